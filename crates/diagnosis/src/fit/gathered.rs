//! What the sum of all parts says at a place: the quadratic there, and the estimates.

use effects::{Setting, by_id};
use models::{Description, Estimate, ModelEffect};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::equations::{MemberAt, NormalEquations};
use super::fitted_model::put;
use crate::DiagnosisError;
use crate::cut_offs::MODEL_TOLERANCE;

/// What the sum of all parts says at a place.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PartedFit {
    /// Whether this is the minimum.
    pub is_converged: bool,
    /// Rounds so far.
    pub rounds: usize,
    /// Squared distance to the minimum of the quadratic there, in standard errors.
    pub decrement: f64,
    /// Pushes fitted to.
    pub n_pushes: u64,
    /// Steps fitted to.
    pub n_steps: u64,
    /// Root mean square of the whitened residuals; 1 for a model that misses nothing.
    pub whitened_rms: f64,
    /// The effects of the model, with what was asked for.
    pub effects: Vec<PartedEffect>,
    /// What was left open beside them.
    pub nuisances: Vec<PartedEffect>,
}

/// An effect with its estimates.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PartedEffect {
    /// Its id.
    pub id: String,
    /// In their SI units; standard errors take whole pushes for independent.
    pub parameters: Vec<PartedEstimate>,
}

/// The estimate of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PartedEstimate {
    /// Its name.
    pub name: &'static str,
    /// Its SI unit.
    pub unit: &'static str,
    /// The estimate.
    pub value: f64,
    /// Its standard error.
    pub se: f64,
}

/// A place with its quadratic, from which a step was taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Last {
    pub(super) x: Vec<f64>,
    pub(super) value: f64,
    pub(super) moved: Vec<usize>,
    pub(super) ranges: Vec<[f64; 2]>,
    pub(super) curvature: Vec<f64>,
    pub(super) pull: Vec<f64>,
    pub(super) decrement: f64,
    /// Fall that the step should bring.
    pub(super) promise: f64,
}

impl Last {
    /// Whether it is of a place with so many numbers.
    pub(super) fn is_sound(&self, n: usize) -> bool {
        let n_moved = self.moved.len();
        self.x.len() == n
            && self.moved.iter().all(|k| *k < n)
            && [self.ranges.len(), self.pull.len()] == [n_moved; 2]
            && self.curvature.len() == n_moved * n_moved
    }
}

/// The quadratic at a place.
pub(super) struct Here {
    pub(super) last: Last,
    /// Which of the equations' numbers are not held by a bound.
    columns: Vec<usize>,
    inverse: DMatrix<f64>,
}

impl Here {
    /// - `x`: the place, and `scale`: the typical whitened residual there.
    ///
    /// # Errors
    /// `Flat`.
    pub(super) fn of(
        (x, scale): (&[f64], f64),
        sums: &NormalEquations,
    ) -> Result<Self, DiagnosisError> {
        let n = sums.numbers.len();
        let pull = |k: usize| sums.data.pull[k] + sums.priors.pull[k];
        let is_free = |k: &usize| {
            let number = &sums.numbers[*k];
            let (x, [low, high]) = (x[number.index], number.range);
            !(x <= low && pull(*k) < 0.0 || x >= high && pull(*k) > 0.0)
        };
        let columns: Vec<usize> = (0..n).filter(is_free).collect();
        let curvature = DMatrix::from_fn(columns.len(), columns.len(), |i, j| {
            let at = columns[j] * n + columns[i];
            sums.data.curvature[at] + sums.priors.curvature[at]
        });
        let pull = DVector::from_iterator(columns.len(), columns.iter().map(|k| pull(*k)));
        let factor = curvature.clone().cholesky().ok_or(DiagnosisError::Flat)?;
        let decrement = pull.dot(&factor.solve(&pull)) / scale.powi(2);
        let last = Last {
            x: x.to_vec(),
            value: sums.data.value + sums.priors.value,
            moved: columns.iter().map(|k| sums.numbers[*k].index).collect(),
            ranges: columns.iter().map(|k| sums.numbers[*k].range).collect(),
            curvature: curvature.as_slice().to_vec(),
            pull: pull.as_slice().to_vec(),
            decrement,
            promise: 0.0,
        };
        Ok(Self { last, columns, inverse: factor.inverse() })
    }

