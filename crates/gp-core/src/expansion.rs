//! Beliefs that are sums over known functions, and what they say of an input that is uncertain.

mod bumps;
mod factors;

use std::fmt::Debug;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};

pub use self::bumps::{AveragedSquaredExponentialBasis, SquaredExponentialBasis};
use crate::checks::check_count;
use crate::kernel::column;
use crate::triangle::add_outer;
use crate::vector::dot;
use crate::{GaussianInput, GpError};

/// N functions φᵢ of D inputs whose moments under a Gaussian are known in closed form.
pub trait Basis: Debug + Send + Sync {
    /// What is worked out once for an input, from which covariances follow.
    type Averaged: AsRef<Averages>;

    /// The number of inputs D.
    fn n_inputs(&self) -> usize;

    /// E φᵢ(x) and E ∂φᵢ/∂x for x ~ N(m, S).
    fn averaged(&self, input: &GaussianInput) -> Self::Averaged;

    /// Calls `visit(j, c)` for every function ψⱼ of another basis, with cᵢ = cov(φᵢ(x), ψⱼ(x)); with
    /// `lower` from i = j on alone, for a basis with itself.
    ///
    /// Each must vanish with S digit by digit: they are multiplied by weights that nearly cancel.
    fn covariances(
        own: &Self::Averaged,
        other: &Self::Averaged,
        input: &GaussianInput,
        lower: bool,
        visit: impl FnMut(usize, &[f64]),
    );
}

/// The first moments of N functions of D inputs.
#[derive(Clone, Debug)]
pub struct Averages {
    /// E φᵢ, N.
    pub values: Vec<f64>,
    /// E ∂φᵢ/∂x, N×D.
    pub slopes: Mat<f64>,
}

/// A belief about a function f with independent parts: a mean m(x) = c + gᵀx + Σᵢ αᵢ φᵢ(x) and a
/// variance v(x) = v₀ + Σᵣ ±|Fᵣ φ(x)|² + Σ d(x)², where each deviation d has the form of m.
///
/// An exact Gaussian process, a sparse one, and one on random features all are of this form. With it
/// the moments of f at an input that is Gaussian itself need no points and no linearisation.
#[derive(Clone, Debug)]
pub struct Expansion<B> {
    basis: B,
    mean: Combination,
    variance: f64,
    roots: Vec<(f64, Mat<f64>)>,
    deviations: Vec<Combination>,
    /// Σᵣ ±FᵣᵀFᵣ + Σ w wᵀ over the weights of deviations; the lower triangle.
    square: Mat<f64>,
}

/// c + gᵀx + Σᵢ wᵢ φᵢ(x).
#[derive(Clone, Debug)]
struct Combination {
    constant: f64,
    slopes: Vec<f64>,
    weights: Vec<f64>,
}

/// What independent functions f₁ … f_E are at one input that is Gaussian: no observation noise.
#[derive(Clone, Debug)]
pub struct UncertainOutputs {
    /// E f, of each function.
    pub mean: Vec<f64>,
    /// E v, of each function: how sure it would be if the input were known.
    pub variance: Vec<f64>,
    /// cov(f, f), E×E: the expected variances on the diagonal, and what the common input does.
    pub covariance: Mat<f64>,
    /// E ∂m/∂x, D×E: the covariance of input and output is S times it, and that of the output with
    /// whatever is Gaussian together with the input is its covariance with the input times it.
    pub slopes: Mat<f64>,
}

impl<B: Basis> Expansion<B> {
    /// A belief of its parts; O(N³).
    ///
    /// - `trend`: c, and g, one an input or none; - `weights`: α, N.
    /// - `variance`: v₀; - `roots`: the signs ±1 with Fᵣ, of N columns.
    ///
    /// # Errors
    /// `ShapeMismatch` for slopes or roots that do not fit the basis.
    pub fn new(
        basis: B,
        trend: (f64, &[f64]),
        weights: Vec<f64>,
        variance: f64,
        roots: Vec<(f64, Mat<f64>)>,
    ) -> Result<Self, GpError> {
        let (constant, slopes) = trend;
        if !slopes.is_empty() {
            check_count("slopes of the mean", basis.n_inputs(), slopes.len())?;
        }
        let n = weights.len();
        let mut square = Mat::zeros(n, n);
        for (sign, root) in &roots {
            check_count("columns of a root", n, root.ncols())?;
            let sum = square.as_mut();
            matmul(sum, Accum::Add, root.transpose(), root, *sign, Par::Seq);
        }
        let mean = Combination { constant, slopes: slopes.to_vec(), weights };
        Ok(Self { basis, mean, variance, roots, deviations: Vec::new(), square })
    }

    /// The same with one more deviation d, c + gᵀx + Σᵢ wᵢ φᵢ(x).
    ///
    /// - `trend`: c, and g, one an input or none; - `weights`: w, N.
    ///
    /// # Errors
    /// `ShapeMismatch` for slopes or weights that do not fit the basis.
    pub fn with_deviation(
        mut self,
        trend: (f64, &[f64]),
        weights: Vec<f64>,
    ) -> Result<Self, GpError> {
        let (constant, slopes) = trend;
        if !slopes.is_empty() {
            check_count("slopes of a deviation", self.basis.n_inputs(), slopes.len())?;
        }
        check_count("weights of a deviation", self.mean.weights.len(), weights.len())?;
        add_outer(&mut self.square, &weights);
        self.deviations.push(Combination { constant, slopes: slopes.to_vec(), weights });
        Ok(self)
    }

    /// The number of inputs D.
    pub fn n_inputs(&self) -> usize {
        self.basis.n_inputs()
    }

