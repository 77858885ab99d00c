//! The summed-area table (docs/numerics.md, section 5.3; Crow 1984), without the table: every row of the box is added up.
//!
//! Box sums are whole numbers in u64, so nothing here can wrap around, and no rule about table entries is needed. A texel that
//! counts several times, because the box repeats the texture, is multiplied. Each row has its running total, of one row only, and
//! so has each column.

use std::ops::Range;

use texunit_hw::{AddressMode, Request, Response, Sampler};

use super::{
    checked,
    coordinate::{anywhere, floor},
    ideal::{FURTHEST, defined},
    planes::Plane,
    turns,
};
use crate::{error::Result, pyramid::Pyramid};

/// The widest box there is: 4096 x 4096 texels of 255 stay below 2^32.
const WIDEST: f64 = 4096.0;

/// The float model of a summed-area table.
///
/// ```
/// use texunit::{pyramid::{PlaneImage, Pyramid}, reference::sat::Sat};
/// use texunit_hw::{I12F20, PyramidKind, Request, Sampler};
/// let texels = [10, 20, 30, 41].map(|grey| [grey; 4]).to_vec();
/// let pyramid =
///     Pyramid { kind: PyramidKind::Mipmap, width: 4, height: 1, planes: vec![PlaneImage::top(4, 1, texels)] };
/// let sat = Sat::new(&pyramid, &Sampler::default())?;
/// // Half the texture around u = 0.75: texels 2 and 3, 71 / 2, half up.
/// let half = [I12F20::from_num(0.5), I12F20::ZERO];
/// let request = Request { axes: [half, [I12F20::ZERO; 2]], ..Request::at(I12F20::from_num(0.75), I12F20::ZERO) };
/// assert_eq!(sat.sample(&request).texel, [36; 4]);
/// # Ok::<(), texunit::error::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Sat<'a> {
    plane: Plane<'a>,
    address: [AddressMode; 2],
    /// Of each row, one more than texels: the sum of all texels before. A row of 2^20 texels of 255 stays below 2^32.
    along: Vec<[u32; 4]>,
    /// The same of each column.
    down: Vec<[u32; 4]>,
}

impl<'a> Sat<'a> {
    /// A unit that reads level 0 of `pyramid` with the address modes of `sampler`.
    ///
    /// # Errors
    /// A setting out of range, or a pyramid without a level 0.
    pub fn new(pyramid: &'a Pyramid, sampler: &Sampler) -> Result<Self> {
        checked(sampler)?;
        Self::unlimited(pyramid, sampler.address)
    }

    /// The same without widths to check, for [`Self::ideal`].
    pub(super) fn unlimited(pyramid: &'a Pyramid, address: [AddressMode; 2]) -> Result<Self> {
        let plane = Plane::find(pyramid, 0, 0)?;
        let [columns, rows] = plane.size.map(|size| size as usize);
        let along = totals(rows, columns, |j, i| plane.texel(Some(i), Some(j)));
        let down = totals(columns, rows, |i, j| plane.texel(Some(i), Some(j)));
        Ok(Self { plane, address, along, down })
    }

    /// The answer to one request.
    #[must_use]
    pub fn sample(&self, request: &Request) -> Response {
        let at = [turns(request.u), turns(request.v)];
        let axes = request.axes.map(|axis| axis.map(turns));
        let boxes = [0, 1].map(|axis| {
            let size = self.plane.size[axis];
            let width = floor(extent(axes, axis) * size + 0.5).clamp(1.0, WIDEST);
            let first = floor(at[axis] * size - width / 2.0 + 0.5);
            (first, width)
        });
        let [columns, rows] = [0, 1].map(|axis| {
            let (first, width) = boxes[axis];
            self.shares((0..width as u32).map(|step| (first + f64::from(step), 1)), axis)
        });
        let sums = self.sums(&columns, &rows, |total, times: u64| times * total);
        let area = (boxes[0].1 * boxes[1].1) as u64;
        Response { texel: sums.map(|sum| ((2 * sum + area) / (2 * area)) as u8), lod: [0; 2] }
    }

    /// The average over the box itself, with its edges between texels: red, green, blue, alpha, each 0.0 to 255.0. `at` is
    /// normalised (u, v), `axes` the two steps (du, dv) of a pixel. A box is a texel wide at least (and so interpolates as
    /// bilinear does), and 4096 at most.
    #[must_use]
    pub fn ideal(&self, at: [f64; 2], axes: [[f64; 2]; 2]) -> [f64; 4] {
        let axes = axes.map(|axis| axis.map(|c| if c.is_nan() { 0.0 } else { c.clamp(-FURTHEST, FURTHEST) }));
        let boxes = [0, 1].map(|axis| {
            let size = self.plane.size[axis];
            let width = (extent(axes, axis) * size).clamp(1.0, WIDEST);
            (defined(at[axis], self.address[axis]) * size - width / 2.0, width)
        });
        let [columns, rows] = [0, 1].map(|axis| {
            let (from, width) = boxes[axis];
            let texels = (floor(from + width) - floor(from)) as u32;
            let overlap = move |texel: f64| (from + width).min(texel + 1.0) - from.max(texel);
            let indices = (0..=texels).map(move |step| floor(from) + f64::from(step));
            self.shares(indices.map(|texel| (texel, overlap(texel) / width)), axis)
        });
        self.sums(&columns, &rows, |total, share: f64| share * total as f64)
    }

