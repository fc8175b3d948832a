//! Random features whose products approximate a kernel.

use faer::{Mat, MatMut, MatRef};
use gp_core::GpError;
use gp_core::checks::{check_count, check_inputs, check_positive};
use gp_core::kernel::column_of;
use gp_core::vector::{self, SIN_COS_LIMIT};
use serde::{Deserialize, Serialize};

use crate::draw::draw;
use crate::{Sampling, Spectrum};

/// How many features there are, and how they are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FeatureOptions {
    /// Number of features M.
    pub n_features: usize,
    /// What a frequency is turned into.
    pub form: Form,
    /// How frequencies are chosen.
    pub sampling: Sampling,
    /// Seed of all that is drawn.
    pub seed: u64,
}

impl Default for FeatureOptions {
    fn default() -> Self {
        Self { n_features: 200, form: Form::default(), sampling: Sampling::default(), seed: 0 }
    }
}

/// What a frequency ω is turned into.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Form {
    /// √(2/M) cos(ωᵀx + b) with a random phase b: the thesis' features, eq. 3.29.
    Cosines,
    /// √(2/M) cos(ωᵀx) and √(2/M) sin(ωᵀx): no phase, and k(x, x) without error.
    #[default]
    Paired,
}

/// M features φ of D inputs with φ(a)ᵀφ(b) ≈ k(a, b)/s², s² the signal variance.
///
/// Frequencies are kept for lengthscales of 1, so that other lengthscales need no new draw.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomFeatures {
    pub(crate) spectrum: Spectrum,
    pub(crate) form: Form,
    pub(crate) lengthscales: Vec<f64>,
    /// One frequency after the other, D numbers each.
    pub(crate) frequencies: Vec<f64>,
    pub(crate) phases: Vec<f64>,
}

impl RandomFeatures {
    /// Draws features for a kernel with one lengthscale an input.
    ///
    /// # Errors
    /// `Empty` without lengthscales; `NotPositive` for one that is not positive and finite or
    /// without features; `ShapeMismatch` for an odd number of paired features.
    pub fn new(
        spectrum: Spectrum,
        lengthscales: &[f64],
        options: FeatureOptions,
    ) -> Result<Self, GpError> {
        check_positive("n_features", options.n_features as f64)?;
        let n_frequencies = match options.form {
            Form::Cosines => options.n_features,
            Form::Paired => {
                let even = options.n_features.next_multiple_of(2);
                check_count("paired features, two a frequency", even, options.n_features)?;
                options.n_features / 2
            }
        };
        let d = lengthscales.len();
        spectrum.kernel(lengthscales, 1.0)?;
        let (frequencies, mut phases) =
            draw(spectrum, options.sampling, n_frequencies, d, options.seed);
        if options.form == Form::Paired {
            phases.fill(0.0);
        }
        let (form, lengthscales) = (options.form, lengthscales.to_vec());
        Ok(Self { spectrum, form, lengthscales, frequencies, phases })
    }

    /// The same frequencies for other lengthscales.
    ///
    /// # Errors
    /// `ShapeMismatch` for a wrong count; `NotPositive`.
    pub fn with_lengthscales(&self, lengthscales: &[f64]) -> Result<Self, GpError> {
        check_count("lengthscales", self.lengthscales.len(), lengthscales.len())?;
        self.spectrum.kernel(lengthscales, 1.0)?;
        Ok(Self { lengthscales: lengthscales.to_vec(), ..self.clone() })
    }

    /// The same lengthscales with frequencies of one's own: of any stationary kernel, whose spectrum they
    /// are drawn from.
    ///
    /// - `frequencies`: for lengthscales of 1, one a row; as many as there are.
    ///
    /// # Errors
    /// `ShapeMismatch`, `NotFinite`.
    pub fn with_frequencies(&self, frequencies: MatRef<'_, f64>) -> Result<Self, GpError> {
        check_count("frequencies", self.phases.len(), frequencies.nrows())?;
        check_inputs("frequencies", frequencies, self.n_inputs())?;
        let rows = frequencies.row_iter().flat_map(|row| row.iter().copied().collect::<Vec<_>>());
        Ok(Self { frequencies: rows.collect(), ..self.clone() })
    }

