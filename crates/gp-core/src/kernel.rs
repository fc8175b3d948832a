//! The trait that every covariance function implements, and the blocks made from it.

mod active_inputs;
mod build;
mod constant;
mod coregionalization;
mod coregionalized;
mod cosine;
mod linear;
mod matern12;
mod matern32;
mod matern52;
mod operators;
mod parameter;
mod per_input;
mod periodic;
mod polynomial;
mod product;
mod radial;
mod rational_quadratic;
mod spec;
mod squared_exponential;
mod sum;
mod white;

use std::fmt::Debug;

use faer::{Mat, MatMut, MatRef};
use rayon::prelude::{IndexedParallelIterator, ParallelIterator};

pub use self::active_inputs::ActiveInputs;
pub use self::constant::Constant;
pub use self::coregionalization::Coregionalization;
pub(crate) use self::coregionalized::{Coregionalized, SharedRows};
pub use self::cosine::Cosine;
pub use self::linear::Linear;
pub use self::matern12::{Matern12, Matern12Profile};
pub use self::matern32::{Matern32, Matern32Profile};
pub use self::matern52::{Matern52, Matern52Profile};
pub use self::parameter::{Parameter, Role};
pub use self::per_input::PerInput;
pub use self::periodic::Periodic;
pub use self::polynomial::Polynomial;
pub use self::product::Product;
use self::radial::FARTHEST;
pub use self::radial::{Profile, Radial};
pub use self::rational_quadratic::RationalQuadratic;
pub use self::spec::KernelSpec;
pub use self::squared_exponential::{SquaredExponential, SquaredExponentialProfile};
pub use self::sum::Sum;
pub use self::white::White;
use crate::GpError;
use crate::checks::{check_count, check_finite, check_inputs, check_positive};
use crate::vector::add_multiple;

/// A covariance function k(a, b) of two inputs with D coordinates, and its derivatives.
///
/// Its parameters are positive numbers in the user's own units; derivatives are taken with respect
/// to their logarithms. The slices `a` and `b` have as many entries as `check_n_inputs` allows.
/// Pairwise methods are enough; `column` and `column_gradient` are there to be made faster.
///
/// A kernel of your own, k(a, b) = v a³b³, adds and multiplies with the others and is learnt like them:
/// ```
/// use gp_core::{Gp, Kernel, Matern52, Parameter, Role};
///
/// #[derive(Debug)]
/// struct Cubes(f64);
///
/// impl Kernel for Cubes {
///     fn value(&self, a: &[f64], b: &[f64]) -> f64 {
///         self.0 * (a[0] * b[0]).powi(3)
///     }
///     fn parameters(&self) -> Vec<Parameter> {
///         vec![Parameter::new("cubes.variance", self.0, Role::Shape)]
///     }
///     fn with_values(&self, values: &[f64]) -> Box<dyn Kernel> {
///         Box::new(Self(values[0]))
///     }
///     fn parameter_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
///         gradient[0] = self.value(a, b);
///     }
///     fn input_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
///         gradient[0] = 3.0 * self.0 * a[0] * a[0] * b[0].powi(3);
///     }
/// }
///
/// let x: Vec<f64> = (0..30).map(|i| 0.1 * f64::from(i) - 1.5).collect();
/// let y: Vec<f64> = x.iter().map(|x| 2.0 * x.powi(3) + 0.1 * (9.0 * x).sin()).collect();
/// let gp = Gp::builder(Matern52::isotropic(1.0) + Cubes(1.0)).fit(&x, &y)?;
/// assert_eq!(gp.kernel().parameters()[2].name, "cubes.variance");
/// # Ok::<(), gp_core::GpError>(())
/// ```
#[auto_impl::auto_impl(Box)]
pub trait Kernel: Debug + Send + Sync {
    /// k(a, b).
    fn value(&self, a: &[f64], b: &[f64]) -> f64;

    /// The parameters with names, values and roles, in a fixed order.
    fn parameters(&self) -> Vec<Parameter>;

    /// The same kernel with other parameter values, in the order of `parameters`, of which there are as
    /// many; called by `with_parameters`, which checks them.
    fn with_values(&self, values: &[f64]) -> Box<dyn Kernel>;

