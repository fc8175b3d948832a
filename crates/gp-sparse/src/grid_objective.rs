//! The likelihood of rows that are seen through a grid, and its gradient.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use gp_core::cholesky::factorize;
use gp_core::kernel::{column, column_of, copy_row, fill_lower_gram};
use gp_core::triangle::{clear_above, solve_rows};
use gp_core::vector::{add_multiple, dot};
use gp_core::{GpError, Kernel, Mean, Monomials};
use rayon::prelude::{IndexedParallelIterator, ParallelIterator};

use crate::block::Response;
use crate::grid_sums::GridSums;
use crate::objective::PSEUDO_COVARIANCE;
use crate::row_sums::{RowSums, Solved};
use crate::{Approximation, SparseSettings};

/// ln N(y | H c, W K Wᵀ + σₙ² I) for one set of rows and many parameters; O(M³), whatever N is.
///
/// K is the covariance of the M nodes and W their shares in the rows. With K = L Lᵀ and S = WᵀW it is the
/// likelihood of a sparse process with V = W L, so that B = I + LᵀSL/σₙ².
pub(crate) struct GridObjective<'a> {
    sums: &'a GridSums,
    z: Mat<f64>,
    settings: SparseSettings,
    /// H at the nodes: W reproduces it at the rows.
    basis: Vec<Vec<f64>>,
    /// WᵀH.
    of_basis: Vec<Vec<f64>>,
    rows: RowSums,
    pub(crate) gram: Mat<f64>,
    /// L.
    pub(crate) factor: Mat<f64>,
    /// S L, later S L R⁻ᵀ.
    product: Mat<f64>,
    /// L R⁻ᵀ.
    turned: Mat<f64>,
    slope: Mat<f64>,
    pub(crate) solved: Solved,
}

impl<'a> GridObjective<'a> {
    /// - `z`: the nodes, M×D; - `mean`: of degree 2 at most; - `jitter`: of the nodes' variance.
    pub(crate) fn new(sums: &'a GridSums, z: Mat<f64>, mean: Mean, jitter: f64) -> Self {
        let m = z.nrows();
        let settings = SparseSettings { approximation: Approximation::Dtc, mean, jitter };
        let mut rows = RowSums::new(z.as_ref(), &[0.0], m, mean);
        (rows.n_rows, rows.origin) = (sums.n_rows, sums.origin);
        let basis = rows.monomials.columns(z.as_ref());
        let times = |column: &Vec<f64>| {
            let mut product = vec![0.0; m];
            sums.multiply(column, &mut product);
            product
        };
        let of_basis: Vec<Vec<f64>> = basis.iter().map(times).collect();
        let p = basis.len();
        rows.spread = Mat::from_fn(p, p, |i, j| dot(&basis[i], &of_basis[j]));
        let square = || Mat::zeros(m, m);
        let [gram, factor, product, turned, slope] = [(); 5].map(|()| square());
        let solved = Solved::new(m);
        Self {
            sums,
            z,
            settings,
            basis,
            of_basis,
            rows,
            gram,
            factor,
            product,
            turned,
            slope,
            solved,
        }
    }

    /// What the mean is a sum of.
    pub(crate) fn monomials(&self) -> &Monomials {
        &self.rows.monomials
    }

    /// In nats.
    ///
    /// # Errors
    /// `NotPositiveDefinite`; `UndeterminedSlope`.
    pub(crate) fn value(&mut self, kernel: &dyn Kernel, noise: f64) -> Result<f64, GpError> {
        let m = self.z.nrows();
        fill_lower_gram(kernel, self.z.as_ref(), &mut self.gram);
        self.factor.copy_from(&self.gram);
        for a in 0..m {
            self.factor[(a, a)] *= 1.0 + self.settings.jitter;
        }
        factorize(PSEUDO_COVARIANCE, self.factor.as_mut())?;
        clear_above(self.factor.as_mut());
        multiply_columns(self.sums, &self.factor, &mut self.product);
        let precision = noise.recip();
        let (factor, product) = (self.factor.as_ref(), self.product.as_ref());
        let square = self.rows.square.as_mut().get_mut(..m, ..m);
        in_panels(square, |panel, start| {
            let (below, width) = (factor.get(start.., start..), panel.ncols());
            let right = product.get(start.., start..start + width);
            matmul(panel, Accum::Replace, below.transpose(), right, precision, Par::Seq);
        });
        self.fill_small_sums(precision);
        self.rows.log_determinant = self.sums.n_rows as f64 * noise.ln();
        self.solved.solve(&self.rows, self.factor.as_ref(), self.settings)?;
        Ok(self.solved.value)
    }

