//! Where the optimiser starts and which parameter values it may visit, from the spread of the data.

use std::sync::Arc;

use faer::MatRef;

use crate::constraints::Constraint;
use crate::{Constraints, GpError, HyperPrior, Kernel, LowDiscrepancy, Prior, Role};

/// Standardised log-parameters: u = ln(θ/scale), with the scale of each from the data's spread.
///
/// A lengthscale or period scales with the standard deviation of its input and a variance with the
/// variance of the outputs, so u is what standardised inputs and outputs would give, and the
/// likelihood stays that of the data in the user's units.
/// The noise variance is the last parameter, but for what `with_shape` adds. A point has a coordinate
/// for every parameter, but for those that [`Constraints`] fix or tie.
pub struct SearchSpace {
    coordinates: Vec<Coordinate>,
    /// Where each parameter comes from.
    places: Vec<Place>,
    stiffness: f64,
    prior: HyperPrior,
}

/// Where a parameter comes from.
#[derive(Clone, Copy)]
enum Place {
    Fixed(f64),
    Coordinate(usize),
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
        let mut coordinates = Vec::new();
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
                Role::Odds => (0.0, Range::odds(log_value)),
            };
            coordinates.push(Coordinate::new(log_scale, range));
        }
        coordinates.push(Coordinate::new(output, Range::noise()));
        let places = (0..coordinates.len()).map(Place::Coordinate).collect();
        Self { coordinates, places, stiffness: STIFFNESS * y.len() as f64, prior }
    }

    /// The same with hyperparameters that are fixed, bounded, tied, or have priors.
    ///
    /// - `names`: of all parameters in order.
    ///
    /// # Errors
    /// What is wrong with the constraints: `UnknownParameter`, `NotPositive`, `OutOfRange`,
    /// `ShapeMismatch`, `Incompatible`.
    pub fn constrained(
        mut self,
        names: &[String],
        constraints: &Constraints,
    ) -> Result<Self, GpError> {
        let mut left = Vec::new();
        let mut places: Vec<Place> = Vec::new();
        let coordinates = self.coordinates.into_iter().zip(constraints.resolve(names)?);
        for (coordinate, constraint) in coordinates {
            places.push(match (constraint.leader, constraint.fixed) {
                (Some(leader), _) => places[leader],
                (None, Some(value)) => Place::Fixed(value),
                (None, None) => {
                    left.push(coordinate.constrained(constraint));
                    Place::Coordinate(left.len() - 1)
                }
            });
        }
        (self.coordinates, self.places) = (left, places);
        Ok(self)
    }

    /// One more parameter behind the noise variance, without unit, that starts at `value`.
    pub fn with_shape(mut self, value: f64) -> Self {
        let coordinate = Coordinate::new(0.0, Range::around(value.ln()));
        self.places.push(Place::Coordinate(self.coordinates.len()));
        self.coordinates.push(coordinate);
        self
    }

    /// The number of coordinates of a point.
    pub fn n_coordinates(&self) -> usize {
        self.coordinates.len()
    }

    /// Start number `index`: the first in the usual place, the others a low-discrepancy set.
    pub fn start(&self, index: usize, seed: u64) -> Vec<f64> {
        if index == 0 {
            return self.coordinates.iter().map(|one| one.inside(one.range.start)).collect();
        }
        let fractions = LowDiscrepancy::new(self.coordinates.len(), seed).point(index);
        let place = |(one, fraction): (&Coordinate, f64)| one.between(fraction);
        self.coordinates.iter().zip(fractions).map(place).collect()
    }

    /// The parameters θ in the user's units.
    pub fn parameters(&self, point: &[f64]) -> Vec<f64> {
        let value = |place: &Place| match *place {
            Place::Fixed(value) => Some(value),
            Place::Coordinate(c) => Some(self.coordinates[c].value(*point.get(c)?)),
        };
        self.places.iter().map_while(value).collect()
    }

    /// The standardised point of parameters θ in the user's units; of tied ones the last counts.
    pub fn point(&self, parameters: &[f64]) -> Vec<f64> {
        let mut point = vec![0.0; self.coordinates.len()];
        for (place, value) in self.places.iter().zip(parameters) {
            if let Place::Coordinate(c) = *place {
                let one = &self.coordinates[c];
                point[c] = one.inside(value.ln() - one.log_scale);
            }
        }
        point
    }

    /// From slopes by the log-parameters those by the coordinates.
    pub fn by_coordinates(&self, point: &[f64], by_parameters: &[f64], by_point: &mut [f64]) {
        by_point.fill(0.0);
        for (place, slope) in self.places.iter().zip(by_parameters) {
            if let Place::Coordinate(c) = *place {
                by_point[c] += slope * self.coordinates[c].stretch(point[c]);
            }
        }
    }

    /// The penalty of standing behind a wall, less the log priors up to their constants; its gradient
    /// is added to `gradient`. 0 between the walls under a flat prior.
    pub fn penalty(&self, point: &[f64], gradient: &mut [f64]) -> f64 {
        let mut penalty = 0.0;
        for ((&u, one), slope) in point.iter().zip(&self.coordinates).zip(gradient) {
            let (range, stretch) = (&one.range, one.stretch(u));
            let standardized = one.standardized(u);
            if one.bounds.is_none() {
                let excess = u - u.clamp(range.lowest, range.highest);
                penalty += 0.5 * self.stiffness * excess * excess;
                *slope += self.stiffness * excess;
            }
            if let (true, Some(sd)) = (one.priors.is_empty(), range.prior_sd(self.prior)) {
                let deviation = (standardized - range.center) / sd;
                penalty += 0.5 * deviation * deviation;
                *slope += deviation / sd * stretch;
            }
            for prior in &one.priors {
                let (log_density, by_log) = prior.log_density(one.value(u));
                penalty -= log_density;
                *slope -= by_log * stretch;
            }
        }
        penalty
    }

    /// Which parameters stand at a wall or behind it, or at a bound of the user's.
    pub fn at_bound(&self, point: &[f64]) -> Vec<usize> {
        let outside = |i: &usize| match self.places[*i] {
            Place::Fixed(_) => false,
            Place::Coordinate(c) => self.coordinates[c].is_at_bound(point[c]),
        };
        (0..self.places.len()).filter(outside).collect()
    }
}

