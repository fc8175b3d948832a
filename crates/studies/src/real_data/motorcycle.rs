//! Silverman's motorcycle data: noise that depends on the input, against the same noise everywhere.

use std::path::Path;

use anyhow::{Context, Result};
use serde_json::{Map, json};

use super::Section;
use super::row::{Reference, Row};
use crate::figures::learning::changing_noise::cross_validated;

const N_FOLDS: usize = 10;

/// Time in ms and acceleration in g.
#[derive(serde::Deserialize)]
struct Record {
    times: f64,
    accel: f64,
}

/// Cross-validates both on a table with columns `times` and `accel`, if it is there.
pub(super) fn run(path: &Path) -> Result<Section> {
    if !path.is_file() {
        println!("no motorcycle data beside the others: {} is no file", path.display());
        return Ok(Section::default());
    }
    let mut reader = csv::Reader::from_path(path)?;
    let records = reader.deserialize().collect::<Result<Vec<Record>, _>>();
    let records = records.with_context(|| format!("cannot read {}", path.display()))?;
    let (t, y): (Vec<f64>, Vec<f64>) = records.iter().map(|row| (row.times, row.accel)).unzip();
    let found = cross_validated(&t, &y, N_FOLDS)?;
    let names = ["the same noise everywhere", "noise of the time"];
    let mut rows = Vec::new();
    for ((name, nlpd), [half, most]) in names.iter().zip(found.nlpd).zip(found.inside) {
        for (what, value) in [("NLPD in nats", nlpd), ("share in 50 %", half), ("in 95 %", most)] {
            rows.push(Row::new(format!("motorcycle, {name}: {what}"), value, Reference::None));
        }
    }
    let json = json!({
        "folds": N_FOLDS,
        "rows": t.len(),
        "nlpd": found.nlpd,
        "inside_50_and_95": found.inside,
    });
    Ok(Section { json: Map::from_iter([("motorcycle".to_owned(), json)]), rows })
}
