//! Gradients of an exact Gaussian process by its inputs.

use faer::{Mat, MatRef};

use crate::checks::check_inputs;
use crate::kernel::copy_row;
use crate::mean::{Deviation, Trend};
use crate::root::Root;
use crate::{Gp, GpError, Posterior};

impl Gp {
    /// The gradient of the posterior mean by the inputs, M×D, one row an input.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch` or `NotFinite` if `x_star` is not a finite M×D matrix.
    pub fn mean_gradient(&self, x_star: MatRef<'_, f64>) -> Result<Mat<f64>, GpError> {
        check_inputs("inputs", x_star, self.n_inputs())?;
        Ok(self.gradient(&self.trend, &self.weights, x_star))
    }

    /// That of a trend and a weighted sum of the kernel's columns.
    fn gradient(&self, trend: &Trend, weights: &[f64], x_star: MatRef<'_, f64>) -> Mat<f64> {
        let n_inputs = self.n_inputs();
        let (mut a, mut b) = (vec![0.0; n_inputs], vec![0.0; n_inputs]);
        let mut slope = vec![0.0; n_inputs];
        let mut gradient = Mat::zeros(x_star.nrows(), n_inputs);
        for i in 0..x_star.nrows() {
            copy_row(x_star, i, &mut a);
            for (j, weight) in weights.iter().enumerate() {
                copy_row(self.inputs(), j, &mut b);
                self.kernel().input_gradient(&a, &b, &mut slope);
                for (d, slope) in slope.iter().enumerate() {
                    gradient[(i, d)] += weight * slope;
                }
            }
            slope.fill(0.0);
            trend.add_gradient(&a, &mut slope);
            for (d, slope) in slope.iter().enumerate() {
                gradient[(i, d)] += slope;
            }
        }
        gradient
    }

    /// The gradient of the posterior variance of f by the inputs, M×D, one row an input; O(N²) each.
    ///
    /// ∂k**/∂x − 2 (∂k*/∂x)ᵀ (K + σₙ² I)⁻¹ k*, and 2 d ∂d/∂x for each deviation d of a learnt mean.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch` or `NotFinite` if `x_star` is not a finite M×D matrix.
    pub fn variance_gradient(&self, x_star: MatRef<'_, f64>) -> Result<Mat<f64>, GpError> {
        check_inputs("inputs", x_star, self.n_inputs())?;
        let n_inputs = self.n_inputs();
        let (mut a, mut slope) = (vec![0.0; n_inputs], vec![0.0; n_inputs]);
        let mut values = vec![0.0; self.y.len()];
        let mut gradient = Mat::zeros(x_star.nrows(), n_inputs);
        for i in 0..x_star.nrows() {
            copy_row(x_star, i, &mut a);
            self.kernel().column(self.inputs(), &a, &mut values);
            let mut weights = values.clone();
            self.factor.solve_whole(&mut weights);
            self.kernel().input_gradient(&a, &a, &mut slope);
            let mut explained = vec![0.0; n_inputs];
            let of_input = &mut explained;
            self.kernel().column_gradient(self.inputs(), &a, &values, &weights, &mut [], of_input);
            for (d, (slope, explained)) in slope.iter().zip(&explained).enumerate() {
                // k(x, x) moves with both of its arguments.
                gradient[(i, d)] = 2.0 * (slope - explained);
            }
        }
        for Deviation { trend, weights } in &self.deviations {
            let values = self.values(trend, weights, x_star)?;
            let slopes = self.gradient(trend, weights, x_star);
            for (i, value) in values.iter().enumerate() {
                (0..n_inputs).for_each(|d| gradient[(i, d)] += 2.0 * value * slopes[(i, d)]);
            }
        }
        Ok(gradient)
    }
}
