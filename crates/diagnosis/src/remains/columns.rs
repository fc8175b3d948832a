//! What each origin of errors could add to a model's predictions.

use std::f64::consts::PI;
use std::iter;
use std::ops::Range;

use effects::{
    Effect, FrictionCenterOffset, Origin, PressureRadius, PusherFriction, SupportFriction,
    TableAnisotropy,
};
use nalgebra::{DMatrix, DVector};

use crate::predict::candidates::Candidate;
use crate::predict::tangent::Tangent;
use crate::{Covariate, Observations, Tolerances, Whitening};

/// What is added to a number of a step by one of a component's numbers.
struct Column {
    base: Base,
    /// Index of what it is multiplied with.
    factor: usize,
}

#[derive(Clone, Copy)]
enum Base {
    /// A coordinate of an effect, in sizes that are met.
    Coordinate(usize),
    /// A number of every step, in its noise.
    Number(usize),
}

/// Numbers that every fit leaves open, and the free components of all origins.
pub(super) struct Columns<'a> {
    observations: &'a Observations,
    whitening: &'a Whitening,
    tangent: &'a Tangent,
    /// Coordinates of what every fit leaves open, and the variance known beforehand, if any.
    open: Vec<(usize, Option<f64>)>,
    scale: Vec<f64>,
    columns: Vec<Column>,
    /// Functions of where and how each step is.
    factors: Vec<Vec<f64>>,
    noise: [f64; 7],
    /// The columns of each origin, in the order of [`Origin::ALL`]: the simplest first, then what has more freedom.
    pub(super) origins: Vec<Vec<Range<usize>>>,
    /// The columns of anything smooth in where a step touches and whither it goes.
    pub(super) smooth: Range<usize>,
}

/// A function that is the same everywhere.
const EVEN: usize = 0;
/// Half waves over the table at most, along x and y.
const SHORTEST: u32 = 4;
/// Numbers of an effect of the support that may be others by the direction of the push.
const FEW: usize = 4;

/// Where a step touches and whither it goes, −1 to 1, and their products up to the third degree.
const DEGREES: [(i32, i32); 10] =
    [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3)];

impl<'a> Columns<'a> {
    pub(super) fn of(
        tangent: &'a Tangent,
        (observations, whitening): (&'a Observations, &'a Whitening),
        is_testable: impl Fn(&str) -> bool,
        tolerances: Tolerances,
    ) -> Self {
        let candidates = &tangent.candidates;
        let mut open = Vec::new();
        for candidate in &candidates.effects {
            let known = tolerances.of(candidate.effect.info()).filter(|sd| sd.is_finite());
            let is_free = tolerances.of(candidate.effect.info()) == Some(f64::INFINITY);
            let variance = known.filter(|_| !candidate.is_in_model).map(|sd| sd * sd);
            if candidate.is_in_model || is_free || known.is_some() {
                open.extend(candidate.coordinates.clone().map(|k| (k, variance)));
            }
        }
        let mut found = Self {
            observations,
            whitening,
            tangent,
            open,
            // A prior of three times what is met.
            scale: candidates.prior_sd.iter().map(|sd| sd / 3.0).collect(),
            columns: Vec::new(),
            factors: vec![vec![1.0; observations.n_steps()]],
            noise: whitening.typical_sd(),
            origins: Vec::new(),
            smooth: 0..0,
        };
        let first = found.places();
        found.add_origins(&first, &is_testable);
        found.add_smooth(&first);
        found
    }

    /// Factors: place along the edge and direction, table, orientation, speed and order.
    fn places(&mut self) -> Places {
        let observations = self.observations;
        let of_contact = |degrees: (i32, i32)| {
            let at = |step: usize| {
                let p = 2.0 * observations.value_of(Covariate::P, step) - 1.0;
                let b = observations.value_of(Covariate::Beta, step).sin();
                p.powi(degrees.0) * b.powi(degrees.1)
            };
            (0..observations.n_steps()).map(at).collect::<Vec<f64>>()
        };
        let contact: Vec<usize> =
            DEGREES.iter().map(|degrees| self.factor(of_contact(*degrees))).collect();
        let mut along = |covariate: Covariate, of: fn(f64) -> f64| {
            let values =
                observations.knows(covariate).then(|| observations.values_of(covariate))?;
            standard(values.into_iter().map(of).collect()).map(|values| self.factor(values))
        };
        let mut several = |all: &[Along]| -> Vec<usize> {
            all.iter().filter_map(|(covariate, of)| along(*covariate, *of)).collect()
        };
        let mut table = several(&[(Covariate::TableX, |x| x), (Covariate::TableY, |y| y)]);
        let turned =
            several(&[(Covariate::Orientation, f64::cos), (Covariate::Orientation, f64::sin)]);
        let speed = several(&[(Covariate::Speed, f64::ln)]);
        let order =
            several(&[(Covariate::Time, |t| t), (Covariate::Time, |t| (2.0 * t - 1.0).powi(2))]);
        if let [x, y] = table[..] {
            for [one, other] in [[x, x], [x, y], [y, y]] {
                let product = self.factors[one].iter().zip(&self.factors[other]);
                let product = product.map(|(one, other)| one * other).collect();
                table.push(self.factor(product));
            }
        }
        Places { contact, table, turned, speed, order }
    }

