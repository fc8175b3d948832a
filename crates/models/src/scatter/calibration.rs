//! A model, and pushes that it was not asked about, go in; how sure it may be of whole pushes comes out.

use std::sync::atomic::{AtomicUsize, Ordering};

use effects::Spread;
use nalgebra::Matrix3;
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};
use serde::{Deserialize, Serialize};

use crate::analytical::fit::scatter_per_way;
use crate::analytical::is_covariance;
use crate::{
    Analytical, Base, Description, ModelError, Noise, PushModel, RecordedPush, RollOutSettings,
    Setup, StepCorrelation,
};

/// How sure a model may be of where pushes end, as recorded ones showed it ([`Description::calibration`]).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Pushes that it was measured on.
    pub n_pushes: usize,
    /// So many times as wide as in the model is what differs from push to push; none where nothing does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub widened: Option<f64>,
    /// Of physics that have none of their own, the scatter of steps: the covariance of (Δx, Δy, Δθ) in m and rad
    /// per meter of way squared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scatter_per_m: Option<[[f64; 3]; 3]>,
    /// How the errors of the steps of a push go together; none where what differs from push to push says it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correlation: Option<StepCorrelation>,
}

/// What a calibration is at, for those who wait for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum CalibrationPhase {
    /// The errors of the steps of each push are held against each other.
    Steps,
    /// Pushes are rolled out with spreads of another size.
    RollOuts {
        /// Sizes that were tried, this one with them.
        round: usize,
        /// Pushes rolled out, of this size.
        done: usize,
        /// How many there are.
        of: usize,
    },
}

/// Fewer ends do not tell how far apart ends are.
const FEWEST: usize = 8;
/// More are not rolled out, but an even choice of them.
const MOST: usize = 30;
const N_PARTICLES: usize = 100;
/// Factors are tried so far apart until ends are in the other half of their regions, then between the last two.
const FIRST_RATIO: f64 = 1.6;
const HALVINGS: usize = 2;
/// What a file may say: by hand somebody may be more daring.
const MOST_WIDENED: f64 = 1e3;
/// Spreads become at most so many times as wide, or as narrow.
const WIDEST: f64 = 8.0;

impl Description {
    /// How sure the model may be of whole pushes, by recorded ones.
    ///
    /// Where parameters differ from push to push, all spreads are scaled by one factor, with which the
    /// regions of roll-outs hold as many of the measured ends as they say: the least Cramér–von Mises distance
    /// of the levels of the ends to even ones. They were fitted to steps, each beside the others, and a step knows
    /// nothing of what its errors add up to. Else physics without any scatter get that of the steps, and the
    /// errors of the steps of a push go together as they were measured to ([`StepCorrelation::measure`]).
    ///
    /// - `pushes`: of a model that learnt those that it has not seen; physics leave of pushes that their few
    ///   numbers were fitted to what they leave of others.
    ///
    /// # Errors
    /// `TooFewPushes`; what the model refuses.
    pub fn calibration(
        &self,
        setup: &Setup,
        pushes: &[RecordedPush],
    ) -> Result<Calibration, ModelError> {
        self.calibration_with_progress(setup, pushes, &|_| {})
    }

    /// The same, and tells an observer what it is at: roll-outs take half a minute. Many threads tell, in any
    /// order; what is found does not depend on who listens.
    ///
    /// # Errors
    /// As [`Self::calibration`].
    pub fn calibration_with_progress(
        &self,
        setup: &Setup,
        pushes: &[RecordedPush],
        observer: &(dyn Fn(CalibrationPhase) + Sync),
    ) -> Result<Calibration, ModelError> {
        if self.built_in(setup)?.n_drawn() > 0 {
            return self.widened_by_ends(setup, pushes, observer);
        }
        observer(CalibrationPhase::Steps);
        let has_none = match &self.base {
            Base::Analytical(base) => *base.scatter() == Matrix3::zeros(),
            _ => false,
        };
        let scatter_per_m = match has_none {
            true => scatter_of(self.built_in(setup)?.as_ref(), pushes)?.map(Into::into),
            false => None,
        };
        let found = Calibration { scatter_per_m, ..Calibration::default() };
        let model = self.with(&found)?.built_in(setup)?;
        let correlation = StepCorrelation::measure(model.as_ref(), pushes)?;
        Ok(Calibration { n_pushes: correlation.n_pushes, correlation: Some(correlation), ..found })
    }

    /// The model as sure of whole pushes as a calibration lets it be; how the errors of steps go together is for
    /// [`RollOutSettings`].
    ///
    /// # Errors
    /// Physics that refuse a scatter.
    pub fn with(&self, calibration: &Calibration) -> Result<Self, ModelError> {
        let mut model = calibration.widened.map_or_else(|| self.clone(), |of| self.widened(of));
        if let (Base::Analytical(base), Some(scatter)) = (&self.base, calibration.scatter_per_m) {
            let base = Analytical::new(
                base.pusher_friction().clone(),
                base.length().clone(),
                scatter.into(),
            )?
            .with_surface(base.surface())?;
            model.base = Base::Analytical(base);
        }
        Ok(model)
    }

