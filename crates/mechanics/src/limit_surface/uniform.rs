//! Limit surfaces that can stand for uniform pressure over any outline.

use crate::{LimitSurface, MechanicsError};
use planar::Shape;
use std::sync::Arc;

/// A limit surface that can stand for uniform pressure over any outline.
pub trait UniformPressure: LimitSurface + Sized + 'static {
    /// Lower-case name with hyphens, as in `model.toml`.
    const NAME: &'static str;

    /// The surface of uniform pressure over `shape`, in the shape's frame; it bears `f_max`, in N.
    ///
    /// # Errors
    /// `NotPositive` if `f_max` is not positive and finite, and what the surface refuses.
    fn over(shape: &Shape, f_max: f64) -> Result<Self, MechanicsError>;
}

/// A surface over a shape that bears a force, in N.
type Over = fn(&Shape, f64) -> Result<Arc<dyn LimitSurface>, MechanicsError>;

/// A kind of surface that stands for uniform pressure, by its name.
#[derive(Clone, Copy, Debug)]
pub struct UniformSurface {
    name: &'static str,
    over: Over,
}

impl UniformSurface {
    pub(super) const fn of<S: UniformPressure>() -> Self {
        Self { name: S::NAME, over: |shape, f_max| Ok(Arc::new(S::over(shape, f_max)?)) }
    }

    /// Lower-case name with hyphens, as in `model.toml`.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// The surface over `shape`, in the shape's frame; it bears `f_max`, in N.
    ///
    /// # Errors
    /// As [`UniformPressure::over`].
    pub fn over(&self, shape: &Shape, f_max: f64) -> Result<Arc<dyn LimitSurface>, MechanicsError> {
        (self.over)(shape, f_max)
    }
}

impl PartialEq for UniformSurface {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for UniformSurface {}
