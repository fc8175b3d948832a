//! Gaussians and mixtures carried through motion.

use filter::{FilterError, GaussHermite, Gaussian, Mixture, Rule, Simplex, Unscented};
use nalgebra::{DMatrix, DVector, dmatrix, dvector};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

fn rules() -> [(&'static dyn Rule, u32); 4] {
    let grids: [(&dyn Rule, u32); 2] =
        [(&GaussHermite { order: 3 }, 5), (&GaussHermite { order: 5 }, 9)];
    [(&Simplex, 2), (&Unscented, 3), grids[0], grids[1]]
}

/// E zᵏ of a standard normal: the double factorial of k − 1 for even k.
fn moment(k: u32) -> f64 {
    if k % 2 == 1 { 0.0 } else { (1..k).step_by(2).map(f64::from).product() }
}

#[test]
fn rules_are_exact_up_to_their_degree() {
    for (rule, degree) in rules() {
        for dimension in 1..=3 {
            let points = rule.points(dimension);
            assert!((points.iter().map(|(_, weight)| weight).sum::<f64>() - 1.0).abs() < 1e-13);
            assert!(points.iter().all(|(_, weight)| *weight >= 0.0));
            for (a, b) in (0..dimension).flat_map(|a| (0..a).map(move |b| (a, b))) {
                let found: f64 = points.iter().map(|(z, weight)| weight * z[a] * z[b]).sum();
                assert!(found.abs() < 1e-13, "{dimension}: {found}");
            }
            for axis in 0..dimension {
                for k in 0..=degree {
                    let found: f64 =
                        points.iter().map(|(z, weight)| weight * z[axis].powi(k as i32)).sum();
                    assert!((found - moment(k)).abs() < 1e-11, "{dimension} {k}: {found}");
                }
            }
        }
    }
}

fn gaussian() -> Gaussian {
    Gaussian::new(dvector![1.0, -0.5], dmatrix![0.5, 0.2; 0.2, 0.3]).unwrap()
}

#[test]
fn a_linear_motion_is_exact() {
    let (a, q) = (dmatrix![1.0, 0.3; -0.2, 0.8], dmatrix![0.05, 0.01; 0.01, 0.02]);
    for (rule, _) in rules() {
        let moved: Gaussian = gaussian()
            .propagated(rule, |x| Gaussian::new(&a * x + dvector![0.1, 0.2], q.clone()))
            .unwrap();
        let mean = &a * gaussian().mean() + dvector![0.1, 0.2];
        let covariance = &a * gaussian().covariance() * a.transpose() + &q;
        assert!((moved.mean() - mean).amax() < 1e-13);
        assert!((moved.covariance() - covariance).amax() < 1e-13);
    }
}

#[test]
fn a_density_is_that_of_its_own_draws() {
    // E log p = −½ (d + d ln 2π + ln |C|).
    let one = gaussian();
    let mixture = Mixture::new(vec![(one.clone(), 2.0)]).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let n = 40_000;
    let mean: f64 =
        (0..n).map(|_| mixture.log_density(&mixture.sample(&mut random)).unwrap()).sum::<f64>()
            / f64::from(n);
    let entropy = 1.0 + std::f64::consts::TAU.ln() + 0.5 * one.covariance().determinant().ln();
    // The sum of two squared normals has a standard deviation of 2, of which half counts.
    assert!((mean + entropy).abs() < 5.0 / f64::from(n).sqrt(), "{mean} {entropy}");
}

#[test]
fn a_motion_of_two_ways_splits_and_joins_to_the_same_moments() {
    let start = Mixture::new(vec![(Gaussian::new(dvector![0.0], dmatrix![1.0]).unwrap(), 1.0)]);
    let motion = |x: &DVector<f64>| -> Result<Vec<(usize, f64, Gaussian)>, FilterError> {
        let way = usize::from(x[0] > 0.0);
        Ok(vec![(way, 1.0, Gaussian::new(dvector![x[0].abs()], DMatrix::zeros(1, 1))?)])
    };
    let moved = start.unwrap().propagated(&GaussHermite { order: 40 }, motion).unwrap();
    assert_eq!(moved.components().len(), 2);
    for (part, weight) in moved.components() {
        // A half normal.
        assert!((weight - 0.5).abs() < 1e-12);
        assert!((part.mean()[0] - (2.0 / std::f64::consts::PI).sqrt()).abs() < 0.02);
    }
    let (whole, joined) = (moved.moments().unwrap(), moved.reduced(1).unwrap());
    assert!((joined.components()[0].0.covariance() - whole.covariance()).amax() < 1e-14);
}

#[test]
fn a_gaussian_of_few_directions_asks_few_points_whatever_its_units() {
    // Meters beside radians: the third is the sum of the others, the fourth is known.
    let factor = dmatrix![1e-6, 0.0; 0.0, 3.0; 1e-6, 3.0; 0.0, 0.0];
    let covariance = &factor * factor.transpose();
    let start = Gaussian::new(dvector![1.0, 2.0, 3.0, 4.0], covariance.clone()).unwrap();
    let n_asked = std::cell::Cell::new(0);
    let moved = start
        .propagated(&GaussHermite { order: 3 }, |x| {
            n_asked.set(n_asked.get() + 1);
            Gaussian::new(x.clone(), DMatrix::zeros(4, 4))
        })
        .unwrap();
    assert_eq!(n_asked.get(), 9);
    for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
        let off = (moved.covariance()[(i, j)] - covariance[(i, j)]).abs();
        // Sixteen digits of a mean of 1 are ten of a standard deviation of 1e-6.
        let size = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
        let of_mean = 2e-15 * (covariance[(i, i)].sqrt() + covariance[(j, j)].sqrt());
        assert!(off <= 1e-9 * size + of_mean + 1e-28, "{i} {j}: {off}");
    }
    let known = Gaussian::new(dvector![1.0], dmatrix![0.0]).unwrap();
    let moved = known.propagated(&filter::Unscented, |x| Gaussian::new(2.0 * x, dmatrix![0.5]));
    assert_eq!(moved.unwrap(), Gaussian::new(dvector![2.0], dmatrix![0.5]).unwrap());
}

