//! A push's errors, each over what its model says of it.

use nalgebra::{Matrix3, Vector3};

use crate::scatter::given_draw::GivenDraw;
use crate::scatter::whitened::{Whitened, whitened};
use crate::{ModelError, PushModel, RecordedPush};

/// The whitened errors of a push's steps, without what contact forbids.
///
/// z = A L⁻¹ (observed − mean) with L Lᵀ the model's covariance of a step, and A = 1 − h hᵀ, h the
/// direction of Lᵀ Hᵀ, H the slope of the gap: a roll-out conditions its draws on the gap, which takes
/// their part along h away. Two free directions are left of three, and what is measured of the errors
/// has to be measured of those. Where pushes draw numbers ([`PushModel::n_drawn`]), errors are about the
/// likeliest draw: a roll-out draws once, and what that does to a push is no error of its steps.
#[derive(Clone, Debug)]
pub(crate) struct PushErrors {
    pub(crate) errors: Vec<Vector3<f64>>,
    /// The projection A of each step.
    pub(crate) free: Vec<Matrix3<f64>>,
    /// What the push has drawn, as far as its errors tell.
    pub(crate) drawn: GivenDraw,
    /// Mean way of the pusher in a step, in m.
    pub(crate) way: f64,
}

impl PushErrors {
    /// # Errors
    /// `NoVariance` for a model that claims none; what the model refuses.
    pub(crate) fn of(model: &dyn PushModel, push: &RecordedPush) -> Result<Self, ModelError> {
        let (drawn, numbers) = GivenDraw::of(model, push)?;
        let Whitened { errors, free } = whitened(model, push, &numbers)?;
        let way = push.steps.iter().map(|step| step.input.distance()).sum::<f64>();
        Ok(Self { way: way / errors.len().max(1) as f64, errors, free, drawn })
    }
}
