//! The exact limit surface of several support points.

use crate::limit_surface::polar::{Homogeneous, Polar, plane_basis, polar};
use crate::limit_surface::{direction_of_twist, direction_of_wrench};
use crate::{LimitSurface, MechanicsError, UniformPressure, WrenchSet};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use planar::{Shape, Twist, Wrench, perpendicular};

/// The Minkowski sum of the points' elliptical discs, with dissipation Σ fᵢ |vᵢ|.
///
/// Each point leaves two flat facets, one for each sense of a rotation about it; between them the
/// surface is curved, except where all points lie on a line: there it has edges. At least two
/// distinct points are needed: a single one bears no moment about itself.
///
/// # Source
/// Goyal, Ruina & Papadopoulos (1991), "Planar sliding with dry friction", part 1.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSet {
    points: Vec<(Vector2<f64>, f64)>,
    length: f64,
}

/// A flat part of the surface: the loads of a rotation about one support point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// The middle of the facet: the load of all the other points, in N and N·m.
    pub center: Wrench,
    /// The support point, in m.
    pub at: Vector2<f64>,
    /// What it bears, in N: the facet is `center` + every force up to this size at `at`.
    pub radius: f64,
    /// The rotation about the point, with an angular velocity of ±1 rad/s.
    pub normal: Twist,
}

impl PointSet {
    /// Points with their place, in m, and the friction force that each bears, in N.
    ///
    /// Points closer than 1e-12 of the set's extent become one that bears their sum.
    ///
    /// # Errors
    /// `NotPositive` or `NotFinite` for a bad point, `TooFewPoints` if not two are distinct.
    pub fn new(
        points: impl IntoIterator<Item = (Vector2<f64>, f64)>,
    ) -> Result<Self, MechanicsError> {
        let given: Vec<_> = points.into_iter().collect();
        for (at, f_max) in &given {
            if !(*f_max > 0.0 && f_max.is_finite()) {
                let name = "friction of a support point";
                return Err(MechanicsError::NotPositive { name, value: *f_max, unit: "N" });
            }
            if let Some(&value) = at.iter().find(|x| !x.is_finite()) {
                return Err(MechanicsError::NotFinite { name: "support point", value, unit: "m" });
            }
        }
        let points = merged(given);
        if points.len() < 2 {
            return Err(MechanicsError::TooFewPoints { distinct: points.len() });
        }
        let total: f64 = points.iter().map(|(_, f)| f).sum();
        let length = points.iter().map(|(r, f)| f * r.norm()).sum::<f64>() / total;
        Ok(Self { points, length })
    }

    /// Lumps the pressure of a square within 1 % of its exact characteristic length.
    pub const ENOUGH: usize = 100;

    /// Uniform pressure over `shape`, lumped at the centers of the cells of a square grid with
    /// about `n` cells inside the shape; together they bear `f_max`, in N.
    ///
    /// # Errors
    /// `NotPositive` for the force, `TooFewPoints` if the grid is too coarse for the shape.
    pub fn sampling(shape: &Shape, f_max: f64, n: usize) -> Result<Self, MechanicsError> {
        let center = shape.centroid();
        let cell = (shape.area() / n.max(1) as f64).sqrt();
        // Cells start symmetrically about the centroid and cover the bounding square.
        let reach = shape.bounding_radius() + center.norm();
        let half = (reach / cell).ceil() as i64;
        let at = |k: i64| (k as f64 + 0.5) * cell;
        let places: Vec<_> = (-half..half)
            .flat_map(|i| (-half..half).map(move |j| Vector2::new(at(i), at(j)) + center))
            .filter(|point| shape.contains(point))
            .collect();
        let each = f_max / places.len().max(1) as f64;
        Self::new(places.into_iter().map(|point| (point, each)))
    }

    /// The distinct points: place in m and friction in N.
    pub fn points(&self) -> &[(Vector2<f64>, f64)] {
        &self.points
    }

    /// All facets: for each point the one of the counter-clockwise turn, then its mirror image.
    pub fn facets(&self) -> Vec<Facet> {
        let facet = |(index, &(at, radius)): (usize, &(Vector2<f64>, f64))| {
            let others = self.points.iter().enumerate().filter(|(i, _)| *i != index);
            let load = |(_, (r, f)): (usize, &(Vector2<f64>, f64))| {
                Wrench::from_force_at(&(*f * perpendicular(&(r - at)).normalize()), r)
            };
            let center: Wrench = others.map(load).sum();
            let normal = Twist { linear: -perpendicular(&at), angular: 1.0 };
            let mirrored = Facet { center: -center, at, radius, normal: -normal };
            [Facet { center, at, radius, normal }, mirrored]
        };
        self.points.iter().enumerate().flat_map(facet).collect()
    }

