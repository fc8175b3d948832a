//! How predictions change with an effect's coordinates, by secants over a finite size.

use std::sync::Arc;

use effects::{Effect, EffectError, Object, PushPhysics, Role, StepInput};
use models::{ChannelModel, Description, ModelError};
use nalgebra::Vector2;
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

use crate::{DiagnosisError, Observations};

/// A coordinate of an effect, and how far to move it.
#[derive(Clone, Debug)]
pub(crate) struct Direction {
    pub(crate) effect: Arc<dyn Effect>,
    /// Index in the effect's coordinates.
    pub(crate) coordinate: usize,
    /// To either side, in the coordinate's unit.
    pub(crate) size: f64,
}

impl Direction {
    fn is_switch(&self) -> bool {
        self.effect.info().parameters[self.coordinate].role == Role::Switch
    }

    fn is_like(&self, other: &Self) -> bool {
        let is_of_it = Arc::ptr_eq(&self.effect, &other.effect);
        is_of_it && (self.coordinate, self.size) == (other.coordinate, other.size)
    }
}

/// Those that are not the same, and which of them each is.
fn distinct(directions: &[Direction]) -> (Vec<Direction>, Vec<usize>) {
    let mut distinct: Vec<Direction> = Vec::new();
    let place_of = directions.iter().map(|direction| {
        let known = distinct.iter().position(|other| other.is_like(direction));
        known.unwrap_or_else(|| {
            distinct.push(direction.clone());
            distinct.len() - 1
        })
    });
    let place_of = place_of.collect();
    (distinct, place_of)
}

/// A model's predictions of all steps, and their slopes.
#[derive(Clone, Debug)]
pub(crate) struct Linearisation {
    pub(crate) predicted: Vec<[f64; 7]>,
    /// What of that pushes that differ widely add on average to the model's own predictions; none where they do not.
    pub(crate) shift: Option<Vec<[f64; 7]>>,
    /// Change of each number by the unit of each direction: `slopes[direction][step]`.
    pub(crate) slopes: Vec<Vec<[f64; 7]>>,
    /// Half the difference of the slopes to both sides of each direction: 0 for a straight line.
    pub(crate) bends: Vec<Vec<[f64; 7]>>,
    /// How far each direction is from the nearer end of its range, of the object for which that is least.
    pub(crate) rooms: Vec<f64>,
    /// Change of observed less predicted by 1 m of the pusher's end along x and y of W, all of
    /// whose way is stretched towards it; without the gaps.
    pub(crate) by_pusher: Vec<[[f64; 7]; 2]>,
}

/// Share of a direction's size at which it is tried where the mechanics refuse all of it.
const NEAR: f64 = 0.1;
/// What stands for noise of the pusher's place, in m.
const PUSHER_SHIFT: f64 = 5e-5;

impl Linearisation {
    /// The predictions of an analytical model with its effects, and their slopes.
    ///
    /// Where parameters differ from push to push, predictions are expected, and slopes those of a typical push.
    ///
    /// Infinitesimal derivatives mislead at the edge of sticking and sliding, so a slope is the
    /// secant from one side to the other, or to one side where the range ends there.
    ///
    /// # Errors
    /// `Model` for what the model refuses.
    pub(crate) fn of(
        model: &Description,
        own: &[Arc<dyn Effect>],
        observations: &Observations,
        directions: &[Direction],
    ) -> Result<Self, DiagnosisError> {
        let model = ChannelModel::new(model, observations.support, own)?;
        // What differs from push to push is often tested by secants as long.
        let (directions, place_of) = distinct(directions);
        let mut known: Vec<(Arc<Object>, Probes)> = Vec::new();
        let mut probes_of = Vec::new();
        for step in &observations.steps {
            let object = &step.input.object;
            let found = known.iter().position(|(other, _)| Arc::ptr_eq(other, object));
            probes_of.push(match found {
                Some(index) => index,
                None => {
                    let physics = model.physics(object)?;
                    known.push((object.clone(), Probes::new(physics, &step.input, &directions)?));
                    known.len() - 1
                }
            });
        }
        let probes: Vec<Probes> = known.into_iter().map(|(_, probes)| probes).collect();
        Ok(Self::at(&probes, &probes_of, observations)?.only(&place_of))
    }

    /// The slopes by some directions, in any order.
    pub(crate) fn only(&self, directions: &[usize]) -> Self {
        Self {
            predicted: self.predicted.clone(),
            shift: self.shift.clone(),
            slopes: directions.iter().map(|k| self.slopes[*k].clone()).collect(),
            bends: directions.iter().map(|k| self.bends[*k].clone()).collect(),
            rooms: directions.iter().map(|k| self.rooms[*k]).collect(),
            by_pusher: self.by_pusher.clone(),
        }
    }

