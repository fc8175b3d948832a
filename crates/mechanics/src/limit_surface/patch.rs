//! The limit surface of a continuous pressure patch.

use crate::limit_surface::polar::{Homogeneous, Polar, polar};
use crate::limit_surface::quadratic_patch::{QuadraticPatch, QuadraticTraction};
use crate::limit_surface::{direction_of_twist, direction_of_wrench};
use crate::numerics::quadrature::Cells;
use crate::{LimitSurface, MechanicsError, UniformPressure, WrenchSet};
use nalgebra::{Matrix3, Vector2, Vector3};
use planar::{Shape, Twist, Wrench, perpendicular};
use std::sync::Arc;

/// Friction spread over a shape: each element dA bears a force of at most (traction) dA.
///
/// The dissipation is ∫ traction |v| dA. Uniform traction is in closed form on polygons (about a
/// microsecond a wrench), quadratic traction and ellipses are integrals along the outline; any other
/// field is integrated adaptively, to an error of about 1e-11 of the largest force and moment. The
/// surface is smooth and strictly convex: it has neither facets nor vertices.
#[derive(Clone)]
pub struct Patch {
    traction: Traction,
    f_max: f64,
    center: Vector2<f64>,
    length: f64,
}

/// Friction per area as a function of place: N/m² at a point in m.
type Field = Arc<dyn Fn(&Vector2<f64>) -> f64 + Send + Sync>;

#[derive(Clone)]
enum Traction {
    Quadratic(QuadraticPatch),
    Field { cells: Cells, field: Field, radius: f64 },
}

const TOLERANCE: f64 = 1e-11;

impl Patch {
    /// Uniform pressure over `shape`, in the shape's frame; it bears `f_max`, in N.
    ///
    /// # Errors
    /// `NotPositive` if `f_max` is not positive and finite.
    pub fn uniform(shape: &Shape, f_max: f64) -> Result<Self, MechanicsError> {
        if !(f_max > 0.0 && f_max.is_finite()) {
            return Err(MechanicsError::NotPositive { name: "f_max", value: f_max, unit: "N" });
        }
        Self::quadratic(shape, QuadraticTraction([f_max / shape.area(), 0.0, 0.0, 0.0]))
    }

    /// A traction that is a polynomial of degree two, over `shape`, in the shape's frame.
    ///
    /// # Errors
    /// `BadTraction` where it is negative or not finite, `NotPositive` if it is zero everywhere.
    pub fn quadratic(shape: &Shape, traction: QuadraticTraction) -> Result<Self, MechanicsError> {
        let lowest = traction.lowest(shape);
        let value = traction.at(&lowest);
        if !(value >= 0.0 && value.is_finite()) {
            return Err(MechanicsError::BadTraction { value, x: lowest.x, y: lowest.y });
        }
        let quadratic = QuadraticPatch::new(shape, traction);
        let (f_max, center) = quadratic.total();
        if !(f_max > 0.0 && f_max.is_finite()) {
            let name = "total friction";
            return Err(MechanicsError::NotPositive { name, value: f_max, unit: "N" });
        }
        let length = quadratic.load(&Vector3::z()).z / f_max;
        Ok(Self { traction: Traction::Quadratic(quadratic), f_max, center, length })
    }

