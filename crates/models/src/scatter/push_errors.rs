//! A push's errors, each over what its model says of it.

use nalgebra::{Matrix3, Vector3};

use crate::roll_out::settle::gap_slope;
use crate::steps::prediction::root;
use crate::{ModelError, Noise, PushModel, RecordedPush, Slip, StepInput, StepPrediction};

/// The whitened errors of a push's steps, without what contact forbids.
///
/// z = A L⁻¹ (observed − mean) with L Lᵀ the model's covariance of a step, and A = 1 − h hᵀ, h the
/// direction of Lᵀ Hᵀ, H the slope of the gap: a roll-out conditions its draws on the gap, which takes
/// their part along h away. Two free directions are left of three, and what is measured of the errors
/// has to be measured of those.
#[derive(Clone, Debug)]
pub(crate) struct PushErrors {
    pub(crate) errors: Vec<Vector3<f64>>,
    /// The projection A of each step.
    pub(crate) free: Vec<Matrix3<f64>>,
    /// Mean way of the pusher in a step, in m.
    pub(crate) way: f64,
}

impl PushErrors {
    /// # Errors
    /// `NoVariance` for a model that claims none; what the model refuses.
    pub(crate) fn of(model: &dyn PushModel, push: &RecordedPush) -> Result<Self, ModelError> {
        let (n, outline) = (push.steps.len(), model.true_outline(&push.pushed)?);
        let (mut errors, mut free) = (Vec::with_capacity(n), Vec::with_capacity(n));
        let centers = push.path.points().iter().skip(1).map(|(_, center_w)| center_w);
        let ends = push.poses_wb.iter().skip(1).zip(centers);
        for ((step, said), (pose_wb, center_w)) in
            push.steps.iter().zip(said(model, push)?).zip(ends)
        {
            let root = root(&said.covariance);
            let error = root
                .solve_lower_triangular(&(step.outputs - said.mean))
                .ok_or(ModelError::NoVariance { kind: model.kind() })?;
            let along_w = push.poses_wb[errors.len()].rotate(&step.input.direction_b());
            let slope = gap_slope(&outline, pose_wb, center_w, &along_w);
            let held = (root.transpose() * slope.transpose()).normalize();
            let projection = Matrix3::identity() - held * held.transpose();
            errors.push(projection * error);
            free.push(projection);
        }
        let way = push.steps.iter().map(|step| step.input.distance()).sum::<f64>();
        Ok(Self { errors, free, way: way / n.max(1) as f64 })
    }
}

/// What a model says of each step of a push.
fn said(model: &dyn PushModel, push: &RecordedPush) -> Result<Vec<StepPrediction>, ModelError> {
    let inputs: Vec<StepInput> = push.steps.iter().map(|step| step.input.clone()).collect();
    match model.as_mixture() {
        // A step is held against the way that it went: which one is drawn anew every time.
        Some(mixture) => {
            let ways = mixture.ways(&inputs, Noise::Included)?;
            Ok(ways.iter().zip(&push.steps).map(|(said, step)| said.of(Slip::of(step))).collect())
        }
        None => model.predict(&inputs, Noise::Included),
    }
}
