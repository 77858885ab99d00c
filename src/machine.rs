//! The machine: every knob an architect turns, as one TOML file, with `--set section.key=value` on top.

use std::{ops::Range, path::Path};

use serde::{Deserialize, Serialize};
use texunit_hw::{
    AddressMode, Filter, Format, Geometry, Layout, LevelRounding, LodSource, Log2, Policy, Rounding, Sampler,
};

use crate::{
    annotated,
    energy::EnergyTable,
    error::{Error, Result},
    lod_rules::polygon::LevelPer,
    names::{Named, by_name},
    pyramid::Build,
    scene::{AxisRule, Norm},
    schema::Schema,
    text_file,
    texture_memory::Decompress,
    timing_settings::{self, MemorySettings, TimingSettings},
};

/// A machine, complete: what is not said in a file has the value of the default machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct Machine {
    /// What the file was written for.
    #[serde(skip_serializing)]
    pub schema: Schema,
    /// What it is called in reports.
    pub name: String,
    /// What it is, and where its numbers come from.
    pub description: String,
    /// The LOD unit and what is handed to it.
    pub lod: Lod,
    /// Widths and roundings of the filter.
    pub filter: FilterWidths,
    /// How textures are made and stored.
    pub texture: Texture,
    /// The texel cache.
    pub cache: CacheShape,
    /// The pipeline in time.
    pub timing: TimingSettings,
    /// What answers misses.
    pub memory: MemorySettings,
    /// Picojoules of everything that happens.
    pub energy: EnergyTable,
}

/// See docs/numerics.md, section 4.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct Lod {
    /// The log2 unit.
    #[serde(with = "by_name")]
    pub log2: Log2,
    /// Bits of the level fraction, 0 to 8.
    pub bits: u8,
    /// Levels added before the clamp, -16 to 16, in steps of 1/256.
    pub bias: f64,
    /// Smallest level.
    pub min: f64,
    /// Largest level.
    pub max: f64,
    /// How filters of one whole level round.
    #[serde(with = "by_name")]
    pub rounding: LevelRounding,
    /// Which measure of the footprint selects the level.
    #[serde(with = "by_name")]
    pub norm: Norm,
    /// Which measure goes to which axis of a Dipmap.
    #[serde(with = "by_name")]
    pub dipmap_rule: AxisRule,
    /// Whether each pixel has a level or the whole shape.
    pub per: LevelPer,
}

/// See docs/numerics.md, sections 3 and 6.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct FilterWidths {
    /// Bits of the bilinear fraction, 1 to 12.
    pub bits: u8,
    /// Where the datapath rounds.
    #[serde(with = "by_name")]
    pub rounding: Rounding,
    /// Most probes of an anisotropic filter a level, 1 to 64.
    pub max_anisotropy: u8,
    /// Brilinear takes one level where the fraction is this close to it, in 1/256 level, 0 to 127.
    pub brilinear_threshold: u8,
}

/// See docs/layouts.md and docs/numerics.md, sections 8 and 10.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct Texture {
    /// How texels are arranged.
    #[serde(with = "crate::names::layout")]
    pub layout: Layout,
    /// What a texel is stored as.
    #[serde(with = "by_name")]
    pub format: Format,
    /// Where it becomes RGBA8: behind the cache or before it.
    pub decompress: Decompress,
    /// Whether colours are sRGB codes, made linear before they are filtered.
    pub srgb: bool,
    /// How the planes are made.
    pub pyramid: Build,
}

/// The texel cache.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct CacheShape {
    /// Sets, any number.
    pub sets: u32,
    /// Ways of a set, any number.
    pub ways: u32,
    /// Bytes of a line, a power of two.
    pub line: u32,
    /// lru, fifo, plru or random.
    pub policy: String,
    /// Seed of the random policy.
    pub seed: u64,
}

impl Default for Lod {
    fn default() -> Self {
        Self {
            log2: Log2::Exact,
            bits: 8,
            bias: 0.0,
            min: 0.0,
            max: 32.0,
            rounding: LevelRounding::Nearest,
            norm: Norm::default(),
            dipmap_rule: AxisRule::default(),
            per: LevelPer::default(),
        }
    }
}

impl Default for FilterWidths {
    fn default() -> Self {
        Self { bits: 8, rounding: Rounding::Once, max_anisotropy: 16, brilinear_threshold: 64 }
    }
}

impl Default for CacheShape {
    /// 16 KiB in 4 ways of 64-byte lines, each one 4 x 4 tile of RGBA8.
    fn default() -> Self {
        Self { sets: 64, ways: 4, line: 64, policy: "lru".into(), seed: 0 }
    }
}

