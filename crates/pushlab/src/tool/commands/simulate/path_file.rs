//! A path of the pusher from a file: recorded points, or a shape with a speed.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use dataset::read_text;
use models::PushPath;
use nalgebra::Vector2;
use planar::Pose;
use serde::Deserialize;

/// A path, and where its file lays the object down.
pub(super) struct PathFile {
    pub(super) path: PushPath,
    pub(super) object_wb: Option<Pose>,
}

/// A path file in TOML.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    kind: Kind,
    speed_mm_s: f64,
    /// Pose of the object at the start: x and y in mm, and degrees.
    object: Option<[f64; 3]>,
    points_mm: Option<Vec<[f64; 2]>>,
    start_mm: Option<[f64; 2]>,
    center_mm: Option<[f64; 2]>,
    angle_deg: Option<f64>,
}

#[derive(Clone, Copy, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
enum Kind {
    Straight,
    Polyline,
    Spline,
    Arc,
}

/// Columns of a recorded path.
const COLUMNS: &str = "t_s,x_m,y_m";
const MM: f64 = 1e-3;

impl PathFile {
    /// Reads a path file, `.csv` or `.toml`.
    ///
    /// # Errors
    /// If it cannot be read or is no path, with the line or the point.
    pub(super) fn read(file: &Path) -> Result<Self> {
        let text = read_text(file).with_context(|| format!("cannot read {}", file.display()))?;
        let ending = file.extension().and_then(|ending| ending.to_str());
        let read = match ending {
            Some("csv") => recorded(&text).map(|path| Self { path, object_wb: None }),
            Some("toml") => drawn(&text),
            _ => bail!(
                "{} is neither a recording set nor a path: a path ends in .csv or .toml",
                file.display()
            ),
        };
        read.with_context(|| format!("{} is no path", file.display()))
    }

    /// Whether a CSV file has no more columns than a recorded path; step tables have many.
    pub(super) fn has_few_columns(file: &Path) -> bool {
        let text = read_text(file).unwrap_or_default();
        let mut lines = text.trim_start_matches('\u{feff}').lines();
        let header = lines.find(|line| !line.trim().is_empty() && !line.starts_with('#'));
        header.is_none_or(|header| header.split(',').count() <= COLUMNS.split(',').count())
    }
}

/// Lines of time in s and place in m; `#` begins a comment.
fn recorded(text: &str) -> Result<PushPath> {
    let lines = text.trim_start_matches('\u{feff}').lines().enumerate();
    let mut lines = lines.filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let (_, header) = lines.next().context("the file is empty")?;
    let names: Vec<_> = header.split(',').map(str::trim).collect();
    ensure!(
        names == COLUMNS.split(',').collect::<Vec<_>>(),
        "its columns are {header:?}; expected {COLUMNS}"
    );
    let mut points = Vec::new();
    let mut numbers = Vec::new();
    for (index, line) in lines {
        let cells: Vec<_> = line.split(',').map(str::trim).collect();
        ensure!(cells.len() == 3, "line {}: {} values, expected 3", index + 1, cells.len());
        let value = |k: usize| {
            let name = names[k];
            let value = cells[k].parse::<f64>();
            value
                .with_context(|| format!("line {}, {name}: {:?} is no number", index + 1, cells[k]))
        };
        points.push((value(0)?, Vector2::new(value(1)?, value(2)?)));
        numbers.push(index + 1);
    }
    PushPath::timed(&points).map_err(|error| match error {
        models::ModelError::Path { point, problem } if point < numbers.len() => {
            anyhow::anyhow!("line {}: the point {problem}", numbers[point])
        }
        other => other.into(),
    })
}

