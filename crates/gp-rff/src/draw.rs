//! Frequencies from the spectrum of a kernel, for lengthscales of 1.

use std::f64::consts::{PI, TAU};

use gp_core::LowDiscrepancy;
use gp_core::quantile;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{Sampling, Spectrum};

/// `n` frequencies of `d` coordinates, one after the other, and a phase in [0, 2π) for each.
pub(crate) fn draw(
    spectrum: Spectrum,
    sampling: Sampling,
    n: usize,
    d: usize,
    seed: u64,
) -> (Vec<f64>, Vec<f64>) {
    // Two coordinates more: the stretch of a Student t, and the phase.
    let width = d + 2;
    let uniform: Vec<f64> = match sampling {
        Sampling::LowDiscrepancy => {
            let points = LowDiscrepancy::new(width, seed);
            (1..=n).flat_map(|index| points.point(index)).collect()
        }
        _ => {
            let mut rng = stream(seed, 0);
            (0..n * width).map(|_| rng.random()).collect()
        }
    };
    let rows = || uniform.chunks_exact(width);
    let mut frequencies: Vec<f64> =
        rows().flat_map(|row| row[..d].iter().map(|u| quantile::normal(*u))).collect();
    if sampling == Sampling::Orthogonal {
        orthogonalize(&mut frequencies, d, seed);
    }
    if let Some(degrees) = spectrum.degrees_of_freedom() {
        for (frequency, row) in frequencies.chunks_exact_mut(d).zip(rows()) {
            let stretch = (f64::from(degrees) / chi_squared_quantile(row[d], degrees)).sqrt();
            frequency.iter_mut().for_each(|entry| *entry *= stretch);
        }
    }
    (frequencies, rows().map(|row| TAU * row[d + 1]).collect())
}

fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(number);
    rng
}

/// Gives every `d` rows after each other orthogonal directions, uniform on the sphere, and their
/// own lengths.
fn orthogonalize(rows: &mut [f64], d: usize, seed: u64) {
    let mut rng = stream(seed, 1);
    for set in rows.chunks_mut(d * d) {
        let lengths: Vec<f64> = set.chunks_exact(d).map(|row| dot(row, row).sqrt()).collect();
        for (k, length) in lengths.iter().enumerate() {
            let (done, rest) = set.split_at_mut(k * d);
            let row = &mut rest[..d];
            row.iter_mut().for_each(|entry| *entry = quantile::normal(rng.random()));
            // Twice, so that rounding leaves no trace of the others.
            for other in done.chunks_exact(d).chain(done.chunks_exact(d)) {
                let along = dot(row, other) / dot(other, other);
                row.iter_mut().zip(other).for_each(|(entry, other)| *entry -= along * other);
            }
            let scale = length / dot(row, row).sqrt();
            row.iter_mut().for_each(|entry| *entry *= scale);
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The x at which the χ² distribution function of 1, 3 or 5 degrees of freedom is `p`.
fn chi_squared_quantile(p: f64, degrees: u32) -> f64 {
    let below = |x: f64| {
        let first = libm::erf((0.5 * x).sqrt());
        let third = first - (2.0 * x / PI).sqrt() * (-0.5 * x).exp();
        match degrees {
            1 => first,
            3 => third,
            _ => third - (2.0 * x / PI).sqrt() * x / 3.0 * (-0.5 * x).exp(),
        }
    };
    quantile::invert(below, p.clamp(1e-12, 1.0 - 1e-12), 0.0, 100.0)
}

#[cfg(test)]
mod tests {
    use super::{chi_squared_quantile, dot, draw};
    use crate::{Sampling, Spectrum};

    #[test]
    fn quantiles_known_from_tables() {
        assert!((chi_squared_quantile(0.95, 1) - 3.841_458_820_694_124).abs() < 1e-9);
        assert!((chi_squared_quantile(0.95, 3) - 7.814_727_903_251_179).abs() < 1e-9);
        assert!((chi_squared_quantile(0.95, 5) - 11.070_497_693_516_35).abs() < 1e-9);
    }

    #[test]
    fn orthogonal_sets_are_orthogonal() {
        let d = 4;
        let rows = draw(Spectrum::default(), Sampling::Orthogonal, 10, d, 3).0;
        for set in rows.chunks(d * d) {
            for (i, a) in set.chunks_exact(d).enumerate() {
                for b in set.chunks_exact(d).take(i) {
                    assert!(dot(a, b).abs() < 1e-13);
                }
            }
        }
    }

    #[test]
    fn every_sampling_has_the_moments_of_the_spectrum() {
        for sampling in [Sampling::Independent, Sampling::Orthogonal, Sampling::LowDiscrepancy] {
            let n = 20_000;
            let rows = draw(Spectrum::Matern52, sampling, n, 2, 1).0;
            let mean = rows.iter().sum::<f64>() / rows.len() as f64;
            let variance = dot(&rows, &rows) / rows.len() as f64;
            // A Student t of 5 degrees has the variance 5/3.
            assert!(mean.abs() < 0.03, "{sampling:?} {mean}");
            assert!((variance - 5.0 / 3.0).abs() < 0.06, "{sampling:?} {variance}");
        }
    }
}
