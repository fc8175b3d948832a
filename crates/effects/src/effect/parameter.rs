//! Parameters of effects: meaning, unit, range, and how they are fitted.

use crate::{EffectError, Rig};

/// A number that an effect carries, as users write it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name, as in `model.toml`.
    pub name: &'static str,
    /// SI unit; `1` for numbers without one.
    pub unit: &'static str,
    /// What it is, and what its sign means.
    pub meaning: &'static str,
    /// Its value when the effect is not there.
    pub off: Off,
    /// A size that is met on real rigs: what examples use and secants step by.
    pub typical: f64,
    /// Smallest and largest allowed value.
    pub range: (f64, f64),
    /// How it behaves when the world is turned or mirrored.
    pub role: Role,
}

/// The value of a parameter when its effect is not there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Off {
    /// This value.
    At(f64),
    /// The rig's nominal friction between pusher and object.
    PusherFriction,
    /// The rig's nominal friction between object and support.
    SupportFriction,
    /// The rig's kind of limit surface as λ.
    SurfaceShape,
    /// None: a direction or a reference of an effect whose size is zero.
    Undefined,
}

/// What a parameter becomes when the world is mirrored (y → −y) or turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// A number that neither changes.
    Even,
    /// A number that changes its sign in a mirror.
    Odd,
    /// First component of a vector; the next parameter is its [`Role::Y`].
    X(Frame),
    /// Second component of a vector.
    Y(Frame),
    /// A ratio along an axis; the next parameter is its [`Role::Direction`].
    Ratio(Frame),
    /// The axis' direction, in rad, modulo π.
    Direction(Frame),
    /// 0 or 1.
    Switch,
    /// A part of the weight. Fits move parts freely and read them as in proportion where they are more
    /// than the whole.
    Part,
    /// The same of a cell of a grid along the body's axes: seen from other axes it is not one of theirs.
    Cell,
    /// An amplitude of a wave over the table, along the table's axes: seen from other axes it is not one of
    /// theirs. Its typical size is the standard deviation of what is expected of it, and no more is.
    Wave,
    /// A number that says what others are about; no fit moves it.
    Reference,
    /// A limit that a step is on one side of: predictions jump with it, and fits try values.
    Threshold,
    /// A share in a mixture, which neither changes: nothing is beyond the ends of its range, and an
    /// estimate may be there.
    Share,
}

/// To what a vector or an axis is fixed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frame {
    /// The table.
    World,
    /// The object.
    Body,
}

/// A number that fits work with: smooth at "off", unlike a ratio with a direction.
///
/// A ratio ρ along φ is the pair (e cos 2φ, e sin 2φ) with e = ½ ln ρ; every other parameter is its
/// own coordinate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinate {
    /// Name.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Value when the effect is not there; for those without one, a usual value.
    pub off: f64,
    /// Step of secants that reach over the kinks of sticking and sliding.
    pub secant: f64,
    /// Standard deviation of a weak prior about `off`: a few times the typical size; 0 for what no fit moves.
    pub prior_sd: f64,
    /// Smallest and largest allowed value.
    pub range: (f64, f64),
}

impl Parameter {
    /// A parameter that is a plain number: off at `off`, the same in a mirror.
    pub const fn number(
        name: &'static str,
        unit: &'static str,
        meaning: &'static str,
        (off, typical): (f64, f64),
        range: (f64, f64),
    ) -> Self {
        Self { name, unit, meaning, off: Off::At(off), typical, range, role: Role::Even }
    }

    /// The value when the effect is not there; the typical one where that is not defined.
    pub fn off(&self, rig: &Rig) -> f64 {
        match self.off {
            Off::At(value) => value,
            Off::PusherFriction => rig.pusher_friction(),
            Off::SupportFriction => rig.support_friction(),
            Off::SurfaceShape => rig.surface_shape(),
            Off::Undefined => self.typical,
        }
    }

    /// A value that is there and not off: the typical one, or one as far on the other side of it.
    pub fn on(&self, rig: &Rig) -> f64 {
        let off = self.off(rig);
        if off == self.typical && self.off != Off::Undefined {
            return off - 0.5 * (self.range.1 - self.range.0).min(1.0);
        }
        self.typical
    }

    /// Refuses a value out of range, in the name of `effect`.
    pub(crate) fn check(&self, effect: &str, value: f64) -> Result<(), EffectError> {
        if self.role == Role::Switch && value != 0.0 && value != 1.0 {
            let (effect, parameter) = (effect.to_owned(), self.name.to_owned());
            return Err(EffectError::NotASwitch { effect, parameter, value });
        }
        self.check_within(effect, value, self.range)
    }

