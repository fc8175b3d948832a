//! Running one trial: a set with sealed truth, the answer to it, and only then the truth.

use std::collections::BTreeMap;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use dataset::{RecordingSet, Table, ingest};
use diagnosis::{
    DiagnoseSettings, Diagnosis, FitSettings, Intervals, NoiseModel, Observations, Predictions,
    diagnose, fit_with_noise, split, steady_ingest,
};
use models::{Analytical, Description, ModelFile, PushModel};
use plant::generate;

use super::case::{Case, Family};
use super::oracle::Oracle;
use super::record::{Outcome, Record};
use super::truth;
use super::variant::{SPLIT_SEED, Variant};

/// The model under test, inside of the set's folder.
const MODEL: &str = "model.toml";

/// Runs a trial in a folder of its own, which is gone afterwards.
///
/// # Errors
/// A set that cannot be made; what goes wrong in a diagnosis is an outcome.
pub(super) fn run(case: &Case, oracle: &Oracle, folder: &Path) -> Result<Record> {
    let sealed = Sealed::make(case, oracle, folder)?;
    let start = Instant::now();
    let outcome = outcome(&sealed.given, None, case.seed);
    let seconds = start.elapsed().as_secs_f64();
    let variants = case.variants.iter();
    let variants: BTreeMap<Variant, Outcome> =
        variants.map(|own| (*own, self::outcome(&sealed.given, Some(*own), case.seed))).collect();
    let truth = truth::open(&sealed.truth)?;
    let floor = floor(case, folder)?;
    let by_hand = case.family == Family::WrongEffect;
    let closed_by_hand = match by_hand {
        true => closed_by_hand(case, oracle, &sealed.given, floor)?,
        false => Vec::new(),
    };
    let visibility = case.hidden.first().and_then(|asked| {
        let sizes = oracle.sizes(asked.id, &case.setup).ok()?;
        Some(oracle.share(asked, &case.setup).ok()? * sizes.visibility())
    });
    fs::remove_dir_all(folder).with_context(|| format!("cannot remove {}", folder.display()))?;
    let record = Record::failed(case, String::new(), truth, seconds);
    Ok(Record { outcome, variants, visibility, floor: Some(floor), closed_by_hand, ..record })
}

/// A recording set, and its truth in another folder.
struct Sealed {
    given: PathBuf,
    truth: PathBuf,
}

impl Sealed {
    /// Makes the set of a case with the model under test.
    fn make(case: &Case, oracle: &Oracle, folder: &Path) -> Result<Self> {
        let shares = case.hidden.iter().map(|asked| oracle.share(asked, &case.setup));
        let shares = shares.collect::<Result<Vec<_>>>()?;
        let made = folder.join("made");
        fs::create_dir_all(&made)?;
        let report = generate(&case.rig(&shares)?, &made.join("set"))?;
        let given = folder.join("given");
        fs::rename(&report.set, &given)?;
        let set = RecordingSet::open(&given)?;
        let base = Analytical::nominal(set.manifest().pusher.friction)?;
        let description = base.with_surface(case.surface)?.describe()?;
        let model = ModelFile { name: "the model under test".into(), description, split: None };
        model.write(&given.join(MODEL))?;
        Ok(Self { given, truth: report.sealed_truth })
    }
}

/// What the diagnosis says of a folder; an error and a panic are outcomes, too.
fn outcome(given: &Path, variant: Option<Variant>, seed: u64) -> Outcome {
    let answer = catch_unwind(AssertUnwindSafe(|| diagnosed(given, variant, seed)));
    match answer {
        Ok(Ok(found)) => Outcome::Answer(Box::new(found.into())),
        Ok(Err(error)) => Outcome::Failed(format!("{error:#}")),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or(panic.downcast_ref::<&str>().copied());
            Outcome::Failed(format!("panic: {}", text.unwrap_or("without words")))
        }
    }
}

