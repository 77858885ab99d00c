//! Scenes as TOML files: the keys, their defaults and their ranges.

use std::{
    fmt::Display,
    ops::{Range, RangeInclusive},
    path::{Path, PathBuf},
};

use serde::Deserialize;
use texunit_hw::AddressMode;
use toml::Spanned;

use super::{
    Camera, Ellipsoid, GradientMethod, MOST_SAMPLES, MatrixStepping, Pattern, PixelOrder, Pose, Procedural, Rectangle,
    Rotation, Scene, Shape, Supersampling, Texture, TextureSource,
};
use crate::{
    annotated,
    error::{Error, Result},
    names::by_name_per_axis,
    schema::Schema,
};

/// Said with every error that a look at a good scene would mend.
const SEE_EXAMPLE: &str = "`texunit scenes --show floor` prints a scene with its keys";

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct SceneFile {
    #[serde(default)]
    #[allow(dead_code, reason = "reading it is all there is to it")]
    schema: Schema,
    name: String,
    description: String,
    width: Option<Spanned<i64>>,
    height: Option<Spanned<i64>>,
    #[serde(default)]
    order: PixelOrder,
    tile: Option<Spanned<i64>>,
    #[serde(default)]
    gradient: GradientMethod,
    #[serde(default)]
    camera: CameraFile,
    rectangle: Option<Spanned<RectangleFile>>,
    ellipsoid: Option<Spanned<EllipsoidFile>>,
    path: Option<PathFile>,
    texture: Spanned<TextureFile>,
    #[serde(default)]
    ground_truth: SupersamplingFile,
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct CameraFile {
    field_of_view: Option<Spanned<f64>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct RectangleFile {
    size: [Spanned<f64>; 2],
    rotation: Option<Spanned<Rotation>>,
    translation: [Spanned<f64>; 3],
    repeats: Option<[Spanned<f64>; 2]>,
    #[serde(default)]
    extends: bool,
    #[serde(default)]
    matrix_stepping: MatrixStepping,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct EllipsoidFile {
    radii: [Spanned<f64>; 3],
    rotation: Option<Spanned<Rotation>>,
    translation: [Spanned<f64>; 3],
    repeats: Option<[Spanned<f64>; 2]>,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct PathFile {
    frames: Spanned<i64>,
    rotation: Option<Spanned<Rotation>>,
    translation: [Spanned<f64>; 3],
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct TextureFile {
    pattern: Option<Spanned<Pattern>>,
    file: Option<Spanned<PathBuf>>,
    size: Option<Spanned<[Spanned<i64>; 2]>>,
    cell: Option<Spanned<i64>>,
    line: Option<Spanned<i64>>,
    seed: Option<Spanned<i64>>,
    #[serde(default, with = "by_name_per_axis")]
    wrap: [AddressMode; 2],
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct SupersamplingFile {
    samples: Option<Spanned<i64>>,
    #[serde(default)]
    jitter: bool,
}

impl Scene {
    /// Reads a scene. The path of its texture, if it has one, is relative to the folder of the scene.
    ///
    /// # Errors
    /// [`Error::Io`] if the file cannot be read; otherwise [`Error::Rendered`], showing the line at fault: not TOML, an unknown
    /// key, a value out of range, a texture that cannot be read or has no texels.
    pub fn load(path: &Path) -> Result<Self> {
        let source = crate::text_file::read(path)?;
        Self::parse(path, &source)
    }

    /// A scene from the text of its file; `path` is for messages and as the base of the texture's path.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn parse(path: &Path, source: &str) -> Result<Self> {
        let file: SceneFile =
            toml::from_str(source).map_err(|found| annotated::toml_error(path, source, &found, SEE_EXAMPLE))?;
        Reader { path, source }.scene(file)
    }
}

/// Checks values against their ranges, and shows them in place when they are wrong.
struct Reader<'a> {
    path: &'a Path,
    source: &'a str,
}

impl Reader<'_> {
    fn error(&self, span: Range<usize>, problem: String, label: &str, remedy: String) -> Error {
        annotated::error(self.path, self.source, span, problem, label, remedy)
    }

    fn in_range<T: Copy + PartialOrd + Display>(
        &self,
        key: &str,
        value: &Spanned<T>,
        range: &RangeInclusive<T>,
    ) -> Result<T> {
        let number = *value.get_ref();
        if range.contains(&number) {
            return Ok(number);
        }
        let remedy = format!("give `{key}` a value from {} to {}", range.start(), range.end());
        Err(self.error(value.span(), format!("`{key}` is {number}"), "out of range", remedy))
    }

    fn count(&self, key: &str, value: Option<&Spanned<i64>>, default: u32, range: RangeInclusive<i64>) -> Result<u32> {
        let Some(value) = value else { return Ok(default) };
        let number = self.in_range(key, value, &range)?;
        Ok(u32::try_from(number).expect("every range lies within u32"))
    }

    fn numbers<const N: usize>(
        &self,
        key: &str,
        values: &[Spanned<f64>; N],
        range: &RangeInclusive<f64>,
    ) -> Result<[f64; N]> {
        let mut numbers = [0.0; N];
        for (number, value) in numbers.iter_mut().zip(values) {
            *number = self.in_range(key, value, range)?;
        }
        Ok(numbers)
    }

    fn scene(&self, file: SceneFile) -> Result<Scene> {
        let size = [
            self.count("width", file.width.as_ref(), 640, 1..=16384)?,
            self.count("height", file.height.as_ref(), 480, 1..=16384)?,
        ];
        let field_of_view = match &file.camera.field_of_view {
            Some(angle) => self.in_range("field-of-view", angle, &(1.0..=170.0))?,
            None => 45.0,
        };
        let samples = self.count("samples", file.ground_truth.samples.as_ref(), 8, 1..=i64::from(MOST_SAMPLES))?;
        let shape = match (&file.rectangle, &file.ellipsoid) {
            (Some(rectangle), None) => Shape::Rectangle(self.rectangle(rectangle.get_ref())?),
            (None, Some(ellipsoid)) => Shape::Ellipsoid(self.ellipsoid(ellipsoid.get_ref())?),
            (None, None) => {
                let remedy = "add a table [rectangle] or [ellipsoid]".to_owned();
                return Err(self.error(0..0, "the scene has no shape".to_owned(), "in this file", remedy));
            }
            (Some(_), Some(second)) => {
                let remedy = "keep one of [rectangle] and [ellipsoid]".to_owned();
                return Err(self.error(second.span(), "the scene has two shapes".to_owned(), "the second", remedy));
            }
        };
        Ok(Scene {
            name: file.name,
            description: file.description,
            size,
            order: file.order,
            tile: self.count("tile", file.tile.as_ref(), 8, 1..=4096)?,
            gradient: file.gradient,
            camera: Camera { field_of_view },
            shape,
            path: file.path.as_ref().map(|path| self.path_through(path)).transpose()?,
            texture: self.texture(&file.texture)?,
            ground_truth: Supersampling { samples, jitter: file.ground_truth.jitter },
        })
    }

    fn pose(&self, rotation: Option<&Spanned<Rotation>>, translation: &[Spanned<f64>; 3]) -> Result<Pose> {
        let translation = self.numbers("translation", translation, &(-1e6..=1e6))?;
        let Some(spanned) = rotation else { return Ok(Pose { rotation: Rotation::default(), translation }) };
        let rotation = *spanned.get_ref();
        let finite = match rotation {
            Rotation::Euler(degrees) => degrees.into_iter().all(f64::is_finite),
            Rotation::About { axis, angle } => {
                if axis.into_iter().all(|component| component == 0.0) {
                    let remedy = "give it a direction, such as [0, 1, 0]".to_owned();
                    let problem = "the axis of `rotation` has no length".to_owned();
                    return Err(self.error(spanned.span(), problem, "turns about nothing", remedy));
                }
                axis.into_iter().chain([angle]).all(f64::is_finite)
            }
        };
        if !finite {
            let remedy = "give angles in degrees, such as { euler = [-60, 0, 30] }".to_owned();
            let problem = "`rotation` is not finite".to_owned();
            return Err(self.error(spanned.span(), problem, "inf or nan in here", remedy));
        }
        Ok(Pose { rotation, translation })
    }

    fn path_through(&self, file: &PathFile) -> Result<super::Path> {
        let frames = self.count("frames", Some(&file.frames), 0, 2..=10_000)?;
        Ok(super::Path { frames, end: self.pose(file.rotation.as_ref(), &file.translation)? })
    }

    fn repeats(&self, repeats: Option<&[Spanned<f64>; 2]>) -> Result<[f64; 2]> {
        repeats.map_or(Ok([1.0; 2]), |repeats| self.numbers("repeats", repeats, &(1e-6..=65536.0)))
    }

    fn rectangle(&self, file: &RectangleFile) -> Result<Rectangle> {
        Ok(Rectangle {
            size: self.numbers("size", &file.size, &(1e-6..=1e6))?,
            pose: self.pose(file.rotation.as_ref(), &file.translation)?,
            repeats: self.repeats(file.repeats.as_ref())?,
            extends: file.extends,
            matrix_stepping: file.matrix_stepping,
        })
    }

    fn ellipsoid(&self, file: &EllipsoidFile) -> Result<Ellipsoid> {
        Ok(Ellipsoid {
            radii: self.numbers("radii", &file.radii, &(1e-6..=1e6))?,
            pose: self.pose(file.rotation.as_ref(), &file.translation)?,
            repeats: self.repeats(file.repeats.as_ref())?,
        })
    }

    fn texture(&self, spanned: &Spanned<TextureFile>) -> Result<Texture> {
        let file = spanned.get_ref();
        let source = match (&file.pattern, &file.file) {
            (Some(pattern), None) => TextureSource::Procedural(self.procedural(*pattern.get_ref(), file)?),
            (None, Some(path)) => self.texture_file(path, file)?,
            (pattern, _) => {
                let problem = if pattern.is_some() { "two sources" } else { "no source" };
                let problem = format!("the texture has {problem}");
                let remedy = "give either `pattern` (checkerboard, pane, natural) or `file`".to_owned();
                return Err(self.error(spanned.span(), problem, "in this table", remedy));
            }
        };
        Ok(Texture { source, wrap: file.wrap })
    }

    fn procedural(&self, pattern: Pattern, file: &TextureFile) -> Result<Procedural> {
        let mut size = [512; 2];
        if let Some(given) = &file.size {
            for (axis, value) in size.iter_mut().zip(given.get_ref()) {
                *axis = self.count("size", Some(value), 0, 1..=8192)?;
            }
        }
        let (default_cell, default_line) = match pattern {
            Pattern::Checkerboard => (16, 1),
            Pattern::Pane => (64, 4),
            Pattern::Natural => (128, 1),
        };
        Ok(Procedural {
            pattern,
            size,
            cell: self.count("cell", file.cell.as_ref(), default_cell, 1..=8192)?,
            line: self.count("line", file.line.as_ref(), default_line, 1..=8192)?,
            seed: self.count("seed", file.seed.as_ref(), 1, 0..=0x7FFF_FFFF)?,
        })
    }

    fn texture_file(&self, path: &Spanned<PathBuf>, file: &TextureFile) -> Result<TextureSource> {
        let procedural_only = [
            ("size", file.size.as_ref().map(Spanned::span)),
            ("cell", file.cell.as_ref().map(Spanned::span)),
            ("line", file.line.as_ref().map(Spanned::span)),
            ("seed", file.seed.as_ref().map(Spanned::span)),
        ];
        if let Some((key, Some(span))) = procedural_only.into_iter().find(|(_, span)| span.is_some()) {
            let remedy = format!("leave `{key}` out: the file says it all");
            return Err(self.error(span, format!("`{key}` is for procedural textures"), "of no use here", remedy));
        }
        let found = self.path.parent().unwrap_or(Path::new("")).join(path.get_ref());
        TextureSource::read(found.clone()).map_err(|problem| {
            let problem = problem.to_string().replace("\n  help: ", "; ");
            let remedy = format!("the path is relative to the scene file: {} must be an image", found.display());
            self.error(path.span(), problem, "this texture", remedy)
        })
    }
}
