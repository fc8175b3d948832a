//! Poses of the object before and after each push alone, with the way of the pusher between.

use std::collections::{BTreeMap, HashMap};
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use nalgebra::Vector2;
use planar::Pose;

use super::find::{find_recordings, is_file_ending};
use super::format::{Inspection, LogFormat, StreamInfo};
use super::timed_rows::{TimedRow, column_missing, csv_error, timed_rows};
use crate::error::DatasetError;
use crate::input::limits::{Limit, ReadLimits};
use crate::input::map::{FileBytes, open_regular, sha256};
use crate::recording::Recording;
use crate::recording::settings::Streams;
use crate::recording::whole_push::{EndPoints, WholePush, WholePushes};

/// Poses before and after, a push a row, as CSV.
pub(crate) struct EndPointsFormat;

/// The name of the format in `dataset.toml`.
pub(crate) const END_POINTS: &str = "endpoints";

/// What a row cannot do without: our name of the column, and that of the MIT set.
const POSES: [(&str, &str); 6] = [
    ("x0_m", "obj_x0"),
    ("y0_m", "obj_y0"),
    ("theta0_rad", "obj_th0"),
    ("x1_m", "obj_x1"),
    ("y1_m", "obj_y1"),
    ("theta1_rad", "obj_th1"),
];
/// The pusher's ends.
const TIPS: [(&str, &str); 4] = [
    ("tip_x0_m", "tip_x0"),
    ("tip_y0_m", "tip_y0"),
    ("tip_x1_m", "tip_x1"),
    ("tip_y1_m", "tip_y1"),
];
const DURATION: (&str, &str) = ("dt_s", "dt_s");
const SPEED: (&str, &str) = ("speed_m_s", "v_mm_s");
/// What a header line may be long, in bytes.
const LONGEST_HEADER: u64 = 1 << 16;
/// Files beside a `pushes.csv`.
const BESIDE: [&str; 2] = ["tip.csv", "wrench.csv"];

impl LogFormat for EndPointsFormat {
    fn id(&self) -> &'static str {
        END_POINTS
    }

    fn endings(&self) -> &'static [&'static str] {
        &["csv"]
    }

    fn find(&self, dir: &Path) -> Result<Vec<PathBuf>, DatasetError> {
        let expected =
            format!("files NAME.csv with the columns {}", POSES.map(|(own, _)| own).join(", "));
        find_recordings(dir, self.id(), &expected, &is_end_points)
    }

    fn read(
        &self,
        path: &Path,
        _: &Streams,
        limits: &ReadLimits,
    ) -> Result<Recording, DatasetError> {
        FileBytes::open(path, limits)?;
        let what = "the poses before and after alone are no stream; ingest the folder as a set";
        Err(DatasetError::Parse { path: path.into(), line: 1, what: what.to_owned() })
    }

    fn end_points(
        &self,
        path: &Path,
        limits: &ReadLimits,
    ) -> Result<Option<EndPoints>, DatasetError> {
        read_end_points(path, limits).map(Some)
    }

    fn inspect(&self, path: &Path, limits: &ReadLimits) -> Result<Inspection, DatasetError> {
        let file = FileBytes::open(path, limits)?;
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(file.bytes());
        let header = reader.headers().map_err(|error| parse(path, 1, error))?.clone();
        let stream = StreamInfo {
            name: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            columns: header.iter().map(str::to_owned).collect(),
            count: reader.records().count() as u64,
            ..StreamInfo::default()
        };
        Ok(Inspection { streams: vec![stream], ..Inspection::default() })
    }
}

/// Whether a path is a file of end points: a CSV whose header has the poses at both ends.
#[must_use]
pub fn is_end_points(path: &Path) -> bool {
    let header = || {
        let (file, _) = open_regular(path, &ReadLimits::default()).ok()?;
        let lines = BufReader::new(file.take(LONGEST_HEADER)).lines().map_while(Result::ok);
        lines.into_iter().find(|line| !line.starts_with('#'))
    };
    let header = if is_file_ending(path, &["csv"]) { header() } else { None };
    header.is_some_and(|header| {
        let names: Vec<&str> =
            header.trim_start_matches('\u{feff}').split(',').map(str::trim).collect();
        POSES.iter().all(|(own, other)| names.contains(own) || names.contains(other))
    })
}

