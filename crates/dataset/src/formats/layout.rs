//! Which fields of a message make a pose or a wrench.

use crate::formats::decode::{N_VALUES, Schema, Slot, Wanted};
use crate::recording::settings::{Quantity, StreamSettings};
use crate::remark::StreamRole;

/// The fields that a stream takes from the messages of one channel.
#[derive(Clone, Debug, Default)]
pub(crate) struct Layout {
    pub(crate) wanted: Vec<Wanted>,
    /// Which of the stream's quantities the messages have.
    pub(crate) has: [bool; N_VALUES],
    /// Whether the messages carry a stamp.
    pub(crate) stamped: bool,
    /// Whether a message carries a list of named transforms.
    pub(crate) is_list: bool,
    /// Whether the messages name a child frame.
    pub(crate) names_child: bool,
}

/// Where poses stand in the known message types.
const POSE_BASES: [&str; 6] =
    ["", "pose.", "pose.pose.", "transform.", "transforms[].transform.", "transforms[]."];
/// Where wrenches stand in the known message types.
const WRENCH_BASES: [&str; 2] = ["wrench.", ""];
/// Where stamps stand, and what their parts are called.
const STAMPS: [&str; 3] = ["header.stamp", "timestamp", "stamp"];
const STAMP_PARTS: [(&str, &str); 3] = [("sec", "nanosec"), ("sec", "nsec"), ("seconds", "nanos")];

impl Layout {
    /// Finds the fields for a stream.
    ///
    /// # Errors
    /// What is missing, in words.
    pub(crate) fn find(
        schema: &Schema,
        role: StreamRole,
        settings: &StreamSettings,
    ) -> Result<Self, String> {
        let mut layout = Self::default();
        let named = settings.fields.keys().any(|quantity| *quantity != Quantity::T);
        if named {
            layout.take_named(schema, role, settings)?;
        } else {
            layout.take_known(schema, role)?;
        }
        let needed: &[usize] = match role {
            StreamRole::Robot | StreamRole::Wrench => &[0, 1],
            StreamRole::Object if layout.has[3] => &[0, 1, 3, 4, 5, 6],
            StreamRole::Object => &[0, 1, 7],
        };
        if let Some(i) = needed.iter().find(|i| !layout.has[**i]) {
            let name = Quantity::of(role)[*i].name();
            return Err(format!("no field for {name}; set streams.{role}.fields.{name}"));
        }
        let list =
            layout.wanted.iter().find_map(|w| w.path.split_once("[].")).map(|(list, _)| list);
        let base = list.map_or(String::new(), |list| format!("{list}[]."));
        layout.is_list = list.is_some();
        layout.take_stamp(schema, &base, settings)?;
        layout.take_frames(schema, &base);
        Ok(layout)
    }

    fn take_named(
        &mut self,
        schema: &Schema,
        role: StreamRole,
        settings: &StreamSettings,
    ) -> Result<(), String> {
        for (i, quantity) in Quantity::of(role).iter().enumerate() {
            let Some(map) = settings.fields.get(quantity) else { continue };
            if !schema.has(&map.column, false) {
                return Err(format!(
                    "no number at `{}`; correct streams.{role}.fields.{}",
                    map.column,
                    quantity.name()
                ));
            }
            self.take(i, map.column.clone());
        }
        Ok(())
    }

    fn take_known(&mut self, schema: &Schema, role: StreamRole) -> Result<(), String> {
        if role == StreamRole::Wrench {
            let base =
                WRENCH_BASES.iter().find(|base| schema.has(&format!("{base}force.x"), false));
            let base = base.ok_or(
                "it holds no wrench (force.x, force.y); set \
                                   streams.wrench.fields for a type of your own",
            )?;
            self.take_if_there(
                schema,
                base,
                &["force.x", "force.y", "force.z", "torque.x", "torque.y", "torque.z"],
            );
            return Ok(());
        }
        for base in POSE_BASES {
            for (position, rotation) in [("position", "orientation"), ("translation", "rotation")] {
                if schema.has(&format!("{base}{rotation}.w"), false) {
                    let axes = ["x", "y", "z"].map(|axis| format!("{position}.{axis}"));
                    let parts = ["x", "y", "z", "w"].map(|part| format!("{rotation}.{part}"));
                    let paths: Vec<&str> = axes.iter().chain(&parts).map(String::as_str).collect();
                    self.take_if_there(schema, base, &paths);
                    return Ok(());
                }
            }
            if schema.has(&format!("{base}theta"), false) {
                self.take_if_there(schema, base, &["x", "y"]);
                self.take(7, format!("{base}theta"));
                return Ok(());
            }
        }
        if role == StreamRole::Robot && schema.has("point.x", false) {
            self.take_if_there(schema, "point.", &["x", "y", "z"]);
            return Ok(());
        }
        Err(format!("it holds no pose; set streams.{role}.fields for a type of your own"))
    }

    fn take_if_there(&mut self, schema: &Schema, base: &str, paths: &[&str]) {
        for (i, path) in paths.iter().enumerate() {
            let path = format!("{base}{path}");
            if schema.has(&path, false) {
                self.take(i, path);
            }
        }
    }

    fn take(&mut self, i: usize, path: String) {
        self.has[i] = true;
        self.wanted.push(Wanted { slot: Slot::Value(i), path });
    }

