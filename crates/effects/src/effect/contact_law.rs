//! Friction and stiffness of the contact between pusher and object.

/// Gathered laws of the contact: effects scale or add to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactLaw {
    /// Coefficient of friction for both directions; its sides follow from `asymmetry`.
    pub friction: f64,
    /// Relative difference of the sides: left bears (1 + a) times the friction, right (1 − a).
    ///
    /// Left is the side of the inward normal turned by +90°.
    pub asymmetry: f64,
    /// What it takes to break a sticking contact loose, over the sliding friction.
    pub static_ratio: f64,
    /// Slip over which what sticking bears more fades, in m/s; 0 where it is gone with any slip.
    pub stribeck_velocity: f64,
    /// How far the pusher yields along the normal, in m/N.
    pub compliance: f64,
    /// How high above the table the pusher touches, in m.
    pub height: f64,
    /// Whether a pusher that would slide to the left is held.
    pub caught_left: bool,
    /// The same to the right.
    pub caught_right: bool,
}

impl ContactLaw {
    /// Coulomb's law, rigid, with one coefficient.
    pub(crate) fn rigid(friction: f64) -> Self {
        Self {
            friction,
            asymmetry: 0.0,
            static_ratio: 1.0,
            stribeck_velocity: 0.0,
            compliance: 0.0,
            height: 0.0,
            caught_left: false,
            caught_right: false,
        }
    }

    /// Sliding friction to the left (+1) or to the right (−1).
    pub(crate) fn sliding(&self, side: f64) -> f64 {
        self.friction * (1.0 + side * self.asymmetry).max(0.0)
    }

    /// The same at some slip, in m/s, with its derivative by the slip.
    pub(crate) fn slipping(&self, side: f64, slip: f64) -> (f64, f64) {
        let sliding = self.sliding(side);
        if self.stribeck_velocity <= 0.0 {
            return (sliding, 0.0);
        }
        let ratio = slip.abs() / self.stribeck_velocity;
        let surplus = sliding * (self.static_ratio - 1.0) * (-ratio * ratio).exp();
        (sliding + surplus, -2.0 * ratio / self.stribeck_velocity * surplus)
    }

    /// Whether a pusher may be held on either side.
    pub(crate) fn is_caught(&self) -> bool {
        self.caught_left || self.caught_right
    }

    /// Whether a pusher that would slide to a side is held: to the left (+1) or to the right (−1).
    pub(crate) fn holds(&self, side: f64) -> bool {
        if side > 0.0 { self.caught_left } else { self.caught_right }
    }

    /// Whether a force of this normal and tangential part can stick. What is held can be pulled at.
    pub(crate) fn sticks(&self, normal: f64, tangential: f64) -> bool {
        let side = if tangential >= 0.0 { 1.0 } else { -1.0 };
        let is_held = self.holds(side) && tangential != 0.0;
        is_held
            || normal > 0.0 && tangential.abs() <= self.static_ratio * self.sliding(side) * normal
    }
}
