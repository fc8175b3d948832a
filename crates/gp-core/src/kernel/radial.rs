//! Kernels that depend on the scaled distance of two inputs only.

use std::fmt;
use std::marker::PhantomData;

use faer::MatRef;

use super::{Kernel, KernelSpec, Parameter, PerInput, Role};
use crate::GpError;
use crate::checks::check_positive;
use crate::vector::{dot, vectorized, weighted_sums};

/// k(a, b) = s² g(r²) with r² = Σ_d ((a_d − b_d)/l_d)² and g given by a `Profile`.
///
/// Parameters: `<ID>.lengthscale`, in the unit of input d, and `<ID>.signal_variance`, with the ID of
/// the profile, such as `matern52`.
pub struct Radial<P> {
    lengthscales: PerInput,
    signal_variance: f64,
    profile: PhantomData<P>,
}

/// The shape g of a radial kernel as a function of the squared scaled distance, with g(0) = 1.
pub trait Profile: Send + Sync + Sized + 'static {
    /// The kernel's name as a type.
    const NAME: &'static str;

    /// Its name in hyperparameters and files.
    const ID: &'static str;

    /// Whether the slope depends on the distance other than through the value.
    const NEEDS_DISTANCE: bool = true;

    /// g(r²).
    fn value(squared_distance: f64) -> f64;

    /// dg/d(r²), given g(r²) as well, so that no exponential is computed twice.
    fn slope(squared_distance: f64, value: f64) -> f64;

    /// The kernel as plain data.
    fn spec(kernel: &Radial<Self>) -> Option<KernelSpec>;
}

impl<P: Profile> Radial<P> {
    /// A kernel with the same lengthscale for all inputs, however many, and signal variance 1.
    pub fn isotropic(lengthscale: f64) -> Self {
        Self::of(PerInput::Shared(lengthscale), 1.0)
    }

    /// A kernel with one lengthscale an input and signal variance s² = k(x, x).
    ///
    /// # Errors
    /// `Empty` without lengthscales; `NotPositive` for a value that is not positive and finite.
    pub fn new(lengthscales: &[f64], signal_variance: f64) -> Result<Self, GpError> {
        if lengthscales.is_empty() {
            return Err(GpError::Empty { what: "lengthscales" });
        }
        for (d, &lengthscale) in lengthscales.iter().enumerate() {
            check_positive(&format!("lengthscale {d}"), lengthscale)?;
        }
        check_positive("signal variance", signal_variance)?;
        Ok(Self::of(lengthscales.into(), signal_variance))
    }

    /// A kernel with one lengthscale an input and all parameters 1: the family, where the values are
    /// to be learnt.
    ///
    /// # Errors
    /// `Empty` if `n_inputs` is 0.
    pub fn unit(n_inputs: usize) -> Result<Self, GpError> {
        Self::new(&vec![1.0; n_inputs], 1.0)
    }

    pub(super) fn of(lengthscales: PerInput, signal_variance: f64) -> Self {
        Self { lengthscales, signal_variance, profile: PhantomData }
    }

    pub(super) fn scaled(mut self, factor: f64) -> Self {
        self.signal_variance *= factor;
        self
    }

    pub(super) fn per_input(&self) -> &PerInput {
        &self.lengthscales
    }

    /// The lengthscales, each in the unit of its input: one, or one an input.
    pub fn lengthscales(&self) -> &[f64] {
        self.lengthscales.as_slice()
    }

    /// The prior variance of the function, in the squared unit of the output.
    pub fn signal_variance(&self) -> f64 {
        self.signal_variance
    }
}

impl<P: Profile> Kernel for Radial<P> {
    fn check_n_inputs(&self, n_inputs: usize) -> Result<(), GpError> {
        self.lengthscales.check(n_inputs)
    }

    fn value(&self, a: &[f64], b: &[f64]) -> f64 {
        self.signal_variance * P::value(self.lengthscales.squared_distance(a, b))
    }

    fn parameters(&self) -> Vec<Parameter> {
        let name = |parameter: &str| format!("{}.{parameter}", P::ID);
        let role = |inputs| Role::Lengthscale { inputs };
        let mut all = self.lengthscales.parameters(&name("lengthscale"), role);
        all.push(Parameter::new(name("signal_variance"), self.signal_variance, Role::Variance));
        all
    }

    fn with_values(&self, values: &[f64]) -> Box<dyn Kernel> {
        let (lengthscales, variance) = values.split_at(self.lengthscales.n_parameters());
        Box::new(Self::of(self.lengthscales.with_values(lengthscales), variance[0]))
    }

