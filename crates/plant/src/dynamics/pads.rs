//! The support under an object as small pads.

use libm::{exp, sincos};
use nalgebra::{Matrix3, Vector2, Vector3};
use planar::{Shape, cross};
use std::f64::consts::TAU;

use crate::PlantError;
use crate::truth::Feet;

/// Pads are handled in groups of this many, side by side in vector registers.
pub(crate) const LANES: usize = 4;

const ELLIPSE_VERTICES: usize = 720;
const MAX_ITERATIONS: usize = 40;
const BISECTIONS: usize = 60;

/// Of the way from the center to the outline the rim begins here.
const INSIDE_RIM: f64 = 0.75;
/// Radius of gyration of a foot, in m.
const FOOT: f64 = 1e-3;

/// The pads of one support, each a small plate that slides and turns with the object.
///
/// A pad of an area's cell has the cell's share of the area, its centroid, and half the square of
/// its radius of gyration as spin: a pad under the velocity v and the turn ω dissipates
/// load·√(|v|² + spin·ω²), which is exact to third order in the cell's size away from the center
/// of rotation. Area, centroid and second moment of the outline are exact for any number of pads.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pads {
    /// Place in the body frame B, in m. All columns are padded with loads of 0 to whole groups.
    pub(crate) x: Vec<f64>,
    pub(crate) y: Vec<f64>,
    /// Squared radius with which a pad resists turning in place, in m².
    pub(crate) spin: Vec<f64>,
    /// Share of the object's weight, 1 in all.
    pub(crate) share: Vec<f64>,
}

impl Pads {
    /// About `n` pads of equal area under the shape, their load uniform.
    pub(crate) fn uniform(shape: &Shape, n: usize) -> Self {
        let vertices = match shape {
            Shape::Polygon(polygon) => polygon.vertices().to_vec(),
            Shape::Ellipse(ellipse) => {
                let (a, b) = ellipse.semi_axes();
                let vertex = |k: usize| {
                    let (sin, cos) = sincos(TAU * k as f64 / ELLIPSE_VERTICES as f64);
                    Vector2::new(a * cos, b * sin)
                };
                (0..ELLIPSE_VERTICES).map(vertex).collect()
            }
        };
        let bound = |axis: usize, pick: fn(f64, f64) -> f64| {
            vertices.iter().map(|v| v[axis]).reduce(pick).unwrap_or_default()
        };
        let low = Vector2::new(bound(0, f64::min), bound(1, f64::min));
        let extent = Vector2::new(bound(0, f64::max), bound(1, f64::max)) - low;
        let side = (shape.area() / n as f64).sqrt();
        let counts = extent.map(|length| (length / side).round().max(1.0));
        let cell = extent.component_div(&counts);
        let mut pads = Self { x: vec![], y: vec![], spin: vec![], share: vec![] };
        let mut area = 0.0;
        for i in 0..counts.x as usize {
            let column = strip(&vertices, 0, low.x + i as f64 * cell.x, cell.x);
            for j in 0..counts.y as usize {
                let piece = strip(&column, 1, low.y + j as f64 * cell.y, cell.y);
                let center =
                    low + cell.component_mul(&Vector2::new(i as f64 + 0.5, j as f64 + 0.5));
                if let Some(moments) = Moments::of(&piece, center) {
                    pads.push(moments.centroid, 0.5 * moments.gyration, moments.area);
                    area += moments.area;
                }
            }
        }
        pads.share.iter_mut().for_each(|share| *share /= area);
        pads.fill_group();
        pads
    }

    /// The mean place of the load, in m, frame B.
    pub(crate) fn center(&self) -> Vector2<f64> {
        self.sum(|x, y, _| Vector3::new(x, y, 0.0)).xy()
    }

    /// The mean distance of the load from a point, spin included, in m: the characteristic length.
    pub(crate) fn mean_distance(&self, about: &Vector2<f64>) -> f64 {
        let distance = |x: f64, y: f64, spin: f64| {
            let (dx, dy) = (x - about.x, y - about.y);
            Vector3::new((dx * dx + dy * dy + spin).sqrt(), 0.0, 0.0)
        };
        self.sum(distance).x
    }

