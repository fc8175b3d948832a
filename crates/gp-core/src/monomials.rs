//! The functions that a learnt mean is a sum of.

use faer::MatRef;

use crate::vector::add_multiple;

/// Products of inputs less a center: 1, then x_d − c_d, then (x_d − c_d)(x_e − c_e) with d ≤ e, and so on,
/// up to a degree.
#[derive(Clone, Debug, PartialEq)]
pub struct Monomials {
    degree: u32,
    center: Vec<f64>,
    /// Of each but the 1: the one before it, and the input, of which it is the product.
    factors: Vec<(usize, usize)>,
}

impl Monomials {
    /// - `degree`: the most inputs in a product; - `center`: c, one an input.
    pub fn new(degree: u32, center: &[f64]) -> Self {
        let mut factors = Vec::new();
        let mut last = vec![(0, 0)];
        for _ in 0..degree {
            let mut next = Vec::new();
            for (place, first) in last {
                for input in first..center.len() {
                    factors.push((place, input));
                    next.push((factors.len(), input));
                }
            }
            last = next;
        }
        Self { degree, center: center.to_vec(), factors }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        1 + self.factors.len()
    }

    /// The most inputs in a product.
    pub fn degree(&self) -> u32 {
        self.degree
    }

    /// c.
    pub fn center(&self) -> &[f64] {
        &self.center
    }

    /// The last input in product `index`; none of the 1.
    pub fn input(&self, index: usize) -> Option<usize> {
        index.checked_sub(1).map(|index| self.factors[index].1)
    }

    /// The values of each at every row.
    pub fn columns(&self, x: MatRef<'_, f64>) -> Vec<Vec<f64>> {
        let mut columns = vec![vec![1.0; x.nrows()]];
        for &(place, input) in &self.factors {
            columns.push(self.product(x, input, &columns[place]));
        }
        columns
    }

    /// Adds Σ_k `coefficients[k]` times product number k + 1 to the values of the rows: all but the 1.
    pub fn add(&self, x: MatRef<'_, f64>, coefficients: &[f64], values: &mut [f64]) {
        if coefficients.is_empty() {
            return;
        }
        let columns = self.columns(x);
        for (coefficient, column) in coefficients.iter().zip(&columns[1..]) {
            add_multiple(values, *coefficient, column);
        }
    }

    /// Adds the gradient of that sum by the inputs at `x`.
    pub fn add_gradient(&self, x: &[f64], coefficients: &[f64], gradient: &mut [f64]) {
        let d = self.center.len();
        let mut known = vec![(1.0, vec![0.0; d])];
        for (&(place, input), coefficient) in self.factors.iter().zip(coefficients) {
            let offset = x[input] - self.center[input];
            let (value, slopes) = &known[place];
            let mut own: Vec<f64> = slopes.iter().map(|slope| slope * offset).collect();
            own[input] += value;
            gradient.iter_mut().zip(&own).for_each(|(sum, slope)| *sum += coefficient * slope);
            known.push((value * offset, own));
        }
    }

    fn product(&self, x: MatRef<'_, f64>, input: usize, of: &[f64]) -> Vec<f64> {
        let center = self.center[input];
        x.col(input).iter().zip(of).map(|(x, of)| (x - center) * of).collect()
    }
}
