//! A model that may go several ways: the pusher sticks, or slips to either side.

use nalgebra::{Matrix3, Vector3};
use planar::{Pose, perpendicular};

use crate::learnt::slip_gate::SlipGate;
use crate::steps::prediction::root;
use crate::{
    GpPushModel, ModelError, Noise, SeenSteps, StepFeatures, StepInput, StepObservation,
    StepPrediction, Training,
};

/// How the contact moves along the outline over a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Slip {
    /// By less than a tenth of the pusher's way: the pusher sticks, or rolls.
    Stick,
    /// To the left of the inward normal, towards smaller p.
    Left,
    /// To the right, towards larger p.
    Right,
}

impl Slip {
    /// Every way to go.
    pub const ALL: [Self; 3] = [Self::Stick, Self::Left, Self::Right];
}

/// A Gaussian process of each way that the contact goes, with the probabilities of the ways as learnt
/// functions of (p, β).
///
/// Where steps that begin alike end in different ways, as at a vertex, one Gaussian has to cover both
/// and what is between; a mixture does not. The probability of a way is its share among the training
/// steps near by, with Gaussian weights whose widths leave-one-out chooses, and one step's worth of the
/// overall shares; a table has it, at one cost for any number of steps.
///
/// # Source
/// Jacobs, Jordan, Nowlan & Hinton (1991), Adaptive mixtures of local experts; here with observed
/// modes, so that each expert is learnt by itself.
#[derive(Debug)]
pub struct SlipMixture {
    /// The ways that were seen often enough, each with its process.
    pub(crate) modes: Vec<(Slip, GpPushModel)>,
    gate: SlipGate,
    pub(crate) seen: Option<SeenSteps>,
}

/// What a mixture says of a step: weights that sum to 1, each with its Gaussian.
#[derive(Clone, Debug, PartialEq)]
pub struct SlipPrediction {
    /// The ways.
    pub modes: Vec<(Slip, f64, StepPrediction)>,
}

/// The contact's way over the pusher's below which the pusher sticks.
const STICKS: f64 = 0.1;
/// Fewer steps of a way are counted with those that stick.
const FEWEST: usize = 20;

impl Slip {
    /// Which way the contact went in an observed step.
    pub fn of(step: &StepObservation) -> Self {
        let input = &step.input;
        let along = input.direction_b();
        let position = step.outputs.x * along + step.outputs.y * perpendicular(&along);
        let pose_bb = Pose { position, angle: step.outputs.z };
        let end_b = input.start_b() + input.distance() * along;
        let at = |center_b| input.shape().contact(&center_b, input.pusher_radius());
        let (start, end) = (at(input.start_b()), at(pose_bb.inverse_transform_point(&end_b)));
        let slip = start.tangent().dot(&(end.point - start.point)) / input.distance();
        match slip {
            slip if slip > STICKS => Self::Left,
            slip if slip < -STICKS => Self::Right,
            _ => Self::Stick,
        }
    }
}

impl SlipMixture {
    /// Learns from observed steps.
    ///
    /// # Errors
    /// `TooFewSteps` where no way has 20 steps; as [`GpPushModel::train`].
    pub fn train(steps: &[StepObservation], training: &Training) -> Result<Self, ModelError> {
        let mut ways: Vec<Slip> = steps.iter().map(Slip::of).collect();
        let count = |ways: &[Slip], way: Slip| ways.iter().filter(|own| **own == way).count();
        for rare in [Slip::Left, Slip::Right] {
            if count(&ways, rare) < FEWEST {
                ways.iter_mut().filter(|way| **way == rare).for_each(|way| *way = Slip::Stick);
            }
        }
        if count(&ways, Slip::Stick) < FEWEST {
            // Too few stick: they go with the way that most go.
            let most = [Slip::Left, Slip::Right].into_iter().max_by_key(|way| count(&ways, *way));
            let most = most.unwrap_or(Slip::Stick);
            ways.iter_mut().filter(|way| **way == Slip::Stick).for_each(|way| *way = most);
        }
        let (mut modes, mut known) = (Vec::new(), Vec::new());
        for way in Slip::ALL {
            let own = steps.iter().zip(&ways).filter(|(_, own)| **own == way);
            let own: Vec<StepObservation> = own.map(|(step, _)| step.clone()).collect();
            if own.is_empty() {
                continue;
            }
            if own.len() < FEWEST {
                let (what, actual) = ("a mixture of slipping and sticking", own.len());
                return Err(ModelError::TooFewSteps { what, needed: FEWEST, actual });
            }
            let place = |step: &StepObservation| [step.input.p(), step.input.beta()];
            known.extend(own.iter().map(|step| (place(step), modes.len())));
            modes.push((way, GpPushModel::train(&own, training)?.0));
        }
        if modes.is_empty() {
            let (what, actual) = ("a mixture of slipping and sticking", 0);
            return Err(ModelError::TooFewSteps { what, needed: FEWEST, actual });
        }
        let gate = SlipGate::learn(known, modes.len());
        let inputs: Vec<&StepInput> = steps.iter().map(|step| &step.input).collect();
        let seen = SeenSteps::of(StepFeatures::default(), &inputs)?;
        Ok(Self { modes, gate, seen })
    }

