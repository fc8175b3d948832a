//! The data sets of the MIT push files, whether in JSON or HDF5.

use std::path::Path;

use nalgebra::Isometry3;

use crate::formats::assemble::{Assembly, RawStream, nanoseconds, wrong_time_unit};
use crate::formats::decode::N_VALUES;
use crate::formats::format::{Inspection, StreamInfo};
use crate::formats::log::fixed_transform;
use crate::recording::Recording;
use crate::recording::frames::Frames;
use crate::recording::settings::{ColumnMap, Quantity, StreamSettings, Streams};
use crate::{error::DatasetError, remark::StreamRole};

/// The name of a stream's data set where the manifest names none.
pub(crate) fn default_data_set(role: StreamRole) -> &'static str {
    match role {
        StreamRole::Robot => "tip_pose",
        StreamRole::Object => "object_pose",
        StreamRole::Wrench => "ft_wrench",
    }
}

/// Rows of one data set.
pub(super) type Rows = Vec<[f64; 4]>;

/// Builds a recording from rows of [t, x, y, yaw] and [t, fx, fy, τz]; `rows_of` gives the rows
/// of a data set, or none if the file has no such set.
pub(super) fn recording_of_rows(
    path: &Path,
    sha256: String,
    names: &[String],
    streams: &Streams,
    rows_of: &mut dyn FnMut(&str) -> Result<Option<Rows>, DatasetError>,
) -> Result<Recording, DatasetError> {
    let mut assembly = Assembly { path, sha256, remarks: Vec::new() };
    let mut parts: [Option<(RawStream, Option<Isometry3<f64>>)>; 3] = [None, None, None];
    for role in StreamRole::ALL {
        let settings = streams.of(role);
        let name = settings.topic.as_deref().unwrap_or(default_data_set(role));
        let Some(rows) = rows_of(name)? else {
            if role == StreamRole::Wrench && settings.topic.is_none() {
                continue;
            }
            return Err(DatasetError::TopicMissing {
                path: path.into(),
                stream: role,
                topic: name.into(),
                available: names.join(", "),
            });
        };
        let frames = Frames::default();
        let transform = settings.transform.as_ref();
        let pose = fixed_transform(path, role, transform, &frames, &mut assembly.remarks)?;
        parts[role as usize] = Some((raw_stream(path, role, name, settings, &rows)?, pose));
    }
    let [Some((robot, robot_pose)), Some((object, object_pose)), wrench] = &parts else {
        unreachable!("a file without one of the poses is refused above")
    };
    let wrench = wrench.as_ref().map(|(raw, pose)| (raw, *pose, &streams.wrench));
    assembly.finish((robot, *robot_pose), (object, *object_pose), wrench)
}

/// What the numbers of a row are.
fn quantities(role: StreamRole) -> [Quantity; 4] {
    match role {
        StreamRole::Wrench => [Quantity::T, Quantity::Fx, Quantity::Fy, Quantity::Tz],
        _ => [Quantity::T, Quantity::X, Quantity::Y, Quantity::Theta],
    }
}

fn raw_stream(
    path: &Path,
    role: StreamRole,
    name: &str,
    settings: &StreamSettings,
    rows: &[[f64; 4]],
) -> Result<RawStream, DatasetError> {
    let unusable = |what: String| DatasetError::FieldMissing {
        path: path.into(),
        stream: role,
        topic: name.into(),
        type_name: "rows".into(),
        what,
    };
    let known = quantities(role);
    let is_other = |(quantity, map): &(&Quantity, &ColumnMap)| {
        !known.contains(quantity) || map.column != quantity.name()
    };
    if let Some((quantity, map)) = settings.columns.iter().find(is_other) {
        let names = known.map(Quantity::name).join(", ");
        return Err(unusable(format!(
            "its columns are {names}; streams.{role}.columns.{} asks for `{}`",
            quantity.name(),
            map.column
        )));
    }
    // Places among the quantities of a pose and of a wrench.
    let slots = if role == StreamRole::Wrench { [0, 1, 5] } else { [0, 1, 7] };
    let mut raw = RawStream::new(role, name, "row", &settings.columns);
    for slot in slots {
        raw.has[slot] = true;
    }
    let time = settings.columns.get(&Quantity::T);
    for (i, [t, numbers @ ..]) in rows.iter().enumerate() {
        let mut values = [0.0; N_VALUES];
        for (slot, number) in slots.into_iter().zip(numbers) {
            values[slot] = *number;
        }
        let t = time.map_or(*t, |map| map.scale * t + map.offset);
        if let Some(what) = wrong_time_unit(t, role, "columns") {
            return Err(unusable(format!("row {i}: {what}")));
        }
        if t.is_finite() {
            raw.push(nanoseconds(t), &values, i as u64);
        } else {
            // A row without a time counts among those that are not finite.
            raw.push(0, &[f64::NAN; N_VALUES], i as u64);
        }
    }
    Ok(raw)
}

/// What the data sets of a file are.
pub(super) fn inspect_rows<'a>(
    sets: impl Iterator<Item = (&'a str, &'a [[f64; 4]])>,
) -> Inspection {
    let streams = sets.map(|(name, rows)| {
        let times = rows.iter().map(|row| row[0]).filter(|t| t.is_finite());
        let first = times.clone().fold(f64::INFINITY, f64::min);
        let span = times.fold(f64::NEG_INFINITY, f64::max) - first;
        let serves = |role: &StreamRole| name == default_data_set(*role);
        StreamInfo {
            name: name.into(),
            count: rows.len() as u64,
            rate_hz: (span > 0.0).then(|| (rows.len() - 1) as f64 / span),
            fits: StreamRole::ALL.into_iter().filter(serves).collect(),
            ..StreamInfo::default()
        }
    });
    Inspection { streams: streams.collect(), ..Inspection::default() }
}
