//! Numbers that fill an interval or scatter, and how near a model is to known steps.

use models::{Noise, PushModel, StepInput, StepObservation};

/// The k-th point of a low-discrepancy sequence on the unit interval, for a root of a small degree.
pub(crate) fn spread(k: usize, ratio: f64) -> f64 {
    (0.5 + k as f64 * ratio).fract()
}

/// Sum of twelve uniform numbers less six: mean 0, variance 1 and close to normal.
pub(crate) fn unit_noise(k: usize, output: usize) -> f64 {
    let uniform = |i: usize| {
        let mut z = ((36 * k + 12 * output + i) as u64).wrapping_add(0x9e37_79b9_7f4a_7c15);
        for shift in [30, 27, 31] {
            z = (z ^ (z >> shift)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        }
        (z >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..12).map(uniform).sum::<f64>() - 6.0
}

pub(crate) fn inputs(steps: &[StepObservation]) -> Vec<StepInput> {
    steps.iter().map(|step| step.input.clone()).collect()
}

/// Mean over outputs of squared error over variance.
pub(crate) fn nmse(model: &dyn PushModel, steps: &[StepObservation]) -> f64 {
    let predictions = model.predict(&inputs(steps), Noise::Excluded).unwrap();
    let score = |k: usize| {
        let y: Vec<f64> = steps.iter().map(|step| step.outputs[k]).collect();
        let mean: Vec<f64> = predictions.iter().map(|prediction| prediction.mean[k]).collect();
        gp_core::scores::nmse(&y, &mean).unwrap()
    };
    (0..3).map(score).sum::<f64>() / 3.0
}
