//! A pusher that sticks harder than it slides.

use crate::{About, Channel, ContactLaw, Effect, LookAlike, Moment, Off, Parameter, Role, Stage};

/// Stiction of the pusher: see [`About`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PusherStiction;

static ABOUT: About = About {
    id: "pusher-stiction",
    title: "Stiction of the pusher",
    physics: "A sticking contact holds until the force leaves a cone that is wider than the one \
        in which it slides; a sliding one goes on until it comes to rest. Between the two cones a \
        push does what it did before: at the start of a step it slides if its measured slip is \
        more than half of what sliding would give, or if contact begins there.",
    equation: "Sticks while |f_t| ≤ ratio · μp f_n; slides with |f_t| = μp f_n.",
    source: "Armstrong-Hélouvry, Dupont & Canudas de Wit (1994), A survey of models, analysis \
        tools and compensation methods for the control of machines with friction, Automatica \
        30(7).",
    stages: &[Stage::Contact],
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &[Parameter {
        name: "ratio",
        unit: "1",
        meaning: "Static over kinetic friction with the pusher",
        off: Off::At(1.0),
        typical: 1.3,
        range: (1.0, 3.0),
        role: Role::Even,
    }],
    look_alikes: &[LookAlike { id: "pusher-friction", when: "where few pushes slide" }],
};

impl Effect for PusherStiction {
    fn about(&self) -> &About {
        &ABOUT
    }

    fn contact(&self, values: &[f64], _: &Moment<'_>, law: &mut ContactLaw) {
        law.static_ratio *= values[0];
    }
}
