//! The rational quadratic kernel.

use super::{Kernel, KernelSpec, Parameter, PerInput, Role};
use crate::GpError;

/// k(a, b) = s² (1 + r²/(2α))^−α with r² = Σ_d ((a_d − b_d)/l_d)²: smooth functions of many
/// lengthscales at once, spread about l the more the smaller α is.
///
/// Large α is the squared exponential.
/// Parameters: `rational_quadratic.lengthscale`, in the unit of input d, `.alpha`, without unit, and
/// `.signal_variance`.
#[derive(Clone, Debug, PartialEq)]
pub struct RationalQuadratic {
    lengthscales: PerInput,
    alpha: f64,
    signal_variance: f64,
}

impl RationalQuadratic {
    /// A kernel with signal variance s² = k(x, x).
    ///
    /// - `lengthscales`: one for all inputs, or one an input.
    pub fn new(lengthscales: PerInput, alpha: f64, signal_variance: f64) -> Self {
        Self { lengthscales, alpha, signal_variance }
    }

    /// A kernel with signal variance 1 and the same lengthscale for all inputs.
    pub fn isotropic(lengthscale: f64, alpha: f64) -> Self {
        Self::new(PerInput::Shared(lengthscale), alpha, 1.0)
    }

    /// A kernel with signal variance 1 and one lengthscale an input.
    pub fn ard(lengthscales: &[f64], alpha: f64) -> Self {
        Self::new(lengthscales.into(), alpha, 1.0)
    }

    pub(super) fn scaled(self, factor: f64) -> Self {
        Self { signal_variance: factor * self.signal_variance, ..self }
    }

    /// r²/(2α).
    fn ratio(&self, a: &[f64], b: &[f64]) -> f64 {
        self.lengthscales.squared_distance(a, b) / (2.0 * self.alpha)
    }

    fn at(&self, ratio: f64) -> f64 {
        self.signal_variance * (-self.alpha * ratio.ln_1p()).exp()
    }
}

impl Kernel for RationalQuadratic {
    fn check_n_inputs(&self, n_inputs: usize) -> Result<(), GpError> {
        self.lengthscales.check(n_inputs)
    }

    fn value(&self, a: &[f64], b: &[f64]) -> f64 {
        self.at(self.ratio(a, b))
    }

    fn parameters(&self) -> Vec<Parameter> {
        let role = |inputs| Role::Lengthscale { inputs };
        let mut all = self.lengthscales.parameters("rational_quadratic.lengthscale", role);
        all.push(Parameter::new("rational_quadratic.alpha", self.alpha, Role::Shape));
        let name = "rational_quadratic.signal_variance";
        all.push(Parameter::new(name, self.signal_variance, Role::Variance));
        all
    }

    fn with_values(&self, values: &[f64]) -> Box<dyn Kernel> {
        let (lengthscales, rest) = values.split_at(self.lengthscales.n_parameters());
        Box::new(Self::new(self.lengthscales.with_values(lengthscales), rest[0], rest[1]))
    }

    fn parameter_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        let ratio = self.ratio(a, b);
        let value = self.at(ratio);
        // ∂k/∂r² = −½ k/(1 + r²/2α).
        let factor = value / (1.0 + ratio);
        gradient.fill(0.0);
        for (d, (a, b)) in a.iter().zip(b).enumerate() {
            let scaled = (a - b) / self.lengthscales.of(d);
            gradient[self.lengthscales.slot(d)] += factor * scaled * scaled;
        }
        let n = self.lengthscales.n_parameters();
        gradient[n] = self.alpha * (factor * ratio - value * ratio.ln_1p());
        gradient[n + 1] = value;
    }

    fn input_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        let ratio = self.ratio(a, b);
        let factor = self.at(ratio) / (1.0 + ratio);
        for (d, slope) in gradient.iter_mut().enumerate() {
            *slope = -factor * (a[d] - b[d]) / self.lengthscales.of(d).powi(2);
        }
    }

    fn spec(&self) -> Option<KernelSpec> {
        Some(KernelSpec::RationalQuadratic {
            lengthscales: self.lengthscales.clone(),
            alpha: self.alpha,
            signal_variance: self.signal_variance,
        })
    }
}
