//! The texture of a trace: how to make it again, and how to know that it is the same.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use crate::{
    error::{Error, Result},
    pyramid::PlaneImage,
    scene::{Pattern, Procedural, Texture, TextureSource},
    texture_file::{self, TextureImage},
};

/// Longest side of a computed texture, cell or line: that of scenes.
const LONGEST: u32 = 8192;

/// What the head of a trace says about the texture: a pattern with all its numbers, or a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct TracedTexture {
    /// What a computed texture shows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pattern: Option<Pattern>,
    /// An image file; a relative path starts at the folder of the trace.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Width and height, texels.
    pub size: [u32; 2],
    /// See [`Procedural::cell`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cell: Option<u32>,
    /// See [`Procedural::line`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<u32>,
    /// See [`Procedural::seed`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u32>,
    /// [`digest`] of its texels.
    #[serde(with = "hexadecimal")]
    pub digest: u64,
}

impl TracedTexture {
    /// For a texture of a scene, as it was read, in a trace that lies in `folder`.
    ///
    /// # Errors
    /// A file that is there no more.
    pub fn new(texture: &Texture, read: &TextureImage, folder: &Path) -> Result<Self> {
        let plain = Self {
            pattern: None,
            file: None,
            size: [read.top.width, read.top.height],
            cell: None,
            line: None,
            seed: None,
            digest: digest(read),
        };
        match &texture.source {
            TextureSource::Procedural(Procedural { pattern, cell, line, seed, .. }) => {
                Ok(Self { pattern: Some(*pattern), cell: Some(*cell), line: Some(*line), seed: Some(*seed), ..plain })
            }
            TextureSource::File { path, .. } => {
                let whole = |path: &Path| path.canonicalize().map_err(Error::io(path));
                let file = whole(path)?;
                let folder = whole(if folder.as_os_str().is_empty() { Path::new(".") } else { folder })?;
                let below = file.strip_prefix(&folder).map(Path::to_path_buf);
                Ok(Self { file: Some(below.unwrap_or(file)), ..plain })
            }
        }
    }

    /// Where the texels come from, before any are made.
    ///
    /// # Errors
    /// The key at fault and a sentence about it.
    pub fn check(&self) -> Result<(), (&'static str, String)> {
        let procedural = [("cell", self.cell), ("line", self.line), ("seed", self.seed)];
        match (&self.pattern, &self.file) {
            (Some(_), None) => {
                if let Some((key, _)) = procedural.iter().find(|(_, value)| value.is_none()) {
                    return Err((key, "is missing: a pattern needs it".into()));
                }
            }
            (None, Some(_)) => {
                if let Some((key, _)) = procedural.iter().find(|(_, value)| value.is_some()) {
                    return Err((key, "stands beside `file`: it is for patterns only".into()));
                }
                return Ok(());
            }
            (Some(_), Some(_)) => return Err(("file", "stands beside `pattern`: a texture is one of the two".into())),
            (None, None) => return Err(("size", "has neither `pattern` nor `file` beside it".into())),
        }
        let ranges = [("size", Some(self.size[0])), ("size", Some(self.size[1])), procedural[0], procedural[1]];
        match ranges.into_iter().find(|(_, value)| value.is_some_and(|value| !(1..=LONGEST).contains(&value))) {
            Some((key, value)) => {
                Err((key, format!("has {} in it: out of range, 1 to {LONGEST}", value.unwrap_or_default())))
            }
            None => Ok(()),
        }
    }

    /// The texels. `trace` is the file this was read from.
    ///
    /// # Errors
    /// A file that cannot be read; a texture that is not the one recorded.
    pub fn load(&self, trace: &Path) -> Result<TextureImage> {
        let wrong = |key: &str, problem: String| {
            let remedy =
                "the trace holds for the texture it was recorded with: put that back, or record the trace again";
            Error::file(trace, format!("key texture.{key}"), problem, remedy)
        };
        self.check().map_err(|(key, problem)| wrong(key, problem))?;
        let (texture, what) = match (self.pattern, &self.file) {
            (Some(pattern), _) => {
                let number = |value: Option<u32>| value.unwrap_or_default();
                let [cell, line, seed] = [self.cell, self.line, self.seed].map(number);
                let image = Procedural { pattern, size: self.size, cell, line, seed }.image();
                (PlaneImage::of_image(&image).into(), "the computed texture".to_owned())
            }
            (None, file) => {
                let file = file.clone().unwrap_or_default();
                let found = trace.parent().unwrap_or(Path::new("")).join(file);
                let texture = texture_file::load(&found)
                    .map_err(|error| wrong("file", error.to_string().replace("\n  help: ", "; ")))?;
                (texture, found.display().to_string())
            }
        };
        let PlaneImage { width: found_width, height: found_height, .. } = texture.top;
        if [found_width, found_height] != self.size {
            let [width, height] = self.size;
            let problem = format!("{width} x {height} were recorded, and {what} has {found_width} x {found_height}");
            return Err(wrong("size", problem));
        }
        let found = digest(&texture);
        if found != self.digest {
            return Err(wrong("digest", format!("{:016x} was recorded, and {what} has {found:016x}", self.digest)));
        }
        Ok(texture)
    }
}

/// FNV-1a, 64 bits, over the texels: red, green, blue, alpha, row after row from the top; then over the elements of each level that
/// its file brought.
///
/// ```
/// use texunit::{pyramid::PlaneImage, trace::digest};
/// assert_eq!(digest(&PlaneImage::top(1, 1, vec![*b"foob"]).into()), 0xDD12_0E79_0C25_12AF);
/// ```
#[must_use]
pub fn digest(texture: &TextureImage) -> u64 {
    let levels = texture.own.iter().flat_map(|own| &own.planes).map(|plane| plane.elements.as_slice());
    std::iter::once(texture.top.texels.as_flattened())
        .chain(levels)
        .flatten()
        .fold(0xCBF2_9CE4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3))
}

/// Sixteen hexadecimal digits in a string: TOML has no unsigned 64 bits.
mod hexadecimal {
    use super::{Deserialize, Deserializer, Serializer, de};

    pub fn serialize<S: Serializer>(value: &u64, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&format!("{value:016x}"))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u64, D::Error> {
        let text = String::deserialize(deserializer)?;
        let digits = text.len() == 16 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
        Some(&text)
            .filter(|_| digits)
            .and_then(|text| u64::from_str_radix(text, 16).ok())
            .ok_or_else(|| de::Error::custom(format!("`{text}` is not 16 hexadecimal digits")))
    }
}
