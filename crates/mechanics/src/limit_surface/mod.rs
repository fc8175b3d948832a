//! The limit surface: which loads move a supported object, and how.

pub(crate) mod fit;
pub(crate) mod mesh;
pub(crate) mod polar;
pub(crate) mod quadratic_patch;
pub(crate) mod uniform;

use crate::MechanicsError;
use crate::limit_surface::uniform::UniformSurface;
use nalgebra::{Matrix3, Vector3};
use planar::{Twist, Wrench};

/// Declares the modules, hands on their surfaces, and lists those.
macro_rules! uniform_surfaces {
    ($($file:ident::$Surface:ident,)+) => {
        $(
            pub(crate) mod $file;
            pub use $file::$Surface;
        )+

        static UNIFORM: &[UniformSurface] = &[$(UniformSurface::of::<$Surface>()),+];
    };
}

uniform_surfaces! {
    ellipsoid::Ellipsoid,
    patch::Patch,
    point_set::PointSet,
    quartic::Quartic,
}

/// Every kind of surface that stands for uniform pressure, as `model.toml` names them.
pub fn uniform_surfaces() -> &'static [UniformSurface] {
    UNIFORM
}

/// A closed, convex surface in the space of wrenches (Fx, Fy, M) that bounds what friction can bear.
///
/// Wrenches are those **applied to the object** (friction is their opposite), in the slider frame
/// S, in N and N·m; twists are the object's, in the same frame. A load on the surface makes the
/// object move along the outward normal there; a moving object dissipates the most power that any
/// load within the surface could (maximum-power inequality). Both views are here:
///
/// - `dissipation(t) = max_w w·t` is the support function, homogeneous of degree one in t;
/// - `level(w)` is the gauge, homogeneous of degree one in w, below 1 inside and 1 on the surface.
///
/// The origin is inside. The surface need not be symmetric about it: friction may resist one way more
/// than the other.
///
/// # Source
/// Goyal, Ruina & Papadopoulos (1991), "Planar sliding with dry friction", part 1.
pub trait LimitSurface: std::fmt::Debug + Send + Sync {
    /// Power that friction dissipates while the object moves with `twist_s`, in W.
    ///
    /// # Errors
    /// A twist that is not finite, or a quadrature or solver that did not converge.
    fn dissipation(&self, twist_s: &Twist) -> Result<f64, MechanicsError>;

    /// The loads that move the object with `twist_s`: one, or a facet of them.
    ///
    /// # Errors
    /// As [`LimitSurface::dissipation`], and `NoDirection` for a zero twist.
    fn wrenches(&self, twist_s: &Twist) -> Result<WrenchSet, MechanicsError>;

    /// How far `wrench_s` is on the way to the surface: 0 at the origin, 1 on it.
    ///
    /// # Errors
    /// A wrench that is not finite, or a solver that did not converge.
    fn level(&self, wrench_s: &Wrench) -> Result<f64, MechanicsError>;

    /// The motion under a load along `wrench_s`: an outward normal where its ray leaves the surface.
    ///
    /// It is scaled so that wrench_s · twist = level(wrench_s), which makes it the gradient of the
    /// level wherever the surface is smooth; where normals are many (an edge or a vertex of the
    /// surface) it is one of them.
    ///
    /// # Errors
    /// As [`LimitSurface::level`], and `NoDirection` for a zero wrench.
    fn twist(&self, wrench_s: &Wrench) -> Result<Twist, MechanicsError>;

    /// The largest pure force divided into the largest pure moment, in m: the length that makes
    /// forces and moments of like size.
    fn characteristic_length(&self) -> f64;

    /// The load that moves the object with `twist_s`; of a facet, its center.
    ///
    /// # Errors
    /// As [`LimitSurface::wrenches`].
    fn wrench(&self, twist_s: &Twist) -> Result<Wrench, MechanicsError> {
        Ok(match self.wrenches(twist_s)? {
            WrenchSet::Point(wrench) => wrench,
            WrenchSet::Disc { center, .. } => center,
        })
    }

    /// A of level² = wᵀ A w where the surface is an ellipsoid, whose pushes are in closed form.
    fn quadric(&self) -> Option<&Matrix3<f64>> {
        None
    }
}

/// All the loads that belong to one motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WrenchSet {
    /// The surface is strictly convex there.
    Point(Wrench),
    /// A facet: the center of rotation lies on a support point, whose friction is undecided.
    ///
    /// The loads are `center` + f for every force |f| ≤ `radius` applied at `at`.
    Disc {
        /// The load of all the other points, in N and N·m.
        center: Wrench,
        /// The undecided support point, in m, frame S.
        at: nalgebra::Vector2<f64>,
        /// What that point can bear, in N.
        radius: f64,
    },
}

/// A twist as direction (largest component 1) and size; size 0 for a zero twist.
///
/// Dividing the size out first keeps squares from over- and underflowing.
pub(crate) fn direction_of_twist(twist: &Twist) -> Result<(Vector3<f64>, f64), MechanicsError> {
    split(&twist.to_vector(), "twist", "m/s or rad/s")
}

/// A wrench as direction (largest component 1) and size; size 0 for a zero wrench.
pub(crate) fn direction_of_wrench(wrench: &Wrench) -> Result<(Vector3<f64>, f64), MechanicsError> {
    split(&wrench.to_vector(), "wrench", "N or N·m")
}

fn split(
    vector: &Vector3<f64>,
    name: &'static str,
    unit: &'static str,
) -> Result<(Vector3<f64>, f64), MechanicsError> {
    if let Some(&value) = vector.iter().find(|x| !x.is_finite()) {
        return Err(MechanicsError::NotFinite { name, value, unit });
    }
    let size = vector.amax();
    if size == 0.0 { Ok((*vector, 0.0)) } else { Ok((vector / size, size)) }
}
