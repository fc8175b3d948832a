//! The lowest of several minima.

use std::ops::Range;

use nalgebra::DMatrix;

use super::descent::{Exactness, Minimum, Start};
use super::field::is_field;
use super::member::{Member, Part};
use super::problem::{Evaluation, Problem};
use super::robust::Robust;
use crate::DiagnosisError;

/// What a fit ends with: the minimum without the effects that were asked for, and with them.
pub(super) struct Found {
    pub(super) before: Minimum,
    pub(super) after: Minimum,
}

/// Rounds of weights by the typical residual, each from the minimum of the last.
const MOST_ROUNDS: usize = 6;
/// Values that are tried of what means nothing at "off", in its own.
const SCALES: [f64; 3] = [0.25, 0.5, 2.0];
/// Change of what pushes show, in standard deviations of their noise, that is seen.
const SHOWS: f64 = 1.0;
/// Change of the typical residual that changes no weight to speak of.
const SETTLED: f64 = 0.01;

impl Problem<'_> {
    /// The minimum from where the model stands, and the lower one of two: from there, and from the
    /// best typical size of each effect that was asked for, one after the other.
    ///
    /// Leaves the weights at those of the second minimum.
    ///
    /// # Errors
    /// As a descent.
    pub(super) fn search(&mut self) -> Result<Found, DiagnosisError> {
        let asked_from = |member: &Member| match member.part == Part::Asked && member.is_mixture() {
            true => member.off.clone(),
            false => member.start.clone(),
        };
        let start = self.space.place(asked_from);
        let mut without = self.clone();
        let asked =
            self.space.of_each(|member| vec![member.part == Part::Asked; member.len()], |_| false);
        without.frozen.iter_mut().zip(asked).for_each(|(frozen, asked)| *frozen |= asked);
        let before = without.settle(start, None, Exactness::Sum)?;
        self.robust = without.robust;
        let plain = self.spread(&self.switched_on(&before.at.x));
        let plain = self.limited(plain)?;
        let has_many =
            |member: &Member| member.is_moved_mixture() || is_field(member.effect.info());
        let has_many = self.space.members.iter().any(has_many);
        let exactness = if has_many { Exactness::Mixture } else { Exactness::Estimates };
        let far = self.far_start(plain.clone())?;
        let mut other = self.clone();
        let mut after = self.settle(plain.clone(), None, exactness)?;
        if far != plain {
            // A start may lead to where the mechanics refuse; the other one counts then.
            if let Ok(found) = other.settle(far, None, exactness)
                && other.robust.value(&found.at.z) < other.robust.value(&after.at.z)
            {
                (*self, after) = (other, found);
            }
        }
        while let Some(stair) = self.next_asked_stair(&after.at) {
            let mut other = self.clone();
            // Where the way from there is none, or leads no lower, what was reached counts.
            match other.settle(stair.x, None, exactness) {
                Ok(found) if other.robust.value(&found.at.z) < other.robust.value(&after.at.z) => {
                    (*self, after) = (other, found);
                }
                _ => break,
            }
        }
        let limited = self.limited(after.at.x.clone())?;
        if limited != after.at.x {
            after = self.settle(limited, None, exactness)?;
        }
        Ok(Found { before, after })
    }

    /// The place with what says where the weight rests at its start.
    fn spread(&self, x: &[f64]) -> Vec<f64> {
        let at = |(member, own): (&Member, &[f64])| match member.is_mixture() {
            true => member.place(&member.start),
            false => own.to_vec(),
        };
        self.space.shares(x).flat_map(at).collect()
    }

    /// The minimum below a place, with weights by the typical residual there.
    ///
    /// # Errors
    /// As a descent.
    pub(super) fn settle(
        &mut self,
        x: Vec<f64>,
        slopes: Option<DMatrix<f64>>,
        exactness: Exactness,
    ) -> Result<Minimum, DiagnosisError> {
        let rows = self.whitening.rows();
        let is_final = exactness == Exactness::Estimates;
        let on_the_way = if is_final { Exactness::Sum } else { exactness };
        self.space.stay_near(&x, &self.whitening.sd())?;
        let mut start = Start { at: self.stand(x)?, slopes, exactness: on_the_way };
        let mut rounds = 1;
        loop {
            self.robust = Robust::at(&rows, &start.at.z);
            start.at.value = self.robust.value(&start.at.z);
            let first = start.at.value;
            let mut found = self.descend(start)?;
            let (fall, lowest) = (first - found.at.value, found.at.value);
            found.at = self.renewed(found.at)?;
            let square = self.robust.scale().powi(2);
            let is_near = (found.at.value - lowest).abs() < on_the_way.near(fall / square) * square;
            let next = Robust::at(&rows, &found.at.z);
            start = Start { at: found.at.clone(), slopes: Some(found.whole.clone()), exactness };
            let is_settled = is_near && (next.scale() / self.robust.scale() - 1.0).abs() < SETTLED;
            // Weights that go back and forth between two minima stay as they are.
            if is_settled || rounds == MOST_ROUNDS {
                return if is_final { self.descend(start) } else { Ok(found) };
            }
            start.exactness = on_the_way;
            rounds += 1;
        }
    }

    /// The same place, with what is expected of pushes that differ as it is there.
    fn renewed(&mut self, at: Evaluation) -> Result<Evaluation, DiagnosisError> {
        match self.space.stay_near(&at.x, &self.whitening.sd())? {
            true => self.stand(at.x),
            false => Ok(at),
        }
    }

    /// The place with the switches of what was asked for set.
    pub(super) fn switched_on(&self, x: &[f64]) -> Vec<f64> {
        let on = |(member, own): (&Member, &[f64])| {
            let switches = member.switches();
            let asked = member.part == Part::Asked;
            let on = |k: usize| if asked && switches[k] { 1.0 } else { own[k] };
            (0..own.len()).map(on).collect::<Vec<_>>()
        };
        self.space.shares(x).flat_map(on).collect()
    }

    /// The numbers of each effect that was asked for, but of those with many.
    fn asked(&self) -> impl Iterator<Item = Range<usize>> {
        let is_asked = |member: &Member| {
            let has_many = member.is_mixture() || is_field(member.effect.info());
            member.part == Part::Asked && !has_many
        };
        let members = self.space.members.iter().enumerate();
        members.filter(move |(_, member)| is_asked(member)).map(|(index, member)| {
            let first = self.space.first(index);
            first..first + member.len()
        })
    }

    fn next_asked_stair(&self, from: &Evaluation) -> Option<Evaluation> {
        self.asked().find_map(|numbers| self.next_stair(from, numbers))
    }

    /// The best of the typical sizes on either side of "off", of the effect that lowers the sum most first.
    fn far_start(&self, plain: Vec<f64>) -> Result<Vec<f64>, DiagnosisError> {
        let mut best = self.stand(plain)?;
        let mut left: Vec<_> = self.asked().collect();
        while !left.is_empty() {
            let there = left.iter().map(|numbers| self.farther(best.clone(), numbers.clone()));
            let lowest = there.enumerate().min_by(|(_, a), (_, b)| a.value.total_cmp(&b.value));
            match lowest {
                Some((k, there)) if there.value < best.value => {
                    best = there;
                    left.remove(k);
                }
                _ => break,
            }
        }
        Ok(best.x)
    }

    /// The best of a place and of an effect's typical sizes to either side of it, one number at a time; with each of
    /// them what means nothing at "off", as the speed over which something fades, is tried at several values.
    pub(super) fn farther(&self, from: Evaluation, numbers: Range<usize>) -> Evaluation {
        let scales = self.space.scales(numbers.start);
        let mut best = from.clone();
        for k in numbers.filter(|k| !self.frozen[*k]) {
            for there in [-1.0, 1.0].into_iter().flat_map(|side| self.seen_sizes(&from, k, side)) {
                let others = scales.iter().filter(|scale| **scale != k && !self.frozen[**scale]);
                let scaled = others.flat_map(|&scale| {
                    SCALES.map(|factor| {
                        let (mut x, (low, high)) = (there.x.clone(), self.ranges[scale]);
                        x[scale] = (factor * x[scale]).clamp(low, high);
                        x
                    })
                });
                let scaled = scaled.filter_map(|x| self.stand(x).ok()).collect::<Vec<_>>();
                let found = std::iter::once(there).chain(scaled);
                best = found.fold(best, |best, to| if to.value < best.value { to } else { best });
            }
        }
        best
    }

    /// A typical size of a number to one side; where it shows nothing, as round corners that end before anything
    /// is read, twice and four times that, too.
    fn seen_sizes(&self, from: &Evaluation, k: usize, side: f64) -> Vec<Evaluation> {
        let (low, high) = self.ranges[k];
        // A size that the mechanics refuse is no start, and at an end of the range there is none.
        let at = |times: f64| {
            let mut x = from.x.clone();
            x[k] = (x[k] + side * times * 2.0 * self.secants[k]).clamp(low, high);
            (x[k] != from.x[k]).then(|| self.stand(x).ok()).flatten()
        };
        let n_rows = self.whitening.n_numbers();
        let is_seen = |there: &Evaluation| (&there.z - &from.z).rows(0, n_rows).norm() > SHOWS;
        match at(1.0) {
            Some(typical) if !is_seen(&typical) => {
                [2.0, 4.0].into_iter().filter_map(at).chain([typical]).collect()
            }
            typical => typical.into_iter().collect(),
        }
    }

    /// A place with a typical size of a number to either side.
    pub(super) fn typical_sizes(&self, from: &[f64], k: usize) -> [Vec<f64>; 2] {
        let (low, high) = self.ranges[k];
        [-2.0, 2.0].map(|side| {
            let mut x = from.to_vec();
            x[k] = (x[k] + side * self.secants[k]).clamp(low, high);
            x
        })
    }
}
