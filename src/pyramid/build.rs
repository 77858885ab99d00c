//! From a texture to its planes: exact integer sums along both axes and one rounding (docs/numerics.md, section 8).

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use texunit_hw::{AddressMode, PyramidKind};

use super::{PlaneImage, Pyramid, axis::AxisTaps, box_sums, halved, kernel::Kernel, planes_of};
use crate::{error::Result, names::by_name};

/// Which plane a plane is made from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum From {
    /// The texture itself: rounded once, and the kernel grows with the level (Blow 2001).
    #[default]
    Top,
    /// The next larger plane: the usual recursion, rounded and clamped once per level.
    Above,
}

/// How the exact sum of a texel becomes 8 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PlaneRounding {
    /// To nearest, ties to even: no drift.
    #[default]
    HalfEven,
    /// To nearest, ties up: drifts by +1/8 of a step a level (E16).
    HalfUp,
    /// Down, as in Flavell's and Blow's listings: drifts by -3/8 of a step a level (E16).
    Truncate,
}

/// How planes are made.
///
/// ```
/// use texunit::pyramid::{Build, PlaneImage};
/// use texunit_hw::PyramidKind;
///
/// let texture = PlaneImage::top(2, 1, vec![[0, 0, 0, 255], [255, 0, 0, 255]]);
/// let pyramid = Build::default().pyramid(PyramidKind::Mipmap, &texture)?;
/// assert_eq!(pyramid.plane(1, 0).unwrap().texels, [[128, 0, 0, 255]]);
/// # Ok::<(), texunit::error::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Build {
    /// What is averaged with which weights.
    #[serde(with = "by_name")]
    pub kernel: Kernel,
    /// Kernel width in source texels at 2:1, even, 2 to 64; `None` for the kernel's own ([`Kernel::default_width`]).
    pub width: Option<u8>,
    /// Which plane is the source.
    #[serde(with = "by_name")]
    pub from: From,
    /// The one rounding.
    #[serde(with = "by_name")]
    pub rounding: PlaneRounding,
    /// What a kernel finds outside the texture: should be what the sampler will find there.
    #[serde(with = "by_name")]
    pub edge: AddressMode,
}

impl Build {
    /// All planes of a pyramid over `top`.
    ///
    /// # Errors
    /// A width the kernel cannot have.
    pub fn pyramid(&self, kind: PyramidKind, top: &PlaneImage) -> Result<Pyramid> {
        let planes = self.planes(top, &planes_of(kind, top.width, top.height), |_| ())?;
        Ok(Pyramid { kind, width: top.width, height: top.height, planes })
    }

    /// The pyramid with the texels of those planes only of which `needed(lu, lv)` is true: bit for bit those of [`Build::pyramid`].
    /// Only they are computed, and with [`From::Above`] those they come from.
    ///
    /// # Errors
    /// A width the kernel cannot have.
    pub fn needed_planes(
        &self,
        kind: PyramidKind,
        top: &PlaneImage,
        needed: impl Fn(u8, u8) -> bool,
    ) -> Result<Pyramid> {
        let all = planes_of(kind, top.width, top.height);
        let mut list: Vec<(u8, u8)> = all.iter().copied().filter(|&(lu, lv)| needed(lu, lv)).collect();
        if self.from == From::Above {
            // A source comes earlier in storage order, so one pass from the end finds the sources of sources.
            for number in (0..all.len()).rev().filter(|&number| all[number] != (0, 0)) {
                if list.contains(&all[number])
                    && let Some(source) = nearest_above(all[..number].iter().copied(), all[number])
                    && !list.contains(&source)
                {
                    list.push(source);
                }
            }
            list.sort_by_key(|plane| all.iter().position(|known| known == plane));
        }
        let mut made = self.planes(top, &list, |_| ())?;
        let planes = all.into_iter().map(|(lu, lv)| {
            let place = made.iter().position(|plane| (plane.lu, plane.lv) == (lu, lv) && needed(lu, lv));
            place.map_or_else(
                || {
                    let (width, height) = (halved(top.width, lu), halved(top.height, lv));
                    PlaneImage { lu, lv, width, height, texels: Vec::new() }
                },
                |place| made.swap_remove(place),
            )
        });
        let planes = planes.collect();
        Ok(Pyramid { kind, width: top.width, height: top.height, planes })
    }

