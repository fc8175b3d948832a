//! Measurement updates of Gaussians and mixtures.

use std::f64::consts::PI;

use filter::{
    DifferentiableMeasurement, FilterError, GaussHermite, Gaussian, GaussianMeasurement,
    LinearMeasurement, MeasurementModel, Mixture, ParticleFilter, Rule, Settings, Simplex,
    Unscented,
};
use nalgebra::{DMatrix, DVector, dmatrix, dvector};
use proptest::test_runner::Config;
use proptest::{prop_assert, proptest};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::linear::{T, systems};

fn rules() -> [&'static dyn Rule; 4] {
    [&Simplex, &Unscented, &GaussHermite { order: 2 }, &GaussHermite { order: 4 }]
}

fn gaussian(mean: f64, variance: f64) -> Gaussian {
    Gaussian::new(dvector![mean], dmatrix![variance]).unwrap()
}

proptest! {
    #![proptest_config(Config::with_cases(48))]

    #[test]
    fn every_update_of_a_linear_system_is_what_the_joint_gaussian_says(system in systems()) {
        for rule in std::iter::once(None).chain(rules().map(Some)) {
            let (mut state, mut evidence) = (system.start.clone(), 0.0);
            for k in 0..=T {
                if k > 0 {
                    let moved = match rule {
                        None => state.predicted(&system.motion()).unwrap(),
                        Some(rule) => {
                            let moved = |x: &DVector<f64>| Ok::<_, FilterError>(system.moved(x));
                            state.predicted_by(rule, moved).unwrap()
                        }
                    };
                    state = moved.state().clone();
                }
                let seen = system.measurement(k);
                let update = match rule {
                    None => state.updated(&seen).unwrap(),
                    Some(rule) => state.updated_by(rule, &seen).unwrap(),
                };
                evidence += update.log_evidence;
                state = update.posterior;
                let (mean, covariance, log_density) = system.known(k, k);
                prop_assert!((state.mean() - mean).amax() < 1e-8);
                prop_assert!((state.covariance() - covariance).amax() < 1e-8);
                prop_assert!((evidence - log_density).abs() < 1e-7 * (1.0 + log_density.abs()));
                prop_assert!(*state.covariance() == state.covariance().transpose());
            }
        }
    }

    #[test]
    fn two_measurements_at_once_are_one_after_the_other(system in systems()) {
        let [one, two] = [0, 1].map(|k| system.measurement(k));
        let first = system.start.updated(&one).unwrap();
        let second = first.posterior.updated(&two).unwrap();
        let stacked = |a: &DMatrix<f64>| DMatrix::from_fn(4, 3, |i, j| a[(i % 2, j)]);
        let seen = DVector::from_fn(4, |i, _| system.seen[i / 2][i % 2]);
        let mean = DVector::from_fn(4, |i, _| system.noise.mean()[i % 2]);
        let noise = DMatrix::from_fn(4, 4, |i, j| {
            if i / 2 == j / 2 { system.noise.covariance()[(i % 2, j % 2)] } else { 0.0 }
        });
        let noise = Gaussian::new(mean, noise).unwrap();
        let both = LinearMeasurement::new(seen, stacked(&system.observed), noise).unwrap();
        let both = system.start.updated(&both).unwrap();
        prop_assert!((both.posterior.mean() - second.posterior.mean()).amax() < 1e-9);
        prop_assert!((both.posterior.covariance() - second.posterior.covariance()).amax() < 1e-9);
        let sum = first.log_evidence + second.log_evidence;
        prop_assert!((both.log_evidence - sum).abs() < 1e-8 * (1.0 + sum.abs()));
    }

    #[test]
    fn a_mixture_is_weighed_by_what_it_says_of_the_measurement(system in systems()) {
        let other = Gaussian::new(-system.start.mean(), 2.0 * system.start.covariance()).unwrap();
        let parts = vec![(system.start.clone(), 0.3), (other, 0.7)];
        let seen = system.measurement(0);
        let of_seen = parts.iter().map(|(part, weight)| {
            let mean = &system.observed * part.mean() + system.noise.mean();
            let covariance = &system.observed * part.covariance() * system.observed.transpose();
            let covariance = covariance + system.noise.covariance();
            let covariance = 0.5 * (&covariance + covariance.transpose());
            (Gaussian::new(mean, covariance).unwrap(), *weight)
        });
        let of_seen = Mixture::new(of_seen.collect()).unwrap();
        let mixture = Mixture::new(parts.clone()).unwrap();
        let update = mixture.updated(&seen).unwrap();
        let log_density = of_seen.log_density(&system.seen[0]).unwrap();
        prop_assert!((update.log_evidence - log_density).abs() < 1e-9 * (1.0 + log_density.abs()));
        // Bayes: log prior + log likelihood = log posterior + log evidence, anywhere.
        let at = dvector![0.3, -0.2, 0.4];
        let before = mixture.log_density(&at).unwrap() + seen.log_likelihood(&at);
        let after = update.posterior.log_density(&at).unwrap() + update.log_evidence;
        prop_assert!((before - after).abs() < 1e-7 * (1.0 + before.abs()), "{before} {after}");
        for rule in rules() {
            let by_points = mixture.updated_by(rule, &seen).unwrap();
            prop_assert!((by_points.log_evidence - update.log_evidence).abs() < 1e-7);
        }
    }
}

