//! The covariance of all that is observed of a push, where the model is true.

use std::sync::Arc;

use effects::Effect;
use models::Description;
use nalgebra::DVector;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use serde::Serialize;

use crate::data::repeats::FEWEST_REPEATS;
use crate::noise::blocks_of_pushes::{Data, MOST_PAIRS, neighbour_pairs, repeat_groups};
use crate::predict::error_shapes::{
    ErrorShapes, Kind, SOURCES, Source, priors, push_directions, stated_sds,
};
use crate::predict::secants::Linearisation;
use crate::predict::tangent::Tangent;
use crate::statistics::blocks::Block;
use crate::statistics::quantile::NORMAL_975;
use crate::statistics::variances::{LogNormal, variances};
use crate::{DiagnosisError, FloorSource, Observations, Whitening};

/// Sources of error and their sizes: what the streams' noise leaves at the ends of steps, small
/// errors of each step's own, and parameters that differ from push to push.
///
/// The steps of one push share their errors with the shape that the effect behind them has.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NoiseModel {
    /// What it was learnt from.
    pub source: FloorSource,
    /// Groups of repeats, or pairs of neighbours, that it was learnt from.
    pub n_cells: usize,
    /// Pushes in them.
    pub n_pushes: usize,
    /// The sources of error.
    pub sources: Vec<ErrorSource>,
    /// Names of those whose size did not converge, or were likeliest beyond what their range allows: they are left
    /// out, or stay as large as is usual.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub dropped: Vec<&'static str>,
    /// Groups or pairs that say nothing, for a number of theirs has no source of error or is beyond
    /// reckoning.
    #[serde(skip_serializing_if = "is_none")]
    pub n_unused: usize,
    /// Iterations that the likelihood took.
    pub iterations: usize,
    /// Twice the gain in log likelihood that one more would have brought.
    pub decrement: f64,
}

/// A source of error with its size.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErrorSource {
    /// What it is; for a parameter that differs from push to push the effect's id.
    pub name: &'static str,
    /// SI unit of the standard deviation; `1` for a factor or a share.
    pub unit: &'static str,
    /// Whether all steps of a push share it.
    pub of_push: bool,
    /// Standard deviation.
    pub sd: f64,
    /// Lower end of its 95 % interval.
    pub low95: f64,
    /// Upper end of its 95 % interval.
    pub high95: f64,
    /// Share of the variance of a step's displacement and turn, mean over all steps; 0 before anything is
    /// learnt.
    pub share: f64,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks so")]
fn is_none(n: &usize) -> bool {
    *n == 0
}

impl NoiseModel {
    /// Learns the sizes of errors, linearised about a model; `own` are effects besides those of the
    /// catalogue.
    ///
    /// What repeats of a push have in common cancels, and with it what the model misses. Without
    /// enough repeats pushes are compared that are alike, less what any effect of the catalogue
    /// could explain of their difference: an estimate.
    ///
    /// # Errors
    /// `Model` for what the model refuses, such as a learnt one.
    pub fn learn(
        model: &Description,
        own: &[Arc<dyn Effect>],
        observations: &Observations,
    ) -> Result<Self, DiagnosisError> {
        let tangent = Tangent::of(model, own, observations)?;
        Self::learn_at(&tangent, observations, None, &Self::usual_beside(model)?)
    }

