//! The trait of every physical effect, and all that an effect may change.

pub(crate) mod contact_law;
pub(crate) mod geometry;
pub(crate) mod measurement;
pub(crate) mod nuisance;
pub(crate) mod parameter;
pub(crate) mod readable_unit;
pub(crate) mod setting;
pub(crate) mod spread;
pub(crate) mod support;

use std::fmt::Debug;
use std::sync::Arc;

use planar::{Pose, Wrench};
use serde::{Deserialize, Serialize};

use crate::effect::parameter::{coordinates, from_coordinates, to_coordinates};
use crate::{
    Channel, ContactLaw, Coordinate, EffectError, Geometry, LocalFriction, MeasurementModel,
    Nuisance, Object, Parameter, Rig, Role, Sliding, SlidingPoints, Spot, StepInput, Support,
};

/// A physical effect that a model can carry.
///
/// An effect adds to what the effects before it have gathered; the sums do not depend on their
/// order. It is asked at the stages that [`EffectInfo::stages`] names and at no other, with its
/// parameter values in the order of [`EffectInfo::parameters`], all finite and in range. With all values
/// at "off" it must leave everything as it is, bit for bit. What is measured beforehand and no fit
/// moves, such as a map of the table, is data of the type.
pub trait Effect: Debug + Send + Sync {
    /// Name, parameters, physics and claims.
    fn info(&self) -> &EffectInfo;

    /// [`Stage::Measurement`]: how the streams are read; once a step.
    fn measurement(&self, _values: &[f64], _step: &StepInput, _measurement: &mut MeasurementModel) {
    }

    /// [`Stage::Geometry`]: what touches where; once a step.
    fn geometry(&self, _values: &[f64], _step: &StepInput, _geometry: &mut Geometry) {}

    /// [`Stage::Pressure`]: adds the spots on which an object rests; once a step. What they leave of
    /// its weight is spread over the area as the rig says.
    fn spots(&self, _values: &[f64], _object: &Object, _spots: &mut Vec<Spot>) {}

