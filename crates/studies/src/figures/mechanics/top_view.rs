//! The thesis' square from above, with its pusher, in panels in mm.

use anyhow::Result;
use mechanics::{Push, Pusher};
use nalgebra::{UnitVector2, Vector2};
use planar::{Pose, Shape};
use report::{Arrows, Axis, Color, Ellipse, Panel, Polygon};

/// Side of the square, in m.
pub(crate) const SIDE: f64 = 0.09;
/// The thesis' pusher.
pub(crate) const PUSHER: Pusher = Pusher { radius: 0.00475, friction: 0.25 };
/// Speed of the pusher, in m/s.
pub(crate) const SPEED: f64 = 0.02;

/// Range of an axis, in mm.
pub(crate) type Range = (f64, f64);

/// A push on the edge at −x, `y` above its middle in m, turned by `beta` in rad from the normal.
pub(crate) fn push(y: f64, beta: f64) -> Push {
    Push {
        p_sc: Vector2::new(-0.5 * SIDE, y),
        normal_s: Vector2::x_axis(),
        v_wp_s: SPEED * Vector2::new(beta.cos(), beta.sin()),
        friction: PUSHER.friction,
    }
}

/// A panel with equal units and the square at rest.
pub(crate) fn panel(title: &str, x: Range, y: Range) -> Result<Panel> {
    let square = outline(&Pose::default())?.fill(Color::LIGHT, 0.55);
    let (x, y) = (Axis::new("x / mm").range(x.0, x.1), Axis::new("y / mm").range(y.0, y.1));
    Ok(Panel::new(x, y).title(title).equal_aspect().with(square))
}

/// The outline of the square at a pose.
pub(crate) fn outline(pose_ws: &Pose) -> Result<Polygon> {
    let corners = Shape::square(SIDE)?.outline(1);
    let corners: Vec<_> = corners.iter().map(|p| in_mm(&pose_ws.transform_point(p))).collect();
    Ok(Polygon::new(&corners))
}

/// The pusher that touches at the push's contact.
pub(crate) fn pusher(push: &Push) -> Ellipse {
    Ellipse::circle(in_mm(&pusher_center(push)), 1e3 * PUSHER.radius).fill(Color::GRAY, 0.6)
}

/// Center of the pusher that touches at the push's contact, in m.
pub(crate) fn pusher_center(push: &Push) -> Vector2<f64> {
    push.p_sc - PUSHER.radius * push.normal_s.into_inner()
}

/// The sector between two directions, `length` mm long.
pub(crate) fn cone(
    apex: &Vector2<f64>,
    [left, right]: &[UnitVector2<f64>; 2],
    length: f64,
) -> Polygon {
    const STEPS: i32 = 24;
    let opening = left.angle(right);
    let on_rim = |k: i32| {
        let turned = nalgebra::Rotation2::new(opening * f64::from(k) / f64::from(STEPS));
        in_mm(&(apex + 1e-3 * length * (turned * right.into_inner())))
    };
    Polygon::new(&[vec![in_mm(apex)], (0..=STEPS).map(on_rim).collect()].concat())
}

/// An arrow for a vector at a point; `scale` is mm drawn for a unit of the vector.
pub(crate) fn arrow(at: &Vector2<f64>, vector: &Vector2<f64>, scale: f64) -> Arrows {
    Arrows::new(&[in_mm(at)], &[[vector.x, vector.y]]).scale(scale).width(2.2)
}

pub(crate) fn in_mm(point: &Vector2<f64>) -> [f64; 2] {
    [1e3 * point.x, 1e3 * point.y]
}
