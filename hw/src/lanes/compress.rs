//! Lanes of a set moved to the front, four lanes at a time: what AVX-512 has an instruction for.

/// For each set of four lanes of `WORDS / 4` words each, where the words come from: those of the set first.
pub(super) const fn order<const WORDS: usize>() -> [[u32; WORDS]; 16] {
    let words = WORDS / 4;
    let mut order = [[0; WORDS]; 16];
    let mut set = 0;
    while set < 16 {
        let (mut from, mut to) = (0, 0);
        while from < WORDS {
            if set >> (from / words) & 1 != 0 {
                order[set][to] = from as u32;
                to += 1;
            }
            from += 1;
        }
        set += 1;
    }
    order
}

/// How many lanes are in each set of four.
pub(super) const KEPT: [u8; 16] = [0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4];
