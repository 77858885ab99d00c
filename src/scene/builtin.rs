//! The scenes that come with the program: embedded, so that they run from any folder.

use std::path::Path;

use super::Scene;
use crate::error::{Error, Result};

macro_rules! builtin {
    ($($name:literal),+ $(,)?) => {
        [$(($name, include_str!(concat!("../../scenes/", $name, ".toml")))),+]
    };
}

/// Name and text of every built-in scene, in the order they are run.
const BUILTIN: [(&str, &str); 12] = builtin![
    "rectangle-checkerboard",
    "rectangle-pane",
    "rectangle-natural",
    "ellipsoid-checkerboard",
    "ellipsoid-pane",
    "ellipsoid-natural",
    "floor",
    "magnified",
    "one-to-one",
    "one-axis",
    "mixed",
    "walk",
];

impl Scene {
    /// The names of the built-in scenes, in the order they are run.
    pub fn builtin_names() -> impl Iterator<Item = &'static str> {
        BUILTIN.into_iter().map(|(name, _)| name)
    }

    /// The TOML text of a built-in scene.
    ///
    /// # Errors
    /// [`Error::Setting`] if there is none of that name.
    pub fn builtin_source(name: &str) -> Result<&'static str> {
        BUILTIN.into_iter().find(|(known, _)| *known == name).map(|(_, source)| source).ok_or_else(|| {
            let names = Self::builtin_names().collect::<Vec<_>>().join(", ");
            Error::setting("scene", name, "no built-in scene has this name", format!("one of {names}; or a .toml file"))
        })
    }

    /// A built-in scene.
    ///
    /// # Errors
    /// [`Error::Setting`] if there is none of that name.
    pub fn builtin(name: &str) -> Result<Self> {
        Self::parse(Path::new(&format!("scenes/{name}.toml")), Self::builtin_source(name)?)
    }

    /// All built-in scenes, in the order they are run.
    ///
    /// # Errors
    /// None, unless the program was built with a broken scene.
    pub fn builtins() -> Result<Vec<Self>> {
        Self::builtin_names().map(Self::builtin).collect()
    }

    /// What a user means by a scene: a built-in name, or the path of a TOML file.
    ///
    /// # Errors
    /// As [`Scene::builtin`] and [`Scene::load`].
    pub fn find(name_or_path: &str) -> Result<Self> {
        let path = Path::new(name_or_path);
        let is_path = path.extension().is_some() || path.components().count() > 1;
        if is_path { Self::load(path) } else { Self::builtin(name_or_path) }
    }
}
