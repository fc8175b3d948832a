//! The errors of a model on a part of a set, as sums that merge to those of the whole.

use std::collections::BTreeMap;

use effects::Channels;
use gp_core::{GpError, Mergeable};
use models::ChannelObservation;
use planar::Shape;
use serde::{Deserialize, Serialize};

use crate::compare::calibration::{Covered, IntervalCalibration, calibrations};
use crate::compare::errors::of_number;
use crate::compare::reading::Reading;
use crate::compare::residual_map::Cell;
use crate::compare::sums::Sums;
use crate::data::covariate::Bins;
use crate::{
    ChannelError, Covariate, DiagnosisError, Floor, NoiseFloor, Observations, Predictions,
};

/// What parts of a set have to share to count alike: the cells of maps, and the noise floor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ErrorGrid {
    axes: Vec<(Covariate, Bins)>,
    /// Predictions below have no sense, for each reading.
    senseless: Vec<f64>,
    floor: [Option<Floor>; 7],
}

/// Sums over the steps of a part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ErrorSums {
    n_pushes: u64,
    n_steps: u64,
    n_excluded: u64,
    /// In the order of [`Channels`].
    numbers: Vec<OfNumber>,
    /// Of each reading over each set of axes.
    maps: Vec<BTreeMap<usize, InCell>>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct OfNumber {
    errors: Sums,
    squares: Sums,
    /// What was observed where there is an error.
    observed: Sums,
    /// Steps with an interval, those within each of several, Σ NLPD and Σ CRPS.
    intervals: Vec<f64>,
}

/// Sums of a cell, and Σ of errors over the floor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct InCell(Sums, f64);

/// How wrong a model is over a whole set, and where; in SI units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErrorTable {
    /// Pushes compared.
    pub n_pushes: u64,
    /// Steps compared.
    pub n_steps: u64,
    /// Rows of the table that are not compared.
    pub n_excluded: u64,
    /// Errors of each number of a step; standard errors take whole pushes for independent.
    pub channels: Vec<ChannelError>,
    /// How honest the model's own intervals are, for each number with a variance.
    pub calibration: Vec<IntervalCalibration>,
    /// Mean residuals over covariates and pairs of them.
    pub maps: Vec<ErrorMap>,
}

/// Mean residuals of one number of a step over one or two covariates.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ErrorMap {
    /// Which number; `drift` is dy, and `turn` dtheta, in the sense that the model predicts.
    pub name: &'static str,
    /// Its SI unit.
    pub unit: &'static str,
    /// Over what.
    pub covariates: Vec<Covariate>,
    /// The cells with two pushes or more; what lies beyond the first and the last is in them.
    pub cells: Vec<Cell>,
}

impl ErrorGrid {
    /// As a sample of the set has them, with the noise floor about the model.
    ///
    /// The order of the pushes in the set, which no part knows, is no axis.
    pub fn of(observations: &Observations, predictions: &Predictions, floor: &NoiseFloor) -> Self {
        let is_axis = |known: &Covariate| *known != Covariate::Time && observations.knows(*known);
        let axis = |known: Covariate| match known {
            // A sample need not have touched them all.
            Covariate::Edge => (known, known.bins(&[last_edge(observations)])),
            _ => (known, known.bins(&observations.values_of(known))),
        };
        let varies = |(_, bins): &(Covariate, Bins)| bins.n_cells() > 1;
        let axes = Covariate::ALL.into_iter().filter(is_axis).map(axis).filter(varies).collect();
        let senseless = Reading::all().map(|reading| reading.senseless(predictions)).collect();
        Self { axes, senseless, floor: floor.numbers }
    }

    /// The axes of each map: one, or a pair that matters.
    fn sets(&self) -> Vec<Vec<usize>> {
        let place = |known| self.axes.iter().position(|(covariate, _)| *covariate == known);
        let pairs = Covariate::PAIRS.into_iter();
        let pairs = pairs.filter_map(|[a, b]| Some(vec![place(a)?, place(b)?]));
        (0..self.axes.len()).map(|axis| vec![axis]).chain(pairs).collect()
    }

