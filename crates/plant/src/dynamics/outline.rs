//! The true outline of an object, worn as it may be, and where a round tip touches it.

use nalgebra::Vector2;
use planar::{Shape, cross, perpendicular};

use crate::PlantError;
use crate::truth::Wear;

/// Tangent of half of the turn below which a vertex is a point of a curve.
const SLIGHT: f64 = 0.2;
/// Largest radius of the arc there, in m.
const CURVE_RADIUS: f64 = 0.03;

/// An outline in the body frame B.
#[derive(Clone, Debug)]
pub(crate) enum Outline {
    Sides(Vec<Side>),
    Ellipse { a: f64, b: f64 },
}

/// A straight side and the round corner that follows it.
#[derive(Clone, Debug)]
pub(crate) struct Side {
    from: Vector2<f64>,
    to: Vector2<f64>,
    /// Unit normal out of the object.
    outward: Vector2<f64>,
    corner: Option<Corner>,
}

/// The arc that rounds a vertex.
#[derive(Clone, Copy, Debug)]
struct Corner {
    center: Vector2<f64>,
    radius: f64,
    /// Normal out of the object at the arc's end.
    end: Vector2<f64>,
    /// Whether the arc is a hollow, with its center outside of the object.
    is_hollow: bool,
}

/// Where a round tip touches or would touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Touch {
    /// Nearest point of the outline, in m.
    pub(crate) point: Vector2<f64>,
    /// Unit normal into the object.
    pub(crate) normal: Vector2<f64>,
    /// Distance of the tip's surface from the outline, in m; negative if they overlap.
    pub(crate) gap: f64,
}

impl Outline {
    /// The outline of a shape after wear.
    ///
    /// # Errors
    /// `Wear` if the shape has no such corner, or no room for it.
    pub(crate) fn new(shape: &Shape, wear: &Wear) -> Result<Self, PlantError> {
        match shape {
            Shape::Polygon(polygon) => {
                let vertices = chipped(polygon.vertices(), wear)?;
                Ok(Self::Sides(rounded(&vertices, wear)?))
            }
            Shape::Ellipse(ellipse) => {
                if wear.corner_radius > 0.0 || wear.chip_size > 0.0 {
                    let what = "an ellipse has no corner to round or to chip".into();
                    return Err(PlantError::Wear { what });
                }
                let (a, b) = ellipse.semi_axes();
                Ok(Self::Ellipse { a, b })
            }
        }
    }

    /// Where a tip outside of the object is nearest to it.
    pub(crate) fn touch(&self, center: &Vector2<f64>, radius: f64) -> Touch {
        match self {
            Self::Ellipse { a, b } => {
                let point = nearest_on_ellipse(*a, *b, center);
                let outward = Vector2::new(point.x / (a * a), point.y / (b * b)).normalize();
                let gap = (center - point).dot(&outward) - radius;
                Touch { point, normal: -outward, gap }
            }
            Self::Sides(sides) => {
                let mut nearest: Option<Touch> = None;
                for touch in sides.iter().flat_map(|side| side.touches(center)) {
                    if nearest.is_none_or(|best| touch.gap.abs() < best.gap.abs()) {
                        nearest = Some(touch);
                    }
                }
                let mut touch = nearest.expect("an outline has at least three sides");
                touch.gap -= radius;
                touch
            }
        }
    }
}

impl Side {
    /// Nearest points of the side and of its corner, the gap that of the tip's center.
    fn touches(&self, center: &Vector2<f64>) -> impl Iterator<Item = Touch> + use<> {
        let along = self.to - self.from;
        let share = (center - self.from).dot(&along) / along.norm_squared();
        let side = if (0.0..=1.0).contains(&share) {
            let point = self.from + share * along;
            let gap = (center - self.from).dot(&self.outward);
            Touch { point, normal: -self.outward, gap }
        } else {
            let point = if share < 0.0 { self.from } else { self.to };
            let distance = (point - center).norm();
            // The tip of a point that is just there has the side's normal.
            let normal = if distance > 0.0 { (point - center) / distance } else { -self.outward };
            Touch { point, normal, gap: distance }
        };
        let corner = self.corner.and_then(|corner| corner.touch(&self.outward, center));
        std::iter::once(side).chain(corner)
    }
}

impl Corner {
    /// Nearest point of the arc, if it has one, the gap that of the tip's center.
    fn touch(&self, start: &Vector2<f64>, tip: &Vector2<f64>) -> Option<Touch> {
        let side = if self.is_hollow { -1.0 } else { 1.0 };
        let away = tip - self.center;
        let distance = away.norm();
        let outward = side / distance * away;
        let within =
            side * cross(start, &outward) >= 0.0 && side * cross(&outward, &self.end) >= 0.0;
        (within && distance > 0.0).then(|| Touch {
            point: self.center + self.radius / distance * away,
            normal: -outward,
            gap: side * (distance - self.radius),
        })
    }
}

