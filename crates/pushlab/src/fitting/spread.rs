//! The values of an effect that differs from push to push, and the scatter that is left beside it.

use anyhow::Result;
use diagnosis::{Fit, FitSettings, Intervals, MotionErrors, NoiseModel, SpreadFit, fit};
use models::{Analytical, Base, Description, ModelFile};
use nalgebra::Matrix3;

use super::Fitting;

impl Fitting {
    /// The fit of an effect's values beside the spread that was found: motions are weighted by the spread and
    /// by the errors that it leaves.
    ///
    /// # Errors
    /// What the fit says.
    pub(crate) fn beside_spread(
        &self,
        model: &ModelFile,
        effect: &str,
        found: &SpreadFit,
    ) -> Result<Fit> {
        let settings =
            FitSettings { intervals: Intervals::None, resemblances: false, ..self.settings() };
        let (model, own) = (&model.description, &settings.own);
        let noise = NoiseModel::learn(model, own, &self.train)?;
        let noise = noise.whitening(model, own, &self.train)?;
        let whitening = found.errors.whitening(&noise, &self.train, model, own)?;
        let mut fit = fit(&self.train, model, &[effect], &whitening, &settings)?;
        // The covariance of the errors of a step over the mean square of its way.
        let ways = self.train.steps().iter().map(|step| {
            let track = &step.input.track;
            (track.end() - track.start()).norm_squared()
        });
        let square = ways.sum::<f64>() / self.train.n_steps().max(1) as f64;
        renew_scatter(&mut fit.description, &found.errors, square)?;
        Ok(fit)
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
