//! The sum of two kernels over the same inputs.

use std::sync::Arc;

use faer::MatRef;

use super::{Kernel, KernelSpec, Parameter};
use crate::GpError;

/// k(a, b) = k₁(a, b) + k₂(a, b): a function that is the sum of two; sums of sums give any number.
///
/// Parameters: those of the first term, then those of the second (see [`Parameter`] for names).
#[derive(Clone, Debug)]
pub struct Sum {
    first: Arc<dyn Kernel>,
    second: Arc<dyn Kernel>,
    n_first: usize,
}

impl Sum {
    /// The sum of two kernels; also `first + second`.
    pub fn new(first: impl Kernel + 'static, second: impl Kernel + 'static) -> Self {
        let n_first = first.parameters().len();
        Self { first: Arc::new(first), second: Arc::new(second), n_first }
    }

    /// The two terms.
    pub fn terms(&self) -> (&dyn Kernel, &dyn Kernel) {
        (&*self.first, &*self.second)
    }
}

impl Kernel for Sum {
    fn check_n_inputs(&self, n_inputs: usize) -> Result<(), GpError> {
        self.first.check_n_inputs(n_inputs)?;
        self.second.check_n_inputs(n_inputs)
    }

    fn value(&self, a: &[f64], b: &[f64]) -> f64 {
        self.first.value(a, b) + self.second.value(a, b)
    }

    fn parameters(&self) -> Vec<Parameter> {
        Parameter::of_both(self.first.parameters(), self.second.parameters())
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
    }

    fn input_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        let mut of_second = vec![0.0; gradient.len()];
        self.first.input_gradient(a, b, gradient);
        self.second.input_gradient(a, b, &mut of_second);
        add(gradient, &of_second);
    }

    fn spec(&self) -> Option<KernelSpec> {
        let first = Box::new(self.first.spec()?);
        let second = Box::new(self.second.spec()?);
        Some(KernelSpec::Sum { first, second })
    }

    fn column(&self, x: MatRef<'_, f64>, b: &[f64], values: &mut [f64]) {
        let mut second = vec![0.0; values.len()];
        self.first.column(x, b, values);
        self.second.column(x, b, &mut second);
        add(values, &second);
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
        let mut values = vec![0.0; weights.len()];
        for (term, of_term) in [(&self.first, of_first), (&self.second, of_second)] {
            term.column(x, b, &mut values);
            term.column_gradient(x, b, &values, weights, of_term, of_input);
        }
    }

    fn diagonal(&self, x: MatRef<'_, f64>, values: &mut [f64]) {
        let mut second = vec![0.0; values.len()];
        self.first.diagonal(x, values);
        self.second.diagonal(x, &mut second);
        add(values, &second);
    }

    fn diagonal_gradient(&self, x: MatRef<'_, f64>, weights: &[f64], gradient: &mut [f64]) {
        let (of_first, of_second) = gradient.split_at_mut(self.n_first);
        self.first.diagonal_gradient(x, weights, of_first);
        self.second.diagonal_gradient(x, weights, of_second);
    }
}

fn add(sums: &mut [f64], terms: &[f64]) {
    sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
}
