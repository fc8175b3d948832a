//! The likelihood of several outputs at the same inputs, by factors of the size of one output's rows.

use faer::{Mat, MatRef};
use rayon::prelude::{IndexedParallelIterator, ParallelIterator};

use crate::cholesky::invert;
use crate::factor::shared_rows;
use crate::kernel::{
    COLUMNS, Coregionalized, SharedRows, column, column_of, copy_row, fill_lower_gram,
};
use crate::kronecker::{Kronecker, Mixing};
use crate::mean::Residual;
use crate::noise::Noise;
use crate::triangle::scratch_rows;
use crate::vector::{add_multiple, dot};
use crate::{GpError, Kernel, Mean};

/// ln p(y | X, θ) and its gradient for Σ = B ⊗ K + R ⊗ I; owns the matrices.
///
/// With S = Σᵢ λᵢ (λᵢ K + I)⁻¹ and the weights of output p in column p of A, the slopes are
/// ½ (A B Aᵀ − S) by K, ½ (Aᵀ K A)_pq − ½ Σᵢ W_ip W_iq tr(K (λᵢ K + I)⁻¹) by B, and those by R have I
/// in place of the K in it. What a learnt mean leaves open adds the same of its weights.
pub(crate) struct SharedLikelihood {
    gram: Mat<f64>,
    factors: Vec<Mat<f64>>,
    scratch: Mat<f64>,
}

impl SharedLikelihood {
    /// Without memory yet.
    pub(crate) fn new() -> Self {
        Self { gram: Mat::new(), factors: Vec::new(), scratch: Mat::new() }
    }

