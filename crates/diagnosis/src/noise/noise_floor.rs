//! How wrong a model may be at best.

use std::collections::{BTreeMap, BTreeSet};

use planar::wrap_angle;
use serde::{Deserialize, Serialize};

use crate::data::repeats::{FEWEST_REPEATS, cells};
use crate::noise::floor_growth::{Deviation, Growth};
use crate::statistics::quantile::{NORMAL_975, chi_square_per_freedom};
use crate::{DiagnosisError, Observations, Predictions, RepeatTolerance};

/// The least error that a model can have, for each number of a step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NoiseFloor {
    /// What it was learnt from.
    pub source: FloorSource,
    /// Pushes that are repeats of another one.
    pub n_repeats: usize,
    /// Groups of repeats.
    pub n_cells: usize,
    /// Names of the numbers whose floor is what sources of error predict of all steps, for repeats at few
    /// places scatter less.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub widened: Vec<&'static str>,
    /// In the order of [`effects::Channels`].
    pub numbers: [Option<Floor>; 7],
}

/// What a noise floor was learnt from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FloorSource {
    /// Repeated pushes.
    Repeats,
    /// Nearest neighbours among steps of different pushes: an estimate.
    Neighbours,
}

/// The standard deviation of one number about what any model could predict, in its SI unit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Floor {
    /// The estimate.
    pub rms: f64,
    /// Lower end of its 95 % interval.
    pub low95: f64,
    /// Upper end of its 95 % interval.
    pub high95: f64,
    /// Part of it that does not depend on the motion.
    pub constant: f64,
    /// Its growth with the pusher's way in a step, per m, where that shows; else 0. The variance of
    /// a step is constant² + (per_meter · way)², and `rms` is over the steps compared.
    pub per_meter: f64,
}

impl NoiseFloor {
    /// This floor over another one, the geometric mean of the numbers that both know; 1 if none is.
    pub fn times(&self, other: &Self) -> f64 {
        let pairs = self.numbers.iter().zip(&other.numbers);
        let pairs = pairs.filter_map(|(one, other)| Some(((*one)?.rms, (*other)?.rms)));
        let logs = pairs.filter(|(one, other)| one.min(*other) > 0.0);
        let logs: Vec<f64> = logs.map(|(one, other)| (one / other).ln()).collect();
        (logs.iter().sum::<f64>() / logs.len().max(1) as f64).exp()
    }

    /// The floor of one number at each step; none where it is not known.
    pub(crate) fn of_steps(&self, number: usize, observations: &Observations) -> Option<Vec<f64>> {
        let floor = self.numbers[number].filter(|floor| floor.rms > 0.0)?;
        let steps = 0..observations.n_steps();
        Some(steps.map(|step| floor.at(observations.way(step))).collect())
    }
}

impl Floor {
    /// The floor of a step whose pusher moves by `way`, in m.
    pub fn at(&self, way: f64) -> f64 {
        self.constant.hypot(self.per_meter * way)
    }

    /// The same floor with the growth that the deviations show, over the ways of the steps compared.
    fn growing(self, deviations: &[Deviation], observations: &Observations) -> Self {
        let Some(growth) = Growth::of(deviations) else { return self };
        let n = observations.n_steps();
        let variance = (0..n).map(|step| growth.variance(observations.way(step))).sum::<f64>();
        let rms = (variance / n as f64).sqrt();
        let ratio = rms / self.rms;
        let (constant, per_meter) = (growth.constant.sqrt(), growth.per_square.sqrt());
        Self { rms, low95: ratio * self.low95, high95: ratio * self.high95, constant, per_meter }
    }
}

/// The noise floor of observations, by the residuals of a model.
///
/// What the model misses is common to repeats of a push and cancels; what their starts differ by it
/// predicts. The variance within the cells of repeats is that of a push's own friction, pressure
/// and noise. The interval takes each cluster's share of the scatter as one number.
///
/// # Errors
/// `OtherSteps` if the predictions are of other observations.
pub fn noise_floor(
    observations: &Observations,
    predictions: &Predictions,
    tolerance: &RepeatTolerance,
) -> Result<NoiseFloor, DiagnosisError> {
    let residuals = predictions.residuals(observations)?;
    let cells = cells(observations, tolerance);
    let n_members = |cell: usize| cells.iter().filter(|other| **other == cell).count();
    let groups: Vec<usize> = (0..cells.len()).filter(|push| n_members(*push) > 1).collect();
    let n_members = groups.iter().map(|cell| n_members(*cell)).sum::<usize>();
    let (n_cells, n_repeats) = (groups.len(), n_members - groups.len());
    let (source, numbers) = if n_repeats >= FEWEST_REPEATS {
        let of = |number| of_repeats(&residuals, observations, &cells, number);
        (FloorSource::Repeats, std::array::from_fn(of))
    } else {
        let pairs = neighbours(observations);
        let of = |number| of_neighbours(&residuals, observations, &pairs, number);
        (FloorSource::Neighbours, std::array::from_fn(of))
    };
    Ok(NoiseFloor { source, n_repeats, n_cells, widened: Vec::new(), numbers })
}

