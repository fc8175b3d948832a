//! Maps of positive outputs to numbers that a process may be about.

use serde::{Deserialize, Serialize};

use crate::GpError;
use crate::checks::{check_outputs, check_positive, check_range};

/// A growing map z = g(y) of positive outputs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Transform {
    /// z = ln y: errors in proportion to the output.
    Log,
    /// z = (yˡ − 1)/l with l from 0, which is the logarithm, to 2; 1 changes nothing but the origin.
    ///
    /// What a process believes of z below −1/l counts as y = 0.
    ///
    /// # Source
    /// Box & Cox, An analysis of transformations (1964).
    BoxCox(f64),
}

impl Transform {
    /// The power that a process finds most likely, to about 0.01.
    ///
    /// - `log_likelihood`: of outputs that are transformed and scaled to keep their volume, e.g.
    ///   `|z| Ok(builder.fit(&x, z)?.log_marginal_likelihood())`; called some fifteen times.
    ///
    /// # Errors
    /// `Empty`, `NotFinite`, `NotPositive` for outputs that are not positive; those of
    /// `log_likelihood`.
    pub fn box_cox(
        y: &[f64],
        log_likelihood: impl Fn(&[f64]) -> Result<f64, GpError>,
    ) -> Result<Self, GpError> {
        let mean_log = Self::Log.forward(y)?.iter().sum::<f64>() / y.len() as f64;
        let loss = |power: f64| {
            // The Jacobian of z is Π yˡ⁻¹, which the geometric mean of y takes out.
            let scale = ((1.0 - power) * mean_log).exp();
            let z = Self::BoxCox(power).forward(y)?;
            Ok(-log_likelihood(&z.iter().map(|z| scale * z).collect::<Vec<f64>>())?)
        };
        golden_section(loss, 0.0, HIGHEST_POWER).map(Self::BoxCox)
    }

    /// Checks the power.
    ///
    /// # Errors
    /// `OutOfRange`.
    pub fn check(self) -> Result<(), GpError> {
        match self {
            Self::Log => Ok(()),
            Self::BoxCox(power) => check_range("power of Box–Cox", power, 0.0, HIGHEST_POWER),
        }
    }

    /// z of outputs.
    ///
    /// # Errors
    /// As `check`; `Empty`, `NotFinite`; `NotPositive` for an output that is not.
    pub fn forward(self, y: &[f64]) -> Result<Vec<f64>, GpError> {
        self.check()?;
        if y.is_empty() {
            return Err(GpError::Empty { what: "outputs" });
        }
        check_outputs("outputs", y, y.len())?;
        for (row, &value) in y.iter().enumerate() {
            check_positive(&format!("output of row {row}"), value)?;
        }
        let power = self.power();
        let one = |y: &f64| match power {
            0.0 => y.ln(),
            // (e^(l ln y) − 1)/l without losing the digits of small powers.
            _ => (power * y.ln()).exp_m1() / power,
        };
        Ok(y.iter().map(one).collect())
    }

    /// y of a z; 0 below the range of g.
    pub fn inverse(self, z: f64) -> f64 {
        match self.power() {
            0.0 => z.exp(),
            power if power * z <= -1.0 => 0.0,
            power => ((power * z).ln_1p() / power).exp(),
        }
    }

    /// ln g'(y).
    pub(crate) fn log_slope(self, y: f64) -> f64 {
        (self.power() - 1.0) * y.ln()
    }

    fn power(self) -> f64 {
        match self {
            Self::Log => 0.0,
            Self::BoxCox(power) => power,
        }
    }
}

const HIGHEST_POWER: f64 = 2.0;

/// Where a function with one valley between `low` and `high` is smallest, to 0.2 % of the way.
fn golden_section<E>(
    function: impl Fn(f64) -> Result<f64, E>,
    mut low: f64,
    mut high: f64,
) -> Result<f64, E> {
    let share = 0.5 * (5.0_f64.sqrt() - 1.0);
    let at = |low: f64, high: f64| low + share * (high - low);
    let (mut left, mut right) = (at(high, low), at(low, high));
    let (mut at_left, mut at_right) = (function(left)?, function(right)?);
    for _ in 0..13 {
        if at_left < at_right {
            (high, right, at_right) = (right, left, at_left);
            left = at(high, low);
            at_left = function(left)?;
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = at(low, high);
            at_right = function(right)?;
        }
    }
    Ok(0.5 * (low + high))
}
