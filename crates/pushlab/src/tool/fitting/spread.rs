//! By how much an effect differs from push to push and from place to place, and the scatter that is left.

use anyhow::Result;
use diagnosis::{FitSettings, MotionErrors, SpreadFit, fit_per_push};
use effects::by_id;
use models::{Analytical, Base, Description, ModelFile};
use nalgebra::Matrix3;

use super::Fitting;

impl Fitting {
    /// The fit of an effect that differs, with its values and the scatter that is left beside it.
    ///
    /// # Errors
    /// What the fit says.
    pub(crate) fn per_push(&self, model: &ModelFile, effect: &str) -> Result<SpreadFit> {
        self.testable(by_id(effect)?.info())?;
        let settings = FitSettings { resemblances: false, ..self.settings() };
        let mut found = fit_per_push(&self.train, &model.description, effect, &settings)?;
        // The covariance of the errors of a step over the mean square of its way.
        let ways = self.train.steps().iter().map(|step| {
            let track = &step.input.track;
            (track.end() - track.start()).norm_squared()
        });
        let square = ways.sum::<f64>() / self.train.n_steps().max(1) as f64;
        for model in [&mut found.fit.description, &mut found.fit.with_nuisances] {
            renew_scatter(model, &found.errors, square)?;
        }
        Ok(found)
    }
}

/// Puts what a spread leaves in the place of the scatter that the base has from an earlier fit, which holds
/// what differs from push to push, too; a base without scatter stays so.
fn renew_scatter(model: &mut Description, errors: &MotionErrors, square_way: f64) -> Result<()> {
    let Base::Analytical(base) = &model.base else { return Ok(()) };
    if *base.scatter() == Matrix3::zeros() || square_way <= 0.0 {
        return Ok(());
    }
    let scatter = errors.of_step() / square_way;
    let renewed = Analytical::new(base.pusher_friction().clone(), base.length().clone(), scatter)?;
    model.base = Base::Analytical(renewed.with_surface(base.surface())?);
    Ok(())
}