    /// The same pads with their loads moved: the center by `shift` (m), the mean distance from it
    /// times `ratio`.
    ///
    /// The loads are multiplied by exp(g·r + a r²), which keeps them positive, with g and a found
    /// by Newton's method.
    ///
    /// # Errors
    /// `Pressure` if no such loads are found.
    pub(crate) fn reshaped(&self, shift: &Vector2<f64>, ratio: f64) -> Result<Self, PlantError> {
        if *shift == Vector2::zeros() && ratio == 1.0 {
            return Ok(self.clone());
        }
        let center = self.center();
        let length = self.mean_distance(&center);
        let goal = center + shift;
        let miss = |pads: &Self| {
            let off = (pads.center() - goal) / length;
            Vector3::new(off.x, off.y, pads.mean_distance(&goal) / length - ratio)
        };
        let mut exponents = Vector3::zeros();
        let mut reached = miss(self);
        for _ in 0..MAX_ITERATIONS {
            if reached.amax() < 1e-13 {
                return Ok(self.weighted(&center, length, &exponents));
            }
            const STEP: f64 = 1e-6;
            let column = |k: usize| {
                let mut moved = exponents;
                moved[k] += STEP;
                (miss(&self.weighted(&center, length, &moved)) - reached) / STEP
            };
            let jacobian = Matrix3::from_columns(&[column(0), column(1), column(2)]);
            let Some(inverse) = jacobian.try_inverse() else { break };
            let step = inverse * reached;
            exponents -= step / step.amax().max(1.0);
            reached = miss(&self.weighted(&center, length, &exponents));
            if !reached.amax().is_finite() {
                break;
            }
        }
        if reached.amax() < 1e-9 {
            return Ok(self.weighted(&center, length, &exponents));
        }
        Err(PlantError::Pressure { shift: [shift.x, shift.y], ratio })
    }

    /// The same load with all but `patch_share` of it on one plate that dissipates like an
    /// ellipsoid: load·√(|v|² + c²ω²) at the load's center, c the mean distance.
    pub(crate) fn blended(&self, patch_share: f64) -> Self {
        let mut pads = self.clone();
        if patch_share < 1.0 {
            let center = self.center();
            let c = self.mean_distance(&center);
            pads.share.iter_mut().for_each(|share| *share *= patch_share);
            pads.push(center, c * c, 1.0 - patch_share);
            pads.fill_group();
        }
        pads
    }

    /// The same with a share of the load near the outline, spread there as it was.
    pub(crate) fn rimmed(&self, shape: &Shape, rim_share: f64) -> Self {
        let mut pads = self.clone();
        if rim_share == 0.0 {
            return pads;
        }
        let center = self.center();
        let is_rim = |i: usize| {
            let outward = Vector2::new(self.x[i], self.y[i]) - center;
            !shape.contains(&(center + outward / INSIDE_RIM))
        };
        let of_rim = |i: usize| if is_rim(i) { self.share[i] } else { 0.0 };
        let rim: Vec<f64> = (0..self.share.len()).map(of_rim).collect();
        let total: f64 = rim.iter().sum();
        for (share, rim) in pads.share.iter_mut().zip(rim) {
            *share = (1.0 - rim_share) * *share + rim_share * rim / total;
        }
        pads
    }

    /// The same with a share of the load on three feet about the center of mass, which are moved by `shift`
    /// (m) and, from there, by the factor `ratio`.
    ///
    /// # Errors
    /// `Feet` for a center of mass that is not under the outline, which no such feet balance.
    pub(crate) fn on_feet(
        &self,
        (feet, shape): (&Feet, &Shape),
        center_of_mass: &Vector2<f64>,
        (shift, ratio): (&Vector2<f64>, f64),
    ) -> Result<Self, PlantError> {
        let mut pads = self.clone();
        if feet.is_off() {
            return Ok(pads);
        }
        if !shape.contains(center_of_mass) {
            return Err(PlantError::Feet { center_of_mass: (*center_of_mass).into() });
        }
        pads.share.iter_mut().for_each(|share| *share *= 1.0 - feet.share);
        let arms = [0.0, 1.0, 2.0].map(|third| {
            let (sin, cos) = sincos(feet.direction + third * TAU / 3.0);
            let direction = Vector2::new(cos, sin);
            feet.reach * way_to_outline(shape, center_of_mass, &direction) * direction
        });
        // A third of a turn apart, forces balance where each times its arm is the same.
        let weights = arms.map(|arm| 1.0 / arm.norm());
        let whole: f64 = weights.iter().sum();
        for (arm, weight) in arms.into_iter().zip(weights) {
            let place = center_of_mass + shift + ratio * arm;
            pads.push(place, 0.5 * FOOT * FOOT, feet.share * weight / whole);
        }
        pads.fill_group();
        Ok(pads)
    }

