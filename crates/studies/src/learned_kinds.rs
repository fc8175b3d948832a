//! Every kind of model, with its color and how it is trained where many are.

use anyhow::Result;
use gp_core::LearnOptions;
use models::{
    Analytical, GpPushModel, Hybrid, ModelError, Noise, ProcessKind, PushModel, StepObservation,
    Training, learn_options,
};
use nalgebra::Matrix3;
use report::Color;

/// A kind of model that learns from steps.
#[derive(Clone, Copy)]
pub(crate) struct LearnedKind {
    /// For people.
    pub(crate) name: &'static str,
    pub(crate) color: Color,
    /// Trains one from a nominal analytical model.
    pub(crate) train: Train,
}

/// Trains a model from a nominal one.
type Train = fn(&Analytical, &[StepObservation]) -> Result<Box<dyn PushModel>>;

/// The place of the exact process in [`KINDS`].
pub(crate) const GP: usize = 1;

/// Every kind, the fitted analytical model first.
pub(crate) const KINDS: [LearnedKind; 6] = [
    LearnedKind {
        name: "analytical",
        color: Color::GREEN,
        train: |nominal, steps| Ok(Box::new(fitted(nominal, steps)?)),
    },
    LearnedKind {
        name: "GP",
        color: Color::BLUE,
        train: |_, steps| process(ProcessKind::Gp, steps),
    },
    LearnedKind {
        name: "SPGP",
        color: Color::SKY,
        train: |_, steps| process(ProcessKind::Spgp, steps),
    },
    LearnedKind {
        name: "RFF",
        color: Color::PURPLE,
        train: |_, steps| process(ProcessKind::Rff, steps),
    },
    LearnedKind {
        name: "VHGP",
        color: Color::ORANGE,
        train: |_, steps| process(ProcessKind::Vhgp, steps),
    },
    LearnedKind {
        name: "hybrid",
        color: Color::VERMILION,
        train: |nominal, steps| {
            let training = training(ProcessKind::Gp);
            Ok(Box::new(Hybrid::train(&nominal.describe()?, None, steps, &training)?.0))
        },
    },
];

/// Two starts instead of four, since so many models are learned.
fn training(process: ProcessKind) -> Training {
    let options = LearnOptions { n_starts: 2, ..learn_options() };
    Training { process, ..options.into() }
}

fn process(kind: ProcessKind, steps: &[StepObservation]) -> Result<Box<dyn PushModel>> {
    Ok(Box::new(GpPushModel::train(steps, &training(kind))?.0))
}

/// The fitted model; where the steps do not determine it, the nominal one with its scatter.
fn fitted(nominal: &Analytical, steps: &[StepObservation]) -> Result<Analytical> {
    match nominal.fit(steps) {
        Ok(fit) => return Ok(fit.model),
        Err(ModelError::Undetermined { .. }) => {}
        Err(error) => return Err(error.into()),
    }
    let inputs: Vec<_> = steps.iter().map(|step| step.input.clone()).collect();
    let mut scatter = Matrix3::zeros();
    for (step, said) in steps.iter().zip(nominal.predict(&inputs, Noise::Excluded)?) {
        let off = (step.outputs - said.mean) / step.input.distance();
        scatter += off * off.transpose() / steps.len() as f64;
    }
    Ok(Analytical::new(nominal.pusher_friction().clone(), nominal.length().clone(), scatter)?)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use models::{Analytical, CharacteristicLength, Noise, PushModel, StepInput, StepObservation};
    use nalgebra::Vector3;
    use planar::Shape;

    use super::fitted;

    #[test]
    fn steps_that_do_not_tell_the_friction_still_tell_the_scatter() {
        let nominal = Analytical::nominal(1.0).unwrap();
        let shape = Arc::new(Shape::square(0.09).unwrap());
        let step = |k: usize| {
            let p = 0.3 + 0.02 * k as f64;
            let input = StepInput::on_edge(shape.clone(), 0.005, 1, p, 0.0, 0.004).unwrap();
            let off = if k.is_multiple_of(2) { 1e-4 } else { -1e-4 };
            let outputs = input.outputs(&nominal.motion(&input).unwrap());
            StepObservation { input, outputs: outputs + Vector3::new(off, -off, off) }
        };
        let steps: Vec<_> = (0..20).map(step).collect();
        let model = fitted(&nominal, &steps).unwrap();
        assert_eq!(*model.length(), CharacteristicLength::UniformPressure);
        let input = std::slice::from_ref(&steps[0].input);
        let covariance = model.predict(input, Noise::Included).unwrap()[0].covariance;
        assert!((0..3).all(|k| (covariance[(k, k)].sqrt() / 1e-4 - 1.0).abs() < 1e-9));
    }
}
