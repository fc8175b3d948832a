//! What a part of a set says of a fit at a place: linearised normal equations, which merge.

use std::collections::BTreeMap;
use std::ops::Range;

use gp_core::{GpError, Mergeable};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::member::{Member, Part};
use super::problem::Problem;
use super::robust::rms_of_pushes;
use crate::DiagnosisError;

/// Gauss and Newton's equations JᵀWJ δ = JᵀWz of some pushes, with all else that a step and its errors need.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NormalEquations {
    /// What is moved.
    pub(super) numbers: Vec<Number>,
    pub(super) members: Vec<MemberAt>,
    pub(super) n_pushes: u64,
    pub(super) n_steps: u64,
    pub(super) n_residuals: u64,
    /// zᵀz of the data.
    pub(super) squares: f64,
    pub(super) data: Sum,
    /// The same in every part.
    pub(super) priors: Sum,
    /// Σ g gᵀ over pushes, g = JᵀWz of one.
    pub(super) scatter: Vec<f64>,
    /// How many pushes have a root mean square of e^(k/1000).
    typical: BTreeMap<u32, u64>,
}

/// A number that is moved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Number {
    pub(super) name: String,
    /// Its index in a place.
    pub(super) index: usize,
    pub(super) range: [f64; 2],
    pub(super) secant: f64,
    /// Of what it is part of.
    pub(super) size: f64,
}

/// An effect at the place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MemberAt {
    pub(super) effect: String,
    /// Whether a model gets its values.
    pub(super) is_written: bool,
    /// Index of its first number in a place.
    pub(super) first: usize,
    pub(super) values: Vec<f64>,
    /// Change of each value by its numbers.
    pub(super) slopes: Vec<Vec<f64>>,
}

/// F, JᵀWJ by rows, and JᵀWz.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Sum {
    pub(super) value: f64,
    pub(super) curvature: Vec<f64>,
    pub(super) pull: Vec<f64>,
}

/// Parts of a factor of e in which typical residuals are counted.
const PARTS: f64 = 1000.0;
/// Beyond e²⁰ all are counted as one.
const MOST: f64 = 20.0 * PARTS;

impl NormalEquations {
    /// The equations at a place, with slopes by secants of half-widths `widths`.
    ///
    /// # Errors
    /// What a prediction refuses.
    pub(super) fn of(problem: &Problem, x: &[f64], widths: &[f64]) -> Result<Self, DiagnosisError> {
        let Problem { space, whitening, robust, .. } = problem;
        let at = problem.stand(x.to_vec())?;
        let slopes = problem.slopes(&at, widths)?;
        let weights = robust.weights(&at.z);
        let n_data = whitening.n_numbers();
        let of_rows = |rows: Range<usize>| {
            let own = slopes.rows(rows.start, rows.len());
            let mut weighted = own.into_owned();
            for (mut row, weight) in weighted.row_iter_mut().zip(weights.iter().skip(rows.start)) {
                row *= *weight;
            }
            let pull = weighted.tr_mul(&at.z.rows(rows.start, rows.len()));
            (own.tr_mul(&weighted), pull)
        };
        let sum = |value: f64, (curvature, pull): (DMatrix<f64>, DVector<f64>)| Sum {
            value,
            curvature: curvature.as_slice().to_vec(),
            pull: pull.as_slice().to_vec(),
        };
        let strains = at.z.rows(n_data, at.z.len() - n_data);
        let rows = whitening.rows();
        let mut scatter = DMatrix::zeros(slopes.ncols(), slopes.ncols());
        for push in rows.iter().cloned() {
            let (_, pull) = of_rows(push);
            scatter.ger(1.0, &pull, &pull, 1.0);
        }
        let mut typical = BTreeMap::new();
        for rms in rms_of_pushes(&rows, &at.z) {
            *typical.entry((PARTS * rms.ln()).clamp(0.0, MOST) as u32).or_default() += 1;
        }
        let all = of_rows(0..n_data);
        Ok(Self {
            numbers: numbers(problem, x),
            members: members(problem, x),
            n_pushes: rows.len() as u64,
            n_steps: space.n_steps() as u64,
            n_residuals: n_data as u64,
            squares: at.z.rows(0, n_data).norm_squared(),
            data: sum(robust.of_pushes(&at.z).iter().sum(), all),
            priors: sum(strains.norm_squared(), of_rows(n_data..at.z.len())),
            scatter: scatter.as_slice().to_vec(),
            typical,
        })
    }

