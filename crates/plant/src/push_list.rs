//! A design from a file: one push a line.

use std::path::Path;

use serde::Deserialize;

use crate::{PlannedPush, PlantError};

const COLUMNS: &str = "edge, p, angle_deg, speed_mm_s and, if wanted, travel_mm (50), x_mm, \
                       y_mm, theta_deg, session (all 0) and repeat (a name)";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    edge: usize,
    p: f64,
    #[serde(rename = "angle_deg")]
    angle_degrees: f64,
    #[serde(rename = "speed_mm_s")]
    millimeters_per_second: f64,
    #[serde(rename = "travel_mm", default = "usual_travel")]
    travel_millimeters: f64,
    #[serde(rename = "x_mm", default)]
    x_millimeters: f64,
    #[serde(rename = "y_mm", default)]
    y_millimeters: f64,
    #[serde(rename = "theta_deg", default)]
    theta_degrees: f64,
    #[serde(default)]
    session: usize,
    #[serde(default)]
    repeat: String,
}

fn usual_travel() -> f64 {
    50.0
}

/// Reads pushes from a CSV file with the columns edge, p, angle_deg, speed_mm_s and, if wanted,
/// travel_mm, x_mm, y_mm, theta_deg, session and repeat.
///
/// # Errors
/// `PushList` with the line and what it should be.
pub fn read_push_list(path: &Path) -> Result<Vec<PlannedPush>, PlantError> {
    let fail = |error: csv::Error| PlantError::PushList {
        path: path.to_owned(),
        line: error.position().map_or(0, csv::Position::line),
        what: format!("{error}; the columns are {COLUMNS}"),
    };
    let mut reader =
        csv::ReaderBuilder::new().trim(csv::Trim::All).from_path(path).map_err(fail)?;
    let pushes = reader
        .deserialize()
        .map(|line| line.map(Line::push).map_err(fail))
        .collect::<Result<Vec<_>, _>>()?;
    if pushes.is_empty() {
        let what = "the list has no pushes".to_owned();
        return Err(PlantError::PushList { path: path.to_owned(), line: 0, what });
    }
    Ok(pushes)
}

impl Line {
    fn push(self) -> PlannedPush {
        PlannedPush {
            edge: self.edge,
            p: self.p,
            angle: self.angle_degrees.to_radians(),
            speed: 1e-3 * self.millimeters_per_second,
            travel: 1e-3 * self.travel_millimeters,
            place: [
                1e-3 * self.x_millimeters,
                1e-3 * self.y_millimeters,
                self.theta_degrees.to_radians(),
            ],
            session: self.session,
            repeat: self.repeat,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::read_push_list;

    fn read(text: &str) -> Result<Vec<crate::PlannedPush>, String> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("pushes.csv");
        std::fs::write(&path, text).unwrap();
        read_push_list(&path)
            .map_err(|error| error.to_string().replace(dir.path().to_str().unwrap(), "DIR"))
    }

    #[test]
    fn columns_that_are_not_given_have_their_usual_values() {
        let pushes = read("edge,p,angle_deg,speed_mm_s\n1,0.25,-30,20\n").unwrap();
        let push = &pushes[0];
        assert_eq!((push.edge, push.p, push.speed, push.travel), (1, 0.25, 0.02, 0.05));
        assert!((push.angle + std::f64::consts::FRAC_PI_6).abs() < 1e-15);
        let pushes =
            read("edge,p,angle_deg,speed_mm_s,theta_deg,repeat\n1,0.25,0,20,90,a\n").unwrap();
        assert_eq!((pushes[0].place[2], pushes[0].repeat.as_str()), (90.0_f64.to_radians(), "a"));
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line_and_the_columns() {
        let message = read("edge,p,angle_deg,speed_mm_s\n1,0.25,-30,20\n1,x,-30,20\n").unwrap_err();
        assert!(message.starts_with("DIR/pushes.csv:3:"), "{message}");
        assert!(message.contains("travel_mm (50)"), "{message}");
        assert!(read("edge,p,angle,speed_mm_s\n1,0.25,-30,20\n").is_err());
        assert!(read("edge,p,angle_deg,speed_mm_s\n").unwrap_err().contains("no pushes"));
    }
}
