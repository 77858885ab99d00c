//! From a sweep file to its points.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
    sync::Arc,
};

use serde::Deserialize;
use serde_json::{Value, json};
use texunit_hw::{Filter, Geometry};

use super::{Measure, Measured, measure};
use crate::{
    annotated,
    error::{Error, Result},
    experiment::Stage,
    machine::Machine,
    names::{Named, by_name},
    scene::{Scene, TextureSource},
    schema::Schema,
};

/// Most points of a sweep: a longer list is a typing error.
const POINTS_MAX: usize = 1_000_000;

/// Most machines, scenes in sizes, or caches that are crossed: a list of a hundred lines could otherwise ask for all the memory there is.
const CROSSED_MAX: usize = 1 << 16;

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct SweepFile {
    #[serde(default)]
    #[allow(dead_code, reason = "reading it is all there is to it")]
    schema: Schema,
    name: String,
    #[serde(default)]
    description: String,
    #[serde(default = "default_machine")]
    machine: String,
    #[serde(default)]
    measure: Measure,
    scenes: Vec<String>,
    filters: Vec<FilterName>,
    #[serde(default)]
    sizes: Vec<[u32; 2]>,
    #[serde(default)]
    set: toml::Table,
}

#[derive(Deserialize)]
#[serde(transparent)]
struct FilterName(#[serde(with = "by_name")] Filter);

fn default_machine() -> String {
    "herf-12.20".into()
}

/// A scene of one size: what points share.
#[derive(Clone, Debug)]
pub struct StageChoice {
    /// The scene, in that size.
    pub scene: Scene,
}

/// One point of a sweep.
#[derive(Clone, Debug)]
pub struct Point {
    /// Its number, from 0, by which it can be run alone.
    pub number: usize,
    /// Which stage.
    pub stage: usize,
    /// Which filter.
    pub filter: Filter,
    /// The swept keys with their values here, as on a command line.
    pub settings: Arc<[(String, String)]>,
    /// The machine that makes.
    pub machine: Arc<Machine>,
}

impl Point {
    /// Points of which this is the same have one ground truth.
    #[must_use]
    pub fn stage_key(&self) -> (usize, bool) {
        (self.stage, self.machine.texture.srgb)
    }
}

/// A sweep, expanded.
#[derive(Clone, Debug)]
pub struct Plan {
    /// What it is called.
    pub name: String,
    /// What it is about.
    pub description: String,
    /// How much is measured.
    pub measure: Measure,
    /// The scenes in their sizes.
    pub stages: Vec<StageChoice>,
    /// The caches of every point, by sets and ways; the line is the machine's.
    pub caches: Vec<[u32; 2]>,
    /// The keys that are crossed, those of the caches apart.
    pub keys: Vec<String>,
    /// All points, by stage first.
    pub points: Vec<Point>,
}

/// Keys and the values each takes, as on a command line.
type Axes = Vec<(String, Vec<String>)>;

/// The lists within a table, with dotted keys.
fn flatten(prefix: &str, table: &toml::Table, axes: &mut Axes) {
    for (key, value) in table {
        let path = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
        match value {
            toml::Value::Table(inner) => flatten(&path, inner, axes),
            toml::Value::Array(values) => axes.push((path, values.iter().map(toml::Value::to_string).collect())),
            value => axes.push((path, vec![value.to_string()])),
        }
    }
}

/// Every combination of one value of each axis, the last axis fastest.
fn crossed(axes: &Axes) -> Vec<Vec<(String, String)>> {
    axes.iter().fold(vec![vec![]], |rows, (key, values)| {
        rows.iter()
            .flat_map(|row| values.iter().map(|value| [row.as_slice(), &[(key.clone(), value.clone())]].concat()))
            .collect()
    })
}

impl Plan {
    /// Reads and expands a sweep file. Paths of scenes and of the machine in it are relative to its folder.
    ///
    /// # Errors
    /// [`Error::Io`], or what is wrong in it, with its place.
    pub fn load(path: &Path) -> Result<Self> {
        Self::parse(path, &crate::text_file::read(path)?)
    }

    /// The same from the text of a file; `path` is for messages, and the folder of what it names.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn parse(path: &Path, source: &str) -> Result<Self> {
        let remedy = "docs/sweeps.md lists the keys; sweeps/cache-size.toml is an example";
        let file: SweepFile =
            toml::from_str(source).map_err(|found| annotated::toml_error(path, source, &found, remedy))?;
        Self::expand(file, path)
    }

    fn expand(file: SweepFile, path: &Path) -> Result<Self> {
        let refused = |place: &str, problem: String, remedy: &str| Error::file(path, place, problem, remedy);
        let folder = path.parent().unwrap_or(Path::new(""));
        let found = |name: &str| -> String {
            let relative: PathBuf = folder.join(name);
            if relative.is_file() { relative.display().to_string() } else { name.to_owned() }
        };
        if file.scenes.is_empty() || file.filters.is_empty() {
            return Err(refused("scenes, filters", "a list is empty".into(), "name at least one scene and one filter"));
        }
        let mut axes = Axes::new();
        flatten("", &file.set, &mut axes);
        if let Some((key, _)) = axes.iter().find(|(_, values)| values.is_empty()) {
            return Err(refused(&format!("set.{key}"), "the list is empty".into(), "give it at least one value"));
        }
        let base = Machine::load(&found(&file.machine), &[])?;
        let numbers = |key: &str, default: u32| -> Result<Vec<u32>> {
            let Some((_, values)) = axes.iter().find(|(known, _)| known == key) else { return Ok(vec![default]) };
            let parsed = values.iter().map(|value| value.parse::<u32>().ok().filter(|&number| number > 0));
            parsed.collect::<Option<_>>().ok_or_else(|| {
                refused(&format!("set.{key}"), format!("[{}]", values.join(", ")), "give whole numbers from 1")
            })
        };
        let (sets, ways) = (numbers("cache.sets", base.cache.sets)?, numbers("cache.ways", base.cache.ways)?);
        let crossed_count = |place: &str, lists: &[usize], most: usize| -> Result<usize> {
            let product = lists
                .iter()
                .try_fold(1_usize, |product, &count| product.checked_mul(count))
                .filter(|&product| product <= most);
            product.ok_or_else(|| refused(place, format!("more than {most} combinations"), "cross fewer values"))
        };
        crossed_count("set.cache", &[sets.len(), ways.len()], CROSSED_MAX)?;
        let caches: Vec<[u32; 2]> = sets.iter().flat_map(|&sets| ways.iter().map(move |&ways| [sets, ways])).collect();
        axes.retain(|(key, _)| key != "cache.sets" && key != "cache.ways");

        let rows = crossed_count("set", &axes.iter().map(|(_, values)| values.len()).collect::<Vec<_>>(), CROSSED_MAX)?;
        let places = [file.scenes.len(), file.sizes.len().max(1)];
        let of_row = crossed_count("scenes, sizes", &places, CROSSED_MAX)?;
        crossed_count("set, scenes, sizes, filters", &[rows, of_row, file.filters.len()], POINTS_MAX)?;

        let mut stages = Vec::new();
        for name in &file.scenes {
            let scene = Scene::find(&found(name))?;
            let sizes = if file.sizes.is_empty() { vec![scene.size] } else { file.sizes.clone() };
            for size in sizes {
                if size.iter().any(|side| !(1..=16384).contains(side)) {
                    return Err(refused("sizes", format!("{size:?}"), "each side may be 1 to 16384 pixels"));
                }
                stages.push(StageChoice { scene: Scene { size, ..scene.clone() } });
            }
        }
        let mut points = Vec::new();
        for settings in crossed(&axes) {
            let given: Vec<String> = settings.iter().map(|(key, value)| format!("{key}={value}")).collect();
            let (settings, machine) = (Arc::<[_]>::from(settings), Arc::new(base.with_settings(&given)?));
            for (stage, _) in stages.iter().enumerate() {
                for FilterName(filter) in &file.filters {
                    let (settings, machine) = (Arc::clone(&settings), Arc::clone(&machine));
                    points.push(Point { number: 0, stage, filter: *filter, settings, machine });
                }
            }
        }
        // Points of a stage together: its ground truth is then made once.
        points.sort_by_key(Point::stage_key);
        for (number, point) in points.iter_mut().enumerate() {
            point.number = number;
        }
        let plan = Self {
            name: file.name,
            description: file.description,
            measure: file.measure,
            stages,
            caches,
            keys: axes.into_iter().map(|(key, _)| key).collect(),
            points,
        };
        let lines: BTreeSet<u32> = plan.points.iter().map(|point| point.machine.cache.line).collect();
        for line in lines {
            for &[sets, ways] in &plan.caches {
                Geometry { sets, ways, line }.check().map_err(|error| {
                    Error::file(path, "set.cache", error.to_string(), "for instance cache.sets = [32, 64]")
                })?;
            }
        }
        Ok(plan)
    }

    /// The caches of a point.
    #[must_use]
    pub fn geometries(&self, point: &Point) -> Vec<Geometry> {
        self.caches.iter().map(|&[sets, ways]| Geometry { sets, ways, line: point.machine.cache.line }).collect()
    }

    /// Everything the result of a point depends on: a result is good as long as this is the same.
    #[must_use]
    pub fn config(&self, point: &Point) -> Value {
        let scene = &self.stages[point.stage].scene;
        let mut config = json!({
            "texunit": env!("CARGO_PKG_VERSION"),
            "measure": self.measure,
            "filter": point.filter.name(),
            "scene": scene,
            "machine": *point.machine,
            "caches": self.caches,
        });
        if let TextureSource::File { image, .. } = &scene.texture.source {
            config["texture"] = format!("{:016x}", fnv1a(image.as_raw())).into();
        }
        config
    }

    /// Makes the stage of some points, if they need one.
    #[must_use]
    pub fn stage(&self, point: &Point) -> Option<Stage> {
        let scene = || self.stages[point.stage].scene.clone();
        (self.measure != Measure::Traffic).then(|| Stage::in_light(scene(), point.machine.texture.srgb))
    }

    /// Measures a point.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn measure(&self, point: &Point, stage: Option<&Stage>) -> Result<Measured> {
        let geometries = self.geometries(point);
        match stage {
            Some(stage) => measure::on_stage(stage, &point.machine, point.filter, &geometries, self.measure),
            None => measure::traffic(&self.stages[point.stage].scene, &point.machine, point.filter, &geometries),
        }
    }
}

/// Fowler, Noll & Vo: enough to notice that a texture is another one.
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xCBF2_9CE4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01B3))
}