    /// The median of the pushes' root mean squares, at least 1.
    pub(super) fn scale(&self) -> f64 {
        let mut left = self.typical.values().sum::<u64>().div_ceil(2);
        for (k, n) in &self.typical {
            if *n >= left {
                return if *k == 0 { 1.0 } else { ((f64::from(*k) + 0.5) / PARTS).exp() };
            }
            left -= n;
        }
        1.0
    }

    /// Whether the sums are of as many numbers as are named.
    pub(super) fn is_sound(&self) -> bool {
        let n = self.numbers.len();
        let fits = |sum: &Sum| sum.curvature.len() == n * n && sum.pull.len() == n;
        fits(&self.data) && fits(&self.priors) && self.scatter.len() == n * n
    }
}

impl Mergeable for NormalEquations {
    fn merge(&mut self, other: &Self) -> Result<(), GpError> {
        let incompatible = |what| Err(GpError::Incompatible { what });
        let is_same =
            |(own, other): (&Number, &Number)| Number { range: own.range, ..other.clone() } == *own;
        let numbers = || self.numbers.iter().zip(&other.numbers);
        if self.numbers.len() != other.numbers.len() || !numbers().all(is_same) {
            return incompatible("numbers that are fitted (do some parts lack forces?)");
        }
        if self.members != other.members || self.priors != other.priors {
            return incompatible("what is known of the model beforehand");
        }
        if !(self.is_sound() && other.is_sound()) {
            return incompatible("sizes of sums");
        }
        for (own, other) in self.numbers.iter_mut().zip(&other.numbers) {
            let ([low, high], [least, most]) = (own.range, other.range);
            own.range = [low.max(least), high.min(most)];
        }
        self.n_pushes += other.n_pushes;
        self.n_steps += other.n_steps;
        self.n_residuals += other.n_residuals;
        self.squares += other.squares;
        self.data.value += other.data.value;
        add(&mut self.data.curvature, &other.data.curvature);
        add(&mut self.data.pull, &other.data.pull);
        add(&mut self.scatter, &other.scatter);
        for (k, n) in &other.typical {
            *self.typical.entry(*k).or_default() += n;
        }
        Ok(())
    }
}

fn add(sums: &mut [f64], others: &[f64]) {
    sums.iter_mut().zip(others).for_each(|(sum, other)| *sum += other);
}

fn numbers(problem: &Problem, x: &[f64]) -> Vec<Number> {
    let space = &problem.space;
    let name = |member: &Member| {
        let names = member.coordinates.iter().map(|c| format!("{} {}", member.id(), c.name));
        names.collect::<Vec<_>>()
    };
    let names: Vec<String> = space.members.iter().flat_map(name).collect();
    let sizes: Vec<f64> = space.shares(x).flat_map(|(member, own)| member.sizes(own)).collect();
    let number = |index: usize| {
        let (low, high) = problem.ranges[index];
        Number {
            name: names[index].clone(),
            index,
            // JSON has no infinity.
            range: [low.max(f64::MIN), high.min(f64::MAX)],
            secant: problem.secants[index],
            size: sizes[index],
        }
    };
    problem.moved().into_iter().map(number).collect()
}

fn members(problem: &Problem, x: &[f64]) -> Vec<MemberAt> {
    let mut first = 0;
    let of = |(member, own): (&Member, &[f64])| {
        let slopes = member.value_slopes(own);
        let at = MemberAt {
            effect: member.id().to_owned(),
            is_written: member.part != Part::Nuisance,
            first,
            values: member.values(own),
            slopes: slopes.row_iter().map(|row| row.iter().copied().collect()).collect(),
        };
        first += member.len();
        at
    };
    problem.space.shares(x).map(of).collect()
}
