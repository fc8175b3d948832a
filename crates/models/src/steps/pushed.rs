//! What is pushed.

use std::sync::Arc;

use effects::{Object, TrueOutline};
use planar::Shape;

/// What is pushed, and with what.
#[derive(Clone, Debug)]
pub struct Pushed {
    /// The outline as stated, in B.
    pub shape: Arc<Shape>,
    /// As stated, in m.
    pub pusher_radius: f64,
    /// All that effects act on; needed by models that carry some.
    pub object: Option<Arc<Object>>,
}

impl Pushed {
    /// Outline and pusher just as stated.
    pub fn stated(&self) -> TrueOutline {
        TrueOutline::stated(&self.shape, self.pusher_radius)
    }
}