/// Reads the pushes of a file of end points: `pushes.csv` with `tip.csv` and `wrench.csv` beside it, or
/// one whose rows have the ends of the pusher's way, such as `plywood.csv` of the MIT pushes.
///
/// # Errors
/// `Io`; `ColumnMissing`; `Parse` with line, column and value for what is no finite number, a push that
/// is there twice or not in `pushes.csv`, or times that do not increase; `OverLimit`.
pub fn read_end_points(path: &Path, limits: &ReadLimits) -> Result<EndPoints, DatasetError> {
    let beside = |name: &str| Some(path.with_file_name(name)).filter(|file| file.is_file());
    let is_set = path.file_name().is_some_and(|name| name == "pushes.csv");
    let [tip, wrench] = BESIDE.map(|name| if is_set { beside(name) } else { None });
    let file = FileBytes::open(path, limits)?;
    let mut sets = read_pushes(path, file.bytes(), tip.is_some(), limits)?;
    let mut hashes = vec![file.sha256()];
    for (other, is_tip) in [(tip, true), (wrench, false)] {
        let Some(other) = other else { continue };
        let bytes = FileBytes::open(&other, limits)?;
        hashes.push(bytes.sha256());
        let columns = if is_tip { ["x_m", "y_m"] } else { ["fx_n", "fy_n"] };
        let rows = timed_rows(&other, bytes.bytes(), columns, limits)?;
        hand_out(&other, rows, &mut sets, is_tip)?;
    }
    let sha256 = match &hashes[..] {
        [only] => only.clone(),
        all => sha256(all.iter().map(|hash| hash.as_bytes())),
    };
    Ok(EndPoints { sha256, sets })
}

/// Gives each push its samples.
fn hand_out(
    path: &Path,
    rows: Vec<TimedRow>,
    sets: &mut [WholePushes],
    is_tip: bool,
) -> Result<(), DatasetError> {
    let [set] = sets else {
        let what = "pushes.csv is about more than one object or recording; give each a folder";
        return Err(parse(path, 1, what));
    };
    let places: HashMap<u32, usize> =
        set.pushes.iter().enumerate().map(|(place, push)| (push.push, place)).collect();
    for TimedRow { push, t, value, line } in rows {
        let Some(&place) = places.get(&push) else {
            return Err(parse(path, line, format!("push is {push}, which is not in pushes.csv")));
        };
        let push = &mut set.pushes[place];
        let samples = if is_tip { &mut push.tip } else { &mut push.force };
        match samples.last() {
            // One sample that was written twice.
            Some((last, before)) if is_tip && t == *last && value == *before => {}
            // A mean of forces may have two at one time, a way may not.
            Some((last, _)) if t < *last || (is_tip && t == *last) => {
                let what =
                    format!("t_s is {t}, after {last} of the same push; times must increase");
                return Err(parse(path, line, what));
            }
            _ => samples.push((t, value)),
        }
    }
    Ok(())
}

fn read_pushes(
    path: &Path,
    bytes: &[u8],
    has_tip_file: bool,
    limits: &ReadLimits,
) -> Result<Vec<WholePushes>, DatasetError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut builder = csv::ReaderBuilder::new();
    let mut reader = builder.trim(csv::Trim::All).comment(Some(b'#')).from_reader(bytes);
    let header = reader.headers().map_err(|error| csv_error(path, &error))?.clone();
    limits.check(path, Limit::Columns, || "columns".into(), header.len() as u64)?;
    let columns = Columns::of(path, &header, has_tip_file)?;
    let mut sets: BTreeMap<String, WholePushes> = BTreeMap::new();
    let mut lines: HashMap<(String, u32), u64> = HashMap::new();
    for (number, record) in reader.records().enumerate() {
        limits.check(path, Limit::Pushes, || "pushes".into(), number as u64 + 1)?;
        let record = record.map_err(|error| csv_error(path, &error))?;
        let row = Row { path, columns: &columns, record: &record };
        let (recording, shape) = row.recording();
        let push = row.push(number)?;
        if let Some(first) = lines.insert((recording.clone(), push.push), row.line()) {
            let what = format!(
                "push is {}, as in line {first}; number the pushes, or tell them apart by a column \
                 `recording`",
                push.push
            );
            return Err(parse(path, row.line(), what));
        }
        let new = || WholePushes { recording: recording.clone(), shape, pushes: Vec::new() };
        sets.entry(recording.clone()).or_insert_with(new).pushes.push(push);
    }
    Ok(sets.into_values().collect())
}

/// Where the columns are.
struct Columns {
    poses: [Named; 6],
    tips: Option<[Named; 4]>,
    /// How long a push takes, in s, or how fast it is, in m/s.
    duration: Option<Named>,
    speed: Option<(Named, f64)>,
    t: Option<Named>,
    push: Option<Named>,
    session: Option<Named>,
    recording: Option<Named>,
    shape: Option<Named>,
}