    /// [`Stage::Support`]: the limit surface, at a moment of the step.
    fn support(&self, _values: &[f64], _moment: &Snapshot<'_>, _support: &mut Support) {}

    /// [`Stage::Local`]: relative surplus of friction at one point of the support; 0 when off.
    fn local_friction(&self, _values: &[f64], _sliding: &Sliding) -> f64 {
        0.0
    }

    /// [`Stage::Local`]: growth of that `surplus` with the logarithm of the point's speed, dσ/d ln v;
    /// by a difference, where the effect does not know better.
    fn local_growth(&self, values: &[f64], sliding: &Sliding, surplus: f64) -> f64 {
        /// Relative change of the speed.
        const STEP: f64 = 1e-6;
        let faster = Sliding { velocity_w: (1.0 + STEP) * sliding.velocity_w, ..*sliding };
        (self.local_friction(values, &faster) - surplus) / STEP
    }

    /// [`Stage::Local`]: adds surplus and growth of every point; one after the other, where the effect
    /// knows no faster way.
    fn add_local_friction(
        &self,
        values: &[f64],
        points: &SlidingPoints,
        found: &mut LocalFriction,
    ) {
        for (k, sliding) in points.iter().enumerate() {
            let surplus = self.local_friction(values, &sliding);
            found.surplus[k] += surplus;
            found.growth[k] += self.local_growth(values, &sliding, surplus);
        }
    }

    /// [`Stage::Contact`]: friction and stiffness between pusher and object; once a step, at its
    /// start.
    fn contact(&self, _values: &[f64], _moment: &Snapshot<'_>, _law: &mut ContactLaw) {}

    /// [`Stage::Load`]: what acts on the object besides pusher and friction, in N and N·m about the
    /// origin of the outline's frame, axes of W.
    fn load(&self, _values: &[f64], _moment: &Snapshot<'_>, _load_w: &mut Wrench) {}

    /// Smallest and largest value of a parameter in a step: those of its list, unless the object or the
    /// pusher allow less.
    fn range_in(&self, parameter: usize, _step: &StepInput) -> (f64, f64) {
        self.info().parameters[parameter].range
    }

    /// The coordinates of the parameters, each within what a step allows.
    fn coordinates_in(&self, rig: &Rig, step: &StepInput) -> Vec<Coordinate> {
        let about = self.info();
        let mut coordinates = about.coordinates(rig);
        for (k, (coordinate, parameter)) in coordinates.iter_mut().zip(about.parameters).enumerate()
        {
            let (low, high) = self.range_in(k, step);
            if (low, high) != parameter.range {
                coordinate.range = (coordinate.range.0.max(low), coordinate.range.1.min(high));
            }
        }
        coordinates
    }

    /// [`Stage::Dynamics`]: whether the object's inertia is integrated.
    fn has_inertia(&self, _values: &[f64]) -> bool {
        false
    }
}

/// What becomes a shared effect: an effect, or one that is shared already.
pub trait IntoEffect {
    /// The shared effect.
    fn into_effect(self) -> Arc<dyn Effect>;
}

impl<E: Effect + 'static> IntoEffect for E {
    fn into_effect(self) -> Arc<dyn Effect> {
        Arc::new(self)
    }
}

impl<E: Effect + 'static> IntoEffect for Arc<E> {
    fn into_effect(self) -> Arc<dyn Effect> {
        self
    }
}

impl IntoEffect for Arc<dyn Effect> {
    fn into_effect(self) -> Arc<dyn Effect> {
        self
    }
}

impl IntoEffect for &Arc<dyn Effect> {
    fn into_effect(self) -> Arc<dyn Effect> {
        self.clone()
    }
}

/// A moment of a step, as far as it is known.
#[derive(Clone, Copy, Debug)]
pub struct Snapshot<'a> {
    /// The rig's nominal numbers.
    pub rig: &'a Rig,
    /// The step.
    pub step: &'a StepInput,
    /// Pose of the outline in W.
    pub pose_wo: Pose,
    /// Time since the step's start, in s.
    pub time: f64,
}

/// Where in the prediction an effect acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// How measured streams are read: frames, clocks, force sensor.
    Measurement,
    /// What touches where: outline, radius, contact point.
    Geometry,
    /// Where the weight rests.
    Pressure,
    /// The limit surface: size, shape, center, directions.
    Support,
    /// Friction of each supported point with its own place and speed.
    Local,
    /// The contact between pusher and object: friction cone, compliance.
    Contact,
    /// Loads besides the pusher's.
    Load,
    /// Inertia.
    Dynamics,
}

impl Stage {
    /// Every stage, in the order in which a prediction passes them.
    pub const ALL: [Self; 8] = [
        Self::Measurement,
        Self::Geometry,
        Self::Pressure,
        Self::Support,
        Self::Local,
        Self::Contact,
        Self::Load,
        Self::Dynamics,
    ];
}

/// What of a rig an effect comes from: where to look for what is missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// How the object rests, and rubs, whichever way it lies.
    Support,
    /// What pusher and object do to each other.
    Contact,
    /// The table: its friction from place to place, its directions, its slope.
    Table,
    /// Speed and acceleration.
    Dynamics,
    /// What changes while the pushes are made.
    Time,
    /// How motion and force are measured.
    Measurement,
}

impl Origin {
    /// Every origin.
    pub const ALL: [Self; 6] =
        [Self::Support, Self::Contact, Self::Table, Self::Dynamics, Self::Time, Self::Measurement];

    /// Name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Support => "support",
            Self::Contact => "contact",
            Self::Table => "table",
            Self::Dynamics => "dynamics",
            Self::Time => "time",
            Self::Measurement => "measurement",
        }
    }
}

