//! What is measured on all of the set beside the best model, which is linearised there once.

use super::MotionError;
use super::found::Found;
use super::phase::DiagnosePhase;
use super::push_scatter::{PushScatter, push_scatter};
use super::search::Search;
use crate::predict::tangent::Tangent;
use crate::remains::{Beside, remains};
use crate::screen::untestable::Reason;
use crate::{DiagnosisError, NoiseFloor, Remains};

/// What is measured beside the best model.
pub(super) struct BesideBest {
    /// How much pushes differ that are alike, in units of the sensors.
    pub(super) floor: MotionError,
    /// What of the rig the error comes from that is left.
    pub(super) remains: Option<Remains>,
    /// What becomes of the model's effects beside free components of their origins.
    pub(super) besides: Vec<Beside>,
    /// By how much what moves the object differs from push to push.
    pub(super) push_to_push: Vec<PushScatter>,
}

impl Search<'_> {
    /// Measures what is left beside the best model, and how pushes differ there.
    ///
    /// # Errors
    /// `Model` for what the model refuses; `NotACovariance`.
    pub(super) fn beside_best(&self, found: &Found) -> Result<BesideBest, DiagnosisError> {
        let (best, all, settings) = (&found.with_nuisances, self.all, self.settings);
        let tangent = Tangent::of_all(best, &settings.own, all)?;
        let floor = NoiseFloor::at(&tangent, best, &settings.own, all)?;
        let rms = |number: usize| floor.numbers[number].map(|floor| floor.rms);
        let floor = MotionError::of(std::array::from_fn(rms));
        let untested = |id: &str| {
            let mut effects = found.last_screen.effects.iter().filter(|one| one.id == id);
            effects.find_map(|one| one.not_testable.as_ref()).map(|why| why.reason)
        };
        let is_testable = |id: &str| untested(id) != Some(Reason::NoCovariate);
        let noise = (&found.noise, found.at);
        let remains = remains((&tangent, best), all, noise, is_testable, &settings.remain())?;
        self.tell(DiagnosePhase::Scatter);
        let push_to_push = push_scatter((&tangent, best), all, settings)?;
        let (remains, besides) = remains.map_or((None, Vec::new()), |(all, own)| (Some(all), own));
        Ok(BesideBest { floor, remains, besides, push_to_push })
    }
}