    /// The estimates with the scatter of whole pushes.
    ///
    /// # Errors
    /// `Model` for an effect that is not known.
    pub(super) fn estimates(
        &self,
        scale: f64,
        sums: &NormalEquations,
        (is_converged, rounds): (bool, usize),
    ) -> Result<PartedFit, DiagnosisError> {
        let covariance = self.covariance(scale, sums);
        let effect = |member: &&MemberAt| {
            let about = by_id(&member.effect).map_err(models::ModelError::from)?.info();
            let columns: Vec<(usize, usize)> = self
                .columns
                .iter()
                .enumerate()
                .filter_map(|(at, k)| {
                    let own = sums.numbers[*k].index.checked_sub(member.first)?;
                    member.slopes.first().is_some_and(|row| own < row.len()).then_some((at, own))
                })
                .collect();
            let estimate = |(k, parameter): (usize, &effects::Parameter)| {
                let (value, slopes) = (member.values.get(k)?, member.slopes.get(k)?);
                let variance: f64 = columns
                    .iter()
                    .flat_map(|(i, a)| {
                        let covariance = &covariance;
                        let slope = |k: &usize| slopes.get(*k).copied().unwrap_or_default();
                        let of_pair = move |(j, b): &(usize, usize)| {
                            slope(a) * covariance[(*i, *j)] * slope(b)
                        };
                        columns.iter().map(of_pair)
                    })
                    .sum();
                let (name, unit) = (parameter.name, parameter.unit);
                Some(PartedEstimate { name, unit, value: *value, se: variance.max(0.0).sqrt() })
            };
            let parameters = about.parameters.iter().enumerate().filter_map(estimate).collect();
            Ok(PartedEffect { id: member.effect.clone(), parameters })
        };
        let of = |is_written: bool| -> Result<Vec<_>, DiagnosisError> {
            let members = sums.members.iter().filter(|member| member.is_written == is_written);
            members.collect::<Vec<_>>().iter().map(effect).collect()
        };
        Ok(PartedFit {
            is_converged,
            rounds,
            decrement: self.last.decrement,
            n_pushes: sums.n_pushes,
            n_steps: sums.n_steps,
            whitened_rms: (sums.squares / sums.n_residuals.max(1) as f64).sqrt(),
            effects: of(true)?,
            nuisances: of(false)?,
        })
    }

    /// G/(G−1) A⁻¹ Σggᵀ A⁻¹ + A⁻¹PA⁻¹, with 1 % of each size: the sandwich of a fit to a whole set, where each push
    /// has little leverage.
    fn covariance(&self, scale: f64, sums: &NormalEquations) -> DMatrix<f64> {
        let n = sums.numbers.len();
        let n_pushes = sums.n_pushes as f64;
        let share = n_pushes / (n_pushes - 1.0).max(1.0);
        let middle = DMatrix::from_fn(self.columns.len(), self.columns.len(), |i, j| {
            let at = self.columns[j] * n + self.columns[i];
            share * sums.scatter[at] + sums.priors.curvature[at]
        });
        let mut covariance = &self.inverse * middle * &self.inverse;
        covariance += self.last.decrement * scale.powi(2) * &self.inverse;
        for (i, k) in self.columns.iter().enumerate() {
            covariance[(i, i)] += (MODEL_TOLERANCE * sums.numbers[*k].size).powi(2);
        }
        covariance
    }
}

impl PartedFit {
    /// A model with the estimates of its effects.
    ///
    /// # Errors
    /// `Model` for values that it cannot have.
    pub fn description(
        &self,
        model: &Description,
        set: &str,
    ) -> Result<Description, DiagnosisError> {
        let mut model = model.clone();
        let (pushes, steps) = (self.n_pushes, self.n_steps);
        let source = format!("fit in parts to {pushes} pushes ({steps} steps) of {set}");
        for PartedEffect { id, parameters } in &self.effects {
            let about = by_id(id).map_err(models::ModelError::from)?.info();
            let values: Vec<f64> = parameters.iter().map(|estimate| estimate.value).collect();
            let mut effect = ModelEffect::from(Setting::new(about, &values));
            for PartedEstimate { name, value, se, .. } in parameters {
                let estimate = Estimate { value: *value, se: *se, source: source.clone() };
                effect.parameters.insert((*name).to_owned(), estimate);
            }
            put(&mut model, effect)?;
        }
        Ok(model)
    }
}
