//! Where pusher and object touch at one time.

use nalgebra::Vector2;
use planar::Contact;

/// The contact of a moment, frame of the outline, and the pusher's velocity in W.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactEvent {
    pub(crate) contact: Contact,
    pub(crate) velocity_w: Vector2<f64>,
}