#[test]
fn a_state_that_may_go_two_ways_goes_both_with_their_probabilities() {
    let start = Gaussian::new(dvector![0.0, 1.0], dmatrix![1.0, 0.0; 0.0, 0.0]).unwrap();
    let motion = |x: &DVector<f64>| -> Result<Vec<(usize, f64, Gaussian)>, FilterError> {
        let to = |by: f64| Gaussian::new(dvector![x[0] + by, x[1]], DMatrix::zeros(2, 2));
        Ok(vec![(0, 0.7, to(-3.0)?), (1, 0.3, to(7.0)?)])
    };
    let start = Mixture::new(vec![(start, 1.0)]).unwrap();
    let moved = start.propagated(&GaussHermite { order: 3 }, motion).unwrap();
    let told: Vec<_> =
        moved.components().iter().map(|(part, weight)| (part.mean()[0], *weight)).collect();
    assert!((told[0].0 + 3.0).abs() < 1e-12 && (told[0].1 - 0.7).abs() < 1e-12, "{told:?}");
    assert!((told[1].0 - 7.0).abs() < 1e-12 && (told[1].1 - 0.3).abs() < 1e-12, "{told:?}");
    // Again: of four, the two that meet at 4 are joined, although the second axis has no variance.
    let again = moved.propagated(&GaussHermite { order: 3 }, motion).unwrap().reduced(3).unwrap();
    let mut means: Vec<f64> = again.components().iter().map(|(part, _)| part.mean()[0]).collect();
    means.sort_by(f64::total_cmp);
    assert!((means[0] + 6.0).abs() < 1e-9 && (means[1] - 4.0).abs() < 1e-9, "{means:?}");
}

#[test]
fn the_two_that_are_alike_are_joined_first() {
    let at = |x: f64| Gaussian::new(dvector![x], dmatrix![0.1]).unwrap();
    let mixture = Mixture::new(vec![(at(0.0), 0.4), (at(5.0), 0.3), (at(0.1), 0.3)]).unwrap();
    let reduced = mixture.reduced(2).unwrap();
    let mut means: Vec<f64> = reduced.components().iter().map(|(part, _)| part.mean()[0]).collect();
    means.sort_by(f64::total_cmp);
    assert!((means[0] - 0.03 / 0.7).abs() < 1e-12 && (means[1] - 5.0).abs() < 1e-12);
}

#[test]
fn what_is_no_covariance_is_refused() {
    let bad = Gaussian::new(dvector![0.0, 0.0], dmatrix![1.0, 2.0; 2.0, 1.0]);
    assert!(matches!(bad, Err(FilterError::NotPositiveSemiDefinite { dimension: 2 })));
    let bad = Gaussian::new(dvector![0.0, 0.0], dmatrix![1.0, 0.5; 0.0, 1.0]);
    assert!(matches!(bad, Err(FilterError::NotPositiveSemiDefinite { dimension: 2 })));
    let bad = Gaussian::new(dvector![0.0], dmatrix![1.0, 0.0; 0.0, 1.0]);
    assert!(matches!(bad, Err(FilterError::ShapeMismatch { expected: 1, actual: 2, .. })));
    assert!(matches!(Mixture::new(Vec::new()), Err(FilterError::Empty { .. })));
}

