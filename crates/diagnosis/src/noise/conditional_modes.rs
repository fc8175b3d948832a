//! A model linearised where each push is likeliest: at its own values of what differs from push to push.

use std::sync::Arc;

use effects::{Effect, PushPhysics};
use models::{ChannelModel, Description};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use crate::predict::error_shapes::{ErrorShapes, Kind, Root, SOURCES, push_directions};
use crate::predict::secants::{Direction, Linearisation, moved};
use crate::predict::tangent::Tangent;
use crate::{DiagnosisError, NoiseModel, Observations};

/// The likeliest values of each push, given what it shows and the noise (conditional modes), with the model
/// linearised there.
///
/// A tip that holds where friction is a little larger, and slides where it is less, has no slope that is right for
/// all pushes. About its own values each is nearly straight, however widely they scatter.
///
/// # Source
/// Lindstrom & Bates (1990), Nonlinear mixed effects models for repeated measures data, Biometrics 46(3).
pub(crate) struct ConditionalModes<'a> {
    observations: &'a Observations,
    /// What differs, in the order of a tangent's first slopes.
    directions: Vec<Direction>,
    pushes: Vec<Push>,
    /// The predictions are those of the model as far as they are straight from each push's own values on.
    tangent: Tangent,
}

struct Push {
    /// What is observed, as (step, number).
    numbers: Vec<(usize, usize)>,
    /// A value for each.
    observed: Vec<f64>,
    /// The model of a push in the middle of all.
    physics: PushPhysics,
    /// How far off along each direction it is likeliest.
    values: Vec<f64>,
}

/// A push moved to where it is likelier.
struct Moved {
    values: Vec<f64>,
    physics: PushPhysics,
    /// As long as what the push leaves open.
    secants: Vec<Direction>,
}

/// Shares of the way to where a push is likeliest that are tried one after the other: it is not straight.
const TRIED: [f64; 3] = [1.0, 0.5, 0.25];
/// Changes of each value alone that are tried, in its standard deviation, where a push is unlikely.
const LEAPS: [f64; 4] = [-2.0, -1.0, 1.0, 2.0];
/// Standard deviations beyond the mean of its misfit from which a push is unlikely.
const UNLIKELY: f64 = 4.0;
/// Least length of a secant, as a share of that for what is usual: beyond rounding.
const SHORTEST: f64 = 1e-2;
/// Share of a variance that a push leaves open at least: beyond rounding.
const LEAST_OPEN: f64 = 1e-4;