/// Squares about the mean of steps that repeat each other, summed a push.
fn of_repeats(
    residuals: &[[Option<f64>; 7]],
    observations: &Observations,
    cells: &[usize],
    number: usize,
) -> Option<Floor> {
    let mut known: Vec<((usize, u32), usize, f64)> = Vec::new();
    for (index, values) in residuals.iter().enumerate() {
        if let Some(value) = values[number] {
            let cell = cells[observations.push_of[index]];
            known.push(((cell, observations.places[index].step), index, value));
        }
    }
    known.sort_by_key(|(group, step, _)| (*group, *step));
    let mut sums = vec![0.0; observations.pushes.len()];
    let (mut freedom, mut deviations) = (0, Vec::new());
    for group in known.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() > 1) {
        let mean = group.iter().map(|(_, _, value)| value).sum::<f64>() / group.len() as f64;
        freedom += group.len() - 1;
        let unbiased = group.len() as f64 / (group.len() - 1) as f64;
        for ((_, _), step, value) in group {
            let square = (value - mean).powi(2);
            sums[observations.push_of[*step]] += square;
            let (cluster, way) = (observations.cluster_of[*step], observations.way(*step));
            deviations.push(Deviation { cluster, way, square: unbiased * square });
        }
    }
    let used = (0..sums.len()).filter(|push| sums[*push] > 0.0).map(|push| cells[push]);
    let n_cells = used.collect::<BTreeSet<_>>().len();
    let floor = floor(&sums, &observations.clusters_of_pushes(), freedom as f64, n_cells)?;
    Some(floor.growing(&deviations, observations))
}

/// The floor of squares summed a push, with the cluster of each push and `freedom` degrees in all.
///
/// The effective number of degrees follows from the scatter of the clusters' sums (Satterthwaite). It
/// is at least that of pushes whose steps are all alike, or 1 where clusters hold several pushes.
fn floor(sums: &[f64], cluster_of: &[usize], freedom: f64, n_cells: usize) -> Option<Floor> {
    let mut of_clusters: BTreeMap<usize, f64> = BTreeMap::new();
    let mut n_pushes = 0;
    for (sum, cluster) in sums.iter().zip(cluster_of).filter(|(sum, _)| **sum > 0.0) {
        *of_clusters.entry(*cluster).or_default() += sum;
        n_pushes += 1;
    }
    if n_pushes <= n_cells || n_pushes < 2 {
        return None;
    }
    let (n, total) = (of_clusters.len() as f64, of_clusters.values().sum::<f64>());
    let squares = of_clusters.values().map(|sum| (sum - total / n).powi(2)).sum::<f64>();
    let (scatter, least) = match of_clusters.len() {
        n if n == n_pushes => (squares, (n - n_cells) as f64),
        // What a single cluster scatters by is not known.
        1 => (f64::INFINITY, 1.0),
        _ => (squares, 1.0),
    };
    let scatter = scatter * n / (n - 1.0).max(1.0);
    let effective = if scatter > 0.0 { 2.0 * total * total / scatter } else { freedom };
    let effective = effective.clamp(least, freedom.max(least));
    let rms = (total / freedom).sqrt();
    let at = |z: f64| rms / chi_square_per_freedom(effective, z).sqrt().max(1e-3);
    let (low95, high95) = (at(NORMAL_975), at(-NORMAL_975));
    Some(Floor { rms, low95, high95, constant: rms, per_meter: 0.0 })
}

/// Steps that are asked for their neighbour at most: an even choice of the set.
const MOST_QUERIES: usize = 4000;
/// The nearest share of pairs is used.
const NEAREST_SHARE: f64 = 0.25;

/// Pairs of steps of different pushes that are nearest to each other.
fn neighbours(observations: &Observations) -> Vec<(usize, usize)> {
    let n = observations.n_steps();
    let features: Vec<_> = (0..n).map(|index| features(observations, index)).collect();
    let stride = n.div_ceil(MOST_QUERIES).max(1);
    let nearest = |a: usize| {
        let is_other = |b: &usize| {
            observations.push_of[*b] != observations.push_of[a]
                && observations.places[*b].edge == observations.places[a].edge
        };
        let distances = (0..n).filter(is_other).map(|b| (distance(&features[a], &features[b]), b));
        distances.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(distance, b)| (distance, a, b))
    };
    let mut pairs: Vec<_> = (0..n).step_by(stride).filter_map(nearest).collect();
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    pairs.truncate((NEAREST_SHARE * pairs.len() as f64).ceil() as usize);
    pairs.into_iter().map(|(_, a, b)| (a, b)).collect()
}