/// One coordinate of a point.
struct Coordinate {
    log_scale: f64,
    range: Range,
    bounds: Option<Bounds>,
    priors: Vec<Arc<dyn Prior>>,
}

/// A range of the user's. The coordinate is then the logit of the share of the way from its lowest to
/// its highest u, so that no value of it leaves the range.
#[derive(Clone, Copy)]
struct Bounds {
    low: f64,
    high: f64,
    /// In the user's units.
    values: (f64, f64),
}

impl Coordinate {
    fn new(log_scale: f64, range: Range) -> Self {
        Self { log_scale, range, bounds: None, priors: Vec::new() }
    }

    fn constrained(mut self, constraint: Constraint) -> Self {
        self.priors = constraint.priors;
        if let Some(start) = constraint.start {
            self.range.start = start.ln() - self.log_scale;
        }
        if let Some(values) = constraint.bounds {
            let (low, high) = (values.0.ln() - self.log_scale, values.1.ln() - self.log_scale);
            // An open end is the usual wall, or as far from the other end as the walls are.
            let width = self.range.highest - self.range.lowest;
            let low = if low.is_finite() { low } else { self.range.lowest.min(high - width) };
            let high = if high.is_finite() { high } else { self.range.highest.max(low + width) };
            self.bounds = Some(Bounds { low, high, values });
            let (near, far) = (self.range.low.max(low), self.range.high.min(high));
            (self.range.low, self.range.high) = if near < far { (near, far) } else { (low, high) };
        }
        self
    }

    /// The coordinate of a standardised log-parameter, which is moved inside the bounds.
    fn inside(&self, standardized: f64) -> f64 {
        match self.bounds {
            None => standardized,
            Some(Bounds { low, high, .. }) => {
                let share = ((standardized - low) / (high - low)).clamp(NEAREST, 1.0 - NEAREST);
                (share / (1.0 - share)).ln()
            }
        }
    }

    /// A place among the starts.
    fn between(&self, fraction: f64) -> f64 {
        self.inside(self.range.low + fraction * (self.range.high - self.range.low))
    }

    fn share(u: f64) -> f64 {
        ((-u).exp() + 1.0).recip()
    }

    fn standardized(&self, u: f64) -> f64 {
        match self.bounds {
            None => u,
            Some(Bounds { low, high, .. }) => low + (high - low) * Self::share(u),
        }
    }

    fn value(&self, u: f64) -> f64 {
        let value = (self.standardized(u) + self.log_scale).exp();
        self.bounds.map_or(value, |Bounds { values, .. }| value.clamp(values.0, values.1))
    }

    /// ∂ ln θ/∂u.
    fn stretch(&self, u: f64) -> f64 {
        match self.bounds {
            None => 1.0,
            Some(Bounds { low, high, .. }) => (high - low) * Self::share(u) * Self::share(-u),
        }
    }

    fn is_at_bound(&self, u: f64) -> bool {
        match self.bounds {
            None => u <= self.range.lowest || u >= self.range.highest,
            Some(_) => Self::share(u.abs()) >= 1.0 - AT_BOUND,
        }
    }
}

/// The share of the way between bounds next to which no start is.
const NEAREST: f64 = 0.02;
/// The share of the way between bounds from which on a parameter stands at one: the slope by the
/// coordinate vanishes there before it is reached.
const AT_BOUND: f64 = 0.01;

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

    /// Odds of a correlation: start at the kernel's, starts up to 0.8, walls 2e-6 from 1.
    fn odds(start: f64) -> Self {
        let (near, far) = (9f64.ln(), 1e6_f64.ln());
        Self {
            start,
            center: 0.0,
            is_variance: false,
            low: -near,
            high: near,
            lowest: -far,
            highest: far,
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