    /// The frequencies for lengthscales of 1, one a row.
    pub fn frequencies(&self) -> MatRef<'_, f64> {
        MatRef::from_row_major_slice(&self.frequencies, self.phases.len(), self.n_inputs())
    }

    /// The number of features M.
    pub fn n_features(&self) -> usize {
        match self.form {
            Form::Cosines => self.phases.len(),
            Form::Paired => 2 * self.phases.len(),
        }
    }

    /// The number of input coordinates D.
    pub fn n_inputs(&self) -> usize {
        self.lengthscales.len()
    }

    /// The lengthscales, each in the unit of its input.
    pub fn lengthscales(&self) -> &[f64] {
        &self.lengthscales
    }

    /// The kernel that is approximated.
    pub fn spectrum(&self) -> Spectrum {
        self.spectrum
    }

    /// The features of every row of `x`, N×M.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch` or `NotFinite` if `x` is not a finite N×D matrix.
    pub fn evaluate(&self, x: MatRef<'_, f64>) -> Result<Mat<f64>, GpError> {
        check_inputs("inputs", x, self.n_inputs())?;
        let mut values = Mat::zeros(x.nrows(), self.n_features());
        self.fill(x, values.as_mut(), None);
        Ok(values)
    }

    /// Writes the features into the first columns of `values` and, where asked for, the sine beside
    /// each cosine, N×frequencies.
    pub(crate) fn fill(
        &self,
        x: MatRef<'_, f64>,
        mut values: MatMut<'_, f64>,
        mut sines: Option<MatMut<'_, f64>>,
    ) {
        let amplitude = self.amplitude();
        let n_frequencies = self.phases.len();
        let mut sine = [0.0; ROWS];
        let largest: Vec<f64> = (0..x.ncols())
            .map(|d| x.col(d).iter().fold(0.0_f64, |most, x| most.max(x.abs())))
            .collect();
        let frequencies = self.frequencies.chunks_exact(self.n_inputs());
        for (j, (frequency, phase)) in frequencies.zip(&self.phases).enumerate() {
            let scales = || frequency.iter().zip(&self.lengthscales).map(|(f, l)| f / l);
            let reach = |(scale, largest): (f64, &f64)| scale.abs() * largest;
            let bound = phase.abs() + scales().zip(&largest).map(reach).sum::<f64>();
            for start in (0..x.nrows()).step_by(ROWS) {
                let n = ROWS.min(x.nrows() - start);
                let cosine = &mut column_of(values.as_mut(), j)[start..start + n];
                let sine = &mut sine[..n];
                cosine.fill(*phase);
                for (d, scale) in scales().enumerate() {
                    add_multiple(cosine, scale, x, start, d);
                }
                turn(cosine, sine, amplitude, bound);
                if self.form == Form::Paired {
                    let column = column_of(values.as_mut(), n_frequencies + j);
                    column[start..start + n].copy_from_slice(sine);
                }
                if let Some(sines) = &mut sines {
                    column_of(sines.as_mut(), j)[start..start + n].copy_from_slice(sine);
                }
            }
        }
    }

    /// √(2/M).
    pub(crate) fn amplitude(&self) -> f64 {
        (2.0 / self.n_features() as f64).sqrt()
    }

    /// A number that two feature sets share only if they are the same.
    pub(crate) fn fingerprint(&self) -> u64 {
        let numbers = self.lengthscales.iter().chain(&self.frequencies).chain(&self.phases);
        let header = [self.form as u64, self.n_inputs() as u64];
        let words = header.into_iter().chain(numbers.map(|number| number.to_bits()));
        // FNV-1a, word by word.
        words.fold(0xcbf2_9ce4_8422_2325, |hash, word| {
            (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3).rotate_left(29)
        })
    }
}

/// Rows whose sines stay on the stack.
const ROWS: usize = 256;

fn add_multiple(sums: &mut [f64], factor: f64, x: MatRef<'_, f64>, start: usize, d: usize) {
    let rows = x.col(d).subrows(start, sums.len());
    match rows.try_as_col_major() {
        Some(rows) => vector::add_multiple(sums, factor, rows.as_slice()),
        None => {
            for (sum, x) in sums.iter_mut().zip(rows.iter()) {
                *sum += factor * x;
            }
        }
    }
}

/// Replaces angles by a·cos, and writes a·sin.
///
/// - `bound`: no angle is beyond it.
fn turn(angles: &mut [f64], sines: &mut [f64], amplitude: f64, bound: f64) {
    if bound <= SIN_COS_LIMIT {
        return vector::turn(angles, sines, amplitude);
    }
    for (angle, sine) in angles.iter_mut().zip(sines) {
        let (s, c) = angle.sin_cos();
        *sine = amplitude * s;
        *angle = amplitude * c;
    }
}