    fn scaled(&self) -> Scaled<'_> {
        // Of two distinct points one is away from the origin, so the length is never zero.
        Scaled { points: &self.points, length: self.length }
    }

    fn polar(&self, wrench_s: &Wrench) -> Result<(Polar, f64), MechanicsError> {
        let (direction, size) = direction_of_wrench(wrench_s)?;
        if size == 0.0 {
            return Err(MechanicsError::NoDirection { name: "wrench" });
        }
        let y = Vector3::new(direction.x, direction.y, direction.z / self.length);
        let solution = self.scaled().polar(&y)?;
        Ok((solution, size))
    }
}

impl UniformPressure for PointSet {
    const NAME: &'static str = "points";

    fn over(shape: &Shape, f_max: f64) -> Result<Self, MechanicsError> {
        Self::sampling(shape, f_max, Self::ENOUGH)
    }
}

impl LimitSurface for PointSet {
    fn dissipation(&self, twist_s: &Twist) -> Result<f64, MechanicsError> {
        let (direction, size) = direction_of_twist(twist_s)?;
        let motion = Twist::from_vector(&direction);
        let sum: f64 = self.points.iter().map(|(r, f)| f * motion.velocity_at(r).norm()).sum();
        Ok(size * sum)
    }

    fn wrenches(&self, twist_s: &Twist) -> Result<WrenchSet, MechanicsError> {
        let (direction, size) = direction_of_twist(twist_s)?;
        if size == 0.0 {
            return Err(MechanicsError::NoDirection { name: "twist" });
        }
        let (linear, angular) = (direction.xy(), direction.z);
        let mut load = Wrench::default();
        let mut undecided: Option<(Vector2<f64>, f64)> = None;
        for (r, f) in &self.points {
            let velocity = linear + angular * perpendicular(r);
            let speed = velocity.norm();
            let rounding = 16.0 * f64::EPSILON * (linear.norm() + angular.abs() * r.norm());
            if speed <= rounding {
                undecided = Some((*r, f + undecided.map_or(0.0, |(_, radius)| radius)));
            } else {
                load += Wrench::from_force_at(&(*f / speed * velocity), r);
            }
        }
        Ok(match undecided {
            Some((at, radius)) => WrenchSet::Disc { center: load, at, radius },
            None => WrenchSet::Point(load),
        })
    }

    /// Exact on facets; elsewhere Newton's method, to a relative error of about 1e-13. O(N²).
    fn level(&self, wrench_s: &Wrench) -> Result<f64, MechanicsError> {
        match self.polar(wrench_s) {
            Ok((solution, size)) => Ok(size * solution.value),
            Err(MechanicsError::NoDirection { .. }) => Ok(0.0),
            Err(error) => Err(error),
        }
    }

    fn twist(&self, wrench_s: &Wrench) -> Result<Twist, MechanicsError> {
        let (Polar { normal, .. }, _) = self.polar(wrench_s)?;
        Ok(Twist::new(normal.x, normal.y, normal.z / self.length))
    }

    fn characteristic_length(&self) -> f64 {
        self.length
    }
}

/// The dissipation as a function of (vx, vy, ω ρ), with ρ the characteristic length.
struct Scaled<'a> {
    points: &'a [(Vector2<f64>, f64)],
    length: f64,
}

