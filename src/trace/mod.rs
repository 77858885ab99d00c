//! Golden traces: requests with the answers they must get and the misses they cause, as text that a person, Rust, C++ and
//! Verilog's `$readmemh` all read (docs/trace-format.md).

mod memory_image;
mod player;
mod profile;
mod reader;
mod record;
mod recording;
mod texture;
mod verdict;
mod writer;

pub use player::{Player, Totals};
pub use profile::{Profile, WITHOUT_EFFECT};
pub use reader::is_trace;
pub use record::{FIELDS, Record};
pub use recording::{Selection, record};
pub use texture::{TracedTexture, digest};
pub use verdict::{Difference, Party};

/// The version of the format that is written, and the highest that is read.
pub const VERSION: u32 = 1;

/// What the `unit` line says: a trace of one block inside the unit would name that block.
pub const UNIT: &str = "texture-unit";

/// A trace: what was asked of which machine, and what it said.
///
/// ```
/// use texunit::{machine::Machine, scene::Scene, trace::{self, Profile, Selection, Trace}};
/// use texunit_hw::Filter;
/// let scene = Scene::builtin("magnified")?;
/// let machine = Machine::load("herf-12.20", &[])?;
/// let texture = scene.texture.texture_image();
/// let folder = std::path::Path::new(".");
/// let profile = Profile::of_scene(&scene, &texture, &machine, Filter::Bilinear, scene.texture.wrap, folder)?;
/// let trace = trace::record(&scene, &texture, profile, Selection::Count(5), 1)?;
/// let mut text = Vec::new();
/// trace.write(&mut text).unwrap();
/// let again = Trace::parse("magnified.trace", text.as_slice())?;
/// assert_eq!((again.records.len(), &again), (5, &trace));
/// # Ok::<(), texunit::error::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Trace {
    /// Machine, filter and texture.
    pub profile: Profile,
    /// Seed of the choice of requests.
    pub seed: u64,
    /// The version of texunit that recorded it: for people, nothing depends on it.
    pub model: String,
    /// The requests in order, with their answers.
    pub records: Vec<Record>,
    /// The line of the file each record is on, where it was read from one.
    lines: Vec<u64>,
}

impl PartialEq for Trace {
    /// The same requests and answers on the same machine, whoever wrote them on whatever lines.
    fn eq(&self, other: &Self) -> bool {
        self.profile == other.profile && self.seed == other.seed && self.records == other.records
    }
}

impl Trace {
    /// The line of the file a record is on; its number, from 1, if it was not read from a file.
    #[must_use]
    pub fn line(&self, record: usize) -> u64 {
        self.lines.get(record).copied().unwrap_or(record as u64 + 1)
    }
}
