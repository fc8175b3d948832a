//! Where a model fails, as a few regions that hold most of its error.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::compare::structure::{Series, Structure, TestedMap};
use crate::compare::words::{place, size};
use crate::data::clusters::ClusterMean;
use crate::statistics::box_search::{CellRange, Tally, best_range, gain};
use crate::{Condition, Covariate};

/// A region in which a model misses one number of a step by about the same.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// What the model does there, with mm, degrees and N.
    pub sentence: String,
    /// Which number; `drift` is dy, and `turn` dtheta, in the sense that the model predicts.
    pub name: &'static str,
    /// Its SI unit.
    pub unit: &'static str,
    /// Where: all of them hold; none for everywhere.
    pub conditions: Vec<Condition>,
    /// The same as cells of each covariate, as in [`CovariateCells`](crate::CovariateCells), also where
    /// they are all.
    #[serde(skip)]
    pub region: Vec<(Covariate, Vec<usize>)>,
    /// Steps there.
    pub n_steps: usize,
    /// Pushes that they are of.
    pub n_pushes: usize,
    /// Mean of observed less predicted, beyond what earlier findings of the number say.
    pub mean: f64,
    /// Lower end of its 95 % interval, from whole clusters, as if the region had been chosen before.
    pub low95: f64,
    /// Upper end of its 95 % interval.
    pub high95: f64,
    /// Whether an earlier finding of the number tells a part of the miss there.
    pub is_further: bool,
    /// The mean over the noise floor; none without floor.
    pub over_floor: Option<f64>,
    /// Share of the number's mean square error, that goes when this mean is taken off.
    pub share: f64,
    /// That of the map in which it was found.
    pub p_adjusted: f64,
}

/// Most findings of one number.
const MOST: usize = 4;
/// Probability of a map from which a finding is read.
const SURE: f64 = 0.05;
/// Standard errors between a finding's mean and zero.
const FEWEST_SE: f64 = 3.0;
/// Least mean of a finding, in noise floors: what is smaller does not matter.
const LEAST_OVER_FLOOR: f64 = 0.3;
/// Least share of a number's mean square error.
const LEAST_SHARE: f64 = 0.05;
/// A region with fewer conditions is preferred if its gain is this share of the best.
const SIMPLER: f64 = 0.8;
/// How much more a gain is worth in the sense of the model.
const IN_SENSE: f64 = 1.05;
/// Gain by which one more condition has to pay.
const ONE_MORE: f64 = 1.5;

/// The findings of every number, those first that take most off its square over the floor's; of motion and
/// force before those of the gap, whose floor is so low that some hundredths of a millimeter stand out.
///
/// In turn the region whose mean takes most off the squared error is found in the maps that are
/// surer than chance, and taken off; what is left is searched again. A region over p alone that is
/// there because of one over p and β is thus told once.
pub(crate) fn findings(structure: &Structure<'_>) -> Vec<Finding> {
    let mut by_number: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (index, series) in structure.series.iter().enumerate() {
        by_number.entry(series.reading.number).or_default().push(index);
    }
    let mut found = Vec::new();
    for series in by_number.values() {
        Search::new(structure, series).run(&mut found);
    }
    let is_of_gap = |finding: &Finding| finding.name.starts_with("gap");
    found.sort_by(|a: &(f64, Finding), b| {
        is_of_gap(&a.1).cmp(&is_of_gap(&b.1)).then(b.0.total_cmp(&a.0))
    });
    found.into_iter().map(|(_, finding)| finding).collect()
}

/// The search in the residuals of one number.
struct Search<'a> {
    structure: &'a Structure<'a>,
    /// Indices of the number's readings.
    series: &'a [usize],
    /// What is left of each step in each reading, in its unit.
    left: Vec<Vec<f64>>,
    /// What earlier findings took off each step.
    is_told: Vec<bool>,
    /// Maps that led to nothing.
    is_spent: Vec<bool>,
}

/// A region in one reading.
#[derive(Clone, Debug)]
struct Region {
    /// Index of the map.
    map: usize,
    ranges: Vec<(usize, CellRange)>,
    gain: f64,
    p: f64,
}