    fn weighted(&self, center: &Vector2<f64>, length: f64, exponents: &Vector3<f64>) -> Self {
        let mut pads = self.clone();
        let mut total = 0.0;
        for i in 0..pads.share.len() {
            let (x, y) = ((pads.x[i] - center.x) / length, (pads.y[i] - center.y) / length);
            let exponent = exponents.x * x + exponents.y * y + exponents.z * (x * x + y * y);
            pads.share[i] *= exp(exponent);
            total += pads.share[i];
        }
        pads.share.iter_mut().for_each(|share| *share /= total);
        pads
    }

    fn sum(&self, value: impl Fn(f64, f64, f64) -> Vector3<f64>) -> Vector3<f64> {
        (0..self.share.len())
            .map(|i| self.share[i] * value(self.x[i], self.y[i], self.spin[i]))
            .sum()
    }

    fn push(&mut self, place: Vector2<f64>, spin: f64, share: f64) {
        self.x.push(place.x);
        self.y.push(place.y);
        self.spin.push(spin);
        self.share.push(share);
    }

    fn fill_group(&mut self) {
        while !self.share.len().is_multiple_of(LANES) {
            self.push(Vector2::zeros(), 0.0, 0.0);
        }
    }
}

/// Distance of the outline from a place under the object, in m.
fn way_to_outline(shape: &Shape, from: &Vector2<f64>, direction: &Vector2<f64>) -> f64 {
    let (mut inside, mut outside) = (0.0, 2.0 * shape.bounding_radius());
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (inside + outside);
        let end =
            if shape.contains(&(from + middle * direction)) { &mut inside } else { &mut outside };
        *end = middle;
    }
    inside
}

/// Area in m², centroid in m, and squared radius of gyration about it in m², of a cut-out cell.
struct Moments {
    area: f64,
    centroid: Vector2<f64>,
    gyration: f64,
}

impl Moments {
    fn of(outline: &[Vector2<f64>], near: Vector2<f64>) -> Option<Self> {
        let edges = outline.iter().zip(outline.iter().cycle().skip(1));
        let (mut area, mut first, mut second) = (0.0, Vector2::zeros(), 0.0);
        for (a, b) in edges {
            let (a, b) = (a - near, b - near);
            let twice = cross(&a, &b);
            area += twice / 2.0;
            first += twice / 6.0 * (a + b);
            second += twice / 12.0 * (a.dot(&a) + a.dot(&b) + b.dot(&b));
        }
        if area <= 0.0 {
            return None;
        }
        let mean = first / area;
        let gyration = (second / area - mean.dot(&mean)).max(0.0);
        Some(Self { area, centroid: near + mean, gyration })
    }
}

/// The part of an outline between two lines across an axis.
fn strip(outline: &[Vector2<f64>], axis: usize, from: f64, width: f64) -> Vec<Vector2<f64>> {
    let above = cut(outline, axis, |coordinate| coordinate - from);
    cut(&above, axis, |coordinate| from + width - coordinate)
}

