//! Weights files, under the checksum that their model file has.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context, Result};
use gp_core::LearnOptions;
use models::{
    Analytical, GpPushModel, Hybrid, ModelFile, ProcessKind, PushModel, StepInput, StepObservation,
    Training, learn_options,
};
use nalgebra::Vector3;
use planar::Shape;
use sha2::{Digest, Sha256};

use super::super::reader::{NEXT_FILE, Reader, Verdict};
use super::model::wrong;

/// A model file, and its weights, whose checksum is set right before they are read.
pub(super) struct WeightsFiles;

/// Name of the weights of every input.
const WEIGHTS: &str = "model.weights.json";
/// Rows that a process learns from.
const N_STEPS: u32 = 6;

impl Reader for WeightsFiles {
    fn name(&self) -> &'static str {
        "weights"
    }

    fn corpus(&self, dir: &Path) -> Result<Vec<Vec<u8>>> {
        let nominal = Analytical::nominal(0.25)?;
        let steps = (0..N_STEPS).map(|k| step(k, &nominal)).collect::<Result<Vec<_>>>()?;
        let mut inputs = Vec::new();
        let mut add = |model: &dyn PushModel| -> Result<()> {
            let path = dir.join("model.toml");
            let description = model.describe()?;
            ModelFile::new("a", description).write(&path)?;
            inputs.push(input(dir, &path)?);
            Ok(())
        };
        for process in ProcessKind::ALL {
            let usual = learn_options();
            let options = LearnOptions { n_starts: 1, max_iterations: 20, ..usual };
            let training =
                Training { process, n_pseudo_inputs: 3, n_features: 4, ..options.into() };
            match GpPushModel::train(&steps, &training) {
                Ok((model, _)) => add(&model)?,
                Err(error) => eprintln!("no weights of {}: {error}", process.id()),
            }
        }
        let description = nominal.describe()?;
        add(&Hybrid::train(&description, None, &steps, &Training::default())?.0)?;
        Ok(inputs)
    }

    fn tokens(&self) -> &'static [&'static str] {
        &["[]", "[[]]", "null", "-1", "1e308", "[0,0]", "polygon", "ellipse", "\"gp\":", "\"rff\":"]
    }

    fn read(&self, dir: &Path, input: &[u8]) -> Verdict {
        match prepare(dir, input) {
            Ok(()) => Verdict::of(ModelFile::read(&dir.join("model.toml")), wrong),
            Err(error) => Verdict::Wrong(format!("scratch is not usable: {error:#}")),
        }
    }
}

fn step(k: u32, nominal: &Analytical) -> Result<StepObservation> {
    let shape = Arc::new(Shape::square(0.09)?);
    let (p, beta) = (f64::from(k) / 6.0, f64::from(k * 7 % 6) / 6.0 - 0.5);
    let input = StepInput::on_edge(shape, 0.005, 1, p, beta, 0.004)?.lasting(0.2)?;
    let noise = Vector3::repeat(1e-5 * f64::from(k * 5 % 7));
    let outputs = input.outputs(&nominal.motion(&input)?) + noise;
    Ok(StepObservation { input, outputs })
}

/// A model file and its weights, under the name that they are read by.
fn input(dir: &Path, path: &Path) -> Result<Vec<u8>> {
    let model: toml::Table = toml::from_str(&fs::read_to_string(path)?)?;
    let weights = model["learned"]["weights"].as_str().context("no name of the weights")?;
    let text = fs::read_to_string(path)?.replace(weights, WEIGHTS);
    Ok([text.into_bytes(), fs::read(dir.join(weights))?].join(&NEXT_FILE))
}

/// Writes both files, the first with the checksum of the second.
fn prepare(dir: &Path, input: &[u8]) -> Result<()> {
    let mut parts = input.splitn(2, |byte| *byte == NEXT_FILE);
    let (model, weights) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
    let hash = format!("{:x}", Sha256::digest(weights));
    let key = b"sha256 = \"";
    let mut model = model.to_vec();
    let place = model.windows(key.len()).position(|window| window == key);
    if let Some(start) = place.map(|at| at + key.len()) {
        let end = model.len().min(start + hash.len());
        model.splice(start..end, hash.bytes());
    }
    fs::write(dir.join("model.toml"), model).context("model.toml")?;
    fs::write(dir.join(WEIGHTS), weights).context("weights")
}