impl Scaled<'_> {
    /// The gauge at y = (fx, fy, M/ρ) and its twist.
    ///
    /// Seen on the plane y·x = 1 the dissipation is a sum of distances with one kink for each point:
    /// the turn about it. If the lowest of the kinks is no minimum, no kink is; the way down from
    /// it then stays clear of all of them.
    fn polar(&self, y: &Vector3<f64>) -> Result<Polar, MechanicsError> {
        let turns = self.points.iter().enumerate().filter_map(|(index, (r, _))| {
            let turn = self.turn_about(r);
            let moment = y.dot(&turn);
            let far = moment.abs() <= 1e-14 * y.norm() * turn.norm();
            (!far).then(|| {
                let x = turn / moment;
                (index, x, self.sum(&x))
            })
        });
        let Some((index, x, value)) = turns.min_by(|a, b| a.2.total_cmp(&b.2)) else {
            return polar("level of a point set", self, y, None);
        };
        match self.way_down(index, &x, y, value) {
            None => Ok(Polar { value: 1.0 / value, normal: x / value }),
            Some(start) => polar("level of a point set", self, y, Some(start)),
        }
    }

    fn turn_about(&self, r: &Vector2<f64>) -> Vector3<f64> {
        Vector3::new(r.y, -r.x, self.length)
    }

    fn velocity(&self, x: &Vector3<f64>, r: &Vector2<f64>) -> Vector2<f64> {
        x.xy() + x.z / self.length * perpendicular(r)
    }

    fn sum(&self, x: &Vector3<f64>) -> f64 {
        self.points.iter().map(|(r, f)| f * self.velocity(x, r).norm()).sum()
    }

    /// A lower neighbor of the kink of point `index` within the plane, if the kink is no minimum.
    fn way_down(
        &self,
        index: usize,
        x: &Vector3<f64>,
        y: &Vector3<f64>,
        value: f64,
    ) -> Option<Vector3<f64>> {
        let plane = plane_basis(&y.normalize());
        let (at, f_max) = self.points[index];
        let mut gradient = Vector3::zeros();
        for (i, (r, f)) in self.points.iter().enumerate() {
            if i != index {
                gradient += self.pulled_back(&(*f * self.velocity(x, r).normalize()), r);
            }
        }
        let column = |k: usize| self.velocity(&plane.column(k).into_owned(), &at);
        let to_velocity = Matrix2::from_columns(&[column(0), column(1)]);
        let to_plane = to_velocity.try_inverse()?;
        let pull = to_plane.transpose() * (plane.transpose() * gradient);
        if pull.norm() <= f_max * (1.0 + 1e-12) {
            return None;
        }
        let step = plane * (to_plane * -pull.normalize());
        let mut fraction = x.norm() / step.norm();
        for _ in 0..60 {
            let next = x + fraction * step;
            if self.sum(&next) < value {
                return Some(next);
            }
            fraction *= 0.5;
        }
        None
    }

    /// The load (fx, fy, M/ρ) of a force at r.
    fn pulled_back(&self, force: &Vector2<f64>, r: &Vector2<f64>) -> Vector3<f64> {
        Vector3::new(force.x, force.y, planar::cross(r, force) / self.length)
    }
}

impl Homogeneous for Scaled<'_> {
    fn value(&self, x: &Vector3<f64>) -> Result<(f64, Vector3<f64>), MechanicsError> {
        let mut value = 0.0;
        let mut gradient = Vector3::zeros();
        for (r, f) in self.points {
            let velocity = self.velocity(x, r);
            let speed = velocity.norm();
            value += f * speed;
            if speed > 0.0 {
                gradient += self.pulled_back(&(*f / speed * velocity), r);
            }
        }
        Ok((value, gradient))
    }

    fn hessian(&self, x: &Vector3<f64>) -> Result<Matrix3<f64>, MechanicsError> {
        let mut hessian = Matrix3::zeros();
        for (r, f) in self.points {
            let velocity = self.velocity(x, r);
            let speed = velocity.norm();
            if speed > 0.0 {
                let across = self.pulled_back(&(perpendicular(&velocity) / speed), r);
                hessian += (f / speed) * across * across.transpose();
            }
        }
        Ok(hessian)
    }
}

