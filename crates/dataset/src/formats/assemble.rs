//! Rows of numbers become the streams of a recording: scaled, in the world frame, checked.

use std::path::Path;

use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};

use crate::formats::decode::N_VALUES;
use crate::formats::row_losses::{Losses, RowLosses};
use crate::recording::name::{ENDINGS, recording_name};
use crate::recording::settings::{ColumnMap, Quantity, StreamSettings, WrenchFrame};
use crate::recording::transform::unit_quaternion;
use crate::recording::{PoseStream, Recording, WrenchStream};
use crate::{
    error::DatasetError,
    remark::{Remark, RemarkKind, StreamRole},
};

/// Largest magnitude of a position in m, an angle in rad, a force in N or a torque in N·m: more is
/// no measurement but a sensor's or a program's fault.
pub(crate) const LARGEST: f64 = 1e9;
/// Tilt of the object out of the plane above which a remark is made, in rad.
pub(crate) const TILT_LIMIT: f64 = 0.1;

/// The rows of one stream as they stand in the log.
pub(crate) struct RawStream {
    /// Topic, file or data set.
    pub(crate) source: String,
    /// What a place is: `byte`, `line` or `row`.
    pub(crate) place_word: &'static str,
    /// Which values the log has.
    pub(crate) has: [bool; N_VALUES],
    /// Stamps, in ns since the clock's zero.
    pub(crate) stamps: Vec<i64>,
    /// Values in SI, in the order of the stream's quantities.
    pub(crate) rows: Vec<[f64; N_VALUES]>,
    /// Where in the source each row begins.
    pub(crate) places: Vec<u64>,
    /// How many rows took the log time.
    pub(crate) log_times_used: u64,
    maps: [(f64, f64); N_VALUES],
}

impl RawStream {
    /// An empty stream; `maps` scales and shifts the quantities that it names.
    pub(crate) fn new<'a>(
        role: StreamRole,
        source: &str,
        place_word: &'static str,
        maps: impl IntoIterator<Item = (&'a Quantity, &'a ColumnMap)>,
    ) -> Self {
        let mut affine = [(1.0, 0.0); N_VALUES];
        for (quantity, map) in maps {
            if let Some(i) = Quantity::of(role).iter().position(|known| known == quantity) {
                affine[i] = (map.scale, map.offset);
            }
        }
        Self {
            source: source.into(),
            place_word,
            has: [false; N_VALUES],
            stamps: Vec::new(),
            rows: Vec::new(),
            places: Vec::new(),
            log_times_used: 0,
            maps: affine,
        }
    }

    /// Makes room for rows that a log says it has, as far as that is no matter if it is wrong.
    pub(crate) fn expect(&mut self, n_rows: u64) {
        const MOST: u64 = 1 << 13;
        let n_rows = n_rows.min(MOST) as usize;
        self.stamps.reserve(n_rows);
        self.rows.reserve(n_rows);
        self.places.reserve(n_rows);
    }

    /// Appends a row with the log's own numbers.
    pub(crate) fn push(&mut self, stamp: i64, values: &[f64; N_VALUES], place: u64) {
        self.stamps.push(stamp);
        self.rows.push(std::array::from_fn(|i| self.maps[i].0 * values[i] + self.maps[i].1));
        self.places.push(place);
    }

    /// Whether a row can be used; those that cannot are counted with their place.
    fn is_usable(&self, i: usize, losses: &mut RowLosses) -> bool {
        let values = || self.rows[i].iter().zip(&self.has).filter(|(_, has)| **has);
        if values().all(|(value, _)| value.abs() <= LARGEST) {
            return true;
        }
        if let Some((value, _)) = values().find(|(value, _)| !value.is_finite()) {
            losses.not_finite.add(self.places[i], *value);
        } else if let Some((value, _)) = values().find(|(value, _)| value.abs() > LARGEST) {
            losses.too_large.add(self.places[i], *value);
        }
        false
    }
}

