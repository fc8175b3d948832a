//! What follows from where an object rests, whatever the places are.

use nalgebra::Vector2;

use crate::{Object, Spot};

/// The two numbers of a pressure that pushes show best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupportSummary {
    /// Center of friction: of all pressure, in m, frame of the outline.
    pub center_of_friction_o: Vector2<f64>,
    /// Mean distance c of the pressure from there, in m: the largest moment of friction about it over
    /// the largest force.
    pub mean_distance: f64,
}

impl Object {
    /// Of spots, and of what they leave of the weight, spread evenly over the area. Shares of more than
    /// 1 in all are in proportion.
    pub fn support_summary(&self, spots: &[Spot]) -> SupportSummary {
        let total: f64 = spots.iter().map(|spot| spot.share).sum();
        let (whole, rest) = (total.max(1.0), (1.0 - total).max(0.0));
        let arm = |spot: &Spot| spot.share / whole * spot.place_o;
        let center = rest * self.centroid() + spots.iter().map(arm).sum::<Vector2<f64>>();
        let distance = |spot: &Spot| {
            let spin = spot.radius * std::f64::consts::FRAC_1_SQRT_2;
            spot.share / whole * (spot.place_o - center).norm().hypot(spin)
        };
        let of_area = if rest > 0.0 { rest * self.shape().mean_distance(&center) } else { 0.0 };
        let mean_distance = of_area + spots.iter().map(distance).sum::<f64>();
        SupportSummary { center_of_friction_o: center, mean_distance }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use nalgebra::Vector2;
    use planar::Shape;

    use crate::{Effect, Object, PressureMap, Spot};

    #[test]
    fn a_pressure_is_told_by_its_center_and_mean_distance() {
        let shape = Arc::new(Shape::rectangle(0.09, 0.09).unwrap());
        let object = Object::uniform(shape, 1.0).unwrap();
        let bare = object.support_summary(&[]);
        assert_eq!(bare.center_of_friction_o, *object.centroid());
        assert!((bare.mean_distance / object.mean_distance() - 1.0).abs() < 1e-9);
        let spot =
            |x: f64, y: f64, share: f64| Spot { place_o: Vector2::new(x, y), share, radius: 1e-6 };
        // 3–4–5: feet at 30 and 40 mm from their center.
        let two = object.support_summary(&[spot(0.0, 0.04, 3.0), spot(0.0, -0.03, 4.0)]);
        assert!(two.center_of_friction_o.norm() < 1e-15, "{two:?}");
        assert!((two.mean_distance - 0.24 / 7.0).abs() < 1e-9, "{two:?}");
        // Half on one place, half on the area about a center between.
        let half = object.support_summary(&[spot(0.02, 0.0, 0.5)]);
        assert!((half.center_of_friction_o.x - 0.01).abs() < 1e-15);
        let of_area = object.shape().mean_distance(&Vector2::new(0.01, 0.0));
        assert!((half.mean_distance - 0.5 * (0.01 + of_area)).abs() < 1e-9, "{half:?}");
    }

    #[test]
    fn even_cells_are_even_pressure() {
        let object = Object::uniform(Arc::new(Shape::rectangle(0.09, 0.09).unwrap()), 1.0).unwrap();
        let n = PressureMap.info().parameters.len();
        let mut spots = Vec::new();
        PressureMap.spots(&vec![1.0 / n as f64; n], &object, &mut spots);
        let found = object.support_summary(&spots);
        assert!(found.center_of_friction_o.norm() < 1e-9);
        assert!((found.mean_distance / object.mean_distance() - 1.0).abs() < 0.02, "{found:?}");
    }
}
