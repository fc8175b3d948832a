//! What pushes tell of the noise: how repeats and neighbours differ, and what a fit leaves of others.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use crate::data::repeats::cells;
use crate::noise::noise_floor::{distance, features};
use crate::predict::error_shapes::{ErrorShapes, SOURCES};
use crate::predict::tangent::Tangent;
use crate::statistics::blocks::Block;
use crate::{Observations, RepeatTolerance};

/// Closer than for a floor: what a model misses must cancel, and it may be large.
const REPEATS: RepeatTolerance = RepeatTolerance { distance: 1e-3, angle: 0.02, speed: 0.05 };
/// Pairs of neighbours, and pushes without their like, that are used at most.
pub(super) const MOST_PAIRS: usize = 60;

/// Pushes that repeat each other, each group of two or more.
pub(super) fn repeat_groups(observations: &Observations) -> Vec<Vec<usize>> {
    let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (push, cell) in cells(observations, &REPEATS).into_iter().enumerate() {
        groups.entry(cell).or_default().push(push);
    }
    groups.into_values().filter(|group| group.len() > 1).collect()
}

/// Disjoint pairs of pushes that are alike, the nearest first.
pub(super) fn neighbour_pairs(observations: &Observations) -> Vec<[usize; 2]> {
    let first = observations.first_steps();
    let features: Vec<_> = first.iter().map(|step| features(observations, *step)).collect();
    let mut pairs = Vec::new();
    for a in 0..first.len() {
        for b in 0..a {
            let [one, other] = [a, b].map(|push| &observations.places[first[push]]);
            if one.edge == other.edge {
                pairs.push((distance(&features[a], &features[b]), [b, a]));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut is_taken = vec![false; first.len()];
    let mut chosen = Vec::new();
    for (_, pair) in pairs {
        if chosen.len() < MOST_PAIRS && pair.iter().all(|push| !is_taken[*push]) {
            pair.iter().for_each(|push| is_taken[*push] = true);
            chosen.push(pair);
        }
    }
    chosen
}

/// What blocks are made of.
pub(super) struct Data<'a> {
    pub(super) observations: &'a Observations,
    pub(super) tangent: &'a Tangent,
    pub(super) shapes: &'a [ErrorShapes],
}

impl Data<'_> {
    /// Contrasts of pushes that repeat each other.
    pub(super) fn repeats(&self, group: &[usize]) -> Block {
        let (members, residuals) = self.aligned(group);
        let n = residuals.ncols();
        // Helmert's contrasts: independent, and free of what all have in common.
        let contrasts = DMatrix::from_fn(n, n - 1, |row, k| {
            let scale = (((k + 1) * (k + 2)) as f64).sqrt();
            if row <= k {
                1.0 / scale
            } else if row == k + 1 {
                -((k + 1) as f64) / scale
            } else {
                0.0
            }
        });
        let vectors = residuals * contrasts;
        let fixed = DMatrix::zeros(vectors.nrows(), 0);
        Block { shapes: mean_shapes(&members), vectors, fixed }
    }

    /// The difference of two pushes that are alike, with what effects could explain of it.
    pub(super) fn neighbours(&self, pair: &[usize; 2]) -> Block {
        let prior_sd = &self.tangent.candidates.prior_sd;
        let (members, residuals) = self.aligned(pair);
        let root_half = 0.5_f64.sqrt();
        let vectors = root_half * (residuals.column(0) - residuals.column(1));
        let fixed = DMatrix::from_fn(vectors.nrows(), prior_sd.len(), |row, k| {
            let of = |member: &ErrorShapes| {
                let (step, number) = member.numbers[row];
                self.tangent.slopes(k)[step][number]
            };
            root_half * prior_sd[k] * (of(&members[0]) - of(&members[1]))
        });
        let vectors = DMatrix::from_column_slice(vectors.nrows(), 1, vectors.as_slice());
        Block { shapes: mean_shapes(&members), vectors, fixed }
    }

    /// What a flexible fit leaves of a push, beside so many columns of other blocks.
    pub(super) fn left(&self, left: &DVector<f64>, (push, n_fixed): (usize, usize)) -> Block {
        Block {
            shapes: mean_shapes(std::slice::from_ref(&self.shapes[push])),
            vectors: DMatrix::from_column_slice(left.len(), 1, left.as_slice()),
            fixed: DMatrix::zeros(left.len(), n_fixed),
        }
    }

    /// The numbers that all members have, by step of the push, and observed less predicted: a
    /// column each.
    fn aligned(&self, members: &[usize]) -> (Vec<ErrorShapes>, DMatrix<f64>) {
        let key = |&(step, number): &(usize, usize)| (self.observations.places[step].step, number);
        let mut rows: BTreeMap<(u32, usize), Vec<usize>> = BTreeMap::new();
        for (place, member) in members.iter().enumerate() {
            for (row, number) in self.shapes[*member].numbers.iter().enumerate() {
                let known = rows.entry(key(number)).or_default();
                if known.len() == place {
                    known.push(row);
                }
            }
        }
        rows.retain(|_, rows| rows.len() == members.len());
        let shapes = members.iter().enumerate().map(|(place, member)| {
            let rows: Vec<usize> = rows.values().map(|rows| rows[place]).collect();
            self.shapes[*member].rows(&rows)
        });
        let shapes: Vec<ErrorShapes> = shapes.collect();
        let residual = |row: usize, place: usize| {
            let (step, number) = shapes[place].numbers[row];
            let observed = self.observations.steps[step].observed[number].unwrap_or_default();
            observed - self.tangent.linearisation.predicted[step][number]
        };
        let residuals = DMatrix::from_fn(rows.len(), members.len(), residual);
        (shapes, residuals)
    }
}

/// Kₖ, the mean over members of a group.
fn mean_shapes(members: &[ErrorShapes]) -> Vec<DMatrix<f64>> {
    let share = 1.0 / members.len() as f64;
    let shape = |k: usize| {
        let n = members[0].numbers.len();
        let mut sum = DMatrix::zeros(n, n);
        members.iter().for_each(|member| member.roots[k].add_to(&mut sum, share));
        sum
    };
    (0..SOURCES.len()).into_par_iter().map(shape).collect()
}
