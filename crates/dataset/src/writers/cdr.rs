//! Messages of ROS 1 and ROS 2, byte by byte.

use super::sample::Sample;
use crate::remark::StreamRole;

/// The definition of a message type for ROS 1 (`ros1msg`) and ROS 2 (`ros2msg`).
pub(super) fn definition(role: StreamRole, ros2: bool) -> String {
    let line = "=".repeat(80);
    let header = if ros2 {
        format!(
            "{line}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
             {line}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
        )
    } else {
        format!("{line}\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n")
    };
    let axes = "float64 x\nfloat64 y\nfloat64 z\n";
    let body = if role == StreamRole::Wrench {
        format!(
            "geometry_msgs/Wrench wrench\n{header}{line}\nMSG: geometry_msgs/Wrench\n\
             Vector3 force\nVector3 torque\n{line}\nMSG: geometry_msgs/Vector3\n{axes}"
        )
    } else {
        format!(
            "geometry_msgs/Pose pose\n{header}{line}\nMSG: geometry_msgs/Pose\nPoint position\n\
             Quaternion orientation\n{line}\nMSG: geometry_msgs/Point\n{axes}\
             {line}\nMSG: geometry_msgs/Quaternion\n{axes}float64 w\n"
        )
    };
    format!("std_msgs/Header header\n{body}")
}

/// Frame that the messages name.
pub(super) const FRAME: &str = "world";

/// A PoseStamped or WrenchStamped in CDR (ROS 2) or the ROS 1 serialisation.
pub(super) fn encode(role: StreamRole, sample: &Sample, sequence: u32, ros2: bool) -> Vec<u8> {
    let (sec, nanosec) = sample.stamp();
    // Both serialisations have 32 bits for the seconds.
    let sec = u32::try_from(sec).unwrap_or(u32::MAX);
    let mut message = Vec::with_capacity(100);
    if ros2 {
        message.extend([0, 1, 0, 0]);
    } else {
        message.extend(sequence.to_le_bytes());
    }
    message.extend(sec.to_le_bytes());
    message.extend(nanosec.to_le_bytes());
    let terminator = usize::from(ros2);
    message.extend(((FRAME.len() + terminator) as u32).to_le_bytes());
    message.extend(FRAME.as_bytes());
    if ros2 {
        message.push(0);
        // Numbers of eight bytes begin at a multiple of eight behind the header of four.
        message.resize((message.len() - 4).next_multiple_of(8) + 4, 0);
    }
    for number in numbers(role, sample) {
        message.extend(number.to_le_bytes());
    }
    message
}

/// Position and quaternion, or force and torque.
pub(super) fn numbers(role: StreamRole, sample: &Sample) -> Vec<f64> {
    let [a, b, c] = sample.values;
    if role == StreamRole::Wrench {
        vec![a, b, 0.0, 0.0, 0.0, c]
    } else {
        let [z, w] = sample.quaternion_zw();
        vec![a, b, 0.0, 0.0, 0.0, z, w]
    }
}
