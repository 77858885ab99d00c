//! `texunit needs`: what a scene needs, and the smallest machine for it.

use std::{path::PathBuf, process::ExitCode};

use image::RgbaImage;
use serde_json::json;
use texunit_hw::{Filter, LodSource};

use super::scene_args::{SceneArgs, size_up_to};
use crate::{
    error::{Error, Result},
    machine::Machine,
    names::Named,
    needs::{Fit, LazyTexture, Loss, Needs, PixelNeeds, PpmFile, TileMemory, report, requests, requests_of_size},
    output::{print, write_whole},
    scene::{Scene, TextureSource},
};

/// Show what a scene needs of each filter: levels, planes, tiles, address logic, channels, bits
///
/// One pass, in which no texel is read. `texunit run --leave-out` leaves out what is not needed here and says what that saves (docs/leaving-out.md).
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scenes: SceneArgs,
    /// Size of the texture instead of the scene's own, up to 1048576 a side; procedural textures only
    #[arg(long, value_name = "WxH", value_parser = size_up_to::<{ 1 << 20 }>)]
    texture_size: Option<[u32; 2]>,
    /// Propose the smallest cache, FIFO and widths within the loss stated, with what was tried
    #[arg(long)]
    fit: bool,
    /// More clocks that a proposal may cost, for instance 2%
    #[arg(long, value_name = "PERCENT", default_value = "2%", value_parser = percent)]
    loss: f64,
    /// Difference from the picture that a proposal may make, root of the mean square, in steps of an 8-bit channel
    #[arg(long, value_name = "LSB", default_value_t = 0.5)]
    error: f64,
    /// Sample the scene from the tiles it reads, nothing else being computed, into this PNG: one scene, one filter
    #[arg(long, value_name = "FILE")]
    tiles: Option<PathBuf>,
    /// With --tiles: take the texture from this binary PPM file, read piece by piece
    #[arg(long, value_name = "FILE", requires = "tiles")]
    ppm: Option<PathBuf>,
    /// Print JSON instead of tables
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    machine: super::MachineArgs,
}

fn percent(text: &str) -> Result<f64, String> {
    let number: Option<f64> = text.trim_end_matches('%').parse().ok();
    number
        .filter(|percent| (0.0..=1000.0).contains(percent))
        .map(|percent| percent / 100.0)
        .ok_or_else(|| "write a percentage from 0 to 1000, for instance 2%".into())
}

