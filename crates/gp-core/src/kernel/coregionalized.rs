//! The form B ⊗ K + R ⊗ I that a kernel of several outputs may have.

use faer::{Mat, MatRef};

use super::{Coregionalization, Kernel, KernelSpec};
use crate::checks::check_distinct_rows;

/// k((x, i), (x', j)) = B_ij k(x, x'), and a part that is new at each input: R_ij where x = x'.
#[derive(Debug)]
pub(crate) struct Coregionalized {
    /// The input that numbers the outputs.
    column: usize,
    /// K, and where its parameters begin among all.
    shared: (Box<dyn Kernel>, usize),
    /// B.
    outputs: (Coregionalization, usize),
    own: Option<Own>,
}

/// What is new at each input: a white kernel times a covariance of the outputs.
#[derive(Debug)]
struct Own {
    white: (f64, usize),
    outputs: (Coregionalization, usize),
    /// The inputs that the white kernel looks at; none are all, the output's number too: outputs share
    /// nothing then.
    columns: Option<Vec<usize>>,
}

/// Rows that are the same inputs for each of some outputs, one output after the other.
#[derive(Debug)]
pub(crate) struct SharedRows {
    /// How many inputs.
    pub(crate) n: usize,
    /// The outputs' numbers.
    pub(crate) numbers: Vec<f64>,
}

impl Coregionalized {
    /// The form of a kernel with the rows that have it; none if there is none.
    pub(crate) fn of(kernel: &dyn Kernel, x: MatRef<'_, f64>) -> Option<(Self, SharedRows)> {
        let form = Self::of_spec(&kernel.spec()?)?;
        let rows = SharedRows::of(x, form.column)?;
        let is_new_each = |own: &Own| {
            let columns = own.columns.clone().unwrap_or_else(|| form.others(x.ncols()));
            let chosen = Mat::from_fn(rows.n, columns.len(), |i, d| x[(i, columns[d])]);
            !columns.contains(&form.column) && check_distinct_rows(chosen.as_ref()).is_ok()
        };
        form.own.iter().all(is_new_each).then_some((form, rows))
    }

    fn of_spec(spec: &KernelSpec) -> Option<Self> {
        if let KernelSpec::Sum { first, second } = spec {
            let then = n_parameters(first);
            let form = |term: &KernelSpec, at, own: &KernelSpec, own_at| {
                let form = Self::of_product(term, at)?;
                let own = Own::of_product(own, own_at, form.column)?;
                Some(Self { own: Some(own), ..form })
            };
            return form(first, 0, second, then).or_else(|| form(second, then, first, 0));
        }
        Self::of_product(spec, 0)
    }

    fn of_product(spec: &KernelSpec, at: usize) -> Option<Self> {
        let ((column, outputs, outputs_at), (shared, shared_at)) = factors(spec, at)?;
        let is_apart = !looks_at(shared, column);
        let shared = (shared.build(), shared_at);
        is_apart.then_some(Self { column, shared, outputs: (outputs, outputs_at), own: None })
    }

    /// All inputs but the output's number.
    fn others(&self, n_inputs: usize) -> Vec<usize> {
        (0..n_inputs).filter(|column| *column != self.column).collect()
    }

    /// K, over rows of all inputs.
    pub(crate) fn shared(&self) -> &dyn Kernel {
        &*self.shared.0
    }

    /// B of the outputs that are there.
    pub(crate) fn of_outputs(&self, rows: &SharedRows) -> Mat<f64> {
        rows.matrix(&self.outputs.0)
    }

    /// R of these outputs, with `noise_variance` on its diagonal.
    pub(crate) fn of_noise(&self, rows: &SharedRows, noise_variance: f64) -> Mat<f64> {
        let n = rows.numbers.len();
        let mut noise = self.own.as_ref().map_or_else(|| Mat::zeros(n, n), |own| own.matrix(rows));
        (0..n).for_each(|p| noise[(p, p)] += noise_variance);
        noise
    }

    /// Where in the gradient the parameters of K are.
    pub(crate) fn of_shared<'a>(&self, gradient: &'a mut [f64]) -> &'a mut [f64] {
        let (kernel, at) = &self.shared;
        &mut gradient[*at..][..kernel.parameters().len()]
    }

    /// Adds Σ w_pq ∂B_pq and Σ v_pq ∂R_pq by the log-parameters to the gradient.
    pub(crate) fn add_slopes(
        &self,
        rows: &SharedRows,
        by_outputs: &Mat<f64>,
        by_noise: &Mat<f64>,
        gradient: &mut [f64],
    ) {
        rows.add_slopes(&self.outputs, by_outputs, gradient);
        let Some(own) = &self.own else { return };
        let of_rows = own.matrix(rows);
        let n = rows.numbers.len();
        let weighted = |p, q| by_noise[(p, q)] * of_rows[(p, q)];
        gradient[own.white.1] += (0..n * n).map(|k| weighted(k / n, k % n)).sum::<f64>();
        let masked = Mat::from_fn(n, n, |p, q| own.share(p, q) * by_noise[(p, q)]);
        rows.add_slopes(&own.outputs, &masked, gradient);
    }
}

