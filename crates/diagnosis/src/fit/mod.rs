//! A model with free parameters and observed steps go in, the fitted model comes out, with
//! intervals.

mod borne;
mod descent;
mod equations;
mod estimates;
mod field;
mod fitted_model;
mod free_spread;
mod gathered;
mod left_out;
mod member;
mod motion_errors;
mod nearby;
mod parted;
mod per_push;
mod problem;
mod pulls;
mod refit;
mod resemblance;
mod robust;
mod sandwich;
mod search;
mod session_share;
mod space;
mod stairs;
mod supports;
mod thresholds;
mod trial;

use std::sync::Arc;

use effects::Effect;
use models::{Cluster, Description};
use nalgebra::DMatrix;
use serde::Serialize;

pub use self::equations::NormalEquations;
pub use self::field::{FieldRegion, FrictionFieldFit};
pub use self::gathered::{PartedEffect, PartedEstimate, PartedFit};
pub use self::motion_errors::MotionErrors;
pub use self::parted::FitPlace;
pub use self::per_push::{SpreadFit, fit_per_push};
pub(crate) use self::pulls::Pulls;
pub(crate) use self::refit::Refit;
pub use self::resemblance::Resemblance;
pub(crate) use self::robust::Robust;
pub(crate) use self::thresholds::N_LIMITS;
pub(crate) use self::trial::Trial;

use self::estimates::estimates;
use self::problem::Problem;
use self::space::Space;
use crate::cut_offs::NAME;
use crate::{DiagnosisError, NoiseModel, Observations, Tolerances, Undetermined, Whitening};

/// What a fit moves beside what it is asked for, and what it tells.
#[derive(Clone, Debug)]
pub struct FitSettings {
    /// Effects besides those of the catalogue.
    pub own: Vec<Arc<dyn Effect>>,
    /// How exactly the nominal values are known: they are nuisances of every fit.
    pub tolerances: Tolerances,
    /// Whether standard errors in the model are priors: right where they come from other
    /// recordings. Without, what has one is fitted anew.
    pub priors: bool,
    /// Whether it is told what fitted effects could be taken for.
    pub resemblances: bool,
    /// On how many points the object may rest, and what is known of them.
    pub points: SupportPointsFit,
}

/// What a fit of `support-points` takes as known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SupportPointsFit {
    /// How many points there are, 3 to 6.
    pub n: usize,
    /// Whether the weight is shared so that the object does not tip: Σ share · place is its center of mass, as
    /// of a rigid object that is pushed near the table.
    pub by_statics: bool,
}

impl Default for SupportPointsFit {
    fn default() -> Self {
        Self { n: 4, by_statics: false }
    }
}

impl Default for FitSettings {
    fn default() -> Self {
        Self {
            own: Vec::new(),
            tolerances: Tolerances::default(),
            priors: true,
            resemblances: true,
            points: SupportPointsFit::default(),
        }
    }
}

/// A fitted model, and what the fit leaves open.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The model with the effects asked for, and those that it carried with standard errors, at
    /// their estimates. A pusher friction that was no effect before is in the base.
    pub description: Description,
    /// The same with the nuisances at theirs.
    pub with_nuisances: Description,
    /// The effects asked for, in the order in which they act.
    pub effects: Vec<EffectFit>,
    /// The nuisances.
    pub nuisances: Vec<NuisanceFit>,
    /// Of a field of friction that was asked for: where the pushes tell it.
    pub field: Option<FrictionFieldFit>,
    /// Names of the numbers that were moved, such as `table-tilt ax`.
    pub coordinates: Vec<String>,
    /// Their covariance, by the scatter of whole clusters.
    pub covariance: DMatrix<f64>,
    /// What was taken as a whole.
    pub cluster: Cluster,
    /// How many clusters there are.
    pub n_clusters: usize,
    /// Pushes fitted to.
    pub n_pushes: usize,
    /// Steps fitted to.
    pub n_steps: usize,
    /// Root mean square of the whitened residuals, without what was asked for and with it, both
    /// with fitted nuisances; 1 for a model that misses nothing.
    pub whitened_rms: [f64; 2],
    /// Typical whitened residual of a push, at least 1: numbers beyond three times it, and pushes,
    /// have a smaller weight.
    pub scale: f64,
    /// Iterations of the last descent.
    pub iterations: usize,
    /// Squared distance from the minimum in standard errors, as far as known.
    pub decrement: f64,
}

/// The estimate of an effect.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EffectFit {
    /// Its id.
    pub id: &'static str,
    /// Its parameters, as people read them.
    pub parameters: Vec<ParameterFit>,
    /// What follows from them: of an effect that says where the object rests, the center of friction
    /// and the mean distance c of the pressure from it ([`effects::SupportSummary`]).
    pub follows: Vec<ParameterFit>,
    /// Probability, were the effect not there, of an estimate as far from "off".
    pub p: f64,
    /// What it could be taken for in these data.
    pub resemblances: Vec<Resemblance>,
    /// Why the data do not determine it, if they do not.
    pub undetermined: Option<Undetermined>,
}