/// Distance in m and direction in rad of a place, seen from the origin.
struct RangeBearing {
    seen: DVector<f64>,
    noise: Gaussian,
}

impl RangeBearing {
    fn new(range: f64, bearing: f64) -> Self {
        let noise = Gaussian::independent(dvector![0.0, 0.0], &[0.02, 0.03]).unwrap();
        Self { seen: dvector![range, bearing], noise }
    }
}

impl GaussianMeasurement for RangeBearing {
    type State = DVector<f64>;

    fn measured(&self) -> &DVector<f64> {
        &self.seen
    }

    fn noise(&self) -> &Gaussian {
        &self.noise
    }

    fn expected(&self, x: &DVector<f64>) -> Result<DVector<f64>, FilterError> {
        Ok(dvector![x[0].hypot(x[1]), x[1].atan2(x[0])])
    }

    fn angles(&self) -> &[usize] {
        &[1]
    }
}

impl DifferentiableMeasurement for RangeBearing {
    fn jacobian(&self, x: &DVector<f64>) -> Result<DMatrix<f64>, FilterError> {
        let range = x[0].hypot(x[1]);
        let square = range * range;
        Ok(dmatrix![x[0] / range, x[1] / range; -x[1] / square, x[0] / square])
    }
}

#[test]
fn a_bearing_has_no_seam() {
    // The same, turned by half a turn: the seam lies between the states.
    let prior = |sign: f64| {
        let covariance = dmatrix![0.01, 0.004; 0.004, 0.02];
        Gaussian::new(sign * dvector![1.0, 0.01], covariance).unwrap()
    };
    let near = RangeBearing::new(1.05, -0.04);
    let far = RangeBearing::new(1.05, PI - 0.04);
    // A simplex is not the same from the other side.
    let even = rules().into_iter().skip(1);
    let pairs = even.map(|rule| {
        [(1.0, &near), (-1.0, &far)].map(|(sign, z)| prior(sign).updated_by(rule, z).unwrap())
    });
    let extended = [(1.0, &near), (-1.0, &far)].map(|(sign, z)| prior(sign).updated(z).unwrap());
    for [here, there] in pairs.into_iter().chain([extended]) {
        assert!((here.posterior.mean() + there.posterior.mean()).amax() < 1e-12);
        assert!((here.posterior.covariance() - there.posterior.covariance()).amax() < 1e-12);
        assert!((here.log_evidence - there.log_evidence).abs() < 1e-9);
        assert!(here.innovation[1].abs() < 0.1);
    }
    let turned = dmatrix![1.0; 1.0];
    let noise = Gaussian::independent(dvector![0.0, 0.0], &[1.0, 1.0]).unwrap();
    let heading = LinearMeasurement::new(dvector![3.0, 3.0], turned, noise).unwrap();
    let heading = heading.with_angles(&[1]).unwrap();
    let off = gaussian(-3.0, 0.1).updated(&heading).unwrap().innovation;
    assert!((off[0] - 6.0).abs() < 1e-12 && (off[1] - (6.0 - 2.0 * PI)).abs() < 1e-12);
}

