//! Gaussian bumps: the columns of a squared-exponential kernel.

use faer::{Mat, MatRef};

use super::factors::Factors;
use super::{Averages, Basis, Expansion};
use crate::kernel::{column, column_mut};
use crate::triangle::inverse;
use crate::vector::{add_multiple, exp, vectorized};
use crate::{GaussianInput, Gp, GpError, Kernel, KernelSpec};

/// φᵢ(x) = s² exp(−½ Σ_d ((x_d − z_id)/l_d)²): k(x, zᵢ) of a squared-exponential kernel.
#[derive(Clone, Debug)]
pub struct SquaredExponentialBasis {
    lengthscales: Vec<f64>,
    signal_variance: f64,
    /// N×D.
    centers: Mat<f64>,
}

impl SquaredExponentialBasis {
    /// The columns of a kernel at the rows of `centers`, N×D.
    ///
    /// # Errors
    /// As [`Kernel::check`]; `NoClosedForm` for any kernel but the squared exponential of all inputs.
    pub fn new(kernel: &dyn Kernel, centers: MatRef<'_, f64>) -> Result<Self, GpError> {
        kernel.check(centers.ncols())?;
        match kernel.spec() {
            Some(KernelSpec::SquaredExponential { lengthscales, signal_variance }) => {
                let lengthscales = (0..centers.ncols()).map(|d| lengthscales.of(d)).collect();
                Ok(Self { lengthscales, signal_variance, centers: centers.to_owned() })
            }
            _ => Err(GpError::NoClosedForm { kernel: format!("{kernel:?}") }),
        }
    }

    /// s², the variance of the kernel's prior.
    pub fn signal_variance(&self) -> f64 {
        self.signal_variance
    }

    fn precisions(&self) -> Vec<f64> {
        self.lengthscales.iter().map(|lengthscale| lengthscale.powi(-2)).collect()
    }
}

/// SquaredExponentialBasis at an input.
#[derive(Clone, Debug)]
pub struct AveragedSquaredExponentialBasis {
    averages: Averages,
    log_averages: Vec<f64>,
    precisions: Vec<f64>,
    /// uᵢ = P (zᵢ − m), N×D.
    pulls: Mat<f64>,
    log_determinant: f64,
    /// (S⁻¹ + P)⁻¹, D×D.
    product: Mat<f64>,
}

impl AsRef<Averages> for AveragedSquaredExponentialBasis {
    fn as_ref(&self) -> &Averages {
        &self.averages
    }
}

impl Basis for SquaredExponentialBasis {
    type Averaged = AveragedSquaredExponentialBasis;

    fn n_inputs(&self) -> usize {
        self.lengthscales.len()
    }

    /// q = s² |I + S P|^−½ exp(−½ dᵀ (S + P⁻¹)⁻¹ d) with d = z − m, whose slope by m is
    /// q (S + P⁻¹)⁻¹ d; and (S + P⁻¹)⁻¹ = P − P (S⁻¹ + P)⁻¹ P.
    fn averaged(&self, input: &GaussianInput) -> AveragedSquaredExponentialBasis {
        let (n, d, precisions) = (self.centers.nrows(), self.n_inputs(), self.precisions());
        let Factors { log_determinant, product } = Factors::new(input, &precisions);
        let mean = input.mean();
        let pulls = Mat::from_fn(n, d, |i, k| precisions[k] * (self.centers[(i, k)] - mean[k]));
        let shifts = times(&pulls, &product);
        let mut slopes = Mat::from_fn(n, d, |i, k| pulls[(i, k)] - precisions[k] * shifts[(i, k)]);
        let mut log_averages = vec![self.signal_variance.ln() - 0.5 * log_determinant; n];
        for (k, mean) in mean.iter().enumerate() {
            let (center, slope) = (column(&self.centers, k), column(&slopes, k));
            for ((log, center), slope) in log_averages.iter_mut().zip(center).zip(slope) {
                *log -= 0.5 * (center - mean) * slope;
            }
        }
        let values: Vec<f64> = log_averages.iter().map(|log| exp(*log)).collect();
        for k in 0..d {
            column_mut(&mut slopes, k).iter_mut().zip(&values).for_each(|(s, q)| *s *= q);
        }
        let averages = Averages { values, slopes };
        AveragedSquaredExponentialBasis {
            averages,
            log_averages,
            precisions,
            pulls,
            log_determinant,
            product,
        }
    }