    /// The same where each push has a model of its own, and directions of its own sizes.
    ///
    /// # Errors
    /// `Model` for what a model refuses.
    pub(crate) fn of_each(
        models: Vec<(PushPhysics, Vec<Direction>)>,
        observations: &Observations,
    ) -> Result<Self, DiagnosisError> {
        let first = observations.first_steps();
        let probes = |(push, (physics, directions)): (usize, (PushPhysics, Vec<Direction>))| {
            Probes::new(physics, &observations.steps[first[push]].input, &directions)
        };
        let probes: Result<Vec<Probes>, DiagnosisError> =
            models.into_par_iter().enumerate().map(probes).collect();
        Self::at(&probes?, &observations.push_of, observations)
    }

    fn at(
        all: &[Probes],
        probes_of: &[usize],
        observations: &Observations,
    ) -> Result<Self, DiagnosisError> {
        let at = |index: usize| all[probes_of[index]].at(observations, index);
        let at: Result<Vec<AtStep>, EffectError> =
            (0..observations.n_steps()).into_par_iter().map(at).collect();
        let steps = at.map_err(ModelError::from)?;
        let of = |k: usize, pick: fn(&Secant) -> [f64; 7]| {
            steps.iter().map(|step| pick(&step.secants[k])).collect()
        };
        let rooms = |k: usize| all.iter().map(move |probes| probes.sides[k].room);
        let n = all.first().map_or(0, |probes| probes.sides.len());
        Ok(Self {
            shift: None,
            rooms: (0..n).map(|k| rooms(k).fold(f64::INFINITY, f64::min)).collect(),
            slopes: (0..n).map(|k| of(k, |secant| secant.slope)).collect(),
            bends: (0..n).map(|k| of(k, |secant| secant.bend)).collect(),
            predicted: steps.iter().map(|step| step.predicted).collect(),
            by_pusher: steps.iter().map(|step| step.by_pusher).collect(),
        })
    }
}

/// The model and its neighbours, for one object.
struct Probes {
    physics: PushPhysics,
    /// Of a typical push; none where pushes do not differ.
    typical: Option<PushPhysics>,
    /// The same as its neighbours are predicted.
    roughly: PushPhysics,
    sides: Vec<Sides>,
}

/// The model with a coordinate moved.
struct Sides {
    above: Option<PushPhysics>,
    below: Option<PushPhysics>,
    /// From one side to the other, and from the middle to the upper one.
    span: f64,
    by_above: f64,
    /// To the nearer end of the range.
    room: f64,
    /// A place nearer by on one side, and how far it is.
    near: Option<(PushPhysics, f64)>,
    /// Whether it is switched, so that sub-steps miss another part on each side.
    is_switched: bool,
}

struct AtStep {
    predicted: [f64; 7],
    secants: Vec<Secant>,
    by_pusher: [[f64; 7]; 2],
}

struct Secant {
    slope: [f64; 7],
    bend: [f64; 7],
}

impl Probes {
    fn new(
        physics: PushPhysics,
        step: &StepInput,
        directions: &[Direction],
    ) -> Result<Self, DiagnosisError> {
        let typical = physics.of_typical_push();
        let middle = typical.as_ref().unwrap_or(&physics);
        let roughly = middle.clone().in_half_the_substeps();
        let sides = directions.iter().map(|direction| {
            let from = if direction.is_switch() { middle } else { &roughly };
            Sides::new(from, direction, step)
        });
        let sides = sides.collect::<Result<_, EffectError>>().map_err(ModelError::from)?;
        Ok(Self { physics, typical, roughly, sides })
    }

