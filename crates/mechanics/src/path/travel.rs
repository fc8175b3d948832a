//! How far a pusher goes along its path, there and back counted both.

use crate::PusherPath;
use crate::numerics::quadrature::gauss_points;

/// Rounding of a travel, relative to it.
const ROUNDING: f64 = 1e-9;
/// A shorter share of the travel that is allowed is no good use of it.
const LEAST_SHARE: f64 = 0.5;
const MOST_TRIES: usize = 60;

/// The mean speed of the pusher's center from a time within a piece on, for `duration` in s, in m/s.
pub(crate) fn mean_speed(path: &dyn PusherPath, piece: usize, time: f64, duration: f64) -> f64 {
    let speed = |share: f64| {
        let velocity = path.velocity(piece, time + share * duration);
        velocity.x.hypot(velocity.y)
    };
    gauss_points().iter().map(|(share, weight)| weight * speed(*share)).sum()
}

/// A time of at most `longest`, in s, in which the pusher's center goes `travel` in m along its path at
/// most, and half of that at least where there is time for it.
///
/// The way back counts as the way there does. Of a speed that changes within the time, eight moments are
/// looked at.
pub(crate) fn within_travel(
    path: &dyn PusherPath,
    piece: usize,
    time: f64,
    longest: f64,
    travel: f64,
) -> f64 {
    let way = |duration: f64| duration * mean_speed(path, piece, time, duration);
    let is_within = |way: f64| way <= travel * (1.0 + ROUNDING);
    let (mut low, mut high) = (0.0, longest);
    let mut at_high = way(high);
    if is_within(at_high) {
        return longest;
    }
    // In proportion: at a constant speed the first try uses all of the travel.
    let mut aim = 1.0;
    for _ in 0..MOST_TRIES {
        let tried = if low > 0.0 { 0.5 * (low + high) } else { aim * high * (travel / at_high) };
        aim = 0.9;
        let at_tried = way(tried);
        if !is_within(at_tried) {
            (high, at_high) = (tried, at_tried);
        } else if at_tried >= LEAST_SHARE * travel {
            return tried;
        } else {
            low = tried;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::within_travel;
    use crate::{SmoothPath, StraightPath};
    use nalgebra::Vector2;

    #[test]
    fn at_a_constant_speed_the_travel_is_used_up() {
        let path = StraightPath {
            start_w: Vector2::zeros(),
            velocity_w: Vector2::new(0.03, 0.04),
            duration: 2.0,
        };
        assert!((within_travel(&path, 0, 0.5, 1.5, 0.01) - 0.2).abs() < 1e-15);
        assert_eq!(within_travel(&path, 0, 0.5, 0.1, 0.01), 0.1);
    }

    #[test]
    fn there_and_back_is_twice_the_way() {
        // 0.1 m to and fro in 1 s, from rest.
        let path = SmoothPath {
            position_w: |t: f64| Vector2::new(0.05 - 0.05 * (std::f64::consts::TAU * t).cos(), 0.0),
            velocity_w: |t: f64| {
                let rate = std::f64::consts::TAU;
                Vector2::new(0.05 * rate * (rate * t).sin(), 0.0)
            },
            duration: 1.0,
        };
        for travel in [1e-6, 1e-3, 0.037, 0.05, 0.1, 0.19] {
            let time = within_travel(&path, 0, 0.0, 1.0, travel);
            let there = |t: f64| 0.05 - 0.05 * (std::f64::consts::TAU * t).cos();
            let way = if time <= 0.5 { there(time) } else { 0.2 - there(time) };
            assert!(way <= 1.001 * travel && way > 0.49 * travel, "{travel}: {time} s, {way} m");
        }
    }
}