/// The vertices with one of them cut off.
fn chipped(vertices: &[Vector2<f64>], wear: &Wear) -> Result<Vec<Vector2<f64>>, PlantError> {
    if wear.chip_size == 0.0 {
        return Ok(vertices.to_vec());
    }
    let n = vertices.len();
    let k = wear.chip_vertex;
    let Some(&vertex) = vertices.get(k) else {
        let what = format!("vertex {k} cannot be chipped, the shape has vertices 0 to {}", n - 1);
        return Err(PlantError::Wear { what });
    };
    let ends = [vertices[(k + n - 1) % n], vertices[(k + 1) % n]].map(|other| {
        let along = other - vertex;
        (wear.chip_size < 0.5 * along.norm()).then(|| vertex + wear.chip_size * along.normalize())
    });
    let [Some(before), Some(after)] = ends else {
        let size = wear.chip_size;
        let what = format!("a chip of {size} m is longer than half of a side at vertex {k}");
        return Err(PlantError::Wear { what });
    };
    let mut kept = vertices.to_vec();
    kept.splice(k..=k, [before, after]);
    Ok(kept)
}

/// The sides of a polygon whose convex corners have a radius.
///
/// Where sides meet at a slight turn they are taken for a curve drawn by points, which gets an arc
/// there, to either side: a tip touches one place of it at a time, and rolls on smoothly.
fn rounded(vertices: &[Vector2<f64>], wear: &Wear) -> Result<Vec<Side>, PlantError> {
    let radius = wear.corner_radius;
    let n = vertices.len();
    let outward = |i: usize| -perpendicular(&(vertices[(i + 1) % n] - vertices[i])).normalize();
    let length = |i: usize| (vertices[(i + 1) % n] - vertices[i]).norm();
    // Radius of the arc at vertex i, negative for a hollow, and what it takes from either side:
    // radius times tan(half of its turn).
    let arc = |i: usize| {
        let before = (i + n - 1) % n;
        let (last, next) = (outward(before), outward(i));
        let turn = cross(&last, &next);
        let tangent = turn.abs() / (1.0 + last.dot(&next));
        if tangent > 0.0 && tangent < SLIGHT {
            let taken = (0.4 * length(before).min(length(i))).min(CURVE_RADIUS * tangent);
            (taken / tangent * turn.signum(), taken)
        } else if turn > 0.0 {
            let room = 0.4 * length(before).min(length(i)) / tangent;
            let radius = radius.max(wear.edge_break.min(room));
            (radius, radius * tangent)
        } else {
            (0.0, 0.0)
        }
    };
    let arcs: Vec<_> = (0..n).map(arc).collect();
    let side = |i: usize| {
        let (next, length) = ((i + 1) % n, length(i));
        let ((_, taken), (signed, next_taken)) = (arcs[i], arcs[next]);
        if taken + next_taken > length {
            let what =
                format!("side {i} of {length} m has no room for corners of radius {radius} m");
            return Err(PlantError::Wear { what });
        }
        let along = (vertices[next] - vertices[i]) / length;
        let (from, to) = (vertices[i] + taken * along, vertices[next] - next_taken * along);
        let corner = (next_taken > 0.0).then(|| Corner {
            center: to - signed * outward(i),
            radius: signed.abs(),
            end: outward(next),
            is_hollow: signed < 0.0,
        });
        Ok(Side { from, to, outward: outward(i), corner })
    };
    (0..n).map(side).collect()
}

/// The point of an ellipse that is nearest to a point outside of it or near it.
///
/// The outline is replaced by its circle of curvature at the latest guess, over and over; only
/// square roots are needed.
fn nearest_on_ellipse(a: f64, b: f64, center: &Vector2<f64>) -> Vector2<f64> {
    let goal = Vector2::new(center.x.abs(), center.y.abs());
    // Cosine and sine of the ellipse's parameter.
    let mut guess = Vector2::new(goal.x / a, goal.y / b).normalize();
    for _ in 0..32 {
        let point = Vector2::new(a * guess.x, b * guess.y);
        let excess = a * a - b * b;
        let evolute = Vector2::new(
            excess / a * guess.x * guess.x * guess.x,
            -excess / b * guess.y * guess.y * guess.y,
        );
        let toward = (goal - evolute).normalize();
        let next = evolute + (point - evolute).norm() * toward;
        let next = Vector2::new((next.x / a).max(0.0), (next.y / b).max(0.0)).normalize();
        let change = (next - guess).norm_squared();
        guess = next;
        if change < 1e-32 {
            break;
        }
    }
    let sign = |value: f64| if value < 0.0 { -1.0 } else { 1.0 };
    Vector2::new(a * guess.x * sign(center.x), b * guess.y * sign(center.y))
}

