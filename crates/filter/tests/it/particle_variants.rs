//! Particle filters that look ahead, that choose their number, and that carry Gaussians.

use std::convert::Infallible;

use filter::{
    FilterError, GaussHermite, Gaussian, KldSampling, LinearMeasurement, LinearMotion,
    MeasurementModel, MotionModel, ParticleFilter, RaoBlackwellized, Resampler, Settings,
    Systematic,
};
use nalgebra::{dmatrix, dvector};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

fn start(n: usize, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    (0..n).map(|_| random.sample(StandardNormal)).collect()
}

/// Moves by a standard deviation.
struct Walk(f64);

impl MotionModel for Walk {
    type State = f64;
    type Error = Infallible;

    fn advance(&self, states: &mut [f64], random: &mut dyn Rng) -> Result<(), Infallible> {
        states.iter_mut().for_each(|x| *x += self.0 * random.sample::<f64, _>(StandardNormal));
        Ok(())
    }
}

/// Seen at a place, give or take a standard deviation.
struct Seen(f64, f64);

impl MeasurementModel for Seen {
    type State = f64;

    fn log_likelihood(&self, x: &f64) -> f64 {
        -0.5 * ((x - self.0) / self.1).powi(2) - self.1.ln() - 0.5 * std::f64::consts::TAU.ln()
    }
}

/// Mean, variance and evidence after a step of a standard normal and a measurement.
fn kalman(motion_sd: f64, Seen(seen, sd): &Seen) -> (f64, f64, f64) {
    let predicted = 1.0 + motion_sd * motion_sd;
    let total = predicted + sd * sd;
    let evidence = -0.5 * (seen * seen / total + (std::f64::consts::TAU * total).ln());
    (predicted * seen / total, predicted * sd * sd / total, evidence)
}

fn moments(filter: &ParticleFilter<'_, f64>) -> (f64, f64) {
    let weighted = || filter.particles().iter().zip(filter.weights().as_slice());
    let mean: f64 = weighted().map(|(x, w)| x * w).sum();
    (mean, weighted().map(|(x, w)| w * (x - mean).powi(2)).sum())
}

const NEVER: Settings<'static> = Settings { resampler: &Systematic, resample_below: 0.0, seed: 7 };

#[test]
fn an_auxiliary_step_is_right_and_wastes_fewer_particles() {
    let (seen, n) = (Seen(2.5, 0.3), 100_000);
    let motion = Walk(0.3);
    let (mean, variance, evidence) = kalman(motion.0, &seen);
    let mut plain = ParticleFilter::new(start(n, 1), NEVER).unwrap();
    plain.predict(&motion).unwrap();
    let plain = plain.update(&seen).unwrap();
    // What is seen after the motion, as far as it can be foreseen, and a rough foresight.
    let ahead = |width: f64| move |x: &f64| -0.5 * ((x - 2.5) / width).powi(2);
    for (width, gain) in [(0.18_f64.sqrt(), 5.0), (1.0, 1.5)] {
        let mut filter = ParticleFilter::new(start(n, 1), NEVER).unwrap();
        let update = filter.auxiliary_step(&motion, &seen, ahead(width)).unwrap();
        assert!(update.resampled && filter.step() == 1);
        assert!(update.effective_size > gain * plain.effective_size, "{update:?} {plain:?}");
        // Five standard errors of the effective particles.
        let error = 5.0 / update.effective_size.sqrt();
        let found = moments(&filter);
        assert!((found.0 - mean).abs() < error * variance.sqrt(), "{found:?} {mean}");
        assert!((found.1 / variance - 1.0).abs() < error * 2.0_f64.sqrt(), "{found:?}");
        assert!((update.log_evidence - evidence).abs() < error, "{update:?} {evidence}");
    }
}

