//! Places on which an object rests.

use std::borrow::Cow;

use nalgebra::{Matrix2, Vector2};

use crate::EffectError;
use crate::object::points::{Point, Points};

/// A place on which a part of the object's weight rests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Where, in m, frame of the outline.
    pub place_o: Vector2<f64>,
    /// Share of the weight, 0 to 1.
    pub share: f64,
    /// How wide it is: the radius of gyration of its pressure, in m. Positive: an object that turns
    /// about a place of no size may be turned by no or by any moment.
    pub radius: f64,
}

/// The spots of an object; what they leave of its weight is spread over the area.
#[derive(Clone, Debug)]
pub(crate) struct Spots {
    /// Shares of 1, places about the center of the object's whole pressure.
    points: Vec<Point>,
    lanes: Points,
    /// Of the spots alone, about that center.
    own_center: Vector2<f64>,
    /// Of the weight that they bear, above 0 and at most 1.
    pub(crate) share: f64,
    /// Center of the whole pressure from the centroid, in m.
    pub(crate) center: Vector2<f64>,
    /// Mean distance of their load from that center, in m.
    pub(crate) mean_distance: f64,
}

/// Of the whole weight: shares that leave less leave nothing.
const ROUNDING: f64 = 1e-12;
/// Of the mean distance of spots that all are at their center, as a share of the area's.
const LEAST_DISTANCE: f64 = 1e-3;

impl Spots {
    /// The spots of an object whose area has a centroid, in m, and a mean distance from it; none if
    /// they bear nothing. Shares beyond the whole weight are in proportion.
    ///
    /// # Errors
    /// `InvalidValue` for a place, a share or a radius that a spot cannot have.
    pub(crate) fn new(
        spots: &[Spot],
        centroid: &Vector2<f64>,
        area_distance: f64,
    ) -> Result<Option<Self>, EffectError> {
        spots.iter().try_for_each(Spot::check)?;
        let total: f64 = spots.iter().map(|spot| spot.share).sum();
        if total == 0.0 {
            return Ok(None);
        }
        let share = if total > 1.0 - ROUNDING { 1.0 } else { total };
        let bearing = spots.iter().filter(|spot| spot.share > 0.0);
        let arm = |spot: &Spot| spot.share / total * (spot.place_o - centroid);
        let mean: Vector2<f64> = bearing.clone().map(arm).sum();
        let center: Vector2<f64> = share * mean;
        let points: Vec<Point> = bearing
            .map(|spot| Point {
                place: spot.place_o - centroid - center,
                share: spot.share / total,
                spin: spot.radius * std::f64::consts::FRAC_1_SQRT_2,
            })
            .collect();
        let distance = points.iter().map(|point| point.share * point.place.norm()).sum::<f64>();
        Ok(Some(Self {
            lanes: Points::new(&points),
            own_center: mean - center,
            points,
            share,
            center,
            mean_distance: distance.max(LEAST_DISTANCE * area_distance),
        }))
    }

    /// The spots as they bear a weight that leans: its center is beside their own by `shift`, in m,
    /// from which they are seen.
    pub(crate) fn leaning(&self, shift: &Vector2<f64>) -> Cow<'_, Points> {
        if *shift == Vector2::zeros() {
            return Cow::Borrowed(&self.lanes);
        }
        let (shares, rest) = leaning(&self.points, &self.own_center, shift);
        let point = |(point, share): (&Point, f64)| Point {
            place: point.place + rest - shift,
            share,
            spin: point.spin,
        };
        let points: Vec<Point> = self.points.iter().zip(shares).map(point).collect();
        Cow::Owned(Points::new(&points))
    }

    /// Where they are about the center.
    pub(crate) fn places(&self) -> impl Iterator<Item = &Vector2<f64>> {
        self.points.iter().map(|point| &point.place)
    }
}

