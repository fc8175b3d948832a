//! The five-diagonal system behind smoothing splines.

/// LDLᵀ of the positive definite five-diagonal matrix R + λ QᵀQ over the inner knots, where Qᵀy are
/// the changes of slope from knot to knot and R the Gram matrix of the second derivative's hats.
#[derive(Clone, Debug)]
pub(crate) struct Banded {
    diagonal: Vec<f64>,
    first: Vec<f64>,
    second: Vec<f64>,
}

impl Banded {
    /// The factors for increasing times (s) and a penalty λ (s³).
    pub(crate) fn new(t: &[f64], penalty: f64) -> Self {
        let n = t.len().saturating_sub(2);
        let h = |k: usize| t[k + 1] - t[k];
        // Without a penalty, which interpolates, the terms with Q are zero.
        let q = |k: usize| match penalty {
            0.0 => (0.0, 0.0, 0.0),
            _ => (1.0 / h(k), -1.0 / h(k) - 1.0 / h(k + 1), 1.0 / h(k + 1)),
        };
        let mut diagonal = vec![0.0; n];
        let mut first = vec![0.0; n];
        let mut second = vec![0.0; n];
        for k in 0..n {
            let (a, b, c) = q(k);
            let mut d = (h(k) + h(k + 1)) / 3.0 + penalty * (a * a + b * b + c * c);
            let mut e = if k + 1 < n {
                let (next_a, next_b, _) = q(k + 1);
                h(k + 1) / 6.0 + penalty * (b * next_a + c * next_b)
            } else {
                0.0
            };
            let f = if k + 2 < n { penalty * c / h(k + 2) } else { 0.0 };
            if k >= 1 {
                d -= first[k - 1] * first[k - 1] * diagonal[k - 1];
                e -= first[k - 1] * second[k - 1] * diagonal[k - 1];
            }
            if k >= 2 {
                d -= second[k - 2] * second[k - 2] * diagonal[k - 2];
            }
            diagonal[k] = d;
            first[k] = e / d;
            second[k] = f / d;
        }
        Self { diagonal, first, second }
    }

    /// Replaces right-hand sides, one a column, by their solutions.
    ///
    /// Each step waits for the one before: columns side by side fill the time.
    pub(crate) fn solve<const K: usize>(&self, x: &mut [[f64; K]]) {
        let subtract = |x: &mut [f64; K], factor: f64, other: [f64; K]| {
            for (x, other) in x.iter_mut().zip(other) {
                *x -= factor * other;
            }
        };
        let n = x.len();
        let [mut before, mut two_before] = [[0.0; K]; 2];
        for (i, row) in x.iter_mut().enumerate() {
            if i >= 1 {
                subtract(row, self.first[i - 1], before);
            }
            if i >= 2 {
                subtract(row, self.second[i - 2], two_before);
            }
            (before, two_before) = (*row, before);
        }
        let [mut after, mut two_after] = [[0.0; K]; 2];
        for (i, row) in x.iter_mut().enumerate().rev() {
            *row = row.map(|x| x / self.diagonal[i]);
            if i + 1 < n {
                subtract(row, self.first[i], after);
            }
            if i + 2 < n {
                subtract(row, self.second[i], two_after);
            }
            (after, two_after) = (*row, after);
        }
    }

    /// Logarithm of the determinant.
    pub(crate) fn log_determinant(&self) -> f64 {
        self.diagonal.iter().map(|d| d.ln()).sum()
    }

    /// The inverse's diagonal and its first and second upper diagonals.
    ///
    /// # Source
    /// Hutchinson & de Hoog (1985), "Smoothing noisy data with spline functions".
    pub(crate) fn inverse_bands(&self) -> [Vec<f64>; 3] {
        let n = self.diagonal.len();
        let mut bands = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
        for i in (0..n).rev() {
            let (e, f) = (self.first[i], self.second[i]);
            let at = |band: usize, k: usize| bands[band].get(k).copied().unwrap_or(0.0);
            let second = -e * at(1, i + 1) - f * at(0, i + 2);
            let first = -e * at(0, i + 1) - f * at(1, i + 1);
            let diagonal = 1.0 / self.diagonal[i] - e * first - f * second;
            (bands[0][i], bands[1][i], bands[2][i]) = (diagonal, first, second);
        }
        bands
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::Banded;

    #[test]
    fn factors_agree_with_the_dense_matrix() {
        let t = [0.0, 0.3, 1.1, 1.25, 2.0, 3.7, 4.0];
        let n = t.len() - 2;
        for penalty in [0.0, 0.02, 3.0] {
            let h = |k: usize| t[k + 1] - t[k];
            let mut q = DMatrix::zeros(t.len(), n);
            let mut r = DMatrix::zeros(n, n);
            for k in 0..n {
                q[(k, k)] = 1.0 / h(k);
                q[(k + 1, k)] = -1.0 / h(k) - 1.0 / h(k + 1);
                q[(k + 2, k)] = 1.0 / h(k + 1);
                r[(k, k)] = (h(k) + h(k + 1)) / 3.0;
                if k + 1 < n {
                    (r[(k, k + 1)], r[(k + 1, k)]) = (h(k + 1) / 6.0, h(k + 1) / 6.0);
                }
            }
            let dense = r + penalty * q.transpose() * &q;
            let banded = Banded::new(&t, penalty);
            assert!((banded.log_determinant() - dense.determinant().ln()).abs() < 1e-12);
            let inverse = dense.clone().try_inverse().unwrap();
            let bands = banded.inverse_bands();
            for (offset, band) in bands.iter().enumerate() {
                for i in 0..n - offset {
                    assert!((band[i] - inverse[(i, i + offset)]).abs() < 1e-12, "{offset} {i}");
                }
            }
            let right = [[1.0, 0.5], [-2.0, 1.5], [0.5, -1.0], [0.0, 4.0], [3.0, 0.0]];
            let mut x = right;
            banded.solve(&mut x);
            let matrix = |rows: &[[f64; 2]; 5]| DMatrix::from_fn(n, 2, |i, k| rows[i][k]);
            assert!((dense * matrix(&x) - matrix(&right)).norm() < 1e-11);
        }
    }
}
