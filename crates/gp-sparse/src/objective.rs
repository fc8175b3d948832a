//! The objective of all sparse approximations, ln N(y | m, Q + D) less a penalty, and its gradient.

use std::f64::consts::PI;

use faer::linalg::triangular_solve::solve_upper_triangular_in_place;
use faer::{Mat, MatRef, Par};
use gp_core::cholesky::{factorize, invert, log_determinant};
use gp_core::kernel::{column, column_mut, fill_lower_gram, mirror_lower};
use gp_core::triangle::{self, clear_above, scratch_rows, solve_lower};
use gp_core::vector::{add_multiple, dot};
use gp_core::{GpError, Kernel, Mean};
use rayon::prelude::{IntoParallelRefMutIterator, ParallelIterator};

use crate::SparseSettings;
use crate::block::{Response, Shared, Solution};
use crate::deviation::Deviation;
use crate::part::Part;

pub(crate) const PSEUDO_COVARIANCE: &str = "covariance of the pseudo-outputs";
pub(crate) const PRECISION: &str = "precision of the pseudo-outputs";

/// ln p(y | X, Z, θ) for one data set and many Z and θ; owns all memory, 16 N M bytes.
///
/// With K_uu = L Lᵀ, V = K_fu L⁻ᵀ and B = I + VᵀD⁻¹V the determinant lemma and its inverse give
/// ln |Q + D| = ln |B| + ln |D| and (Q + D)⁻¹ = D⁻¹ − D⁻¹VB⁻¹VᵀD⁻¹. O(N M²).
pub(crate) struct Objective {
    settings: SparseSettings,
    /// Subtracted from all outputs, so that far offsets cost no digits.
    origin: f64,
    n_rows: usize,
    parts: Vec<Part>,
    /// (V, y, 1)ᵀ D⁻¹ (V, y, 1), the lower triangle.
    sums: Mat<f64>,
    /// Pseudo-inputs, M×D by rows and as a matrix.
    z: Vec<f64>,
    z_columns: Mat<f64>,
    /// K_uu with its jitter, then a matrix of slopes.
    gram: Mat<f64>,
    factor: Mat<f64>,
    pub(crate) factor_inverse: Mat<f64>,
    /// The Cholesky factor R of B.
    pub(crate) root: Mat<f64>,
    inverse: Mat<f64>,
    scratch: Mat<f64>,
    slope: Mat<f64>,
    /// That of the mean, less the data's origin, and that of its standard deviation if it is learnt.
    responses: Vec<Response>,
}

impl Objective {
    /// Prepares for data that have been checked; `row_noise` is one a row, or none.
    pub(crate) fn new(
        x: MatRef<'_, f64>,
        y: &[f64],
        row_noise: &[f64],
        n_pseudo_inputs: usize,
        n_parameters: usize,
        settings: SparseSettings,
    ) -> Self {
        let (n, d, m) = (x.nrows(), x.ncols(), n_pseudo_inputs);
        let origin = y.iter().sum::<f64>() / n as f64;
        let square = || Mat::zeros(m, m);
        Self {
            settings,
            origin,
            n_rows: n,
            parts: Part::split(x, y, row_noise, origin, m, n_parameters),
            sums: Mat::zeros(m + 2, m + 2),
            z: vec![0.0; m * d],
            z_columns: Mat::zeros(m, d),
            gram: square(),
            factor: square(),
            factor_inverse: square(),
            root: square(),
            inverse: square(),
            scratch: Mat::zeros(scratch_rows(m), m),
            slope: square(),
            responses: vec![Response::new(m); 1 + settings.mean.n_coefficients(0)],
        }
    }

    /// The mean at x is c + k(x, Z) u.
    pub(crate) fn mean(&self) -> Deviation {
        let Response { constant, weights, .. } = &self.responses[0];
        Deviation { constant: self.origin + constant, weights: weights.clone() }
    }

