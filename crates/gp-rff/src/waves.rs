//! Random features as waves, for inputs that are uncertain.

use faer::Mat;
use gp_core::{Averages, Basis, Expansion, GaussianInput, GpError};

use crate::rff_gp::Function;
use crate::{Form, RandomFeatures, RffGp};

/// φᵢ(x) = a cos(ωᵢᵀx + bᵢ).
#[derive(Clone, Debug)]
pub struct Waves {
    amplitude: f64,
    /// N×D.
    frequencies: Mat<f64>,
    phases: Vec<f64>,
}

impl Waves {
    /// The features, a sine as the cosine a quarter of a turn later.
    pub(crate) fn new(features: &RandomFeatures) -> Self {
        let (n, d) = (features.phases.len(), features.n_inputs());
        let mut phases = features.phases.clone();
        if features.form == Form::Paired {
            let sines = features.phases.iter().map(|phase| phase - std::f64::consts::FRAC_PI_2);
            phases.extend(sines);
        }
        let entry =
            |i: usize, k: usize| features.frequencies[i % n * d + k] / features.lengthscales[k];
        let frequencies = Mat::from_fn(phases.len(), d, entry);
        Self { amplitude: features.amplitude(), frequencies, phases }
    }
}

/// Waves at an input.
#[derive(Clone, Debug)]
pub struct AveragedWaves {
    averages: Averages,
    /// a cos(θ), a sin(θ), and half the variance of ωᵀx; θ = ωᵀm + b.
    waves: Vec<[f64; 3]>,
    frequencies: Mat<f64>,
}

impl AsRef<Averages> for AveragedWaves {
    fn as_ref(&self) -> &Averages {
        &self.averages
    }
}

impl Basis for Waves {
    type Averaged = AveragedWaves;

    fn n_inputs(&self) -> usize {
        self.frequencies.ncols()
    }

    /// E a cos(ωᵀx + b) = a e^(−½ ωᵀSω) cos(ωᵀm + b).
    fn averaged(&self, input: &GaussianInput) -> AveragedWaves {
        let (n, d) = (self.phases.len(), self.n_inputs());
        let spreads = &self.frequencies * input.covariance();
        let wave = |i: usize| {
            let over = |x: &dyn Fn(usize) -> f64| -> f64 {
                (0..d).map(|k| self.frequencies[(i, k)] * x(k)).sum()
            };
            let (sin, cos) = (over(&|k| input.mean()[k]) + self.phases[i]).sin_cos();
            let half = 0.5 * over(&|k| spreads[(i, k)]);
            [self.amplitude * cos, self.amplitude * sin, half]
        };
        let waves: Vec<[f64; 3]> = (0..n).map(wave).collect();
        let values = waves.iter().map(|[cos, _, half]| (-half).exp() * cos).collect();
        let slope = |i: usize, k: usize| {
            let [_, sin, half] = waves[i];
            -(-half).exp() * sin * self.frequencies[(i, k)]
        };
        let averages = Averages { values, slopes: Mat::from_fn(n, d, slope) };
        AveragedWaves { averages, waves, frequencies: self.frequencies.clone() }
    }

    /// Of a product of cosines half that of the difference and half that of the sum, each with its own
    /// spread: with c = ωᵢᵀSωⱼ, hᵢ = ½ ωᵢᵀSωᵢ and θ the angles at the mean,
    /// e^(−hᵢ−hⱼ) (cos θᵢ cos θⱼ (cosh c − 1) + sin θᵢ sin θⱼ sinh c).
    fn covariances(
        own: &AveragedWaves,
        other: &AveragedWaves,
        input: &GaussianInput,
        lower: bool,
        mut visit: impl FnMut(usize, &[f64]),
    ) {
        let spreads = &other.frequencies * input.covariance();
        let mut values = vec![0.0; own.waves.len()];
        for (j, [cos_j, sin_j, half_j]) in other.waves.iter().enumerate() {
            let first = if lower { j } else { 0 };
            let waves = own.waves[first..].iter().enumerate();
            for (value, (i, [cos, sin, half])) in values[first..].iter_mut().zip(waves) {
                let row =
                    (0..spreads.ncols()).map(|k| own.frequencies[(first + i, k)] * spreads[(j, k)]);
                let [up, down] = grown(row.sum(), half + half_j);
                *value = 0.5 * (cos * cos_j * (up + down) + sin * sin_j * (up - down));
            }
            visit(j, &values[first..]);
        }
    }
}

/// e^−h (e^c − 1) and e^−h (e^−c − 1) for |c| ≤ h, where either alone may be beyond what numbers hold.
fn grown(c: f64, h: f64) -> [f64; 2] {
    let small = (-h).exp();
    [c, -c].map(|c| if c.abs() < 1.0 { small * c.exp_m1() } else { (c - h).exp() - small })
}

impl RffGp {
    /// The belief about f as a sum of waves: what it says of uncertain inputs; O(M³).
    ///
    /// # Errors
    /// `PolynomialMean`.
    pub fn expansion(&self) -> Result<Expansion<Waves>, GpError> {
        if self.monomials.degree() > 1 {
            return Err(GpError::PolynomialMean);
        }
        let signal_sd = self.signal_variance.sqrt();
        let scaled = |one: &Function| one.weights.iter().map(|t| signal_sd * t).collect();
        let constant = |one: &Function| {
            let pairs = one.coefficients.iter().zip(self.monomials.center());
            one.constant - pairs.map(|(g, c)| g * c).sum::<f64>()
        };
        let root =
            faer::Scale((self.noise_variance * self.signal_variance).sqrt()) * &self.root_inverse;
        let (basis, own) = (Waves::new(&self.features), &self.function);
        let trend = (constant(own), &*own.coefficients);
        let whole = Expansion::new(basis, trend, scaled(own), 0.0, vec![(1.0, root)])?;
        self.deviations.iter().try_fold(whole, |whole, one| {
            whole.with_deviation((constant(one), &one.coefficients), scaled(one))
        })
    }
}
