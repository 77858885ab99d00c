//! Which scenes and which filters, for every command that takes several.

use std::path::{Component, Path};

use texunit_hw::{FILTERS, Filter};

use crate::{
    error::{Error, Result},
    machine::parser,
    scene::Scene,
};

/// Which filters.
#[derive(Debug, clap::Args)]
pub(super) struct FilterArgs {
    /// Filters, all if none is given
    #[arg(long, short, visible_alias = "filter", value_delimiter = ',', value_parser = parser::<Filter>())]
    filters: Vec<Filter>,
}

impl FilterArgs {
    /// Those named, or all.
    pub(super) fn filters(&self) -> Vec<Filter> {
        if self.filters.is_empty() { FILTERS.to_vec() } else { self.filters.clone() }
    }
}

/// Which scenes, how large, through which filters.
#[derive(Debug, clap::Args)]
pub(super) struct SceneArgs {
    /// Scenes: names of those that ship or TOML files
    #[arg(value_name = "SCENE", required = true)]
    scenes: Vec<String>,
    #[command(flatten)]
    filters: FilterArgs,
    /// Image size for every scene, instead of its own, for instance 1920x1080
    #[arg(long, value_name = "WxH", value_parser = image_size)]
    size: Option<[u32; 2]>,
}

impl SceneArgs {
    /// The scenes, in the size asked for.
    pub(super) fn scenes(&self) -> Result<Vec<Scene>> {
        scenes(&self.scenes, self.size)
    }

    /// The filters named, or all.
    pub(super) fn filters(&self) -> Vec<Filter> {
        self.filters.filters()
    }
}

/// The size of an image on a command line.
pub(super) fn image_size(text: &str) -> Result<[u32; 2], String> {
    size_up_to::<16384>(text)
}

/// A size on a command line, no side longer than that.
pub(super) fn size_up_to<const MOST: u32>(text: &str) -> Result<[u32; 2], String> {
    text.split_once('x')
        .and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]))
        .filter(|size| size.iter().all(|side| (1..=MOST).contains(side)))
        .ok_or_else(|| format!("write WIDTHxHEIGHT, each 1 to {MOST}, for instance 1920x1080"))
}

/// The scenes of names and files, all that ship if there are none.
pub(super) fn scenes(names: &[String], size: Option<[u32; 2]>) -> Result<Vec<Scene>> {
    let mut scenes: Vec<Scene> = if names.is_empty() {
        Scene::builtins()?
    } else {
        names.iter().map(|name| Scene::find(name)).collect::<Result<_>>()?
    };
    if let Some(size) = size {
        for scene in &mut scenes {
            scene.size = size;
        }
    }
    for (number, Scene { name, .. }) in scenes.iter().enumerate() {
        let wrong = |problem, remedy| Err(Error::setting("scene.name", name, problem, remedy));
        // Each scene has a folder of its name for its images.
        let mut parts = Path::new(name).components();
        if !matches!((parts.next(), parts.next()), (Some(Component::Normal(_)), None)) || name.contains(['/', '\\']) {
            return wrong("not the name of a folder", "name the scene without slashes, for instance my-floor");
        }
        if scenes[..number].iter().any(|other| other.name == *name) {
            return wrong("two scenes have this name", "run each scene once, and give every scene a name of its own");
        }
    }
    Ok(scenes)
}
