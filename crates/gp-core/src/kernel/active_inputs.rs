//! A kernel that looks at some of the inputs only.

use std::sync::Arc;

use faer::{Mat, MatRef};

use super::{Kernel, KernelSpec, Parameter, Role};
use crate::GpError;
use crate::checks::check_range;

/// k(a, b) = k₁(a_S, b_S), S a choice of the inputs: sums and products of such are functions with
/// structure, such as f(a) + g(b).
#[derive(Clone, Debug)]
pub struct ActiveInputs {
    kernel: Arc<dyn Kernel>,
    columns: Vec<usize>,
}

impl ActiveInputs {
    /// A kernel over the inputs `columns`, from zero, in the order given; also `kernel.active(columns)`.
    pub fn new(kernel: impl Kernel + 'static, columns: &[usize]) -> Self {
        Self { kernel: Arc::new(kernel), columns: columns.to_vec() }
    }

    fn choose(&self, a: &[f64]) -> Vec<f64> {
        self.columns.iter().map(|&column| a[column]).collect()
    }

    /// Calls `body` with the active columns: as they are if they stand together, else copied.
    fn with_columns<R>(&self, x: MatRef<'_, f64>, body: impl FnOnce(MatRef<'_, f64>) -> R) -> R {
        if self.columns.windows(2).all(|pair| pair[1] == pair[0] + 1) {
            body(x.subcols(self.columns[0], self.columns.len()))
        } else {
            let chosen = |i, d: usize| x[(i, self.columns[d])];
            body(Mat::from_fn(x.nrows(), self.columns.len(), chosen).as_ref())
        }
    }

    /// Adds what was found for the active inputs.
    fn scatter(&self, of_active: &[f64], gradient: &mut [f64]) {
        for (column, slope) in self.columns.iter().zip(of_active) {
            gradient[*column] += slope;
        }
    }
}

impl Kernel for ActiveInputs {
    fn check_n_inputs(&self, n_inputs: usize) -> Result<(), GpError> {
        if self.columns.is_empty() {
            return Err(GpError::Empty { what: "active inputs" });
        }
        for &column in &self.columns {
            check_range("active input", column as f64, 0.0, n_inputs as f64 - 1.0)?;
        }
        self.kernel.check_n_inputs(self.columns.len())
    }

    fn value(&self, a: &[f64], b: &[f64]) -> f64 {
        self.kernel.value(&self.choose(a), &self.choose(b))
    }

    fn parameters(&self) -> Vec<Parameter> {
        let mut parameters = self.kernel.parameters();
        for parameter in &mut parameters {
            if let Role::Lengthscale { inputs }
            | Role::Period { inputs }
            | Role::SlopeVariance { inputs } = &mut parameter.role
            {
                match inputs.is_empty() {
                    true => inputs.clone_from(&self.columns),
                    // A kernel of another number of inputs is refused before it is learnt.
                    false => {
                        let column = |&input: &usize| self.columns.get(input).copied();
                        *inputs = inputs.iter().filter_map(column).collect();
                    }
                }
            }
        }
        parameters
    }

    fn with_values(&self, values: &[f64]) -> Box<dyn Kernel> {
        let kernel = Arc::from(self.kernel.with_values(values));
        Box::new(Self { kernel, columns: self.columns.clone() })
    }

    fn parameter_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        self.kernel.parameter_gradient(&self.choose(a), &self.choose(b), gradient);
    }

    fn input_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        let mut of_active = vec![0.0; self.columns.len()];
        self.kernel.input_gradient(&self.choose(a), &self.choose(b), &mut of_active);
        gradient.fill(0.0);
        self.scatter(&of_active, gradient);
    }

    fn spec(&self) -> Option<KernelSpec> {
        Some(KernelSpec::ActiveInputs {
            kernel: Box::new(self.kernel.spec()?),
            columns: self.columns.clone(),
        })
    }

    fn column(&self, x: MatRef<'_, f64>, b: &[f64], values: &mut [f64]) {
        self.with_columns(x, |x| self.kernel.column(x, &self.choose(b), values));
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
        let (b, mut of_active) =
            (self.choose(b), vec![0.0; of_input.len().min(self.columns.len())]);
        self.with_columns(x, |x| {
            self.kernel.column_gradient(x, &b, values, weights, of_parameters, &mut of_active);
        });
        self.scatter(&of_active, of_input);
    }

    fn diagonal(&self, x: MatRef<'_, f64>, values: &mut [f64]) {
        self.with_columns(x, |x| self.kernel.diagonal(x, values));
    }

    fn diagonal_gradient(&self, x: MatRef<'_, f64>, weights: &[f64], gradient: &mut [f64]) {
        self.with_columns(x, |x| self.kernel.diagonal_gradient(x, weights, gradient));
    }
}
