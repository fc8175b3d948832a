//! The linear kernel.

use super::{Kernel, KernelSpec, Parameter, PerInput, Role};
use crate::GpError;

/// k(a, b) = Σ_d v_d a_d b_d: straight lines through the origin with slopes of variance v_d.
///
/// Add a `Constant` for lines with an offset. It is not stationary: the variance grows as the square
/// of the distance from the origin.
/// Parameters: `linear.slope_variance`, in squared units of output over input d.
#[derive(Clone, Debug, PartialEq)]
pub struct Linear {
    slope_variances: PerInput,
}

impl Linear {
    /// A kernel with the same slope variance for all inputs.
    pub fn isotropic(slope_variance: f64) -> Self {
        PerInput::Shared(slope_variance).into()
    }

    /// A kernel with one slope variance an input.
    pub fn ard(slope_variances: &[f64]) -> Self {
        PerInput::from(slope_variances).into()
    }

    /// The slope variances v_d: one, or one an input.
    pub fn slope_variances(&self) -> &[f64] {
        self.slope_variances.as_slice()
    }

    pub(super) fn scaled(mut self, factor: f64) -> Self {
        let values: Vec<f64> = self.slope_variances().iter().map(|v| factor * v).collect();
        self.slope_variances = self.slope_variances.with_values(&values);
        self
    }
}

impl From<PerInput> for Linear {
    fn from(slope_variances: PerInput) -> Self {
        Self { slope_variances }
    }
}

impl Kernel for Linear {
    fn check_n_inputs(&self, n_inputs: usize) -> Result<(), GpError> {
        self.slope_variances.check(n_inputs)
    }

    fn value(&self, a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).enumerate().map(|(d, (a, b))| self.slope_variances.of(d) * a * b).sum()
    }

    fn parameters(&self) -> Vec<Parameter> {
        let role = |inputs| Role::SlopeVariance { inputs };
        self.slope_variances.parameters("linear.slope_variance", role)
    }

    fn with_values(&self, values: &[f64]) -> Box<dyn Kernel> {
        Box::new(Self::from(self.slope_variances.with_values(values)))
    }

    fn parameter_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        gradient.fill(0.0);
        for (d, (a, b)) in a.iter().zip(b).enumerate() {
            gradient[self.slope_variances.slot(d)] += self.slope_variances.of(d) * a * b;
        }
    }

    fn input_gradient(&self, _a: &[f64], b: &[f64], gradient: &mut [f64]) {
        for (d, slope) in gradient.iter_mut().enumerate() {
            *slope = self.slope_variances.of(d) * b[d];
        }
    }

    fn spec(&self) -> Option<KernelSpec> {
        Some(KernelSpec::Linear { slope_variances: self.slope_variances.clone() })
    }
}