    /// How much of the box falls on the texels of an axis: runs of texels by equal share, where they begin and end. What falls
    /// outside is on none.
    fn shares<T: Number>(&self, indices: impl Iterator<Item = (f64, T)>, axis: usize) -> Vec<(usize, usize, T)> {
        let texel = |index| anywhere(index, self.plane.size[axis], self.address[axis]);
        let of_box: Vec<(f64, T)> = indices.collect();
        let [first, last] = [of_box.first(), of_box.last()].map(|end| end.and_then(|(index, _)| texel(*index)));
        // As many texels from the first to the last as there are indices: no edge of the texture lies between them.
        let within = first.zip(last).is_some_and(|(first, last)| last + 1 == first + of_box.len());
        let mut runs: Vec<(usize, usize, T)> = Vec::new();
        let mut add = |texel: usize, share: T| match runs.last_mut() {
            Some((_, end, same)) if *end == texel && *same == share => *end += 1,
            _ => runs.push((texel, texel + 1, share)),
        };
        if within {
            (first.unwrap_or(0)..).zip(&of_box).for_each(|(texel, (_, share))| add(texel, *share));
        } else {
            // Shares of one texel are added in the order they come in; room is made for the texels from the first touched to the last.
            let of_box = of_box.into_iter().filter_map(|(index, share)| Some((texel(index)?, share)));
            let of_box: Vec<(usize, T)> = of_box.collect();
            let texels = || of_box.iter().map(|(texel, _)| *texel);
            let (first, last) = (texels().min().unwrap_or(0), texels().max().unwrap_or(0));
            let mut of_texels = vec![T::default(); last - first + 1];
            of_box.iter().for_each(|(texel, share)| of_texels[texel - first] += *share);
            let some = (first..).zip(of_texels).filter(|(_, share)| *share != T::default());
            some.for_each(|(texel, share)| add(texel, share));
        }
        runs
    }

    /// Texels by the shares of their columns and rows: those of equal share are added up first, row by row.
    fn sums<T: Number>(
        &self,
        columns: &[(usize, usize, T)],
        rows: &[(usize, usize, T)],
        product: impl Fn(u64, T) -> T,
    ) -> [T; 4] {
        let mut sums = [T::default(); 4];
        for &(top, bottom, down) in rows {
            for &(begin, end, across) in columns {
                // Few long rows or few long columns.
                let equal = if bottom - top <= end - begin {
                    sum_of_lines(&self.along, self.plane.size[0], top..bottom, begin..end)
                } else {
                    sum_of_lines(&self.down, self.plane.size[1], begin..end, top..bottom)
                };
                for (sum, equal) in sums.iter_mut().zip(equal) {
                    *sum += product(equal, across * down);
                }
            }
        }
        sums
    }
}

/// Running totals of lines of texels, one more than texels in each: the sum of all before.
fn totals(lines: usize, texels: usize, texel: impl Fn(usize, usize) -> [u8; 4]) -> Vec<[u32; 4]> {
    let mut totals = Vec::with_capacity((texels + 1) * lines);
    for line in 0..lines {
        let mut total = [0; 4];
        totals.push(total);
        for at in 0..texels {
            let texel = texel(line, at);
            total = [0, 1, 2, 3].map(|channel| total[channel] + u32::from(texel[channel]));
            totals.push(total);
        }
    }
    totals
}

/// The sum of some texels of some lines of `size` texels.
fn sum_of_lines(totals: &[[u32; 4]], size: f64, lines: Range<usize>, texels: Range<usize>) -> [u64; 4] {
    let stride = size as usize + 1;
    let mut sum = [0; 4];
    for line in totals[lines.start * stride..lines.end * stride].chunks_exact(stride) {
        let (before, until) = (line[texels.start], line[texels.end]);
        for (channel, sum) in sum.iter_mut().enumerate() {
            *sum += u64::from(until[channel] - before[channel]);
        }
    }
    sum
}

/// The bounding box of the pixel's parallelogram along one axis, in turns.
fn extent(axes: [[f64; 2]; 2], axis: usize) -> f64 {
    axes[0][axis].abs() + axes[1][axis].abs()
}

/// A count of texels, or a part of one.
trait Number: Copy + Default + PartialEq + std::ops::AddAssign + std::ops::Mul<Output = Self> {}
impl Number for u64 {}
impl Number for f64 {}