    /// Writes ∂k(a, b)/∂ ln θ into `gradient`, one entry a parameter.
    fn parameter_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]);

    /// Writes ∂k(a, b)/∂a into `gradient`, one entry a coordinate.
    fn input_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]);

    /// Checks that inputs may have `n_inputs` coordinates; any number, if it is not overridden.
    ///
    /// # Errors
    /// `ShapeMismatch`, `OutOfRange` or `Empty` if they may not.
    fn check_n_inputs(&self, _n_inputs: usize) -> Result<(), GpError> {
        Ok(())
    }

    /// The same kernel with other parameter values, in the order of `parameters`.
    ///
    /// # Errors
    /// `ShapeMismatch` for a wrong count, `NotPositive` for a value that is not positive and finite.
    fn with_parameters(&self, values: &[f64]) -> Result<Box<dyn Kernel>, GpError> {
        let parameters = self.parameters();
        check_count("kernel parameters", parameters.len(), values.len())?;
        for (parameter, value) in parameters.iter().zip(values) {
            check_positive(&parameter.name, *value)?;
        }
        Ok(self.with_values(values))
    }

    /// Checks that all parameters are positive and finite, and that inputs may have `n_inputs`
    /// coordinates: kernels are put together unchecked, and checked where they meet data.
    ///
    /// # Errors
    /// `NotPositive`; as `check_n_inputs`.
    fn check(&self, n_inputs: usize) -> Result<(), GpError> {
        for parameter in self.parameters() {
            check_positive(&parameter.name, parameter.value)?;
        }
        self.check_n_inputs(n_inputs)
    }

    /// The kernel as plain data for saving; `None` for kernels that this crate does not know.
    fn spec(&self) -> Option<KernelSpec> {
        None
    }

    /// Writes k(xᵢ, b) into `values` for every row xᵢ of `x`.
    fn column(&self, x: MatRef<'_, f64>, b: &[f64], values: &mut [f64]) {
        let mut a = vec![0.0; x.ncols()];
        for (i, value) in values.iter_mut().enumerate() {
            copy_row(x, i, &mut a);
            *value = self.value(&a, b);
        }
    }

    /// Adds Σᵢ wᵢ ∂k(xᵢ, b)/∂ ln θ to `of_parameters` and Σᵢ wᵢ ∂k(xᵢ, b)/∂b to `of_input`, either
    /// of which may be empty: not wanted; `values` holds what `column` wrote.
    fn column_gradient(
        &self,
        x: MatRef<'_, f64>,
        b: &[f64],
        _values: &[f64],
        weights: &[f64],
        of_parameters: &mut [f64],
        of_input: &mut [f64],
    ) {
        let mut a = vec![0.0; x.ncols()];
        let (mut by_parameters, mut by_input) = (of_parameters.to_vec(), of_input.to_vec());
        for (i, weight) in weights.iter().enumerate() {
            copy_row(x, i, &mut a);
            if !of_parameters.is_empty() {
                self.parameter_gradient(&a, b, &mut by_parameters);
                add_multiple(of_parameters, *weight, &by_parameters);
            }
            if !of_input.is_empty() {
                self.input_gradient(b, &a, &mut by_input);
                add_multiple(of_input, *weight, &by_input);
            }
        }
    }

    /// Writes k(xᵢ, xᵢ) into `values` for every row xᵢ of `x`.
    fn diagonal(&self, x: MatRef<'_, f64>, values: &mut [f64]) {
        let mut a = vec![0.0; x.ncols()];
        for (i, value) in values.iter_mut().enumerate() {
            copy_row(x, i, &mut a);
            *value = self.value(&a, &a);
        }
    }

    /// Adds Σᵢ wᵢ ∂k(xᵢ, xᵢ)/∂ ln θ to `gradient`.
    fn diagonal_gradient(&self, x: MatRef<'_, f64>, weights: &[f64], gradient: &mut [f64]) {
        let mut a = vec![0.0; x.ncols()];
        let mut term = vec![0.0; gradient.len()];
        for (i, weight) in weights.iter().enumerate() {
            copy_row(x, i, &mut a);
            self.parameter_gradient(&a, &a, &mut term);
            add_multiple(gradient, *weight, &term);
        }
    }
}

