//! A stretch of time.

/// A stretch of time, such as one with contact, in s on the recording's clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Interval {
    pub(crate) start: f64,
    pub(crate) end: f64,
}
