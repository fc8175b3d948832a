//! The product of two kernels over the same inputs.

use std::sync::Arc;

use faer::MatRef;

use super::{Kernel, KernelSpec, Parameter, Role};
use crate::GpError;

/// k(a, b) = k₁(a, b) k₂(a, b); products of products give any number of factors.
///
/// Parameters: those of the first factor, then those of the second (see [`Parameter`] for names). A
/// variance of the second factor counts as a number without unit where the first one has a variance,
/// which carries the output's unit.
#[derive(Clone, Debug)]
pub struct Product {
    first: Arc<dyn Kernel>,
    second: Arc<dyn Kernel>,
    n_first: usize,
}

impl Product {
    /// The product of two kernels; also `first * second`.
    pub fn new(first: impl Kernel + 'static, second: impl Kernel + 'static) -> Self {
        let n_first = first.parameters().len();
        Self { first: Arc::new(first), second: Arc::new(second), n_first }
    }

    /// The two factors.
    pub fn factors(&self) -> (&dyn Kernel, &dyn Kernel) {
        (&*self.first, &*self.second)
    }
}

impl Kernel for Product {
    fn check_n_inputs(&self, n_inputs: usize) -> Result<(), GpError> {
        self.first.check_n_inputs(n_inputs)?;
        self.second.check_n_inputs(n_inputs)
    }

    fn value(&self, a: &[f64], b: &[f64]) -> f64 {
        self.first.value(a, b) * self.second.value(a, b)
    }

    fn parameters(&self) -> Vec<Parameter> {
        let (first, mut second) = (self.first.parameters(), self.second.parameters());
        if first.iter().any(|parameter| parameter.role.is_variance()) {
            let variances = second.iter_mut().filter(|parameter| parameter.role.is_variance());
            variances.for_each(|parameter| parameter.role = Role::Shape);
        }
        Parameter::of_both(first, second)
    }

    fn with_values(&self, values: &[f64]) -> Box<dyn Kernel> {
        let (of_first, of_second) = values.split_at(self.n_first);
        let first = Arc::from(self.first.with_values(of_first));
        let second = Arc::from(self.second.with_values(of_second));
        Box::new(Self { first, second, n_first: self.n_first })
    }

    fn parameter_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        let (of_first, of_second) = gradient.split_at_mut(self.n_first);
        self.first.parameter_gradient(a, b, of_first);
        self.second.parameter_gradient(a, b, of_second);
        let (first, second) = (self.first.value(a, b), self.second.value(a, b));
        of_first.iter_mut().for_each(|slope| *slope *= second);
        of_second.iter_mut().for_each(|slope| *slope *= first);
    }

    fn input_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        let mut of_second = vec![0.0; gradient.len()];
        self.first.input_gradient(a, b, gradient);
        self.second.input_gradient(a, b, &mut of_second);
        let (first, second) = (self.first.value(a, b), self.second.value(a, b));
        for (slope, other) in gradient.iter_mut().zip(&of_second) {
            *slope = *slope * second + first * other;
        }
    }

    fn spec(&self) -> Option<KernelSpec> {
        let first = Box::new(self.first.spec()?);
        let second = Box::new(self.second.spec()?);
        Some(KernelSpec::Product { first, second })
    }

    fn column(&self, x: MatRef<'_, f64>, b: &[f64], values: &mut [f64]) {
        let mut second = vec![0.0; values.len()];
        self.first.column(x, b, values);
        self.second.column(x, b, &mut second);
        for (value, factor) in values.iter_mut().zip(&second) {
            *value *= factor;
        }
    }

    fn column_gradient(
        &self,
        x: MatRef<'_, f64>,
        b: &[f64],
        _values: &[f64],
        weights: &[f64],
        of_parameters: &mut [f64],
        of_input: &mut [f64],
    ) {
        let n_first = self.n_first.min(of_parameters.len());
        let (of_first, of_second) = of_parameters.split_at_mut(n_first);
        let (mut first, mut second) = (vec![0.0; weights.len()], vec![0.0; weights.len()]);
        self.first.column(x, b, &mut first);
        self.second.column(x, b, &mut second);
        let (by_first, by_second) = (products(weights, &second), products(weights, &first));
        self.first.column_gradient(x, b, &first, &by_first, of_first, of_input);
        self.second.column_gradient(x, b, &second, &by_second, of_second, of_input);
    }

    fn diagonal(&self, x: MatRef<'_, f64>, values: &mut [f64]) {
        let mut second = vec![0.0; values.len()];
        self.first.diagonal(x, values);
        self.second.diagonal(x, &mut second);
        values.iter_mut().zip(&second).for_each(|(value, factor)| *value *= factor);
    }

    fn diagonal_gradient(&self, x: MatRef<'_, f64>, weights: &[f64], gradient: &mut [f64]) {
        let (of_first, of_second) = gradient.split_at_mut(self.n_first);
        let mut values = vec![0.0; weights.len()];
        self.second.diagonal(x, &mut values);
        self.first.diagonal_gradient(x, &products(weights, &values), of_first);
        self.first.diagonal(x, &mut values);
        self.second.diagonal_gradient(x, &products(weights, &values), of_second);
    }
}

fn products(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a * b).collect()
}