    /// The index of a cell by those on each axis of a map, the last fastest.
    fn index(&self, axes: &[usize], cell: impl Fn(usize) -> usize) -> usize {
        axes.iter().fold(0, |index, axis| index * self.axes[*axis].1.n_cells() + cell(*axis))
    }

    /// The sums in the cells of each reading over each set of axes.
    fn maps(
        &self,
        residuals: &[[Option<f64>; 7]],
        observations: &Observations,
        predictions: &Predictions,
    ) -> Vec<BTreeMap<usize, InCell>> {
        let cells_of = |(covariate, bins): &(Covariate, Bins)| {
            let values = observations.values_of(*covariate);
            values.iter().map(|value| bins.cell(*value)).collect()
        };
        let cells: Vec<Vec<usize>> = self.axes.iter().map(cells_of).collect();
        let mut maps = Vec::new();
        for (reading, least) in Reading::all().zip(&self.senseless) {
            let signs = reading.signs_above(*least, predictions, observations);
            let floor = self.floor[reading.number].filter(|floor| floor.rms > 0.0);
            // Each step that counts, its value, and that over the floor.
            let value = |(step, residual): (usize, &[Option<f64>; 7])| {
                let value =
                    signs[step] * residual[reading.number].filter(|_| signs[step] != 0.0)?;
                let floor = floor.map_or(f64::INFINITY, |floor| floor.at(observations.way(step)));
                Some((step, value, value / floor))
            };
            let values: Vec<_> = residuals.iter().enumerate().filter_map(value).collect();
            for axes in self.sets() {
                let mut members: BTreeMap<usize, (Vec<(usize, f64)>, f64)> = BTreeMap::new();
                for (step, value, over_floor) in &values {
                    let cell = members.entry(self.index(&axes, |axis| cells[axis][*step]));
                    let (values, sum) = cell.or_default();
                    values.push((observations.push_of[*step], *value));
                    *sum += over_floor;
                }
                let sums = members.into_iter();
                let sums = sums.map(|(cell, (values, sum))| (cell, InCell(Sums::of(&values), sum)));
                maps.push(sums.collect());
            }
        }
        maps
    }

    fn ends(&self, axes: &[usize], mut index: usize) -> (Vec<usize>, Vec<[f64; 2]>) {
        let (mut indices, mut ends) = (Vec::new(), Vec::new());
        for axis in axes.iter().rev() {
            let bins = &self.axes[*axis].1;
            indices.insert(0, index % bins.n_cells());
            ends.insert(0, bins.ends(index % bins.n_cells()));
            index /= bins.n_cells();
        }
        (indices, ends)
    }
}

impl ErrorSums {
    /// The sums of a part.
    ///
    /// # Errors
    /// `OtherSteps` if the predictions are of other observations; `Scores` for intervals without end.
    pub fn of(
        observations: &Observations,
        predictions: &Predictions,
        grid: &ErrorGrid,
    ) -> Result<Self, DiagnosisError> {
        let residuals = predictions.residuals(observations)?;
        let number = |number: usize| OfNumber::of(&residuals, observations, number);
        let mut numbers: Vec<OfNumber> = (0..Channels::NAMES.len()).map(number).collect();
        for found in calibrations(observations, predictions)? {
            let own =
                Channels::NAMES.iter().zip(&mut numbers).filter(|(name, _)| **name == found.name);
            own.for_each(|(_, number)| number.intervals = sums_of(&found));
        }
        Ok(Self {
            n_pushes: observations.pushes.len() as u64,
            n_steps: observations.n_steps() as u64,
            n_excluded: observations.excluded.n_rows() as u64,
            numbers,
            maps: grid.maps(&residuals, observations, predictions),
        })
    }

