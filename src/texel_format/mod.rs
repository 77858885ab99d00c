//! Texel formats outside the chip: planes into stored elements, and what those elements mean, by other code than the chip's
//! (docs/numerics.md, section 10).

mod bc7_encode;
mod decode;
mod encode;
pub mod palette;
pub mod srgb;

use texunit_hw::{Format, Palette, PyramidKind};

use crate::pyramid::{PlaneImage, Pyramid};

/// One plane as a format stores it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredPlane {
    /// Halvings of the u axis.
    pub lu: u8,
    /// Halvings of the v axis.
    pub lv: u8,
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Texels or blocks row after row, each of [`Format::element_bytes`].
    pub elements: Vec<u8>,
}

/// Planes as a format stores them, in no layout yet.
///
/// ```
/// use texunit::{pyramid::{Build, PlaneImage}, texel_format::Stored};
/// use texunit_hw::{Format, PyramidKind};
/// let texture = PlaneImage::top(1, 1, vec![[200, 100, 50, 255]]);
/// let pyramid = Build::default().pyramid(PyramidKind::Mipmap, &texture)?;
/// let stored = Stored::encode(&pyramid, Format::Rgb565);
/// assert_eq!(stored.planes[0].elements, 0xC326_u16.to_le_bytes());
/// assert_eq!(stored.decode().planes[0].texels, [[198, 101, 49, 255]]);
/// # Ok::<(), texunit::error::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stored {
    /// Which planes.
    pub kind: PyramidKind,
    /// Columns of plane (0, 0).
    pub width: u32,
    /// Rows of plane (0, 0).
    pub height: u32,
    /// What an element is.
    pub format: Format,
    /// The colours of a palette format.
    pub palette: Option<Box<Palette>>,
    /// The planes in storage order.
    pub planes: Vec<StoredPlane>,
}

/// Bytes of a plane's elements.
#[must_use]
pub const fn plane_bytes(format: Format, width: u32, height: u32) -> u64 {
    format.elements(width) as u64 * format.elements(height) as u64 * format.element_bytes() as u64
}

impl Stored {
    /// Every plane in the nearest codes of a format. One palette serves all planes.
    #[must_use]
    pub fn encode(pyramid: &Pyramid, format: Format) -> Self {
        Self::encode_beside(pyramid, format, None)
    }

    /// The same, with planes that come in this format already taken as they are.
    #[must_use]
    pub fn encode_beside(pyramid: &Pyramid, format: Format, given: Option<&Self>) -> Self {
        let given = given.filter(|given| given.format == format);
        let palette = (format == Format::Palette8).then(|| {
            let own = given.and_then(|given| given.palette.clone());
            own.unwrap_or_else(|| Box::new(palette::of_pyramid(pyramid)))
        });
        let encoder = encode::Encoder::new(format, palette.as_deref());
        let planes = pyramid
            .planes
            .iter()
            .map(|plane| {
                // A plane without texels was left out.
                let needed = given.filter(|_| !plane.texels.is_empty());
                let own = needed.and_then(|given| given.plane(plane.lu, plane.lv));
                own.cloned().unwrap_or_else(|| StoredPlane {
                    lu: plane.lu,
                    lv: plane.lv,
                    width: plane.width,
                    height: plane.height,
                    elements: if plane.texels.is_empty() { Vec::new() } else { encoder.plane(plane) },
                })
            })
            .collect();
        Self { kind: pyramid.kind, width: pyramid.width, height: pyramid.height, format, palette, planes }
    }

    /// What the elements mean, colour codes as they are.
    #[must_use]
    pub fn decode(&self) -> Pyramid {
        let planes = self.planes.iter().map(|plane| self.decode_plane(plane)).collect();
        Pyramid { kind: self.kind, width: self.width, height: self.height, planes }
    }

    /// One plane of these as texels.
    #[must_use]
    pub fn decode_plane(&self, plane: &StoredPlane) -> PlaneImage {
        let texels = decode::plane(self.format, self.palette.as_deref(), plane);
        PlaneImage { lu: plane.lu, lv: plane.lv, width: plane.width, height: plane.height, texels }
    }

    /// The plane halved `lu` and `lv` times, if it is there.
    #[must_use]
    pub fn plane(&self, lu: u8, lv: u8) -> Option<&StoredPlane> {
        self.planes.iter().find(|plane| (plane.lu, plane.lv) == (lu, lv))
    }
}
