//! The results of a sweep on disk: a file a point, whole or not there.
//!
//! Any number of processes may share a folder (a job array does): a point computed twice is the same bytes twice, and the last one stays.

use std::{
    fs,
    path::{Path, PathBuf},
};

use serde_json::{Value, json};

use super::{Cell, Measured, Plan, Point};
use crate::{
    error::{Error, Result},
    experiment::report::metrics_json,
    names::Named,
    output::{create_folder, write_whole},
};

/// Version of the shape of a point's file.
const SCHEMA: u32 = 1;

/// The folder of a sweep.
#[derive(Clone, Debug)]
pub struct Store {
    folder: PathBuf,
}

/// One row of the merged table.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Number of the point.
    pub point: usize,
    /// Values of the columns between `point` and `metric`, in the order of [`Store::columns`].
    pub place: Vec<String>,
    /// Name of the metric.
    pub metric: String,
    /// Value; none where there is no such number.
    pub value: Option<f64>,
    /// Unit.
    pub unit: String,
}

impl Store {
    /// Opens a folder, making it if need be.
    ///
    /// # Errors
    /// [`Error::Io`] naming the folder.
    pub fn open(folder: &Path) -> Result<Self> {
        create_folder(folder)?;
        Ok(Self { folder: folder.to_path_buf() })
    }

    /// The file of a point.
    #[must_use]
    pub fn path(&self, number: usize) -> PathBuf {
        self.folder.join(format!("point-{number:06}.json"))
    }

    /// Refuses a folder in which a newer texunit has left results: they are finished, and would be computed anew over.
    ///
    /// # Errors
    /// The first of them.
    pub fn check(&self, plan: &Plan) -> Result<()> {
        for point in &plan.points {
            let Some(value) = self.value(point) else { continue };
            if let Some(newer) = value["schema"].as_u64().filter(|schema| *schema > u64::from(SCHEMA)) {
                let problem = format!("schema {newer}, and this texunit reads up to {SCHEMA}");
                return Err(Error::file(
                    self.path(point.number),
                    "schema",
                    problem,
                    "update texunit, or give another folder",
                ));
            }
        }
        Ok(())
    }

    /// Whether a point's result is there and is that of this very configuration.
    #[must_use]
    pub fn holds(&self, plan: &Plan, point: &Point) -> bool {
        self.read(plan, point).is_some()
    }

    /// What a point's file holds, if that can be read.
    fn value(&self, point: &Point) -> Option<Value> {
        serde_json::from_slice(&fs::read(self.path(point.number)).ok()?).ok()
    }

    fn read(&self, plan: &Plan, point: &Point) -> Option<Value> {
        let value = self.value(point)?;
        // Through text and back, as the one on disk went: floats compare as written.
        let config: Value = serde_json::from_str(&plan.config(point).to_string()).ok()?;
        (value["schema"] == SCHEMA && value["config"] == config).then_some(value)
    }

    /// Writes the result of a point.
    ///
    /// # Errors
    /// [`Error::Io`] naming the file.
    pub fn write(&self, plan: &Plan, point: &Point, measured: &Measured) -> Result<()> {
        let cells: Vec<Value> = measured
            .cells
            .iter()
            .map(|Cell { geometry, metrics }| {
                json!({ "sets": geometry.sets, "ways": geometry.ways, "metrics": metrics_json(metrics) })
            })
            .collect();
        let settings: serde_json::Map<String, Value> =
            point.settings.iter().map(|(key, value)| (key.clone(), value.clone().into())).collect();
        let value = json!({
            "schema": SCHEMA,
            "sweep": plan.name,
            "point": point.number,
            "settings": settings,
            "metrics": metrics_json(&measured.metrics),
            "cells": cells,
            "config": plan.config(point),
        });
        write_whole(&self.path(point.number), |file| writeln!(file, "{value:#}"))
    }