    /// By how much the function moves with a standard deviation of a learnt mean.
    pub(crate) fn deviation(&self) -> Option<Deviation> {
        let Response { constant, weights, .. } = self.responses.get(1)?;
        Some(Deviation { constant: *constant, weights: weights.clone() })
    }

    /// The objective in nats for pseudo-inputs `z`, M×D by rows.
    ///
    /// # Errors
    /// `NotPositiveDefinite` if the pseudo-inputs are too close for the jitter.
    pub(crate) fn value(
        &mut self,
        kernel: &dyn Kernel,
        noise_variance: f64,
        z: &[f64],
    ) -> Result<f64, GpError> {
        let d = self.z_columns.ncols();
        let m = self.z_columns.nrows();
        self.z.copy_from_slice(z);
        for (i, value) in z.iter().enumerate() {
            self.z_columns[(i / d, i % d)] = *value;
        }
        fill_lower_gram(kernel, self.z_columns.as_ref(), &mut self.gram);
        self.factor.copy_from(&self.gram);
        for a in 0..m {
            self.factor[(a, a)] *= 1.0 + self.settings.jitter;
        }
        factorize(PSEUDO_COVARIANCE, self.factor.as_mut())?;
        self.factor_inverse.copy_from(&self.factor);
        triangle::invert(self.factor_inverse.as_mut(), self.scratch.as_mut());
        clear_above(self.factor_inverse.as_mut());
        let shared = Shared {
            kernel,
            z: &self.z,
            approximation: self.settings.approximation,
            noise_variance,
            factor_inverse: self.factor_inverse.as_ref(),
        };
        self.parts.par_iter_mut().for_each(|part| part.sum(&shared));
        self.solve()
    }

    /// Merges the parts' sums and solves for the weights.
    ///
    /// With a learnt mean the value is a density of what the mean does not touch, as in
    /// [`gp_core::Gp::log_marginal_likelihood`].
    fn solve(&mut self) -> Result<f64, GpError> {
        let m = self.z_columns.nrows();
        merge_lower(&mut self.sums, self.parts.iter().map(|part| &part.sums.square));
        self.root.copy_from(self.sums.as_ref().get(..m, ..m));
        for a in 0..m {
            self.root[(a, a)] += 1.0;
        }
        factorize(PRECISION, self.root.as_mut())?;
        let total = |term: fn(&Part) -> f64| self.parts.iter().map(term).sum::<f64>();
        let row = |i: usize| (0..m).map(|a| self.sums[(i, a)]).collect::<Vec<f64>>();
        let (mut of_y, mut of_one) = (row(m), row(m + 1));
        solve_lower(self.root.as_ref(), &mut [&mut of_y, &mut of_one]);
        let one_one = self.sums[(m + 1, m + 1)] - dot(&of_one, &of_one);
        let one_y = self.sums[(m + 1, m)] - dot(&of_one, &of_y);
        let y_y = self.sums[(m, m)] - dot(&of_y, &of_y);
        let constant = match self.settings.mean {
            Mean::Fixed(value) => value - self.origin,
            _ => one_y / one_one,
        };
        let quadratic = y_y - 2.0 * constant * one_y + constant * constant * one_one;
        let factors = [self.root.as_ref(), self.factor.as_ref()];
        self.responses[0].solve((1.0, constant), [&of_y, &of_one], factors);
        let mut determinant =
            log_determinant(self.root.as_ref()) + total(|part| part.sums.log_determinant);
        let mut n_told = self.n_rows;
        if let Some(deviation) = self.responses.get_mut(1) {
            if one_one <= m as f64 * f64::EPSILON * self.sums[(m + 1, m + 1)] {
                let what = "precision of the mean";
                return Err(GpError::NotPositiveDefinite { what, size: 1, pivot: 0 });
            }
            deviation.solve((0.0, one_one.sqrt().recip()), [&of_y, &of_one], factors);
            determinant += (one_one / self.n_rows as f64).ln();
            n_told -= 1;
        }
        let normalization = n_told as f64 * (2.0 * PI).ln();
        let approximation = self.settings.approximation;
        let penalty = (1.0 - approximation.alpha()) * total(|part| part.sums.penalty);
        Ok(-0.5 * (quadratic + determinant + normalization + penalty))
    }

