//! Smoothers against the joint Gaussian of all states and measurements.

use std::convert::Infallible;

use filter::{
    FilterError, GaussHermite, Gaussian, LinearMeasurement, LinearMotion, MotionDensity,
    MotionModel, ParticleFilter, ParticleHistory, Prediction, Rule, Settings, Unscented,
    rauch_tung_striebel,
};
use nalgebra::{DVector, dmatrix, dvector};
use proptest::test_runner::Config;
use proptest::{prop_assert, proptest};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::linear::{System, T, systems};

fn filtered(system: &System, rule: Option<&dyn Rule>) -> (Vec<Prediction>, Gaussian) {
    let mut state = system.start.updated(&system.measurement(0)).unwrap().posterior;
    let mut predictions = Vec::new();
    for k in 1..=T {
        let moved = |x: &DVector<f64>| Ok::<_, FilterError>(system.moved(x));
        let prediction = match rule {
            None => state.predicted(&system.motion()).unwrap(),
            Some(rule) => state.predicted_by(rule, moved).unwrap(),
        };
        state = prediction.state().updated(&system.measurement(k)).unwrap().posterior;
        predictions.push(prediction);
    }
    (predictions, state)
}

proptest! {
    #![proptest_config(Config::with_cases(48))]

    #[test]
    fn smoothed_states_are_what_the_joint_gaussian_says(system in systems()) {
        for rule in [None, Some(&Unscented as &dyn Rule), Some(&GaussHermite { order: 3 })] {
            let (predictions, last) = filtered(&system, rule);
            let smoothed = rauch_tung_striebel(&predictions, &last).unwrap();
            prop_assert!(smoothed.len() == T + 1);
            for (k, state) in smoothed.iter().enumerate() {
                let (mean, covariance, _) = system.known(k, T);
                prop_assert!((state.mean() - mean).amax() < 1e-6, "{k}");
                prop_assert!((state.covariance() - covariance).amax() < 1e-6, "{k}");
                prop_assert!(*state.covariance() == state.covariance().transpose());
            }
        }
    }

    #[test]
    fn what_is_not_known_later_changes_nothing_earlier(system in systems()) {
        let (predictions, _) = filtered(&system, None);
        for prediction in predictions {
            let same = prediction.smoothed(prediction.state()).unwrap();
            prop_assert!((same.mean() - prediction.earlier().mean()).amax() < 1e-12);
            let off = (same.covariance() - prediction.earlier().covariance()).amax();
            prop_assert!(off < 1e-9, "{off}");
        }
    }
}

const MOTION_SD: f64 = 0.4;
const SENSOR_SD: f64 = 0.5;
const SEEN: [f64; 5] = [0.1, 1.4, 0.2, 1.6, 1.2];

struct Walk;

impl MotionModel for Walk {
    type State = DVector<f64>;
    type Error = Infallible;

    fn advance(&self, states: &mut [DVector<f64>], random: &mut dyn Rng) -> Result<(), Infallible> {
        let mut draw = || random.sample::<f64, _>(StandardNormal);
        states.iter_mut().for_each(|x| x[0] += MOTION_SD * draw());
        Ok(())
    }
}

impl MotionDensity for Walk {
    fn log_density(&self, from: &DVector<f64>, to: &DVector<f64>) -> f64 {
        -0.5 * ((to[0] - from[0]) / MOTION_SD).powi(2)
    }
}

fn seen(value: f64) -> LinearMeasurement {
    let noise = Gaussian::independent(dvector![0.0], &[SENSOR_SD]).unwrap();
    LinearMeasurement::new(dvector![value], dmatrix![1.0], noise).unwrap()
}

fn history(n: usize) -> ParticleHistory<DVector<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let start = Gaussian::independent(dvector![0.0], &[1.0]).unwrap();
    let start = (0..n).map(|_| start.sample(&mut random)).collect();
    let mut filter = ParticleFilter::new(start, Settings::default()).unwrap();
    let mut history = ParticleHistory::default();
    for (k, value) in SEEN.into_iter().enumerate() {
        if k > 0 {
            filter.predict(&Walk).unwrap();
        }
        filter.update(&seen(value)).unwrap();
        history.record(&filter);
    }
    history
}

