//! One line of a trace: a request, its answer, and what it did to the cache.

use texunit_hw::{I12F20, Request, Response};

/// The fields of a line with their widths in bits, all multiples of 4, in order.
pub const FIELDS: [(&str, u32); 15] = [
    ("u", 32),
    ("v", 32),
    ("scale0", 32),
    ("scale1", 32),
    ("axis0u", 32),
    ("axis0v", 32),
    ("axis1u", 32),
    ("axis1v", 32),
    ("x", 16),
    ("y", 16),
    ("texel", 32),
    ("lod0", 16),
    ("lod1", 16),
    ("reads", 16),
    ("misses", 16),
];

/// A request, its answer, and its reads and misses in a cache that has seen the records before it and nothing else.
///
/// ```
/// use texunit::trace::Record;
/// let line = "00080000_00040000_3f800000_00000000_00000000_00000000_00000000_00000000_0140_00f0_ff8000ff_0000_0000_0008_0002";
/// let record = Record::parse(line).unwrap();
/// assert_eq!(record.response.texel, [255, 128, 0, 255]);
/// assert_eq!((record.reads, record.misses), (8, 2));
/// assert_eq!(record.to_string(), line);
/// assert!(Record::parse(&line[1..]).unwrap_err().contains("u = `0080000`"));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Record {
    /// The request.
    pub request: Request,
    /// The answer.
    pub response: Response,
    /// Reads of memory the request caused: lookups in the cache.
    pub reads: u16,
    /// Those that missed.
    pub misses: u16,
}

impl Record {
    /// The values of [`FIELDS`], signed ones as two's complement, a texel as red, green, blue, alpha from the highest byte down.
    #[must_use]
    pub fn values(&self) -> [u32; FIELDS.len()] {
        let Request { u, v, scale, axes, pixel } = &self.request;
        let bits = |fixed: I12F20| fixed.to_bits().cast_unsigned();
        [
            bits(*u),
            bits(*v),
            scale[0],
            scale[1],
            bits(axes[0][0]),
            bits(axes[0][1]),
            bits(axes[1][0]),
            bits(axes[1][1]),
            pixel[0] as u32,
            pixel[1] as u32,
            u32::from_be_bytes(self.response.texel),
            self.response.lod[0] as u32,
            self.response.lod[1] as u32,
            self.reads as u32,
            self.misses as u32,
        ]
    }

    /// The record of [`Record::values`]; of the 16-bit fields the low half counts.
    #[must_use]
    pub fn of_values(values: [u32; FIELDS.len()]) -> Self {
        let [u, v, scale0, scale1, axis0u, axis0v, axis1u, axis1v, x, y, texel, lod0, lod1, reads, misses] = values;
        let fixed = |bits: u32| I12F20::from_bits(bits.cast_signed());
        Self {
            request: Request {
                u: fixed(u),
                v: fixed(v),
                scale: [scale0, scale1],
                axes: [[fixed(axis0u), fixed(axis0v)], [fixed(axis1u), fixed(axis1v)]],
                pixel: [x as u16, y as u16],
            },
            response: Response { texel: texel.to_be_bytes(), lod: [lod0 as u16, lod1 as u16] },
            reads: reads as u16,
            misses: misses as u16,
        }
    }

    /// The record of a line.
    ///
    /// # Errors
    /// A sentence about the field at fault.
    pub fn parse(line: &str) -> Result<Self, String> {
        let found = line.split('_').count();
        if found != FIELDS.len() {
            return Err(format!("{found} fields where there should be {}", FIELDS.len()));
        }
        let mut values = [0; FIELDS.len()];
        for ((value, (name, width)), text) in values.iter_mut().zip(FIELDS).zip(line.split('_')) {
            let digits = width as usize / 4;
            let whole = text.len() == digits && text.bytes().all(|byte| byte.is_ascii_hexdigit());
            *value = Some(text)
                .filter(|_| whole)
                .and_then(|text| u32::from_str_radix(text, 16).ok())
                .ok_or_else(|| format!("{name} = `{}` is not {digits} hexadecimal digits", shortened(text)))?;
        }
        Ok(Self::of_values(values))
    }
}

/// Enough of a text for a message.
pub(super) fn shortened(text: &str) -> String {
    if text.chars().count() > 40 { text.chars().take(40).chain("...".chars()).collect() } else { text.into() }
}

impl std::fmt::Display for Record {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (number, (value, (_, width))) in self.values().into_iter().zip(FIELDS).enumerate() {
            let digits = width as usize / 4;
            let separator = if number == 0 { "" } else { "_" };
            write!(f, "{separator}{value:0digits$x}")?;
        }
        Ok(())
    }
}