    /// Waves over what is touched of the table, the shorter the smaller.
    fn waves(&mut self) -> Vec<usize> {
        let along = |covariate: Covariate| {
            let values = self.observations.values_of(covariate);
            let low = values.iter().copied().fold(f64::INFINITY, f64::min);
            let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let share = |x: f64| (x - low) / (high - low);
            (high > low).then(|| values.into_iter().map(share).collect::<Vec<f64>>())
        };
        let is_told = |covariate: &Covariate| self.observations.knows(*covariate);
        let table = [Covariate::TableX, Covariate::TableY];
        let [Some(x), Some(y)] = table.map(|one| Some(one).filter(is_told).and_then(along)) else {
            return Vec::new();
        };
        let wave = |(j, k): (u32, u32)| {
            // Half of it as large as x or y beside it where it is longest.
            let size = 2.0 / f64::from(1 + j * j + k * k);
            let cosine = |n: u32, share: &f64| (f64::from(n) * PI * share).cos();
            let of = |(x, y): (&f64, &f64)| size * cosine(j, x) * cosine(k, y);
            x.iter().zip(&y).map(of).collect::<Vec<f64>>()
        };
        let all = (0..=SHORTEST).flat_map(|j| (0..=SHORTEST).map(move |k| (j, k)));
        let is_one = |(j, k): &(u32, u32)| (1..=SHORTEST * SHORTEST + 1).contains(&(j * j + k * k));
        let waves: Vec<Vec<f64>> = all.filter(is_one).map(wave).collect();
        waves.into_iter().map(|values| self.factor(values)).collect()
    }

    /// Whither the object is pushed, seen from it.
    fn pushed(&mut self) -> Vec<usize> {
        let observations = self.observations;
        if ![Covariate::Direction, Covariate::Orientation]
            .iter()
            .all(|one| observations.knows(*one))
        {
            return Vec::new();
        }
        let along = |of: fn(f64) -> f64| {
            let value = |covariate, step| observations.value_of(covariate, step);
            let turn =
                |step| value(Covariate::Direction, step) - value(Covariate::Orientation, step);
            (0..observations.n_steps()).map(|step| of(turn(step))).collect::<Vec<f64>>()
        };
        [along(f64::cos), along(f64::sin)].map(|values| self.factor(values)).to_vec()
    }

    fn factor(&mut self, values: Vec<f64>) -> usize {
        self.factors.push(values);
        self.factors.len() - 1
    }

    fn add_origins(&mut self, places: &Places, is_testable: &impl Fn(&str) -> bool) {
        for origin in Origin::ALL {
            let factors: Vec<usize> = match origin {
                Origin::Contact => places.contact[..6].to_vec(),
                Origin::Table => [&[EVEN], places.table.as_slice()].concat(),
                Origin::Measurement => [&[EVEN], places.turned.as_slice()].concat(),
                Origin::Support | Origin::Dynamics | Origin::Time => vec![EVEN],
            };
            let start = self.columns.len();
            self.add(&self.numbers_of(origin, |one| is_testable(one.effect.info().id)), &factors);
            // What may be another one at another speed, or later.
            let changes = match origin {
                Origin::Dynamics => &places.speed,
                Origin::Time => &places.order,
                _ => &Vec::new(),
            };
            let is_changing = |one: &&Candidate| changing().contains(&one.effect.info().id);
            let changing = self.tangent.candidates.effects.iter().filter(is_changing);
            let numbers: Vec<usize> = changing.flat_map(|one| one.coordinates.clone()).collect();
            self.add(&numbers, changes);
            self.origins.push(iter::once(start..self.columns.len()).collect());
        }
    }

