//! Effects that could be tested or are in the model, with the coordinates that stand for them.

use std::ops::Range;
use std::sync::Arc;

use effects::{
    Effect, FrictionCenterOffset, LimitSurfaceShape, Off, Parameter, PressureRadius, Role, Stage,
    tested,
};
use models::{ChannelModel, Description};

use crate::predict::secants::Direction;
use crate::{DiagnosisError, Observations};

/// An effect with its coordinates among all.
#[derive(Clone, Debug)]
pub(crate) struct Candidate {
    pub(crate) effect: Arc<dyn Effect>,
    /// Whether the model has it already.
    pub(crate) is_in_model: bool,
    /// Its coordinates in [`Candidates::directions`].
    pub(crate) coordinates: Range<usize>,
}

/// All effects, those of users after the catalogue's.
#[derive(Clone, Debug, Default)]
pub(crate) struct Candidates {
    pub(crate) effects: Vec<Candidate>,
    pub(crate) directions: Vec<Direction>,
    /// Name and unit of each coordinate, and the standard deviation of a weak prior.
    pub(crate) names: Vec<(&'static str, &'static str)>,
    pub(crate) prior_sd: Vec<f64>,
    /// Where each coordinate is off, and where it is in the model.
    pub(crate) off: Vec<f64>,
    pub(crate) here: Vec<f64>,
    /// How far each coordinate may change down and up from where it is off.
    pub(crate) room: Vec<[f64; 2]>,
}

/// Numbers that follow from where an object rests.
pub(crate) fn follow_from_points() -> [&'static str; 3] {
    [PressureRadius.info().id, LimitSurfaceShape.info().id, FrictionCenterOffset.info().id]
}

impl Candidates {
    /// For a model of some observations.
    ///
    /// A coordinate that means nothing while the effect is off, as the reference speed of a law of
    /// friction, stays at its usual value.
    pub(crate) fn of(
        model: &Description,
        own: &[Arc<dyn Effect>],
        observations: &Observations,
    ) -> Result<Self, DiagnosisError> {
        Self::among(tested().iter().chain(own), model, own, observations)
    }

    /// The same of some effects.
    pub(crate) fn among<'a>(
        some: impl Iterator<Item = &'a Arc<dyn Effect>>,
        model: &Description,
        own: &[Arc<dyn Effect>],
        observations: &Observations,
    ) -> Result<Self, DiagnosisError> {
        let first_step = &observations.steps[0].input;
        let physics =
            ChannelModel::new(model, observations.support, own)?.physics(&first_step.object)?;
        let has = |id: &str| physics.effects().iter().any(|(other, _)| other.info().id == id);
        let says_where = |effect: &Arc<dyn Effect>| effect.info().stages.contains(&Stage::Pressure);
        let has_spots = physics.effects().iter().any(|(effect, _)| says_where(effect));
        let follows = |effect: &&Arc<dyn Effect>| {
            let id = effect.info().id;
            has_spots && !has(id) && follow_from_points().contains(&id)
        };
        let mut found = Self::default();
        for effect in some.filter(|effect| !follows(effect)) {
            let about = effect.info();
            let own = physics.effects().iter().find(|(other, _)| other.info().id == about.id);
            let own = own.map(|(_, values)| about.to_coordinates(values));
            let first = found.directions.len();
            for (index, coordinate) in
                effect.coordinates_in(physics.rig(), first_step).iter().enumerate()
            {
                let parameter = &about.parameters[index];
                let is_axis = matches!(parameter.role, Role::Direction(_));
                if parameter.off == Off::Undefined && !is_axis {
                    continue;
                }
                found.directions.push(Direction {
                    effect: effect.clone(),
                    coordinate: index,
                    size: coordinate.secant,
                });
                found.names.push((coordinate.name, coordinate.unit));
                found.prior_sd.push(coordinate.prior_sd);
                found.off.push(coordinate.off);
                found.here.push(own.as_ref().map_or(coordinate.off, |own| own[index]));
                let (low, high) = coordinate.range;
                found.room.push([low - coordinate.off, high - coordinate.off]);
            }
            let coordinates = first..found.directions.len();
            found.even_out(about.parameters, coordinates.clone());
            let (effect, is_in_model) = (effect.clone(), has(about.id));
            found.effects.push(Candidate { effect, is_in_model, coordinates });
        }
        Ok(found)
    }

    /// The effects with some ids, and which coordinates of all are theirs.
    pub(crate) fn only(&self, is_wanted: impl Fn(&str) -> bool) -> (Self, Vec<usize>) {
        let mut effects = Vec::new();
        let mut kept = Vec::new();
        for candidate in self.effects.iter().filter(|one| is_wanted(one.effect.info().id)) {
            let first = kept.len();
            kept.extend(candidate.coordinates.clone());
            effects.push(Candidate { coordinates: first..kept.len(), ..candidate.clone() });
        }
        let found = Self {
            effects,
            directions: kept.iter().map(|k| self.directions[*k].clone()).collect(),
            names: kept.iter().map(|k| self.names[*k]).collect(),
            prior_sd: kept.iter().map(|k| self.prior_sd[*k]).collect(),
            off: kept.iter().map(|k| self.off[*k]).collect(),
            here: kept.iter().map(|k| self.here[*k]).collect(),
            room: kept.iter().map(|k| self.room[*k]).collect(),
        };
        (found, kept)
    }

    /// Makes the sizes of a vector's two coordinates one, so that turned axes see the same.
    fn even_out(&mut self, parameters: &[Parameter], coordinates: Range<usize>) {
        for x in coordinates {
            if matches!(parameters[self.directions[x].coordinate].role, Role::X(_)) {
                let mean = |a: f64, b: f64| (0.5 * (a * a + b * b)).sqrt();
                let size = mean(self.directions[x].size, self.directions[x + 1].size);
                let prior_sd = mean(self.prior_sd[x], self.prior_sd[x + 1]);
                self.directions[x..x + 2].iter_mut().for_each(|direction| direction.size = size);
                self.prior_sd[x..x + 2].fill(prior_sd);
            }
        }
    }
}
