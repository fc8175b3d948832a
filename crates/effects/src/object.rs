//! What is pushed: outline, mass and support.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use mechanics::{Ellipsoid, MechanicsError};
use nalgebra::{Matrix2, Vector2};
use planar::{Shape, cross};

use crate::EffectError;
use crate::error::{finite, positive};
use crate::patch_table::PatchTable;
use crate::points::{Point, Points};
use crate::pressure::Pressure;

/// An object on the table, with what predictions need of it worked out once.
///
/// Its frame is that of the outline. Shared between steps as `Arc<Object>`: the table of the exact
/// limit surface is made on first use and kept here.
#[derive(Debug)]
pub struct Object {
    shape: Arc<Shape>,
    mass: f64,
    moment_of_inertia: f64,
    center_of_mass: Vector2<f64>,
    centroid: Vector2<f64>,
    mean_distance: f64,
    second_moment: Matrix2<f64>,
    points: Vec<Point>,
    lanes: Points,
    ellipsoid: Ellipsoid,
    patch: OnceLock<Result<PatchTable, MechanicsError>>,
    /// The last one that was asked for: the steps of a set ask for the same again and again.
    pressure: Mutex<Option<Arc<Pressure>>>,
}

impl Object {
    /// An object of `mass` in kg, moment of inertia about its center of mass in kg·m², and center
    /// of mass in m, frame of the outline.
    ///
    /// # Errors
    /// `InvalidValue` for a mass or moment that is not positive, or a center that is not finite.
    pub fn new(
        shape: Arc<Shape>,
        mass: f64,
        moment_of_inertia: f64,
        center_of_mass: Vector2<f64>,
    ) -> Result<Self, EffectError> {
        positive("the object's mass", mass, "kg")?;
        positive("the object's moment of inertia", moment_of_inertia, "kg·m²")?;
        finite("the center of mass", center_of_mass.x + center_of_mass.y, "m")?;
        let centroid = shape.centroid();
        let points = support_points(&shape, &centroid);
        let second_moment = points.iter().map(|p| p.share * p.place * p.place.transpose()).sum();
        let mean_distance = shape.mean_distance(&centroid);
        let ellipsoid = Ellipsoid::new(1.0, mean_distance)?;
        let (patch, pressure) = (OnceLock::new(), Mutex::new(None));
        Ok(Self {
            shape,
            mass,
            moment_of_inertia,
            center_of_mass,
            centroid,
            mean_distance,
            second_moment,
            lanes: Points::new(&points),
            points,
            ellipsoid,
            patch,
            pressure,
        })
    }

    /// An object whose `mass`, in kg, is spread evenly over its outline.
    ///
    /// # Errors
    /// `InvalidValue` for a mass that is not positive and finite.
    pub fn uniform(shape: Arc<Shape>, mass: f64) -> Result<Self, EffectError> {
        let center = shape.centroid();
        let moment = mass * shape.second_moment(&center) / shape.area();
        Self::new(shape, mass, moment, center)
    }

    /// The outline, in m.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Mass, in kg.
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// Moment of inertia about the center of mass, in kg·m².
    pub fn moment_of_inertia(&self) -> f64 {
        self.moment_of_inertia
    }

    /// Center of mass, in m, frame of the outline.
    pub fn center_of_mass(&self) -> &Vector2<f64> {
        &self.center_of_mass
    }

    /// Centroid of the outline's area, in m: the center of friction of uniform pressure.
    pub fn centroid(&self) -> &Vector2<f64> {
        &self.centroid
    }

    /// Mean distance of the area from its centroid, in m: c = Mmax/Fmax of uniform pressure.
    pub fn mean_distance(&self) -> f64 {
        self.mean_distance
    }

    /// ∫ r rᵀ dA / A about the centroid, in m².
    pub fn second_moment(&self) -> &Matrix2<f64> {
        &self.second_moment
    }