impl Own {
    fn of_product(spec: &KernelSpec, at: usize, column: usize) -> Option<Self> {
        let ((numbered, outputs, outputs_at), (white, white_at)) = factors(spec, at)?;
        let (variance, columns) = match white {
            KernelSpec::White { variance } => (*variance, None),
            KernelSpec::ActiveInputs { kernel, columns } => match **kernel {
                KernelSpec::White { variance } => (variance, Some(columns.clone())),
                _ => return None,
            },
            _ => return None,
        };
        let (white, outputs) = ((variance, white_at), (outputs, outputs_at));
        (numbered == column).then_some(Self { white, outputs, columns })
    }

    /// The white variance where outputs share what is new, else 0.
    fn share(&self, p: usize, q: usize) -> f64 {
        if p == q || self.columns.is_some() { self.white.0 } else { 0.0 }
    }

    fn matrix(&self, rows: &SharedRows) -> Mat<f64> {
        let outputs = rows.matrix(&self.outputs.0);
        Mat::from_fn(outputs.nrows(), outputs.ncols(), |p, q| self.share(p, q) * outputs[(p, q)])
    }
}

impl SharedRows {
    fn of(x: MatRef<'_, f64>, column: usize) -> Option<Self> {
        let number = |i: usize| x[(i, column)];
        let n = (1..x.nrows()).find(|&i| number(i) != number(0))?;
        let numbers: Vec<f64> = (0..x.nrows()).step_by(n).map(number).collect();
        let is_same = |i: usize, d: usize| match d == column {
            true => number(i) == numbers[i / n],
            false => x[(i, d)] == x[(i % n, d)],
        };
        let is_shared = (0..x.ncols()).all(|d| (0..x.nrows()).all(|i| is_same(i, d)));
        // Numbers between two outputs stand for the nearest, which may be there twice.
        let is_whole = |k: usize| {
            numbers[k].fract() == 0.0 && numbers[k] >= 0.0 && !numbers[..k].contains(&numbers[k])
        };
        let is_sound = x.nrows() % n == 0 && is_shared && (0..numbers.len()).all(is_whole);
        is_sound.then_some(Self { n, numbers })
    }

    fn matrix(&self, outputs: &Coregionalization) -> Mat<f64> {
        let value = |p: usize, q: usize| outputs.value(&[self.numbers[p]], &[self.numbers[q]]);
        Mat::from_fn(self.numbers.len(), self.numbers.len(), value)
    }

    fn add_slopes(
        &self,
        (outputs, at): &(Coregionalization, usize),
        weights: &Mat<f64>,
        gradient: &mut [f64],
    ) {
        let mut by = vec![0.0; outputs.parameters().len()];
        for (p, one) in self.numbers.iter().enumerate() {
            for (q, other) in self.numbers.iter().enumerate() {
                outputs.parameter_gradient(&[*one], &[*other], &mut by);
                let slopes = gradient[*at..].iter_mut().zip(&by);
                slopes.for_each(|(slope, by)| *slope += weights[(p, q)] * by);
            }
        }
    }
}

/// The output's number, B and where its parameters begin.
type Numbered = (usize, Coregionalization, usize);

/// The two factors of a product of which one is a covariance of outputs.
fn factors(spec: &KernelSpec, at: usize) -> Option<(Numbered, (&KernelSpec, usize))> {
    let KernelSpec::Product { first, second } = spec else { return None };
    let then = at + n_parameters(first);
    let numbered = |(column, outputs): (usize, Coregionalization), at| (column, outputs, at);
    match (outputs_of(first), outputs_of(second)) {
        (Some(outputs), None) => Some((numbered(outputs, at), (second, then))),
        (None, Some(outputs)) => Some((numbered(outputs, then), (first, at))),
        _ => None,
    }
}

/// A covariance of outputs that looks at one input.
fn outputs_of(spec: &KernelSpec) -> Option<(usize, Coregionalization)> {
    let KernelSpec::ActiveInputs { kernel, columns } = spec else { return None };
    match (&**kernel, &columns[..]) {
        (KernelSpec::Coregionalization { variances, odds, rank }, [column]) => {
            Some((*column, Coregionalization::of(variances, odds, *rank)))
        }
        _ => None,
    }
}

/// Whether a kernel may depend on an input.
fn looks_at(spec: &KernelSpec, column: usize) -> bool {
    match spec {
        KernelSpec::ActiveInputs { columns, .. } => columns.contains(&column),
        KernelSpec::Sum { first, second } | KernelSpec::Product { first, second } => {
            looks_at(first, column) || looks_at(second, column)
        }
        KernelSpec::Constant { .. } => false,
        _ => true,
    }
}

fn n_parameters(spec: &KernelSpec) -> usize {
    spec.build().parameters().len()
}