    fn take_stamp(
        &mut self,
        schema: &Schema,
        base: &str,
        settings: &StreamSettings,
    ) -> Result<(), String> {
        let named = settings.fields.get(&Quantity::T).map(|map| map.column.as_str());
        if let Some(path) = named.filter(|path| schema.has(path, false)) {
            self.wanted.push(Wanted { slot: Slot::Sec, path: path.into() });
            self.stamped = true;
            return Ok(());
        }
        let known = STAMPS.map(|stamp| format!("{base}{stamp}"));
        let places = named.map_or(known.to_vec(), |path| vec![path.to_owned()]);
        for place in places {
            for (sec, nanosec) in STAMP_PARTS {
                let paths = [format!("{place}.{sec}"), format!("{place}.{nanosec}")];
                if paths.iter().all(|path| schema.has(path, false)) {
                    let slots = [Slot::Sec, Slot::Nanosec].into_iter().zip(paths);
                    self.wanted.extend(slots.map(|(slot, path)| Wanted { slot, path }));
                    self.stamped = true;
                    return Ok(());
                }
            }
        }
        named.map_or(Ok(()), |path| Err(format!("no time at `{path}`; correct fields.t")))
    }

    fn take_frames(&mut self, schema: &Schema, base: &str) {
        let child = format!("{base}child_frame_id");
        if schema.has(&child, true) {
            self.names_child = true;
            self.wanted.push(Wanted { slot: Slot::Child, path: child });
        }
        let parents = ["header.frame_id", "parent_frame_id"].map(|name| format!("{base}{name}"));
        if let Some(parent) = parents.into_iter().find(|parent| schema.has(parent, true)) {
            self.wanted.push(Wanted { slot: Slot::Parent, path: parent });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Layout;
    use crate::formats::decode::Schema;
    use crate::input::limits::ReadLimits;
    use crate::recording::settings::{ColumnMap, Quantity, StreamSettings};
    use crate::remark::StreamRole;

    fn json(sample: &str) -> Schema {
        let limits = ReadLimits::default();
        Schema::parse("", ("json", ""), b"", Some(sample.as_bytes()), &limits).unwrap()
    }

    fn find(sample: &str, role: StreamRole) -> Result<Layout, String> {
        Layout::find(&json(sample), role, &StreamSettings::default())
    }

    const POSE: &str = r#"{"position": {"x": 0, "y": 0, "z": 0},
                           "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}"#;
    const TRANSFORM: &str = r#"{"translation": {"x": 0, "y": 0, "z": 0},
                                "rotation": {"x": 0, "y": 0, "z": 0, "w": 1}}"#;

    #[test]
    fn poses_are_found_in_every_known_type() {
        let bare_pose = POSE.to_owned();
        let stamped =
            format!(r#"{{"header": {{"stamp": {{"sec": 0, "nsec": 0}}}}, "pose": {POSE}}}"#);
        let odometry = format!(r#"{{"child_frame_id": "a", "pose": {{"pose": {POSE}}}}}"#);
        let transform = format!(r#"{{"child_frame_id": "a", "transform": {TRANSFORM}}}"#);
        let tf = format!(r#"{{"transforms": [{transform}]}}"#);
        let planar = r#"{"x": 0, "y": 0, "theta": 0}"#.to_owned();
        for sample in [bare_pose, stamped.clone(), odometry, transform, tf.clone(), planar] {
            for role in [StreamRole::Robot, StreamRole::Object] {
                let layout = find(&sample, role).unwrap();
                assert!(layout.has[0] && layout.has[1], "{sample}");
                assert_eq!(layout.is_list, sample == tf);
                assert_eq!(layout.stamped, sample == stamped);
            }
            assert!(find(&sample, StreamRole::Wrench).is_err());
        }
    }

    #[test]
    fn a_point_serves_the_robot_alone() {
        let sample = r#"{"point": {"x": 0, "y": 0, "z": 0}}"#;
        assert!(find(sample, StreamRole::Robot).is_ok());
        assert!(find(sample, StreamRole::Object).unwrap_err().contains("holds no pose"));
    }

    #[test]
    fn fields_of_ones_own_are_checked() {
        let sample =
            r#"{"x_trans": 1.0, "y_trans": 2.0, "rot": 0.5, "time": {"sec": 1, "nsec": 2}}"#;
        let mut settings = StreamSettings::default();
        let set = |settings: &mut StreamSettings, quantity, path: &str| {
            settings.fields.insert(quantity, ColumnMap::plain(path));
        };
        set(&mut settings, Quantity::X, "x_trans");
        set(&mut settings, Quantity::Y, "y_trans");
        let schema = json(sample);
        let message = Layout::find(&schema, StreamRole::Object, &settings).unwrap_err();
        assert_eq!(message, "no field for theta; set streams.object.fields.theta");
        set(&mut settings, Quantity::Theta, "rotation");
        let message = Layout::find(&schema, StreamRole::Object, &settings).unwrap_err();
        assert_eq!(message, "no number at `rotation`; correct streams.object.fields.theta");
        set(&mut settings, Quantity::Theta, "rot");
        set(&mut settings, Quantity::T, "time");
        assert!(Layout::find(&schema, StreamRole::Object, &settings).unwrap().stamped);
        set(&mut settings, Quantity::T, "clock");
        let message = Layout::find(&schema, StreamRole::Object, &settings).unwrap_err();
        assert_eq!(message, "no time at `clock`; correct fields.t");
    }
}