    /// What the sums say.
    pub fn table(&self, grid: &ErrorGrid) -> ErrorTable {
        let numbers = || self.numbers.iter().enumerate().take(Channels::NAMES.len());
        let channels = numbers().filter_map(|(number, of)| of.error(number, grid.floor[number]));
        let sets = grid.sets();
        let readings =
            Reading::all().flat_map(|reading| sets.iter().map(move |axes| (reading, axes)));
        let maps = readings.zip(&self.maps).map(|((reading, axes), cells)| ErrorMap {
            name: reading.name,
            unit: reading.unit(),
            covariates: axes.iter().map(|axis| grid.axes[*axis].0).collect(),
            cells: cells
                .iter()
                .filter_map(|(index, sums)| {
                    sums.cell(grid.ends(axes, *index), grid.floor[reading.number].is_some())
                })
                .collect(),
        });
        ErrorTable {
            n_pushes: self.n_pushes,
            n_steps: self.n_steps,
            n_excluded: self.n_excluded,
            channels: channels.collect(),
            calibration: numbers().filter_map(|(number, of)| of.calibration(number)).collect(),
            maps: maps.filter(|map| !map.cells.is_empty()).collect(),
        }
    }
}

impl Mergeable for ErrorSums {
    fn merge(&mut self, other: &Self) -> Result<(), GpError> {
        let is_of_one =
            self.numbers.len() == other.numbers.len() && self.maps.len() == other.maps.len();
        if !is_of_one {
            return Err(GpError::Incompatible { what: "cells of maps" });
        }
        self.n_pushes += other.n_pushes;
        self.n_steps += other.n_steps;
        self.n_excluded += other.n_excluded;
        for (own, other) in self.numbers.iter_mut().zip(&other.numbers) {
            own.errors.add(&other.errors);
            own.squares.add(&other.squares);
            own.observed.add(&other.observed);
            if own.intervals.is_empty() {
                own.intervals.clone_from(&other.intervals);
            } else {
                own.intervals
                    .iter_mut()
                    .zip(&other.intervals)
                    .for_each(|(sum, other)| *sum += other);
            }
        }
        for (own, other) in self.maps.iter_mut().zip(&other.maps) {
            for (index, InCell(sums, over_floor)) in other {
                let cell = own.entry(*index).or_default();
                cell.0.add(sums);
                cell.1 += over_floor;
            }
        }
        Ok(())
    }
}

impl OfNumber {
    /// Without what intervals hold.
    fn of(residuals: &[[Option<f64>; 7]], observations: &Observations, number: usize) -> Self {
        let values = of_number(residuals, &observations.push_of, number);
        let squares: Vec<_> = values.iter().map(|(push, value)| (*push, value * value)).collect();
        let has = |step: &usize| residuals[*step][number].is_some();
        let observed = |step: usize| Some((step, observations.steps[step].observed[number]?));
        let observed: Vec<_> = (0..residuals.len()).filter(has).filter_map(observed).collect();
        let [errors, squares, observed] = [&values, &squares, &observed].map(|v| Sums::of(v));
        Self { errors, squares, observed, intervals: Vec::new() }
    }

    fn error(&self, number: usize, floor: Option<Floor>) -> Option<ChannelError> {
        let means = [self.errors.mean()?, self.squares.mean()?];
        let mean = self.observed.sum() / means[0].n_steps as f64;
        let spread = self.observed.mean_square() - mean * mean;
        Some(ChannelError::of(number, means, spread, floor))
    }

    fn calibration(&self, number: usize) -> Option<IntervalCalibration> {
        let (n, sums) = self.intervals.split_first()?;
        IntervalCalibration::of_sums(number, *n, sums)
    }
}

/// Index of the last edge of the outlines.
fn last_edge(observations: &Observations) -> f64 {
    let n_edges = |step: &ChannelObservation| match step.input.object.shape() {
        Shape::Polygon(polygon) => polygon.edges().count(),
        Shape::Ellipse(_) => 1,
    };
    observations.steps.iter().map(n_edges).max().unwrap_or(1) as f64 - 1.0
}

/// Steps with an interval, those within each, Σ NLPD and Σ CRPS.
fn sums_of(found: &IntervalCalibration) -> Vec<f64> {
    let n = found.n_steps as f64;
    // Shares are of whole numbers of steps.
    let within =
        found.coverage.iter().chain(&found.curve).map(|Covered { share, .. }| (share * n).round());
    std::iter::once(n).chain(within).chain([n * found.nlpd, n * found.crps]).collect()
}

