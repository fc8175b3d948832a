//! Long pushes of one object, a row each, and what a model misses of their ends.

use std::fmt;
use std::path::Path;

use anyhow::{Context, Result};
use dataset::{IngestSettings, ObjectSpec, Preset, RecordingSet, ingest};
use diagnosis::{Observations, Predictions};
use models::{Analytical, Description, PushModel};
use planar::wrap_angle;

/// A mean error of the end, in m and rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Error {
    pub(super) position: f64,
    pub(super) angle: f64,
}

/// The pushes of an object, as `pushlab ingest --preset mit-endpoints --shape` reads them, and its nominal model.
///
/// # Errors
/// A file that cannot be read.
pub(super) fn pushes(path: &Path, shape: &str) -> Result<(Observations, Description)> {
    let set = RecordingSet::open_with_preset(path, Preset::MitEndpoints)?;
    let set = set.about(ObjectSpec::mit(shape)?)?;
    let (table, _) = ingest(&set, &IngestSettings::default())?;
    let manifest = set.manifest();
    let nominal = Analytical::nominal(manifest.pusher.friction)?.describe()?;
    Ok((Observations::of(&table, manifest)?, nominal))
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
    pub(super) fn mean(of: impl ExactSizeIterator<Item = Self>) -> Self {
        let n = of.len();
        let sum = of.fold(Self::default(), |sum, one| Self {
            position: sum.position + one.position,
            angle: sum.angle + one.angle,
        });
        sum.over(n)
    }

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