    /// The planes of `list`, in its order; `made` is called after each plane that took its own pass over a source.
    ///
    /// With [`From::Above`] a plane comes from the largest-numbered plane *earlier in the list* that is at least as large on
    /// both axes (the texture always is), so a list with planes left out gives other texels than the whole one.
    ///
    /// # Errors
    /// A width the kernel cannot have.
    pub fn planes(&self, top: &PlaneImage, list: &[(u8, u8)], mut made: impl FnMut(usize)) -> Result<Vec<PlaneImage>> {
        let width = self.kernel.width(self.width)?;
        let both_powers_of_two = top.width.is_power_of_two() && top.height.is_power_of_two();
        if self.kernel == Kernel::Box && self.from == From::Top && both_powers_of_two {
            return Ok(box_sums::planes(top, list, self.rounding));
        }
        let limit_colour = is_premultiplied(&top.texels);
        let mut planes: Vec<PlaneImage> = Vec::with_capacity(list.len());
        for (number, &(lu, lv)) in list.iter().enumerate() {
            let source = match self.from {
                From::Top => top,
                From::Above => nearest_above(planes.iter().map(|plane| (plane.lu, plane.lv)), (lu, lv))
                    .and_then(|(lu, lv)| planes.iter().find(|plane| (plane.lu, plane.lv) == (lu, lv)))
                    .unwrap_or(top),
            };
            let axis = |from, to| AxisTaps::new(self.kernel, width, self.edge, from, to);
            let (wide, high) = (halved(top.width, lu), halved(top.height, lv));
            let texels = if (wide, high) == (source.width, source.height) {
                source.texels.clone()
            } else {
                let (u, v) = (axis(source.width, wide), axis(source.height, high));
                resample(source, &u, &v, self.rounding, limit_colour)
            };
            planes.push(PlaneImage { lu, lv, width: wide, height: high, texels });
            made(number);
        }
        Ok(planes)
    }
}

/// Fraction bits of [`Build::unrounded`].
pub const UNROUNDED_BITS: u32 = 24;

impl Build {
    /// The planes of a pyramid before they become 8 bits: every channel clamped to 0..=255, with 24 fraction bits, floored. Made from the
    /// texture whatever [`Build::from`] says, and never limited to alpha: both are ways of rounding.
    ///
    /// ```
    /// use texunit::pyramid::{Build, PlaneImage};
    /// use texunit_hw::PyramidKind;
    ///
    /// let texture = PlaneImage::top(2, 1, vec![[0, 0, 0, 255], [255, 0, 0, 255]]);
    /// let planes = Build::default().unrounded(PyramidKind::Mipmap, &texture)?;
    /// assert_eq!(planes[1][0][0], 255 << 23); // 127.5
    /// # Ok::<(), texunit::error::Error>(())
    /// ```
    ///
    /// # Errors
    /// A width the kernel cannot have.
    pub fn unrounded(&self, kind: PyramidKind, top: &PlaneImage) -> Result<Vec<Vec<[u32; 4]>>> {
        let width = self.kernel.width(self.width)?;
        let plane = |(lu, lv): (u8, u8)| {
            let axis = |from, to| AxisTaps::new(self.kernel, width, self.edge, from, to);
            let (u, v) = (axis(top.width, halved(top.width, lu)), axis(top.height, halved(top.height, lv)));
            let total = i128::from(u.total) * i128::from(v.total);
            let channel = |sum: i64| {
                let value = (i128::from(sum) << UNROUNDED_BITS).div_euclid(total);
                value.clamp(0, 255 << UNROUNDED_BITS) as u32
            };
            sums(top, &u, &v, |sums| sums.map(channel))
        };
        Ok(planes_of(kind, top.width, top.height).into_iter().map(plane).collect())
    }
}

