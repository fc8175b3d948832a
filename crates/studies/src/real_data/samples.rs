//! Simulated sets of foreign make that may lie beside the public data: all of them are ingested.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use dataset::{IngestSettings, RecordingSet, ingest};
use serde_json::{Map, Value, json};

use super::Section;
use super::row::{Reference, Row};

pub(super) fn run(dir: &Path) -> Result<Section> {
    if !dir.is_dir() {
        println!("no sets beside the data: {} is no folder", dir.display());
        return Ok(Section::default());
    }
    let mut sets = Map::new();
    let mut rows = Vec::new();
    for path in manifests(dir)? {
        let set = RecordingSet::open(&path)?;
        let (table, report) = ingest(&set, &IngestSettings::default())
            .with_context(|| format!("cannot ingest {}", path.display()))?;
        let (name, summary) = (&report.name, &report.summary);
        let excluded: usize = summary.excluded.values().sum();
        rows.push(Row::new(
            format!("{name}: pushes used or excluded"),
            (summary.pushes_used + excluded) as f64,
            Reference::Exactly(set.recordings().len() as f64),
        ));
        rows.push(Row::new(format!("{name}: steps"), table.len() as f64, Reference::None));
        let entry = json!({
            "format": set.format().id(),
            "used": summary.pushes_used,
            "excluded": excluded,
            "reasons": summary.excluded,
            "steps": table.len(),
            "steady_force_n": summary.steady_force_n,
            "resting_position_sd_m": summary.resting_position_sd_m,
        });
        sets.insert(name.clone(), entry);
    }
    Ok(Section { json: Map::from_iter([("samples".to_owned(), Value::Object(sets))]), rows })
}

/// The folders with a manifest, in the order of their names.
fn manifests(dir: &Path) -> Result<Vec<PathBuf>> {
    let cannot_read = || format!("cannot read {}", dir.display());
    let mut found = Vec::new();
    for entry in fs::read_dir(dir).with_context(cannot_read)? {
        let path = entry.with_context(cannot_read)?.path();
        if path.join(dataset::MANIFEST_NAME).is_file() {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::{manifests, run};

    #[test]
    fn sets_that_are_not_there_are_skipped() {
        let dir = tempfile::tempdir().unwrap();
        assert!(run(&dir.path().join("none")).unwrap().rows.is_empty());
        std::fs::create_dir_all(dir.path().join("b")).unwrap();
        std::fs::create_dir_all(dir.path().join("a")).unwrap();
        std::fs::write(dir.path().join("b/dataset.toml"), "").unwrap();
        assert_eq!(manifests(dir.path()).unwrap(), [dir.path().join("b")]);
        assert!(run(dir.path()).is_err());
    }
}
