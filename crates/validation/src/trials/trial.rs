//! Running one trial: a set with sealed truth, the answer to it, and only then the truth.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use dataset::{RecordingSet, Table, ingest};
use diagnosis::{
    DiagnoseSettings, Diagnosed, FitSettings, NoiseModel, Observations, Predictions, diagnose,
    fit_with_noise, split, steady_ingest,
};
use models::{Analytical, Description, ModelFile, PushModel};
use plant::{GenerateReport, GenerateSettings, generate};

use super::case::{Case, Family, Rig};
use super::oracle::Oracle;
use super::record::{Outcome, Record};
use super::truth;
use super::variant::{SPLIT_SEED, Variant, recordings};

/// The model under test, inside of the set's folder.
const MODEL: &str = "model.toml";

/// Runs a trial in a folder of its own, which is gone afterwards.
///
/// # Errors
/// A set that cannot be made; what goes wrong in a diagnosis is an outcome.
pub(super) fn run(case: &Case, oracle: &Oracle, folder: &Path) -> Result<Record> {
    let sealed = Sealed::make(case, oracle, folder)?;
    let start = Instant::now();
    let (outcome, found) = outcome(case, &sealed.given, None);
    let seconds = start.elapsed().as_secs_f64();
    let fresh = match found.filter(|_| case.has_fresh_pushes()) {
        Some(found) => error_on_fresh_pushes(case, &sealed.given, &found)?,
        None => None,
    };
    let variants = case.variants.iter();
    let variants: BTreeMap<Variant, Outcome> =
        variants.map(|own| (*own, self::outcome(case, &sealed.given, Some(*own)).0)).collect();
    let truth = truth::open(&sealed.truth, &case.setup.profile().nominal())?;
    let floor = match case.setup.rig {
        Rig::Quiet => Some(floor(case, folder)?),
        _ => None,
    };
    let by_hand = case.family == Family::WrongEffect;
    let closed_by_hand = match by_hand {
        true => closed_by_hand(case, oracle, &sealed.given, floor.context("no floor is known")?)?,
        false => Vec::new(),
    };
    let visibility = case.hidden.first().and_then(|asked| {
        let sizes = oracle.sizes(asked.id, &case.setup).ok()?;
        Some(oracle.share(asked, &case.setup).ok()? * sizes.visibility())
    });
    // Narrow designs alone are judged by it, and the quick slice asks no oracle.
    let alike = match (case.family, case.hidden.first()) {
        (Family::Narrow, Some(asked)) if oracle.knows(&case.setup) => {
            oracle.alike(asked, &case.setup)?
        }
        _ => Vec::new(),
    };
    fs::remove_dir_all(folder).with_context(|| format!("cannot remove {}", folder.display()))?;
    let record = Record::failed(case, String::new(), truth, seconds);
    Ok(Record { outcome, variants, visibility, alike, fresh, floor, closed_by_hand, ..record })
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
        let report = drawn(case.rig(&shares)?, &made.join("set"))?;
        let given = folder.join("given");
        fs::rename(&report.set, &given)?;
        let set = RecordingSet::open(&given)?;
        let base = Analytical::nominal(set.manifest().pusher.friction)?;
        let description = base.with_surface(case.surface)?.describe()?;
        let model = ModelFile::new("the model under test", description);
        model.write(&given.join(MODEL))?;
        Ok(Self { given, truth: report.sealed_truth })
    }
}

/// The recordings of a rig; where some push cannot be simulated, for the tip is wedged in a corner, of other draws.
fn drawn(mut rig: GenerateSettings, set: &Path) -> Result<GenerateReport> {
    const MOST_DRAWS: u64 = 5;
    const FAR: u64 = 1 << 40;
    for _ in 1..MOST_DRAWS {
        if let Ok(report) = generate(&rig, set) {
            return Ok(report);
        }
        if set.exists() {
            fs::remove_dir_all(set)?;
        }
        rig.seed += FAR;
    }
    Ok(generate(&rig, set)?)
}

/// What the diagnosis says of a folder, and its model; an error and a panic are outcomes, too.
fn outcome(case: &Case, given: &Path, variant: Option<Variant>) -> (Outcome, Option<Description>) {
    let answer = catch_unwind(AssertUnwindSafe(|| diagnosed(case, given, variant)));
    match answer {
        Ok(Ok(found)) => {
            (Outcome::Answer(Box::new(found.diagnosis.into())), Some(found.description))
        }
        Ok(Err(error)) => (Outcome::Failed(format!("{error:#}")), None),
        Err(panic) => {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or(panic.downcast_ref::<&str>().copied());
            (Outcome::Failed(format!("panic: {}", text.unwrap_or("without words"))), None)
        }
    }
}