/// A column with its header.
type Named = (usize, &'static str);

impl Columns {
    fn of(
        path: &Path,
        header: &csv::StringRecord,
        has_tip_file: bool,
    ) -> Result<Self, DatasetError> {
        let place =
            |name: &'static str| Some((header.iter().position(|found| found == name)?, name));
        let either =
            |(own, other): (&'static str, &'static str)| place(own).or_else(|| place(other));
        let needed = |pair: (&'static str, &'static str)| {
            either(pair).ok_or_else(|| column_missing(path, pair.0, header))
        };
        let mut poses = [(0, ""); 6];
        for (place, pair) in poses.iter_mut().zip(POSES) {
            *place = needed(pair)?;
        }
        let mut tips = None;
        if !has_tip_file {
            let mut found = [(0, ""); 4];
            for (place, pair) in found.iter_mut().zip(TIPS) {
                *place = needed(pair)?;
            }
            tips = Some(found);
        } else if TIPS.iter().any(|pair| either(*pair).is_some()) {
            let what =
                "the ends of the pusher's way are in columns and in tip.csv; keep one of them";
            return Err(parse(path, 1, what));
        }
        let scale = |found: Named| (found, if found.1 == SPEED.1 { 1e-3 } else { 1.0 });
        let (duration, speed) = (either(DURATION), either(SPEED).map(scale));
        if tips.is_some() && duration.is_none() && speed.is_none() {
            needed(DURATION)?;
        }
        let [t, push, session] = ["t_s", "push", "session"].map(place);
        let [recording, shape] = ["recording", "shape"].map(place);
        Ok(Self { poses, tips, duration, speed, t, push, session, recording, shape })
    }
}

/// One line of the file.
struct Row<'a> {
    path: &'a Path,
    columns: &'a Columns,
    record: &'a csv::StringRecord,
}

impl Row<'_> {
    fn line(&self) -> u64 {
        self.record.position().map_or(0, csv::Position::line)
    }

    fn text(&self, (place, _): Named) -> &str {
        self.record.get(place).unwrap_or_default()
    }

    fn fail(&self, column: Named, expected: &str) -> DatasetError {
        let what = format!("{} is `{}`, expected {expected}", column.1, self.text(column));
        parse(self.path, self.line(), what)
    }

    fn number(&self, column: Named) -> Result<f64, DatasetError> {
        let number = self.text(column).parse::<f64>().ok();
        // Numbers beyond are damage, and their squares would overflow.
        let number = number.filter(|number| number.abs() <= 1e12);
        number.ok_or_else(|| self.fail(column, "a finite number, in SI units"))
    }

    fn positive(&self, column: Named) -> Result<f64, DatasetError> {
        let number = self.number(column)?;
        if number > 0.0 { Ok(number) } else { Err(self.fail(column, "a number above 0")) }
    }

    /// Name of the recording, and the shape.
    fn recording(&self) -> (String, Option<String>) {
        let word = |column: Option<Named>| {
            column.map(|column| self.text(column).to_owned()).filter(|word| !word.is_empty())
        };
        let shape = word(self.columns.shape);
        let name = word(self.columns.recording).unwrap_or_else(|| {
            let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
            let speed = self.columns.speed.filter(|(column, _)| column.1 == SPEED.1);
            let speed = speed.map(|(column, _)| format!("_v={}", self.text(column)));
            let shape = shape.as_ref().map(|shape| format!("_shape={shape}"));
            format!("{stem}{}{}", shape.unwrap_or_default(), speed.unwrap_or_default())
        });
        (name, shape)
    }

    fn push(&self, number: usize) -> Result<WholePush, DatasetError> {
        let Columns { poses, tips, duration, speed, t, push, session, .. } = self.columns;
        let mut pose = [0.0; 6];
        for (value, column) in pose.iter_mut().zip(poses) {
            *value = self.number(*column)?;
        }
        let [x0, y0, theta0, x1, y1, theta1] = pose;
        let number = match push {
            Some(column) => self.text(*column).parse().ok(),
            None => u32::try_from(number).ok(),
        };
        let whole =
            || self.fail(push.unwrap_or((0, "push")), "a whole number from 0 to 4294967295");
        let mut tip = Vec::new();
        if let Some(tips) = tips {
            let mut ends = [0.0; 4];
            for (value, column) in ends.iter_mut().zip(tips) {
                *value = self.number(*column)?;
            }
            let [start, end] = [Vector2::new(ends[0], ends[1]), Vector2::new(ends[2], ends[3])];
            let way: f64 = (end - start).norm();
            let duration = match (duration, speed) {
                (Some(column), _) => self.positive(*column)?,
                (None, Some((column, scale))) => way / (scale * self.positive(*column)?),
                (None, None) => 0.0,
            };
            tip = vec![(0.0, start), (duration, end)];
        }
        Ok(WholePush {
            push: number.ok_or_else(whole)?,
            session: session.map(|column| self.text(column).to_owned()).filter(|s| !s.is_empty()),
            t: t.map_or(Ok(0.0), |column| self.number(column))?,
            object_start: Pose::new(x0, y0, theta0),
            object_end: Pose::new(x1, y1, theta1),
            tip,
            force: Vec::new(),
        })
    }
}

fn parse(path: &Path, line: u64, what: impl ToString) -> DatasetError {
    DatasetError::Parse { path: path.into(), line, what: what.to_string() }
}