/// What an effect says about itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EffectInfo {
    /// Lower-case name with hyphens, as in `model.toml`.
    pub id: &'static str,
    /// A few words for people.
    pub title: &'static str,
    /// The physics in words.
    pub physics: &'static str,
    /// The equation, in plain Unicode, with its symbols.
    pub equation: &'static str,
    /// Where the law or its size comes from.
    pub source: &'static str,
    /// Where it acts.
    pub stages: &'static [Stage],
    /// What of the rig it comes from.
    pub origin: Origin,
    /// What can show it; no other channel changes with it.
    pub reaches: &'static [Channel],
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// Effects that it is confounded with.
    pub confounders: &'static [Confounder],
    /// Whether tests of other effects leave it open.
    pub nuisance: Nuisance,
    /// What to measure so that it shows, besides what its stages and frames call for.
    pub shown_by: &'static [&'static str],
}

/// Another effect that shows nearly the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Confounder {
    /// Its id.
    pub id: &'static str,
    /// With which data, and what tells them apart.
    pub when: &'static str,
}

impl EffectInfo {
    /// The coordinates that fits work with.
    pub fn coordinates(&self, rig: &Rig) -> Vec<Coordinate> {
        coordinates(self.parameters, rig)
    }

    /// From values to coordinates; `values` has one for each parameter.
    pub fn to_coordinates(&self, values: &[f64]) -> Vec<f64> {
        to_coordinates(self.parameters, values)
    }

    /// From coordinates to values; a direction is in [0, π).
    pub fn from_coordinates(&self, coordinates: &[f64]) -> Vec<f64> {
        from_coordinates(self.parameters, coordinates)
    }

    /// The values when the effect is not there.
    pub fn off(&self, rig: &Rig) -> Vec<f64> {
        self.parameters.iter().map(|parameter| parameter.off(rig)).collect()
    }

    /// Values of a size that is met on real rigs.
    pub fn typical(&self, rig: &Rig) -> Vec<f64> {
        self.parameters.iter().map(|parameter| parameter.on(rig)).collect()
    }

    /// Refuses values that are too many, too few, out of range or not finite.
    ///
    /// # Errors
    /// `WrongCount`, `OutOfRange`, `NotASwitch`.
    pub fn check(&self, values: &[f64]) -> Result<(), EffectError> {
        if values.len() != self.parameters.len() {
            let (effect, parameters) = (self.id.to_owned(), self.names());
            return Err(EffectError::WrongCount { effect, parameters, got: values.len() });
        }
        self.parameters.iter().zip(values).try_for_each(|(p, value)| p.check(self.id, *value))
    }

    /// The first parameter that has to be told, but is not; of points and cells that bear nothing, and of waves that are
    /// not there, none has.
    pub fn missing(&self, is_told: impl Fn(&str) -> bool) -> Option<&'static Parameter> {
        let is_left_out = |index: usize, parameter: &Parameter| match parameter.role {
            Role::Cell | Role::Wave => true,
            // A share follows the place of its point.
            Role::X(_) => self.is_part(index + 2) && !is_told(self.parameters[index + 2].name),
            Role::Y(_) => self.is_part(index + 1) && !is_told(self.parameters[index + 1].name),
            Role::Part => {
                !self.parameters[index - 2..index].iter().any(|place| is_told(place.name))
            }
            _ => false,
        };
        let parameters = self.parameters.iter().enumerate();
        let mut untold = parameters.filter(|(_, parameter)| !is_told(parameter.name));
        let found = untold.find(|(index, parameter)| !is_left_out(*index, parameter));
        found.map(|(_, parameter)| parameter)
    }

    fn is_part(&self, index: usize) -> bool {
        self.parameters.get(index).is_some_and(|parameter| parameter.role == Role::Part)
    }

    /// The parameters' names, for messages.
    pub(crate) fn names(&self) -> String {
        self.parameters.iter().map(|parameter| parameter.name).collect::<Vec<_>>().join(", ")
    }
}
