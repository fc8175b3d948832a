//! Summaries of clouds of poses.

#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

use std::f64::consts::{PI, TAU};

use filter::{DensityGrid, PlanarSummary, Weights};
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