    /// (y, H)ᵀ (V, y, H)/σₙ².
    fn fill_small_sums(&mut self, precision: f64) {
        let m = self.z.nrows();
        let nodes: Vec<&[f64]> = std::iter::once(&*self.sums.of_y)
            .chain(self.of_basis.iter().map(Vec::as_slice))
            .collect();
        let square = &mut self.rows.square;
        for (i, of) in nodes.iter().enumerate() {
            for a in 0..m {
                square[(m + i, a)] = precision * dot(&column(&self.factor, a)[a..], &of[a..]);
            }
        }
        square[(m, m)] = precision * self.sums.y_y;
        for (i, basis) in self.basis.iter().enumerate() {
            square[(m + 1 + i, m)] = precision * dot(basis, &self.sums.of_y);
            for j in 0..=i {
                square[(m + 1 + i, m + 1 + j)] = precision * self.rows.spread[(i, j)];
            }
        }
    }

    /// L R⁻ᵀ at the place of the last `value`: times its transpose it is the nodes' posterior covariance.
    pub(crate) fn turn(&mut self) -> MatRef<'_, f64> {
        self.turned.copy_from(&self.factor);
        solve_rows(self.solved.root.as_ref(), self.turned.as_mut());
        self.turned.as_ref()
    }

    /// The gradient there by the kernel's log-parameters and, last, ln σₙ².
    ///
    /// With C the inverse covariance of the rows, ∂/∂K = ½ WᵀCr (WᵀCr)ᵀ over the responses less
    /// ½ WᵀCW = ½ (S/σₙ² − S Σ S/σₙ⁴), Σ the nodes' posterior covariance.
    pub(crate) fn differentiate(&mut self, kernel: &dyn Kernel, noise: f64, gradient: &mut [f64]) {
        self.turn();
        multiply_columns(self.sums, &self.turned, &mut self.product);
        let precision = noise.recip();
        let pairs = (0..self.z.nrows())
            .map(|j| dot(column(&self.turned, j), column(&self.product, j)))
            .sum::<f64>();
        let trace = precision * (self.sums.n_rows as f64 - precision * pairs);
        let mut residuals = Vec::new();
        let mut squares = 0.0;
        for response in &self.solved.responses {
            let (residual, square) = self.residual(response, precision);
            squares += square;
            residuals.push(residual);
        }
        let (of_noise, of_kernel) = gradient.split_last_mut().expect("the noise comes last");
        *of_noise = 0.5 * noise * (squares - trace);
        let (product, sums) = (self.product.as_ref(), self.sums);
        let (z, gram, jitter) = (self.z.as_ref(), &self.gram, self.settings.jitter);
        let n_parameters = of_kernel.len();
        let parts = in_panels(self.slope.as_mut(), |mut panel, start| {
            let width = panel.ncols();
            let right = product.get(start..start + width, ..).transpose();
            let square = precision * precision;
            matmul(
                panel.as_mut(),
                Accum::Replace,
                product.get(start.., ..),
                right,
                square,
                Par::Seq,
            );
            let (mut part, mut b) = (vec![0.0; n_parameters], vec![0.0; z.ncols()]);
            for k in 0..width {
                let j = start + k;
                let slope = &mut column_of(panel.as_mut(), k)[k..];
                sums.subtract_row(j, precision, slope);
                for residual in &residuals {
                    add_multiple(slope, residual[j], &residual[j..]);
                }
                slope[0] *= 0.5 * (1.0 + jitter);
                copy_row(z, j, &mut b);
                let (rows, values) = (z.subrows(j, slope.len()), &column(gram, j)[j..]);
                kernel.column_gradient(rows, &b, values, slope, &mut part, &mut []);
            }
            part
        });
        for (i, slope) in of_kernel.iter_mut().enumerate() {
            *slope = parts.iter().map(|part| part[i]).sum();
        }
    }

    /// WᵀCr and |Cr|² of a response r = b y − H c.
    fn residual(&self, response: &Response, precision: f64) -> (Vec<f64>, f64) {
        let (b, c) = (response.of_y, &response.coefficients);
        let mut of_r: Vec<f64> = self.sums.of_y.iter().map(|y| b * y).collect();
        let mut r_r = b * b * self.sums.y_y;
        for (i, (c_i, of)) in c.iter().zip(&self.of_basis).enumerate() {
            add_multiple(&mut of_r, -c_i, of);
            r_r -= 2.0 * b * c_i * dot(&self.basis[i], &self.sums.of_y);
            r_r += c
                .iter()
                .enumerate()
                .map(|(j, c_j)| c_i * c_j * self.rows.spread[(i, j)])
                .sum::<f64>();
        }
        let values = self.node_values(response);
        let mut image = vec![0.0; values.len()];
        self.sums.multiply(&values, &mut image);
        let left = r_r - 2.0 * dot(&values, &of_r) + dot(&values, &image);
        let residual = of_r.iter().zip(&image).map(|(r, image)| precision * (r - image)).collect();
        (residual, precision * precision * left.max(0.0))
    }

    /// What a response is at the nodes beside the mean: L t.
    pub(crate) fn node_values(&self, response: &Response) -> Vec<f64> {
        let mut values = vec![0.0; self.z.nrows()];
        for (a, t) in response.whitened.iter().enumerate() {
            add_multiple(&mut values[a..], *t, &column(&self.factor, a)[a..]);
        }
        values
    }
}

