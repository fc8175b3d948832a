//! Fixed transforms between the frame of a log and the world.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// Farthest that a quaternion's length may be from 1 before it is refused.
pub(crate) const UNIT_TOLERANCE: f64 = 0.01;

/// The fixed pose of a log's own frame in the world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "TransformTable", into = "TransformTable")]
pub enum Transform {
    /// Given in `dataset.toml`: `{ translation_m = [x, y], yaw_rad = 0.1 }`, or in three
    /// dimensions with `quaternion_xyzw`.
    Fixed(Isometry3<f64>),
    /// Published in the log itself (`/tf`, `/tf_static`):
    /// `{ tf_parent = "world", tf_child = "viconworld" }`.
    Tf {
        /// Frame in which the streams are wanted.
        parent: String,
        /// Frame in which the stream was logged.
        child: String,
    },
}

/// Which signed axis of a sensor is x, y and z: `["-x", "+y", "-z"]`.
///
/// A reflection is allowed: a sensor may report the force on the object instead.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "[String; 3]", into = "[String; 3]")]
pub struct AxisSigns {
    axes: [usize; 3],
    signs: [f64; 3],
}

impl AxisSigns {
    /// The vector with its axes renamed and signed.
    #[must_use]
    pub fn apply(&self, v: &Vector3<f64>) -> Vector3<f64> {
        Vector3::from_fn(|i, _| self.signs[i] * v[self.axes[i]])
    }
}

/// A unit quaternion from its four components, or its length if that is not 1 within 0.01.
pub(crate) fn unit_quaternion(xyzw: [f64; 4]) -> Result<UnitQuaternion<f64>, f64> {
    let [x, y, z, w] = xyzw;
    let quaternion = Quaternion::new(w, x, y, z);
    let length = quaternion.norm();
    if (length - 1.0).abs() <= UNIT_TOLERANCE {
        Ok(UnitQuaternion::from_quaternion(quaternion))
    } else {
        Err(length)
    }
}

#[derive(Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct TransformTable {
    #[serde(skip_serializing_if = "Option::is_none")]
    translation_m: Option<Vec<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    yaw_rad: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    quaternion_xyzw: Option<[f64; 4]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    tf_parent: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    tf_child: Option<String>,
}

impl TryFrom<TransformTable> for Transform {
    type Error = String;

    fn try_from(table: TransformTable) -> Result<Self, String> {
        let TransformTable { translation_m, yaw_rad, quaternion_xyzw, tf_parent, tf_child } = table;
        let fixed = translation_m.is_some() || yaw_rad.is_some() || quaternion_xyzw.is_some();
        match (tf_parent, tf_child) {
            (Some(parent), Some(child)) if !fixed => return Ok(Self::Tf { parent, child }),
            (None, None) => {}
            _ => {
                return Err(
                    "a transform has either tf_parent and tf_child, or translation_m with \
                            yaw_rad or quaternion_xyzw"
                        .into(),
                );
            }
        }
        let translation = match translation_m.as_deref() {
            None => Vector3::zeros(),
            Some(&[x, y]) => Vector3::new(x, y, 0.0),
            Some(&[x, y, z]) => Vector3::new(x, y, z),
            Some(other) => {
                return Err(format!("translation_m must have 2 or 3 numbers, got {}", other.len()));
            }
        };
        let rotation = match (yaw_rad, quaternion_xyzw) {
            (Some(_), Some(_)) => return Err("give yaw_rad or quaternion_xyzw, not both".into()),
            (yaw, None) => {
                UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw.unwrap_or_default())
            }
            (None, Some(xyzw)) => unit_quaternion(xyzw)
                .map_err(|length| format!("quaternion_xyzw must have length 1, got {length}"))?,
        };
        if !(translation.iter().chain(rotation.coords.iter()).all(|v| v.is_finite())) {
            return Err("a transform must be finite, in m and rad".into());
        }
        Ok(Self::Fixed(Isometry3::from_parts(Translation3::from(translation), rotation)))
    }
}

impl From<Transform> for TransformTable {
    fn from(transform: Transform) -> Self {
        match transform {
            Transform::Tf { parent, child } => {
                Self { tf_parent: Some(parent), tf_child: Some(child), ..Self::default() }
            }
            Transform::Fixed(pose) => {
                let q = pose.rotation.coords;
                Self {
                    translation_m: Some(pose.translation.vector.iter().copied().collect()),
                    quaternion_xyzw: Some([q.x, q.y, q.z, q.w]),
                    ..Self::default()
                }
            }
        }
    }
}

impl TryFrom<[String; 3]> for AxisSigns {
    type Error = String;

    fn try_from(names: [String; 3]) -> Result<Self, String> {
        let mut axes = [0; 3];
        let mut signs = [1.0; 3];
        for (i, name) in names.iter().enumerate() {
            let (sign, axis) = match name.split_at_checked(1) {
                Some(("+", axis)) => (1.0, axis),
                Some(("-", axis)) => (-1.0, axis),
                _ => (1.0, name.as_str()),
            };
            signs[i] = sign;
            axes[i] = ["x", "y", "z"]
                .iter()
                .position(|&known| known == axis)
                .ok_or_else(|| format!("an axis is +x, -x, +y, -y, +z or -z, got `{name}`"))?;
        }
        if (0..3).any(|axis| !axes.contains(&axis)) {
            return Err(format!("signs must name each axis once, got {names:?}"));
        }
        Ok(Self { axes, signs })
    }
}

impl From<AxisSigns> for [String; 3] {
    fn from(value: AxisSigns) -> Self {
        std::array::from_fn(|i| {
            let sign = if value.signs[i] < 0.0 { '-' } else { '+' };
            format!("{sign}{}", ["x", "y", "z"][value.axes[i]])
        })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::{AxisSigns, Transform, TransformTable};

    fn signs(names: [&str; 3]) -> Result<AxisSigns, String> {
        AxisSigns::try_from(names.map(String::from))
    }

    #[test]
    fn signs_rename_and_turn_axes() {
        let v = Vector3::new(1.0, 2.0, 3.0);
        assert_eq!(signs(["-x", "+y", "-z"]).unwrap().apply(&v), Vector3::new(-1.0, 2.0, -3.0));
        assert_eq!(signs(["y", "-x", "z"]).unwrap().apply(&v), Vector3::new(2.0, -1.0, 3.0));
    }

    #[test]
    fn wrong_signs_are_refused() {
        assert!(signs(["x", "x", "z"]).unwrap_err().contains("each axis once"));
        assert!(signs(["x", "y", "w"]).unwrap_err().contains("got `w`"));
        assert!(signs(["", "y", "z"]).unwrap_err().contains("got ``"));
        assert!(signs(["é", "y", "z"]).unwrap_err().contains("got `é`"));
    }

    #[test]
    fn wrong_transforms_are_refused() {
        let table = TransformTable { translation_m: Some(vec![1.0]), ..Default::default() };
        assert!(Transform::try_from(table).unwrap_err().contains("2 or 3 numbers, got 1"));
        let table = TransformTable { quaternion_xyzw: Some([0.0; 4]), ..Default::default() };
        assert!(Transform::try_from(table).unwrap_err().contains("length 1, got 0"));
        let table = TransformTable { tf_parent: Some("w".into()), ..Default::default() };
        assert!(Transform::try_from(table).unwrap_err().contains("tf_parent and tf_child"));
        let table = TransformTable { yaw_rad: Some(f64::NAN), ..Default::default() };
        assert!(Transform::try_from(table).unwrap_err().contains("finite"));
    }
}
