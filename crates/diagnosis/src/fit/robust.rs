//! A sum of squares in which neither a number nor a push has more than its say.

use std::ops::Range;

use nalgebra::DVector;

use dataset::quantile;

/// Huber's function of whitened residuals, once for each number and once for each push.
///
/// F = Σₚ nₚ H(sₚ) + Σ prior_residual², sₚ² = Σᵢ H(zᵢ)/nₚ over the nₚ numbers of push p, with
/// H(z) = z² up to the threshold k and 2k|z| − k² beyond. The rows after the last push's are the
/// strains of priors, plain squares.
///
/// # Source
/// Huber (1964), Robust estimation of a location parameter, Annals of Mathematical Statistics 35.
#[derive(Clone, Debug)]
pub(crate) struct Robust {
    rows: Vec<Range<usize>>,
    threshold: f64,
}

/// Threshold in standard deviations.
const HUBER: f64 = 3.0;

impl Robust {
    /// With the threshold at three times the typical residual, which is at least the noise.
    pub(crate) fn at(rows: &[Range<usize>], z: &DVector<f64>) -> Self {
        Self { rows: rows.to_vec(), threshold: HUBER * spread(rows, z) }
    }

    /// With the threshold at three times a typical residual that is known.
    pub(super) fn of_scale(rows: &[Range<usize>], scale: f64) -> Self {
        Self { rows: rows.to_vec(), threshold: HUBER * scale }
    }

    /// The typical residual in standard deviations of the noise.
    pub(crate) fn scale(&self) -> f64 {
        self.threshold / HUBER
    }

    pub(super) fn value(&self, z: &DVector<f64>) -> f64 {
        let strains: f64 = self.strains(z).map(|z| z * z).sum();
        self.of_pushes(z).iter().sum::<f64>() + strains
    }

    /// Each push's part of the sum.
    pub(super) fn of_pushes(&self, z: &DVector<f64>) -> Vec<f64> {
        let of = |rows: &Range<usize>| rows.len() as f64 * self.huber(self.radius(rows, z));
        self.rows.iter().map(of).collect()
    }

    /// The weights wᵢ with which ∂F/∂zᵢ = 2 wᵢ zᵢ.
    pub(crate) fn weights(&self, z: &DVector<f64>) -> DVector<f64> {
        let mut weights = DVector::repeat(z.len(), 1.0);
        for rows in &self.rows {
            let of_push = self.weight(self.radius(rows, z));
            rows.clone().for_each(|row| weights[row] = of_push * self.weight(z[row]));
        }
        weights
    }

    fn radius(&self, rows: &Range<usize>, z: &DVector<f64>) -> f64 {
        let sum: f64 = rows.clone().map(|row| self.huber(z[row])).sum();
        (sum / rows.len().max(1) as f64).sqrt()
    }

    fn strains<'a>(&self, z: &'a DVector<f64>) -> impl Iterator<Item = &'a f64> {
        z.iter().skip(self.rows.last().map_or(0, |rows| rows.end))
    }

    fn huber(&self, z: f64) -> f64 {
        let k = self.threshold;
        if z.abs() <= k { z * z } else { k * (2.0 * z.abs() - k) }
    }

    fn weight(&self, z: f64) -> f64 {
        if z.abs() <= self.threshold { 1.0 } else { self.threshold / z.abs() }
    }
}

/// The median of the pushes' root mean squares, at least 1.
fn spread(rows: &[Range<usize>], z: &DVector<f64>) -> f64 {
    quantile(rms_of_pushes(rows, z).collect(), 0.5).unwrap_or_default().max(1.0)
}

/// The root mean square of each push that has numbers.
pub(super) fn rms_of_pushes(rows: &[Range<usize>], z: &DVector<f64>) -> impl Iterator<Item = f64> {
    rows.iter().filter(|rows| !rows.is_empty()).map(|rows| {
        let sum: f64 = rows.clone().map(|row| z[row] * z[row]).sum();
        (sum / rows.len() as f64).sqrt()
    })
}

#[cfg(test)]
mod tests {
    use super::Robust;
    use nalgebra::DVector;

    #[test]
    fn weights_are_the_slope_and_outliers_lose_theirs() {
        let rows = [0..4, 4..6, 6..9];
        let z = vec![0.3, -1.0, 40.0, 2.0, 9.0, 11.0, 0.1, -0.4, 1.1, 0.7];
        let z = DVector::from_vec(z);
        let robust = Robust::at(&rows, &DVector::repeat(10, 0.5));
        assert_eq!(robust.scale(), 1.0);
        let weights = robust.weights(&z);
        for row in 0..z.len() {
            let at = |step: f64| {
                let mut z = z.clone();
                z[row] += step;
                robust.value(&z)
            };
            let slope = (at(1e-6) - at(-1e-6)) / 2e-6;
            assert!((slope - 2.0 * weights[row] * z[row]).abs() < 1e-6, "{row}");
        }
        assert!(weights[2] < 0.1 && weights[4] < 0.4 && weights[6] == 1.0 && weights[9] == 1.0);
    }
}