    /// Points about the centroid that stand for the supported area under uniform pressure.
    pub(crate) fn points(&self) -> &[Point] {
        &self.points
    }

    /// The same points, for sums over all of them.
    pub(crate) fn lanes(&self) -> &Points {
        &self.lanes
    }

    /// The ellipsoid of uniform pressure about the centroid, its largest force 1.
    pub(crate) fn ellipsoid(&self) -> &Ellipsoid {
        &self.ellipsoid
    }

    /// The exact limit surface of uniform pressure, tabulated.
    pub(crate) fn patch(&self) -> Result<&PatchTable, EffectError> {
        let made = self.patch.get_or_init(|| PatchTable::new(&self.shape));
        made.as_ref().map_err(|error| EffectError::Mechanics(error.clone()))
    }

    /// Pressure whose center is `shift` from the centroid, in m.
    ///
    /// # Errors
    /// `NotConverged`.
    pub(crate) fn pressure(&self, shift: &Vector2<f64>) -> Result<Arc<Pressure>, EffectError> {
        let last = || self.pressure.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = last().as_ref().filter(|known| known.is(shift)) {
            return Ok(known.clone());
        }
        let pressure = Arc::new(Pressure::new(self, shift)?);
        *last() = Some(pressure.clone());
        Ok(pressure)
    }
}

/// Gauss–Legendre points and weights on 0 to 1, exact for polynomials up to degree 7.
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Sixteen points on the triangle of the centroid and each edge, or on each eighth of an ellipse.
fn support_points(shape: &Shape, centroid: &Vector2<f64>) -> Vec<Point> {
    let area = shape.area();
    let mut points = Vec::new();
    // A square plate of the point's share of the area.
    let mut add = |place, share: f64| {
        points.push(Point { place, share, spin: (share * area / 12.0).sqrt() });
    };
    match shape {
        Shape::Polygon(polygon) => {
            for (a, b) in polygon.edges() {
                let (a, b) = (a - centroid, b - centroid);
                let share = cross(&a, &b) / area;
                for (s, weight_s) in GAUSS {
                    for (u, weight_u) in GAUSS {
                        add(s * (a + u * (b - a)), weight_s * weight_u * s * share);
                    }
                }
            }
        }
        Shape::Ellipse(ellipse) => {
            const ANGLES: u32 = 16;
            for (s, weight) in GAUSS {
                for k in 0..ANGLES {
                    let psi = std::f64::consts::TAU * (f64::from(k) + 0.5) / f64::from(ANGLES);
                    let share = 2.0 * weight * s / f64::from(ANGLES);
                    add(s * ellipse.at_parameter(psi), share);
                }
            }
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::Object;
    use crate::EffectError;
    use nalgebra::Vector2;
    use planar::{MIT_NAMES, Shape, mit_object};
    use std::sync::Arc;

    #[test]
    fn the_support_points_have_the_moments_of_the_area() {
        for name in MIT_NAMES {
            let shape = Arc::new(mit_object(name).unwrap().shape);
            let object = Object::uniform(shape.clone(), 0.8).unwrap();
            let total: f64 = object.points().iter().map(|point| point.share).sum();
            let first: Vector2<f64> =
                object.points().iter().map(|point| point.share * point.place).sum();
            assert!((total - 1.0).abs() < 1e-14, "{name} {total}");
            assert!(first.norm() < 1e-16, "{name} {first}");
            let polar = shape.second_moment(object.centroid()) / shape.area();
            assert!(
                (object.second_moment().trace() - polar).abs() < 1e-14 * polar.sqrt(),
                "{name}"
            );
        }
    }

    #[test]
    fn an_object_without_mass_is_refused() {
        let square = Arc::new(Shape::square(0.09).unwrap());
        let error = Object::uniform(square, 0.0).unwrap_err();
        let (name, expected) = ("the object's mass", "positive and finite");
        assert_eq!(error, EffectError::InvalidValue { name, expected, value: 0.0, unit: "kg" });
    }
}