    fn at(&self, observations: &Observations, index: usize) -> Result<AtStep, EffectError> {
        let step = &observations.steps[index].input;
        let predict = |physics: &PushPhysics| physics.predict(step).map(|found| found.to_array());
        let predicted = predict(&self.physics)?;
        let typical = self.typical.as_ref().map_or(Ok(predicted), predict)?;
        let roughly = predict(&self.roughly)?;
        let secant = |sides: &Sides| -> Result<Secant, EffectError> {
            let here = if sides.is_switched { typical } else { roughly };
            let side = |side: &Option<PushPhysics>| side.as_ref().map(predict).transpose();
            let (above, below, span) = match (side(&sides.above), side(&sides.below)) {
                (Ok(above), Ok(below)) => (above, below, sides.span),
                // What the mechanics refuse on one side, as a pusher so high that no lean is that of its force, the
                // other one tells.
                (Ok(Some(above)), Err(_)) => (Some(above), None, sides.by_above),
                (Err(_), Ok(Some(below))) => (None, Some(below), sides.span - sides.by_above),
                (Err(why), _) | (_, Err(why)) => match &sides.near {
                    Some((near, by)) => (Some(predict(near)?), None, *by),
                    None => return Err(why),
                },
            };
            let is_one_sided = above.is_none() || below.is_none();
            let (above, below) = (above.unwrap_or(here), below.unwrap_or(here));
            let slope = std::array::from_fn(|k| (above[k] - below[k]) / span);
            let bend = |k: usize| (above[k] + below[k] - 2.0 * here[k]) / span;
            let bend = if is_one_sided { [0.0; 7] } else { std::array::from_fn(bend) };
            Ok(Secant { slope, bend })
        };
        let secants = self.sides.iter().map(secant).collect::<Result<_, _>>()?;
        let observed = &observations.steps[index].observed;
        let by_pusher = [Vector2::x(), Vector2::y()].map(|axis| -> Result<[f64; 7], EffectError> {
            let moved = stretched(step, PUSHER_SHIFT * axis);
            let then = self.roughly.predict(&moved)?.to_array();
            let turned = turned(step, &moved, observed, &predicted);
            let mut change: [f64; 7] = std::array::from_fn(|k| roughly[k] - then[k] + turned[k]);
            (change[5], change[6]) = (0.0, 0.0);
            Ok(change.map(|change| change / PUSHER_SHIFT))
        });
        let [x, y] = by_pusher;
        Ok(AtStep { predicted, secants, by_pusher: [x?, y?] })
    }
}

impl Sides {
    fn new(
        physics: &PushPhysics,
        direction: &Direction,
        step: &StepInput,
    ) -> Result<Self, EffectError> {
        let here = Here::of(physics, direction, step);
        let (place, bounds) = (here.place(), here.bounds);
        let is_switched = direction.is_switch();
        let (low, high) = match is_switched {
            true => bounds,
            false => {
                ((place - direction.size).max(bounds.0), (place + direction.size).min(bounds.1))
            }
        };
        let at = |place: f64| here.at(physics, place);
        let (span, by_above) = (high - low, high - place);
        let by = NEAR * if high == place { low - place } else { by_above };
        let near = if is_switched { None } else { at(place + by)? };
        let (above, below, near) = (at(high)?, at(low)?, near.map(|near| (near, by)));
        let room = (place - bounds.0).min(bounds.1 - place);
        Ok(Self { above, below, span, by_above, room, near, is_switched })
    }
}

/// Where a model stands along a direction.
struct Here<'a> {
    direction: &'a Direction,
    coordinates: Vec<f64>,
    is_in_model: bool,
    bounds: (f64, f64),
}

impl<'a> Here<'a> {
    fn of(physics: &PushPhysics, direction: &'a Direction, step: &StepInput) -> Self {
        let about = direction.effect.info();
        let found = physics.effects().iter().find(|(other, _)| other.info().id == about.id);
        let off = about.off(physics.rig());
        let coordinates = about.to_coordinates(found.map_or(&off, |(_, values)| values));
        let all = direction.effect.coordinates_in(physics.rig(), step);
        let bounds = all[direction.coordinate].range;
        Self { direction, coordinates, is_in_model: found.is_some(), bounds }
    }

    fn place(&self) -> f64 {
        self.coordinates[self.direction.coordinate]
    }

    /// The model elsewhere; none if that is here.
    fn at(&self, physics: &PushPhysics, place: f64) -> Result<Option<PushPhysics>, EffectError> {
        if place == self.place() {
            return Ok(None);
        }
        let Direction { effect, coordinate, .. } = self.direction;
        let mut there = self.coordinates.clone();
        there[*coordinate] = place;
        let values = effect.info().from_coordinates(&there);
        let mut moved = physics.clone();
        match self.is_in_model {
            true => moved.set(effect.info().id, &values).map(|()| Some(moved)),
            false => moved.with(effect, &values).map(Some),
        }
    }
}

/// A model moved by so much along directions.
///
/// # Errors
/// What an effect refuses, such as a value beyond its range.
pub(crate) fn moved<'a>(
    mut physics: PushPhysics,
    along: impl Iterator<Item = (&'a Direction, f64)>,
    step: &StepInput,
) -> Result<PushPhysics, EffectError> {
    for (direction, by) in along {
        let here = Here::of(&physics, direction, step);
        if let Some(there) = here.at(&physics, here.place() + by)? {
            physics = there;
        }
    }
    Ok(physics)
}

