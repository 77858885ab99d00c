//! The values of an accessor (3.6.2), checked against their buffer: the crate's own reader panics where they do not fit.

use ::gltf::accessor::{Accessor, DataType, Dimensions};

use super::resources::Resources;
use crate::error::Result;

impl Resources<'_> {
    /// Every element of an accessor of `N` components, of one of the types `allowed`; normalised integers are 0 to 1.
    pub fn values<const N: usize>(&self, accessor: &Accessor<'_>, allowed: &[DataType]) -> Result<Vec<[f64; N]>> {
        let place = format!("accessors[{}]", accessor.index());
        let (kind, shape) = (accessor.data_type(), accessor.dimensions());
        let components = match shape {
            Dimensions::Scalar => 1,
            Dimensions::Vec2 => 2,
            Dimensions::Vec3 => 3,
            Dimensions::Vec4 | Dimensions::Mat2 => 4,
            Dimensions::Mat3 => 9,
            Dimensions::Mat4 => 16,
        };
        if components != N || !allowed.contains(&kind) {
            return Err(self.wrong(&place, format!("{shape:?} of {kind:?} is not what is kept there")));
        }
        let view = match (accessor.view(), accessor.sparse()) {
            (Some(view), None) => view,
            _ => return Err(self.wrong(&place, "sparse accessors are not read".into())),
        };
        let size = kind.size() * N;
        let stride = view.stride().unwrap_or(size);
        // Lengths are any number a file may hold.
        let length = |count: usize| (count - 1).checked_mul(stride)?.checked_add(size);
        let count = accessor.count();
        let length = if count == 0 { Some(0) } else { length(count) };
        let bytes = self.view(&view)?;
        let within = bytes.get(accessor.offset()..).and_then(|bytes| bytes.get(..length?));
        let Some(within) = within.filter(|_| stride >= size) else {
            let problem = format!("{count} elements of {size} bytes, one every {stride}, are not in their buffer view");
            return Err(self.wrong(&place, problem));
        };
        let is_normalized = accessor.normalized();
        let element = |bytes: &[u8]| {
            std::array::from_fn(|component| number(kind, is_normalized, &bytes[component * kind.size()..]))
        };
        Ok(within.chunks(stride).map(element).collect())
    }
}

/// The number that `bytes` begin with; an unsigned integer stands for itself, or a part of the largest.
fn number(kind: DataType, is_normalized: bool, bytes: &[u8]) -> f64 {
    let mut word = [0; 4];
    word[..kind.size()].copy_from_slice(&bytes[..kind.size()]);
    if kind == DataType::F32 {
        return f32::from_le_bytes(word).into();
    }
    let whole = f64::from(u32::from_le_bytes(word));
    if is_normalized { whole / ((1_u64 << (8 * kind.size())) - 1) as f64 } else { whole }
}