/// The estimate of a parameter, in its SI unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterFit {
    /// Its name.
    pub name: &'static str,
    /// Its SI unit.
    pub unit: &'static str,
    /// Its value when the effect is not there; none where that is not defined.
    pub off: Option<f64>,
    /// The estimate.
    pub value: f64,
    /// Its standard error, from whole clusters; 0 for a switch.
    pub se: f64,
    /// Its 95 % interval, by the standard error and Student's t; none of a number without standard error, where the
    /// data do not show the effect, and of one with a direction that may be chance.
    pub interval: Option<Interval>,
}

/// A 95 % interval in the unit of its number, within what that may be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Lower end; of a direction perhaps below 0.
    pub low95: f64,
    /// Upper end; of a direction perhaps above π.
    pub high95: f64,
}

/// The estimate of a nominal number that was left open.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NuisanceFit {
    /// Id of the effect.
    pub id: &'static str,
    /// Its parameter.
    pub name: &'static str,
    /// Its SI unit.
    pub unit: &'static str,
    /// What it was taken to be.
    pub nominal: f64,
    /// Its standard error beforehand; none where it was left open.
    pub tolerance: Option<f64>,
    /// The estimate.
    pub value: f64,
    /// Its standard error.
    pub se: f64,
}

/// Fits effects and nominal parameters of an analytical model to observed steps.
///
/// `free` are ids of effects: those that the model carries start from its values, others from
/// "off" and from typical sizes; `pusher-friction`, `pressure-radius` and `support-friction` are
/// the nominal parameters. A switch such as `inertia` is set to 1 and tested against 0.
///
/// Minimises the squares of whitened residuals and of priors by Levenberg and Marquardt's method,
/// with slopes by secants. Numbers and pushes beyond three standard deviations lose weight.
/// Standard errors are a jackknife over clusters, and know that models of rigs are true within 1 % of
/// a size.
/// The result does not depend on the order of effects and, beyond rounding, of pushes, nor on the
/// number of threads.
///
/// # Errors
/// `Model` for what the model refuses; `NotConverged`; `Flat` for numbers that change nothing and
/// have no prior; `OneCluster` for those that one push or session alone determines.
pub fn fit(
    observations: &Observations,
    model: &Description,
    free: &[&str],
    whitening: &Whitening,
    settings: &FitSettings,
) -> Result<Fit, DiagnosisError> {
    fit_near(observations, model, free, whitening, settings, None)
}

/// The same, where what says where the object rests starts from another model.
fn fit_near(
    observations: &Observations,
    model: &Description,
    free: &[&str],
    whitening: &Whitening,
    settings: &FitSettings,
    near: Option<&Description>,
) -> Result<Fit, DiagnosisError> {
    let mut space = Space::new(observations, model, free, settings, near)?;
    let rows = whitening.rows();
    let start = space.place(|member| member.start.clone());
    let robust = Robust::at(&rows, &whitening.whiten_residuals(&space.residuals(&start)?));
    space.hold_against(robust.scale());
    let mut problem = Problem::new(space, whitening, robust);
    let found = problem.search()?;
    estimates(&problem, &found, observations, model, settings)
}

/// The same with the covariance of a noise model: linearised about the model, and once more about
/// what was fitted with it, for pushes at the edge of sliding change sides.
///
/// # Errors
/// As [`fit`].
pub fn fit_with_noise(
    observations: &Observations,
    model: &Description,
    free: &[&str],
    noise: &NoiseModel,
    settings: &FitSettings,
) -> Result<Fit, DiagnosisError> {
    let whitening = |model| noise.whitening(model, &settings.own, observations);
    let first = FitSettings { resemblances: false, ..settings.clone() };
    let first = fit(observations, model, free, &whitening(model)?, &first)?;
    let (whitening, near) = (whitening(&first.with_nuisances)?, Some(&first.description));
    fit_near(observations, model, free, &whitening, settings, near)
}

impl Fit {
    /// Refuses an effect that the data do not determine.
    ///
    /// # Errors
    /// `Undetermined` with the reason and what to do.
    pub fn determined(self) -> Result<Self, DiagnosisError> {
        let open = self.effects.iter().find_map(|e| Some((e.id, e.undetermined.clone()?)));
        match open {
            Some((effect, why)) => Err(DiagnosisError::Undetermined { effect, why }),
            None => Ok(self),
        }
    }

    /// Refuses, besides, an effect that the data do not tell from nothing, at a probability of 0.01.
    ///
    /// # Errors
    /// `Undetermined` with the reason and what to do.
    pub fn distinct(self) -> Result<Self, DiagnosisError> {
        let is_seen = |effect: &&EffectFit| {
            !matches!(
                effect.undetermined,
                Some(Undetermined::NoChannel { .. } | Undetermined::Invisible)
            )
        };
        let nothing = self.effects.iter().filter(is_seen).find(|effect| effect.p > NAME);
        match nothing {
            Some(EffectFit { id, p, .. }) => {
                let why = Undetermined::NotDistinct { p: *p };
                Err(DiagnosisError::Undetermined { effect: id, why })
            }
            None => self.determined(),
        }
    }
}
