//! The particle filter against the Kalman filter, and its other laws.

use std::convert::Infallible;

use filter::{
    DrawnMotion, FilterError, MeasurementModel, MotionModel, Multinomial, ParticleFilter,
    PlanarSummary, Residual, Settings, Stratified, Systematic, Weights,
};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

const DRIFT: f64 = 0.3;
const MOTION_SD: f64 = 0.4;
const SENSOR_SD: f64 = 0.5;

struct Walk;

impl MotionModel for Walk {
    type State = f64;
    type Error = Infallible;

    fn advance(&self, states: &mut [f64], random: &mut dyn Rng) -> Result<(), Infallible> {
        let mut draw = || random.sample::<f64, _>(StandardNormal);
        states.iter_mut().for_each(|x| *x += DRIFT + MOTION_SD * draw());
        Ok(())
    }
}

impl DrawnMotion for Walk {
    fn advance_with_density(
        &self,
        states: &mut [f64],
        log_densities: &mut [f64],
        random: &mut dyn Rng,
    ) -> Result<(), Infallible> {
        for (x, log_density) in states.iter_mut().zip(log_densities) {
            let draw: f64 = random.sample(StandardNormal);
            *x += DRIFT + MOTION_SD * draw;
            *log_density = -0.5 * draw * draw;
        }
        Ok(())
    }
}

struct Seen(f64);

impl MeasurementModel for Seen {
    type State = f64;

    fn log_likelihood(&self, state: &f64) -> f64 {
        let off = (state - self.0) / SENSOR_SD;
        -0.5 * off * off - SENSOR_SD.ln() - 0.5 * std::f64::consts::TAU.ln()
    }
}

/// Nothing above zero is possible.
struct Below;

impl MeasurementModel for Below {
    type State = f64;

    fn log_likelihood(&self, state: &f64) -> f64 {
        if *state < 0.0 { 0.0 } else { f64::NEG_INFINITY }
    }
}

const SEEN: [f64; 6] = [0.1, 0.9, 0.7, 1.6, 1.2, 2.4];

/// Mean, variance and log evidence of all measurements.
fn kalman() -> (f64, f64, f64) {
    let (mut mean, mut variance, mut evidence) = (0.0, 1.0, 0.0);
    for seen in SEEN {
        mean += DRIFT;
        variance += MOTION_SD * MOTION_SD;
        let total = variance + SENSOR_SD * SENSOR_SD;
        let off: f64 = seen - mean;
        evidence -= 0.5 * (off * off / total + (std::f64::consts::TAU * total).ln());
        let gain = variance / total;
        mean += gain * off;
        variance *= 1.0 - gain;
    }
    (mean, variance, evidence)
}

fn start(n: usize, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..n).map(|_| random.sample(StandardNormal)).collect()
}

fn filtered(n: usize, settings: Settings<'_>) -> (f64, f64, f64) {
    let mut filter = ParticleFilter::new(start(n, settings.seed + 1000), settings).unwrap();
    let mut evidence = 0.0;
    for seen in SEEN {
        filter.predict(&Walk).unwrap();
        evidence += filter.update(&Seen(seen)).unwrap().log_evidence;
    }
    let weighted = || filter.particles().iter().zip(filter.weights().as_slice());
    let mean: f64 = weighted().map(|(x, w)| x * w).sum();
    let variance: f64 = weighted().map(|(x, w)| w * (x - mean).powi(2)).sum();
    (mean, variance, evidence)
}

#[test]
fn a_linear_gaussian_case_meets_the_kalman_filter_with_every_resampler() {
    let (mean, variance, evidence) = kalman();
    for resampler in
        [&Systematic as &'static dyn filter::Resampler, &Stratified, &Residual, &Multinomial]
    {
        let settings = Settings { resampler, ..Settings::default() };
        let found = filtered(200_000, settings);
        // Five standard errors, with a third of the particles effective.
        let n: f64 = 200_000.0 / 3.0;
        assert!((found.0 - mean).abs() < 5.0 * (variance / n).sqrt(), "{found:?} {mean}");
        assert!((found.1 / variance - 1.0).abs() < 5.0 * (2.0 / n).sqrt());
        assert!((found.2 - evidence).abs() < 5.0 * (6.0 * 2.0 / n).sqrt());
    }
}

#[test]
fn the_error_falls_with_the_root_of_the_number_of_particles() {
    let (mean, ..) = kalman();
    let rms = |n: usize| {
        let error = |seed| filtered(n, Settings { seed, ..Settings::default() }).0 - mean;
        ((0..60).map(|seed| error(seed).powi(2)).sum::<f64>() / 60.0).sqrt()
    };
    let slope = (rms(12_800) / rms(200)).ln() / 64.0_f64.ln();
    assert!((slope + 0.5).abs() < 0.1, "{slope}");
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let run = |n_threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        pool.install(|| {
            let mut filter = ParticleFilter::new(start(5000, 3), Settings::default()).unwrap();
            for seen in SEEN {
                filter.predict(&Walk).unwrap();
                filter.update(&Seen(seen)).unwrap();
            }
            (filter.particles().to_vec(), filter.weights().clone())
        })
    };
    assert_eq!(run(1), run(4));
}

