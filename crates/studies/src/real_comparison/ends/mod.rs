//! Long pushes of every object, of which the ends are known: what is missing, and the error with it.

mod page;
mod rows;

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use dataset::{Table, TableMapping};
use diagnosis::{
    DiagnoseSettings, Diagnosis, DiagnosisError, Observations, Predictions, diagnose, split,
};
use models::{Analytical, Description, PushModel};
use planar::wrap_angle;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

pub(super) use self::page::text;
use self::rows::Pushes;

/// Pushes of an object that are diagnosed at most, evenly from the file.
const MOST: usize = 150;

/// What is said of the pushes of one object.
pub(super) struct Ends {
    shape: String,
    n_kept: usize,
    /// Of those, as many as were diagnosed.
    n_used: usize,
    n_lost: usize,
    /// Pushes that never meet the outline.
    n_missed: usize,
    /// The answer, or why there is none.
    found: std::result::Result<Diagnosis, DiagnosisError>,
    /// Of the nominal model and of that with what is confirmed, on held-out pushes.
    errors: [Unseen; 2],
}

/// Mean errors of where the object ends up.
#[derive(Clone, Copy)]
struct Unseen {
    /// On the held-out pushes, which end in contact.
    kept: Error,
    /// On those and on the pushes whose pusher slid off, in the shares that they have of all.
    all: Error,
}

/// A mean error: m and rad.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Error {
    position: f64,
    angle: f64,
}

/// Diagnoses the pushes of every object in a file of end points, each by itself.
///
/// # Errors
/// A file that cannot be read; a model that cannot predict an object's pushes.
pub(super) fn ends(path: &Path) -> Result<Vec<Ends>> {
    let pushes = rows::pushes(path)?;
    pushes.par_iter().map(|one| of(one).with_context(|| one.shape.clone())).collect()
}

fn of(pushes: &Pushes) -> Result<Ends> {
    let Pushes { shape, mapping, kept, lost, .. } = pushes;
    let started = Instant::now();
    let stride = kept.rows.len().div_ceil(MOST).max(1);
    let rows = kept.rows.iter().step_by(stride).cloned().collect();
    let thinned = Table { rows, provenance: kept.provenance.clone() };
    let observations = Observations::of_mapped(&thinned, mapping)?;
    let nominal = Analytical::nominal(mapping.pusher.friction)?.describe()?;
    let n_pushes_excluded = lost.rows.len();
    let settings = DiagnoseSettings { n_pushes_excluded, ..DiagnoseSettings::default() };
    let parts = split(&observations, settings.seed)?;
    let aside = observations.part(&parts.confirm)?;
    // That a diagnosis fails is an outcome, too.
    let answer = diagnose(&observations, &nominal, &settings);
    let unseen = |model: &Description| -> Result<Unseen> {
        let kept_error = mean_error(model, &aside)?;
        let Some(lost_error) = lost_error(model, lost, mapping)? else {
            return Ok(Unseen { kept: kept_error, all: kept_error });
        };
        let all = kept_error.weighted(kept.rows.len(), lost_error, lost.rows.len());
        Ok(Unseen { kept: kept_error, all })
    };
    let (seconds, n) = (started.elapsed().as_secs(), observations.pushes().len());
    println!("{shape}: {n} of {} pushes diagnosed in {seconds} s", kept.rows.len());
    Ok(Ends {
        shape: shape.clone(),
        n_kept: kept.rows.len(),
        n_used: observations.pushes().len(),
        n_lost: lost.rows.len(),
        n_missed: pushes.n_missed,
        errors: [unseen(&nominal)?, unseen(answer.as_ref().map_or(&nominal, |a| &a.description))?],
        found: answer.map(|answer| answer.diagnosis),
    })
}

/// Of held-out pushes because the pusher slid off; none where there are too few.
fn lost_error(model: &Description, lost: &Table, mapping: &TableMapping) -> Result<Option<Error>> {
    const FEWEST: usize = 3;
    if lost.rows.len() < FEWEST {
        return Ok(None);
    }
    Ok(Some(mean_error(model, &Observations::of_mapped(lost, mapping)?)?))
}

fn mean_error(model: &Description, observations: &Observations) -> Result<Error> {
    let predictions = Predictions::of(model, &[], observations)?;
    let mut sum = Error { position: 0.0, angle: 0.0 };
    for (predicted, step) in predictions.steps().iter().zip(observations.steps()) {
        let miss = |k: usize| {
            let pair = step.observed[k].zip(predicted[k]);
            pair.map(|(seen, told)| seen - told).context("a step without motion")
        };
        sum.position += miss(0)?.hypot(miss(1)?);
        sum.angle += wrap_angle(miss(2)?).abs();
    }
    let n = observations.n_steps() as f64;
    Ok(Error { position: sum.position / n, angle: sum.angle / n })
}

impl Error {
    /// The mean of two means over so many pushes.
    fn weighted(self, n: usize, other: Self, n_other: usize) -> Self {
        let share = n as f64 / (n + n_other) as f64;
        let mean = |one: f64, other: f64| share * one + (1.0 - share) * other;
        let position = mean(self.position, other.position);
        Self { position, angle: mean(self.angle, other.angle) }
    }
}

#[cfg(test)]
mod tests {
    use super::Error;

    #[test]
    fn a_mean_of_means_counts_every_push_once() {
        let (one, other) =
            (Error { position: 1.0, angle: 0.0 }, Error { position: 5.0, angle: 0.4 });
        let mean = one.weighted(3, other, 1);
        assert!((mean.position - 2.0).abs() < 1e-15 && (mean.angle - 0.1).abs() < 1e-15);
    }
}