    /// The same mixture with its processes read from tables: see [`GpPushModel::tabulated`].
    ///
    /// # Errors
    /// As [`GpPushModel::tabulated`].
    pub fn tabulated(&self) -> Result<Self, ModelError> {
        let table = |(way, model): &(Slip, GpPushModel)| Ok((*way, model.tabulated()?.0));
        let modes = self.modes.iter().map(table).collect::<Result<_, ModelError>>()?;
        Ok(Self { modes, gate: self.gate.clone(), seen: self.seen.clone() })
    }

    /// A mixture over (Δx, Δy, Δθ) of each step.
    ///
    /// # Errors
    /// As [`crate::PushModel::predict`].
    pub fn ways(
        &self,
        steps: &[StepInput],
        noise: Noise,
    ) -> Result<Vec<SlipPrediction>, ModelError> {
        let said = self.modes.iter().map(|(_, model)| model.processes.predict(steps, noise));
        let said = said.collect::<Result<Vec<_>, _>>()?;
        let prediction = |i: usize| {
            let shares = self.gate.shares([steps[i].p(), steps[i].beta()]);
            let modes = self.modes.iter().zip(&said).zip(shares);
            let modes = modes.map(|(((way, _), said), share)| (*way, share, said[i]));
            SlipPrediction { modes: modes.collect() }
        };
        Ok((0..steps.len()).map(prediction).collect())
    }
}

impl SlipPrediction {
    /// The Gaussian of the way at which a number, even from 0 to 1, arrives when the ways' shares are
    /// laid end to end.
    pub(crate) fn drawn(&self, number: f64) -> StepPrediction {
        let mut left = number;
        let reached = self.modes.iter().find(|(_, share, _)| {
            left -= share;
            left < 0.0
        });
        reached.unwrap_or(&self.modes[self.modes.len() - 1]).2
    }

    /// The Gaussian of the way of most probability.
    pub(crate) fn likeliest(&self) -> StepPrediction {
        let most = self.modes.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        most.unwrap_or(&self.modes[0]).2
    }

    /// The Gaussian of a way, or of the likeliest where that way was never seen.
    pub(crate) fn of(&self, way: Slip) -> StepPrediction {
        let own = self.modes.iter().find(|(own, ..)| *own == way);
        own.map_or_else(|| self.likeliest(), |(_, _, said)| *said)
    }

    /// Log density of observed outputs, in nats of m, m and rad; −∞ without variance.
    pub fn log_density(&self, outputs: &Vector3<f64>) -> f64 {
        let logs =
            self.modes.iter().map(|(_, share, said)| share.ln() + log_density(said, outputs));
        let logs: Vec<f64> = logs.collect();
        let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if largest == f64::NEG_INFINITY {
            return largest;
        }
        largest + logs.iter().map(|log| (log - largest).exp()).sum::<f64>().ln()
    }

    /// The probability that an output is below a value: 0 for Δx, 1 for Δy, 2 for Δθ.
    pub fn probability_below(&self, output: usize, value: f64) -> f64 {
        let below = |said: &StepPrediction| {
            let sd = said.covariance[(output, output)].sqrt();
            0.5 * libm::erfc(-(value - said.mean[output]) / (sd * std::f64::consts::SQRT_2))
        };
        self.modes.iter().map(|(_, share, said)| share * below(said)).sum()
    }

    /// The Gaussian of the same mean and covariance.
    pub fn moments(&self) -> StepPrediction {
        let mean: Vector3<f64> = self.modes.iter().map(|(_, share, said)| *share * said.mean).sum();
        let mut covariance = Matrix3::zeros();
        for (_, share, said) in &self.modes {
            let off = said.mean - mean;
            covariance += *share * (said.covariance + off * off.transpose());
        }
        StepPrediction { mean, covariance }
    }
}

impl From<StepPrediction> for SlipPrediction {
    /// One way only.
    fn from(said: StepPrediction) -> Self {
        Self { modes: vec![(Slip::Stick, 1.0, said)] }
    }
}

