//! The objective of all sparse approximations, ln N(y | m, Q + D) less a penalty, and its gradient.

use faer::linalg::triangular_solve::solve_upper_triangular_in_place;
use faer::{Mat, MatRef, Par};
use gp_core::cholesky::{factorize, invert};
use gp_core::kernel::{column, column_mut, fill_lower_gram, mirror_lower};
use gp_core::triangle::{self, clear_above, scratch_rows};
use gp_core::vector::add_multiple;
use gp_core::{GpError, Kernel};
use rayon::prelude::{IntoParallelRefMutIterator, ParallelIterator};

use crate::SparseSettings;
use crate::block::{Response, Shared, Solution};
use crate::part::Part;
use crate::row_sums::{RowSums, Solved, merge_lower};

pub(crate) const PSEUDO_COVARIANCE: &str = "covariance of the pseudo-outputs";

/// ln p(y | X, Z, θ) for one data set and many Z and θ; owns all memory, 16 N M bytes.
///
/// With K_uu = L Lᵀ, V = K_fu L⁻ᵀ and B = I + VᵀD⁻¹V the determinant lemma and its inverse give
/// ln |Q + D| = ln |B| + ln |D| and (Q + D)⁻¹ = D⁻¹ − D⁻¹VB⁻¹VᵀD⁻¹. O(N M²).
pub(crate) struct Objective {
    settings: SparseSettings,
    parts: Vec<Part>,
    pub(crate) sums: RowSums,
    /// Pseudo-inputs, M×D by rows and as a matrix.
    z: Vec<f64>,
    z_columns: Mat<f64>,
    /// K_uu with its jitter, then a matrix of slopes.
    gram: Mat<f64>,
    factor: Mat<f64>,
    pub(crate) factor_inverse: Mat<f64>,
    pub(crate) solved: Solved,
    inverse: Mat<f64>,
    scratch: Mat<f64>,
    slope: Mat<f64>,
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
        let (d, m) = (x.ncols(), n_pseudo_inputs);
        let sums = RowSums::new(x, y, m, settings.mean);
        let square = || Mat::zeros(m, m);
        Self {
            settings,
            parts: Part::split((x, y, row_noise), sums.origin, &sums.monomials, m, n_parameters),
            sums,
            z: vec![0.0; m * d],
            z_columns: Mat::zeros(m, d),
            gram: square(),
            factor: square(),
            factor_inverse: square(),
            solved: Solved::new(m),
            inverse: square(),
            scratch: Mat::zeros(scratch_rows(m), m),
            slope: square(),
        }
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
        self.sums.merge(self.parts.iter().map(|part| &part.sums));
        self.solved.solve(&self.sums, self.factor.as_ref(), self.settings)?;
        Ok(self.solved.value)
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
            responses: &self.solved.responses,
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
        self.inverse.copy_from(&self.solved.root);
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
            for Response { weights, .. } in &self.solved.responses {
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

fn add(sums: &mut [f64], terms: &[f64]) {
    sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
}