/// The Gram matrix K(X, X), exactly symmetric, N×N.
///
/// # Errors
/// `Empty`, `ShapeMismatch` or `NotFinite` if `x` is not a finite N×D matrix.
pub fn gram(kernel: &dyn Kernel, x: MatRef<'_, f64>) -> Result<Mat<f64>, GpError> {
    check_kernel_and_inputs(kernel, x)?;
    let mut matrix = Mat::zeros(x.nrows(), x.nrows());
    fill_lower_gram(kernel, x, &mut matrix);
    mirror_lower(&mut matrix);
    Ok(matrix)
}

/// The cross-covariance K(A, B), N×M, for A: N×D and B: M×D.
///
/// # Errors
/// `Empty`, `ShapeMismatch` or `NotFinite` if `a` or `b` is not a finite matrix with D columns.
pub fn cross(
    kernel: &dyn Kernel,
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
) -> Result<Mat<f64>, GpError> {
    check_kernel_and_inputs(kernel, a)?;
    check_inputs("inputs", b, a.ncols())?;
    let mut matrix = Mat::zeros(a.nrows(), b.nrows());
    fill_cross(kernel, a, b, matrix.as_mut());
    Ok(matrix)
}

/// Checks inputs, N×D, and that the kernel takes them.
///
/// # Errors
/// `Empty` or `NotFinite` for inputs that are no finite matrix; as [`Kernel::check`].
pub fn check_kernel_and_inputs(kernel: &dyn Kernel, x: MatRef<'_, f64>) -> Result<(), GpError> {
    if x.nrows() == 0 || x.ncols() == 0 {
        return Err(GpError::Empty { what: "inputs" });
    }
    kernel.check(x.ncols())?;
    check_finite("inputs", x)
}

/// Writes the lower triangle of K(X, X), diagonal included; the rest is left as it is.
pub fn fill_lower_gram(kernel: &dyn Kernel, x: MatRef<'_, f64>, matrix: &mut Mat<f64>) {
    matrix.par_col_chunks_mut(COLUMNS).enumerate().for_each(|(block, mut columns)| {
        let mut b = vec![0.0; x.ncols()];
        for k in 0..columns.ncols() {
            let j = block * COLUMNS + k;
            copy_row(x, j, &mut b);
            let values = &mut column_of(columns.as_mut(), k)[j..];
            kernel.column(x.subrows(j, values.len()), &b, values);
        }
    });
}

/// Columns of a matrix that one thread works on at once.
pub(crate) const COLUMNS: usize = 64;

/// Writes K(A, B).
pub fn fill_cross(
    kernel: &dyn Kernel,
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    mut matrix: MatMut<'_, f64>,
) {
    let mut row = vec![0.0; b.ncols()];
    for j in 0..b.nrows() {
        copy_row(b, j, &mut row);
        kernel.column(a, &row, column_of(matrix.as_mut(), j));
    }
}

/// Copies the lower triangle onto the upper one.
pub fn mirror_lower(matrix: &mut Mat<f64>) {
    for j in 0..matrix.ncols() {
        for i in j + 1..matrix.nrows() {
            matrix[(j, i)] = matrix[(i, j)];
        }
    }
}

/// Copies row `i` of `x` into `row`.
pub fn copy_row(x: MatRef<'_, f64>, i: usize, row: &mut [f64]) {
    for (d, value) in row.iter_mut().enumerate() {
        *value = x[(i, d)];
    }
}

/// A column of an owned matrix as a slice.
///
/// # Panics
/// If there is no column `j`.
pub fn column(matrix: &Mat<f64>, j: usize) -> &[f64] {
    matrix.col(j).try_as_col_major().expect("owned matrices are column-major").as_slice()
}

/// A column of an owned matrix as a mutable slice.
///
/// # Panics
/// If there is no column `j`.
pub fn column_mut(matrix: &mut Mat<f64>, j: usize) -> &mut [f64] {
    column_of(matrix.as_mut(), j)
}

/// A column of a part of an owned matrix as a mutable slice.
///
/// # Panics
/// If there is no column `j`, or the columns are not contiguous.
pub fn column_of(matrix: MatMut<'_, f64>, j: usize) -> &mut [f64] {
    matrix
        .col_mut(j)
        .try_as_col_major_mut()
        .expect("owned matrices are column-major")
        .as_slice_mut()
}