/// The diagnosis of a folder with recordings, manifest and model: all that it is told.
fn diagnosed(case: &Case, given: &Path, variant: Option<Variant>) -> Result<Diagnosed> {
    let told = Told::read(case, given, variant, Part::Given)?;
    let settings = DiagnoseSettings {
        seed: variant.map_or(SPLIT_SEED, Variant::split_seed),
        n_pushes_excluded: told.n_pushes - told.observations.pushes().len(),
        ..DiagnoseSettings::default()
    };
    Ok(diagnose(&told.observations, &told.model, &settings)?)
}

/// Error of a step with the model that was found over that with the model under test, on the pushes
/// that the diagnosis did not get; none if the model is the same.
fn error_on_fresh_pushes(case: &Case, given: &Path, found: &Description) -> Result<Option<f64>> {
    let Told { observations, model, .. } = Told::read(case, given, None, Part::Fresh)?;
    if *found == model {
        return Ok(None);
    }
    let (before, after) = (squares(&model, &observations)?, squares(found, &observations)?);
    let known = before.iter().zip(after).filter(|(before, _)| **before > 0.0);
    let ratios: Vec<f64> = known.map(|(before, after)| after / before).collect();
    Ok(Some((ratios.iter().sum::<f64>() / ratios.len() as f64).sqrt()))
}

/// Which pushes of a set.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    /// Those that the diagnosis gets: every other one where some are kept from it.
    Given,
    Fresh,
}

/// What a folder tells.
struct Told {
    observations: Observations,
    model: Description,
    n_pushes: usize,
}

impl Told {
    fn read(case: &Case, given: &Path, variant: Option<Variant>, part: Part) -> Result<Self> {
        let manifest = given.join(dataset::MANIFEST_NAME);
        let right = fs::read_to_string(&manifest)?;
        let told = variant.map_or(Ok(right.clone()), |variant| variant.manifest(&right))?;
        fs::write(&manifest, told)?;
        let set = RecordingSet::open(given)?;
        fs::write(&manifest, right)?;
        let model = ModelFile::read(&given.join(MODEL))?.description;
        let (mut table, report): (Table, _) = ingest(&set, &steady_ingest())?;
        if case.has_fresh_pushes() {
            let names = recordings(&table).into_iter().enumerate();
            let own = names.filter(|(k, _)| (k % 2 == 0) == (part == Part::Given));
            let own: BTreeSet<_> = own.map(|(_, name)| name).collect();
            table.rows.retain(|row| own.contains(&row.recording));
        }
        let (table, model) = match variant {
            Some(variant) => (variant.table(&table, &set, case.seed)?, variant.model(&model)?),
            None => (table, model),
        };
        let observations = Observations::steady(&table, set.manifest())?;
        let n_used = observations.pushes().len();
        let n_pushes = match case.has_fresh_pushes() {
            true => n_used,
            false => report.summary.pushes_used.max(n_used),
        };
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
    let report = drawn(plain.rig(&[])?, &noise_alone)?;
    let set = RecordingSet::open(&report.set)?;
    let (table, _) = ingest(&set, &steady_ingest())?;
    let observations = Observations::steady(&table, set.manifest())?;
    let base = Analytical::nominal(set.manifest().pusher.friction)?.with_surface(plain.surface)?;
    errors(&base.describe()?, &observations)
}

/// Root mean square error of Δx, Δy and Δθ of a step.
fn errors(model: &Description, observations: &Observations) -> Result<[f64; 3]> {
    let [dx, dy, dtheta, ..] = squares(model, observations)?;
    Ok([dx, dy, dtheta].map(f64::sqrt))
}

/// Mean squares of the errors of a step's Δx, Δy, Δθ, normal and tangential force.
fn squares(model: &Description, observations: &Observations) -> Result<[f64; 5]> {
    let predictions = Predictions::of(model, &[], observations)?;
    let mut squares = [0.0; 5];
    for (predicted, step) in predictions.steps().iter().zip(observations.steps()) {
        for (k, square) in squares.iter_mut().enumerate() {
            let miss = step.observed[k].zip(predicted[k]).map_or(0.0, |(seen, told)| seen - told);
            *square += miss * miss;
        }
    }
    Ok(squares.map(|square| square / observations.n_steps() as f64))
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
    let told = Told::read(case, given, None, Part::Given)?;
    let parts = split(&told.observations, SPLIT_SEED)?;
    let (fitted, kept) =
        (told.observations.part(&parts.fit)?, told.observations.part(&parts.confirm)?);
    let noise = NoiseModel::learn(&told.model, &[], &fitted)?;
    let settings = FitSettings::default();
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