    /// ln p, and its gradient as of all rows together; none where the covariance has no such form, or is
    /// too near to singular for it.
    pub(crate) fn evaluate(
        &mut self,
        kernel: &dyn Kernel,
        (x, y, mean): (MatRef<'_, f64>, &[f64], Mean),
        noise: Noise<'_>,
        gradient: &mut [f64],
    ) -> Option<Result<f64, GpError>> {
        let (form, rows) = shared_rows(kernel, x, noise)?;
        if self.gram.nrows() != rows.n {
            self.gram = Mat::zeros(rows.n, rows.n);
            self.scratch = Mat::zeros(scratch_rows(rows.n), rows.n);
        }
        let shared_x = x.subrows(0, rows.n);
        fill_lower_gram(form.shared(), shared_x, &mut self.gram);
        let of_outputs = form.of_outputs(&rows);
        let mixing = Mixing::new(&of_outputs, &form.of_noise(&rows, noise.common)).ok()?;
        let known = std::mem::take(&mut self.factors);
        let kronecker = Kronecker::new(mixing, &self.gram, known).ok()?;
        let residual = match Residual::solve(&kronecker, x, y, mean) {
            Ok(residual) => residual,
            Err(error) => return Some(Err(error)),
        };
        let Kronecker { mixing, factors, .. } = kronecker;
        self.factors = factors;
        for factor in &mut self.factors {
            invert(factor.as_mut(), self.scratch.as_mut());
        }
        gradient.fill(0.0);
        let vectors = Vectors::new(&residual, rows.n);
        self.add_by_outputs(&form, &rows, &mixing, &vectors, noise.common, gradient);
        self.add_by_inputs(&form, shared_x, &mixing, (&vectors, &of_outputs), gradient);
        Some(Ok(residual.log_likelihood))
    }

    /// Adds the slopes by the parameters of B, R and, last, the noise variance.
    fn add_by_outputs(
        &self,
        form: &Coregionalized,
        rows: &SharedRows,
        mixing: &Mixing,
        vectors: &Vectors<'_>,
        noise_variance: f64,
        gradient: &mut [f64],
    ) {
        let n_outputs = mixing.eigenvalues.len();
        let (mut by_outputs, mut by_noise) =
            (Mat::zeros(n_outputs, n_outputs), Mat::zeros(n_outputs, n_outputs));
        for vector in &vectors.0 {
            let moved: Vec<Vec<f64>> =
                vector.iter().map(|block| multiply_lower(&self.gram, block)).collect();
            for p in 0..n_outputs {
                for q in 0..n_outputs {
                    by_outputs[(p, q)] += 0.5 * dot(vector[p], &moved[q]);
                    by_noise[(p, q)] += 0.5 * dot(vector[p], vector[q]);
                }
            }
        }
        for (i, inverse) in self.factors.iter().enumerate() {
            let (trace, with_gram) = traces(inverse, &self.gram);
            for p in 0..n_outputs {
                for q in 0..n_outputs {
                    let share = 0.5 * mixing.mix[(i, p)] * mixing.mix[(i, q)];
                    by_outputs[(p, q)] -= share * with_gram;
                    by_noise[(p, q)] -= share * trace;
                }
            }
        }
        form.add_slopes(rows, &by_outputs, &by_noise, gradient);
        let trace: f64 = (0..n_outputs).map(|p| by_noise[(p, p)]).sum();
        if let Some(slope) = gradient.last_mut() {
            *slope += noise_variance * trace;
        }
    }

    /// Adds the slopes by the parameters of K; spoils the first inverse.
    fn add_by_inputs(
        &mut self,
        form: &Coregionalized,
        x: MatRef<'_, f64>,
        mixing: &Mixing,
        (vectors, of_outputs): (&Vectors<'_>, &Mat<f64>),
        gradient: &mut [f64],
    ) {
        let pairs = vectors.mixed(of_outputs);
        let of_shared = form.of_shared(gradient);
        let (gram, n_parameters) = (&self.gram, of_shared.len());
        let Some((first, others)) = self.factors.split_first_mut() else { return };
        let blocks = first.par_col_chunks_mut(COLUMNS).enumerate();
        let parts: Vec<Vec<f64>> = blocks
            .map(|(block, mut slopes)| {
                let mut part = vec![0.0; n_parameters];
                let mut b = vec![0.0; x.ncols()];
                for k in 0..slopes.ncols() {
                    let j = block * COLUMNS + k;
                    let slope = &mut column_of(slopes.as_mut(), k)[j..];
                    slope.iter_mut().for_each(|slope| *slope *= -mixing.eigenvalues[0]);
                    for (inverse, eigenvalue) in others.iter().zip(&mixing.eigenvalues[1..]) {
                        add_multiple(slope, -eigenvalue, &column(inverse, j)[j..]);
                    }
                    for (mixed, known) in &pairs {
                        add_multiple(slope, known[j], &mixed[j..]);
                    }
                    // The lower triangle stands for both, the diagonal for half of them.
                    slope[0] *= 0.5;
                    copy_row(x, j, &mut b);
                    let (rows, values) = (x.subrows(j, slope.len()), &column(gram, j)[j..]);
                    form.shared().column_gradient(rows, &b, values, slope, &mut part, &mut []);
                }
                part
            })
            .collect();
        for (i, slope) in of_shared.iter_mut().enumerate() {
            *slope += parts.iter().map(|part| part[i]).sum::<f64>();
        }
    }
}

/// The weights of the outputs, and those of what a learnt mean leaves open; each a block an output.
struct Vectors<'a>(Vec<Vec<&'a [f64]>>);

impl<'a> Vectors<'a> {
    fn new(residual: &'a Residual, n: usize) -> Self {
        let deviations = residual.deviations.iter().map(|deviation| &deviation.weights);
        let all = std::iter::once(&residual.weights).chain(deviations);
        Self(all.map(|weights| weights.chunks_exact(n).collect()).collect())
    }

    /// Each block of each vector beside Σ_p B_pq of them.
    fn mixed(&self, of_outputs: &Mat<f64>) -> Vec<(Vec<f64>, &'a [f64])> {
        let mixed = |vector: &[&'a [f64]], q: usize| {
            let mut sum = vec![0.0; vector[q].len()];
            for (p, block) in vector.iter().enumerate() {
                add_multiple(&mut sum, of_outputs[(p, q)], block);
            }
            (sum, vector[q])
        };
        self.0.iter().flat_map(|vector| (0..vector.len()).map(|q| mixed(vector, q))).collect()
    }
}

/// A symmetric matrix, of which the lower triangle is given, times a vector.
fn multiply_lower(matrix: &Mat<f64>, vector: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; vector.len()];
    for j in 0..vector.len() {
        let lower = &column(matrix, j)[j..];
        add_multiple(&mut product[j..], vector[j], lower);
        product[j] += dot(&lower[1..], &vector[j + 1..]);
    }
    product
}

/// The trace of a symmetric matrix, and of its product with another; of both the lower triangle is given.
fn traces(one: &Mat<f64>, other: &Mat<f64>) -> (f64, f64) {
    let mut sums = (0.0, 0.0);
    for j in 0..one.ncols() {
        let (a, b) = (&column(one, j)[j..], &column(other, j)[j..]);
        sums.0 += a[0];
        sums.1 += 2.0 * dot(a, b) - a[0] * b[0];
    }
    sums
}