#[test]
fn an_auxiliary_step_that_fails_leaves_the_filter_as_it_was() {
    let mut filter = ParticleFilter::new(start(100, 1), Settings::default()).unwrap();
    let before = filter.particles().to_vec();
    let error = filter.auxiliary_step(&Walk(1.0), &Seen(0.0, 1.0), |_| f64::NAN).unwrap_err();
    assert!(matches!(error, FilterError::NotANumber { step: 0, particle: 0, .. }), "{error}");
    let error = filter.auxiliary_step(&Walk(1.0), &Seen(f64::INFINITY, 1.0), |_| 0.0).unwrap_err();
    assert!(matches!(error, FilterError::Collapsed { step: 1, .. }), "{error}");
    assert_eq!((filter.particles(), filter.step()), (&before[..], 0));
}

#[test]
fn particles_are_as_many_as_the_bins_ask_for() {
    // χ² of 99 degrees of freedom is below 134.64 in 99 of 100 cases, of one below 6.63 (tables).
    let sampling = KldSampling { least: 1, ..KldSampling::default() };
    assert!((sampling.n_particles(100) as f64 / (134.64 / 0.1) - 1.0).abs() < 2e-3);
    assert!((sampling.n_particles(2) as f64 / (6.63 / 0.1) - 1.0).abs() < 0.05);
    assert_eq!((sampling.n_particles(1), sampling.n_particles(0)), (1, 1));
    let bin = |x: &f64| (x / 0.1).floor() as i64;
    let moved = |width: f64| {
        let cloud = start(5000, 2).into_iter().map(|x| width * x).collect();
        let mut filter = ParticleFilter::new(cloud, NEVER).unwrap();
        let n_bins = filter.predict_adaptively(&Walk(1.0), &KldSampling::default(), bin).unwrap();
        let n = filter.particles().len();
        assert_eq!(n, KldSampling::default().n_particles(n_bins));
        assert_eq!(filter.weights().as_slice().len(), n);
        let mut bins: Vec<i64> = filter.particles().iter().map(bin).collect();
        bins.sort_unstable();
        bins.dedup();
        assert_eq!((bins.len(), filter.step()), (n_bins, 1));
        let (mean, variance) = moments(&filter);
        let (truth, error) = (width * width + 1.0, 5.0 / (n as f64).sqrt());
        assert!(mean.abs() < error * truth.sqrt() && (variance / truth - 1.0).abs() < 1.5 * error);
        n
    };
    assert!(moved(10.0) > 3 * moved(0.1));
    let (least, most) = (300, 310);
    let few = KldSampling { least, most, ..KldSampling::default() };
    let mut filter = ParticleFilter::new(start(5000, 2), NEVER).unwrap();
    filter.predict_adaptively(&Walk(1.0), &few, bin).unwrap();
    assert_eq!(filter.particles().len(), most);
    filter.predict_adaptively(&Walk(1.0), &few, |_| 0).unwrap();
    assert_eq!(filter.particles().len(), least);
}

#[test]
fn heavy_particles_are_drawn_by_their_weights() {
    let mut filter = ParticleFilter::new(vec![-50.0, 50.0], NEVER).unwrap();
    filter.update(&Seen(50.0, 50.0)).unwrap();
    let share = filter.weights().as_slice()[1];
    let sampling = KldSampling { least: 20_000, ..KldSampling::default() };
    filter.predict_adaptively(&Walk(1.0), &sampling, |x| *x > 0.0).unwrap();
    let found = filter.particles().iter().filter(|x| **x > 0.0).count() as f64 / 20_000.0;
    assert!((found - share).abs() < 5.0 * (share * (1.0 - share) / 20_000.0).sqrt());
}

#[test]
fn a_sampling_out_of_range_is_refused() {
    let mut filter = ParticleFilter::new(start(10, 2), NEVER).unwrap();
    let usual = KldSampling::default();
    for sampling in [
        KldSampling { divergence: 0.0, ..usual },
        KldSampling { confidence: 1.0, ..usual },
        KldSampling { least: 0, ..usual },
        KldSampling { least: 11, most: 10, ..usual },
    ] {
        let error = filter.predict_adaptively(&Walk(1.0), &sampling, |_| 0).unwrap_err();
        assert!(matches!(error, FilterError::OutOfRange { .. }), "{error}");
    }
    assert_eq!(filter.step(), 0);
}

