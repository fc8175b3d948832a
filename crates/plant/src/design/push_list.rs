//! A design from a file: one push a line.

use std::path::Path;

use csv::StringRecord;

use crate::{PlannedPush, PlantError};

/// A column of numbers: name, value where it is left out (none if it must be there), least and
/// largest value, and its unit's size in SI units.
struct Column {
    name: &'static str,
    usual: Option<f64>,
    range: (f64, f64),
    unit: f64,
}

const fn column(name: &'static str, usual: Option<f64>, range: (f64, f64), unit: f64) -> Column {
    Column { name, usual, range, unit }
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;
const COLUMNS: [Column; 9] = [
    column("edge", None, (0.0, 1e6), 1.0),
    column("p", None, (0.0, 1.0), 1.0),
    column("angle_deg", None, (-88.0, 88.0), DEGREE),
    column("speed_mm_s", None, (1.0, 1000.0), 1e-3),
    column("travel_mm", Some(50.0), (0.1, 1000.0), 1e-3),
    column("x_mm", Some(0.0), (-10_000.0, 10_000.0), 1e-3),
    column("y_mm", Some(0.0), (-10_000.0, 10_000.0), 1e-3),
    column("theta_deg", Some(0.0), (-360.0, 360.0), DEGREE),
    column("session", Some(0.0), (0.0, 1e6), 1.0),
];
/// Columns of whole numbers.
const COUNTS: [&str; 2] = ["edge", "session"];
/// The column of names.
const REPEAT: &str = "repeat";
/// The pusher's path, for robots: it follows from the other columns and is passed over.
const PATH: [&str; 6] =
    ["start_x_mm", "start_y_mm", "touch_x_mm", "touch_y_mm", "end_x_mm", "end_y_mm"];

/// Reads pushes from a CSV file with the columns edge, p, angle_deg, speed_mm_s and, if wanted,
/// travel_mm, x_mm, y_mm, theta_deg, session and repeat, in any order.
///
/// Lines that begin with `#` are comments. The pusher's path in start_x_mm, start_y_mm, touch_x_mm,
/// touch_y_mm, end_x_mm and end_y_mm is for robots: here it follows from the other columns.
///
/// # Errors
/// `PushList` with the line, the column, what is there and what it should be.
pub fn read_push_list(path: &Path) -> Result<Vec<PlannedPush>, PlantError> {
    let fail = |line: usize, what: String| PlantError::PushList {
        path: path.to_owned(),
        line: line as u64,
        what,
    };
    let text = dataset::read_text(path)?;
    let text = text.trim_start_matches('\u{feff}');
    let mut lines = text
        .lines()
        .enumerate()
        .map(|(index, line)| (index + 1, line))
        .filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let (line, header) = lines.next().unwrap_or((1, ""));
    let header = values(header);
    check(&header).map_err(|what| fail(line, format!("{what}; {}", known())))?;
    let pushes = lines
        .map(|(line, text)| push(&header, &values(text)).map_err(|what| fail(line, what)))
        .collect::<Result<Vec<_>, _>>()?;
    if pushes.is_empty() {
        return Err(fail(line, "the list has no pushes".to_owned()));
    }
    Ok(pushes)
}

/// The values of a line; none of what is no line of CSV.
fn values(line: &str) -> StringRecord {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .trim(csv::Trim::All)
        .from_reader(line.as_bytes());
    reader.records().next().and_then(Result::ok).unwrap_or_default()
}

/// What the columns are, for messages.
fn known() -> String {
    let (needed, usual): (Vec<_>, Vec<_>) =
        COLUMNS.iter().partition(|column| column.usual.is_none());
    let needed = needed.iter().map(|column| column.name).collect::<Vec<_>>().join(", ");
    let usual = usual.iter().map(|column| match column.usual {
        Some(value) => format!("{} ({value})", column.name),
        None => column.name.to_owned(),
    });
    let usual = usual.collect::<Vec<_>>().join(", ");
    format!("the columns are {needed} and, if wanted, {usual} and {REPEAT} (a name)")
}

/// Refuses headers that are not known, are missing or are given twice.
fn check(header: &StringRecord) -> Result<(), String> {
    for (k, name) in header.iter().enumerate() {
        let is_known = name == REPEAT || PATH.contains(&name);
        if !is_known && !COLUMNS.iter().any(|column| column.name == name) {
            return Err(format!("column {} is called `{name}`", k + 1));
        }
        if header.iter().take(k).any(|before| before == name) {
            return Err(format!("column `{name}` is there twice"));
        }
    }
    let missing = COLUMNS
        .iter()
        .find(|column| column.usual.is_none() && !header.iter().any(|name| name == column.name));
    missing.map_or(Ok(()), |column| Err(format!("column `{}` is missing", column.name)))
}

fn push(header: &StringRecord, record: &StringRecord) -> Result<PlannedPush, String> {
    let (n, n_columns) = (record.len(), header.len());
    if n != n_columns {
        return Err(format!("{n} values where the header names {n_columns} columns"));
    }
    let text = |name: &str| {
        let place = header.iter().position(|known| known == name);
        place.and_then(|place| record.get(place)).filter(|text| !text.is_empty())
    };
    let mut values = [0.0; COLUMNS.len()];
    for (value, column) in values.iter_mut().zip(&COLUMNS) {
        *value = column.unit * number(column, text(column.name))?;
    }
    let [edge, p, angle, speed, travel, x, y, theta, session] = values;
    Ok(PlannedPush {
        edge: edge as usize,
        p,
        angle,
        speed,
        travel,
        place: [x, y, theta],
        session: session as usize,
        repeat: text(REPEAT).unwrap_or_default().to_owned(),
    })
}

/// A number in its column's unit.
fn number(column: &Column, text: Option<&str>) -> Result<f64, String> {
    let Column { name, usual, range: (low, high), .. } = column;
    let Some(text) = text else {
        return usual.ok_or_else(|| format!("{name} is empty, expected {low} to {high}"));
    };
    let is_whole = |value: f64| value.fract() == 0.0 || !COUNTS.contains(name);
    match text.parse::<f64>() {
        Ok(value) if (*low..=*high).contains(&value) && is_whole(value) => Ok(value),
        Ok(value) if !is_whole(value) => Err(format!("{name} = {value} is no whole number")),
        Ok(value) => Err(format!("{name} = {value} is not within {low} to {high}")),
        Err(_) => Err(format!("{name} = `{text}` is not a number")),
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
        let pushes = read(
            "# made by hand\nedge,p,angle_deg,speed_mm_s,theta_deg,repeat\n1,0.25,0,20,90,a\n",
        )
        .unwrap();
        assert_eq!((pushes[0].place[2], pushes[0].repeat.as_str()), (90.0_f64.to_radians(), "a"));
        let pushes = read("speed_mm_s,x_mm,p,edge,angle_deg\n20,,0.25,1,0\n").unwrap();
        assert_eq!((pushes[0].place[0], pushes[0].speed), (0.0, 0.02));
    }

    #[test]
    fn the_path_that_robots_read_is_passed_over() {
        let plain = "edge,p,angle_deg,speed_mm_s\n1,0.25,-30,20\n";
        let with_path = "edge,p,start_x_mm,end_y_mm,angle_deg,speed_mm_s\n1,0.25,-60.1,3,-30,20\n";
        assert_eq!(read(plain), read(with_path));
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line_and_column() {
        let header = "edge,p,angle_deg,speed_mm_s";
        for (text, says) in [
            ("1,0.25,-30,20\n1,x,-30,20", "DIR/pushes.csv:3: p = `x` is not a number"),
            ("# here\n1,1.25,-30,20", "DIR/pushes.csv:3: p = 1.25 is not within 0 to 1"),
            ("1,nan,-30,20", "DIR/pushes.csv:2: p = NaN is not within 0 to 1"),
            ("1,0.5,-30,0.02", ":2: speed_mm_s = 0.02 is not within 1 to 1000"),
            ("0.5,0.5,-30,20", ":2: edge = 0.5 is no whole number"),
            ("1,,-30,20", ":2: p is empty, expected 0 to 1"),
            ("1,0.5,-30", ":2: 3 values where the header names 4 columns"),
            ("", "the list has no pushes"),
        ] {
            let message = read(&format!("{header}\n{text}\n")).unwrap_err();
            assert!(message.contains(says), "{message}");
        }
    }

    #[test]
    fn headers_are_checked_and_answered_with_the_known_ones() {
        for (header, says) in [
            ("edge,p,angle,speed_mm_s", "DIR/pushes.csv:1: column 3 is called `angle`"),
            ("edge,p,speed_mm_s", "column `angle_deg` is missing"),
            ("edge,p,p,speed_mm_s", "column `p` is there twice"),
        ] {
            let message = read(&format!("{header}\n1,0.25,-30,20\n")).unwrap_err();
            assert!(message.contains(says) && message.contains("travel_mm (50)"), "{message}");
        }
        assert!(super::read_push_list("nowhere.csv".as_ref()).is_err());
    }
}
