//! The errors of a push's steps, by what its model says of them if it has drawn certain numbers.

use nalgebra::{Matrix3, Vector3};

use crate::roll_out::settle::gap_slope;
use crate::steps::prediction::root;
use crate::{ModelError, Noise, PushModel, RecordedPush, Slip, StepInput, StepPrediction};

/// The whitened errors of a push's steps, and the projection of each.
pub(super) struct Whitened {
    pub(super) errors: Vec<Vector3<f64>>,
    pub(super) free: Vec<Matrix3<f64>>,
}

/// The errors of a push that has drawn such numbers.
///
/// # Errors
/// `NoVariance` for a model that claims none; what the model refuses.
pub(super) fn whitened(
    model: &dyn PushModel,
    push: &RecordedPush,
    numbers: &[f64],
) -> Result<Whitened, ModelError> {
    let outline = model.true_outline(&push.pushed)?;
    let (mut errors, mut free) = (Vec::new(), Vec::new());
    let centers = push.path.points().iter().skip(1).map(|(_, center_w)| center_w);
    let ends = push.poses_wb.iter().skip(1).zip(centers);
    let said = said(model, push, numbers)?;
    for ((step, said), (pose_wb, center_w)) in push.steps.iter().zip(said).zip(ends) {
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
    Ok(Whitened { errors, free })
}

/// What a model says of each step of a push that has drawn such numbers.
fn said(
    model: &dyn PushModel,
    push: &RecordedPush,
    numbers: &[f64],
) -> Result<Vec<StepPrediction>, ModelError> {
    let inputs: Vec<StepInput> = push.steps.iter().map(|step| step.input.clone()).collect();
    match model.as_mixture() {
        // A step is held against the way that it went: which one is drawn anew every time.
        Some(mixture) => {
            let ways = mixture.ways(&inputs, Noise::Included)?;
            Ok(ways.iter().zip(&push.steps).map(|(said, step)| said.of(Slip::of(step))).collect())
        }
        None if numbers.is_empty() => model.predict(&inputs, Noise::Included),
        None => model.predict_drawn(&inputs, &vec![numbers; inputs.len()], Noise::Included),
    }
}