    /// Any field of traction (friction coefficient times pressure), in N/m², over `shape`.
    ///
    /// The field is asked inside the shape only. It should be continuous: jumps cost many
    /// evaluations and may end in `NotConverged`.
    ///
    /// # Errors
    /// `BadTraction` where the field is negative or not finite, `NotPositive` if it is zero
    /// everywhere, `NotConverged` if its integral is out of reach.
    pub fn with_traction(
        shape: &Shape,
        field: impl Fn(&Vector2<f64>) -> f64 + Send + Sync + 'static,
    ) -> Result<Self, MechanicsError> {
        let cells = Cells::new(shape);
        let radius = shape.bounding_radius();
        let field: Field = Arc::new(field);
        let moments = |r: &Vector2<f64>| {
            let traction = checked(&field, r)?;
            Ok(traction * Vector3::new(1.0, r.x / radius, r.y / radius))
        };
        // A first, rough value gives the scale for the tolerance of the second.
        let rough = cells.integrate(None, f64::INFINITY, &moments)?.x;
        let name = "total friction";
        let not_positive = MechanicsError::NotPositive { name, value: rough, unit: "N" };
        if !(rough > 0.0 && rough.is_finite()) {
            return Err(not_positive);
        }
        let sums = cells.integrate(None, TOLERANCE * rough, &moments)?;
        let (f_max, center) = (sums.x, radius * sums.yz() / sums.x);
        let traction = Traction::Field { cells, field, radius };
        let mut patch = Self { traction, f_max, center, length: radius };
        patch.length = patch.load(&Vector3::z())?.z / f_max;
        Ok(patch)
    }

    /// The largest force, in N.
    pub fn f_max(&self) -> f64 {
        self.f_max
    }

    /// The center of friction, in m: forces through it move the object without turning.
    pub fn center_of_friction(&self) -> &Vector2<f64> {
        &self.center
    }

    /// The load (Fx, Fy, M) of a nonzero motion (vx, vy, ω).
    fn load(&self, twist: &Vector3<f64>) -> Result<Vector3<f64>, MechanicsError> {
        let (linear, angular) = (twist.xy(), twist.z);
        match &self.traction {
            Traction::Quadratic(patch) => Ok(patch.load(twist)),
            Traction::Field { cells, field, radius } => {
                let kink = (angular != 0.0).then(|| perpendicular(&linear) / angular);
                let kink = kink.filter(|point| point.norm() < 2.0 * radius);
                let traction = |r: &Vector2<f64>| {
                    let velocity = linear + angular * perpendicular(r);
                    let speed = velocity.norm();
                    if speed == 0.0 {
                        return Ok(Vector3::zeros());
                    }
                    let force = checked(field, r)? / speed * velocity;
                    let moment = planar::cross(r, &force) / radius;
                    Ok(Vector3::new(force.x, force.y, moment))
                };
                let sum = cells.integrate(kink.as_ref(), TOLERANCE * self.f_max, &traction)?;
                Ok(Vector3::new(sum.x, sum.y, radius * sum.z))
            }
        }
    }

    fn polar(&self, wrench_s: &Wrench) -> Result<Option<(Polar, f64)>, MechanicsError> {
        let (direction, size) = direction_of_wrench(wrench_s)?;
        if size == 0.0 {
            return Ok(None);
        }
        let y = Vector3::new(direction.x, direction.y, direction.z / self.length);
        Ok(Some((polar("level of a patch", self, &y, None)?, size)))
    }
}

impl UniformPressure for Patch {
    const NAME: &'static str = "uniform-patch";

    fn over(shape: &Shape, f_max: f64) -> Result<Self, MechanicsError> {
        Self::uniform(shape, f_max)
    }
}

impl LimitSurface for Patch {
    fn dissipation(&self, twist_s: &Twist) -> Result<f64, MechanicsError> {
        let (direction, size) = direction_of_twist(twist_s)?;
        if size == 0.0 {
            return Ok(0.0);
        }
        Ok(size * self.load(&direction)?.dot(&direction))
    }

    fn wrenches(&self, twist_s: &Twist) -> Result<WrenchSet, MechanicsError> {
        let (direction, size) = direction_of_twist(twist_s)?;
        if size == 0.0 {
            return Err(MechanicsError::NoDirection { name: "twist" });
        }
        Ok(WrenchSet::Point(Wrench::from_vector(&self.load(&direction)?)))
    }

    /// By Newton's method, to a relative error of about 1e-13 (uniform) or 1e-10 (other fields).
    fn level(&self, wrench_s: &Wrench) -> Result<f64, MechanicsError> {
        Ok(self.polar(wrench_s)?.map_or(0.0, |(solution, size)| size * solution.value))
    }

