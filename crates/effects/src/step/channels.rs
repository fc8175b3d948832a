//! All that a step's measurement shows.

use crate::EffectError;

/// What is observed of a step: its motion, its contact force and the contact gap.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Channels {
    /// Displacement of B's origin along the pusher's mean velocity, in m.
    pub dx: f64,
    /// Displacement of B's origin along the left normal of that velocity, in m.
    pub dy: f64,
    /// Turn of the object, counter-clockwise positive, in rad.
    pub dtheta: f64,
    /// Mean force on the object along the inward normal, in N.
    pub force_normal: f64,
    /// Mean force on the object along the normal turned by +90°, in N.
    pub force_tangential: f64,
    /// Distance between the pusher's nominal surface and the nominal outline at the start, in m.
    pub gap_start: f64,
    /// The same at the end, in m.
    pub gap_end: f64,
}

/// A group of numbers that one sensor, or two together, show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Channel {
    /// Δx, Δy and Δθ.
    Motion,
    /// Normal and tangential force.
    Force,
    /// The gap at the start and at the end.
    Gap,
}

impl Channel {
    /// Every channel.
    pub const ALL: [Self; 3] = [Self::Motion, Self::Force, Self::Gap];
}

impl Channels {
    /// All numbers in the order of the fields.
    pub fn to_array(&self) -> [f64; 7] {
        let Self { dx, dy, dtheta, force_normal, force_tangential, gap_start, gap_end } = *self;
        [dx, dy, dtheta, force_normal, force_tangential, gap_start, gap_end]
    }

    /// From all numbers in that order.
    pub(crate) fn from_array(numbers: [f64; 7]) -> Self {
        let [dx, dy, dtheta, force_normal, force_tangential, gap_start, gap_end] = numbers;
        Self { dx, dy, dtheta, force_normal, force_tangential, gap_start, gap_end }
    }

    /// The same, if every number is finite.
    pub(crate) fn checked(self) -> Result<Self, EffectError> {
        let mut named = Self::NAMES.into_iter().zip(self.to_array());
        match named.find(|(_, value)| !value.is_finite()) {
            Some((channel, value)) => Err(EffectError::NotFinite { channel, value }),
            None => Ok(self),
        }
    }

    /// The channel of each number of [`Channels::to_array`].
    pub const KINDS: [Channel; 7] = [
        Channel::Motion,
        Channel::Motion,
        Channel::Motion,
        Channel::Force,
        Channel::Force,
        Channel::Gap,
        Channel::Gap,
    ];

    /// The name of each number of [`Channels::to_array`], as in the table.
    pub const NAMES: [&str; 7] =
        ["dx", "dy", "dtheta", "force_normal", "force_tangential", "gap_start", "gap_end"];
}