impl CacheShape {
    /// Sets, ways and line.
    #[must_use]
    pub const fn geometry(&self) -> Geometry {
        Geometry { sets: self.sets, ways: self.ways, line: self.line }
    }

    /// The replacement policy of a name.
    ///
    /// # Errors
    /// A sentence that lists the names.
    pub fn policy(&self) -> Result<Policy, String> {
        policy_from_name(&self.policy, self.seed)
    }
}

/// The replacement policy of a name: lru, fifo, plru, random.
///
/// # Errors
/// A sentence that lists the names.
pub fn policy_from_name(name: &str, seed: u64) -> Result<Policy, String> {
    match name {
        "lru" => Ok(Policy::Lru),
        "fifo" => Ok(Policy::Fifo),
        "plru" => Ok(Policy::Plru),
        "random" => Ok(Policy::Random { seed }),
        _ => Err(format!("no policy is named `{name}`: use lru, fifo, plru, random")),
    }
}

/// Said with every error that a look at a whole machine would mend.
const SEE_EXPLAIN: &str =
    "`texunit explain` lists every key with its value; if a newer texunit wrote this, update texunit";

/// Where the value of a dotted key stands in a TOML text.
fn value_span(source: &str, key: &str) -> Option<Range<usize>> {
    let table = toml::de::DeTable::parse(source).ok()?;
    let mut inner = table.get_ref();
    let mut keys = key.split('.').peekable();
    loop {
        let key = keys.next()?;
        let (_, value) = inner.iter().find(|(name, _)| name.get_ref() == key)?;
        match (keys.peek(), value.get_ref()) {
            (None, _) => return Some(value.span()),
            (Some(_), toml::de::DeValue::Table(below)) => inner = below,
            (Some(_), _) => return None,
        }
    }
}

/// The machines that ship with texunit, with their files.
pub const PROFILES: &[(&str, &str)] = &[
    ("herf-12.20", include_str!("../hw/profiles/herf-12.20.toml")),
    ("hakura-1997", include_str!("../hw/profiles/hakura-1997.toml")),
    ("igehy-1998", include_str!("../hw/profiles/igehy-1998.toml")),
    ("milkymist", include_str!("../hw/profiles/milkymist.toml")),
    ("vortex", include_str!("../hw/profiles/vortex.toml")),
    ("mobile", include_str!("../hw/profiles/mobile.toml")),
    ("desktop", include_str!("../hw/profiles/desktop.toml")),
];

impl Machine {
    /// The machine of a shipped name or of a TOML file, with settings on top.
    ///
    /// # Errors
    /// An unknown name or unreadable file, an unknown key, a value out of range: each with what would be right.
    pub fn load(profile: &str, settings: &[String]) -> Result<Self> {
        let text = match PROFILES.iter().find(|(name, _)| *name == profile) {
            Some((_, text)) => (*text).to_owned(),
            None if Path::new(profile).exists() => text_file::read(Path::new(profile))?,
            None => {
                let names: Vec<_> = PROFILES.iter().map(|(name, _)| *name).collect();
                let remedy = format!("name a TOML file, or one of {}", names.join(", "));
                return Err(Error::setting("machine", profile, "neither a machine that ships nor a file", remedy));
            }
        };
        Self::parse(Path::new(profile), &text)?.with_settings(settings)
    }

    /// A machine from the text of its file; `path` is for messages.
    ///
    /// # Errors
    /// An unknown key or a value out of range, shown in its line.
    pub fn parse(path: &Path, source: &str) -> Result<Self> {
        let machine: Self =
            toml::from_str(source).map_err(|found| annotated::toml_error(path, source, &found, SEE_EXPLAIN))?;
        machine.check().map_err(|error| match error {
            Error::Setting { key, value, problem, remedy } => {
                let span = value_span(source, &key).unwrap_or(0..0);
                annotated::error(path, source, span, format!("`{key}` is {value}"), problem, remedy)
            }
            other => other,
        })?;
        Ok(machine)
    }

    /// The same machine with settings on top, each `section.key=value`, as `--set` takes them.
    ///
    /// # Errors
    /// An unknown key or a value out of range.
    pub fn with_settings(&self, settings: &[String]) -> Result<Self> {
        let machine = settings.iter().try_fold(self.clone(), |machine, setting| machine.set(setting))?;
        machine.check()?;
        Ok(machine)
    }

