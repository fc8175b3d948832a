//! Checks of poses: quaternions, tilt, clocks.

use std::path::Path;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use proptest::prelude::{prop_assert, prop_assert_eq, proptest};

use super::{Assembly, RawStream, nanoseconds, tilt, yaw};
use crate::recording::Recording;
use crate::{
    error::DatasetError,
    remark::{RemarkKind, StreamRole},
};

/// A stream of poses at 1, 2, 3 ... s with these quaternions.
fn poses(role: StreamRole, quaternions: &[[f64; 4]]) -> RawStream {
    let mut raw = RawStream::new(role, "/topic", "byte", []);
    raw.has = [true, true, true, true, true, true, true, false];
    for (i, [x, y, z, w]) in quaternions.iter().enumerate() {
        let values = [0.5, 0.25, 0.0, *x, *y, *z, *w, 0.0];
        raw.push(1_000_000_000 * (i as i64 + 1), &values, 100 + i as u64);
    }
    raw
}

fn finish(
    robot: &RawStream,
    object: &RawStream,
    pose: Option<Isometry3<f64>>,
) -> Result<Recording, DatasetError> {
    let path = Path::new("dir/log.mcap");
    let assembly = Assembly { path, sha256: String::new(), remarks: Vec::new() };
    assembly.finish((robot, None), (object, pose), None)
}

const UPRIGHT: [f64; 4] = [0.0, 0.0, 0.6, 0.8];
const ZERO: [f64; 4] = [0.0; 4];

fn robot() -> RawStream {
    poses(StreamRole::Robot, &[UPRIGHT])
}

#[test]
fn a_quaternion_far_from_unit_length_is_set_aside_and_counted() {
    let bad = [0.0, 0.0, 0.0, 0.5];
    let nearly = [0.0, 0.0, 0.603, 0.804];
    let object = poses(StreamRole::Object, &[UPRIGHT, bad, nearly]);
    let recording = finish(&robot(), &object, None).unwrap();
    assert_eq!(recording.object.t, [0.0, 2.0]);
    let yaw = 2.0 * f64::atan2(0.6, 0.8);
    assert!((recording.object.theta[1] - yaw).abs() < 1e-12);
    let [remark] = recording.remarks.as_slice() else { panic!("{:?}", recording.remarks) };
    assert_eq!((remark.kind, remark.count), (RemarkKind::QuaternionExcluded, 1));
    assert_eq!(
        remark.text,
        "1 of 3 rows excluded: the quaternion has length 0.500 instead of 1, first at byte 101"
    );
}

#[test]
fn mostly_bad_quaternions_are_an_error() {
    let object = poses(StreamRole::Object, &[ZERO, ZERO, UPRIGHT]);
    let error = finish(&robot(), &object, None).unwrap_err();
    assert!(matches!(
        error,
        DatasetError::MostlyUnusable { stream: StreamRole::Object, excluded: 2, total: 3, .. }
    ));
    assert_eq!(
        error.to_string(),
        "dir/log.mcap: 2 of 3 rows of the object stream cannot be used: the quaternion has length \
         0.000 instead of 1, first at byte 100; check the sensor or name another topic"
    );
}

#[test]
fn a_robot_that_never_publishes_its_orientation_is_read() {
    let recording = finish(
        &poses(StreamRole::Robot, &[ZERO, ZERO]),
        &poses(StreamRole::Object, &[UPRIGHT]),
        None,
    );
    let recording = recording.unwrap();
    assert_eq!(recording.robot.theta, [0.0, 0.0]);
    assert_eq!(recording.remarks[0].kind, RemarkKind::NoOrientation);
}

#[test]
fn a_tilted_object_is_remarked_and_a_tilted_tool_is_not() {
    let tilted = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.3).coords;
    let tilted = [tilted.x, tilted.y, tilted.z, tilted.w];
    let tool = poses(StreamRole::Robot, &[[1.0, 0.0, 0.0, 0.0]]);
    let object = poses(StreamRole::Object, &[UPRIGHT, tilted]);
    let recording = finish(&tool, &object, None).unwrap();
    assert!((recording.robot.max_tilt - std::f64::consts::PI).abs() < 1e-7);
    assert!((recording.object.max_tilt - 0.3).abs() < 1e-12);
    let [remark] = recording.remarks.as_slice() else { panic!("{:?}", recording.remarks) };
    assert_eq!((remark.kind, remark.count), (RemarkKind::Tilted, 1));
    assert!(remark.text.contains("1 of 2 poses are tilted by more than 0.1 rad, at most by 0.300"));
}

#[test]
fn the_epoch_is_the_whole_second_before_the_first_stamp() {
    let mut object = poses(StreamRole::Object, &[UPRIGHT]);
    object.stamps[0] = -500_000_000;
    let recording = finish(&robot(), &object, None).unwrap();
    assert_eq!(recording.epoch_ns, -1_000_000_000);
    assert_eq!((recording.object.t[0], recording.robot.t[0]), (0.5, 2.0));
    assert_eq!(nanoseconds(1_476_728_847.5), 1_476_728_847_500_000_000);
    assert_eq!((nanoseconds(-0.25), nanoseconds(1e300)), (-250_000_000, i64::MAX));
}

proptest! {
    #[test]
    fn yaw_and_tilt_are_those_of_the_rotation(angle in -3.0..3.0, lean in 0.0..1.5, about in -3.0..3.0) {
        let axis = nalgebra::Unit::new_normalize(Vector3::new(f64::cos(about), f64::sin(about), 0.0));
        let leaning = UnitQuaternion::from_axis_angle(&axis, lean);
        let upright = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
        prop_assert!((yaw(&upright) - angle).abs() < 1e-12);
        prop_assert!((tilt(&(leaning * upright)) - lean).abs() < 1e-7);
        let x_axis = leaning * upright * Vector3::x();
        prop_assert!((yaw(&(leaning * upright)) - x_axis.y.atan2(x_axis.x)).abs() < 1e-9);
    }

    #[test]
    fn a_transform_moves_poses_as_rigid_bodies(x in -1.0..1.0, y in -1.0..1.0, angle in -1.5..1.5) {
        let pose = Isometry3::new(Vector3::new(x, y, 0.3), Vector3::new(0.0, 0.0, angle));
        let object = poses(StreamRole::Object, &[UPRIGHT]);
        let plain = finish(&robot(), &object, None).unwrap().object;
        let moved = finish(&robot(), &object, Some(pose)).unwrap().object;
        let (sin, cos) = f64::sin_cos(angle);
        prop_assert!((moved.x[0] - (x + cos * plain.x[0] - sin * plain.y[0])).abs() < 1e-12);
        prop_assert!((moved.y[0] - (y + sin * plain.x[0] + cos * plain.y[0])).abs() < 1e-12);
        let turned = planar::wrap_angle(moved.theta[0] - plain.theta[0] - angle);
        prop_assert!(turned.abs() < 1e-12);
        prop_assert_eq!(moved.t, plain.t);
    }
}
