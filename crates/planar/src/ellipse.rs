//! Ellipses and discs, centered on their frame.

use crate::PlanarError;
use nalgebra::Vector2;
use std::f64::consts::{PI, TAU};

/// An ellipse about the origin, its axes along x and y, in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse {
    semi_x: f64,
    semi_y: f64,
    perimeter: f64,
}

impl Ellipse {
    /// An ellipse from its semi-axes along x and y, in m.
    ///
    /// # Errors
    /// `NotPositive` for a semi-axis that is not positive and finite.
    pub fn new(semi_x: f64, semi_y: f64) -> Result<Self, PlanarError> {
        for (name, value) in [("semi-axis along x", semi_x), ("semi-axis along y", semi_y)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(PlanarError::NotPositive { name, value });
            }
        }
        Ok(Self { semi_x, semi_y, perimeter: perimeter(semi_x, semi_y) })
    }

    /// A disc from its radius, in m.
    ///
    /// # Errors
    /// `NotPositive` for a radius that is not positive and finite.
    pub fn disc(radius: f64) -> Result<Self, PlanarError> {
        Self::new(radius, radius)
    }

    /// The semi-axes along x and y, in m.
    pub fn semi_axes(&self) -> (f64, f64) {
        (self.semi_x, self.semi_y)
    }

    /// Area πab, in m².
    pub fn area(&self) -> f64 {
        PI * self.semi_x * self.semi_y
    }

    /// Length of the outline, in m, exact to rounding.
    pub fn perimeter(&self) -> f64 {
        self.perimeter
    }

    /// ∫|r − about|² dA, the polar second moment of area, in m⁴.
    pub fn second_moment(&self, about: &Vector2<f64>) -> f64 {
        let own = 0.25 * (self.semi_x.powi(2) + self.semi_y.powi(2));
        self.area() * (own + about.norm_squared())
    }

    /// ∫|r − about| dA, in m³.
    ///
    /// About the center it is ab/3 times the perimeter. Elsewhere it is an integral over the
    /// direction of r from `about`, whose integrand is smooth and periodic inside the outline:
    /// the trapezoidal rule is doubled until two results agree to 10⁻¹³.
    pub fn distance_integral(&self, about: &Vector2<f64>) -> f64 {
        if *about == Vector2::zeros() {
            return self.semi_x * self.semi_y / 3.0 * self.perimeter();
        }
        let mut n = 64;
        let mut last = self.distance_sum(about, n);
        while n < 1 << 20 {
            n *= 2;
            let sum = self.distance_sum(about, n);
            if (sum - last).abs() <= 1e-13 * sum.abs() {
                return sum;
            }
            last = sum;
        }
        last
    }

    /// The outline at the angle ψ of its stretched circle, in m.
    pub fn at_parameter(&self, psi: f64) -> Vector2<f64> {
        Vector2::new(self.semi_x * psi.cos(), self.semi_y * psi.sin())
    }

    /// Whether `point` (m) lies inside or on the outline.
    pub fn contains(&self, point: &Vector2<f64>) -> bool {
        (point.x / self.semi_x).powi(2) + (point.y / self.semi_y).powi(2) <= 1.0
    }

    /// Outline parameter ψ of the point that is nearest to `point` (m), in (−π, π].
    ///
    /// Newton's method from the parameter of the point itself, kept within the one quadrant that
    /// holds it by bisection: exact for every point, inside and on the axes.
    pub fn nearest_parameter(&self, point: &Vector2<f64>) -> f64 {
        let (ax, by) = (self.semi_x * point.x.abs(), self.semi_y * point.y.abs());
        let gap = self.semi_y.powi(2) - self.semi_x.powi(2);
        // Half the derivative of the squared distance, and its own derivative.
        let slopes = |psi: f64| {
            let (sin, cos) = psi.sin_cos();
            let slope = ax * sin - by * cos + gap * sin * cos;
            (slope, ax * cos + by * sin + gap * (cos * cos - sin * sin))
        };
        // What rounding leaves of a slope that is zero.
        let rounding = f64::EPSILON * (ax + by + gap.abs());
        let (mut low, mut high) = (0.0, 0.5 * PI);
        // Where the slope starts positive, the nearest point is on an axis.
        if slopes(f64::EPSILON).0 > 0.0 {
            high = 0.0;
        }
        let mut psi = (by * self.semi_x.powi(2)).atan2(ax * self.semi_y.powi(2)).min(high);
        while high - low > f64::EPSILON {
            let (slope, bend) = slopes(psi);
            if slope > 0.0 {
                high = psi
            } else {
                low = psi
            }
            let newton = psi - slope / bend;
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            let is_least = bend > 0.0 && slope.abs() <= rounding;
            if is_least || (next - psi).abs() <= f64::EPSILON {
                break;
            }
            psi = next;
        }
        let psi = if point.x < 0.0 { PI - psi } else { psi };
        if point.y < 0.0 { -psi } else { psi }
    }

    /// Arc length from the end of the +x axis to the parameter ψ in [0, 2π], in m.
    pub fn arc_length(&self, psi: f64) -> f64 {
        let quarter = 0.25 * self.perimeter();
        let quadrant = (psi / (0.5 * PI)).floor().clamp(0.0, 4.0);
        let rest = psi - quadrant * 0.5 * PI;
        let start = if (quadrant as u8).is_multiple_of(2) { 0.0 } else { 0.5 * PI };
        quadrant * quarter + self.arc_between(start, start + rest)
    }

    /// The parameter ψ in [0, 2π] at an arc length (m) from the end of the +x axis.
    pub fn parameter_at_length(&self, length: f64) -> f64 {
        let (mut low, mut high) = (0.0, TAU);
        while high - low > 1e-15 {
            let middle = 0.5 * (low + high);
            if middle == low || middle == high {
                break;
            }
            if self.arc_length(middle) < length { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }

    fn arc_between(&self, from: f64, to: f64) -> f64 {
        // The speed bends within about 1/aspect of an axis.
        let aspect = self.semi_x.max(self.semi_y) / self.semi_x.min(self.semi_y);
        let panels = (2.0 * aspect).ceil().clamp(3.0, 64.0) as u32;
        let half = 0.5 * (to - from) / f64::from(panels);
        // The nodes lie alike in all panels: sums of angles take few sines.
        let nodes = GAUSS_LEGENDRE.map(|(x, weight)| ((half * x).sin_cos(), weight));
        let squares = (self.semi_x.powi(2), self.semi_y.powi(2));
        let panel = |k: u32| -> f64 {
            let (sin, cos) = (from + f64::from(2 * k + 1) * half).sin_cos();
            let speed = |sin: f64, cos: f64| (squares.0 * sin * sin + squares.1 * cos * cos).sqrt();
            let pair = |((s, c), weight): &((f64, f64), f64)| {
                let after = speed(sin * c + cos * s, cos * c - sin * s);
                let before = speed(sin * c - cos * s, cos * c + sin * s);
                weight * (after + before)
            };
            nodes.iter().map(pair).sum()
        };
        half * (0..panels).map(panel).sum::<f64>()
    }

    /// ∮ of the radial integral over ψ: ∫|r − o| dA = ⅓ ∮ |R| (R × dR), R = outline − o.
    fn distance_sum(&self, about: &Vector2<f64>, n: usize) -> f64 {
        let step = TAU / n as f64;
        let sum: f64 = (0..n)
            .map(|k| {
                let (sin, cos) = (k as f64 * step).sin_cos();
                let r = Vector2::new(self.semi_x * cos, self.semi_y * sin) - about;
                let tangent = Vector2::new(-self.semi_x * sin, self.semi_y * cos);
                r.norm() * crate::cross(&r, &tangent)
            })
            .sum();
        sum * step / 3.0
    }
}

/// The positive nodes of the eight-point Gauss–Legendre rule on [−1, 1], each with the weight of it and
/// of its mirror image.
pub const GAUSS_LEGENDRE: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// Length of an ellipse's outline from its semi-axes, by the arithmetic-geometric mean.
fn perimeter(semi_x: f64, semi_y: f64) -> f64 {
    let (mut a, mut b) = (semi_x.max(semi_y), semi_x.min(semi_y));
    let mut sum = a * a;
    let mut weight = 0.5;
    sum -= weight * (a * a - b * b);
    while a - b > 4.0 * f64::EPSILON * a {
        let half_gap = 0.5 * (a - b);
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
        weight *= 2.0;
        sum -= weight * half_gap * half_gap;
    }
    TAU * sum / a
}

#[cfg(test)]
mod tests {
    use super::Ellipse;
    use nalgebra::Vector2;
    use std::f64::consts::{PI, TAU};

    #[test]
    fn a_disc_has_the_perimeter_and_mean_distance_of_a_circle() {
        let disc = Ellipse::disc(0.5).unwrap();
        assert!((disc.perimeter() - PI).abs() < 1e-15);
        let mean = disc.distance_integral(&Vector2::zeros()) / disc.area();
        assert!((mean - 2.0 / 3.0 * 0.5).abs() < 1e-16);
        assert!((disc.second_moment(&Vector2::zeros()) - PI * 0.5_f64.powi(4) / 2.0).abs() < 1e-16);
    }

    #[test]
    fn the_perimeter_is_the_known_one_for_axes_two_and_one() {
        // 4·2·E(√3/2) = 9.688448220547675…, complete elliptic integral of the second kind.
        assert!(
            (Ellipse::new(2.0, 1.0).unwrap().perimeter() - 9.688_448_220_547_675).abs() < 1e-14
        );
        assert!(
            (Ellipse::new(1.0, 2.0).unwrap().perimeter() - 9.688_448_220_547_675).abs() < 1e-14
        );
    }

    #[test]
    fn the_closed_form_at_the_center_is_the_limit_of_the_integral_beside_it() {
        let ellipse = Ellipse::new(0.0525, 0.0785).unwrap();
        let center = ellipse.distance_integral(&Vector2::zeros());
        let beside = ellipse.distance_integral(&Vector2::new(1e-9, 0.0));
        assert!((center / beside - 1.0).abs() < 1e-12);
    }

    #[test]
    fn arc_length_and_its_inverse_agree_all_around() {
        let ellipse = Ellipse::new(0.0525, 0.0785).unwrap();
        assert!((ellipse.arc_length(TAU) - ellipse.perimeter()).abs() < 1e-14);
        for k in 0..40 {
            let psi = TAU * f64::from(k) / 40.0;
            let back = ellipse.parameter_at_length(ellipse.arc_length(psi));
            assert!((back - psi).abs() < 1e-12, "ψ = {psi}: {back}");
        }
    }

    #[test]
    fn the_nearest_point_is_nearer_than_a_fine_scan() {
        let ellipse = Ellipse::new(2.0, 1.0).unwrap();
        let points = [
            [3.0, 1.0],
            [-0.3, 0.2],
            [0.0, 0.0],
            [1.9, 0.0],
            [0.5, 0.0],
            [0.0, -2.0],
            [-1.0, -3.0],
        ];
        for [x, y] in points {
            let point = Vector2::new(x, y);
            let best = (ellipse.at_parameter(ellipse.nearest_parameter(&point)) - point).norm();
            let scan = (0..100_000)
                .map(|k| (ellipse.at_parameter(TAU * f64::from(k) / 1e5) - point).norm())
                .fold(f64::INFINITY, f64::min);
            assert!(best <= scan + 1e-12, "({x}, {y}): {best} against {scan}");
        }
    }

    #[test]
    fn bad_axes_are_refused() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Ellipse::new(bad, 1.0).is_err() && Ellipse::new(1.0, bad).is_err());
        }
    }
}