/// Runs the command.
///
/// # Errors
/// Bad scenes or machines, a texture that cannot be had by tiles.
pub fn run(args: &Args) -> Result<ExitCode> {
    let machine = args.machine.load()?;
    let mut scenes = args.scenes.scenes()?;
    let filters = args.scenes.filters();
    for scene in &mut scenes {
        if let Some(size) = args.texture_size {
            let TextureSource::Procedural(texture) = &mut scene.texture.source else {
                let problem = "the scene's texture is a file, which has a size";
                return Err(Error::setting("--texture-size", &scene.name, problem, "leave it out"));
            };
            texture.size = size;
        }
    }
    if let Some(path) = &args.tiles {
        let ([scene], [filter]) = (scenes.as_slice(), filters.as_slice()) else {
            return Err(Error::setting(
                "--tiles",
                path.display(),
                "one picture at a time",
                "name one scene and one filter",
            ));
        };
        return tiles(args, &machine, scene, *filter);
    }
    let mut all = Vec::new();
    for scene in &scenes {
        let pixels = PixelNeeds::of(scene, &machine);
        let image = scene.texture.image_needs();
        let mut rows = Vec::new();
        for &filter in &filters {
            let sampler = machine.sampler(filter, scene.texture.wrap, LodSource::Gradient);
            rows.push((Needs::of(&requests(scene, &machine, filter), &sampler, scene.texture.size())?, sampler));
        }
        let loss = Loss { time: args.loss, rmse: args.error };
        let fits = if args.fit {
            filters.iter().map(|&filter| Fit::find(scene, &machine, filter, loss)).collect::<Result<_>>()?
        } else {
            Vec::new()
        };
        if args.json {
            let filters: Vec<_> = rows.iter().map(|(needs, sampler)| report::needs_json(needs, sampler)).collect();
            let fits: Vec<_> = fits.iter().map(report::fit_json).collect();
            all.push(json!({
                "scene": scene,
                "pixels": pixels.json(),
                "channels": { "opaque": image.opaque, "grey": image.grey, "count": image.channels() },
                "filters": filters,
                "fits": fits,
            }));
            continue;
        }
        print(|out| {
            writeln!(out, "\n{}: {}", scene.name, scene.description)?;
            let [width, height] = scene.texture.size();
            writeln!(out, "{} pixels, a texture of {width} x {height}", pixels.pixels)?;
            writeln!(out, "{}\n{}", report::pixels_text(&pixels, image), report::needs_table(&rows))?;
            for fit in &fits {
                let settings = if fit.settings.is_empty() { "as it is".into() } else { fit.settings.join(" ") };
                writeln!(
                    out,
                    "\n{} with at most {:.1} % more clocks and {} LSB RMSE: {settings}\n{}",
                    fit.filter.name(),
                    100.0 * fit.loss.time,
                    fit.loss.rmse,
                    report::fit_table(fit)
                )?;
            }
            Ok(())
        })?;
    }
    if args.json {
        let value = json!({ "schema": 1, "texunit": env!("CARGO_PKG_VERSION"), "machine": machine, "scenes": all });
        print(|out| writeln!(out, "{value:#}"))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The picture of one filter from the tiles it reads.
fn tiles(args: &Args, machine: &Machine, scene: &Scene, filter: Filter) -> Result<ExitCode> {
    match (&args.ppm, &scene.texture.source) {
        (Some(path), _) => tiles_of(args, machine, scene, filter, &PpmFile::open(path)?),
        (None, TextureSource::Procedural(texture)) => tiles_of(args, machine, scene, filter, texture),
        (None, TextureSource::File { .. }) => {
            tiles_of(args, machine, scene, filter, &scene.texture.texture_image().top)
        }
    }
}

fn tiles_of(
    args: &Args,
    machine: &Machine,
    scene: &Scene,
    filter: Filter,
    texture: &impl LazyTexture,
) -> Result<ExitCode> {
    let size = texture.size();
    let sampler = machine.sampler(filter, scene.texture.wrap, LodSource::Gradient);
    let requests = requests_of_size(scene, machine, filter, size);
    let needs = Needs::of(&requests, &sampler, size)?;
    let memory = TileMemory::new(&needs, &machine.texture.pyramid, texture)?;
    let responses = memory.run(&sampler, size, &requests)?;
    let mut picture = RgbaImage::new(scene.size[0], scene.size[1]);
    for (request, response) in requests.iter().zip(&responses) {
        let [x, y] = request.pixel.map(u32::from);
        picture.put_pixel(x, y, image::Rgba(response.texel));
    }
    if let Some(path) = &args.tiles {
        let mut bytes = std::io::Cursor::new(Vec::new());
        picture
            .write_to(&mut bytes, image::ImageFormat::Png)
            .map_err(|error| Error::file(path, "the image", error.to_string(), "report this"))?;
        write_whole(path, |file| file.write_all(bytes.get_ref()))?;
    }
    let [read, all] = needs.tiles();
    let whole: u64 = needs.planes.iter().map(|plane| 4 * u64::from(plane.size[0]) * u64::from(plane.size[1])).sum();
    let mebibytes = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    print(|out| {
        writeln!(
            out,
            "{}: {read} of {all} tiles, {:.1} MiB with their tables; all planes would take {:.1} MiB",
            scene.name,
            mebibytes(memory.bytes()),
            mebibytes(whole)
        )?;
        writeln!(
            out,
            "{:.2} MiB of texels and sums at most while tiles were made",
            mebibytes(36 * memory.source_texels)
        )
    })?;
    Ok(ExitCode::SUCCESS)
}