impl<'a> ConditionalModes<'a> {
    /// All at the values of the model.
    ///
    /// # Errors
    /// `Model` for what the model refuses.
    pub(crate) fn at_the_model(
        tangent: Tangent,
        (model, own, observations): (&Description, &[Arc<dyn Effect>], &'a Observations),
    ) -> Result<Self, DiagnosisError> {
        let directions = push_directions(model)?;
        let middle = vec![0.0; directions.len()];
        let model = ChannelModel::new(model, observations.support, own)?;
        let first = observations.first_steps();
        let push = |(push, numbers): (usize, Vec<(usize, usize)>)| {
            let physics = model.physics(&observations.steps[first[push]].input.object)?;
            let physics = physics.of_typical_push().unwrap_or(physics);
            let value = |(step, number): (usize, usize)| {
                observations.steps[step].observed[number].map(|value| ((step, number), value))
            };
            let (numbers, observed) = numbers.into_iter().filter_map(value).unzip();
            Ok(Push { numbers, observed, physics, values: middle.clone() })
        };
        let pushes = observations.own_numbers().into_iter().enumerate().map(push);
        let pushes = pushes.collect::<Result<_, DiagnosisError>>()?;
        Ok(Self { observations, directions, pushes, tangent })
    }

    /// The model linearised there.
    pub(crate) fn tangent(&self) -> &Tangent {
        &self.tangent
    }

    /// Goes to where pushes are likeliest under a noise, as far as they are the likelier there indeed.
    ///
    /// # Errors
    /// `Model` for what the mechanics refuse there.
    pub(crate) fn approach(&mut self, noise: &NoiseModel) -> Result<(), DiagnosisError> {
        let variances: Vec<f64> = noise.sources.iter().map(|source| source.sd.powi(2)).collect();
        let moved = |push: &Push| self.moved(push, &variances);
        let moved: Vec<Moved> = self.pushes.par_iter().map(moved).collect();
        let mut models = Vec::with_capacity(self.pushes.len());
        for (push, Moved { values, physics, secants }) in self.pushes.iter_mut().zip(moved) {
            push.values = values;
            models.push((physics, secants));
        }
        let there = Linearisation::of_each(models, self.observations)?;
        let n_directions = there.slopes.len();
        let linearisation = &mut self.tangent.linearisation;
        for (step, push) in self.observations.push_of.iter().enumerate() {
            let values = &self.pushes[*push].values;
            linearisation.predicted[step] = std::array::from_fn(|number| {
                let own = |(slopes, value): (&Vec<[f64; 7]>, &f64)| slopes[step][number] * value;
                there.predicted[step][number]
                    - there.slopes.iter().zip(values).map(own).sum::<f64>()
            });
        }
        let bends = linearisation.bends.iter_mut().take(n_directions).flatten();
        bends.for_each(|bend| *bend = [0.0; 7]);
        linearisation.slopes.splice(..n_directions, there.slopes);
        linearisation.by_pusher = there.by_pusher;
        Ok(())
    }

    fn moved(&self, push: &Push, variances: &[f64]) -> Moved {
        let linearisation = &self.tangent.linearisation;
        let shapes = ErrorShapes::of(self.observations, linearisation, push.numbers.clone());
        let predicted: Vec<[f64; 7]> =
            push.steps().map(|step| linearisation.predicted[step]).collect();
        let (likeliest, open) = likeliest(&shapes, &push.residual(&predicted), variances);
        let trial = Trial::of(push, self, (&shapes, variances));
        let (values, physics) = trial.likelier(&likeliest);
        let secants = self.directions.iter().zip(open).map(|(direction, sd)| Direction {
            size: f64::max(sd, SHORTEST * direction.size),
            ..direction.clone()
        });
        Moved { values, physics, secants: secants.collect() }
    }
}

impl Push {
    /// The steps of which something is observed.
    fn steps(&self) -> impl Iterator<Item = usize> {
        self.numbers.chunk_by(|a, b| a.0 == b.0).map(|of_step| of_step[0].0)
    }

    /// Observed less predicted, which is for each of its steps.
    fn residual(&self, predicted: &[[f64; 7]]) -> DVector<f64> {
        let of_steps = self.numbers.chunk_by(|a, b| a.0 == b.0).zip(predicted);
        let predicted =
            of_steps.flat_map(|(of_step, predicted)| of_step.iter().map(|(_, k)| predicted[*k]));
        let missed = self.observed.iter().zip(predicted).map(|(observed, at)| observed - at);
        DVector::from_iterator(self.numbers.len(), missed)
    }
}

/// A push with other values.
struct Trial<'a> {
    push: &'a Push,
    modes: &'a ConditionalModes<'a>,
    /// The covariance of what each step has of its own; none where that is none.
    factor: Option<Cholesky<f64, Dyn>>,
    /// Of what differs from push to push, of each value.
    variances: Vec<f64>,
}

/// Values that were tried.
struct Tried {
    /// Twice the negative log density of what is observed and of the values, but for what depends on neither.
    misfit: f64,
    values: Vec<f64>,
    physics: PushPhysics,
}

impl<'a> Trial<'a> {
    fn of(
        push: &'a Push,
        modes: &'a ConditionalModes<'a>,
        (shapes, variances): (&ErrorShapes, &[f64]),
    ) -> Self {
        let n = shapes.numbers.len();
        let mut covariance = DMatrix::zeros(n, n);
        for ((source, root), variance) in SOURCES.iter().zip(&shapes.roots).zip(variances) {
            if !matches!(source.kind, Kind::Push { .. }) {
                root.add_to(&mut covariance, *variance);
            }
        }
        let variances = slopes_of_push(shapes, variances).map(|(_, variance)| variance).collect();
        Self { push, modes, factor: covariance.cholesky(), variances }
    }

