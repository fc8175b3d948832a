//! Where a free pusher meets the outline.

use effects::TrueOutline;
use nalgebra::Vector2;

/// The pusher touches within this, in m.
const TOUCH: f64 = 1e-6;
/// Least advance along a surface that is passed by, in m.
const LEAST_ADVANCE: f64 = 1e-5;

/// The way, in m, after which a pusher from `start_b` along `direction_b` first moves into the
/// outline; none within `distance`.
///
/// The pusher goes on by its distance from the outline, which can never be too far.
pub(super) fn first_touch(
    outline: &TrueOutline,
    start_b: Vector2<f64>,
    direction_b: Vector2<f64>,
    distance: f64,
) -> Option<f64> {
    let mut way = 0.0;
    while way < distance {
        let contact = outline.contact(&(start_b + way * direction_b));
        if contact.gap <= TOUCH && direction_b.dot(&contact.normal) > 0.0 {
            return Some(way);
        }
        let advance = if contact.gap <= TOUCH { LEAST_ADVANCE } else { contact.gap };
        way += advance.max(TOUCH);
    }
    None
}

#[cfg(test)]
mod tests {
    use effects::TrueOutline;
    use nalgebra::Vector2;
    use planar::Shape;

    use super::first_touch;

    fn touch(start: [f64; 2], direction: [f64; 2], distance: f64) -> Option<f64> {
        let square = TrueOutline::stated(&Shape::square(0.09).unwrap(), 0.005);
        let (start, direction) = (Vector2::from(start), Vector2::from(direction).normalize());
        first_touch(&square, start, direction, distance)
    }

    #[test]
    fn a_pusher_meets_a_face_at_its_distance_and_misses_beyond_the_corner() {
        let way = touch([-0.07, 0.0], [1.0, 0.0], 0.1).unwrap();
        assert!((way - 0.02).abs() < 2e-6, "{way}");
        let oblique = touch([-0.07, 0.0], [1.0, 1.0], 0.1).unwrap();
        assert!((oblique - 0.02 * 2_f64.sqrt()).abs() < 4e-6, "{oblique}");
        assert_eq!(touch([-0.07, 0.0], [1.0, 0.0], 0.0199), None);
        assert_eq!(touch([-0.07, 0.0501], [1.0, 0.0], 1.0), None);
        // The corner is round for a round pusher.
        let corner = touch([-0.07, 0.049], [1.0, 0.0], 1.0).unwrap();
        assert!((corner - (0.025 - 0.003)).abs() < 2e-6, "{corner}");
    }

    #[test]
    fn leaving_a_surface_or_going_along_it_is_no_touch() {
        assert_eq!(touch([-0.05, 0.0], [-1.0, 0.0], 0.1), None);
        assert_eq!(touch([-0.05, 0.0], [0.0, 1.0], 0.1), None);
        assert_eq!(touch([-0.05, 0.0], [1.0, 0.1], 0.1), Some(0.0));
    }
}