/// The part of an outline on the side where `inside` is not negative.
fn cut(outline: &[Vector2<f64>], axis: usize, inside: impl Fn(f64) -> f64) -> Vec<Vector2<f64>> {
    let mut kept = Vec::with_capacity(outline.len() + 2);
    for (a, b) in outline.iter().zip(outline.iter().cycle().skip(1)) {
        let (at_a, at_b) = (inside(a[axis]), inside(b[axis]));
        if at_a >= 0.0 {
            kept.push(*a);
        }
        if (at_a >= 0.0) != (at_b >= 0.0) {
            kept.push(a + at_a / (at_a - at_b) * (b - a));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::{Feet, Pads};
    use crate::PlantError;
    use nalgebra::Vector2;
    use planar::{MIT_NAMES, Shape, mit_object};

    #[test]
    fn area_center_and_second_moment_of_every_shape_are_exact_for_few_pads() {
        for name in MIT_NAMES {
            let shape = mit_object(name).unwrap().shape;
            let centroid = shape.centroid();
            let exact = shape.second_moment(&centroid) / shape.area();
            let pads = Pads::uniform(&shape, 100);
            assert!((pads.share.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            assert!((pads.center() - centroid).norm() < 1e-9, "{name}");
            let second = pads.sum(|x, y, spin| {
                let r = Vector2::new(x, y) - centroid;
                nalgebra::Vector3::new(r.norm_squared() + 2.0 * spin, 0.0, 0.0)
            });
            // The ellipses are polygons of 720 vertices here.
            let tolerance = if name.starts_with("ellip") { 1e-4 } else { 1e-9 };
            assert!((second.x / exact - 1.0).abs() < tolerance, "{name}: {}", second.x / exact);
        }
    }

    #[test]
    fn the_mean_distance_is_that_of_the_area() {
        for name in MIT_NAMES {
            let shape = mit_object(name).unwrap().shape;
            let (pads, centroid) = (Pads::uniform(&shape, 400), shape.centroid());
            let ratio = pads.mean_distance(&centroid) / shape.mean_distance(&centroid);
            assert!((ratio - 1.0).abs() < 1e-4, "{name}: {ratio}");
        }
    }

    #[test]
    fn loads_are_reshaped_to_any_center_and_radius_and_stay_positive() {
        let pads = Pads::uniform(&Shape::square(0.09).unwrap(), 144);
        let c = pads.mean_distance(&Vector2::zeros());
        for (shift, ratio) in [((0.008, -0.004), 1.0), ((0.0, 0.0), 0.7), ((-0.01, 0.0), 1.15)] {
            let shift = Vector2::new(shift.0, shift.1);
            let moved = pads.reshaped(&shift, ratio).unwrap();
            assert!((moved.center() - shift).norm() < 1e-12);
            assert!((moved.mean_distance(&shift) / c - ratio).abs() < 1e-11);
            assert!(moved.share.iter().all(|share| *share > 0.0));
        }
        assert!(pads.reshaped(&Vector2::new(0.05, 0.0), 1.0).is_err());
        assert_eq!(pads.reshaped(&Vector2::zeros(), 1.0).unwrap(), pads);
    }

    #[test]
    fn feet_balance_the_object_and_lie_inside_it() {
        for name in MIT_NAMES {
            let shape = mit_object(name).unwrap().shape;
            let (center, feet) =
                (shape.centroid(), Feet { share: 1.0, reach: 0.8, direction: 0.5 });
            let pads = Pads::uniform(&shape, 100);
            let shift = Vector2::new(1e-3, -2e-3);
            let stood = pads.on_feet((&feet, &shape), &center, (&Vector2::zeros(), 1.0)).unwrap();
            assert!((stood.center() - center).norm() < 1e-12, "{name}");
            let bears = |k: &usize| stood.share[*k] > 0.0;
            let places: Vec<_> = (0..stood.share.len()).filter(bears).collect();
            assert_eq!(places.len(), 3);
            for k in places {
                assert!(shape.contains(&Vector2::new(stood.x[k], stood.y[k])), "{name}");
            }
            let moved = pads.on_feet((&feet, &shape), &center, (&shift, 1.1)).unwrap();
            assert!((moved.center() - center - shift).norm() < 1e-12, "{name}");
            let beside = Vector2::new(1.0, 0.0);
            let refused = pads.on_feet((&feet, &shape), &beside, (&shift, 1.0));
            assert!(matches!(refused, Err(PlantError::Feet { .. })), "{name}");
        }
    }

    #[test]
    fn a_rim_bears_what_is_said() {
        let shape = Shape::square(0.09).unwrap();
        let pads = Pads::uniform(&shape, 144);
        let (c, zero) = (pads.mean_distance(&Vector2::zeros()), Vector2::zeros());
        let rim = pads.rimmed(&shape, 1.0);
        assert!((rim.share.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(rim.center().norm() < 1e-12);
        // The mean distance of a thin frame from its center is 1.5 times the square's.
        let ratio = rim.mean_distance(&zero) / c;
        assert!((1.3..1.5).contains(&ratio), "{ratio}");
        assert_eq!(pads.rimmed(&shape, 0.0), pads);
    }
}