impl Spot {
    fn check(&self) -> Result<(), EffectError> {
        let refuse = |name, expected, value, unit| {
            Err(EffectError::InvalidValue { name, expected, value, unit })
        };
        let Self { place_o, share, radius } = *self;
        if !(place_o.x + place_o.y).is_finite() {
            return refuse("a spot's place", "finite", place_o.x + place_o.y, "m");
        }
        if !(share >= 0.0 && share.is_finite()) {
            let expected = "finite and not negative";
            return refuse("a spot's share of the weight", expected, share, "(share)");
        }
        if !(radius > 0.0 && radius.is_finite()) {
            return refuse("a spot's radius of gyration", "positive and finite", radius, "m");
        }
        Ok(())
    }
}

const MAX_ITERATIONS: usize = 50;
/// Relative to the spots' spread.
const TOLERANCE: f64 = 1e-12;
/// Parts of a shift that are tried where all of it has no answer: each half of the one before.
const MOST_HALVINGS: usize = 24;

/// Shares of points whose center is moved by a shift, and what of it the points move themselves.
///
/// Of all shares with a center these are the nearest to the given ones (in relative entropy):
/// wᵢ exp(g·rᵢ)/Σ. To first order they change linearly with the place, as under a rigid object on
/// springs. A center that no shares have, because it is not between the points, is approached as far as
/// can be halved; the points are moved by the rest.
fn leaning(
    points: &[Point],
    center: &Vector2<f64>,
    shift: &Vector2<f64>,
) -> (Vec<f64>, Vector2<f64>) {
    let mut part = 1.0;
    for _ in 0..MOST_HALVINGS {
        if let Some(shares) = tilted(points, &(center + part * shift)) {
            return (shares, (1.0 - part) * shift);
        }
        part *= 0.5;
    }
    (points.iter().map(|point| point.share).collect(), *shift)
}

/// Newton's method on the dual ln Σ w exp(g·(r − d)), which is convex; none where it does not converge.
fn tilted(points: &[Point], center: &Vector2<f64>) -> Option<Vec<f64>> {
    let arms: Vec<Vector2<f64>> = points.iter().map(|point| point.place - center).collect();
    let spread = arms.iter().map(Vector2::norm).fold(0.0, f64::max);
    let mut tilt = Vector2::zeros();
    let mut now = Dual::at(points, &arms, &tilt);
    for _ in 0..MAX_ITERATIONS {
        if now.slope.norm() <= TOLERANCE * spread {
            return Some(now.shares);
        }
        let step = now.curvature.try_inverse()? * now.slope;
        // Near an end of the shares' reach a whole step overshoots.
        let part = (1.0 / (step.norm() * spread)).min(1.0);
        let mut length = part;
        let mut next = Dual::at(points, &arms, &(tilt - length * step));
        while next.value > now.value && length > 1e-3 * part {
            length *= 0.5;
            next = Dual::at(points, &arms, &(tilt - length * step));
        }
        tilt -= length * step;
        now = next;
        if !now.value.is_finite() {
            return None;
        }
    }
    None
}

/// ln Σ w exp(g·a) of arms a with its derivatives, and the shares w exp(g·a) over that sum.
struct Dual {
    shares: Vec<f64>,
    value: f64,
    slope: Vector2<f64>,
    curvature: Matrix2<f64>,
}

impl Dual {
    fn at(points: &[Point], arms: &[Vector2<f64>], tilt: &Vector2<f64>) -> Self {
        let terms = points.iter().zip(arms);
        let mut shares: Vec<f64> =
            terms.map(|(point, arm)| point.share * tilt.dot(arm).exp()).collect();
        let (mut sum, mut slope, mut curvature) = (0.0, Vector2::zeros(), Matrix2::zeros());
        for (share, arm) in shares.iter().zip(arms) {
            sum += share;
            slope += *share * arm;
            curvature += *share * arm * arm.transpose();
        }
        shares.iter_mut().for_each(|share| *share /= sum);
        slope /= sum;
        curvature = curvature / sum - slope * slope.transpose();
        Self { shares, value: sum.ln(), slope, curvature }
    }
}

#[cfg(test)]
mod tests {
    use super::{Spot, Spots, tilted};
    use crate::EffectError;
    use crate::object::points::Point;
    use nalgebra::{Matrix2, Vector2, Vector3};

