//! Whether chip, reference and cache still say what a trace recorded.

use super::{FIELDS, Player, Record, Trace};
use crate::error::Result;

/// Who disagrees with a trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Party {
    /// The chip, or its cache.
    Chip,
    /// The float reference.
    Reference,
}

/// The first place where an answer is not the one recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Who answered.
    pub party: Party,
    /// Line of the file.
    pub line: u64,
    /// The field, one of [`FIELDS`].
    pub field: &'static str,
    /// Its width in bits.
    pub width: u32,
    /// What the trace says.
    pub expected: u32,
    /// What was answered.
    pub got: u32,
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { party, line, field, width, expected, got } = self;
        let who = match party {
            Party::Chip => "the chip",
            Party::Reference => "the reference",
        };
        let digits = *width as usize / 4;
        write!(f, "line {line}: {field}: expected {expected:0digits$x}, {who} gives {got:0digits$x}")
    }
}

impl Trace {
    /// Replays the trace through chip and reference. `None` when both agree with every record, reads and misses included.
    ///
    /// # Errors
    /// A machine that cannot be built.
    pub fn verify(&self, player: &Player) -> Result<Option<Difference>> {
        let requests: Vec<_> = self.records.iter().map(|record| record.request).collect();
        let chip = player.chip(&requests)?;
        // The reference has no cache: it is held to the answers alone.
        let reference: Vec<_> = player
            .reference(&requests)?
            .into_iter()
            .zip(&self.records)
            .map(|(response, record)| Record { response, ..*record })
            .collect();
        Ok((0..self.records.len()).find_map(|number| {
            self.difference(number, Party::Chip, &chip[number])
                .or_else(|| self.difference(number, Party::Reference, &reference[number]))
        }))
    }

    /// How many records differ from other answers to the same requests.
    #[must_use]
    pub fn differing(&self, answers: &[Record]) -> u64 {
        self.records.iter().zip(answers).filter(|(recorded, answer)| recorded != answer).count() as u64
    }

    fn difference(&self, number: usize, party: Party, answer: &Record) -> Option<Difference> {
        let recorded = self.records[number].values().into_iter().zip(answer.values());
        recorded.zip(FIELDS).find(|((expected, got), _)| expected != got).map(|((expected, got), (field, width))| {
            Difference { party, line: self.line(number), field, width, expected, got }
        })
    }
}