    fn twist(&self, wrench_s: &Wrench) -> Result<Twist, MechanicsError> {
        let solution = self.polar(wrench_s)?;
        let (Polar { normal, .. }, _) =
            solution.ok_or(MechanicsError::NoDirection { name: "wrench" })?;
        Ok(Twist::new(normal.x, normal.y, normal.z / self.length))
    }

    fn characteristic_length(&self) -> f64 {
        self.length
    }
}

/// The dissipation as a function of (vx, vy, ω ρ), with ρ the characteristic length.
impl Homogeneous for Patch {
    fn value(&self, x: &Vector3<f64>) -> Result<(f64, Vector3<f64>), MechanicsError> {
        let load = self.load(&Vector3::new(x.x, x.y, x.z / self.length))?;
        let gradient = Vector3::new(load.x, load.y, load.z / self.length);
        Ok((gradient.dot(x), gradient))
    }

    fn hessian(&self, x: &Vector3<f64>) -> Result<Matrix3<f64>, MechanicsError> {
        let step = 1e-5 * x.norm();
        let mut hessian = Matrix3::zeros();
        for axis in 0..3 {
            let (mut ahead, mut behind) = (*x, *x);
            ahead[axis] += step;
            behind[axis] -= step;
            let slope = (self.value(&ahead)?.1 - self.value(&behind)?.1) / (2.0 * step);
            hessian.set_column(axis, &slope);
        }
        Ok(0.5 * (hessian + hessian.transpose()))
    }

    fn noise(&self) -> f64 {
        match self.traction {
            Traction::Quadratic(_) => 1e-13,
            Traction::Field { .. } => TOLERANCE,
        }
    }
}

impl std::fmt::Debug for Patch {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let kind = match &self.traction {
            Traction::Quadratic(_) => "quadratic",
            Traction::Field { .. } => "field",
        };
        let Self { f_max, center, length, .. } = self;
        write!(formatter, "Patch({kind}, {f_max} N about {center:?} m, {length} m)")
    }
}

fn checked(field: &Field, r: &Vector2<f64>) -> Result<f64, MechanicsError> {
    let value = field(r);
    if value >= 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(MechanicsError::BadTraction { value, x: r.x, y: r.y })
}

#[cfg(test)]
mod tests {
    use super::Patch;
    use crate::{Ellipsoid, LimitSurface, MechanicsError, PointSet};
    use nalgebra::Vector2;
    use planar::{Ellipse, MIT_NAMES, Shape, Twist, Wrench, mit_object};

    /// Centers of rotation in, on and around every shape, and translations.
    fn motions() -> Vec<Twist> {
        let mut motions = vec![Twist::new(1.0, 0.0, 0.0), Twist::new(-0.3, 0.7, 0.0)];
        for (x, y) in [(0.0, 0.0), (0.045, 0.02), (0.045, 0.045), (-0.06, 0.01), (0.3, 0.1)] {
            motions.push(Twist::new(y, -x, 1.0));
            motions.push(Twist::new(-50.0 * y, 50.0 * x, -1.0));
        }
        motions
    }

    #[test]
    fn the_closed_form_agrees_with_quadrature_on_every_shape() {
        for name in MIT_NAMES {
            let shape = mit_object(name).unwrap().shape;
            let closed = Patch::uniform(&shape, 2.0).unwrap();
            let traction = 2.0 / shape.area();
            let integrated = Patch::with_traction(&shape, move |_| traction).unwrap();
            assert!(
                (closed.characteristic_length() - integrated.characteristic_length()).abs() < 1e-11
            );
            for twist in motions() {
                let a = closed.wrench(&twist).unwrap();
                let b = integrated.wrench(&twist).unwrap();
                assert!((a - b).to_vector().norm() < 4e-11, "{name} {twist:?} {a:?} {b:?}");
            }
        }
    }

    #[test]
    fn a_force_through_the_center_of_friction_does_not_turn() {
        let shape = mit_object("tri2").unwrap().shape;
        let patch = Patch::uniform(&shape, 2.0).unwrap();
        let push = Wrench::from_force_at(&Vector2::new(1.0, 0.4), patch.center_of_friction());
        let twist = patch.twist(&push).unwrap();
        assert!(twist.angular.abs() * 0.05 < 1e-9 * twist.linear.norm(), "{twist:?}");
    }