/// A place that is drawn, and a velocity that is a Gaussian given the place: x′ = x + v + N(0, 0.3²),
/// v′ = 0.9 v + N(0, 0.2²).
struct Carried;

type Carrier = RaoBlackwellized<f64>;

impl MotionModel for Carried {
    type State = Carrier;
    type Error = FilterError;

    fn advance(&self, states: &mut [Carrier], random: &mut dyn Rng) -> Result<(), FilterError> {
        let noise = Gaussian::independent(dvector![0.0], &[0.3])?;
        let motion =
            LinearMotion::new(dmatrix![0.9], Gaussian::independent(dvector![0.0], &[0.2])?)?;
        for state in states {
            let variance = state.gaussian.covariance()[(0, 0)] + 0.09;
            let draw: f64 = random.sample(StandardNormal);
            let by = state.gaussian.mean()[0] + variance.sqrt() * draw;
            // The draw says something of the velocity.
            let seen = LinearMeasurement::new(dvector![by], dmatrix![1.0], noise.clone())?;
            let velocity = state.gaussian.updated(&seen)?.posterior;
            state.drawn += by;
            state.gaussian = velocity.predicted(&motion)?.state().clone();
        }
        Ok(())
    }
}

/// A sensor of speed, which errs in proportion to the place: linear given what is drawn.
fn speed(seen: f64) -> impl Fn(&f64) -> Result<LinearMeasurement, FilterError> + Sync {
    move |_| {
        let noise = Gaussian::independent(dvector![0.05], &[0.2])?;
        LinearMeasurement::new(dvector![seen], dmatrix![1.0], noise)
    }
}

/// Where the carrier is.
struct Place(f64);

impl MeasurementModel for Place {
    type State = Carrier;

    fn log_likelihood(&self, state: &Carrier) -> f64 {
        Seen(self.0, 0.25).log_likelihood(&state.drawn)
    }
}

const PLACES: [f64; 4] = [0.4, 1.1, 1.3, 2.2];
const SPEEDS: [f64; 4] = [0.5, 0.3, 0.6, 0.7];

#[test]
fn particles_with_gaussians_meet_the_kalman_filter() {
    let mut state = Gaussian::independent(dvector![0.0, 0.5], &[0.0, 0.4]).unwrap();
    let added = Gaussian::independent(dvector![0.0, 0.0], &[0.3, 0.2]).unwrap();
    let motion = LinearMotion::new(dmatrix![1.0, 1.0; 0.0, 0.9], added).unwrap();
    let velocity = Gaussian::independent(dvector![0.5], &[0.4]).unwrap();
    let cloud = vec![RaoBlackwellized { drawn: 0.0, gaussian: velocity }; 10_000];
    let mut filter = ParticleFilter::new(cloud, Settings::default()).unwrap();
    let mut by_points = filter.clone();
    let (mut exact, mut found) = (0.0, 0.0);
    for (place, fast) in PLACES.into_iter().zip(SPEEDS) {
        state = state.predicted(&motion).unwrap().state().clone();
        let mean = dvector![0.0, 0.05];
        let noise = Gaussian::independent(mean, &[0.25, 0.2]).unwrap();
        let both = dmatrix![1.0, 0.0; 0.0, 1.0];
        let both = LinearMeasurement::new(dvector![place, fast], both, noise).unwrap();
        let update = state.updated(&both).unwrap();
        (state, exact) = (update.posterior, exact + update.log_evidence);
        filter.predict(&Carried).unwrap();
        found += filter.update(&Place(place)).unwrap().log_evidence;
        found += filter.condition(speed(fast)).unwrap().log_evidence;
        by_points.predict(&Carried).unwrap();
        by_points.update(&Place(place)).unwrap();
        by_points.condition_by(&GaussHermite { order: 2 }, speed(fast)).unwrap();
    }
    // Five standard errors, with a third of the particles effective.
    let error = 5.0 / (10_000.0_f64 / 3.0).sqrt();
    let own = filter.moments().unwrap();
    let sd = |k: usize| state.covariance()[(k, k)].sqrt();
    assert!((own.mean()[0] - state.mean()[1]).abs() < error * sd(1), "{own:?} {state:?}");
    assert!((own.covariance()[(0, 0)] / state.covariance()[(1, 1)] - 1.0).abs() < 1.5 * error);
    let weighted = filter.particles().iter().zip(filter.weights().as_slice());
    let place: f64 = weighted.map(|(carrier, weight)| weight * carrier.drawn).sum();
    assert!((place - state.mean()[0]).abs() < error * sd(0), "{place} {state:?}");
    assert!((found - exact).abs() < 4.0 * error, "{found} {exact}");
    let off = by_points.moments().unwrap().mean() - own.mean();
    assert!(off.amax() < 1e-6, "{off}");
}

