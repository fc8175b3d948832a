//! `diagnosis.json`.

use std::fs;
use std::path::Path;

use anyhow::Result;
use diagnosis::Diagnosis;

use super::super::reader::{Reader, Verdict};

/// The answer of a diagnosis.
pub(super) struct Diagnoses;

const ANSWER: &str = r#"{
"schema": "pushlab.diagnosis/2", "verdict": "identified", "identified": ["inertia"],
"ambiguous": [["a", "b"]], "effective": ["c"],
"sentence": "inertia is missing",
"error": {"before": 1.5, "after": 1.1, "floor": 1.0, "gap_closed": 0.8, "unit": "1",
 "before_si": {"dx_m": 1e-4, "dy_m": 1e-4, "dtheta_rad": 1e-3},
 "after_si": {"dx_m": 1e-4, "dy_m": null, "dtheta_rad": 1e-3},
 "floor_si": {"dx_m": null, "dy_m": null, "dtheta_rad": null}},
"split": {"set": "00ff", "seed": 7, "cluster": "push", "fit": ["a#0"], "confirm": ["b#0"]},
"effects": [{"id": "inertia", "grade": "identified", "p_adjusted": 0.001, "gap_closed": 0.8,
 "log_density_gain": {"mean": 10.5, "se": 2.0},
 "parameters": [{"name": "switch", "unit": "1", "off": 0.0, "estimate": 1.0, "se": 0.0,
  "low95": null, "high95": null, "detection_limit": 0.5}],
 "rivals": [], "why": ""}],
"leftover": {"p": 0.5, "covariate": null}, "noise": {"source": "repeats", "n_cells": 10},
"data": {"pushes_used": 10, "pushes_set_aside": 0, "pushes_fitted": 5, "pushes_confirming": 5,
 "steps": 100},
"made_by": {"tool": "pushlab", "arguments": ["diagnose"], "inputs": [{"path": "a", "sha256": "00"}]}
}"#;

impl Reader for Diagnoses {
    fn name(&self) -> &'static str {
        "diagnosis"
    }

    fn corpus(&self, _: &Path) -> Result<Vec<Vec<u8>>> {
        Ok(vec![ANSWER.as_bytes().to_vec()])
    }

    fn tokens(&self) -> &'static [&'static str] {
        &["null", "[[[[", "{\"a\":", "\"hint\"", "1e999", "\\ud800", "\"ambiguous\"", "[]", "{}"]
    }

    fn read(&self, dir: &Path, input: &[u8]) -> Verdict {
        let path = dir.join("diagnosis.json");
        match fs::write(&path, input) {
            Ok(()) => Verdict::of(Diagnosis::read(&path), |_| None),
            Err(error) => Verdict::Wrong(format!("scratch is not usable: {error}")),
        }
    }
}