    #[test]
    fn a_triangle_turned_about_its_centroid_leaves_a_net_force() {
        // In hundredths of the largest force, by the midpoint rule on a million small triangles in another language.
        for (name, expected) in [("tri1", 3.41), ("tri2", 3.69), ("tri3", 4.28)] {
            let shape = mit_object(name).unwrap().shape;
            let patch = Patch::uniform(&shape, 1.0).unwrap();
            let center = shape.centroid();
            let turn = Twist::new(center.y, -center.x, 1.0);
            let force = patch.wrench(&turn).unwrap().force.norm();
            assert!((100.0 * force - expected).abs() < 0.02, "{name} {force}");
            let upright = Ellipsoid::uniform(&shape, 1.0).unwrap();
            assert!(upright.wrench(&turn).unwrap().force.norm() < 1e-14);
            let moment = |s: &dyn LimitSurface| s.wrench(&turn).unwrap().shifted(&center).torque;
            assert!((moment(&upright) - moment(&patch)).abs() < 1e-14, "{name}");
        }
    }

    #[test]
    fn the_ellipsoid_through_true_loads_has_the_net_force_of_a_turn() {
        let shape = mit_object("tri3").unwrap().shape;
        let patch = Patch::uniform(&shape, 2.0).unwrap();
        let ellipsoid = Ellipsoid::through_loads(&patch).unwrap();
        for twist in [Twist::new(1.0, 0.0, 0.0), Twist::new(0.0, 1.0, 0.0)] {
            let load = patch.wrench(&twist).unwrap();
            assert!((ellipsoid.level(&load).unwrap() - 1.0).abs() < 1e-12);
        }
        let center = patch.center_of_friction();
        let turn = Twist::new(center.y, -center.x, 1.0);
        let gap = ellipsoid.wrench(&turn).unwrap() - patch.wrench(&turn).unwrap();
        assert!(gap.to_vector().norm() < 1e-12);
    }

    #[test]
    fn a_fine_point_set_converges_to_the_patch() {
        let shape = Shape::square(0.09).unwrap();
        let patch = Patch::uniform(&shape, 2.0).unwrap();
        let twist = Twist::new(0.02, 0.01, 1.0);
        let gap = |n: usize| {
            let points = PointSet::sampling(&shape, 2.0, n).unwrap();
            (points.wrench(&twist).unwrap() - patch.wrench(&twist).unwrap()).to_vector().norm()
        };
        let (coarse, fine) = (gap(100), gap(10_000));
        assert!(fine < 2e-3 && fine < 0.1 * coarse, "{coarse} {fine}");
    }

    #[test]
    fn pressure_at_the_rim_of_a_disc_turns_harder_than_pressure_in_its_middle() {
        let disc = Shape::Ellipse(Ellipse::disc(0.05).unwrap());
        // ∫ r·r² / ∫ r·r over the disc: mean distance 3/4 R; for 1 − r/R it is R/2.
        let rim = Patch::with_traction(&disc, |r| r.norm()).unwrap();
        assert!((rim.characteristic_length() - 0.75 * 0.05).abs() < 1e-11);
        let middle = Patch::with_traction(&disc, |r| 1.0 - r.norm() / 0.05).unwrap();
        assert!((middle.characteristic_length() - 0.5 * 0.05).abs() < 1e-11);
    }

    #[test]
    fn a_field_that_friction_cannot_have_is_refused() {
        let square = Shape::square(0.1).unwrap();
        let negative = Patch::with_traction(&square, |r| r.x);
        assert!(matches!(negative, Err(MechanicsError::BadTraction { .. })));
        let nothing = Patch::with_traction(&square, |_| 0.0);
        assert!(matches!(nothing, Err(MechanicsError::NotPositive { .. })));
        let heavy = Patch::uniform(&square, f64::INFINITY);
        assert!(matches!(heavy, Err(MechanicsError::NotPositive { .. })));
    }
}
