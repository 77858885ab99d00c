//! One value for each line ever seen.

use alloc::{collections::BTreeMap, vec::Vec};

/// Numbers below this are looked up directly: a gigabyte of textures in lines of 64 bytes.
const LOW_LINES: u64 = 1 << 24;

/// Gives lines dense numbers in the order of their first appearance. Low line numbers, where texture memory lies, are looked up
/// directly, the rest of the 64-bit space in a tree.
///
/// ```
/// use texunit_hw::sweep::LineTable;
/// let mut table = LineTable::default();
/// assert_eq!([table.number(7), table.number(u64::MAX), table.number(7)], [0, 1, 0]);
/// assert_eq!(table.len(), 2);
/// ```
#[derive(Clone, Debug, Default)]
pub struct LineTable {
    /// Number plus 1; 0 where the line was not seen yet.
    low: Vec<u32>,
    high: BTreeMap<u64, u32>,
    len: u32,
}

impl LineTable {
    /// The number of a line, a new one if it was never seen.
    #[inline]
    pub fn number(&mut self, line: u64) -> u32 {
        let entry = if line < LOW_LINES {
            if line as usize >= self.low.len() {
                self.low.resize((line as usize + 1).next_power_of_two(), 0);
            }
            &mut self.low[line as usize]
        } else {
            self.high.entry(line).or_default()
        };
        if *entry == 0 {
            self.len += 1;
            *entry = self.len;
        }
        *entry - 1
    }

    /// Lines seen.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.len as usize
    }

    /// Whether none was.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }
}