    /// Values on the way from the push's own to others that are likelier, or its own.
    fn likelier(&self, others: &[f64]) -> (Vec<f64>, PushPhysics) {
        let own = &self.push.values;
        let on_the_way = |share: f64| -> Vec<f64> {
            own.iter().zip(others).map(|(own, other)| own + share * (other - own)).collect()
        };
        let here = self.at(own.clone());
        let most = here.as_ref().map_or(f64::INFINITY, |here| here.misfit);
        let mut nearer = TRIED.iter().filter_map(|share| self.at(on_the_way(*share)));
        let mut found = nearer.find(|there| there.misfit <= most).or(here);
        let n = self.push.numbers.len() as f64;
        let likely = n + UNLIKELY * (2.0 * n).sqrt();
        if found.as_ref().is_none_or(|found| found.misfit > likely) {
            // A tip that holds tells nothing of a friction that is a little less, and all of one at which it slides.
            let from = found.as_ref().map_or(own, |found| &found.values).clone();
            let leaps = self.leaps(from).filter_map(|values| self.at(values));
            found = found.into_iter().chain(leaps).min_by(|a, b| a.misfit.total_cmp(&b.misfit));
        }
        match found {
            Some(found) => (found.values, found.physics),
            None => (vec![0.0; own.len()], self.push.physics.clone()),
        }
    }

    /// The values with one of them changed by a standard deviation or two.
    fn leaps(&self, from: Vec<f64>) -> impl Iterator<Item = Vec<f64>> {
        let of_each = self.variances.iter().enumerate();
        of_each.flat_map(move |(k, variance)| {
            let from = from.clone();
            LEAPS.into_iter().map(move |leap| {
                let mut values = from.clone();
                values[k] += leap * variance.sqrt();
                values
            })
        })
    }

    /// None of values at which the mechanics refuse a step.
    fn at(&self, values: Vec<f64>) -> Option<Tried> {
        let Self { push, modes, .. } = self;
        let input = |step: usize| &modes.observations.steps[step].input;
        let along = modes.directions.iter().zip(values.iter().copied());
        let physics = moved(push.physics.clone(), along, input(push.steps().next()?)).ok()?;
        let predict = |step: usize| Some(physics.predict(input(step)).ok()?.to_array());
        let predicted: Vec<[f64; 7]> = push.steps().map(predict).collect::<Option<_>>()?;
        let residual = push.residual(&predicted);
        let square = residual.dot(&self.factor.as_ref()?.solve(&residual));
        let own = values.iter().zip(&self.variances).filter(|(value, _)| **value != 0.0);
        let own: f64 = own.map(|(value, variance)| value * value / variance).sum();
        Some(Tried { misfit: square + own, values, physics })
    }
}

/// The best linear predictions of what differs, and the standard deviations of what they leave open.
fn likeliest(
    shapes: &ErrorShapes,
    residual: &DVector<f64>,
    variances: &[f64],
) -> (Vec<f64>, Vec<f64>) {
    let factor = shapes.covariance(variances).cholesky();
    let of = |(slope, variance): (DVector<f64>, f64)| match &factor {
        Some(factor) => {
            let pull = factor.solve(&slope);
            let open = 1.0 - variance * slope.dot(&pull);
            (variance * pull.dot(residual), (variance * open.max(LEAST_OPEN)).sqrt())
        }
        None => (0.0, variance.sqrt()),
    };
    slopes_of_push(shapes, variances).map(of).unzip()
}

/// The slope by each coordinate that differs, and its variance.
fn slopes_of_push<'a>(
    shapes: &'a ErrorShapes,
    variances: &'a [f64],
) -> impl Iterator<Item = (DVector<f64>, f64)> + 'a {
    let of_source = |((source, root), variance): ((_, &'a Root), &'a f64)| {
        let (Kind::Push { .. }, Root::Columns(columns)) = (source, root) else { return Vec::new() };
        // Each beside its bend.
        columns.column_iter().step_by(2).map(|slope| (slope.into_owned(), *variance)).collect()
    };
    let kinds = SOURCES.iter().map(|source| source.kind);
    kinds.zip(&shapes.roots).zip(variances).flat_map(of_source)
}