    fn spot(x: f64, y: f64, share: f64) -> Spot {
        Spot { place_o: Vector2::new(x, y), share, radius: 1e-3 }
    }

    fn four() -> Vec<Spot> {
        vec![
            spot(0.04, 0.03, 0.4),
            spot(-0.04, 0.03, 0.2),
            spot(-0.03, -0.04, 0.3),
            spot(0.03, -0.02, 0.1),
        ]
    }

    fn spots(of: &[Spot]) -> Spots {
        Spots::new(of, &Vector2::new(0.002, -0.001), 0.03).unwrap().unwrap()
    }

    #[test]
    fn the_center_is_that_of_spots_and_area_together() {
        let half: Vec<Spot> = four().iter().map(|s| Spot { share: 0.5 * s.share, ..*s }).collect();
        let centroid = Vector2::new(0.002, -0.001);
        let mean: Vector2<f64> = four().iter().map(|s| s.share * (s.place_o - centroid)).sum();
        assert!((spots(&four()).center - mean).norm() < 1e-17);
        assert!((spots(&half).center - 0.5 * mean).norm() < 1e-17);
        assert_eq!(spots(&four()).share, 1.0);
        assert!((spots(&half).share - 0.5).abs() < 1e-15);
    }

    #[test]
    fn shares_beyond_the_whole_weight_are_in_proportion() {
        let double: Vec<Spot> =
            four().iter().map(|s| Spot { share: 2.0 * s.share, ..*s }).collect();
        let (once, twice) = (spots(&four()), spots(&double));
        assert!((once.center - twice.center).norm() < 1e-17 && twice.share == 1.0);
    }

    #[test]
    fn leaning_moves_the_center_by_the_shift() {
        let (spots, motion) = (spots(&four()), Vector3::new(0.01, 0.0, 0.0));
        for shift in [(3e-3, -2e-3), (-8e-3, 5e-3), (0.2, 0.0)] {
            // Pure translation loads every point alike: the moment is that of the center.
            let points = spots.leaning(&Vector2::new(shift.0, shift.1));
            let (load, _) = points.load(&Matrix2::identity(), 1.0, &motion);
            assert!((load - Vector3::new(1.0, 0.0, 0.0)).norm() < 1e-11, "{shift:?} {load}");
            let across = Vector3::new(0.0, 0.01, 0.0);
            let (load, _) = points.load(&Matrix2::identity(), 1.0, &across);
            assert!((load - Vector3::new(0.0, 1.0, 0.0)).norm() < 1e-11, "{shift:?} {load}");
        }
    }

    #[test]
    fn three_feet_share_the_weight_as_statics_say() {
        // By hand: on (0, 0), (1, 0), (0, 1) a weight at (0.3, 0.2) loads them by 0.5, 0.3, 0.2.
        let feet = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)];
        let points = feet.map(|(x, y)| {
            let place = Vector2::new(x, y);
            Point { place, share: 1.0 / 3.0, spin: 1e-3 }
        });
        let shares = tilted(&points, &Vector2::new(0.3, 0.2)).unwrap();
        for (share, by_hand) in shares.iter().zip([0.5, 0.3, 0.2]) {
            assert!((share - by_hand).abs() < 1e-10, "{shares:?}");
        }
        assert_eq!(tilted(&points, &Vector2::new(0.7, 0.6)), None);
    }

    #[test]
    fn spots_that_cannot_be_are_refused() {
        let refused = |spot: Spot| Spots::new(&[spot], &Vector2::zeros(), 0.03).unwrap_err();
        for (bad, expected) in [
            (spot(f64::NAN, 0.0, 0.5), "finite"),
            (spot(0.0, 0.0, -0.5), "finite and not negative"),
            (Spot { radius: 0.0, ..spot(0.0, 0.0, 0.5) }, "positive and finite"),
        ] {
            let error = refused(bad);
            assert!(
                matches!(error, EffectError::InvalidValue { expected: e, .. } if e == expected)
            );
        }
        assert!(Spots::new(&[spot(0.0, 0.0, 0.0)], &Vector2::zeros(), 0.03).unwrap().is_none());
    }
}
