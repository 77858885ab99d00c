//! Trace files: one vector or item a line, fields in hexadecimal joined by `_`, readable by `$readmemh` (hw/README.md).

use std::fmt;

/// A trace of one unit.
pub struct Trace {
    unit: &'static str,
    /// What is in it, one comment line each.
    notes: Vec<String>,
    fields: Vec<(&'static str, usize)>,
    lines: Vec<Vec<u64>>,
}

impl Trace {
    /// An empty trace; `fields` are names and bits, multiples of 4 up to 64.
    pub fn new(unit: &'static str, notes: &[&str], fields: &[(&'static str, usize)]) -> Self {
        assert!(fields.iter().all(|&(_, bits)| bits % 4 == 0 && bits <= 64));
        Self { unit, notes: notes.iter().map(ToString::to_string).collect(), fields: fields.to_vec(), lines: vec![] }
    }

    /// Adds a line.
    pub fn push(&mut self, line: impl Into<Vec<u64>>) {
        let line = line.into();
        assert_eq!(line.len(), self.fields.len(), "{}: a value a field", self.unit);
        for (&value, (name, bits)) in line.iter().zip(&self.fields) {
            assert!(*bits == 64 || value >> bits == 0, "{}: {name} = {value:x} in {bits} bits", self.unit);
        }
        self.lines.push(line);
    }
}

impl fmt::Display for Trace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "// trace  1")?;
        writeln!(f, "// unit   {}", self.unit)?;
        for note in &self.notes {
            writeln!(f, "// note   {note}")?;
        }
        let fields: Vec<_> = self.fields.iter().map(|(name, bits)| format!("{name}:{bits}")).collect();
        writeln!(f, "// fields {}", fields.join(" "))?;
        writeln!(f, "// count  {}", self.lines.len())?;
        for line in &self.lines {
            let digits: Vec<_> = line
                .iter()
                .zip(&self.fields)
                .map(|(value, (_, bits))| format!("{value:0width$x}", width = bits / 4))
                .collect();
            writeln!(f, "{}", digits.join("_"))?;
        }
        Ok(())
    }
}

/// Splitmix64 (Steele, Lea & Flood 2014): the same numbers on every machine.
pub struct Random(pub u64);

impl Random {
    /// The next 64 bits.
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ mixed >> 31
    }

    /// A number below `end`.
    pub fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }

    /// True once in `n` times.
    pub fn once_in(&mut self, n: u64) -> bool {
        self.below(n) == 0
    }

    /// One of several.
    pub fn pick<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len() as u64) as usize]
    }

    /// `reset, idle, stall` of an item: usually nothing, sometimes some clocks, seldom a reset.
    pub fn pauses(&mut self) -> [u64; 3] {
        let reset = u64::from(self.once_in(150));
        let idle = if self.once_in(6) { self.below(12) } else { 0 };
        let stall = if self.once_in(6) { self.below(14) } else { 0 };
        [reset, idle, stall]
    }
}
