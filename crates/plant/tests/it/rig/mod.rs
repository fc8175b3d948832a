//! A square on a table, and pushes of its left edge.

use dataset::ObjectSpec;
use nalgebra::Vector2;
use plant::{Numerics, Plant, TipPath, Truth};

/// The nominal tip's radius, in m.
pub(crate) const RADIUS: f64 = 0.00475;
/// Half of the square's side, in m.
pub(crate) const HALF: f64 = 0.045;

/// The 90 mm square with a truth.
pub(crate) fn square(truth: &Truth) -> Plant {
    square_with(truth, &Numerics::default())
}

/// The same, simulated more finely or coarsely.
pub(crate) fn square_with(truth: &Truth, numerics: &Numerics) -> Plant {
    let object = ObjectSpec::mit("rect1").expect("a known object");
    Plant::new(&object, truth, 9.81, numerics).expect("a possible rig")
}

/// A push of the left edge at height `y` (m), at an angle (rad) from the inward normal.
pub(crate) fn push(y: f64, angle: f64, speed: f64, travel: f64) -> TipPath {
    let direction = Vector2::new(angle.cos(), angle.sin());
    let acceleration = 10.0;
    let approach = 0.004_f64.max(0.5 * speed * speed / acceleration + 0.002);
    let start = Vector2::new(-HALF - RADIUS, y) - approach * direction;
    TipPath {
        start: start.into(),
        direction: direction.into(),
        length: approach + travel,
        speed,
        acceleration,
        wait: 0.1,
        hold: 0.3,
    }
}
