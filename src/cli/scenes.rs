//! `texunit scenes`: what there is to run.

use std::{path::PathBuf, process::ExitCode};

use comfy_table::Table;

use crate::{
    error::{Error, Result},
    output::{print, write_whole},
    report::table::plain,
    scene::Scene,
};

/// List the built-in scenes; show one as TOML, or write its texture
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Print the TOML of a built-in scene: a start for one's own.
    #[arg(long, value_name = "NAME", conflicts_with = "texture")]
    show: Option<String>,
    /// Write the texture of a scene (a built-in name or a TOML file) as PNG.
    #[arg(long, value_name = "SCENE", requires = "output")]
    texture: Option<String>,
    /// Where to write the texture.
    #[arg(short, long, value_name = "FILE", requires = "texture")]
    output: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// An unknown scene, or a file that cannot be written.
pub fn run(args: Args) -> Result<ExitCode> {
    match (args.show, args.texture.zip(args.output)) {
        (Some(name), _) => {
            let source = Scene::builtin_source(&name)?;
            print(|out| out.write_all(source.as_bytes()))?;
        }
        (None, Some((name, path))) => {
            let image = Scene::find(&name)?.texture.image();
            write_whole(&path, |file| {
                let encoder = image::codecs::png::PngEncoder::new(file);
                image.write_with_encoder(encoder).map_err(std::io::Error::other)
            })?;
        }
        (None, None) => {
            let list = list()?;
            print(|out| writeln!(out, "{list}"))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn list() -> Result<Table, Error> {
    let mut table = plain(["scene", "size", "texture", "covered pixels", "description"], 1..=3);
    for name in Scene::builtin_names() {
        let scene = Scene::builtin(name)?;
        let [width, height] = scene.size;
        let [texture_width, texture_height] = scene.texture.size();
        table.add_row([
            scene.name.clone(),
            format!("{width} x {height}"),
            format!("{texture_width} x {texture_height}"),
            scene.coverage().covered.to_string(),
            scene.description,
        ]);
    }
    Ok(table)
}
