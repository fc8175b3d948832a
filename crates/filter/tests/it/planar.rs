//! Summaries of clouds of poses.

use std::f64::consts::{PI, TAU};

use filter::{DensityGrid, FilterError, Gaussian, PlanarSummary, Weights};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

fn cloud(n: usize, center: [f64; 3], sd: [f64; 3]) -> Vec<[f64; 3]> {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut draw = |k: usize| center[k] + sd[k] * random.sample::<f64, _>(StandardNormal);
    (0..n).map(|_| [draw(0), draw(1), draw(2)]).collect()
}

#[test]
fn the_seam_of_the_circle_is_not_seen() {
    let poses = cloud(20_000, [1.0, -2.0, PI - 0.01], [0.1, 0.2, 0.3]);
    let turned: Vec<_> = poses.iter().map(|[x, y, angle]| [*x, *y, angle - 1.0 + TAU]).collect();
    let weights = Weights::equal(poses.len());
    let (seam, plain) = (
        PlanarSummary::of(&poses, &weights).unwrap(),
        PlanarSummary::of(&turned, &weights).unwrap(),
    );
    assert!((plain.mean.z + 1.0 - seam.mean.z.rem_euclid(TAU)).abs() < 1e-9);
    assert!((seam.covariance - plain.covariance).amax() < 1e-9);
    assert!((seam.covariance[(2, 2)].sqrt() - 0.3).abs() < 0.01);
    // E cos of a normal angle is exp(−σ²/2).
    assert!((seam.concentration - (-0.045_f64).exp()).abs() < 0.003);
    let quantiles = seam.quantiles(&poses, &weights, &[0.025, 0.5, 0.975]).unwrap();
    assert!((quantiles[2].z - quantiles[0].z - 2.0 * 1.96 * 0.3).abs() < 0.03);
    assert!((quantiles[1].x - 1.0).abs() < 0.005);
}

#[test]
fn a_weight_counts_as_so_many_copies() {
    let poses = [[0.0, 0.0, 0.1], [1.0, 2.0, 0.4], [3.0, -1.0, -0.2]];
    let copies = [poses[0], poses[1], poses[1], poses[1], poses[2], poses[2]];
    let (weights, _) = Weights::from_logs([1.0_f64, 3.0, 2.0].map(f64::ln).to_vec()).unwrap();
    let one = PlanarSummary::of(&poses, &weights).unwrap();
    let other = PlanarSummary::of(&copies, &Weights::equal(6)).unwrap();
    assert!((one.mean - other.mean).amax() < 1e-14);
    assert!((one.covariance - other.covariance).amax() < 1e-14);
}

#[test]
fn a_density_integrates_to_one_and_finds_both_heaps() {
    let mut poses = cloud(6000, [0.0, 0.0, 0.0], [0.01, 0.02, 0.1]);
    poses.extend(cloud(3000, [0.1, 0.05, 0.0], [0.01, 0.01, 0.1]));
    let grid = DensityGrid::of(&poses, &Weights::equal(poses.len()), 96).unwrap();
    let area = grid.spacing[0] * grid.spacing[1];
    assert!((grid.density.iter().sum::<f64>() * area - 1.0).abs() < 1e-3);
    let modes = grid.modes(0.1);
    assert_eq!(modes.len(), 2, "{modes:?}");
    let mut places = modes.iter().map(|mode| mode.position).collect::<Vec<_>>();
    places.sort_by(|a, b| a[0].total_cmp(&b[0]));
    assert!(places[0][0].abs() < 0.005 && (places[1][0] - 0.1).abs() < 0.005, "{places:?}");
    assert!(DensityGrid::of(&[[1.0; 3]; 9], &Weights::equal(9), 96).is_err());
}

#[test]
fn a_pose_is_on_the_border_of_the_region_that_holds_what_is_nearer() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut normal = || random.sample::<f64, _>(StandardNormal);
    // Correlated, wide and narrow, across the seam of the angle.
    let states: Vec<[f64; 3]> = (0..20_000)
        .map(|_| {
            let (a, b, c) = (normal(), normal(), normal());
            [0.1 + 0.01 * a, 0.002 * b + 0.008 * a, PI + 0.05 * c]
        })
        .collect();
    let weights = Weights::equal(states.len());
    let summary = PlanarSummary::of(&states, &weights).unwrap();
    let level = |pose: [f64; 3], sd: [f64; 2]| summary.level(&states, &weights, pose, sd).unwrap();
    assert_eq!(level([summary.mean.x, summary.mean.y, summary.mean.z], [0.0; 2]), 0.0);
    // One standard deviation along one axis: the chi-squared distribution of three at 1 is 0.1987.
    let one = [summary.mean.x, summary.mean.y, summary.mean.z + 0.05 - 2.0 * PI];
    assert!((level(one, [0.0; 2]) - 0.1987).abs() < 0.02, "{}", level(one, [0.0; 2]));
    assert!(level(one, [0.0, 0.05]) < 0.1, "half the square of the distance");
    let beyond = level([1.0, 0.0, 0.0], [0.0; 2]);
    assert!((1.0 - 1e-9..=1.0).contains(&beyond), "beyond all of them: {beyond}");
    let single = PlanarSummary::of(&states[..1], &Weights::equal(1)).unwrap();
    assert_eq!(single.level(&states[..1], &Weights::equal(1), states[0], [0.0; 2]).unwrap(), 0.0);
    assert!(summary.level(&states, &weights, one, [-1.0, 0.0]).is_err());
}

#[test]
fn a_gaussian_is_summed_up_as_its_draws_are() {
    let mean = DVector::from_vec(vec![1.0, -2.0, PI + 0.4]);
    let root = DMatrix::from_row_slice(3, 3, &[0.1, 0.0, 0.0, 0.1, 0.2, 0.0, -0.2, 0.1, 0.15]);
    let gaussian = Gaussian::new(mean, &root * root.transpose()).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let draw = |_| {
        let at = gaussian.sample(&mut random);
        [at[0], at[1], at[2]]
    };
    let draws: Vec<[f64; 3]> = (0..100_000).map(draw).collect();
    let weights = Weights::equal(draws.len());
    let by_draws = PlanarSummary::of(&draws, &weights).unwrap();
    let summary = PlanarSummary::of_gaussian(&gaussian).unwrap();
    assert!((summary.mean - by_draws.mean).amax() < 0.004);
    assert!((summary.covariance - by_draws.covariance).amax() < 0.002);
    assert!((summary.concentration - by_draws.concentration).abs() < 0.001);
    let probabilities = [0.025, 0.5, 0.9];
    let found = summary.gaussian_quantiles(&probabilities).unwrap();
    for (a, b) in found.iter().zip(by_draws.quantiles(&draws, &weights, &probabilities).unwrap()) {
        assert!((a - b).amax() < 0.006, "{a} {b}");
    }
    for measured in [[1.05, -1.8, PI + 0.4], [1.3, -2.3, 0.6 - PI]] {
        let level = by_draws.level(&draws, &weights, measured, [0.02, 0.01]).unwrap();
        let found = summary.gaussian_level(measured, [0.02, 0.01]);
        assert!((found - level).abs() < 0.01, "{found} {level}");
    }
    let error = summary.gaussian_quantiles(&[1.0]).unwrap_err();
    assert!(matches!(error, FilterError::OutOfRange { .. }), "{error}");
    let plane = Gaussian::new(DVector::zeros(2), DMatrix::identity(2, 2)).unwrap();
    let error = PlanarSummary::of_gaussian(&plane).unwrap_err();
    assert!(matches!(error, FilterError::ShapeMismatch { expected: 3, actual: 2, .. }), "{error}");
}