/// A recording in the making.
pub(crate) struct Assembly<'a> {
    pub(crate) path: &'a Path,
    pub(crate) sha256: String,
    pub(crate) remarks: Vec<Remark>,
}

impl Assembly<'_> {
    /// Builds the recording; poses and forces come with the pose of their frame in the world.
    pub(crate) fn finish(
        mut self,
        robot: (&RawStream, Option<Isometry3<f64>>),
        object: (&RawStream, Option<Isometry3<f64>>),
        wrench: Option<(&RawStream, Option<Isometry3<f64>>, &StreamSettings)>,
    ) -> Result<Recording, DatasetError> {
        let (robot_stamps, mut robot) = self.poses(StreamRole::Robot, robot.0, robot.1)?;
        let (object_stamps, mut object) = self.poses(StreamRole::Object, object.0, object.1)?;
        let mut wrench = wrench
            .map(|(raw, transform, settings)| self.forces(raw, transform, settings))
            .transpose()?;
        let stamps = robot_stamps.iter().chain(&object_stamps);
        let first = stamps.chain(wrench.iter().flat_map(|(stamps, _)| stamps)).min();
        let whole_second = |ns: &i64| ns.saturating_sub(ns.rem_euclid(1_000_000_000));
        let epoch_ns = first.map_or(0, whole_second);
        robot.t = seconds_since(epoch_ns, &robot_stamps);
        object.t = seconds_since(epoch_ns, &object_stamps);
        if let Some((stamps, stream)) = &mut wrench {
            stream.t = seconds_since(epoch_ns, stamps);
        }
        Ok(Recording {
            name: recording_name(self.path, &ENDINGS),
            path: self.path.into(),
            sha256: self.sha256,
            epoch_ns,
            robot,
            object,
            wrench: wrench.map(|(_, stream)| stream),
            remarks: self.remarks,
        })
    }

    fn poses(
        &mut self,
        role: StreamRole,
        raw: &RawStream,
        transform: Option<Isometry3<f64>>,
    ) -> Result<(Vec<i64>, PoseStream), DatasetError> {
        let has_quaternion = raw.has[3..7].iter().all(|has| *has);
        let unpublished = has_quaternion
            && role == StreamRole::Robot
            && raw.rows.iter().all(|row| row[3..7].iter().all(|q| *q == 0.0));
        if unpublished && !raw.rows.is_empty() {
            let text = "all quaternions are zero; the robot's yaw is taken as 0".into();
            self.remark(RemarkKind::NoOrientation, role, raw.rows.len() as u64, text);
        }
        let mut stream = PoseStream { source: raw.source.clone(), ..PoseStream::default() };
        let mut stamps = Vec::with_capacity(raw.rows.len());
        for column in [&mut stream.x, &mut stream.y, &mut stream.theta] {
            column.reserve_exact(raw.rows.len());
        }
        let mut losses = RowLosses::default();
        let mut tilted = 0;
        for (i, row) in raw.rows.iter().enumerate() {
            if !raw.is_usable(i, &mut losses) {
                continue;
            }
            let [x, y, z, qx, qy, qz, qw, theta] = *row;
            let rotation = if has_quaternion && !unpublished {
                match unit_quaternion([qx, qy, qz, qw]) {
                    Ok(rotation) => rotation,
                    Err(length) => {
                        losses.not_unit.add(raw.places[i], length);
                        continue;
                    }
                }
            } else {
                UnitQuaternion::from_axis_angle(&Vector3::z_axis(), theta)
            };
            let planar = !has_quaternion || unpublished;
            let (position, angle, tilt) = match (transform, planar) {
                (None, true) => (Vector3::new(x, y, z), theta, 0.0),
                (None, false) => (Vector3::new(x, y, z), yaw(&rotation), tilt(&rotation)),
                (Some(transform), _) => {
                    let pose =
                        transform * Isometry3::from_parts(Translation3::new(x, y, z), rotation);
                    (pose.translation.vector, yaw(&pose.rotation), tilt(&pose.rotation))
                }
            };
            stamps.push(raw.stamps[i]);
            stream.x.push(position.x);
            stream.y.push(position.y);
            stream.theta.push(angle);
            stream.max_tilt = stream.max_tilt.max(tilt);
            tilted += u64::from(tilt > TILT_LIMIT);
        }
        self.check_losses(role, raw, &losses)?;
        // A robot's tool frame may point anywhere: only its position is used.
        if tilted > 0 && role == StreamRole::Object {
            let text = format!(
                "{tilted} of {} poses are tilted by more than {TILT_LIMIT} rad, at most by {:.3} \
                 rad; check the object's z axis, or set streams.object.transform",
                stamps.len(),
                stream.max_tilt
            );
            self.remark(RemarkKind::Tilted, role, tilted, text);
        }
        Ok((stamps, stream))
    }

    fn forces(
        &mut self,
        raw: &RawStream,
        transform: Option<Isometry3<f64>>,
        settings: &StreamSettings,
    ) -> Result<(Vec<i64>, WrenchStream), DatasetError> {
        let to_world = self.sensor_to_world(raw, transform, settings)?;
        let arm = transform.map_or(Vector3::zeros(), |pose| pose.translation.vector);
        let torque_turns = to_world[(2, 0)] != 0.0 || to_world[(2, 1)] != 0.0;
        let has_torque = raw.has[5] && (!torque_turns || (raw.has[3] && raw.has[4]));
        let mut stream = WrenchStream { source: raw.source.clone(), ..WrenchStream::default() };
        let mut stamps = Vec::with_capacity(raw.rows.len());
        let mut losses = RowLosses::default();
        for (i, row) in raw.rows.iter().enumerate() {
            if !raw.is_usable(i, &mut losses) {
                continue;
            }
            let force = to_world * Vector3::new(row[0], row[1], row[2]);
            stamps.push(raw.stamps[i]);
            stream.fx.push(force.x);
            stream.fy.push(force.y);
            if has_torque {
                let torque = to_world * Vector3::new(row[3], row[4], row[5]) + arm.cross(&force);
                stream.tz.push(torque.z);
            }
        }
        self.check_losses(StreamRole::Wrench, raw, &losses)?;
        Ok((stamps, stream))
    }

    /// The matrix that takes logged forces to the world, if the log has the forces it needs.
    fn sensor_to_world(
        &self,
        raw: &RawStream,
        transform: Option<Isometry3<f64>>,
        settings: &StreamSettings,
    ) -> Result<Matrix3<f64>, DatasetError> {
        if settings.frame == WrenchFrame::World {
            return Ok(Matrix3::identity());
        }
        let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
        let signed = settings.signs.map_or(Matrix3::identity(), |signs| {
            Matrix3::from_columns(&axes.map(|axis| signs.apply(&axis)))
        });
        let rotation = transform
            .map_or(Matrix3::identity(), |pose| pose.rotation.to_rotation_matrix().into_inner());
        let to_world = rotation * signed;
        if !raw.has[2] && (to_world[(0, 2)] != 0.0 || to_world[(1, 2)] != 0.0) {
            return Err(DatasetError::FieldMissing {
                path: self.path.into(),
                stream: StreamRole::Wrench,
                topic: raw.source.clone(),
                type_name: "wrench".into(),
                what: "the signs and the transform need fz, which is not there".into(),
            });
        }
        Ok(to_world)
    }

    fn check_losses(
        &mut self,
        stream: StreamRole,
        raw: &RawStream,
        losses: &RowLosses,
    ) -> Result<(), DatasetError> {
        let total = raw.rows.len() as u64;
        if total == 0 {
            let topic = raw.source.clone();
            return Err(DatasetError::NoSamples { path: self.path.into(), stream, topic });
        }
        if raw.log_times_used > 0 {
            let text = format!(
                "{} of {total} messages of {} have no stamp of their own; the log time is used",
                raw.log_times_used, raw.source
            );
            self.remark(RemarkKind::LogTimeUsed, stream, raw.log_times_used, text);
        }
        let place = |losses: &Losses| format!("first at {} {}", raw.place_word, losses.place);
        let RowLosses { not_finite, too_large, not_unit } = losses;
        let reasons = [
            (
                RemarkKind::NonFiniteExcluded,
                not_finite,
                format!("a value is not finite, {}", place(not_finite)),
            ),
            (
                RemarkKind::OutOfRangeExcluded,
                too_large,
                format!(
                    "the value {:e} is beyond ±{LARGEST:e} in SI units, {}",
                    too_large.example,
                    place(too_large)
                ),
            ),
            (
                RemarkKind::QuaternionExcluded,
                not_unit,
                format!(
                    "the quaternion has length {:.3} instead of 1, {}",
                    not_unit.example,
                    place(not_unit)
                ),
            ),
        ];
        let excluded: u64 = reasons.iter().map(|(_, losses, _)| losses.count).sum();
        if 2 * excluded > total {
            let count = |reason: &(_, &Losses, _)| reason.1.count;
            let worst = reasons.iter().rev().max_by_key(|reason| count(reason));
            let worst = worst.unwrap_or(&reasons[0]);
            return Err(DatasetError::MostlyUnusable {
                path: self.path.into(),
                stream,
                excluded,
                total,
                what: format!("{}; check the sensor or name another topic", worst.2),
            });
        }
        for (kind, losses, text) in reasons {
            if losses.count > 0 {
                let text = format!("{} of {total} rows excluded: {text}", losses.count);
                self.remark(kind, stream, losses.count, text);
            }
        }
        Ok(())
    }

    fn remark(&mut self, kind: RemarkKind, stream: StreamRole, count: u64, text: String) {
        self.remarks.push(Remark { kind, stream: Some(stream), count, text });
    }
}