    /// The same with slopes that are known, and also from what a flexible fit leaves of pushes, if that is given;
    /// about as large as what is expected.
    pub(crate) fn learn_at(
        tangent: &Tangent,
        observations: &Observations,
        left: Option<&[(usize, DVector<f64>)]>,
        expected: &Self,
    ) -> Result<Self, DiagnosisError> {
        let shapes = &*shapes(observations, &tangent.linearisation);
        let data = Data { observations, tangent, shapes };
        let groups = repeat_groups(observations);
        let n_repeats = groups.iter().map(|group| group.len() - 1).sum::<usize>();
        let (source, groups, mut blocks) = if n_repeats >= FEWEST_REPEATS {
            let blocks: Vec<Block> = groups.iter().map(|group| data.repeats(group)).collect();
            (FloorSource::Repeats, groups, blocks)
        } else {
            let pairs = neighbour_pairs(observations);
            let blocks = pairs.iter().map(|pair| data.neighbours(pair)).collect();
            let groups = pairs.iter().map(|pair| pair.to_vec()).collect();
            (FloorSource::Neighbours, groups, blocks)
        };
        if let Some(left) = left {
            // What repeats itself says more exactly by how much it differs.
            let repeats = repeat_groups(observations);
            let is_alone = |push: usize| !repeats.iter().any(|group| group.contains(&push));
            let alone: Vec<_> = left.iter().filter(|(push, _)| is_alone(*push)).collect();
            let some = alone.iter().step_by(alone.len().div_ceil(MOST_PAIRS).max(1));
            let n_fixed = blocks.first().map_or(0, |block| block.fixed.ncols());
            blocks.extend(some.map(|(push, left)| data.left(left, (*push, n_fixed))));
        }
        // Few groups of repeats tell little of how their own slopes scatter.
        let noise = Self::likeliest(&blocks, (tangent, shapes), expected, left.is_some());
        let n_pushes = groups.iter().map(Vec::len).sum();
        Ok(Self { source, n_cells: groups.len(), n_pushes, ..noise })
    }

    /// The same from what a flexible fit leaves of each push alone, linearised at what each had itself.
    pub(crate) fn learn_of_each(
        tangent: &Tangent,
        observations: &Observations,
        left: &[(usize, DVector<f64>)],
        expected: &Self,
    ) -> Self {
        let shapes = &*shapes(observations, &tangent.linearisation);
        let data = Data { observations, tangent, shapes };
        let blocks = left.iter().map(|(push, left)| data.left(left, (*push, 0)));
        let blocks: Vec<Block> = blocks.collect();
        Self::likeliest(&blocks, (tangent, shapes), expected, true)
    }

    /// The likeliest sizes about those expected, each block a cell of one push.
    fn likeliest(
        blocks: &[Block],
        (tangent, shapes): (&Tangent, &[ErrorShapes]),
        expected: &Self,
        is_robust: bool,
    ) -> Self {
        let expected = expected.sources.iter().map(|source| source.sd);
        let found = variances(blocks, &priors(expected, &tangent.linearisation));
        let log_se = if is_robust { &found.robust_log_se } else { &found.log_se };
        let shares = shares(shapes, &found.values);
        let of = |(k, source)| {
            let source = ErrorSource::new(source, found.values[k], log_se[k]);
            ErrorSource { share: shares[k], ..source }
        };
        Self {
            source: FloorSource::Neighbours,
            n_cells: blocks.len(),
            n_pushes: blocks.len(),
            sources: SOURCES.iter().enumerate().map(of).collect(),
            dropped: found.dropped.iter().map(|k| SOURCES[*k].name).collect(),
            n_unused: found.n_unused,
            iterations: found.iterations,
            decrement: found.decrement,
        }
    }

    /// Every source as large as is usual, before anything is learnt of it.
    pub(crate) fn usual() -> Self {
        Self::usual_or([0.0; SOURCES.len()])
    }

    /// The same beside a model, which may state that parameters differ by more from push to push.
    ///
    /// # Errors
    /// `Model` if the catalogue does not know a source.
    pub(crate) fn usual_beside(model: &Description) -> Result<Self, DiagnosisError> {
        Ok(Self::usual_or(stated_sds(model)?))
    }

    /// As large as is usual, or as these standard deviations where they are larger.
    fn usual_or(stated: impl IntoIterator<Item = f64>) -> Self {
        let of = |(source, stated): (&Source, f64)| {
            let LogNormal { median, log_sd, .. } = source.prior(source.usual_sd.max(stated));
            ErrorSource::new(source, median, log_sd)
        };
        Self {
            source: FloorSource::Neighbours,
            n_cells: 0,
            n_pushes: 0,
            sources: SOURCES.iter().zip(stated).map(of).collect(),
            dropped: Vec::new(),
            n_unused: 0,
            iterations: 0,
            decrement: 0.0,
        }
    }