/// The diagnosis of a folder with recordings, manifest and model: all that it is told.
fn diagnosed(given: &Path, variant: Option<Variant>, seed: u64) -> Result<Diagnosis> {
    let told = Told::read(given, variant, seed)?;
    let settings = DiagnoseSettings {
        seed: variant.map_or(SPLIT_SEED, Variant::split_seed),
        n_pushes_excluded: told.n_pushes - told.observations.pushes().len(),
        ..DiagnoseSettings::default()
    };
    Ok(diagnose(&told.observations, &told.model, &settings)?.diagnosis)
}

/// What a folder tells.
struct Told {
    observations: Observations,
    model: Description,
    n_pushes: usize,
}

impl Told {
    fn read(given: &Path, variant: Option<Variant>, seed: u64) -> Result<Self> {
        let set = RecordingSet::open(given)?;
        let model = ModelFile::read(&given.join(MODEL))?.description;
        let (table, report): (Table, _) = ingest(&set, &steady_ingest())?;
        let (table, model) = match variant {
            Some(variant) => (variant.table(&table, &set, seed)?, variant.model(&model)?),
            None => (table, model),
        };
        let observations = Observations::steady(&table, set.manifest())?;
        let n_pushes = report.summary.pushes_used.max(observations.pushes().len());
        Ok(Self { observations, model, n_pushes })
    }
}

/// The error of a true model where there is noise alone: the same pushes, simulated with nothing
/// hidden, against the exact surface that they then have.
fn floor(case: &Case, folder: &Path) -> Result<[f64; 3]> {
    let noise_alone = folder.join("noise-alone");
    let mut plain = case.clone();
    plain.surface = models::SurfaceKind::UniformPatch;
    plain.hidden.clear();
    let report = generate(&plain.rig(&[])?, &noise_alone)?;
    let set = RecordingSet::open(&report.set)?;
    let (table, _) = ingest(&set, &steady_ingest())?;
    let observations = Observations::steady(&table, set.manifest())?;
    let base = Analytical::nominal(set.manifest().pusher.friction)?.with_surface(plain.surface)?;
    errors(&base.describe()?, &observations)
}

/// Root mean square error of Δx, Δy and Δθ of a step.
fn errors(model: &Description, observations: &Observations) -> Result<[f64; 3]> {
    let predictions = Predictions::of(model, &[], observations)?;
    let mut squares = [0.0; 3];
    for (predicted, step) in predictions.steps().iter().zip(observations.steps()) {
        for (k, square) in squares.iter_mut().enumerate() {
            let miss = step.observed[k].zip(predicted[k]).map_or(0.0, |(seen, told)| seen - told);
            *square += miss * miss;
        }
    }
    Ok(squares.map(|square| (square / observations.n_steps() as f64).sqrt()))
}

/// An error over its floor, over the three numbers of a step's motion.
pub(super) fn over_floor(error: [f64; 3], floor: [f64; 3]) -> f64 {
    let squares = error.iter().zip(floor).map(|(error, floor)| (error / floor).powi(2));
    (squares.sum::<f64>() / 3.0).sqrt()
}

/// Effects that the oracle finds unlike the hidden one, each fitted on three quarters of the
/// pushes, and the share of the gap to the floor that it closes on the others.
fn closed_by_hand(
    case: &Case,
    oracle: &Oracle,
    given: &Path,
    floor: [f64; 3],
) -> Result<Vec<(String, f64)>> {
    let told = Told::read(given, None, case.seed)?;
    let parts = split(&told.observations, SPLIT_SEED)?;
    let (fitted, kept) =
        (told.observations.part(&parts.fit)?, told.observations.part(&parts.confirm)?);
    let noise = NoiseModel::learn(&told.model, &[], &fitted)?;
    let settings =
        FitSettings { intervals: Intervals::None, priors: true, ..FitSettings::default() };
    let error = |free: &[&str]| -> Result<f64> {
        let fit = fit_with_noise(&fitted, &told.model, free, &noise, &settings)?;
        Ok(over_floor(errors(&fit.with_nuisances, &kept)?, floor))
    };
    let before = error(&[])?;
    let mut closed = Vec::new();
    for id in oracle.unlike(&case.hidden[0], &case.setup)? {
        // A fit that does not settle adds nothing.
        let after = error(&[id]).unwrap_or(before);
        closed.push((id.to_owned(), (before - after) / (before - 1.0)));
    }
    Ok(closed)
}