#[test]
fn likelihoods_that_were_computed_elsewhere_weigh_as_those_of_a_measurement() {
    let mut one = ParticleFilter::new(start(500, 3), Settings::default()).unwrap();
    let mut other = one.clone();
    let seen = Seen(0.8);
    let likelihoods: Vec<f64> = one.particles().iter().map(|x| seen.log_likelihood(x)).collect();
    assert_eq!(one.update(&seen).unwrap(), other.update_by(&likelihoods).unwrap());
    assert_eq!((one.particles(), one.weights()), (other.particles(), other.weights()));
    let short = other.update_by(&likelihoods[1..]);
    assert!(matches!(short, Err(FilterError::ShapeMismatch { expected: 500, actual: 499, .. })));
}

#[test]
fn a_collapse_is_an_error_with_its_step_and_leaves_the_filter_as_it_was() {
    let mut filter = ParticleFilter::new(vec![5.0; 100], Settings::default()).unwrap();
    filter.predict(&Walk).unwrap();
    let before = filter.particles().to_vec();
    let error = filter.update(&Below).unwrap_err();
    assert!(matches!(error, FilterError::Collapsed { step: 1, n_particles: 100 }));
    assert_eq!(filter.particles(), before);
    let update = filter.update_or_inject(&Below, (-9.0, 0.1), |_| -1.0).unwrap();
    assert_eq!(update.n_injected, 10);
    assert!((update.effective_size - 10.0).abs() < 1e-9);
}

#[test]
fn what_is_explained_is_not_injected() {
    let mut filter = ParticleFilter::new(start(100, 5), Settings::default()).unwrap();
    let update = filter.update_or_inject(&Seen(0.0), (-9.0, 0.5), |_| 77.0).unwrap();
    assert_eq!(update.n_injected, 0);
    assert!(filter.particles().iter().all(|x| *x < 10.0));
}

#[test]
fn weighing_by_the_density_of_draws_narrows_what_was_never_measured() {
    let variance = |filter: &ParticleFilter<f64>| {
        let weighted = || filter.particles().iter().zip(filter.weights().as_slice());
        let mean: f64 = weighted().map(|(x, w)| x * w).sum();
        weighted().map(|(x, w)| w * (x - mean).powi(2)).sum::<f64>()
    };
    let mut plain = ParticleFilter::new(vec![0.0; 50_000], Settings::default()).unwrap();
    let mut sharpened = plain.clone();
    plain.predict(&Walk).unwrap();
    sharpened.predict_weighted_by_density(&Walk).unwrap();
    // The density of a normal draw, times itself, has half the variance.
    let tolerance = 5.0 * (2.0 / 50_000.0_f64).sqrt();
    assert!((variance(&plain) / MOTION_SD.powi(2) - 1.0).abs() < tolerance);
    assert!((variance(&sharpened) / MOTION_SD.powi(2) - 0.5).abs() < 2.0 * tolerance);
}

#[test]
fn bad_input_is_refused_with_its_value() {
    let none = ParticleFilter::new(Vec::<f64>::new(), Settings::default());
    assert!(matches!(none, Err(FilterError::Empty { what: "particles" })));
    let settings = Settings { resample_below: 1.5, ..Settings::default() };
    let error = ParticleFilter::new(vec![0.0], settings).unwrap_err();
    assert!(error.to_string().contains("resample_below must be from 0 to 1, got 1.5"));
    let error = Weights::equal(2).updated(&[0.0, f64::NAN], 3).unwrap_err();
    assert!(matches!(error, FilterError::NotANumber { step: 3, particle: 1, .. }));
    let error = PlanarSummary::of(&[[0.0, f64::INFINITY, 0.0]], &Weights::equal(1)).unwrap_err();
    assert!(matches!(error, FilterError::NotANumber { particle: 0, .. }));
}