    /// The moments of several functions at one Gaussian input, in closed form; O(N² D) for each pair.
    ///
    /// By the laws of total expectation and covariance: E f = E m, and cov(f_a, f_b) =
    /// cov(m_a, m_b), to which E v is added where a = b.
    ///
    /// # Errors
    /// `Empty` without functions; `ShapeMismatch` if one has not as many inputs as there are.
    ///
    /// # Source
    /// Girard, Rasmussen, Quiñonero-Candela & Murray-Smith (2003), Gaussian process priors with
    /// uncertain inputs; Deisenroth & Rasmussen (2011), PILCO, for covariances of several outputs.
    pub fn at(all: &[&Self], input: &GaussianInput) -> Result<UncertainOutputs, GpError> {
        if all.is_empty() {
            return Err(GpError::Empty { what: "functions" });
        }
        let (n, d) = (all.len(), input.n_inputs());
        for one in all {
            check_count("inputs of a function", d, one.n_inputs())?;
        }
        let known: Vec<B::Averaged> = all.iter().map(|one| one.basis.averaged(input)).collect();
        let sums: Vec<Vec<f64>> =
            all.iter().zip(&known).map(|(one, known)| one.mean.slopes(known.as_ref(), d)).collect();
        let mean = all.iter().zip(&known).map(|(one, known)| one.mean.value(known.as_ref(), input));
        let mut outputs = UncertainOutputs {
            mean: mean.collect(),
            variance: vec![0.0; n],
            covariance: Mat::zeros(n, n),
            slopes: Mat::from_fn(d, n, |i, a| sums[a][i]),
        };
        for a in 0..n {
            for b in 0..=a {
                let trends = all[a].mean.with_trends(&all[b].mean, [&sums[a], &sums[b]], input);
                let value = if a == b {
                    let (of_mean, of_variance) = all[a].own_covariance(&known[a], input);
                    outputs.variance[a] = of_variance;
                    // Rounding alone can make a variance negative.
                    (of_mean + trends).max(0.0) + of_variance
                } else {
                    all[a].covariance(&known[a], all[b], &known[b], input) + trends
                };
                outputs.covariance[(a, b)] = value;
                outputs.covariance[(b, a)] = value;
            }
        }
        Ok(outputs)
    }

    /// Σᵢⱼ αᵢ cov(φᵢ, ψⱼ) βⱼ.
    fn covariance(
        &self,
        known: &B::Averaged,
        other: &Self,
        others: &B::Averaged,
        input: &GaussianInput,
    ) -> f64 {
        let mut sum = 0.0;
        B::covariances(known, others, input, false, |j, column| {
            sum += other.mean.weights[j] * dot(&self.mean.weights, column);
        });
        sum
    }

    /// The same with itself, and the expected variance: v(x) at the average of the basis, and beyond it
    /// Σᵢⱼ (Σᵣ ±FᵣᵀFᵣ)ᵢⱼ cov(φᵢ, φⱼ).
    fn own_covariance(&self, known: &B::Averaged, input: &GaussianInput) -> (f64, f64) {
        let (mut of_mean, mut of_variance) = (0.0, 0.0);
        let weights = &self.mean.weights;
        B::covariances(known, known, input, true, |j, below| {
            let (own, rest) = (below[0], &below[1..]);
            of_mean += weights[j] * (weights[j] * own + 2.0 * dot(&weights[j + 1..], rest));
            let square = &column(&self.square, j)[j..];
            of_variance += square[0] * own + 2.0 * dot(&square[1..], rest);
        });
        let at_average = self.roots.iter().map(|(sign, root)| {
            let mut image = vec![0.0; root.nrows()];
            for (k, value) in known.as_ref().values.iter().enumerate() {
                crate::vector::add_multiple(&mut image, *value, column(root, k));
            }
            sign * dot(&image, &image)
        });
        let at_average = self.variance + at_average.sum::<f64>();
        // The variance of a deviation's weighted sum is in the square.
        let of_deviations = self.deviations.iter().map(|one| {
            let sums = one.slopes(known.as_ref(), input.n_inputs());
            let value = one.value(known.as_ref(), input);
            value * value + one.with_trends(one, [&sums, &sums], input)
        });
        let total = at_average + of_deviations.sum::<f64>() + of_variance;
        (of_mean, total.max(0.0))
    }
}

impl Combination {
    /// Its expectation.
    fn value(&self, known: &Averages, input: &GaussianInput) -> f64 {
        let trend: f64 = self.slopes.iter().zip(input.mean()).map(|(g, x)| g * x).sum();
        self.constant + trend + dot(&self.weights, &known.values)
    }

    /// g + Σᵢ wᵢ E ∂φᵢ/∂x.
    fn slopes(&self, known: &Averages, d: usize) -> Vec<f64> {
        let of_trend = |k: usize| self.slopes.get(k).copied().unwrap_or(0.0);
        (0..d).map(|k| of_trend(k) + dot(column(&known.slopes, k), &self.weights)).collect()
    }

    /// What trends add to a covariance of two: by Stein's lemma cov(x, m) = S E ∂m/∂x.
    fn with_trends(&self, other: &Self, sums: [&[f64]; 2], input: &GaussianInput) -> f64 {
        let s = input.covariance();
        let product = |a: &[f64], b: &[f64]| -> f64 {
            let row = |i: usize| b.iter().enumerate().map(|(j, b)| s[(i, j)] * b).sum::<f64>();
            a.iter().enumerate().map(|(i, a)| a * row(i)).sum()
        };
        let (own, others) = (&self.slopes, &other.slopes);
        product(own, sums[1]) + product(sums[0], others) - product(own, others)
    }
}
