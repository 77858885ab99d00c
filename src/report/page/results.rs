//! What a folder of results holds.

use std::{fs, io::Cursor, path::Path};

use base64::{Engine, engine::general_purpose::STANDARD};
use image::{ImageFormat, ImageReader, codecs::jpeg::JpegEncoder};
use serde_json::Value;

use crate::{
    error::{Error, Result},
    experiment::report::SCHEMA,
};

/// How images go into the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Images {
    /// As they are, exact.
    Png,
    /// As JPEG of high quality, some five times smaller.
    Jpeg,
}

/// A folder's results: of `texunit run`, `pareto`, `reuse`, `frames`, `stress` or `sweep`.
#[derive(Clone, Debug)]
pub struct Results {
    /// Its name.
    pub folder: String,
    /// report.json
    pub run: Option<Value>,
    /// pareto.json
    pub pareto: Option<Value>,
    /// reuse.json
    pub reuse: Option<Value>,
    /// frames.json
    pub frames: Option<Value>,
    /// stress.json
    pub stress: Option<Value>,
    /// sweep.csv: its columns and rows.
    pub sweep: Option<(Vec<String>, Vec<Vec<String>>)>,
    /// Command and machine of the sweep, from its first point.
    pub sweep_point: Option<Value>,
    /// Images by path within the folder, as data addresses.
    pub images: Vec<(String, String)>,
    /// Plots by path within the folder.
    pub plots: Vec<(String, String)>,
}

fn json(path: &Path) -> Result<Option<Value>> {
    if !path.exists() {
        return Ok(None);
    }
    let text = fs::read_to_string(path).map_err(Error::io(path))?;
    let value: Value = serde_json::from_str(&text).map_err(|error| {
        Error::file(
            path,
            format!("line {}", error.line()),
            error.to_string(),
            "write it anew with the command that made it",
        )
    })?;
    if let Some(newer) = value["schema"].as_u64().filter(|schema| *schema > u64::from(SCHEMA)) {
        let problem = format!("schema {newer}, and this texunit reads up to {SCHEMA}");
        return Err(Error::file(path, "schema", problem, "update texunit"));
    }
    Ok(Some(value))
}

impl Results {
    /// Reads a folder.
    ///
    /// # Errors
    /// A file that cannot be read or is damaged, a folder without results.
    pub fn read(folder: &Path, format: Images) -> Result<Self> {
        let at = |name: &str| folder.join(name);
        let mut results = Self {
            folder: folder.display().to_string(),
            run: json(&at("report.json"))?,
            pareto: json(&at("pareto.json"))?,
            reuse: json(&at("reuse.json"))?,
            frames: json(&at("frames.json"))?,
            stress: json(&at("stress.json"))?,
            sweep: None,
            sweep_point: json(&at("point-000000.json"))?,
            images: Vec::new(),
            plots: Vec::new(),
        };
        let sweep = at("sweep.csv");
        if sweep.exists() {
            results.sweep = Some(table(&sweep)?);
        }
        for scene in results.scenes(&results.run) {
            for name in results.image_names(&scene) {
                let path = folder.join(&scene).join(&name);
                if path.exists() {
                    results.images.push((format!("{scene}/{name}"), data_address(&path, format)?));
                }
            }
        }
        for scene in results.scenes(&results.pareto).into_iter().chain(results.scenes(&results.reuse)) {
            let path = at(&format!("{scene}.svg"));
            if path.exists() {
                results.plots.push((scene, fs::read_to_string(&path).map_err(Error::io(&path))?));
            }
        }
        let parts = [&results.run, &results.pareto, &results.reuse, &results.frames, &results.stress];
        if parts.iter().all(|part| part.is_none()) && results.sweep.is_none() {
            let remedy = "give folders written by texunit run, pareto, reuse, frames, stress or sweep";
            return Err(Error::setting("DIR", folder.display(), "no results in it", remedy));
        }
        Ok(results)
    }

    /// Names of the scenes of a part.
    fn scenes(&self, part: &Option<Value>) -> Vec<String> {
        let scenes = part.as_ref().and_then(|part| part["scenes"].as_array());
        scenes.into_iter().flatten().map(scene_name).collect()
    }

    fn image_names(&self, scene: &str) -> Vec<String> {
        let scenes = self.run.as_ref().and_then(|run| run["scenes"].as_array());
        let scene = scenes.into_iter().flatten().find(|known| scene_name(known) == scene);
        let filters = scene.and_then(|scene| scene["filters"].as_array()).into_iter().flatten();
        let of_filter = |filter: &Value| {
            let name = filter["filter"].as_str().unwrap_or_default();
            [format!("{name}.png"), format!("{name}-difference.png")]
        };
        ["truth.png".to_owned()].into_iter().chain(filters.flat_map(of_filter)).collect()
    }

    /// An image of a scene.
    #[must_use]
    pub fn image(&self, scene: &str, name: &str) -> Option<&str> {
        let path = format!("{scene}/{name}");
        self.images.iter().find(|(known, _)| *known == path).map(|(_, data)| data.as_str())
    }
}

/// The name of a scene, which some files hold whole and others by name.
pub(super) fn scene_name(scene: &Value) -> String {
    let name = scene["scene"].as_str().or_else(|| scene["scene"]["name"].as_str());
    name.unwrap_or("scene").to_owned()
}

fn table(path: &Path) -> Result<(Vec<String>, Vec<Vec<String>>)> {
    let damaged =
        |error: csv::Error| Error::file(path, "the table", error.to_string(), "texunit sweep merge writes it anew");
    let mut reader = csv::Reader::from_path(path).map_err(damaged)?;
    let names = reader.headers().map_err(damaged)?.iter().map(str::to_owned).collect();
    let row =
        |row: csv::Result<csv::StringRecord>| row.map(|row| row.iter().map(str::to_owned).collect()).map_err(damaged);
    let rows = reader.records().map(row).collect::<Result<_>>()?;
    Ok((names, rows))
}

fn data_address(path: &Path, format: Images) -> Result<String> {
    let bytes = fs::read(path).map_err(Error::io(path))?;
    if format == Images::Png {
        return Ok(format!("data:image/png;base64,{}", STANDARD.encode(bytes)));
    }
    let damaged =
        |error: image::ImageError| Error::file(path, "the image", error.to_string(), "texunit run writes it anew");
    let image = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png).decode().map_err(damaged)?;
    let mut jpeg = Vec::new();
    JpegEncoder::new_with_quality(&mut jpeg, 90).encode_image(&image.into_rgb8()).map_err(damaged)?;
    Ok(format!("data:image/jpeg;base64,{}", STANDARD.encode(jpeg)))
}