    /// E φᵢψⱼ = qᵢ rⱼ e^δ, so that the covariance is qᵢ rⱼ (e^δ − 1), where δ vanishes with S: with
    /// T = (S⁻¹ + P + P')⁻¹ it is ½ ln |I + SP| + ½ ln |I + SP'| − ½ ln |I + S(P + P')|
    /// + ½ uᵢᵀ (T − (S⁻¹ + P)⁻¹) uᵢ + ½ vⱼᵀ (T − (S⁻¹ + P')⁻¹) vⱼ + uᵢᵀ T vⱼ.
    fn covariances(
        own: &AveragedSquaredExponentialBasis,
        other: &AveragedSquaredExponentialBasis,
        input: &GaussianInput,
        lower: bool,
        mut visit: impl FnMut(usize, &[f64]),
    ) {
        let both: Vec<f64> =
            own.precisions.iter().zip(&other.precisions).map(|(a, b)| a + b).collect();
        let Factors { log_determinant, product } = Factors::new(input, &both);
        let constant = 0.5 * (own.log_determinant + other.log_determinant - log_determinant);
        let (of_own, of_other) = (own.changes(&product), other.changes(&product));
        let turned = times(&other.pulls, &product);
        let n = own.log_averages.len();
        let mut values = vec![0.0; n];
        for j in 0..other.log_averages.len() {
            let first = if lower { j } else { 0 };
            let values = &mut values[first..];
            values.copy_from_slice(&of_own[first..]);
            for k in 0..turned.ncols() {
                add_multiple(values, turned[(j, k)], &column(&own.pulls, k)[first..]);
            }
            let shift = constant + of_other[j];
            let (average, log_average) = (other.averages.values[j], other.log_averages[j]);
            let (averages, logs) = (&own.averages.values[first..], &own.log_averages[first..]);
            covary(values, shift, (averages, logs), (average, log_average));
            visit(j, values);
        }
    }
}

impl AveragedSquaredExponentialBasis {
    /// ½ uᵢᵀ (T − (S⁻¹ + P)⁻¹) uᵢ.
    fn changes(&self, product: &Mat<f64>) -> Vec<f64> {
        let turned = times(&self.pulls, &(product - &self.product));
        let mut halves = vec![0.0; self.log_averages.len()];
        for k in 0..turned.ncols() {
            for ((half, a), b) in
                halves.iter_mut().zip(column(&turned, k)).zip(column(&self.pulls, k))
            {
                *half += 0.5 * a * b;
            }
        }
        halves
    }
}

/// X A for a small square A: column by column, without the set-up of a large product.
fn times(x: &Mat<f64>, a: &Mat<f64>) -> Mat<f64> {
    let mut product = Mat::zeros(x.nrows(), a.ncols());
    for j in 0..a.ncols() {
        for k in 0..x.ncols() {
            add_multiple(column_mut(&mut product, j), a[(k, j)], column(x, k));
        }
    }
    product
}

/// Below this eˣ − 1 is taken from its series, above from the difference.
const NEAR: f64 = 0.35;
/// 1/(k + 1)!: those left out are less than 10⁻¹⁵ of the sum at `NEAR`.
const SERIES: [f64; 12] = [
    1.0,
    1.0 / 2.0,
    1.0 / 6.0,
    1.0 / 24.0,
    1.0 / 120.0,
    1.0 / 720.0,
    1.0 / 5040.0,
    1.0 / 40_320.0,
    1.0 / 362_880.0,
    1.0 / 3_628_800.0,
    1.0 / 39_916_800.0,
    1.0 / 479_001_600.0,
];

vectorized! {
    /// Replaces δᵢ by qᵢ r (e^(δᵢ + shift) − 1), which has no overflow where q r alone is 0.
    fn covary(
        values: &mut [f64],
        shift: f64,
        own: (&[f64], &[f64]),
        other: (f64, f64),
    ) {
        for ((value, average), log) in values.iter_mut().zip(own.0).zip(own.1) {
            let change = *value + shift;
            let product = average * other.0;
            let mut series = SERIES[SERIES.len() - 1];
            for coefficient in SERIES[..SERIES.len() - 1].iter().rev() {
                series = series * change + coefficient;
            }
            let far = exp(log + other.1 + change) - product;
            *value = if change.abs() < NEAR { product * change * series } else { far };
        }
    }
}

impl Gp {
    /// The belief about f as a sum of the kernel's columns: what it says of uncertain inputs; O(N³).
    ///
    /// # Errors
    /// `NoClosedForm` for any kernel but the squared exponential of all inputs; `PolynomialMean`.
    pub fn expansion(&self) -> Result<Expansion<SquaredExponentialBasis>, GpError> {
        if !self.trend.is_linear() {
            return Err(GpError::PolynomialMean);
        }
        let basis = SquaredExponentialBasis::new(self.kernel(), self.inputs())?;
        let prior = basis.signal_variance();
        let roots = vec![(-1.0, inverse(self.whole_factor()?.factor()))];
        let trend = (self.mean(), self.mean_slopes());
        let whole = Expansion::new(basis, trend, self.weights.clone(), prior, roots)?;
        self.deviations.iter().try_fold(whole, |whole, deviation| {
            let trend = (deviation.trend.constant(), deviation.trend.slopes());
            whole.with_deviation(trend, deviation.weights.clone())
        })
    }
}