fn log_density(said: &StepPrediction, outputs: &Vector3<f64>) -> f64 {
    let root = root(&said.covariance);
    let size: f64 = root.diagonal().iter().product();
    match root.solve_lower_triangular(&(outputs - said.mean)) {
        Some(off) if size > 0.0 => {
            -0.5 * off.norm_squared() - size.ln() - 1.5 * std::f64::consts::TAU.ln()
        }
        _ => f64::NEG_INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::Vector3;
    use planar::Shape;

    use super::{Slip, SlipMixture, SlipPrediction};
    use crate::{
        Analytical, GpPushModel, ModelError, Noise, PushModel, StepInput, StepObservation, Training,
    };

    /// Steps of 4 mm on one face; beyond p = 0.8 every second one slips, the others stick.
    fn steps(n: usize) -> Vec<StepObservation> {
        let shape = Arc::new(Shape::square(0.09).unwrap());
        let sticking = Analytical::nominal(0.9).unwrap();
        let slipping = Analytical::nominal(0.0).unwrap();
        let step = |k: usize| {
            let p = 0.05 + 0.9 * (k as f64 * 0.618).fract();
            let input = StepInput::on_edge(shape.clone(), 0.005, 1, p, 0.5, 0.004).unwrap();
            let model = if p > 0.8 && k.is_multiple_of(2) { &slipping } else { &sticking };
            let one = std::slice::from_ref(&input);
            let noise = 1e-5 * ((k * 7919 % 17) as f64 - 8.0) / 8.0;
            let mean = model.predict(one, Noise::Excluded).unwrap()[0].mean;
            let outputs = mean + Vector3::new(noise, -noise, 30.0 * noise);
            StepObservation { input, outputs }
        };
        (0..n).map(step).collect()
    }

    #[test]
    fn slip_is_told_by_where_the_contact_goes() {
        let shape = Arc::new(Shape::square(0.09).unwrap());
        let way = |friction: f64, beta: f64| {
            let input = StepInput::on_edge(shape.clone(), 0.005, 1, 0.5, beta, 0.004).unwrap();
            let model = Analytical::nominal(friction).unwrap();
            let mean =
                model.predict(std::slice::from_ref(&input), Noise::Excluded).unwrap()[0].mean;
            Slip::of(&StepObservation { input, outputs: mean })
        };
        assert_eq!(
            [way(1.0, 0.3), way(0.0, 0.6), way(0.0, -0.6)],
            [Slip::Stick, Slip::Left, Slip::Right]
        );
    }

    #[test]
    fn a_mixture_is_surer_where_steps_go_two_ways_and_knows_where() {
        let all = steps(600);
        let (train, test) = all.split_at(400);
        let mixture = SlipMixture::train(train, &Training::default()).unwrap();
        let plain = GpPushModel::train(train, &Training::default()).unwrap().0;
        let near: Vec<_> = test.iter().filter(|step| step.input.p() > 0.8).cloned().collect();
        let inputs: Vec<_> = near.iter().map(|step| step.input.clone()).collect();
        let score = |said: Vec<SlipPrediction>| {
            let logs = said.iter().zip(&near).map(|(said, step)| said.log_density(&step.outputs));
            -logs.sum::<f64>() / near.len() as f64
        };
        let of_mixture = score(mixture.ways(&inputs, Noise::Included).unwrap());
        let said = plain.predict(&inputs, Noise::Included).unwrap();
        let of_plain = score(said.into_iter().map(SlipPrediction::from).collect());
        assert!(of_mixture < of_plain - 1.0, "{of_mixture} {of_plain}");
        let at = |p: f64| {
            let shape = train[0].input.shared_shape().clone();
            let input = StepInput::on_edge(shape, 0.005, 1, p, 0.5, 0.004).unwrap();
            let said = mixture.ways(&[input], Noise::Included).unwrap();
            let slips = said[0].modes.iter().filter(|(way, ..)| *way != Slip::Stick);
            slips.map(|(_, share, _)| share).sum::<f64>()
        };
        assert!(at(0.3) < 0.05 && (0.3..0.7).contains(&at(0.9)), "{} {}", at(0.3), at(0.9));
    }

    #[test]
    fn probabilities_and_moments_are_those_of_the_parts() {
        let all = steps(200);
        let mixture = SlipMixture::train(&all, &Training::default()).unwrap();
        let input = all.iter().find(|step| step.input.p() > 0.9).unwrap().input.clone();
        let said = mixture.ways(&[input], Noise::Included).unwrap().remove(0);
        let sum: f64 = said.modes.iter().map(|(_, share, _)| share).sum();
        assert!((sum - 1.0).abs() < 1e-12);
        let moments = said.moments();
        let one = SlipPrediction::from(moments);
        assert!((one.probability_below(1, moments.mean.y) - 0.5).abs() < 1e-12);
        for (output, far) in [(0, 1.0), (1, 1.0), (2, 10.0)] {
            assert!(said.probability_below(output, -far) < 1e-9);
            assert!(said.probability_below(output, far) > 1.0 - 1e-9);
        }
        // By quadrature over Δy.
        let (low, width) = (moments.mean.y - 0.004, 0.008 / 4000.0);
        let edge = |k: usize| low + width * k as f64;
        let mean: f64 = (0..4000)
            .map(|k| {
                let mass =
                    said.probability_below(1, edge(k + 1)) - said.probability_below(1, edge(k));
                mass * (edge(k) + 0.5 * width)
            })
            .sum();
        assert!((mean - moments.mean.y).abs() < 1e-6, "{mean} {}", moments.mean.y);
    }

    #[test]
    fn too_few_steps_are_refused() {
        let error = SlipMixture::train(&steps(10), &Training::default()).unwrap_err();
        assert!(matches!(error, ModelError::TooFewSteps { needed: 20, actual: 10, .. }), "{error}");
    }
}