    fn widened_by_ends(
        &self,
        setup: &Setup,
        pushes: &[RecordedPush],
        observer: &(dyn Fn(CalibrationPhase) + Sync),
    ) -> Result<Calibration, ModelError> {
        let n_pushes = pushes.len().min(MOST);
        if n_pushes < FEWEST {
            return Err(ModelError::TooFewPushes { n_pushes, needed: FEWEST });
        }
        let chosen: Vec<&RecordedPush> =
            (0..n_pushes).map(|k| &pushes[k * pushes.len() / n_pushes]).collect();
        let settings = RollOutSettings {
            n_particles: N_PARTICLES,
            touching: true,
            ..RollOutSettings::default()
        };
        let rolled_out = AtomicUsize::new(0);
        let levels = |log_factor: f64| -> Result<Vec<f64>, ModelError> {
            let model = self.widened(log_factor.exp()).built_in(setup)?;
            let level = |push: &&RecordedPush| {
                let level = push.end_level(model.as_ref(), &settings);
                let before = rolled_out.fetch_add(1, Ordering::Relaxed);
                let (round, done) = (before / n_pushes + 1, before % n_pushes + 1);
                observer(CalibrationPhase::RollOuts { round, done, of: n_pushes });
                level
            };
            chosen.par_iter().map(level).collect()
        };
        let first = levels(0.0)?;
        let ask_for_wider = are_outer(&first);
        let mut tried = vec![(0.0, from_even(&first))];
        let step = if ask_for_wider { FIRST_RATIO.ln() } else { -FIRST_RATIO.ln() };
        let (mut here, mut beyond) = (0.0_f64, None);
        while beyond.is_none() && (here + step).abs() <= WIDEST.ln() {
            // What some push cannot be rolled out with is too wide.
            let Ok(found) = levels(here + step) else { break };
            tried.push((here + step, from_even(&found)));
            match are_outer(&found) == ask_for_wider {
                true => here += step,
                false => beyond = Some(here + step),
            }
        }
        for _ in 0..HALVINGS {
            let Some(there) = beyond else { break };
            let middle = 0.5 * (here + there);
            let found = levels(middle)?;
            tried.push((middle, from_even(&found)));
            match are_outer(&found) == ask_for_wider {
                true => here = middle,
                false => beyond = Some(middle),
            }
        }
        let least = tried.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
        let factor = least.map_or(1.0, |(log_factor, _)| log_factor.exp());
        Ok(Calibration { n_pushes, widened: Some(factor), ..Calibration::default() })
    }

    /// The model whose parameters differ so many times as widely from push to push.
    fn widened(&self, factor: f64) -> Self {
        let mut wider = self.clone();
        for effect in &mut wider.effects {
            let of = [&mut effect.per_push, &mut effect.per_session];
            for spread in of.into_iter().flat_map(|spreads| spreads.values_mut()) {
                let (Spread::Sd(sd) | Spread::RelativeSd(sd)) = spread;
                *sd *= factor;
            }
        }
        wider
    }

    fn built_in(&self, setup: &Setup) -> Result<Box<dyn PushModel>, ModelError> {
        self.build_in(setup.support, &setup.own)
    }
}

impl Calibration {
    /// What no measurement gives, and the key that says it.
    pub(crate) fn problem(&self) -> Option<(&'static str, String)> {
        let (low, high) = (1.0 / MOST_WIDENED, MOST_WIDENED);
        let widened = self.widened.filter(|of| !(low..=high).contains(of));
        let widened = widened.map(|of| format!("must be from {low} to {high}, got {of:?}"));
        widened
            .map(|problem| ("calibration.widened", problem))
            .or_else(|| {
                let is_none = !is_covariance(&self.scatter_per_m?.into());
                let problem = "must be symmetric and positive semi-definite".to_owned();
                is_none.then_some(("calibration.scatter_per_m", problem))
            })
            .or_else(|| self.correlation.as_ref()?.problem())
    }
}

/// The covariance that the steps of pushes show about a model, per meter of way squared; none of no step.
fn scatter_of(
    model: &dyn PushModel,
    pushes: &[RecordedPush],
) -> Result<Option<Matrix3<f64>>, ModelError> {
    let steps: Vec<_> = pushes.iter().flat_map(|push| &push.steps).collect();
    let inputs: Vec<_> = steps.iter().map(|step| step.input.clone()).collect();
    let said = model.predict(&inputs, Noise::Excluded)?;
    let pairs = steps.iter().zip(said);
    let errors: Vec<_> = pairs.map(|(step, said)| step.outputs - said.mean).collect();
    Ok((!errors.is_empty()).then(|| scatter_per_way(steps, &errors, 0)))
}

/// Whether ends are in the outer half of their regions, by the mean of their levels.
fn are_outer(levels: &[f64]) -> bool {
    levels.iter().sum::<f64>() > 0.5 * levels.len() as f64
}

/// Cramér–von Mises distance of numbers from 0 to 1 to even ones.
fn from_even(levels: &[f64]) -> f64 {
    let mut levels = levels.to_vec();
    levels.sort_by(f64::total_cmp);
    let n = levels.len() as f64;
    let off = |(k, level): (usize, &f64)| (level - (k as f64 + 0.5) / n).powi(2);
    levels.iter().enumerate().map(off).sum::<f64>() / n
}

#[cfg(test)]
mod tests {
    use super::{are_outer, from_even};

    #[test]
    fn even_levels_are_nearest_to_even_ones() {
        let even: Vec<f64> = (0..40).map(|k| (f64::from(k) + 0.5) / 40.0).collect();
        let narrow: Vec<f64> = even.iter().map(|level| level.sqrt()).collect();
        let wide: Vec<f64> = even.iter().map(|level| level * level).collect();
        assert!(are_outer(&narrow) && !are_outer(&wide));
        let [even, narrow, wide] = [even, narrow, wide].map(|levels| from_even(&levels));
        assert!(even < 1e-12 && narrow > 0.02 && wide > 0.02, "{narrow} {wide}");
    }
}
