//! The box from the top, for powers of two: sums of sums are exact, so every plane costs what the recursion costs and is
//! rounded once (docs/numerics.md, section 8).
//!
//! Rows stream through one tier per halving of v. A tier adds up two rows of the tier above, halves the sum along u as far
//! as its planes ask, and hands on what all planes below it need. Memory is one row per tier.

use super::{
    PlaneImage,
    build::{Division, PlaneRounding},
    halved,
};

/// A row of exact sums of texels, per channel: 8 + lu + lv bits.
type SumRow = Vec<[u64; 4]>;

/// All rows halved `lv` times.
struct Tier {
    /// Halvings of u that every plane of this tier and of those below has.
    lu: u8,
    /// Planes of this tier by rising `lu`, the texture itself left out: `lu` and place in the list.
    planes: Vec<(u8, usize)>,
    /// Sum of the rows that came in since the last row that went out.
    pending: SumRow,
    /// Rows in `pending`.
    waiting: u8,
}

/// A texel, or a sum of texels.
trait Part: Copy {
    fn channels(self) -> [u64; 4];
}

impl Part for [u8; 4] {
    fn channels(self) -> [u64; 4] {
        self.map(u64::from)
    }
}

impl Part for [u64; 4] {
    fn channels(self) -> [u64; 4] {
        self
    }
}

/// The planes of `list` over a texture whose sides are powers of two.
pub(crate) fn planes(top: &PlaneImage, list: &[(u8, u8)], rounding: PlaneRounding) -> Vec<PlaneImage> {
    let mut planes: Vec<PlaneImage> = list
        .iter()
        .map(|&(lu, lv)| {
            let (width, height) = (halved(top.width, lu), halved(top.height, lv));
            let texels = match (lu, lv) {
                (0, 0) => top.texels.clone(),
                _ => Vec::with_capacity(width as usize * height as usize),
            };
            PlaneImage { lu, lv, width, height, texels }
        })
        .collect();
    let mut tiers = tiers(top.width, list);
    for line in top.texels.chunks_exact(top.width as usize) {
        push(&mut tiers, 0, line, 0, rounding, &mut planes);
    }
    planes
}

fn tiers(width: u32, list: &[(u8, u8)]) -> Vec<Tier> {
    let last = list.iter().map(|&(_, lv)| lv).max().unwrap_or(0);
    (0..=last)
        .map(|tier| {
            let lu = list.iter().filter(|&&(_, lv)| lv >= tier).map(|&(lu, _)| lu).min().unwrap_or(0);
            let numbered = list.iter().enumerate().filter(|&(_, &(lu, lv))| lv == tier && (lu, lv) != (0, 0));
            let mut planes: Vec<(u8, usize)> = numbered.map(|(place, &(lu, _))| (lu, place)).collect();
            planes.sort_unstable();
            Tier { lu, planes, pending: vec![[0; 4]; halved(width, lu) as usize], waiting: 0 }
        })
        .collect()
}

/// A finished row of the tier with `lv` halvings, so far halved `lu` times along u.
fn push<T: Part>(tiers: &mut [Tier], lv: u8, row: &[T], lu: u8, rounding: PlaneRounding, planes: &mut [PlaneImage]) {
    let Some((tier, below)) = tiers.split_first_mut() else { return };
    let mut emit = |row: &[[u64; 4]], place: usize, lu: u8| {
        let division = Division::new(1 << (lu + lv), rounding);
        planes[place].texels.extend(row.iter().map(|sums| sums.map(|sum| division.of(sum as i64))));
    };
    let mut sums: SumRow = Vec::new();
    let mut reached = lu;
    for &(wanted, place) in &tier.planes {
        if sums.is_empty() {
            // From the row as it came: texels are an eighth of the bytes of their sums, and this is the longest row.
            sums = vec![[0; 4]; row.len() >> (wanted - lu)];
            add_halved(&mut sums, row, wanted - lu);
        } else {
            (reached..wanted).for_each(|_| halve(&mut sums));
        }
        reached = wanted;
        emit(&sums, place, wanted);
    }
    let Some(next) = below.first_mut() else { return };
    add_halved(&mut next.pending, row, next.lu - lu);
    next.waiting += 1;
    if next.waiting == 2 {
        let mut complete = std::mem::take(&mut next.pending);
        let lu = next.lu;
        next.waiting = 0;
        push(below, lv + 1, &complete, lu, rounding, planes);
        complete.fill([0; 4]);
        below[0].pending = complete;
    }
}

/// Adds to each of `sums` the run of `2^halvings` of `row` that it covers.
fn add_halved<T: Part>(sums: &mut [[u64; 4]], row: &[T], halvings: u8) {
    for (sum, run) in sums.iter_mut().zip(row.chunks_exact(1 << halvings)) {
        for part in run {
            for (channel, add) in sum.iter_mut().zip(part.channels()) {
                *channel += add;
            }
        }
    }
}

/// Neighbours along u added up in place.
fn halve(row: &mut SumRow) {
    for i in 0..row.len() / 2 {
        let (left, right) = (row[2 * i], row[2 * i + 1]);
        row[i] = std::array::from_fn(|channel| left[channel] + right[channel]);
    }
    row.truncate(row.len() / 2);
}