impl InCell {
    /// None of fewer than two pushes.
    fn cell(
        &self,
        (indices, ranges): (Vec<usize>, Vec<[f64; 2]>),
        has_floor: bool,
    ) -> Option<Cell> {
        let mean = self.0.mean()?;
        let [low95, high95] = mean.interval();
        Some(Cell {
            ranges,
            indices,
            n_steps: self.0.n_steps(),
            n_pushes: self.0.n_pushes(),
            mean: mean.mean,
            low95,
            high95,
            rms: self.0.mean_square().sqrt(),
            over_floor: has_floor.then(|| self.1 / self.0.n_steps() as f64),
        })
    }
}

#[cfg(test)]
mod tests {
    use gp_core::Parts;

    use super::{ErrorGrid, ErrorSums};
    use crate::synthetic::made;
    use crate::{MapSettings, Observations, Predictions, compare};

    /// A part with its predictions.
    fn part(
        all: &Observations,
        predictions: &Predictions,
        k: usize,
    ) -> (Observations, Predictions) {
        let names: Vec<String> = all.pushes().iter().map(ToString::to_string).collect();
        let of = |push: usize| push % 3 == k;
        let own: Vec<String> =
            (0..names.len()).filter(|push| of(*push)).map(|push| names[push].clone()).collect();
        let steps: Vec<usize> = (0..all.n_steps()).filter(|step| of(all.push_of[*step])).collect();
        let values = steps.iter().map(|step| predictions.values[*step]).collect();
        let variances = steps.iter().map(|step| predictions.variances[*step]).collect();
        (all.part(&own).unwrap(), Predictions { values, variances })
    }

    #[test]
    fn parts_say_what_a_comparison_of_the_whole_says() {
        let (all, mut predictions, floor) = made(2, |step| 0.02 * step.p);
        predictions.variances.iter_mut().for_each(|of| of[2] = Some(1e-4));
        let whole = compare(&all, &predictions, &floor, &MapSettings::default()).unwrap();
        let grid = ErrorGrid::of(&all, &predictions, &floor);
        let sums = |order: [usize; 3]| -> ErrorSums {
            let mut parts = Parts::new(3);
            for k in order {
                let (own, predicted) = part(&all, &predictions, k);
                let sums = ErrorSums::of(&own, &predicted, &grid).unwrap();
                let text = serde_json::to_string(&sums).unwrap();
                parts.add(k as u64, serde_json::from_str(&text).unwrap()).unwrap();
            }
            parts.finish().unwrap()
        };
        let one = sums([0, 1, 2]);
        assert_eq!(one, sums([2, 0, 1]));
        let table = one.table(&grid);
        assert_eq!((table.n_pushes, table.n_steps), (1200, 4800));
        let near = |one: f64, other: f64| (one - other).abs() <= 1e-9 * one.abs().max(1e-9);
        assert_eq!(table.channels.len(), whole.channels.len());
        for (one, other) in table.channels.iter().zip(&whole.channels) {
            assert!(near(one.rms, other.rms) && near(one.bias, other.bias), "{one:?} {other:?}");
            assert!(near(one.rms_se, other.rms_se), "{one:?} {other:?}");
            assert!((one.nmse.unwrap_or(0.0) - other.nmse.unwrap_or(0.0)).abs() < 1e-6);
            assert_eq!((one.n_steps, one.floor), (other.n_steps, other.floor));
        }
        let [one, other] = [&table.calibration[0], &whole.calibration[0]];
        assert_eq!((one.coverage, &one.curve), (other.coverage, &other.curve));
        assert!(near(one.nlpd, other.nlpd) && near(one.crps, other.crps));
        let mut n_cells = 0;
        for map in &whole.maps {
            let same = |known: &&super::ErrorMap| {
                known.name == map.name && known.covariates == map.covariates
            };
            let Some(own) = table.maps.iter().find(same) else { continue };
            for cell in &map.cells {
                let own = own.cells.iter().find(|own| own.indices == cell.indices).unwrap();
                assert_eq!((own.n_steps, own.n_pushes), (cell.n_steps, cell.n_pushes));
                assert!(near(own.mean, cell.mean) && near(own.high95, cell.high95));
                assert!(near(own.over_floor.unwrap(), cell.over_floor.unwrap()));
                n_cells += 1;
            }
        }
        assert!(n_cells > 1000, "{n_cells}");
    }
}