#[test]
fn parts_of_a_split_have_the_moments_of_the_whole() {
    let whole = gaussian();
    for rule in [&GaussHermite { order: 7 } as &dyn Rule, &Unscented] {
        let way = |x: &DVector<f64>| Ok::<_, FilterError>((1.4 * x[0] + x[1]).round() as i64);
        let parts = whole.split(rule, 2, way).unwrap();
        assert!(parts.len() >= 3, "{parts:?}");
        let ordered = |(a, b): (&(i64, f64, Gaussian), &(i64, f64, Gaussian))| {
            let along = |part: &Gaussian| 1.4 * part.mean()[0] + part.mean()[1];
            a.0 < b.0 && along(&a.2) < along(&b.2)
        };
        assert!(parts.iter().zip(&parts[1..]).all(ordered));
        let mixture = parts.into_iter().map(|(_, share, part)| (part, share)).collect();
        let moments = Mixture::new(mixture).unwrap().moments().unwrap();
        assert!((moments.mean() - whole.mean()).amax() < 1e-13);
        assert!((moments.covariance() - whole.covariance()).amax() < 1e-13);
    }
}

/// A rule of many equal points, which sees a sharp edge as it is.
struct Draws;

impl Rule for Draws {
    fn points(&self, dimension: usize) -> Vec<(DVector<f64>, f64)> {
        let unit = DMatrix::identity(dimension, dimension);
        let standard = Gaussian::new(DVector::zeros(dimension), unit).unwrap();
        let mut random = ChaCha8Rng::seed_from_u64(8);
        let n = 200_000;
        (0..n).map(|_| (standard.sample(&mut random), 1.0 / f64::from(n))).collect()
    }
}

#[test]
fn a_split_by_a_plane_has_the_moments_of_the_draws_on_its_sides() {
    let whole = gaussian();
    let side = |x: &DVector<f64>| i64::from(x[0] + 2.0 * x[1] > 0.3);
    let parts = whole.split(&Draws, 2, |x| Ok::<_, FilterError>(side(x))).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let draws: Vec<DVector<f64>> = (0..400_000).map(|_| whole.sample(&mut random)).collect();
    for (way, share, part) in parts {
        let own: Vec<&DVector<f64>> = draws.iter().filter(|x| side(x) == way).collect();
        let n = own.len() as f64;
        assert!((n / draws.len() as f64 - share).abs() < 0.004, "{share}");
        let mean = own.iter().fold(DVector::zeros(2), |sum, x| sum + *x) / n;
        let off = own.iter().map(|x| *x - &mean);
        let covariance = off.fold(DMatrix::zeros(2, 2), |sum, x| sum + &x * x.transpose()) / n;
        assert!((part.mean() - mean).amax() < 0.01, "{part:?}");
        assert!((part.covariance() - covariance).amax() < 0.01, "{part:?}");
    }
}

#[test]
fn one_way_is_no_split() {
    let whole = gaussian();
    let parts = whole.split(&Unscented, 2, |_| Ok::<_, FilterError>(3)).unwrap();
    assert_eq!(parts.len(), 1);
    assert_eq!((parts[0].0, parts[0].1), (3, 1.0));
    assert_eq!(parts[0].2, whole);
}

#[test]
fn points_over_some_coordinates_are_enough_for_what_depends_on_them() {
    let covariance = dmatrix![0.5, 0.2, -0.1; 0.2, 0.3, 0.05; -0.1, 0.05, 0.4];
    let whole = Gaussian::new(dvector![1.0, -0.5, 2.0], covariance).unwrap();
    let rule = GaussHermite { order: 9 };
    let bent = |x: &DVector<f64>| dvector![x[0] + x[1] * x[0], x[1] * x[1], x[2] + x[0]];
    let known = |x: &DVector<f64>| Gaussian::new(bent(x), DMatrix::zeros(3, 3));
    let by_all: Gaussian = whole.propagated(&rule, known).unwrap();
    let (points, rest) = whole.points_of_first(&rule, 2);
    assert_eq!(points.len(), 81);
    let moved: Vec<_> = points.iter().map(|(x, weight)| (bent(x), *weight)).collect();
    let by_first = Gaussian::of_points(&moved, &rest).unwrap();
    assert!((by_all.mean() - by_first.mean()).amax() < 1e-12);
    assert!((by_all.covariance() - by_first.covariance()).amax() < 1e-12);
    // A direction without variance takes no point.
    let flat = dmatrix![0.0, 0.0, 0.0; 0.0, 0.3, 0.05; 0.0, 0.05, 0.4];
    let flat = Gaussian::new(dvector![1.0, -0.5, 2.0], flat).unwrap();
    let (points, rest) = flat.points_of_first(&rule, 2);
    assert_eq!(points.len(), 9);
    let again = Gaussian::of_points(&points, &rest).unwrap();
    assert!((again.mean() - flat.mean()).amax() < 1e-13);
    assert!((again.covariance() - flat.covariance()).amax() < 1e-13);
    let error = Gaussian::of_points(&points, &DMatrix::zeros(2, 2)).unwrap_err();
    assert!(matches!(error, FilterError::ShapeMismatch { .. }), "{error}");
}
