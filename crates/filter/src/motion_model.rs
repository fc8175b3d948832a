//! How states move.

use std::error::Error;

use rand::Rng;

/// How a state moves in one step, with its randomness.
///
/// It is asked for many particles at a time, so that models that predict in batches can.
pub trait MotionModel: Sync {
    /// What moves.
    type State: Clone + Send + Sync;
    /// Why a step cannot be predicted.
    type Error: Error + Send + Sync + 'static;

    /// Moves every state on by one step, each with a draw of its own from `random`.
    ///
    /// # Errors
    /// What the model says.
    fn advance(&self, states: &mut [Self::State], random: &mut dyn Rng) -> Result<(), Self::Error>;
}

/// A motion of which the density is known: what smoothing particles takes.
pub trait MotionDensity: MotionModel {
    /// Log density of the step from one state to another, up to a constant; −∞ where it is impossible.
    fn log_density(&self, from: &Self::State, to: &Self::State) -> f64;
}

/// A motion that knows the density of its own draws.
pub trait DrawnMotion: MotionModel {
    /// As [`MotionModel::advance`], and writes the log density of each draw.
    ///
    /// # Errors
    /// What the model says.
    fn advance_with_density(
        &self,
        states: &mut [Self::State],
        log_densities: &mut [f64],
        random: &mut dyn Rng,
    ) -> Result<(), Self::Error>;
}