#[test]
fn nonlinear_updates_are_near_what_particles_say() {
    let covariance = dmatrix![0.0025, 0.0008; 0.0008, 0.004];
    let prior = Gaussian::new(dvector![0.8, 0.5], covariance).unwrap();
    let seen = RangeBearing::new(1.0, 0.5);
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let cloud = (0..100_000).map(|_| prior.sample(&mut random)).collect();
    let settings = Settings { resample_below: 0.0, ..Settings::default() };
    let mut filter = ParticleFilter::new(cloud, settings).unwrap();
    let evidence = filter.update(&seen).unwrap().log_evidence;
    let weighted = || filter.particles().iter().zip(filter.weights().as_slice());
    let mean = weighted().fold(DVector::zeros(2), |sum, (x, w)| sum + *w * x);
    let squares = weighted().map(|(x, w)| *w * (x - &mean).component_mul(&(x - &mean)));
    let sd = squares.fold(DVector::zeros(2), |sum, x| sum + x).map(f64::sqrt);
    for update in [
        prior.updated(&seen).unwrap(),
        prior.updated_by(&Unscented, &seen).unwrap(),
        prior.updated_by(&GaussHermite { order: 5 }, &seen).unwrap(),
    ] {
        // The line through a curve, not chance, is what differs: a part of the standard deviation.
        let off = (update.posterior.mean() - &mean).component_div(&sd);
        assert!(off.amax() < 0.2, "{off} {update:?}");
        assert!((update.log_evidence - evidence).abs() < 0.1, "{update:?} {evidence}");
        assert!(update.normalized_innovation_squared() < 9.0);
    }
}

/// The square of a number.
struct Square {
    seen: DVector<f64>,
    noise: Gaussian,
}

impl GaussianMeasurement for Square {
    type State = DVector<f64>;

    fn measured(&self) -> &DVector<f64> {
        &self.seen
    }

    fn noise(&self) -> &Gaussian {
        &self.noise
    }

    fn expected(&self, x: &DVector<f64>) -> Result<DVector<f64>, FilterError> {
        if x[0] > 100.0 {
            return Ok(dvector![f64::INFINITY]);
        }
        Ok(x.component_mul(x))
    }
}

#[test]
fn a_square_has_the_moments_known_by_hand() {
    // Of x ~ N(m, P): mean m² + P, variance 2 P² + 4 m² P, covariance with x of 2 m P.
    let (m, p, bias, r, z) = (0.7, 0.2, 0.1, 0.05, 1.3);
    let square = Square { seen: dvector![z], noise: gaussian(bias, r) };
    let (mean, variance, cross) =
        (m * m + p + bias, 2.0 * p * p + 4.0 * m * m * p + r, 2.0 * m * p);
    for rule in [&Unscented as &dyn Rule, &GaussHermite { order: 3 }] {
        let update = gaussian(m, p).updated_by(rule, &square).unwrap();
        assert!((update.innovation[0] - (z - mean)).abs() < 1e-12);
        assert!((update.innovation_covariance[(0, 0)] - variance).abs() < 1e-12);
        let posterior = update.posterior;
        assert!((posterior.mean()[0] - (m + cross / variance * (z - mean))).abs() < 1e-12);
        assert!((posterior.covariance()[(0, 0)] - (p - cross * cross / variance)).abs() < 1e-12);
        let density = gaussian(mean, variance).log_density(&dvector![z]).unwrap();
        assert!((update.log_evidence - density).abs() < 1e-12);
    }
}

