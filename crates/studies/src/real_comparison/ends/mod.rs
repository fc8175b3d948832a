//! Long pushes of every object, of which the ends are known: what is missing, and the error with it.

mod page;

use std::fmt;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use dataset::{IngestSettings, Manifest, ObjectSpec, Preset, RecordingSet, Table, ingest};
use diagnosis::{
    DiagnoseSettings, Diagnosis, DiagnosisError, Observations, Predictions, diagnose, split,
};
use models::{Analytical, Description, PushModel};
use planar::{MIT_NAMES, wrap_angle};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

pub(super) use self::page::text;

/// Pushes of an object that are diagnosed at most, evenly from the file.
const MOST: usize = 150;

/// What is said of the pushes of one object.
pub(super) struct Ends {
    shape: String,
    n_pushes: usize,
    /// Of those, as many as were diagnosed.
    n_used: usize,
    /// Pushes in which the tracking flips.
    n_flips: usize,
    /// The answer, or why there is none.
    found: std::result::Result<Diagnosis, DiagnosisError>,
    /// Of the nominal model and of that with what is confirmed, on held-out pushes.
    errors: [Error; 2],
}

/// A mean error of the end, in m and rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Error {
    pub(super) position: f64,
    pub(super) angle: f64,
}

/// Pushes of one object, a row each.
pub(super) struct Pushes {
    pub(super) manifest: Manifest,
    pub(super) table: Table,
    n_flips: usize,
}

/// Diagnoses the pushes of every object in a file of end points, each by itself.
///
/// # Errors
/// A file that cannot be read; a model that cannot predict an object's pushes.
pub(super) fn ends(path: &Path) -> Result<Vec<Ends>> {
    MIT_NAMES.par_iter().map(|shape| of(path, shape).with_context(|| shape.to_string())).collect()
}

/// The pushes of an object, as `pushlab ingest --preset mit-endpoints --shape` reads them.
pub(super) fn pushes(path: &Path, shape: &str) -> Result<Pushes> {
    let set = RecordingSet::open_with_preset(path, Preset::MitEndpoints)?;
    let set = set.about(ObjectSpec::mit(shape)?)?;
    let (table, report) = ingest(&set, &IngestSettings::default())?;
    let n_flips = report.summary.excluded.get("tracking flip").copied().unwrap_or_default();
    Ok(Pushes { manifest: set.manifest().clone(), table, n_flips })
}

fn of(path: &Path, shape: &str) -> Result<Ends> {
    let Pushes { manifest, table, n_flips } = pushes(path, shape)?;
    let started = Instant::now();
    let nominal = Analytical::nominal(manifest.pusher.friction)?.describe()?;
    let stride = table.rows.len().div_ceil(MOST).max(1);
    let rows = table.rows.iter().step_by(stride).cloned().collect();
    let thinned = Table { rows, provenance: table.provenance.clone() };
    let observations = Observations::of(&thinned, &manifest)?;
    let settings = DiagnoseSettings::default();
    let parts = split(&observations, settings.seed)?;
    let aside = observations.part(&parts.confirm)?;
    // That a diagnosis fails is an outcome, too.
    let answer = diagnose(&observations, &nominal, &settings);
    let added = answer.as_ref().map_or(&nominal, |answer| &answer.description);
    let errors = [mean_error(&nominal, &aside)?, mean_error(added, &aside)?];
    let n = observations.pushes().len();
    println!(
        "{shape}: {n} of {} pushes diagnosed in {} s",
        table.len(),
        started.elapsed().as_secs()
    );
    Ok(Ends {
        shape: shape.to_owned(),
        n_pushes: table.len(),
        n_used: n,
        n_flips,
        errors,
        found: answer.map(|answer| answer.diagnosis),
    })
}

fn mean_error(model: &Description, observations: &Observations) -> Result<Error> {
    let mut sum = Error::default();
    let errors = errors(model, observations)?;
    for error in &errors {
        sum.position += error.position;
        sum.angle += error.angle;
    }
    Ok(sum.over(errors.len()))
}

/// Of each push.
pub(super) fn errors(model: &Description, observations: &Observations) -> Result<Vec<Error>> {
    let predictions = Predictions::of(model, &[], observations)?;
    let pairs = predictions.steps().iter().zip(observations.steps());
    let error = |(predicted, step): (&[Option<f64>; 7], &models::ChannelObservation)| {
        let miss = |k: usize| {
            let pair = step.observed[k].zip(predicted[k]);
            pair.map(|(seen, told)| seen - told).context("a step without motion")
        };
        let position = miss(0)?.hypot(miss(1)?);
        Ok(Error { position, angle: wrap_angle(miss(2)?).abs() })
    };
    pairs.map(error).collect()
}

impl Error {
    /// The mean of so many that were summed.
    pub(super) fn over(self, n: usize) -> Self {
        let n = n as f64;
        Self { position: self.position / n, angle: self.angle / n }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.2} mm, {:.2}°", 1e3 * self.position, self.angle.to_degrees())
    }
}
