//! An outline with mass goes in, what is pushed comes out: outline, mass and support.

pub(crate) mod cells;
pub(crate) mod patch_table;
pub(crate) mod points;
pub(crate) mod pressure;
pub(crate) mod sliding;
pub(crate) mod spots;
pub(crate) mod statics;
pub(crate) mod support_summary;

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use mechanics::{Ellipsoid, MechanicsError};
use nalgebra::{Matrix2, Vector2};
use planar::{Ellipse, Shape, cross};

use crate::EffectError;
use crate::error::{finite, positive};
use crate::object::patch_table::PatchTable;
use crate::object::points::{Point, Points};
use crate::object::pressure::Pressure;
use crate::object::spots::Spot;

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
    farthest_distance: f64,
    second_moment: Matrix2<f64>,
    points: Vec<Point>,
    /// Mean distance of the points from the centroid, in m.
    points_distance: f64,
    lanes: Points,
    ellipsoid: Ellipsoid,
    patch: OnceLock<Result<PatchTable, MechanicsError>>,
    cells: OnceLock<Vec<Spot>>,
    /// The last one that was asked for: the steps of a set ask for the same again and again.
    pressure: Mutex<Option<Arc<Pressure>>>,
    /// The same of [`Object::mean_stretch`].
    stretch: Mutex<Option<(Matrix2<f64>, f64)>>,
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
        let outline = shape.outline(N_OUTLINE);
        let farthest_distance =
            outline.iter().map(|place| (place - centroid).norm()).fold(mean_distance, f64::max);
        let ellipsoid = Ellipsoid::new(1.0, mean_distance)?;
        let lanes = Points::new(&points);
        let (patch, cells) = (OnceLock::new(), OnceLock::new());
        let (pressure, stretch) = (Mutex::new(None), Mutex::new(None));
        Ok(Self {
            shape,
            mass,
            moment_of_inertia,
            center_of_mass,
            centroid,
            mean_distance,
            farthest_distance,
            second_moment,
            points_distance: lanes.mean_norm(&Matrix2::identity()),
            lanes,
            points,
            ellipsoid,
            patch,
            cells,
            pressure,
            stretch,
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

    /// Distance of the outline's farthest point from the centroid, in m: c of weight that is all there.
    pub fn farthest_distance(&self) -> f64 {
        self.farthest_distance
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

    /// The cells of a grid of five rows and five columns over the outline, along the axes of its frame:
    /// first row at the smallest y, first column at the smallest x, each with its share of the area.
    pub fn cells(&self) -> &[Spot] {
        self.cells.get_or_init(|| cells::cells(&self.shape))
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

    /// Mean of |M r| over the points about the centroid, over that of |r|.
    pub(crate) fn mean_stretch(&self, map: &Matrix2<f64>) -> f64 {
        let last = || self.stretch.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, known)) = last().filter(|(of, _)| of == map) {
            return known;
        }
        let stretch = self.lanes.mean_norm(map) / self.points_distance;
        *last() = Some((*map, stretch));
        stretch
    }
}

/// Points of a smooth outline: the axes' ends are among them.
const N_OUTLINE: usize = 720;

/// Gauss–Legendre points and weights on 0 to 1, exact for polynomials up to degree 7.
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Weight of the middle of a triangle in a symmetric rule of sixteen points, exact for polynomials up
/// to degree 8.
///
/// # Source
/// Dunavant (1985), High degree efficient symmetrical Gaussian quadrature rules for the triangle,
/// Int. J. Numerical Methods in Engineering 21(6).
const OF_MIDDLE: f64 = 0.144_315_607_677_787;
/// The rule's other points by their first two barycentric coordinates, with their weights: each
/// stands for all permutations of its three.
const ORBITS: [(f64, f64, f64); 4] = [
    (0.459_292_588_292_723, 0.459_292_588_292_723, 0.095_091_634_267_285),
    (0.170_569_307_751_760, 0.170_569_307_751_760, 0.103_217_370_534_718),
    (0.050_547_228_317_031, 0.050_547_228_317_031, 0.032_458_497_623_198),
    (0.263_112_829_634_638, 0.008_394_777_409_958, 0.027_230_314_174_435),
];

/// Points with their shares of the area, from the centroid: sixteen on each quarter of an ellipse, on
/// each triangle of a polygon's centroid and an edge, or, where those overlap, on each of the triangles
/// that a polygon is cut into. All shares are positive.
fn support_points(shape: &Shape, centroid: &Vector2<f64>) -> Vec<Point> {
    let area = shape.area();
    let places = match shape {
        Shape::Ellipse(ellipse) => in_ellipse(ellipse),
        Shape::Polygon(polygon) => {
            let corners = || polygon.edges().map(|(a, b)| (a - centroid, b - centroid));
            if corners().all(|(a, b)| cross(&a, &b) > 0.0) {
                corners().flat_map(|(a, b)| in_fan(&a, &b, cross(&a, &b) / area)).collect()
            } else {
                let from_centroid = |corners: [_; 3]| corners.map(|corner| corner - centroid);
                let triangles = polygon.triangles().into_iter().map(from_centroid);
                triangles.flat_map(|triangle| in_triangle(&triangle, area)).collect()
            }
        }
    };
    // A square plate of the point's share of the area.
    let point = |(place, share): (Vector2<f64>, f64)| Point {
        place,
        share,
        spin: (share * area / 12.0).sqrt(),
    };
    places.into_iter().map(point).collect()
}

/// Sixteen places on the triangle of the origin and an edge; `share` is twice the triangle's.
fn in_fan(a: &Vector2<f64>, b: &Vector2<f64>, share: f64) -> Vec<(Vector2<f64>, f64)> {
    let along = |(s, weight_s): (f64, f64)| {
        let place = move |u: f64| s * (a + u * (b - a));
        GAUSS.map(|(u, weight_u)| (place(u), weight_s * weight_u * s * share))
    };
    GAUSS.into_iter().flat_map(along).collect()
}

/// Sixteen places on a triangle, with their shares of an area. They do not depend on which corner
/// comes first.
fn in_triangle([a, b, c]: &[Vector2<f64>; 3], area: f64) -> Vec<(Vector2<f64>, f64)> {
    let share = 0.5 * cross(&(b - a), &(c - a)) / area;
    let mut places = vec![((a + b + c) / 3.0, OF_MIDDLE * share)];
    for (first, second, weight) in ORBITS {
        let third = 1.0 - first - second;
        let mut add = |x: f64, y: f64, z: f64| places.push((x * a + y * b + z * c, weight * share));
        add(first, second, third);
        add(second, third, first);
        add(third, first, second);
        if first != second {
            add(second, first, third);
            add(first, third, second);
            add(third, second, first);
        }
    }
    places
}

fn in_ellipse(ellipse: &Ellipse) -> Vec<(Vector2<f64>, f64)> {
    const ANGLES: u32 = 16;
    let ring = |(s, weight): (f64, f64)| {
        (0..ANGLES).map(move |k| {
            let psi = std::f64::consts::TAU * (f64::from(k) + 0.5) / f64::from(ANGLES);
            (s * ellipse.at_parameter(psi), 2.0 * weight * s / f64::from(ANGLES))
        })
    };
    GAUSS.into_iter().flat_map(ring).collect()
}

#[cfg(test)]
mod tests {
    use super::Object;
    use crate::EffectError;
    use nalgebra::Vector2;
    use planar::{MIT_NAMES, Polygon, Shape, mit_object};
    use std::sync::Arc;

    fn polygon(corners: &[(f64, f64)]) -> Shape {
        let corners = corners.iter().map(|(x, y)| 1e-2 * Vector2::new(*x, *y)).collect();
        Shape::Polygon(Polygon::new(corners).unwrap())
    }

    fn shapes() -> Vec<Shape> {
        let l = [(0., 0.), (4., 0.), (4., 1.), (1., 1.), (1., 6.), (0., 6.)];
        let u = [(0., 0.), (5., 0.), (5., 6.), (4., 6.), (4., 1.), (1., 1.), (1., 5.), (0., 5.)];
        let bow = [(0., 0.), (3., 1.9), (6., 0.), (6., 4.), (3., 2.1), (0., 4.)];
        let mut shapes: Vec<_> = MIT_NAMES.iter().map(|n| mit_object(n).unwrap().shape).collect();
        shapes.extend([polygon(&l), polygon(&u), polygon(&bow)]);
        shapes.push(Shape::rectangle(0.15, 0.015).unwrap());
        shapes
    }

    #[test]
    fn the_support_points_have_the_moments_of_the_area() {
        for shape in shapes() {
            let name = format!("{shape:?}");
            let shape = Arc::new(shape);
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
            // The mean distance has a kink at the centroid: sums of points are near it.
            let mean: f64 = object.points().iter().map(|p| p.share * p.place.norm()).sum();
            assert!((mean / object.mean_distance() - 1.0).abs() < 2e-2, "{name} {mean}");
        }
    }

    #[test]
    fn every_support_point_bears_a_share_inside_the_outline() {
        for shape in shapes() {
            let object = Object::uniform(Arc::new(shape), 0.8).unwrap();
            for point in object.points() {
                assert!(point.share > 0.0 && point.spin > 0.0, "{:?} {point:?}", object.shape());
                let place = object.centroid() + point.place;
                assert!(object.shape().contains(&place), "{:?} {place}", object.shape());
            }
        }
    }

    #[test]
    fn the_points_of_a_triangle_are_exact_to_degree_eight() {
        // ∫ x^m y^n over the triangle (0, 0), (1, 0), (0, 1) is m! n!/(m + n + 2)!.
        let corners = [Vector2::zeros(), Vector2::x(), Vector2::y()];
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        for m in 0..=8 {
            for n in 0..=8 - m {
                let exact = factorial(m) * factorial(n) / factorial(m + n + 2);
                let terms = super::in_triangle(&corners, 1.0).into_iter();
                let sum: f64 = terms.map(|(r, share)| share * r.x.powi(m) * r.y.powi(n)).sum();
                assert!((sum / exact - 1.0).abs() < 1e-12, "{m} {n}: {sum} {exact}");
            }
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