#[cfg(test)]
mod tests {
    use super::{Outline, Touch};
    use crate::truth::Wear;
    use nalgebra::Vector2;
    use planar::{Ellipse, MIT_NAMES, Shape, mit_object};
    use std::f64::consts::TAU;

    const RADIUS: f64 = 0.00475;

    fn touch(shape: &Shape, wear: Wear, x: f64, y: f64) -> Touch {
        Outline::new(shape, &wear).unwrap().touch(&Vector2::new(x, y), RADIUS)
    }

    #[test]
    fn a_new_outline_is_touched_where_the_geometry_of_the_shape_says() {
        for name in MIT_NAMES {
            let shape = mit_object(name).unwrap().shape;
            let outline = Outline::new(&shape, &Wear::default()).unwrap();
            for k in 0..97 {
                let angle = TAU * f64::from(k) / 97.0;
                let center = 0.09 * Vector2::new(angle.cos(), angle.sin());
                let (ours, theirs) =
                    (outline.touch(&center, RADIUS), shape.contact(&center, RADIUS));
                // Arcs smooth the butterfly, which is drawn by points.
                let tolerance = if name == "butter" { 7e-5 } else { 1e-10 };
                assert!((ours.gap - theirs.gap).abs() < tolerance, "{name} {k}");
                assert!((center + (ours.gap + RADIUS) * ours.normal - ours.point).norm() < 1e-9);
            }
        }
    }

    #[test]
    fn a_thin_ellipse_is_touched_along_its_normal() {
        let shape = Shape::Ellipse(Ellipse::new(0.08, 0.02).unwrap());
        for (x, y) in [(0.085, 0.001), (0.01, 0.026), (-0.07, -0.02), (0.0, 0.025), (0.09, 0.0)] {
            let ours = touch(&shape, Wear::default(), x, y);
            let theirs = shape.contact(&Vector2::new(x, y), RADIUS);
            assert!((ours.point - theirs.point).norm() < 1e-9, "{ours:?} {theirs:?}");
        }
    }

    #[test]
    fn a_round_corner_is_touched_on_its_circle() {
        let square = Shape::square(0.09).unwrap();
        let wear = Wear { corner_radius: 0.005, ..Wear::default() };
        let round = touch(&square, wear, 0.05, 0.05);
        let outward = Vector2::new(1.0, 1.0).normalize();
        assert!((round.normal + outward).norm() < 1e-12);
        assert!((round.point - Vector2::new(0.04, 0.04) - 0.005 * outward).norm() < 1e-12);
        let (worn, new) =
            (touch(&square, wear, 0.05, 0.02), touch(&square, Wear::default(), 0.05, 0.02));
        assert!((worn.point - new.point).norm() < 1e-15 && worn.normal == new.normal);
    }

    #[test]
    fn a_chip_makes_a_side_of_its_own() {
        let square = Shape::square(0.09).unwrap();
        let wear = Wear { chip_vertex: 0, chip_size: 0.01, ..Wear::default() };
        let chip = touch(&square, wear, 0.045, 0.045);
        assert!((chip.point - Vector2::new(0.04, 0.04)).norm() < 1e-12);
        assert!((touch(&square, wear, -0.05, 0.05).point.x + 0.045).abs() < 1e-12);
    }

    #[test]
    fn a_curve_drawn_by_points_is_touched_smoothly() {
        let butterfly = Outline::new(&mit_object("butter").unwrap().shape, &Wear::default());
        let butterfly = butterfly.unwrap();
        let turns = (0..400).map(|k| {
            let y = -0.01 + 5e-5 * f64::from(k);
            butterfly.touch(&Vector2::new(-0.0323, y), RADIUS).normal
        });
        let normals: Vec<_> = turns.collect();
        // The tightest hollow leaves the tip's center 2.9 mm to turn about, in steps of 0.05 mm.
        assert!(normals.windows(2).all(|pair| (pair[1] - pair[0]).norm() < 0.02));
    }

    #[test]
    fn wear_without_room_is_refused() {
        let square = Shape::square(0.09).unwrap();
        let disc = mit_object("ellip1").unwrap().shape;
        for (shape, wear, says) in [
            (&square, Wear { corner_radius: 0.05, ..Wear::default() }, "no room"),
            (&square, Wear { chip_size: 0.05, ..Wear::default() }, "half of a side"),
            (&square, Wear { chip_size: 0.01, chip_vertex: 4, ..Wear::default() }, "0 to 3"),
            (&disc, Wear { corner_radius: 0.001, ..Wear::default() }, "no corner"),
        ] {
            let message = Outline::new(shape, &wear).unwrap_err().to_string();
            assert!(message.contains(says), "{message}");
        }
    }
}
