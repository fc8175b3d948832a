//! An effect is found again, with its size, in what it simulated.

use std::sync::Arc;

use effects::{Effect, PushPhysics, StepInput, Surface, tested};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::world::World;

/// What sensors tell of a step, one standard deviation: 30 µm, 0.08°, 50 mN, 0.1 mm.
const SD: [f64; 7] = [3e-5, 3e-5, 1.4e-3, 0.05, 0.05, 1e-4, 1e-4];
/// Noise of the simulation, in these standard deviations: nearly none.
const NOISE: f64 = 1e-3;

struct Problem {
    effect: Arc<dyn Effect>,
    steps: Vec<StepInput>,
    data: DVector<f64>,
}

impl Problem {
    fn new(effect: &Arc<dyn Effect>, seed: u64) -> Self {
        Self::of(effect, World::PLAIN.steps(), seed)
    }

    fn of(effect: &Arc<dyn Effect>, steps: Vec<StepInput>, seed: u64) -> Self {
        let mut problem = Self { effect: effect.clone(), steps, data: DVector::zeros(0) };
        let truth = effect.info().typical(&World::PLAIN.rig(Surface::Ellipsoid));
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        problem.data = problem.model(&effect.info().to_coordinates(&truth));
        problem.data.iter_mut().for_each(|x| *x += NOISE * random.random_range(-1.7..1.7));
        problem
    }

    /// All channels of all steps in standard deviations.
    fn model(&self, coordinates: &[f64]) -> DVector<f64> {
        let values = self.effect.info().from_coordinates(coordinates);
        let rig = World::PLAIN.rig(Surface::Ellipsoid);
        let physics = PushPhysics::new(rig).with(&self.effect, &values).unwrap();
        let channels = physics.predict_all(&self.steps).unwrap();
        let whitened = |channels: &effects::Channels| {
            let array = channels.to_array();
            (0..7).map(move |i| array[i] / SD[i])
        };
        DVector::from_iterator(7 * channels.len(), channels.iter().flat_map(whitened))
    }

    fn misfit(&self, coordinates: &[f64]) -> f64 {
        (&self.data - self.model(coordinates)).norm_squared()
    }

    /// Levenberg–Marquardt from near "off", with differences over `share` of a secant.
    fn fit(&self) -> Vec<f64> {
        let rig = World::PLAIN.rig(Surface::Ellipsoid);
        let list = self.effect.info().coordinates(&rig);
        let mut at: Vec<f64> = list.iter().map(|c| c.off + 0.2 * c.secant).collect();
        let (mut damping, mut misfit) = (1e-3, self.misfit(&at));
        for iteration in 0..60 {
            let here = self.model(&at);
            let share = if iteration < 5 { 0.3 } else { 1e-4 };
            let mut slopes = DMatrix::zeros(here.len(), at.len());
            for (k, coordinate) in list.iter().enumerate() {
                let mut ahead = at.clone();
                let size = share * coordinate.secant;
                let is_outside = ahead[k] + size > coordinate.range.1;
                let share = if is_outside { -share } else { share };
                ahead[k] += share * coordinate.secant;
                slopes.set_column(k, &((self.model(&ahead) - &here) / share));
            }
            let normal = slopes.transpose() * &slopes;
            let slope = slopes.transpose() * (&self.data - &here);
            let mut damped = normal.clone();
            damped.set_diagonal(&normal.diagonal().map(|x| x * (1.0 + damping) + 1e-9));
            let step = damped.cholesky().unwrap().solve(&slope);
            let next: Vec<f64> = (at.iter().zip(&list).zip(step.iter()))
                .map(|((x, c), s)| (x + s * c.secant).clamp(c.range.0, c.range.1))
                .collect();
            let value = self.misfit(&next);
            if value < misfit {
                (at, misfit, damping) = (next, value, 0.1 * damping);
            } else {
                damping *= 10.0;
            }
            if damping > 1e8 {
                break;
            }
        }
        at
    }
}

#[test]
fn an_effect_is_recovered_from_its_own_simulation() {
    let rig = World::PLAIN.rig(Surface::Ellipsoid);
    for (seed, effect) in tested().iter().enumerate() {
        let about = effect.info();
        // A switch and a threshold have no slope: the next test searches for them.
        if ["inertia", "pusher-stiction"].contains(&about.id) {
            continue;
        }
        let problem = Problem::new(effect, seed as u64);
        let truth = about.to_coordinates(&about.typical(&rig));
        let found = problem.fit();
        for ((coordinate, found), truth) in about.coordinates(&rig).iter().zip(&found).zip(&truth) {
            let size = coordinate.prior_sd / 3.0;
            let near = (found - truth).abs() < 0.01 * size;
            assert!(near, "{} {}: {found} for {truth}", about.id, coordinate.name);
        }
    }
}

#[test]
fn a_switch_and_a_threshold_are_recovered_by_search() {
    for (id, truth, n) in [("inertia", 1.0, 2_u32), ("pusher-stiction", 1.3, 41)] {
        let effect = effects::by_id(id).unwrap();
        let mut steps = World::PLAIN.steps();
        // What moves with the pusher is stuck to it: it breaks loose at the threshold.
        for step in &mut steps {
            step.twist_wb.linear = step.track.mean_velocity();
            step.twist_wb.angular = 0.0;
        }
        let problem = Problem::of(effect, steps, 99);
        let (low, high) = effect.info().parameters[0].range;
        let value = |k: u32| low + (high - low) * f64::from(k) / f64::from(n - 1);
        let mut at = effect.info().typical(&World::PLAIN.rig(Surface::Ellipsoid));
        let mut misfit = |k: u32| {
            at[0] = value(k);
            problem.misfit(&at)
        };
        let misfits: Vec<f64> = (0..n).map(&mut misfit).collect();
        let least = misfits.iter().copied().fold(f64::INFINITY, f64::min);
        let best = (0..n).filter(|k| misfits[*k as usize] <= 2.0 * least).map(value);
        let best: Vec<f64> = best.collect();
        let middle = best.iter().sum::<f64>() / best.len() as f64;
        assert!((middle - truth).abs() < 0.1, "{id}: {best:?}");
        assert!(misfits[0] > 1e3 * least, "{id}: {misfits:?}");
    }
}
