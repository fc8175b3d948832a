//! What is known of an effect before any test.

/// Whether tests and fits of other effects leave an effect open: what it could explain is then no
/// evidence for any of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Nuisance {
    /// No: it is off unless a test finds it.
    No,
    /// Yes, with a flat prior: a manifest states its nominal value, but not how well.
    Free {
        /// How far the nominal value may be off without being called wrong, as a share of it.
        nominal_within: f64,
    },
    /// Yes, with a normal prior about "off", whose standard deviation a set states.
    Known(Tolerance),
}

/// A standard error of what a set's manifest and its streams claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Tolerance {
    /// Of the pusher's radius, in m.
    PusherRadius,
    /// Of the tracked frame's place in the outline, along each axis, in m.
    Pose,
    /// Of the tracked frame's turn, in rad.
    Yaw,
    /// Of the time between the streams, in s.
    Latency,
    /// Of the contact's own compliance, in m/N.
    Compliance,
}