/// What a step's outcome may depend on, each over a difference that hardly matters.
pub(crate) fn features(observations: &Observations, index: usize) -> [f64; 8] {
    let (step, place) = (&observations.steps[index].input, &observations.places[index]);
    let position = &step.pose_wb.position;
    let pusher_b = step.pose_wb.inverse_transform_point(&step.track.start());
    let way = (step.track.end() - step.track.start()).norm();
    [
        pusher_b.x / 5e-3,
        pusher_b.y / 5e-3,
        position.x / 0.05,
        position.y / 0.05,
        place.speed.max(1e-4).ln() / 0.2,
        way.max(1e-5).ln() / 0.1,
        place.beta / 0.1,
        step.pose_wb.angle,
    ]
}

pub(crate) fn distance(a: &[f64; 8], b: &[f64; 8]) -> f64 {
    let plain: f64 = (0..7).map(|k| (a[k] - b[k]).powi(2)).sum();
    plain + (wrap_angle(a[7] - b[7]) / 0.25).powi(2)
}

/// Half the squared differences of neighbours, summed by the push of the first.
fn of_neighbours(
    residuals: &[[Option<f64>; 7]],
    observations: &Observations,
    pairs: &[(usize, usize)],
    number: usize,
) -> Option<Floor> {
    let mut sums = vec![0.0; observations.pushes.len()];
    let mut deviations = Vec::new();
    for (a, b) in pairs {
        if let (Some(one), Some(other)) = (residuals[*a][number], residuals[*b][number]) {
            let square = 0.5 * (one - other).powi(2);
            sums[observations.push_of[*a]] += square;
            let (cluster, way) = (observations.cluster_of[*a], observations.way(*a));
            deviations.push(Deviation { cluster, way, square });
        }
    }
    let floor = floor(&sums, &observations.clusters_of_pushes(), deviations.len() as f64, 0)?;
    Some(floor.growing(&deviations, observations))
}

#[cfg(test)]
mod tests {
    use super::{Floor, floor};

    /// Of pushes that are clusters of their own.
    fn of_pushes(sums: &[f64], freedom: f64, n_cells: usize) -> Option<Floor> {
        floor(sums, &(0..sums.len()).collect::<Vec<_>>(), freedom, n_cells)
    }

    #[test]
    fn a_floor_is_the_pooled_sd_and_narrows_with_pushes() {
        // Ten pushes of five steps each, every deviation 2 in size.
        let wide = of_pushes(&[20.0; 10], 45.0, 5).unwrap();
        assert!((wide.rms - (200.0_f64 / 45.0).sqrt()).abs() < 1e-15);
        assert!(wide.low95 < wide.rms && wide.rms < wide.high95);
        // Shares as unequal as they can be leave no more degrees than pushes beyond their cells.
        let unequal = of_pushes(&[1.0, 1.0, 1.0, 97.0], 12.0, 1).unwrap();
        let three = |z: f64| {
            unequal.rms / crate::statistics::quantile::chi_square_per_freedom(3.0, z).sqrt()
        };
        assert!((unequal.high95 - three(-crate::statistics::quantile::NORMAL_975)).abs() < 1e-12);
        assert!(of_pushes(&[1.0, 0.0], 1.0, 0).is_none());
    }

    #[test]
    fn pushes_that_repeat_their_session_tell_no_more_of_a_floor() {
        // Twelve sessions with sums of their own, each of one push or of five that are alike.
        let of_session = |k: usize| 1.0 + (k as f64 * 1.7).sin().powi(2);
        let one: Vec<f64> = (0..12).map(of_session).collect();
        let five: Vec<f64> = (0..60).map(|push| 0.2 * of_session(push / 5)).collect();
        let sessions: Vec<usize> = (0..60).map(|push| push / 5).collect();
        let one = floor(&one, &(0..12).collect::<Vec<_>>(), 100.0, 0).unwrap();
        let five = floor(&five, &sessions, 100.0, 0).unwrap();
        for (a, b) in [(one.rms, five.rms), (one.low95, five.low95), (one.high95, five.high95)] {
            assert!((a / b - 1.0).abs() < 1e-12, "{one:?} {five:?}");
        }
        // Repeats within a single session leave the floor open within a wide range.
        let single = floor(&[1.0, 1.2, 0.8], &[4; 3], 30.0, 1).unwrap();
        assert!(single.high95 > 10.0 * single.rms, "{single:?}");
    }
}
