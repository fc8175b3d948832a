//! Samples of a recording as they are written: rounded, and checked to be numbers.

use std::path::Path;

use crate::recording::{PoseStream, Recording, WrenchStream};
use crate::{error::DatasetError, remark::StreamRole};

/// A sample of one stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    /// Time since the clock's zero, in µs.
    pub(super) time_us: i64,
    /// x in m, y in m, yaw in rad; or force along x and y in N, torque about z in N·m.
    pub(super) values: [f64; 3],
}

impl Sample {
    /// The time in s as decimal text, exactly.
    pub(super) fn seconds(&self) -> String {
        let sign = if self.time_us < 0 { "-" } else { "" };
        let microseconds = self.time_us.unsigned_abs();
        format!("{sign}{}.{:06}", microseconds / 1_000_000, microseconds % 1_000_000)
    }

    /// The time as whole seconds and the rest in ns.
    pub(super) fn stamp(&self) -> (i64, u32) {
        let rest = self.time_us.rem_euclid(1_000_000) * 1000;
        (self.time_us.div_euclid(1_000_000), u32::try_from(rest).unwrap_or(0))
    }

    /// The third value, a yaw, as the parts z and w of a quaternion.
    pub(super) fn quaternion_zw(&self) -> [f64; 2] {
        let half = self.values[2] / 2.0;
        [libm::sin(half), libm::cos(half)]
    }
}

/// The samples of the streams that a recording has.
pub(super) fn samples(
    recording: &Recording,
    path: &Path,
    format: &'static str,
) -> Result<Vec<(StreamRole, Vec<Sample>)>, DatasetError> {
    let PoseStream { t, x, y, theta, .. } = &recording.robot;
    let robot = (StreamRole::Robot, [t, x, y, theta]);
    let PoseStream { t, x, y, theta, .. } = &recording.object;
    let object = (StreamRole::Object, [t, x, y, theta]);
    let no_torque;
    let mut streams = vec![robot, object];
    if let Some(WrenchStream { t, fx, fy, tz, .. }) = &recording.wrench {
        no_torque = vec![0.0; if tz.is_empty() { t.len() } else { 0 }];
        let tz = if tz.is_empty() { &no_torque } else { tz };
        streams.push((StreamRole::Wrench, [t, fx, fy, tz]));
    }
    let one = |(role, columns): (StreamRole, [&Vec<f64>; 4])| {
        let unwritable = |what| DatasetError::Unwritable { path: path.into(), format, what };
        let lengths = columns.map(Vec::len);
        if lengths.iter().any(|length| *length != lengths[0]) {
            return Err(unwritable(format!("the {role} stream has columns of {lengths:?} values")));
        }
        let row = |i: usize| {
            let values = columns.map(|column| column[i]);
            if values.iter().all(|value| value.is_finite()) {
                Ok(rounded(recording.epoch_ns, role, values))
            } else {
                Err(unwritable(format!("sample {i} of the {role} stream is {values:?}")))
            }
        };
        Ok((role, (0..lengths[0]).map(row).collect::<Result<_, _>>()?))
    };
    streams.into_iter().map(one).collect()
}

fn rounded(epoch_ns: i64, role: StreamRole, [t, a, b, c]: [f64; 4]) -> Sample {
    let time_us = (epoch_ns / 1000).saturating_add((t * 1e6).round() as i64);
    // Adding 0 turns −0 into 0.
    let round = |value: f64, per_unit: f64| (value * per_unit).round() / per_unit + 0.0;
    let per_unit = if role == StreamRole::Wrench { 1e3 } else { 1e6 };
    Sample { time_us, values: [round(a, per_unit), round(b, per_unit), round(c, 1e6)] }
}
