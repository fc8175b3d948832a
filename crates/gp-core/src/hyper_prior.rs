//! Priors of hyperparameters.

/// What is known of the hyperparameters before the data.
///
/// The likelihood of a few noisy rows often has its maximum where a short lengthscale explains the
/// noise away, and intervals are too small by far; a weak prior moves it from there, and fades as
/// rows are added.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum HyperPrior {
    /// Nothing: the marginal likelihood alone is maximised.
    #[default]
    Flat,
    /// Hyperparameters are log-normal and independent. The medians are the usual start (see
    /// [`crate::GpBuilder::fit`]) but for the noise variance, whose median is half of the outputs' variance.
    LogNormal {
        /// Standard deviation of ln θ for a lengthscale, a period or a shape.
        lengthscale_sd: f64,
        /// Standard deviation of ln s for the standard deviations s of signal and noise.
        scale_sd: f64,
    },
}