    /// Points whose result is not there, or is another configuration's.
    #[must_use]
    pub fn missing<'p>(&self, plan: &'p Plan) -> Vec<&'p Point> {
        plan.points.iter().filter(|point| !self.holds(plan, point)).collect()
    }

    /// Names of the columns between `point` and `metric`.
    #[must_use]
    pub fn columns(plan: &Plan) -> Vec<String> {
        let fixed = ["design", "scene", "width", "height", "filter"].map(str::to_owned);
        let caches = ["cache.sets", "cache.ways"].map(str::to_owned);
        [fixed.as_slice(), &plan.keys, &caches].concat()
    }

    /// All results in order of points, in long form.
    ///
    /// # Errors
    /// The numbers of the points that are missing.
    pub fn rows(&self, plan: &Plan) -> Result<Vec<Row>> {
        let mut rows = Vec::new();
        let mut missing = Vec::new();
        for point in &plan.points {
            match self.read(plan, point) {
                Some(value) => point_rows(plan, point, &value, &mut rows),
                None => missing.push(point.number),
            }
        }
        if missing.is_empty() {
            return Ok(rows);
        }
        let shown: Vec<String> = missing.iter().take(20).map(ToString::to_string).collect();
        let more = if missing.len() > shown.len() { ", ..." } else { "" };
        Err(Error::file(
            &self.folder,
            format!("{} of {} points", missing.len(), plan.points.len()),
            format!("no result of this sweep file for {}{more}", shown.join(", ")),
            "`texunit sweep run` computes what is missing; `texunit sweep point FILE NUMBER` one point",
        ))
    }

    /// Writes the merged table as sweep.csv.
    ///
    /// # Errors
    /// [`Error::Io`] naming the file.
    pub fn write_csv(&self, plan: &Plan, rows: &[Row]) -> Result<PathBuf> {
        let path = self.folder.join("sweep.csv");
        write_whole(&path, |file| write_csv(file, &Self::columns(plan), rows))?;
        Ok(path)
    }

    /// Writes the merged table as sweep.parquet.
    ///
    /// # Errors
    /// [`Error::Io`] naming the file.
    #[cfg(feature = "parquet")]
    pub fn write_parquet(&self, plan: &Plan, rows: &[Row]) -> Result<PathBuf> {
        let path = self.folder.join("sweep.parquet");
        write_whole(&path, |file| super::write_parquet(file, &Self::columns(plan), rows))?;
        Ok(path)
    }
}

fn point_rows(plan: &Plan, point: &Point, value: &Value, rows: &mut Vec<Row>) {
    let scene = &plan.stages[point.stage].scene;
    let mut place = vec![
        point.machine.name.clone(),
        scene.name.clone(),
        scene.size[0].to_string(),
        scene.size[1].to_string(),
        point.filter.name().to_owned(),
    ];
    place.extend(point.settings.iter().map(|(_, value)| value.trim_matches('"').to_owned()));
    let mut push = |metrics: &Value, sets: String, ways: String| {
        for (name, metric) in metrics.as_object().into_iter().flatten() {
            rows.push(Row {
                point: point.number,
                place: [place.as_slice(), &[sets.clone(), ways.clone()]].concat(),
                metric: name.clone(),
                value: metric["value"].as_f64(),
                unit: metric["unit"].as_str().unwrap_or_default().to_owned(),
            });
        }
    };
    push(&value["metrics"], String::new(), String::new());
    for cell in value["cells"].as_array().into_iter().flatten() {
        push(&cell["metrics"], cell["sets"].to_string(), cell["ways"].to_string());
    }
}

/// The merged table as CSV.
///
/// # Errors
/// Those of the writer.
pub fn write_csv(writer: &mut dyn std::io::Write, columns: &[String], rows: &[Row]) -> std::io::Result<()> {
    let mut csv = csv::Writer::from_writer(writer);
    let columns = columns.iter().map(String::as_str);
    csv.write_record(["point"].into_iter().chain(columns).chain(["metric", "value", "unit"]))?;
    for row in rows {
        let (point, value) = (row.point.to_string(), row.value.map_or_else(String::new, |value| value.to_string()));
        let place = row.place.iter().map(String::as_str);
        csv.write_record([point.as_str()].into_iter().chain(place).chain([row.metric.as_str(), &value, &row.unit]))?;
    }
    csv.flush()
}
