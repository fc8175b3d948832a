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
    pub(crate) parts: Vec<Part>,
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
        let mut objective = Self::empty((x, y), n_pseudo_inputs, settings);
        objective.take((x, y, row_noise), n_parameters);
        objective
    }

    /// Prepares for sums over rows that do not stay in memory.
    pub(crate) fn empty(
        (x, y): (MatRef<'_, f64>, &[f64]),
        n_pseudo_inputs: usize,
        settings: SparseSettings,
    ) -> Self {
        let (d, m) = (x.ncols(), n_pseudo_inputs);
        let sums = RowSums::new(x, y, m, settings.mean);
        let square = || Mat::zeros(m, m);
        Self {
            settings,
            parts: Vec::new(),
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

    /// Has rows in place of those that it had.
    pub(crate) fn take(&mut self, rows: (MatRef<'_, f64>, &[f64], &[f64]), n_parameters: usize) {
        let (origin, monomials) = (self.sums.origin, &self.sums.monomials);
        self.parts = Part::split(rows, origin, monomials, self.z_columns.nrows(), n_parameters);
    }

    /// The objective of rows that do not stay in memory, in nats.
    ///
    /// # Errors
    /// As `value`.
    pub(crate) fn value_of(
        &mut self,
        rows: (MatRef<'_, f64>, &[f64], &[f64]),
        kernel: &dyn Kernel,
        noise_variance: f64,
        z: &[f64],
    ) -> Result<f64, GpError> {
        self.place(kernel, z)?;
        let shared = self.shared(kernel, noise_variance);
        let (origin, monomials) = (self.sums.origin, &self.sums.monomials);
        let parts = Part::sums(rows, origin, monomials, self.z_columns.nrows(), &shared);
        self.sums.merge(parts.iter());
        self.solve()
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
        self.place(kernel, z)?;
        self.sum(kernel, noise_variance);
        self.sums.merge(self.parts.iter().map(|part| &part.sums));
        self.solve()
    }

    /// Puts pseudo-inputs in place, M×D by rows.
    ///
    /// # Errors
    /// As `value`.
    pub(crate) fn place(&mut self, kernel: &dyn Kernel, z: &[f64]) -> Result<(), GpError> {
        let (m, d) = (self.z_columns.nrows(), self.z_columns.ncols());
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
        Ok(())
    }

    /// Sums over the rows of every part.
    pub(crate) fn sum(&mut self, kernel: &dyn Kernel, noise_variance: f64) {
        let mut parts = std::mem::take(&mut self.parts);
        let shared = self.shared(kernel, noise_variance);
        parts.par_iter_mut().for_each(|part| part.sum(&shared));
        self.parts = parts;
    }

    fn shared<'a>(&'a self, kernel: &'a dyn Kernel, noise_variance: f64) -> Shared<'a> {
        Shared {
            kernel,
            z: &self.z,
            approximation: self.settings.approximation,
            noise_variance,
            factor_inverse: self.factor_inverse.as_ref(),
        }
    }

    /// Moves the sums by a share of the way to `scale` times those of the parts: a step along the natural
    /// gradient of the belief about the pseudo-outputs.
    pub(crate) fn move_to_parts(&mut self, scale: f64, share: f64) {
        self.sums.move_to(self.parts.iter().map(|part| &part.sums), scale, share);
    }

    /// What the sums tell; the objective.
    ///
    /// # Errors
    /// `NotPositiveDefinite`, `UndeterminedSlope`.
    pub(crate) fn solve(&mut self) -> Result<f64, GpError> {
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
        self.differentiate_given(kernel, noise_variance, Belief::OfTheseRows, gradient);
    }

    /// As `differentiate`, of what the rows in the parts add to the bound where the belief about the
    /// whitened pseudo-outputs stays as it was solved for, from these rows or from others.
    pub(crate) fn differentiate_given(
        &mut self,
        kernel: &dyn Kernel,
        noise_variance: f64,
        belief: Belief,
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
        self.differentiate_pseudo_covariance(kernel, belief, of_kernel, of_z);
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

    /// GᵀA less t(Vᵀw)ᵀ of each response, the lower triangle: by it L moves with a belief of other rows.
    ///
    /// # Source
    /// Murray, Differentiation of the Cholesky decomposition (2016), eq. 9.
    fn turn_with_factor(&mut self) {
        let m = self.slope.nrows();
        let mut square = Mat::zeros(self.sums.square.nrows(), self.sums.square.nrows());
        merge_lower(&mut square, self.parts.iter().map(|part| &part.sums.square));
        for Response { of_y, coefficients, whitened, .. } in &self.solved.responses {
            let with_v = |b: usize| -> f64 {
                let known: f64 = (0..m).map(|a| square[(a.max(b), a.min(b))] * whitened[a]).sum();
                let pairs = coefficients.iter().enumerate();
                let of_mean: f64 = pairs.map(|(k, c)| square[(m + 1 + k, b)] * c).sum();
                of_y * square[(m, b)] - of_mean - known
            };
            for b in 0..m {
                let factor = -with_v(b);
                add_multiple(&mut column_mut(&mut self.slope, b)[b..], factor, &whitened[b..]);
            }
        }
    }

    /// What K_uu contributes: its slope is ½ (L⁻ᵀ GᵀA L⁻¹ − Σ uuᵀ) with GᵀA from the parts.
    fn differentiate_pseudo_covariance(
        &mut self,
        kernel: &dyn Kernel,
        belief: Belief,
        of_parameters: &mut [f64],
        of_z: &mut [f64],
    ) {
        let d = self.z_columns.ncols();
        merge_lower(&mut self.slope, self.parts.iter().map(|part| &part.slopes.square));
        if belief == Belief::OfOtherRows {
            self.turn_with_factor();
        }
        mirror_lower(&mut self.slope);
        let upper = self.factor.transpose();
        solve_upper_triangular_in_place(upper, self.slope.as_mut(), Par::Seq);
        solve_upper_triangular_in_place(upper, self.slope.transpose_mut(), Par::Seq);
        mirror_lower(&mut self.gram);
        of_parameters.fill(0.0);
        of_z.fill(0.0);
        for b in 0..self.z_columns.nrows() {
            let slope = column_mut(&mut self.slope, b);
            if belief == Belief::OfTheseRows {
                for Response { weights, .. } in &self.solved.responses {
                    add_multiple(slope, -weights[b], weights);
                }
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

/// Which rows the belief about the pseudo-outputs was solved from.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Belief {
    /// Those in the parts: it is the best, so that its own changes do not matter.
    OfTheseRows,
    OfOtherRows,
}

fn add(sums: &mut [f64], terms: &[f64]) {
    sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
}

#[cfg(test)]
mod tests {
    use faer::linalg::solvers::{DenseSolveCore, Llt};
    use faer::{Mat, MatRef, Side};
    use gp_core::kernel::cross;
    use gp_core::{Kernel, Mean, SquaredExponential};

    use super::{Belief, Objective};
    use crate::SparseSettings;

    const M: usize = 5;
    const VALUES: [f64; 4] = [0.7, 0.9, 1.3, 0.05];

    fn rows(n: usize, seed: f64) -> (Mat<f64>, Vec<f64>, Vec<f64>) {
        let x = Mat::from_fn(n, 2, |i, d| (1.7 * (2 * i + d) as f64 + seed + (i * i) as f64).sin());
        let y = (0..n).map(|i| (2.0 * x[(i, 0)]).sin() + x[(i, 1)] + 0.1 * (9.1 * i as f64).sin());
        let y = y.collect();
        (x, y, (0..n).map(|i| 0.02 * (i % 3) as f64).collect())
    }

    fn kernel(values: &[f64]) -> SquaredExponential {
        SquaredExponential::new(&values[..2], values[2]).unwrap()
    }

    /// A belief about the whitened pseudo-outputs and the mean: what `Solved` makes of sums.
    struct Fixed {
        responses: Vec<(f64, Vec<f64>, Vec<f64>)>,
        covariance: Mat<f64>,
    }

    fn belief(objective: &Objective) -> Fixed {
        let one = |r: &super::Response| (r.of_y, r.coefficients.clone(), r.whitened.clone());
        let root = &objective.solved.root;
        let m = root.nrows();
        let root = Mat::from_fn(m, m, |i, j| if j <= i { root[(i, j)] } else { 0.0 });
        let precision = &root * root.transpose();
        let covariance = Llt::new(precision.as_ref(), Side::Lower).unwrap().inverse();
        Fixed { responses: objective.solved.responses.iter().map(one).collect(), covariance }
    }

    /// Σ E ln N(y | f, noise) over the rows under a belief, written out.
    fn expected(
        at: &[f64],
        z: MatRef<'_, f64>,
        (x, y, row_noise): (&Mat<f64>, &[f64], &[f64]),
        origin: f64,
        belief: &Fixed,
    ) -> f64 {
        let kernel = kernel(at);
        let mut gram = cross(&kernel, z, z).unwrap();
        (0..M).for_each(|a| gram[(a, a)] *= 1.0 + 1e-6);
        let factor = Llt::new(gram.as_ref(), Side::Lower).unwrap().L().to_owned();
        let mut psi = cross(&kernel, x.as_ref(), z).unwrap().transpose().to_owned();
        let lower = factor.as_ref();
        faer::linalg::triangular_solve::solve_lower_triangular_in_place(
            lower,
            psi.as_mut(),
            faer::Par::Seq,
        );
        let spread = psi.transpose() * &belief.covariance * &psi;
        let term = |i: usize| {
            let noise = at[3] + row_noise[i];
            let square = |(b, c, t): &(f64, Vec<f64>, Vec<f64>)| {
                let fitted: f64 = (0..M).map(|a| psi[(a, i)] * t[a]).sum();
                (b * (y[i] - origin) - c[0] - fitted).powi(2)
            };
            let squares: f64 = belief.responses.iter().map(square).sum();
            let point = [x[(i, 0)], x[(i, 1)]];
            let known: f64 = (0..M).map(|a| psi[(a, i)].powi(2)).sum();
            let leftover = kernel.value(&point, &point) - known;
            let all = squares + spread[(i, i)] + leftover;
            -0.5 * ((std::f64::consts::TAU * noise).ln() + all / noise)
        };
        (0..y.len()).map(term).sum()
    }

    fn objective(mean: Mean) -> (Objective, Mat<f64>) {
        let settings = SparseSettings { mean, jitter: 1e-6, ..SparseSettings::default() };
        let (x, y, noise) = rows(300, 0.3);
        let z = rows(M, 1.1).0;
        let mut objective = Objective::new(x.as_ref(), &y, &noise, M, 3, settings);
        objective.value(&kernel(&VALUES), VALUES[3], &by_rows(&z)).unwrap();
        (objective, z)
    }

    fn by_rows(z: &Mat<f64>) -> Vec<f64> {
        crate::sparse_gp::rows_of(z.as_ref())
    }

    #[test]
    fn of_all_rows_and_the_best_belief_the_bound_is_the_collapsed_one() {
        let (objective, z) = objective(Mean::Fixed(0.2));
        let (x, y, noise) = rows(300, 0.3);
        let own = belief(&objective);
        let bound = |belief: &Fixed| {
            let data = (&x, &*y, &*noise);
            let told = expected(&VALUES, z.as_ref(), data, objective.sums.origin, belief);
            let trace: f64 = (0..M).map(|a| belief.covariance[(a, a)]).sum();
            let square: f64 = belief.responses[0].2.iter().map(|t| t * t).sum();
            let factor = Llt::new(belief.covariance.as_ref(), Side::Lower).unwrap();
            let determinant: f64 = (0..M).map(|a| 2.0 * factor.L()[(a, a)].ln()).sum();
            told - 0.5 * (trace + square - M as f64 - determinant)
        };
        let (best, collapsed) = (bound(&own), objective.solved.value);
        assert!((best - collapsed).abs() < 1e-9 * collapsed.abs(), "{best} {collapsed}");
        let mut other = belief(&objective);
        other.responses[0].2[1] += 0.05;
        assert!(bound(&other) < best);
        let other = Fixed { covariance: 1.2 * &own.covariance, ..own };
        assert!(bound(&other) < best);
    }

    #[test]
    fn slopes_under_the_belief_of_other_rows_are_those_of_differences() {
        for mean in [Mean::Fixed(0.2), Mean::Estimated] {
            let (mut objective, z) = objective(mean);
            let (fixed, origin) = (belief(&objective), objective.sums.origin);
            let (x, y, noise) = rows(70, 2.9);
            objective.take((x.as_ref(), &y, &noise), 3);
            objective.sum(&kernel(&VALUES), VALUES[3]);
            let mut gradient = vec![0.0; 4 + 2 * M];
            let of_others = Belief::OfOtherRows;
            objective.differentiate_given(&kernel(&VALUES), VALUES[3], of_others, &mut gradient);
            for (index, slope) in gradient.iter().enumerate() {
                let at = |step: f64| {
                    let (mut values, mut z) = (VALUES, z.clone());
                    match index.checked_sub(4) {
                        None => values[index] *= step.exp(),
                        Some(entry) => z[(entry / 2, entry % 2)] += step,
                    }
                    expected(&values, z.as_ref(), (&x, &y, &noise), origin, &fixed)
                };
                let numeric = (at(1e-5) - at(-1e-5)) / 2e-5;
                let close = (slope - numeric).abs() < 1e-5 * (1.0 + numeric.abs());
                assert!(close, "{mean:?} {index}: {slope} {numeric}");
            }
        }
    }
}