/// Angle of the body's x axis about the world's z axis, in rad.
fn yaw(rotation: &UnitQuaternion<f64>) -> f64 {
    let [x, y, z, w]: [f64; 4] = rotation.coords.into();
    f64::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
}

/// Angle between the body's z axis and the world's, in rad: 2 asin √(qx² + qy²).
fn tilt(rotation: &UnitQuaternion<f64>) -> f64 {
    match (rotation.i, rotation.j) {
        (0.0, 0.0) => 0.0,
        (i, j) => 2.0 * i.hypot(j).min(1.0).asin(),
    }
}

fn seconds_since(epoch_ns: i64, stamps: &[i64]) -> Vec<f64> {
    stamps.iter().map(|stamp| stamp.saturating_sub(epoch_ns) as f64 / 1e9).collect()
}

/// Times beyond this, in s, are in another unit: later than the year 2250, whatever their clock.
const LATEST: f64 = 9e9;

/// Why a number can be no time in s, and what to do; none if it can.
///
/// - `key`: where the manifest takes the scale of times, such as `columns`.
pub(crate) fn wrong_time_unit(t: f64, role: StreamRole, key: &str) -> Option<String> {
    if !t.is_finite() || t.abs() <= LATEST {
        return None;
    }
    // Of a clock that counts from 1970; since the start of a machine they are smaller.
    let (unit, scale) = match t.abs() {
        size if size < 1e14 => ("milliseconds", "1e-3"),
        size if size < 1e17 => ("microseconds", "1e-6"),
        _ => ("nanoseconds", "1e-9"),
    };
    Some(format!(
        "the time {t:e} s is {:.0} years, so times are not in s but perhaps in {unit}: set t with \
         scale = {scale} under streams.{role}.{key}, or write them in s",
        t.abs() / 31_557_600.0
    ))
}

/// A time in s as ns; the fraction is rounded apart from the whole, so that nothing is lost.
pub(crate) fn nanoseconds(seconds: f64) -> i64 {
    let whole = seconds.floor();
    (whole as i64)
        .saturating_mul(1_000_000_000)
        .saturating_add(((seconds - whole) * 1e9).round() as i64)
}

#[cfg(test)]
mod tests;