    /// Refuses a value beyond what a step allows, in the name of `effect`.
    pub(crate) fn check_within(
        &self,
        effect: &str,
        value: f64,
        (low, high): (f64, f64),
    ) -> Result<(), EffectError> {
        if (low..=high).contains(&value) {
            return Ok(());
        }
        let (effect, parameter) = (effect.to_owned(), self.name.to_owned());
        let unit = if self.unit == "1" { "(dimensionless)" } else { self.unit };
        Err(EffectError::OutOfRange { effect, parameter, value, unit, low, high })
    }
}

/// Of the whole weight, as a coordinate.
const LARGEST_PART: f64 = 4.0;

/// The coordinates of a list of parameters.
pub(crate) fn coordinates(parameters: &[Parameter], rig: &Rig) -> Vec<Coordinate> {
    let coordinate = |parameter: &Parameter| {
        let Parameter { name, unit, range, .. } = *parameter;
        let off = parameter.off(rig);
        let size = match parameter.off {
            Off::Undefined => 0.5 * parameter.typical.abs(),
            _ => (parameter.on(rig) - off).abs(),
        };
        let plain = Coordinate { name, unit, off, secant: 0.5 * size, prior_sd: 3.0 * size, range };
        let axis = |name, ratio: f64, widest: f64| {
            let (e, widest) = (0.5 * ratio.ln(), 0.5 * widest.ln());
            let range = (-widest, widest);
            let (secant, prior_sd) = (0.5 * e, 3.0 * e);
            Coordinate { name, unit: "1", off: 0.0, secant, prior_sd, range }
        };
        match parameter.role {
            Role::Ratio(_) => axis("e cos 2φ", parameter.typical, range.1),
            Role::Part | Role::Cell => Coordinate { range: (0.0, LARGEST_PART), ..plain },
            Role::Wave => Coordinate { prior_sd: size, ..plain },
            Role::Reference => Coordinate { prior_sd: 0.0, ..plain },
            _ => plain,
        }
    };
    let mut list: Vec<Coordinate> = parameters.iter().map(coordinate).collect();
    for index in 1..list.len() {
        if matches!(parameters[index].role, Role::Direction(_)) {
            list[index] = Coordinate { name: "e sin 2φ", ..list[index - 1] };
        }
    }
    list
}

/// From values as users write them to coordinates.
pub(crate) fn to_coordinates(parameters: &[Parameter], values: &[f64]) -> Vec<f64> {
    let mut list = values.to_vec();
    for index in axes(parameters, values.len()) {
        let (e, twice) = (0.5 * values[index].ln(), 2.0 * values[index + 1]);
        (list[index], list[index + 1]) = (e * twice.cos(), e * twice.sin());
    }
    list
}

/// From coordinates to values; the direction is in [0, π), and 0 where the ratio is 1, and parts are
/// together no more than 1.
pub(crate) fn from_coordinates(parameters: &[Parameter], coordinates: &[f64]) -> Vec<f64> {
    let mut list = coordinates.to_vec();
    for index in axes(parameters, coordinates.len()) {
        let (cosine, sine) = (coordinates[index], coordinates[index + 1]);
        // Each of the two may be at its end; the ratio is not beyond its own for that.
        let (low, high) = parameters[index].range;
        list[index] = (2.0 * cosine.hypot(sine)).exp().clamp(low, high);
        list[index + 1] = (0.5 * sine.atan2(cosine)).rem_euclid(std::f64::consts::PI);
    }
    let is_part = |parameter: &Parameter| matches!(parameter.role, Role::Part | Role::Cell);
    let parts = || parameters.iter().zip(&list).filter(|(parameter, _)| is_part(parameter));
    let whole: f64 = parts().map(|(_, part)| part).sum();
    if whole > 1.0 {
        let parts = parameters.iter().zip(&mut list).filter(|(parameter, _)| is_part(parameter));
        parts.for_each(|(_, part)| *part /= whole);
    }
    list
}

/// Indices of ratios whose direction is among the first `n` numbers.
fn axes(parameters: &[Parameter], n: usize) -> impl Iterator<Item = usize> + '_ {
    let is_axis = |index: &usize| matches!(parameters[*index].role, Role::Ratio(_));
    (0..parameters.len().min(n.saturating_sub(1))).filter(is_axis)
}
