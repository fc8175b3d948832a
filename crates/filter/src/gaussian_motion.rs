//! Gaussians that move, and what later ones say of earlier ones.

use nalgebra::{DMatrix, DVector};

use crate::gaussian_measurement::finite;
use crate::linearized::{Linearized, symmetric};
use crate::{FilterError, Gaussian, Rule};

/// A motion x′ = F x + w with a Gaussian w.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearMotion {
    matrix: DMatrix<f64>,
    added: Gaussian,
}

impl LinearMotion {
    /// A motion by F and w, of which the mean is what is known to be added.
    ///
    /// One step of the extended Kalman filter has the Jacobian J of f at the mean m for F, and
    /// f(m) − J m for the mean of w.
    ///
    /// # Errors
    /// `ShapeMismatch` if F has another number of rows than w; `NotFinite`.
    pub fn new(matrix: DMatrix<f64>, added: Gaussian) -> Result<Self, FilterError> {
        let (expected, actual) = (added.mean().len(), matrix.nrows());
        if actual != expected {
            let what = "rows of the motion's matrix";
            return Err(FilterError::ShapeMismatch { what, expected, actual });
        }
        finite("an entry of the motion's matrix", &matrix)?;
        Ok(Self { matrix, added })
    }
}

/// A Gaussian that moved, which knows where it came from.
#[derive(Clone, Debug)]
pub struct Prediction {
    earlier: Gaussian,
    state: Gaussian,
    line: Linearized,
}

impl Prediction {
    /// After the motion.
    #[must_use]
    pub fn state(&self) -> &Gaussian {
        &self.state
    }

    /// Before the motion.
    #[must_use]
    pub fn earlier(&self) -> &Gaussian {
        &self.earlier
    }

    /// What is known of the state before the motion, once `later` is known of that after it: one step
    /// back of the Rauch–Tung–Striebel smoother.
    ///
    /// # Errors
    /// `ShapeMismatch` for a later state of another dimension.
    pub fn smoothed(&self, later: &Gaussian) -> Result<Gaussian, FilterError> {
        let (expected, actual) = (self.state.mean().len(), later.mean().len());
        if actual != expected {
            return Err(FilterError::ShapeMismatch { what: "later state", expected, actual });
        }
        let whitener = self.state.whitener();
        let gain = (&whitener * &self.line.slope).transpose() * whitener;
        let known = symmetric(&self.line.rest + later.covariance());
        let covariance = self.line.corrected(&gain, &known);
        self.earlier.of_standard(&(gain * (later.mean() - self.state.mean())), &covariance)
    }
}

/// All states of a series of predictions, smoothed: the state before each of them, and the last.
///
/// - `predictions`: each of the filtered state before its motion; `last`: the last filtered state.
///
/// # Errors
/// As [`Prediction::smoothed`].
///
/// # Source
/// Rauch, Tung & Striebel (1965), Maximum likelihood estimates of linear dynamic systems, AIAA Journal
/// 3(8); by points Särkkä (2008), Unscented Rauch–Tung–Striebel smoother, IEEE Trans. Automatic Control
/// 53(3).
pub fn rauch_tung_striebel(
    predictions: &[Prediction],
    last: &Gaussian,
) -> Result<Vec<Gaussian>, FilterError> {
    let mut smoothed = vec![last.clone()];
    for prediction in predictions.iter().rev() {
        smoothed.push(prediction.smoothed(&smoothed[smoothed.len() - 1])?);
    }
    smoothed.reverse();
    Ok(smoothed)
}

impl Gaussian {
    /// The Kalman filter's prediction.
    ///
    /// # Errors
    /// `ShapeMismatch` for a motion of another state.
    pub fn predicted(&self, motion: &LinearMotion) -> Result<Prediction, FilterError> {
        let (expected, actual) = (self.mean().len(), motion.matrix.ncols());
        if actual != expected {
            let what = "columns of the motion's matrix";
            return Err(FilterError::ShapeMismatch { what, expected, actual });
        }
        self.moved(Linearized {
            center: &motion.matrix * self.mean() + motion.added.mean(),
            slope: &motion.matrix * self.root(),
            rest: motion.added.covariance().clone(),
        })
    }

    /// The prediction by a rule's points, where the motion gives a Gaussian for each state: the state is
    /// that of [`Gaussian::propagated`].
    ///
    /// # Errors
    /// What `motion` says; `ShapeMismatch` if its Gaussians differ in dimension.
    pub fn predicted_by<E: From<FilterError>>(
        &self,
        rule: &dyn Rule,
        motion: impl Fn(&DVector<f64>) -> Result<Self, E>,
    ) -> Result<Prediction, E> {
        let points = self.standard_points(rule);
        let mut means: Vec<DVector<f64>> = Vec::with_capacity(points.len());
        let mut drawn: Option<DMatrix<f64>> = None;
        let total: f64 = points.iter().map(|(_, weight)| weight).sum();
        for (point, weight) in &points {
            let moved = motion(&self.at(point))?;
            let (expected, actual) =
                (means.first().unwrap_or(moved.mean()).len(), moved.mean().len());
            if actual != expected {
                Err(FilterError::ShapeMismatch { what: "component", expected, actual })?;
            }
            let share = moved.covariance() * (weight / total);
            drawn = Some(drawn.map_or_else(|| share.clone(), |sum| sum + &share));
            means.push(moved.mean().clone());
        }
        let drawn = drawn.ok_or(FilterError::Empty { what: "points" })?;
        let mut line = Linearized::of_points(&points, &means);
        line.rest += drawn;
        Ok(self.moved(line)?)
    }

    fn moved(&self, line: Linearized) -> Result<Prediction, FilterError> {
        let state = Self::new(line.center.clone(), line.covariance())?;
        Ok(Prediction { earlier: self.clone(), state, line })
    }
}
