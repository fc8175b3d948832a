//! Where an object is, as people write it.

use std::fmt;
use std::str::FromStr;

use planar::Pose;

/// x and y in mm, and degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place([f64; 3]);

impl Place {
    pub(super) fn pose_wb(self) -> Pose {
        let [x_mm, y_mm, angle_deg] = self.0;
        Pose::new(1e-3 * x_mm, 1e-3 * y_mm, angle_deg.to_radians())
    }
}

impl FromStr for Place {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Vec<f64> =
            text.split(',').filter_map(|number| number.trim().parse().ok()).collect();
        match (<[f64; 3]>::try_from(numbers), text.split(',').count()) {
            (Ok(place), 3) if place.iter().all(|number| number.is_finite()) => Ok(Self(place)),
            _ => Err("expected x and y in mm and an angle in degrees, such as 0,-20,45".to_owned()),
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, angle] = self.0;
        write!(f, "{x},{y},{angle}")
    }
}

#[cfg(test)]
mod tests {
    use super::Place;

    #[test]
    fn a_place_has_three_numbers() {
        let place: Place = "10, -20,90".parse().unwrap();
        let pose = place.pose_wb();
        assert_eq!((pose.position.x, pose.position.y), (0.01, -0.02));
        assert_eq!(pose.angle, std::f64::consts::FRAC_PI_2);
        assert_eq!(place.to_string().parse(), Ok(place));
        for text in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,inf", "1,x,2,3"] {
            assert!(text.parse::<Place>().unwrap_err().contains("such as 0,-20,45"), "{text}");
        }
    }
}