    /// With more freedom where an origin may need it: a field over the table, pressure that leans with the push.
    pub(super) fn with_more_freedom(mut self, is_testable: impl Fn(&str) -> bool) -> Self {
        let (waves, pushed) = (self.waves(), self.pushed());
        for (origin, own) in Origin::ALL.into_iter().zip(0..) {
            let is_testable = |one: &Candidate| is_testable(one.effect.info().id);
            let (numbers, factors) = match origin {
                Origin::Table => {
                    // A place has no direction of its own.
                    let is_field =
                        |one: &Candidate| one.effect.info().id != TableAnisotropy.info().id;
                    (self.numbers_of(origin, |one| is_testable(one) && is_field(one)), &waves)
                }
                // An object that rocks bears on another side.
                Origin::Support => {
                    let is_few = |one: &Candidate| one.coordinates.len() <= FEW;
                    (self.numbers_of(origin, |one| is_testable(one) && is_few(one)), &pushed)
                }
                _ => continue,
            };
            let start = self.columns.len();
            self.add(&numbers, factors);
            self.origins[own].push(start..self.columns.len());
        }
        self.origins.iter_mut().for_each(|groups| groups.retain(|group| !group.is_empty()));
        self
    }

    /// The coordinates of some effects of an origin.
    fn numbers_of(&self, origin: Origin, is_meant: impl Fn(&Candidate) -> bool) -> Vec<usize> {
        let own = self.tangent.candidates.effects.iter();
        let own = own.filter(|one| one.effect.info().origin == origin && is_meant(one));
        own.flat_map(|one| one.coordinates.clone()).collect()
    }

    fn add(&mut self, coordinates: &[usize], factors: &[usize]) {
        let is_moved =
            |k: &&usize| self.tangent.slopes(**k).iter().flatten().any(|slope| *slope != 0.0);
        let coordinates: Vec<usize> = coordinates.iter().filter(is_moved).copied().collect();
        let all = coordinates.iter().flat_map(|k| factors.iter().map(|factor| (*k, *factor)));
        let of = |(k, factor)| Column { base: Base::Coordinate(k), factor };
        self.columns.extend(all.map(of));
    }

    fn add_smooth(&mut self, places: &Places) {
        let start = self.columns.len();
        for number in (0..self.noise.len()).filter(|number| self.noise[*number] > 0.0) {
            let factors = places.contact.iter().chain(&places.speed).copied();
            let of = |factor| Column { base: Base::Number(number), factor };
            self.columns.extend(factors.map(of));
        }
        self.smooth = start..self.columns.len();
    }

    /// Gains of rows, a vector each push, added up over those of each step.
    pub(super) fn of_steps(&self, of_rows: &[DVector<f64>]) -> Vec<f64> {
        let mut of_steps = vec![0.0; self.observations.n_steps()];
        for (push, gains) in of_rows.iter().enumerate() {
            let entries = self.whitening.entries(push).iter().zip(gains.iter());
            entries.for_each(|((step, _), gain)| of_steps[*step] += gain);
        }
        of_steps
    }

    /// How far each component's number may change, in its scale: no effect is larger than physics lets it be.
    pub(super) fn room(&self) -> Vec<[f64; 2]> {
        let candidates = &self.tangent.candidates;
        let of = |column: &Column| match column {
            Column { base: Base::Coordinate(k), factor: EVEN } => {
                let used = candidates.here[*k] - candidates.off[*k];
                let [least, most] = candidates.room[*k].map(|end| (end - used) / self.scale[*k]);
                [least.min(0.0), most.max(0.0)]
            }
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        };
        self.columns.iter().map(of).collect()
    }

    /// The effects of the model that come from an origin.
    pub(super) fn in_model_from(&self, origin: Origin) -> impl Iterator<Item = &Candidate> {
        let all = self.tangent.candidates.effects.iter();
        all.filter(move |one| one.is_in_model && one.effect.info().origin == origin)
    }

    /// Which open number a coordinate is; none where it is not open.
    pub(super) fn open_of(&self, coordinate: usize) -> Option<usize> {
        self.open.iter().position(|(k, _)| *k == coordinate)
    }

    /// How far a coordinate of the model is from "off", in its scale.
    pub(super) fn distance_from_off(&self, coordinate: usize) -> f64 {
        let candidates = &self.tangent.candidates;
        (candidates.here[coordinate] - candidates.off[coordinate]) / self.scale[coordinate]
    }

    /// The open number that each column adds to everywhere; none of the others.
    pub(super) fn evens(&self) -> Vec<Option<usize>> {
        let of = |column: &Column| match column {
            Column { base: Base::Coordinate(k), factor: EVEN } => self.open_of(*k),
            _ => None,
        };
        self.columns.iter().map(of).collect()
    }