    /// The gradient at the place of the last `value`: by the kernel's log-parameters, by ln σₙ²,
    /// and, if `gradient` has room, by the pseudo-inputs, M×D by rows.
    pub(crate) fn differentiate(
        &mut self,
        kernel: &dyn Kernel,
        noise_variance: f64,
        gradient: &mut [f64],
    ) {
        let n_parameters = self.parts[0].slopes.kernel.len();
        let (of_parameters, of_z) = gradient.split_at_mut(n_parameters + 1);
        self.invert_root();
        let shared = Shared {
            kernel,
            z: &self.z,
            approximation: self.settings.approximation,
            noise_variance,
            factor_inverse: self.factor_inverse.as_ref(),
        };
        let solution = Solution {
            inverse: self.inverse.as_ref(),
            responses: &self.responses,
            has_free_z: !of_z.is_empty(),
        };
        self.parts.par_iter_mut().for_each(|part| part.differentiate(&shared, &solution));
        let (of_noise, of_kernel) = of_parameters.split_last_mut().expect("the noise comes last");
        self.differentiate_pseudo_covariance(kernel, of_kernel, of_z);
        *of_noise = 0.0;
        for slopes in self.parts.iter().map(|part| &part.slopes) {
            *of_noise += slopes.noise;
            add(of_kernel, &slopes.kernel);
            add(of_z, &slopes.z);
        }
    }

    /// B⁻¹, both triangles.
    fn invert_root(&mut self) {
        self.inverse.copy_from(&self.root);
        invert(self.inverse.as_mut(), self.scratch.as_mut());
        mirror_lower(&mut self.inverse);
    }

    /// What K_uu contributes: its slope is ½ (L⁻ᵀ GᵀA L⁻¹ − Σ uuᵀ) with GᵀA from the parts.
    fn differentiate_pseudo_covariance(
        &mut self,
        kernel: &dyn Kernel,
        of_parameters: &mut [f64],
        of_z: &mut [f64],
    ) {
        let d = self.z_columns.ncols();
        merge_lower(&mut self.slope, self.parts.iter().map(|part| &part.slopes.square));
        mirror_lower(&mut self.slope);
        let upper = self.factor.transpose();
        solve_upper_triangular_in_place(upper, self.slope.as_mut(), Par::Seq);
        solve_upper_triangular_in_place(upper, self.slope.transpose_mut(), Par::Seq);
        mirror_lower(&mut self.gram);
        of_parameters.fill(0.0);
        of_z.fill(0.0);
        for b in 0..self.z_columns.nrows() {
            let slope = column_mut(&mut self.slope, b);
            for Response { weights, .. } in &self.responses {
                add_multiple(slope, -weights[b], weights);
            }
            slope.iter_mut().for_each(|slope| *slope *= 0.5);
            slope[b] *= 1.0 + self.settings.jitter;
            let (z, z_b) = (self.z_columns.as_ref(), &self.z[b * d..(b + 1) * d]);
            let values = column(&self.gram, b);
            kernel.column_gradient(z, z_b, values, slope, of_parameters, &mut []);
            if !of_z.is_empty() {
                slope.iter_mut().for_each(|slope| *slope *= 2.0);
                let of_z = &mut of_z[b * d..(b + 1) * d];
                kernel.column_gradient(z, z_b, values, slope, &mut [], of_z);
            }
        }
    }
}

/// The sum of lower triangles.
fn merge_lower<'a>(sum: &mut Mat<f64>, parts: impl Iterator<Item = &'a Mat<f64>>) {
    sum.fill(0.0);
    for part in parts {
        for j in 0..part.ncols() {
            let column_sum = &mut column_mut(sum, j)[j..];
            for (sum, part) in column_sum.iter_mut().zip(&column(part, j)[j..]) {
                *sum += part;
            }
        }
    }
}

fn add(sums: &mut [f64], terms: &[f64]) {
    sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
}