    /// One `section.key=value` on top.
    fn set(&self, setting: &str) -> Result<Self> {
        let bad = |problem: String| Error::setting("--set", setting, problem, SEE_EXPLAIN);
        let (path, value) = setting
            .split_once('=')
            .ok_or_else(|| bad("no `=` in it: write section.key=value, for instance cache.ways=8".into()))?;
        // A bare word is a string: nobody wants to quote twice on a command line.
        let value: toml::Value = toml::from_str::<toml::Table>(&format!("value = {value}"))
            .ok()
            .and_then(|mut table| table.remove("value"))
            .unwrap_or_else(|| toml::Value::String(value.into()));
        let mut table = toml::Table::try_from(self).map_err(|error| bad(error.to_string()))?;
        let mut keys = path.split('.').peekable();
        let mut place = &mut table;
        while let Some(key) = keys.next() {
            if keys.peek().is_none() {
                // An integer is welcome where a number is meant. A key that is not there may be one without a default value.
                let value = match (place.get(key), value.as_integer()) {
                    (Some(toml::Value::Float(_)), Some(integer)) => toml::Value::Float(integer as f64),
                    _ => value.clone(),
                };
                place.insert(key.to_owned(), value);
                break;
            }
            let known = place.keys().cloned().collect::<Vec<_>>().join(", ");
            let Some(entry) = place.get_mut(key) else {
                return Err(bad(format!("there is no section `{key}` here, only {known}")));
            };
            place = match entry {
                toml::Value::Table(inner) => inner,
                _ => return Err(bad(format!("`{key}` is a value, not a section"))),
            };
        }
        table.try_into().map_err(|error: toml::de::Error| bad(error.message().to_owned()))
    }

    /// Refuses what no unit can be built for.
    ///
    /// # Errors
    /// The key at fault, its value, and the values that would do.
    pub fn check(&self) -> Result<()> {
        let levels = [
            ("lod.bias", self.lod.bias, -16.0, 16.0),
            ("lod.min", self.lod.min, 0.0, 32.0),
            ("lod.max", self.lod.max, 0.0, 32.0),
        ];
        for (key, value, low, high) in levels {
            if !(low..=high).contains(&value) {
                return Err(Error::setting(key, value, "out of range", format!("use {low} to {high} levels")));
            }
        }
        let sampler = self.sampler(Filter::Trilinear, [AddressMode::Wrap; 2], LodSource::Gradient);
        if let Err(error) = sampler.check() {
            let key = match error.key {
                "filter_bits" => "filter.bits".to_owned(),
                "max_anisotropy" => "filter.max-anisotropy".to_owned(),
                "brilinear_threshold" => "filter.brilinear-threshold".to_owned(),
                key => key.replace("lod_", "lod."),
            };
            let (low, high) = error.range;
            return Err(Error::setting(key, error.value, "out of range", format!("use {low} to {high}")));
        }
        self.cache.policy().map_err(|_| {
            Error::setting("cache.policy", &self.cache.policy, "no such policy", "use lru, fifo, plru or random")
        })?;
        self.cache.geometry().check().map_err(|error| {
            Error::setting(format!("cache.{}", error.key), error.value, error.problem, error.remedy)
        })?;
        let build = &self.texture.pyramid;
        build.kernel.width(build.width)?;
        // Blocks need banks as wide as they are, which a timed run asks for; a run that is not timed has no banks.
        let bytes = self.texture.format.element_bytes().min(Format::Rgba8.element_bytes());
        timing_settings::check(&self.timing, &self.memory, self.cache.line, bytes)?;
        self.energy.check()
    }

    /// The sampler this machine runs a filter with.
    #[must_use]
    pub fn sampler(&self, filter: Filter, address: [AddressMode; 2], lod_source: LodSource) -> Sampler {
        Sampler {
            filter,
            address,
            filter_bits: self.filter.bits,
            lod_bits: self.lod.bits,
            rounding: self.filter.rounding,
            max_anisotropy: self.filter.max_anisotropy,
            brilinear_threshold: self.filter.brilinear_threshold,
            lod_source,
            log2: self.lod.log2,
            level_rounding: self.lod.rounding,
            bias: to_level(self.lod.bias) as i16,
            min_lod: to_level(self.lod.min),
            max_lod: to_level(self.lod.max),
            skip_empty_taps: false,
        }
    }
}

/// The nearest 8.8 level, half up; NaN is the coarsest there can be, as in the LOD unit.
#[must_use]
pub fn to_level(level: f64) -> i32 {
    if level.is_nan() { 64 << 8 } else { (level * 256.0 + 0.5).floor().clamp(-16384.0, 16384.0) as i32 }
}

/// For `clap`: a parser of any [`Named`] choice.
pub fn parser<T: Named + Send + Sync>() -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync {
    |name: &str| T::from_name(name)
}