    /// The precision of each open number beforehand, in its scale.
    pub(super) fn beliefs(&self) -> Vec<f64> {
        /// Stands for none, and keeps what no number sees determined.
        const NONE: f64 = 1e-6;
        let of = |(k, variance): &(usize, Option<f64>)| {
            variance.map_or(NONE, |variance| self.scale[*k].powi(2) / variance)
        };
        self.open.iter().map(of).collect()
    }

    /// Whitened residual, open numbers and components of a push, a column each.
    pub(super) fn of_push(&self, push: usize) -> DMatrix<f64> {
        self.whitening.whiten_columns(push, self.plain(push))
    }

    /// The same as they are, in SI units.
    pub(super) fn plain(&self, push: usize) -> DMatrix<f64> {
        let entries = self.whitening.entries(push);
        let n_open = self.open.len();
        let slope = |k: usize, step: usize, number: usize| {
            self.scale[k] * self.tangent.slopes(k)[step][number]
        };
        DMatrix::from_fn(entries.len(), 1 + n_open + self.columns.len(), |row, column| {
            let (step, number) = entries[row];
            if column == 0 {
                let observed = self.observations.steps[step].observed[number];
                let predicted = self.tangent.linearisation.predicted[step][number];
                return observed.unwrap_or_default() - predicted;
            }
            if let Some((k, _)) = self.open.get(column - 1) {
                return slope(*k, step, number);
            }
            let Column { base, factor } = &self.columns[column - 1 - n_open];
            let of_base = match base {
                Base::Coordinate(k) => slope(*k, step, number),
                Base::Number(own) if *own == number => self.noise[number],
                Base::Number(_) => 0.0,
            };
            of_base * self.factors[*factor][step]
        })
    }
}

/// A covariate, and what is taken of it.
type Along = (Covariate, fn(f64) -> f64);

/// Indices of factors.
struct Places {
    contact: Vec<usize>,
    table: Vec<usize>,
    turned: Vec<usize>,
    speed: Vec<usize>,
    order: Vec<usize>,
}

/// Numbers of a rig that may change with speed or while pushes are made.
fn changing() -> [&'static str; 4] {
    [
        PusherFriction.info().id,
        SupportFriction.info().id,
        PressureRadius.info().id,
        FrictionCenterOffset.info().id,
    ]
}

/// Less its mean, over its standard deviation; none where it hardly differs.
fn standard(mut values: Vec<f64>) -> Option<Vec<f64>> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let sd = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / n).sqrt();
    let least = 1e-3 * mean.abs().max(1e-3);
    values.iter_mut().for_each(|value| *value = (*value - mean) / sd);
    (sd > least).then_some(values)
}

#[cfg(test)]
mod tests {
    use effects::{Inertia, Origin};

    use super::{Base, Columns, EVEN, Effect, Tangent};
    use crate::synthetic::pushed_with;
    use crate::{NoiseModel, Tolerances};

    #[test]
    fn table_and_support_may_have_more_freedom_and_no_number_goes_beyond_its_range() {
        let (observations, model, _) = pushed_with(("table-tilt", &[0.2, 0.1]), 1);
        let tangent = Tangent::of_all(&model, &[], &observations).unwrap();
        let noise = NoiseModel::usual();
        let whitening = noise.whitening_at(&observations, &tangent.linearisation).unwrap();
        let of = (&observations, &whitening);
        let columns = Columns::of(&tangent, of, |_| true, Tolerances::default());
        assert!(columns.origins.iter().all(|groups| groups.len() == 1));
        let columns = columns.with_more_freedom(|_| true);
        for (origin, groups) in Origin::ALL.into_iter().zip(&columns.origins) {
            let is_freer = matches!(origin, Origin::Table | Origin::Support);
            assert_eq!(groups.len(), if is_freer { 2 } else { 1 }, "{origin:?}");
        }
        // As much inertia as the object has, from none.
        let all = &tangent.candidates.effects;
        let inertia = all.iter().find(|one| one.effect.info().id == Inertia.info().id).unwrap();
        let k = inertia.coordinates.start;
        let is_its = |at: &usize| {
            let column = &columns.columns[*at];
            matches!(column.base, Base::Coordinate(own) if own == k) && column.factor == EVEN
        };
        let at = (0..columns.columns.len()).find(is_its).unwrap();
        assert_eq!(columns.room()[at].map(|end| end * columns.scale[k]), [0.0, 1.0]);
    }
}