#[test]
fn a_particle_that_cannot_be_conditioned_is_named() {
    let gaussian = Gaussian::independent(dvector![0.0], &[1.0]).unwrap();
    let cloud = [0.0, 1.0, 2.0].map(|drawn| Carrier { drawn, gaussian: gaussian.clone() });
    let mut filter = ParticleFilter::new(cloud.to_vec(), Settings::default()).unwrap();
    let before = filter.particles().to_vec();
    let error = filter.condition(|drawn: &f64| {
        let seen = dvector![if *drawn < 0.5 { 0.0 } else { f64::NAN }];
        LinearMeasurement::new(seen, dmatrix![1.0], gaussian.clone())
    });
    let error = error.unwrap_err();
    assert!(matches!(error, FilterError::Measurement { step: 0, particle: 1, .. }), "{error}");
    assert_eq!(filter.particles(), before);
    assert_eq!(
        filter::PlanarState::planar(&RaoBlackwellized { drawn: [1.0, 2.0, 3.0], gaussian }),
        [1.0, 2.0, 3.0]
    );
}

/// Draws the heaviest alone; known at run time only.
#[derive(Debug)]
struct Greedy {
    name: String,
}

impl Resampler for Greedy {
    fn id(&self) -> &'static str {
        "greedy"
    }

    fn ancestors(&self, weights: &[f64], n: usize, _: &mut dyn Rng) -> Vec<usize> {
        let best = (0..weights.len()).max_by(|a, b| weights[*a].total_cmp(&weights[*b]));
        vec![best.unwrap_or_default(); n]
    }

    fn keeps_equal_weights(&self) -> bool {
        self.name.is_empty()
    }

    fn keeps_heavy_particles(&self) -> bool {
        false
    }
}

#[test]
fn a_resampler_may_live_as_long_as_its_filter() {
    let greedy = Greedy { name: format!("{}", 7) };
    let settings = Settings { resampler: &greedy, ..Settings::default() };
    let mut filter = ParticleFilter::new(vec![-1.0, 0.0, 1.0], settings).unwrap();
    assert!(filter.update(&Seen(1.0, 0.1)).unwrap().resampled);
    assert_eq!(filter.particles(), [1.0; 3]);
}

#[test]
fn variants_are_the_same_for_any_number_of_threads() {
    let run = |n_threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        pool.install(|| {
            let mut filter = ParticleFilter::new(start(3000, 3), Settings::default()).unwrap();
            filter
                .auxiliary_step(&Walk(1.0), &Seen(1.0, 0.3), |x| -0.3 * (x - 1.0).powi(2))
                .unwrap();
            let sampling = KldSampling::default();
            filter.predict_adaptively(&Walk(1.0), &sampling, |x| (x / 0.01) as i64).unwrap();
            filter.particles().to_vec()
        })
    };
    let (one, four) = (run(1), run(4));
    assert!(one.len() > 1024);
    assert_eq!(one, four);
}
