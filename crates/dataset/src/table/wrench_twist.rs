//! The MIT pushes' wrench–twist pairs as typed rows.

use std::path::Path;

use nalgebra::Vector2;
use planar::{PlanarError, Shape, Twist, Wrench, mit_object};
use serde::{Deserialize, de::DeserializeOwned};

use crate::error::DatasetError;
use crate::input::limits::ReadLimits;
use crate::input::map::FileBytes;

/// A measured pair of applied wrench and twist, in the object's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct WrenchTwist {
    /// What the object lay on.
    pub surface: String,
    /// The object's name in the MIT set.
    pub shape: String,
    /// Nominal speed of the pusher, in m/s.
    pub speed: f64,
    /// Length ρ by which torques were divided and yaw rates multiplied: the mean distance of the
    /// outline's vertices from their mean, in m.
    ///
    /// It is 1.3 to 2.2 times the mean distance of the area. That this one was used shows in the
    /// pairs: only with it the lines of force meet the outline within the cone of friction and no
    /// touched point outruns the pusher.
    pub characteristic_length: f64,
    /// Applied force (N) and torque about the body's origin (N·m): ρ times the column.
    pub wrench: Wrench,
    /// Velocity of the body's origin (m/s) and yaw rate (rad/s): the column over ρ.
    pub twist: Twist,
}

/// Reads measured wrench–twist pairs (`wrench_twist_plywood.csv`).
///
/// # Errors
/// `Io`, `Parse` with the line for a missing column, a value that does not fit, one that is not
/// finite, or an unknown shape; `TableTooShort` for fewer than two rows.
pub fn read_wrench_twists(path: &Path) -> Result<Vec<WrenchTwist>, DatasetError> {
    read_rows(path, |row: WrenchTwistRow| {
        let rho = mean_vertex_distance(&mit_object(&row.shape)?.shape);
        Ok(WrenchTwist {
            surface: row.surface,
            shape: row.shape,
            speed: row.v_mm_s * 1e-3,
            characteristic_length: rho,
            wrench: Wrench { force: Vector2::new(row.fx, row.fy), torque: rho * row.tau_over_rho },
            twist: Twist {
                linear: Vector2::new(row.vx, row.vy),
                angular: row.omega_times_rho / rho,
            },
        })
    })
}

/// Mean distance of an outline's vertices from their mean, in m; an ellipse is a polygon of many
/// vertices at equal steps of its parameter.
fn mean_vertex_distance(shape: &Shape) -> f64 {
    let vertices = shape.outline(1000);
    let n = vertices.len() as f64;
    let center = vertices.iter().sum::<Vector2<f64>>() / n;
    vertices.iter().map(|vertex| (vertex - center).norm()).sum::<f64>() / n
}

fn read_rows<R: DeserializeOwned + Finite, T>(
    path: &Path,
    convert: impl Fn(R) -> Result<T, PlanarError>,
) -> Result<Vec<T>, DatasetError> {
    let file = FileBytes::open(path, &ReadLimits::default())?;
    let mut reader = csv::Reader::from_reader(file.bytes());
    let parse = |line: u64, what: String| DatasetError::Parse { path: path.into(), line, what };
    let header = reader.headers().map_err(|error| parse(1, error.to_string()))?.clone();
    if let Some(column) = R::COLUMNS.iter().find(|&&column| !header.iter().any(|h| h == column)) {
        return Err(DatasetError::ColumnMissing {
            path: path.into(),
            column: (*column).to_owned(),
            found: header.iter().collect::<Vec<_>>().join(", "),
        });
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        let line = |position: Option<&csv::Position>| position.map_or(0, csv::Position::line);
        let record = record.map_err(|error| parse(line(error.position()), error.to_string()))?;
        let at = line(record.position());
        let row: R =
            record.deserialize(Some(&header)).map_err(|error| parse(at, error.to_string()))?;
        if !row.is_finite() {
            return Err(parse(at, "a value is not finite; remove the row or repair it".to_owned()));
        }
        rows.push(convert(row).map_err(|error| parse(at, error.to_string()))?);
    }
    if rows.len() < 2 {
        return Err(DatasetError::TableTooShort { path: path.into(), rows: rows.len() });
    }
    Ok(rows)
}

/// The columns of a row, and whether all its numbers are finite.
trait Finite {
    const COLUMNS: &'static [&'static str];
    fn is_finite(&self) -> bool;
}

#[derive(Deserialize)]
struct WrenchTwistRow {
    surface: String,
    shape: String,
    v_mm_s: f64,
    fx: f64,
    fy: f64,
    tau_over_rho: f64,
    vx: f64,
    vy: f64,
    omega_times_rho: f64,
}

impl Finite for WrenchTwistRow {
    const COLUMNS: &'static [&'static str] =
        &["surface", "shape", "v_mm_s", "fx", "fy", "tau_over_rho", "vx", "vy", "omega_times_rho"];

    fn is_finite(&self) -> bool {
        [self.v_mm_s, self.fx, self.fy, self.tau_over_rho, self.vx, self.vy, self.omega_times_rho]
            .iter()
            .all(|value| value.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::read_wrench_twists;

    fn write(text: &str) -> (tempfile::TempDir, PathBuf) {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rows.csv");
        std::fs::write(&path, text).unwrap();
        (dir, path)
    }

    const HEADER: &str = "surface,shape,v_mm_s,fx,fy,tau_over_rho,vx,vy,omega_times_rho\n";

    #[test]
    fn torque_and_yaw_rate_are_scaled_so_that_power_is_kept() {
        let row = "plywood,rect1,20,1,2,0.5,0.01,0.02,0.004\n";
        let (_dir, path) = write(&format!("{HEADER}{row}{row}"));
        let pair = &read_wrench_twists(&path).unwrap()[0];
        let rho = 0.09 / 2f64.sqrt();
        assert!((pair.characteristic_length - rho).abs() < 1e-15);
        assert!((pair.wrench.torque - 0.5 * rho).abs() < 1e-15);
        let power = 1.0 * 0.01 + 2.0 * 0.02 + 0.5 * 0.004;
        assert!((pair.wrench.power(&pair.twist) - power).abs() < 1e-15);
    }

    #[test]
    fn bad_rows_are_named() {
        let error = |text: &str| {
            let (dir, path) = write(text);
            let message = read_wrench_twists(&path).unwrap_err().to_string();
            message.replace(dir.path().to_str().unwrap(), "SET")
        };
        let good = "plywood,hex,20,1,2,0.5,0.01,0.02,0.004\n";
        let message = error(&format!("{HEADER}{good}{}", good.replace("hex", "hexagon")));
        assert!(message.starts_with("SET/rows.csv:3: unknown object `hexagon`"), "{message}");
        let message = error(&format!("{HEADER}{good}{}", good.replace("0.02", "NaN")));
        assert_eq!(message, "SET/rows.csv:3: a value is not finite; remove the row or repair it");
        let message = error(&HEADER.replace("fy", "f_y"));
        assert!(message.starts_with("SET/rows.csv: no column `fy`; the table has: surface"));
        let message = error(&format!("{HEADER}{good}"));
        assert!(message.contains("the table has 1 row(s); at least 2"), "{message}");
    }
}