#[test]
fn trajectories_have_the_moments_of_the_smoothed_states() {
    let mut state = Gaussian::independent(dvector![0.0], &[1.0]).unwrap();
    let added = Gaussian::independent(dvector![0.0], &[MOTION_SD]).unwrap();
    let motion = LinearMotion::new(dmatrix![1.0], added).unwrap();
    let mut predictions = Vec::new();
    for (k, value) in SEEN.into_iter().enumerate() {
        if k > 0 {
            let prediction = state.predicted(&motion).unwrap();
            state = prediction.state().clone();
            predictions.push(prediction);
        }
        state = state.updated(&seen(value)).unwrap().posterior;
    }
    let smoothed = rauch_tung_striebel(&predictions, &state).unwrap();
    let n = 4000;
    let trajectories = history(n).trajectories(|_| &Walk, n, 7).unwrap();
    let count = n as f64;
    let [mut last_mean, mut lag] = [0.0; 2];
    for (k, state) in smoothed.iter().enumerate() {
        let mean = trajectories.iter().map(|path| path[k][0]).sum::<f64>() / count;
        let off = |path: &Vec<DVector<f64>>| path[k][0] - mean;
        let variance = trajectories.iter().map(|path| off(path).powi(2)).sum::<f64>() / count;
        let truth = state.covariance()[(0, 0)];
        // Five standard errors of as many independent draws, twice: particles and trajectories.
        let tolerance = 5.0 * (2.0 / count).sqrt();
        assert!((mean - state.mean()[0]).abs() < tolerance * truth.sqrt(), "{k}: {mean}");
        assert!((variance / truth - 1.0).abs() < tolerance * 2.0_f64.sqrt(), "{k}: {variance}");
        if k == 1 {
            let products = trajectories.iter().map(|path| (path[0][0] - last_mean) * off(path));
            lag = products.sum::<f64>() / count;
        }
        last_mean = mean;
    }
    // Cov(x₀, x₁ | all) = G P₁ˢ with the smoother's gain G = P₀ / (P₀ + Q).
    let first = predictions[0].earlier().covariance()[(0, 0)];
    let expected = first / (first + MOTION_SD * MOTION_SD) * smoothed[1].covariance()[(0, 0)];
    assert!((lag / expected - 1.0).abs() < 0.2, "{lag} {expected}");
}

#[test]
fn trajectories_are_the_same_for_any_number_of_threads() {
    let history = history(300);
    assert_eq!((history.len(), history.is_empty()), (SEEN.len(), false));
    let run = |n_threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        pool.install(|| history.trajectories(|_| &Walk, 50, 3).unwrap())
    };
    assert_eq!(run(1), run(4));
}

/// A motion of which nothing is possible, or of which the density is no number.
struct Stuck(f64);

impl MotionModel for Stuck {
    type State = DVector<f64>;
    type Error = Infallible;

    fn advance(&self, _: &mut [DVector<f64>], _: &mut dyn Rng) -> Result<(), Infallible> {
        Ok(())
    }
}

impl MotionDensity for Stuck {
    fn log_density(&self, _: &DVector<f64>, _: &DVector<f64>) -> f64 {
        self.0
    }
}

#[test]
fn what_cannot_be_smoothed_is_refused_with_its_step() {
    let empty = ParticleHistory::<DVector<f64>>::default();
    let error = empty.trajectories(|_| &Walk, 1, 7).unwrap_err();
    assert!(matches!(error, FilterError::Empty { what: "steps" }));
    let history = history(50);
    let error = history.trajectories(|_| &Stuck(f64::NEG_INFINITY), 3, 7).unwrap_err();
    assert!(matches!(error, FilterError::Collapsed { step: 3, n_particles: 50 }), "{error}");
    let error = history.trajectories(|_| &Stuck(f64::NAN), 3, 7).unwrap_err();
    assert!(matches!(error, FilterError::NotANumber { step: 3, particle: 0, .. }), "{error}");
    let state = Gaussian::independent(dvector![0.0], &[1.0]).unwrap();
    let wide = Gaussian::independent(dvector![0.0, 0.0], &[1.0, 1.0]).unwrap();
    let motion = LinearMotion::new(dmatrix![1.0], state.clone()).unwrap();
    let error = wide.predicted(&motion).unwrap_err();
    assert!(matches!(error, FilterError::ShapeMismatch { expected: 2, actual: 1, .. }));
    let error = state.predicted(&motion).unwrap().smoothed(&wide).unwrap_err();
    assert!(matches!(error, FilterError::ShapeMismatch { expected: 1, actual: 2, .. }));
    let error = LinearMotion::new(dmatrix![1.0], wide.clone()).unwrap_err();
    assert!(matches!(error, FilterError::ShapeMismatch { expected: 2, actual: 1, .. }));
    let error = LinearMotion::new(dmatrix![f64::NAN], state.clone()).unwrap_err();
    assert!(matches!(error, FilterError::NotFinite { .. }), "{error}");
    let unlike = |x: &DVector<f64>| {
        Ok::<_, FilterError>(if x[0] > 0.0 { wide.clone() } else { state.clone() })
    };
    let error = state.predicted_by(&Unscented, unlike).unwrap_err();
    assert!(matches!(error, FilterError::ShapeMismatch { .. }), "{error}");
}
