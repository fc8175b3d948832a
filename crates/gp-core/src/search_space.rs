//! Where the optimiser starts and which parameter values it may visit, from the spread of the data.

use faer::MatRef;

use crate::{HyperPrior, Kernel, LowDiscrepancy, Role};

/// Standardised log-parameters: u = ln(θ/scale), with the scale of each from the data's spread.
///
/// A lengthscale or period scales with the standard deviation of its input and a variance with the
/// variance of the outputs, so u is what standardised inputs and outputs would give, and the
/// likelihood stays that of the data in the user's units.
/// The noise variance is the last parameter, but for what `with_shape` adds.
pub struct SearchSpace {
    log_scales: Vec<f64>,
    ranges: Vec<Range>,
    stiffness: f64,
    prior: HyperPrior,
}

impl SearchSpace {
    /// The space for a kernel and data with outputs that are not all equal.
    pub fn new(kernel: &dyn Kernel, x: MatRef<'_, f64>, y: &[f64], prior: HyperPrior) -> Self {
        let spread_of = |input: usize| {
            let values: Vec<f64> = x.col(input).iter().copied().collect();
            0.5 * log_variance(&values).unwrap_or(0.0)
        };
        let all: Vec<f64> = (0..x.ncols()).map(spread_of).collect();
        // One parameter of several inputs scales with the geometric mean of their spreads.
        let log_spread = |inputs: &[usize]| match inputs {
            [] => all.iter().sum::<f64>() / all.len() as f64,
            some => some.iter().map(|&input| all[input]).sum::<f64>() / some.len() as f64,
        };
        let output = log_variance(y).unwrap_or(0.0);
        let center = 0.5 * (x.ncols() as f64).ln();
        let (mut log_scales, mut ranges) = (Vec::new(), Vec::new());
        for parameter in kernel.parameters() {
            let log_value = parameter.value.ln();
            let (log_scale, range) = match parameter.role {
                Role::Lengthscale { inputs } => (log_spread(&inputs), Range::lengthscale(center)),
                Role::Period { inputs } => {
                    let log_scale = log_spread(&inputs);
                    (log_scale, Range::around(log_value - log_scale))
                }
                Role::Variance => (output, Range::signal()),
                Role::SlopeVariance { inputs } => {
                    (output - 2.0 * log_spread(&inputs), Range::signal())
                }
                Role::Shape => (0.0, Range::around(log_value)),
            };
            log_scales.push(log_scale);
            ranges.push(range);
        }
        log_scales.push(output);
        ranges.push(Range::noise());
        Self { log_scales, ranges, stiffness: STIFFNESS * y.len() as f64, prior }
    }

    /// One more parameter behind the noise variance, without unit, that starts at `value`.
    pub fn with_shape(mut self, value: f64) -> Self {
        self.log_scales.push(0.0);
        self.ranges.push(Range::around(value.ln()));
        self
    }

    /// Start number `index`: the first in the usual place, the others a low-discrepancy set.
    pub fn start(&self, index: usize, seed: u64) -> Vec<f64> {
        if index == 0 {
            return self.ranges.iter().map(|range| range.start).collect();
        }
        let fractions = LowDiscrepancy::new(self.ranges.len(), seed).point(index);
        let place =
            |(range, fraction): (&Range, f64)| range.low + fraction * (range.high - range.low);
        self.ranges.iter().zip(fractions).map(place).collect()
    }

    /// The parameters θ in the user's units.
    pub fn parameters(&self, point: &[f64]) -> Vec<f64> {
        point.iter().zip(&self.log_scales).map(|(u, log_scale)| (u + log_scale).exp()).collect()
    }

    /// The standardised point of parameters θ in the user's units.
    pub fn point(&self, parameters: &[f64]) -> Vec<f64> {
        parameters.iter().zip(&self.log_scales).map(|(p, log_scale)| p.ln() - log_scale).collect()
    }

    /// The penalty of standing behind a wall, less the log prior up to its constant; its gradient
    /// is added to `gradient`. 0 between the walls under a flat prior.
    pub fn penalty(&self, point: &[f64], gradient: &mut [f64]) -> f64 {
        let mut penalty = 0.0;
        for ((u, range), slope) in point.iter().zip(&self.ranges).zip(gradient) {
            let excess = u - u.clamp(range.lowest, range.highest);
            penalty += 0.5 * self.stiffness * excess * excess;
            *slope += self.stiffness * excess;
            if let Some(sd) = range.prior_sd(self.prior) {
                let deviation = (u - range.center) / sd;
                penalty += 0.5 * deviation * deviation;
                *slope += deviation / sd;
            }
        }
        penalty
    }

    /// Which parameters stand at a wall or behind it.
    pub fn at_bound(&self, point: &[f64]) -> Vec<usize> {
        let outside =
            |i: &usize| point[*i] <= self.ranges[*i].lowest || point[*i] >= self.ranges[*i].highest;
        (0..point.len()).filter(outside).collect()
    }
}

/// The curvature of a wall's parabola for each row of data, in nats per squared log-parameter:
/// stiff beside the likelihood, which grows at most like N/2 times a log-parameter.
const STIFFNESS: f64 = 10.0;

/// Values of one standardised log-parameter.
struct Range {
    start: f64,
    /// The median of a log-normal prior.
    center: f64,
    is_variance: bool,
    low: f64,
    high: f64,
    lowest: f64,
    highest: f64,
}

impl Range {
    /// Signal variance over output variance: start at 1, walls at 1e-6 and 1e6.
    fn signal() -> Self {
        let far = 1e6_f64.ln();
        Self {
            start: 0.0,
            center: 0.0,
            is_variance: true,
            low: -1.0,
            high: 1.5,
            lowest: -far,
            highest: far,
        }
    }

    /// Noise variance over output variance: start at 0.1, walls at 1e-8 and 10.
    fn noise() -> Self {
        Self {
            start: 0.1_f64.ln(),
            center: 0.5_f64.ln(),
            is_variance: true,
            low: 1e-4_f64.ln(),
            high: 0.5_f64.ln(),
            lowest: 1e-8_f64.ln(),
            highest: 10_f64.ln(),
        }
    }

    /// Lengthscale over input spread: start at √D, walls at 0.01 and 100 √D.
    fn lengthscale(center: f64) -> Self {
        Self {
            start: center,
            center,
            is_variance: false,
            low: center - 10f64.ln(),
            high: center + 3f64.ln(),
            lowest: -(100f64.ln()),
            highest: center + 100f64.ln(),
        }
    }

    /// The standard deviation of the log-parameter; none under a flat prior.
    fn prior_sd(&self, prior: HyperPrior) -> Option<f64> {
        match prior {
            HyperPrior::Flat => None,
            HyperPrior::LogNormal { scale_sd, .. } if self.is_variance => Some(2.0 * scale_sd),
            HyperPrior::LogNormal { lengthscale_sd, .. } => Some(lengthscale_sd),
        }
    }

    /// Starts at the user's value, since no spread of the data tells it.
    fn around(value: f64) -> Self {
        let (near, far) = (2f64.ln(), 1000f64.ln());
        Self {
            start: value,
            center: value,
            is_variance: false,
            low: value - near,
            high: value + near,
            lowest: value - far,
            highest: value + far,
        }
    }
}

/// ln of the variance of some values; `None` if they are all equal.
fn log_variance(values: &[f64]) -> Option<f64> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / n;
    (variance > 0.0).then(|| variance.ln())
}