/// The step with its pusher's end moved, in m, and all of its way in proportion.
fn stretched(step: &StepInput, shift: Vector2<f64>) -> StepInput {
    let duration = step.track.duration();
    let ((start, start_rate), (end, end_rate)) = (step.track.at(0.0), step.track.at(duration));
    let rate = shift / duration;
    let track =
        effects::Track::cubic((start, start_rate + rate), (end + shift, end_rate + rate), duration);
    StepInput { track, ..step.clone() }
}

/// How the observed displacement changes as the direction turns along which it is measured.
fn turned(
    step: &StepInput,
    moved: &StepInput,
    observed: &[Option<f64>; 7],
    predicted: &[f64; 7],
) -> [f64; 7] {
    let [dx, dy] = [0, 1].map(|k| observed[k].unwrap_or(predicted[k]));
    let (before, after) = (step.direction_w(), moved.direction_w());
    let way_w = dx * before + dy * planar::perpendicular(&before);
    let mut change = [0.0; 7];
    change[0] = way_w.dot(&after) - dx;
    change[1] = way_w.dot(&planar::perpendicular(&after)) - dy;
    change
}

#[cfg(test)]
mod tests {
    use effects::{
        ContactLaw, Effect, EffectInfo, IntoEffect, PushHeight, PusherFrictionAsymmetry, Snapshot,
    };

    use super::{Direction, Linearisation, NEAR, distinct};
    use crate::DiagnosisError;
    use crate::synthetic::recorded;

    /// A push height above which no step can be predicted, in m.
    #[derive(Debug)]
    struct LowCeiling(f64);

    impl Effect for LowCeiling {
        fn info(&self) -> &EffectInfo {
            PushHeight.info()
        }

        fn contact(&self, values: &[f64], at: &Snapshot<'_>, law: &mut ContactLaw) {
            let is_refused = values[0] > self.0;
            PushHeight.contact(if is_refused { &[f64::NAN] } else { values }, at, law);
        }
    }

    /// An asymmetry beyond which to either side no step can be predicted.
    #[derive(Debug)]
    struct HardlyAsymmetric(f64);

    impl Effect for HardlyAsymmetric {
        fn info(&self) -> &EffectInfo {
            PusherFrictionAsymmetry.info()
        }

        fn contact(&self, values: &[f64], at: &Snapshot<'_>, law: &mut ContactLaw) {
            PusherFrictionAsymmetry.contact(values, at, law);
            if values[0].abs() > self.0 {
                PushHeight.contact(&[f64::NAN], at, law);
            }
        }
    }

    fn slopes(effect: impl IntoEffect, size: f64) -> Result<Vec<[f64; 7]>, DiagnosisError> {
        let (observations, model) = recorded(1);
        let direction = Direction { effect: effect.into_effect(), coordinate: 0, size };
        let mut found = Linearisation::of(&model, &[], &observations, &[direction])?;
        Ok(found.slopes.swap_remove(0))
    }

    #[test]
    fn a_direction_that_is_there_twice_has_its_slopes_in_both_places() {
        let (observations, model) = recorded(1);
        let effect = PushHeight.into_effect();
        let sizes = [0.01, 0.02, 0.01];
        let directions =
            sizes.map(|size| Direction { effect: effect.clone(), coordinate: 0, size });
        let (distinct, place_of) = distinct(&directions);
        assert_eq!((distinct.len(), place_of), (2, vec![0, 1, 0]));
        let of = |directions: &[Direction]| {
            Linearisation::of(&model, &[], &observations, directions).unwrap().slopes
        };
        let alone = directions.each_ref().map(|one| of(std::slice::from_ref(one)).swap_remove(0));
        assert_eq!(of(&directions), alone);
        assert_ne!(alone[0], alone[1]);
    }

    #[test]
    fn a_size_that_the_mechanics_refuse_is_tried_nearer_by() {
        const SIZE: f64 = 0.02;
        let found = slopes(LowCeiling(0.5 * SIZE), SIZE).unwrap();
        assert_eq!(found, slopes(PushHeight, NEAR * SIZE).unwrap());
        assert_ne!(found, slopes(PushHeight, SIZE).unwrap());
        assert!(slopes(LowCeiling(0.5 * NEAR * SIZE), SIZE).is_err());
        // To either side.
        let found = slopes(HardlyAsymmetric(0.5 * SIZE), SIZE).unwrap();
        assert!(found.iter().flatten().all(|slope| slope.is_finite()));
        assert_ne!(found, slopes(PusherFrictionAsymmetry, SIZE).unwrap());
        assert!(slopes(HardlyAsymmetric(0.5 * NEAR * SIZE), SIZE).is_err());
    }
}