fn merged(given: Vec<(Vector2<f64>, f64)>) -> Vec<(Vector2<f64>, f64)> {
    let Some((first, _)) = given.first().copied() else { return given };
    let near = 1e-12 * given.iter().map(|(r, _)| (r - first).norm()).fold(0.0, f64::max);
    // Sorting brings points that may coincide next to each other along x.
    let mut sorted = given;
    sorted.sort_by(|(a, _), (b, _)| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut distinct: Vec<(Vector2<f64>, f64)> = Vec::with_capacity(sorted.len());
    for (r, f) in sorted {
        let nearby = distinct.iter_mut().rev().take_while(|(s, _)| r.x - s.x <= near);
        match nearby.into_iter().find(|(s, _)| (s - r).norm() <= near) {
            Some((_, sum)) => *sum += f,
            None => distinct.push((r, f)),
        }
    }
    distinct
}

#[cfg(test)]
mod tests {
    use super::PointSet;
    use crate::{LimitSurface, MechanicsError, WrenchSet};
    use nalgebra::Vector2;
    use planar::{Shape, Twist, Wrench};

    fn set(points: &[(f64, f64, f64)]) -> PointSet {
        PointSet::new(points.iter().map(|p| (Vector2::new(p.0, p.1), p.2))).unwrap()
    }

    #[test]
    fn two_points_bear_what_a_hand_calculation_says() {
        let surface = set(&[(1.0, 0.0, 1.0), (-1.0, 0.0, 1.0)]);
        // A turn about the middle: 1 N at 1 m each, forces opposite.
        let turn = surface.wrench(&Twist::new(0.0, 0.0, 1.0)).unwrap();
        assert!((turn - Wrench::new(0.0, 0.0, 2.0)).to_vector().norm() < 1e-15);
        // About (0, 1) the velocities are (1, ±1): forces (1, ±1)/√2, moments 1/√2 each.
        let about = surface.wrench(&Twist::new(1.0, 0.0, 1.0)).unwrap();
        let s = 0.5_f64.sqrt();
        assert!((about - Wrench::new(2.0 * s, 0.0, 2.0 * s)).to_vector().norm() < 1e-15);
        assert!((surface.level(&about).unwrap() - 1.0).abs() < 1e-13);
        let motion = surface.twist(&about).unwrap();
        assert!((motion.linear.x / motion.angular - 1.0).abs() < 1e-9, "{motion:?}");
    }

    #[test]
    fn a_turn_about_one_of_two_points_leaves_a_facet() {
        let surface = set(&[(1.0, 0.0, 1.0), (-1.0, 0.0, 2.0)]);
        let set = surface.wrenches(&Twist::new(0.0, -1.0, 1.0)).unwrap();
        let center = Wrench::new(0.0, -2.0, 2.0);
        assert_eq!(set, WrenchSet::Disc { center, at: Vector2::new(1.0, 0.0), radius: 1.0 });
        assert!(surface.facets().iter().any(|f| f.center == center && f.radius == 1.0));
    }

    #[test]
    fn each_of_three_points_has_two_facets_whose_loads_turn_the_object_about_it() {
        let surface = set(&[(0.0, 0.1, 1.0), (-0.08, -0.05, 1.5), (0.09, -0.04, 0.7)]);
        let facets = surface.facets();
        assert_eq!(facets.len(), 6);
        for facet in facets {
            for (angle, fraction) in [(0.3, 0.0), (1.0, 0.5), (4.0, 0.9)] {
                let (sin, cos) = f64::sin_cos(angle);
                let force = fraction * facet.radius * Vector2::new(cos, sin);
                let load = facet.center + Wrench::from_force_at(&force, &facet.at);
                assert!((surface.level(&load).unwrap() - 1.0).abs() < 1e-13);
                let twist = surface.twist(&load).unwrap();
                let turn = twist.angular.abs() * facet.normal;
                assert!((turn - twist).to_vector().norm() < 1e-12);
                let undecided = surface.wrenches(&twist).unwrap();
                assert!(matches!(undecided, WrenchSet::Disc { at, .. } if at == facet.at));
            }
        }
    }

    #[test]
    fn points_on_a_line_have_an_edge_whose_loads_are_level_one() {
        let surface = set(&[(-1.0, 0.0, 1.0), (0.0, 0.0, 1.0), (1.0, 0.0, 1.0)]);
        // Every turn about a point beyond x = 1 pushes all three points along y.
        let edge = Wrench::new(0.0, -3.0, 0.0);
        for center in [1.5, 2.0, 7.0] {
            let wrench = surface.wrench(&Twist::new(0.0, -center, 1.0)).unwrap();
            assert!((wrench - edge).to_vector().norm() < 1e-14);
        }
        assert!((surface.level(&edge).unwrap() - 1.0).abs() < 1e-13);
        assert!((edge.power(&surface.twist(&edge).unwrap()) - 1.0).abs() < 1e-13);
    }

    #[test]
    fn coincident_points_are_one_that_bears_their_sum() {
        let twice = set(&[(0.1, 0.0, 1.0), (-0.1, 0.0, 1.0), (0.1, 0.0, 0.5)]);
        let once = set(&[(-0.1, 0.0, 1.0), (0.1, 0.0, 1.5)]);
        assert_eq!(twice, once);
        let heap = PointSet::new([(Vector2::new(0.1, 0.2), 1.0); 3]);
        assert_eq!(heap, Err(MechanicsError::TooFewPoints { distinct: 1 }));
        assert_eq!(PointSet::new([]), Err(MechanicsError::TooFewPoints { distinct: 0 }));
    }

    #[test]
    fn a_point_nowhere_or_without_friction_is_refused() {
        let set = |x, f| PointSet::new([(Vector2::zeros(), 1.0), (Vector2::new(x, 0.0), f)]);
        assert!(matches!(set(f64::INFINITY, 1.0), Err(MechanicsError::NotFinite { .. })));
        assert!(matches!(set(0.1, 0.0), Err(MechanicsError::NotPositive { .. })));
    }

    #[test]
    fn a_fine_grid_has_the_closed_form_moment_of_the_square() {
        let square = Shape::square(0.09).unwrap();
        let exact = 2.0 * square.mean_distance(&Vector2::zeros());
        let error = |n: usize| {
            let grid = PointSet::sampling(&square, 2.0, n).unwrap();
            grid.dissipation(&Twist::new(0.0, 0.0, 1.0)).unwrap() / exact - 1.0
        };
        // The midpoint rule is of second order in the cell's side.
        let ratio = error(900) / error(3600);
        assert!((ratio - 4.0).abs() < 0.2, "{ratio}");
        assert!(error(3600).abs() < 2e-4);
    }
}