/// product ← S X.
fn multiply_columns(sums: &GridSums, x: &Mat<f64>, product: &mut Mat<f64>) {
    product.par_col_chunks_mut(PANEL).enumerate().for_each(|(panel, mut columns)| {
        for k in 0..columns.ncols() {
            let from = column(x, panel * PANEL + k);
            sums.multiply(from, column_of(columns.as_mut(), k));
        }
    });
}

/// Calls `fill` for the part of each panel of columns that begins on the diagonal, in parallel; what it
/// returns, in order.
pub(crate) fn in_panels<R: Send>(
    matrix: MatMut<'_, f64>,
    fill: impl Fn(MatMut<'_, f64>, usize) -> R + Sync,
) -> Vec<R> {
    let panels = matrix.par_col_chunks_mut(PANEL).enumerate();
    let each = panels.map(|(panel, columns)| {
        let start = panel * PANEL;
        let n = columns.nrows();
        fill(columns.subrows_mut(start, n - start), start)
    });
    each.collect()
}

/// Columns of a panel.
const PANEL: usize = 96;

#[cfg(test)]
mod tests {
    use faer::Mat;
    use gp_core::{Kernel, Matern52, Mean};

    use super::GridObjective;
    use crate::grid::Grid;
    use crate::grid_sums::GridSums;

    #[test]
    fn the_gradient_is_that_of_differences() {
        let turn = |i: usize, d: usize| 1.7 * (2 * i + d) as f64 + (i * i * (d + 1)) as f64;
        let x = Mat::from_fn(400, 2, |i, d| turn(i, d).sin());
        let y: Vec<f64> =
            (0..400).map(|i| x[(i, 0)].exp() + 0.1 * (9.0 * i as f64).sin()).collect();
        let grid = Grid::finest(x.as_ref(), &[1.0, 1.3], 0.3, 120).unwrap();
        let sums = GridSums::new(&grid, x.as_ref(), &y).unwrap();
        for mean in [Mean::Fixed(0.2), Mean::Estimated, Mean::Polynomial(2)] {
            let mut objective = GridObjective::new(&sums, grid.positions(), mean, 1e-6);
            let values = [0.9, 1.2, 0.5, 0.02_f64];
            let mut value = |logs: &[f64], gradient: &mut [f64]| {
                let theta: Vec<f64> = logs.iter().map(|log| log.exp()).collect();
                let kernel = Matern52::unit(2).unwrap().with_parameters(&theta[..3]).unwrap();
                let value = objective.value(&*kernel, theta[3]).unwrap();
                objective.differentiate(&*kernel, theta[3], gradient);
                value
            };
            let logs: Vec<f64> = values.iter().map(|value| value.ln()).collect();
            let (mut gradient, mut unused) = (vec![0.0; 4], vec![0.0; 4]);
            value(&logs, &mut gradient);
            for k in 0..4 {
                let mut at = |step: f64| {
                    let mut moved = logs.clone();
                    moved[k] += step;
                    value(&moved, &mut unused)
                };
                let numeric = (at(1e-5) - at(-1e-5)) / 2e-5;
                let apart = (gradient[k] - numeric).abs();
                assert!(
                    apart < 1e-4 * (1.0 + numeric.abs()),
                    "{mean:?} {k} {gradient:?} {numeric}"
                );
            }
        }
    }
}