impl<'a> Search<'a> {
    fn new(structure: &'a Structure<'a>, series: &'a [usize]) -> Self {
        Self {
            structure,
            series,
            left: series.iter().map(|index| structure.series[*index].values.clone()).collect(),
            is_told: vec![false; structure.observations.n_steps()],
            is_spent: vec![false; structure.maps.len()],
        }
    }

    fn run(mut self, found: &mut Vec<(f64, Finding)>) {
        let mut n_found = 0;
        while let Some(region) = self.best().filter(|_| n_found < MOST) {
            match self.finding(&region) {
                Some((finding, steps)) => {
                    self.take_off(&region, finding.mean, &steps);
                    found.push((region.gain, finding));
                    n_found += 1;
                }
                None => self.is_spent[region.map] = true,
            }
        }
    }

    fn white(&self, map: &TestedMap) -> Vec<f64> {
        let left = self.left_of(map.series).iter();
        left.zip(&self.structure.series[map.series].scales).map(|(x, scale)| x / scale).collect()
    }

    fn left_of(&self, series: usize) -> &[f64] {
        let place = self.series.iter().position(|known| *known == series);
        &self.left[place.unwrap_or_default()]
    }

    /// The region with the largest gain, or a simpler one that gains nearly as much.
    fn best(&self) -> Option<Region> {
        let maps = self.structure.maps.iter().enumerate();
        let own =
            maps.filter(|(index, map)| self.series.contains(&map.series) && !self.is_spent[*index]);
        let regions: Vec<Region> = own.filter_map(|(index, _)| self.region(index)).collect();
        let largest = regions.iter().map(|region| region.gain).fold(0.0, f64::max);
        let near = regions.into_iter().filter(|region| region.gain >= SIMPLER * largest);
        // Of two readings that gain alike the one in the sense of the model says it in one.
        let worth = |region: &Region| {
            let reading = &self.structure.series[self.structure.maps[region.map].series].reading;
            if reading.is_in_sense() { IN_SENSE * region.gain } else { region.gain }
        };
        let n = |region: &Region| region.ranges.len();
        let best = near.min_by(|a, b| n(a).cmp(&n(b)).then(worth(b).total_cmp(&worth(a))))?;
        Some(self.refined(best))
    }

    /// The best region of a map, if its structure is more than chance.
    fn region(&self, index: usize) -> Option<Region> {
        let (structure, map) = (self.structure, &self.structure.maps[index]);
        let white = self.white(map);
        let quantile = map.test.normal_quantile(&white, &structure.observations.cluster_of);
        let p = structure.largest.probability(quantile);
        if p > SURE {
            return None;
        }
        let n_cells = map.axes.iter().map(|axis| structure.axes[*axis].n_cells()).product();
        let mut cells: Vec<Tally> = vec![(0.0, 0.0); n_cells];
        for (cell, value) in map.test.cell_of().iter().zip(&white) {
            if let Some(cell) = cell {
                cells[*cell] = (cells[*cell].0 + 1.0, cells[*cell].1 + value);
            }
        }
        let ranges = structure.best_box(map, &cells, gain);
        let mut region = Region { map: index, ranges, gain: 0.0, p };
        region.gain = gain(self.tally(&region, &white));
        Some(region)
    }

    /// The region with one more condition, where that concentrates it.
    fn refined(&self, region: Region) -> Region {
        let (structure, map) = (self.structure, &self.structure.maps[region.map]);
        let white = self.white(map);
        let mut best = region.clone();
        for (index, axis) in structure.axes.iter().enumerate() {
            if region.ranges.iter().any(|(known, _)| *known == index) || region.ranges.is_empty() {
                continue;
            }
            let mut cells: Vec<Tally> = vec![(0.0, 0.0); axis.n_cells()];
            for step in self.steps(&region) {
                let cell = &mut cells[axis.cell_of[step]];
                *cell = (cell.0 + 1.0, cell.1 + white[step]);
            }
            let range = best_range(&cells, axis.covariate.is_periodic(), gain);
            let mut narrower = region.clone();
            narrower.ranges.push((index, range));
            narrower.gain = gain(self.tally(&narrower, &white));
            if narrower.gain > best.gain.max(ONE_MORE * region.gain) {
                best = narrower;
            }
        }
        best
    }

