//! A part of the table as people write it.

use std::fmt;
use std::str::FromStr;

/// Smallest and largest x, and y, in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Area(pub(super) [[f64; 2]; 2]);

impl FromStr for Area {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Vec<f64> =
            text.split(',').map(|part| part.trim().parse().unwrap_or(f64::NAN)).collect();
        match numbers[..] {
            [x0, x1, y0, y1] if x0 < x1 && y0 < y1 && (x1 - x0 + y1 - y0).is_finite() => {
                Ok(Self([[1e-3 * x0, 1e-3 * x1], [1e-3 * y0, 1e-3 * y1]]))
            }
            _ => Err("expected XMIN,XMAX,YMIN,YMAX in mm, such as -150,150,-100,100".to_owned()),
        }
    }
}

impl fmt::Display for Area {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [[x0, x1], [y0, y1]] = self.0.map(|ends| ends.map(|end| 1e3 * end));
        write!(f, "{x0},{x1},{y0},{y1}")
    }
}

#[cfg(test)]
mod tests {
    use super::Area;

    #[test]
    fn areas_are_four_numbers_in_order() {
        let area: Area = "-150,150,-100, 100".parse().unwrap();
        assert_eq!(area, Area([[-0.15, 0.15], [-0.1, 0.1]]));
        assert_eq!(area.to_string().parse(), Ok(area));
        for text in ["", "1,2,3", "2,1,0,1", "0,1,1,1", "0,x,0,1", "0,inf,0,1", "0,nan,0,1"] {
            assert!(text.parse::<Area>().is_err(), "{text}");
        }
    }
}