fn drawn(text: &str) -> Result<PathFile> {
    let raw: Raw = toml::from_str(text)?;
    let speed = MM * raw.speed_mm_s;
    let place = |place: &[f64; 2]| MM * Vector2::from(*place);
    let path = match (raw.kind, &raw.points_mm, raw.start_mm, raw.center_mm, raw.angle_deg) {
        (Kind::Arc, None, Some(start), Some(center), Some(angle_deg)) => {
            PushPath::arc(place(&start), place(&center), angle_deg.to_radians(), speed)?
        }
        (Kind::Arc, ..) => bail!("an arc has start_mm, center_mm and angle_deg, and no points_mm"),
        (kind, Some(points), None, None, None) => {
            let points: Vec<_> = points.iter().map(place).collect();
            match kind {
                Kind::Straight if points.len() != 2 => {
                    bail!("points_mm: a straight path has 2 points, not {}", points.len())
                }
                Kind::Spline => PushPath::spline(&points, speed)?,
                Kind::Straight | Kind::Polyline | Kind::Arc => PushPath::polyline(&points, speed)?,
            }
        }
        _ => bail!("a path of this kind has points_mm, and nothing of an arc"),
    };
    let pose = |[x, y, turn]: [f64; 3]| Pose::new(MM * x, MM * y, turn.to_radians());
    Ok(PathFile { path, object_wb: raw.object.map(pose) })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::PathFile;

    fn read(name: &str, text: &str) -> Result<PathFile, String> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(name);
        std::fs::write(&file, text).unwrap();
        PathFile::read(&file).map_err(|error| format!("{error:#}"))
    }

    #[test]
    fn every_kind_of_path_is_read() {
        let points = "points_mm = [[-60, 0], [-20, 10], [40, 0]]";
        for (text, length) in [
            ("kind = \"straight\"\nspeed_mm_s = 20\npoints_mm = [[0, 0], [30, 40]]", 0.05),
            (&format!("kind = \"polyline\"\nspeed_mm_s = 20\n{points}"), 0.10206),
            (&format!("kind = \"spline\"\nspeed_mm_s = 20\n{points}"), 0.103),
            (
                "kind = \"arc\"\nspeed_mm_s = 20\nobject = [5, 0, 90]\nstart_mm = [100, 0]\n\
                 center_mm = [0, 0]\nangle_deg = 90",
                0.15708,
            ),
        ] {
            let found = read("p.toml", text).unwrap();
            assert!((found.path.length() - length).abs() < 1e-3, "{text}: {}", found.path.length());
            assert_eq!(found.object_wb.is_some(), text.contains("object"));
        }
        let csv = read("p.csv", "# by hand\nt_s,x_m,y_m\n1,0,0\n1.5, 0.01, 0\n").unwrap();
        assert!((csv.path.duration() - 0.5).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_path_is_refused_with_line_and_value() {
        let header = "t_s,x_m,y_m\n";
        for (name, text, says) in [
            ("p.csv", String::new(), "the file is empty"),
            ("p.csv", "t,x,y\n0,0,0\n".into(), "expected t_s,x_m,y_m"),
            ("p.csv", format!("{header}0,0\n"), "line 2: 2 values, expected 3"),
            ("p.csv", format!("{header}0,0,0\n1,a,0\n"), "line 3, x_m: \"a\" is no number"),
            ("p.csv", format!("{header}0,0,0\n\n1,NaN,0\n"), "line 4: the point is (NaN, 0) m"),
            ("p.csv", format!("{header}0,0,0\n0.1,9,0\n"), "line 3: the point is a jump of 9000"),
            ("p.csv", format!("{header}1,0,0\n1,0.01,0\n"), "line 3: the point is at 1 s, after"),
            ("p.csv", format!("{header}0,0,0\n"), "two points or more"),
            ("p.toml", "kind = \"loop\"\nspeed_mm_s = 20".into(), "straight"),
            ("p.toml", "kind = \"arc\"\nspeed_mm_s = 20".into(), "start_mm"),
            ("p.xlsx", String::new(), "ends in .csv or .toml"),
        ] {
            let error = read(name, &text).err().unwrap();
            assert!(error.contains(says), "{says}: {error}");
        }
        assert!(PathFile::read(Path::new("none.csv")).is_err());
    }
}