    /// The steps of a region that have the reading.
    fn steps(&self, region: &Region) -> Vec<usize> {
        let series = &self.structure.series[self.structure.maps[region.map].series];
        let inside = |step: &usize| {
            series.signs[*step] != 0.0 && self.structure.is_in(*step, &region.ranges)
        };
        (0..self.structure.observations.n_steps()).filter(inside).collect()
    }

    fn tally(&self, region: &Region, white: &[f64]) -> Tally {
        let steps = self.steps(region);
        (steps.len() as f64, steps.iter().map(|step| white[*step]).sum())
    }

    /// What a region says, if it is sure and large enough to matter.
    fn finding(&self, region: &Region) -> Option<(Finding, Vec<usize>)> {
        let structure = self.structure;
        let series = &structure.series[structure.maps[region.map].series];
        let left = self.left_of(structure.maps[region.map].series);
        let (steps, clusters) = (self.steps(region), &structure.observations.cluster_of);
        let of = |value: &dyn Fn(usize) -> f64| {
            let values: Vec<_> = steps.iter().map(|k| (clusters[*k], value(*k))).collect();
            ClusterMean::of(&values)
        };
        let white = of(&|k| left[k] / series.scales[k])?;
        let mean = of(&|k| left[k])?;
        let share = gained_share(series, left, &steps, mean.mean);
        let is_enough = mean.n_steps >= structure.settings.fewest_steps
            && mean.n_clusters >= structure.settings.fewest_pushes
            && mean.mean.abs() >= FEWEST_SE * mean.se
            && white.mean.abs() >= LEAST_OVER_FLOOR
            && share >= LEAST_SHARE
            && white.mean * mean.mean > 0.0;
        if !is_enough {
            return None;
        }
        let [low95, high95] = mean.interval();
        let n_told = steps.iter().filter(|step| self.is_told[**step]).count();
        let mut finding = Finding {
            sentence: String::new(),
            name: series.reading.name,
            unit: series.reading.unit(),
            conditions: structure.conditions(&region.ranges),
            region: structure.region(&region.ranges),
            n_steps: mean.n_steps,
            n_pushes: structure.observations.n_pushes_of(&steps),
            mean: mean.mean,
            low95,
            high95,
            is_further: 2 * n_told > steps.len(),
            over_floor: series.has_floor.then_some(white.mean),
            share,
            p_adjusted: region.p,
        };
        finding.sentence = sentence(&finding);
        Some((finding, steps))
    }

    /// Takes the mean off every reading of the number.
    fn take_off(&mut self, region: &Region, mean: f64, steps: &[usize]) {
        let chosen = &self.structure.series[self.structure.maps[region.map].series];
        for (left, index) in self.left.iter_mut().zip(self.series) {
            let series = &self.structure.series[*index];
            // A residual in this reading is that of the chosen one times both signs.
            steps.iter().for_each(|k| left[*k] -= series.signs[*k] * chosen.signs[*k] * mean);
        }
        steps.iter().for_each(|step| self.is_told[*step] = true);
    }
}

/// Fall of the sum of squares over the number's sum of squares.
fn gained_share(series: &Series, left: &[f64], steps: &[usize], mean: f64) -> f64 {
    let all: f64 = series.values.iter().map(|value| value * value).sum();
    let fall = |k: &usize| left[*k].powi(2) - (left[*k] - mean).powi(2);
    steps.iter().map(fall).sum::<f64>() / all
}