    /// With known standard deviations, in the order of its sources; none for another number of them.
    pub(crate) fn of_sds(sds: &[f64]) -> Option<Self> {
        let mut noise = Self::usual();
        for (source, sd) in noise.sources.iter_mut().zip(sds) {
            (source.sd, source.low95, source.high95) = (*sd, *sd, *sd);
        }
        (noise.sources.len() == sds.len()).then_some(noise)
    }

    /// The covariance of every push, linearised about a model.
    ///
    /// # Errors
    /// `Model` for what the model refuses.
    pub fn whitening(
        &self,
        model: &Description,
        own: &[Arc<dyn Effect>],
        observations: &Observations,
    ) -> Result<Whitening, DiagnosisError> {
        let directions = push_directions(model)?;
        let linearisation = Linearisation::of(model, own, observations, &directions)?;
        self.whitening_at(observations, &linearisation)
    }

    /// The same with slopes that are known: the first ones are [`push_directions`].
    pub(crate) fn whitening_at(
        &self,
        observations: &Observations,
        linearisation: &Linearisation,
    ) -> Result<Whitening, DiagnosisError> {
        let variances: Vec<f64> = self.sources.iter().map(|source| source.sd.powi(2)).collect();
        let numbers = observations.own_numbers();
        let covariance = |numbers: Vec<(usize, usize)>| {
            let shapes = ErrorShapes::of(observations, linearisation, numbers);
            let covariance = shapes.covariance(&variances);
            (shapes.numbers, covariance)
        };
        let pushes: Vec<_> = numbers.into_par_iter().map(covariance).collect();
        Ok(Whitening::new(pushes)?.about(linearisation.shift.clone()))
    }
}

impl ErrorSource {
    /// Of a variance, whose logarithm has this standard error.
    fn new(source: &Source, variance: f64, log_se: f64) -> Self {
        let Source { name, unit, kind, .. } = *source;
        let sd = variance.sqrt();
        let ratio = (0.5 * NORMAL_975 * log_se).exp();
        let of_push = matches!(kind, Kind::Push { .. });
        Self { name, unit, of_push, sd, low95: sd / ratio, high95: sd * ratio, share: 0.0 }
    }
}

/// Each source's share in the variance of a step's displacement and turn, mean over all steps.
fn shares(shapes: &[ErrorShapes], variances: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; variances.len()];
    let mut n = 0.0;
    for of_push in shapes {
        let roots = of_push.roots.iter().zip(variances);
        let own: Vec<Vec<f64>> = roots
            .map(|(root, theta)| root.squares().map(|square| theta * square).collect())
            .collect();
        let motion = of_push.numbers.iter().enumerate().filter(|(_, (_, number))| *number < 5);
        for (row, _) in motion {
            let total: f64 = own.iter().map(|squares| squares[row]).sum();
            if total > 0.0 {
                sums.iter_mut().zip(&own).for_each(|(sum, squares)| *sum += squares[row] / total);
                n += 1.0;
            }
        }
    }
    sums.into_iter().map(|sum| sum / f64::max(n, 1.0)).collect()
}

fn shapes(observations: &Observations, linearisation: &Linearisation) -> Vec<ErrorShapes> {
    let numbers = observations.own_numbers();
    let of = |numbers| ErrorShapes::of(observations, linearisation, numbers);
    numbers.into_par_iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::NoiseModel;
    use crate::synthetic::recorded;

    #[test]
    fn pushes_of_which_no_two_are_alike_keep_what_is_usual() {
        let (all, model) = recorded(11);
        let on_edge = |edge: u32| {
            let step = all.places.iter().position(|place| place.edge == edge)?;
            Some(all.pushes[all.push_of[step]].to_string())
        };
        let names: Vec<String> = (0..4).filter_map(on_edge).collect();
        let mut few = all.part(&names).unwrap();
        // A push that goes on around a vertex is on one edge here.
        for (step, push) in few.push_of.iter().enumerate() {
            few.places[step].edge = *push as u32;
        }
        let noise = NoiseModel::learn(&model, &[], &few).unwrap();
        assert_eq!((noise.n_cells, noise.dropped.len()), (0, 0));
        assert!(noise.sources.iter().all(|source| source.low95 < source.high95), "{noise:?}");
        noise.whitening(&model, &[], &few).unwrap();
    }
}
