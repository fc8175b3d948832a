//! What a measurement says of a state.

/// A measurement that was made, as a function of the state.
pub trait MeasurementModel: Sync {
    /// What is measured.
    type State;

    /// Log density of the measurement if `state` were true, up to a constant; −∞ where it is
    /// impossible.
    fn log_likelihood(&self, state: &Self::State) -> f64;
}