/// `turns 1.30° too little per step at p < 0.2 and β > 20°, on edge 3 only`.
fn sentence(finding: &Finding) -> String {
    let further = if finding.is_further { "a further " } else { "" };
    let size = format!("{further}{}", size(finding.mean.abs(), finding.unit));
    let is_more = finding.mean > 0.0;
    let pick = |observed_more: &'static str, observed_less: &'static str| {
        if is_more { observed_more } else { observed_less }
    };
    let what = match finding.name {
        "dx" => format!("moves {size} {} per step", pick("too little", "too far")),
        "dy" => format!("drifts {size} too far {} per step", pick("right", "left")),
        "drift" => format!("drifts {size} {} sideways per step", pick("too little", "too far")),
        "dtheta" => {
            let way = pick("clockwise", "counter-clockwise");
            format!("turns {size} too much {way} per step")
        }
        "turn" => format!("turns {size} {} per step", pick("too little", "too much")),
        "force_normal" => format!("pushes {size} {}", pick("too softly", "too hard")),
        "force_tangential" => {
            format!("pushes {size} too much to the {}", pick("right", "left"))
        }
        "gap_start" => format!("begins {size} too {} the pusher", pick("near", "far from")),
        _ => format!("ends {size} too {} the pusher", pick("near", "far from")),
    };
    what + &place(&finding.conditions)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_6;

    use super::{Finding, findings};
    use crate::compare::structure::Structure;
    use crate::synthetic::{Made, made};
    use crate::{Covariate, MapSettings};

    /// Findings where the model misses a number by `miss` beyond noise of 0.1 floors.
    fn found(number: usize, miss: impl Fn(&Made) -> f64) -> Vec<Finding> {
        let (observations, predictions, floor) = made(number, miss);
        let residuals = predictions.residuals(&observations).unwrap();
        let settings = MapSettings { n_flips: 499, ..MapSettings::default() };
        findings(&Structure::of(&residuals, &observations, &predictions, &floor, &settings))
    }

    fn sentences(found: &[Finding]) -> Vec<&str> {
        found.iter().map(|finding| finding.sentence.as_str()).collect()
    }

    #[test]
    fn a_corner_on_one_edge_is_told_once_with_all_that_it_needs() {
        // 1.3°, where the model turns counter-clockwise.
        let miss = |step: &Made| {
            let is_there = step.p < 0.2 && step.beta > 0.2618 && step.edge == 3;
            if is_there { 1.3_f64.to_radians() } else { 0.0 }
        };
        let found = found(2, miss);
        assert_eq!(
            sentences(&found),
            ["turns 1.3° too little per step at p < 0.2 with β > 15°, on edge 3 only"]
        );
        assert!(found[0].share > 0.9 && found[0].p_adjusted <= 0.01, "{:?}", found[0]);
        assert!(found[0].low95 < 0.0227 && 0.0227 < found[0].high95, "{:?}", found[0]);
    }

    #[test]
    fn a_turn_that_is_too_small_everywhere_is_one_fault() {
        // In the sense of the model: of one sign on one half of an edge, of the other on the other.
        let found = found(2, |step| 0.02 * step.sense);
        assert_eq!(sentences(&found), ["turns 1.1° too little per step, everywhere"]);
    }

    #[test]
    fn what_depends_on_one_covariate_is_not_told_over_two() {
        let found = found(0, |step| if step.p > 0.6 { -5e-4 } else { 0.0 });
        assert_eq!(sentences(&found), ["moves 0.50 mm too far per step at p > 0.6"]);
    }

    #[test]
    fn faults_of_both_signs_and_across_the_cut_of_the_circle_are_each_told() {
        let found = found(1, |step| {
            let behind = step.direction.abs() > 5.0 * FRAC_PI_6;
            if behind {
                4e-4
            } else if step.direction.abs() < FRAC_PI_6 {
                -4e-4
            } else {
                0.0
            }
        });
        let mut told = sentences(&found);
        told.sort_unstable();
        assert_eq!(
            told,
            [
                "drifts 0.40 mm too far left per step when pushed towards from −30 to 30°",
                "drifts 0.40 mm too far right per step when pushed towards from 150 to 210°",
            ]
        );
        assert!(found.iter().all(|one| one.conditions[0].covariate == Covariate::Direction));
    }

    #[test]
    fn neither_chance_nor_what_is_small_against_the_floor_is_told() {
        assert!(sentences(&found(2, |_| 0.0)).is_empty());
        // Sure, but a fifth of the floor.
        let small = found(0, |step| if step.p > 0.6 { 2e-5 } else { 0.0 });
        assert!(sentences(&small).is_empty(), "{:?}", sentences(&small));
    }

    #[test]
    fn forces_and_gaps_have_their_own_words() {
        let hard = found(3, |step| if step.speed > 0.05 { -0.2 } else { 0.0 });
        assert_eq!(sentences(&hard), ["pushes 0.20 N too hard at speed > 60 mm/s"]);
        let near = found(6, |_| 3e-4);
        assert_eq!(sentences(&near), ["ends 0.30 mm too near the pusher, everywhere"]);
    }
}