    fn parameter_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        let squared_distance = self.lengthscales.squared_distance(a, b);
        let shape = P::value(squared_distance);
        let factor = -2.0 * self.signal_variance * P::slope(squared_distance, shape);
        gradient.fill(0.0);
        for (d, (a, b)) in a.iter().zip(b).enumerate() {
            let scaled = (a - b) / self.lengthscales.of(d);
            gradient[self.lengthscales.slot(d)] += factor * scaled.powi(2);
        }
        gradient[self.lengthscales.n_parameters()] = self.signal_variance * shape;
    }

    fn input_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        let squared_distance = self.lengthscales.squared_distance(a, b);
        let slope = P::slope(squared_distance, P::value(squared_distance));
        for (d, of_input) in gradient.iter_mut().enumerate() {
            let scaled = (a[d] - b[d]) / self.lengthscales.of(d).powi(2);
            *of_input = 2.0 * self.signal_variance * slope * scaled;
        }
    }

    fn spec(&self) -> Option<KernelSpec> {
        P::spec(self)
    }

    fn column(&self, x: MatRef<'_, f64>, b: &[f64], values: &mut [f64]) {
        let last = x.ncols() - 1;
        self.squared_distances(x, b, last, values);
        let (inverse, signal_variance) = (self.lengthscales.of(last).recip(), self.signal_variance);
        with_column(x, last, |x| {
            profile_values::<P>(values, x, b[last], inverse, signal_variance);
        });
    }

    fn column_gradient(
        &self,
        x: MatRef<'_, f64>,
        b: &[f64],
        values: &[f64],
        weights: &[f64],
        of_parameters: &mut [f64],
        of_input: &mut [f64],
    ) {
        let mut factors = [0.0; BLOCK];
        let signal_variance = self.signal_variance;
        for start in (0..values.len()).step_by(BLOCK) {
            let n = BLOCK.min(values.len() - start);
            let (rows, factors) = (x.subrows(start, n), &mut factors[..n]);
            if P::NEEDS_DISTANCE {
                self.squared_distances(rows, b, x.ncols(), factors);
            }
            let (values, weights) = (&values[start..start + n], &weights[start..start + n]);
            profile_slopes::<P>(factors, values, weights, signal_variance);
            if let Some((of_variance, _)) = of_parameters.split_last_mut() {
                *of_variance += dot(values, weights);
            }
            for d in 0..x.ncols() {
                let inverse = self.lengthscales.of(d).recip();
                let sums = |x: &[f64]| weighted_sums(x, factors, b[d], inverse);
                let (first, second) = with_column(rows, d, sums);
                if !of_parameters.is_empty() {
                    of_parameters[self.lengthscales.slot(d)] -= second;
                }
                if !of_input.is_empty() {
                    of_input[d] -= inverse * first;
                }
            }
        }
    }

    fn diagonal(&self, _x: MatRef<'_, f64>, values: &mut [f64]) {
        values.fill(self.signal_variance);
    }

    fn diagonal_gradient(&self, _x: MatRef<'_, f64>, weights: &[f64], gradient: &mut [f64]) {
        let of_variance = gradient.last_mut().expect("one a parameter");
        *of_variance += self.signal_variance * weights.iter().sum::<f64>();
    }
}

impl<P: Profile> Radial<P> {
    /// Writes r² of every row from b, over the first `n_inputs` inputs.
    fn squared_distances(
        &self,
        x: MatRef<'_, f64>,
        b: &[f64],
        n_inputs: usize,
        squares: &mut [f64],
    ) {
        squares.fill(0.0);
        for (d, &center) in b.iter().enumerate().take(n_inputs) {
            let inverse = self.lengthscales.of(d).recip();
            with_column(x, d, |x| add_squares(squares, x, center, inverse));
        }
    }
}

/// Calls `body` with a column of a matrix of any layout.
fn with_column<R>(x: MatRef<'_, f64>, d: usize, body: impl FnOnce(&[f64]) -> R) -> R {
    match x.col(d).try_as_col_major() {
        Some(x) => body(x.as_slice()),
        None => body(&x.col(d).iter().copied().collect::<Vec<f64>>()),
    }
}

impl<P> Clone for Radial<P> {
    fn clone(&self) -> Self {
        Self {
            lengthscales: self.lengthscales.clone(),
            signal_variance: self.signal_variance,
            profile: PhantomData,
        }
    }
}

impl<P> PartialEq for Radial<P> {
    fn eq(&self, other: &Self) -> bool {
        self.lengthscales == other.lengthscales && self.signal_variance == other.signal_variance
    }
}

impl<P: Profile> fmt::Debug for Radial<P> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct(P::NAME)
            .field("lengthscales", &self.lengthscales)
            .field("signal_variance", &self.signal_variance)
            .finish()
    }
}

/// The largest r² told apart from infinity: every profile is 0 long before.
pub(super) const FARTHEST: f64 = 1e9;

/// Rows that the gradient handles at once: their terms stay on the stack and in the first cache.
const BLOCK: usize = 256;

vectorized! {
    /// Adds ((xᵢ − center)·inverse)².
    fn add_squares(squares: &mut [f64], x: &[f64], center: f64, inverse: f64) {
        for (square, x) in squares.iter_mut().zip(x) {
            let scaled = (x - center) * inverse;
            *square += scaled * scaled;
        }
    }
}

vectorized! {
    /// Replaces what is there of r², all but the last input's part, by s² g(r²).
    fn profile_values<P: Profile>(
        values: &mut [f64],
        x: &[f64],
        center: f64,
        inverse: f64,
        signal_variance: f64,
    ) {
        for (value, x) in values.iter_mut().zip(x) {
            let scaled = (x - center) * inverse;
            *value = signal_variance * P::value(*value + scaled * scaled);
        }
    }
}

vectorized! {
    /// Replaces r² by 2 s² w g'(r²), given the kernel's values.
    fn profile_slopes<P: Profile>(
        factors: &mut [f64],
        values: &[f64],
        weights: &[f64],
        signal_variance: f64,
    ) {
        let inverse_variance = signal_variance.recip();
        for ((factor, value), weight) in factors.iter_mut().zip(values).zip(weights) {
            let slope = P::slope(*factor, value * inverse_variance);
            *factor = 2.0 * signal_variance * slope * weight;
        }
    }
}