#[test]
fn a_measurement_a_trillion_times_better_leaves_a_covariance() {
    let prior = Gaussian::new(dvector![0.0, 0.0], dmatrix![1e6, 9e5; 9e5, 1e6]).unwrap();
    let noise = Gaussian::independent(dvector![0.0], &[1e-6]).unwrap();
    let seen = LinearMeasurement::new(dvector![3.0], dmatrix![1.0, 1.0], noise).unwrap();
    let sum = |state: &Gaussian| {
        let weights = dvector![1.0, 1.0];
        (weights.dot(&(state.covariance() * &weights)), weights.dot(state.mean()))
    };
    let mut state = prior;
    for _ in 0..50 {
        state = state.updated(&seen).unwrap().posterior;
        let (variance, mean) = sum(&state);
        // The variance is 1e-12, where 1e6 is rounded by 1e-10.
        assert!(variance.abs() < 1e-9, "{variance}");
        assert!((mean - 3.0).abs() < 1e-6);
    }
    // Without any noise the state is known.
    let exact = LinearMeasurement::new(dvector![2.0], dmatrix![1.0], gaussian(0.0, 0.0)).unwrap();
    let update = gaussian(0.0, 1.0).updated(&exact).unwrap();
    assert_eq!(update.posterior, gaussian(2.0, 0.0));
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let seen = |value: f64, variance: f64| {
        LinearMeasurement::new(dvector![value], dmatrix![1.0], gaussian(0.0, variance))
    };
    let error = gaussian(0.0, 0.0).updated(&seen(1.0, 0.0).unwrap()).unwrap_err();
    assert!(matches!(error, FilterError::Singular { dimension: 1, .. }), "{error}");
    let error = seen(f64::NAN, 1.0).unwrap_err();
    assert!(error.to_string().contains("a measured value is NaN"), "{error}");
    let wide = Gaussian::independent(dvector![0.0, 0.0], &[1.0, 1.0]).unwrap();
    for rule in rules() {
        let error = wide.updated_by(rule, &seen(1.0, 1.0).unwrap()).unwrap_err();
        assert!(matches!(error, FilterError::ShapeMismatch { expected: 2, actual: 1, .. }));
    }
    let error = wide.updated(&seen(1.0, 1.0).unwrap()).unwrap_err();
    assert!(error.to_string().contains("columns of the measurement's matrix: expected 2, got 1"));
    let error = LinearMeasurement::new(dvector![1.0], dmatrix![1.0], wide.clone()).unwrap_err();
    assert!(matches!(error, FilterError::ShapeMismatch { expected: 1, actual: 2, .. }));
    let error =
        LinearMeasurement::new(dvector![1.0], dmatrix![1.0; 1.0], wide.clone()).unwrap_err();
    assert!(matches!(error, FilterError::ShapeMismatch { expected: 1, actual: 2, .. }));
    let error = seen(1.0, 1.0).unwrap().with_angles(&[1]).unwrap_err();
    assert!(matches!(error, FilterError::OutOfRange { value: 1.0, .. }), "{error}");
    let square = Square { seen: dvector![1.0], noise: gaussian(0.0, 1.0) };
    let error = gaussian(1000.0, 1.0).updated_by(&Unscented, &square).unwrap_err();
    assert!(matches!(error, FilterError::NotFinite { .. }), "{error}");
    let square = Square { seen: dvector![1.0, 2.0], noise: gaussian(0.0, 1.0) };
    let error = gaussian(0.0, 1.0).updated_by(&Unscented, &square).unwrap_err();
    assert!(matches!(error, FilterError::ShapeMismatch { expected: 2, actual: 1, .. }), "{error}");
    assert!(square.log_likelihood(&dvector![0.0]).is_nan());
    let error = Gaussian::independent(dvector![0.0], &[-1.0]).unwrap_err();
    assert!(matches!(error, FilterError::OutOfRange { value: -1.0, .. }), "{error}");
    // A distance of 1e200 standard deviations has no log density.
    let error = gaussian(0.0, 1.0).updated(&seen(1e200, 1.0).unwrap()).unwrap_err();
    assert!(error.to_string().contains("the log evidence of a measurement is -inf"), "{error}");
}