/// The plane with the most halvings that `(lu, lv)` can be halved from; of equals the one that leaves the u axis to halve.
fn nearest_above(planes: impl Iterator<Item = (u8, u8)>, (lu, lv): (u8, u8)) -> Option<(u8, u8)> {
    planes.filter(|plane| plane.0 <= lu && plane.1 <= lv).max_by_key(|plane| (plane.0 + plane.1, plane.1))
}

/// Whether no colour is above its alpha. Then planes keep to that (negative lobes would break it: X17); a texture that
/// itself breaks it has straight alpha, and nothing follows from one about the other.
#[must_use]
pub fn is_premultiplied(texels: &[[u8; 4]]) -> bool {
    texels.par_iter().all(|&[r, g, b, a]| r <= a && g <= a && b <= a)
}

impl PlaneRounding {
    /// Exact sums of four channels over their common total, rounded once and clamped.
    #[must_use]
    pub fn divide(self, sums: [i64; 4], total: i64) -> [u8; 4] {
        let division = Division::new(total, self);
        sums.map(|sum| division.of(sum))
    }
}

/// Divides exact sums by the same number, rounding once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Division {
    divisor: i64,
    shift: Option<u32>,
    rounding: PlaneRounding,
}

impl Division {
    pub(crate) fn new(divisor: i64, rounding: PlaneRounding) -> Self {
        let shift = (divisor as u64).is_power_of_two().then(|| divisor.trailing_zeros());
        Self { divisor, shift, rounding }
    }

    /// The quotient, clamped to 8 bits. Sums below zero floor before they clamp, so no rule sees their sign.
    #[inline(always)]
    pub(crate) fn of(self, sum: i64) -> u8 {
        let floor = match self.shift {
            Some(shift) => sum >> shift,
            None => sum.div_euclid(self.divisor),
        };
        let twice_rest = 2 * (sum - floor * self.divisor);
        let up = match self.rounding {
            PlaneRounding::HalfEven => twice_rest + (floor & 1) > self.divisor,
            PlaneRounding::HalfUp => twice_rest >= self.divisor,
            PlaneRounding::Truncate => false,
        };
        (floor + i64::from(up)).clamp(0, 255) as u8
    }
}

/// One plane from another, rounded.
fn resample(
    source: &PlaneImage,
    u: &AxisTaps,
    v: &AxisTaps,
    rounding: PlaneRounding,
    limit_colour: bool,
) -> Vec<[u8; 4]> {
    let division = Division::new(u.total * v.total, rounding);
    sums(source, u, v, |sums| {
        let texel = sums.map(|sum| division.of(sum));
        if limit_colour { texel.map(|channel| channel.min(texel[3])) } else { texel }
    })
}

/// The exact sums of a plane's texels, each made into a texel: columns summed in 32 bits, rows of those sums in 64.
fn sums<T: Copy + Default + Send>(
    source: &PlaneImage,
    u: &AxisTaps,
    v: &AxisTaps,
    finish: impl Fn([i64; 4]) -> T + Sync,
) -> Vec<T> {
    let row_length = source.width as usize;
    let mut texels = vec![T::default(); u.len() * v.len()];
    texels.par_chunks_mut(u.len()).enumerate().for_each_init(
        || vec![[0i32; 4]; row_length],
        |columns, (j, row)| {
            columns.fill([0; 4]);
            for tap in v.of(j) {
                let begin = tap.texel as usize * row_length;
                let line = source.texels[begin..begin + row_length].as_flattened();
                for (sum, &channel) in columns.as_flattened_mut().iter_mut().zip(line) {
                    *sum += tap.weight * i32::from(channel);
                }
            }
            for (i, texel) in row.iter_mut().enumerate() {
                let mut sums = [0i64; 4];
                for tap in u.of(i) {
                    let column = columns[tap.texel as usize];
                    for (sum, part) in sums.iter_mut().zip(column) {
                        *sum += i64::from(tap.weight) * i64::from(part);
                    }
                }
                *texel = finish(sums);
            }
        },
    );
    texels
}
