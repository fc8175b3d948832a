//! Several Gaussians: what one becomes where a motion has several ways to go.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use rand::{Rng, RngExt};

use crate::weights::Weights;
use crate::{FilterError, Gaussian, Rule};

/// Gaussians with weights that sum to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Mixture {
    components: Vec<(Gaussian, f64)>,
}

impl Mixture {
    /// A mixture of weighted Gaussians; the weights are scaled to sum to 1.
    ///
    /// # Errors
    /// `Empty`; `OutOfRange` for a weight that is not positive and finite; `ShapeMismatch` for
    /// components of different dimension.
    pub fn new(components: Vec<(Gaussian, f64)>) -> Result<Self, FilterError> {
        let is_wrong = |weight: &f64| !(*weight > 0.0 && weight.is_finite());
        if let Some((_, value)) = components.iter().find(|(_, weight)| is_wrong(weight)) {
            let (name, expected) = ("weight of a component", "positive and finite");
            return Err(FilterError::OutOfRange { name, expected, value: *value });
        }
        Gaussian::of_mixture(&components)?;
        let total: f64 = components.iter().map(|(_, weight)| weight).sum();
        let scaled = components.into_iter().map(|(part, weight)| (part, weight / total));
        Ok(Self { components: scaled.collect() })
    }

    /// The components with their weights.
    #[must_use]
    pub fn components(&self) -> &[(Gaussian, f64)] {
        &self.components
    }

    /// The one Gaussian of the same mean and covariance.
    ///
    /// # Errors
    /// `NotPositiveSemiDefinite` if rounding left no covariance.
    pub fn moments(&self) -> Result<Gaussian, FilterError> {
        Gaussian::of_mixture(&self.components)
    }

    /// A draw.
    pub fn sample(&self, random: &mut dyn Rng) -> DVector<f64> {
        let mut left: f64 = random.random();
        let reached = self.components.iter().find(|(_, weight)| {
            left -= weight;
            left < 0.0
        });
        reached.unwrap_or(&self.components[self.components.len() - 1]).0.sample(random)
    }

    /// The log density, in nats.
    ///
    /// # Errors
    /// As [`Gaussian::log_density`] of the components.
    pub fn log_density(&self, at: &DVector<f64>) -> Result<f64, FilterError> {
        let part = |(part, weight): &(Gaussian, f64)| Ok(part.log_density(at)? + weight.ln());
        let logs = self.components.iter().map(part).collect::<Result<Vec<f64>, FilterError>>()?;
        Ok(Weights::from_logs(logs).map_or(f64::NEG_INFINITY, |(_, log_sum)| log_sum))
    }

    /// What a motion makes of the mixture, where each state goes one or several ways: `motion`
    /// numbers the ways (as sticking or sliding), with the probability and the Gaussian of each. Each
    /// component splits into one for each way that its points go.
    ///
    /// # Errors
    /// What `motion` says; `ShapeMismatch` if its Gaussians differ in dimension.
    pub fn propagated<E: From<FilterError>>(
        &self,
        rule: &dyn Rule,
        motion: impl Fn(&DVector<f64>) -> Result<Vec<(usize, f64, Gaussian)>, E>,
    ) -> Result<Self, E> {
        let mut components = Vec::new();
        for (component, share) in &self.components {
            let mut ways: BTreeMap<usize, Vec<(Gaussian, f64)>> = BTreeMap::new();
            for (point, weight) in component.points(rule) {
                if weight > 0.0 {
                    for (way, probability, moved) in motion(&point)? {
                        ways.entry(way).or_default().push((moved, weight * probability));
                    }
                }
            }
            for parts in ways.values() {
                let weight: f64 = parts.iter().map(|(_, weight)| weight).sum();
                if weight > 0.0 {
                    components.push((Gaussian::of_mixture(parts)?, share * weight));
                }
            }
        }
        Ok(Self::new(components)?)
    }

    /// At most `n` components: the two whose union is nearest to one Gaussian are joined first.
    ///
    /// # Errors
    /// `Empty` for no components at all; `NotPositiveSemiDefinite` if rounding left no covariance.
    ///
    /// # Source
    /// Runnalls (2007), Kullback-Leibler approach to Gaussian mixture reduction, IEEE Trans.
    /// Aerospace and Electronic Systems 43(3).
    pub fn reduced(&self, n: usize) -> Result<Self, FilterError> {
        if n == 0 {
            return Err(FilterError::Empty { what: "components asked for" });
        }
        let mut parts = self.components.clone();
        while parts.len() > n {
            let pairs = (0..parts.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
            let cost = |(i, j): (usize, usize)| {
                let joined = Gaussian::of_mixture(&[parts[i].clone(), parts[j].clone()])?;
                Ok((join_cost(&parts[i], &parts[j], &joined), i, j, joined))
            };
            let costs = pairs.map(cost).collect::<Result<Vec<_>, FilterError>>()?;
            let best = costs.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
            let Some((_, i, j, joined)) = best else { break };
            let weight = parts[i].1 + parts[j].1;
            parts.remove(i);
            parts[j] = (joined, weight);
        }
        Self::new(parts)
    }
}

/// Runnalls' bound on the divergence that a join costs, in units of the joined Gaussian's standard
/// deviations, of which a thousandth is added to all: what has no variance has no divergence either.
fn join_cost(a: &(Gaussian, f64), b: &(Gaussian, f64), joined: &Gaussian) -> f64 {
    let n = joined.mean().len();
    let sd = joined.covariance().diagonal().map(f64::sqrt);
    let unit = |i: usize| if sd[i] > 0.0 { sd[i] } else { 1.0 };
    let size = |part: &Gaussian| {
        let scaled = DMatrix::from_fn(n, n, |i, j| {
            let floor = if i == j { 1e-6 } else { 0.0 };
            part.covariance()[(i, j)] / (unit(i) * unit(j)) + floor
        });
        scaled.determinant().max(f64::MIN_POSITIVE).ln()
    };
    0.5 * ((a.1 + b.1) * size(joined) - a.1 * size(&a.0) - b.1 * size(&b.0))
}
