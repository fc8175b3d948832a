//! What the tables `[streams.robot]`, `[streams.object]` and `[streams.wrench]` may say.

use std::{collections::BTreeMap, fmt};

use serde::{
    Deserialize, Deserializer, Serialize, Serializer,
    de::{MapAccess, Visitor, value::MapAccessDeserializer},
};

use crate::recording::transform::{AxisSigns, Transform};
use crate::remark::StreamRole;

/// Where the three streams are found in a log; the default chooses by type and name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Streams {
    /// Poses of the pusher.
    #[serde(deserialize_with = "pose_settings")]
    pub robot: StreamSettings,
    /// Poses of the object.
    #[serde(deserialize_with = "pose_settings")]
    pub object: StreamSettings,
    /// Forces on the pusher.
    #[serde(deserialize_with = "wrench_settings")]
    pub wrench: StreamSettings,
}

impl Streams {
    /// The settings of one stream.
    #[must_use]
    pub fn of(&self, role: StreamRole) -> &StreamSettings {
        match role {
            StreamRole::Robot => &self.robot,
            StreamRole::Object => &self.object,
            StreamRole::Wrench => &self.wrench,
        }
    }
}

/// Where one stream is found and how its numbers become SI in the world frame.
///
/// A number is scaled and shifted by its [`ColumnMap`] first, then `signs` apply, then `transform`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StreamSettings {
    /// Topic of the log; for CSV the file's name, for MIT files the data set's name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub topic: Option<String>,
    /// Child frame to take from messages that carry several transforms.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub child_frame: Option<String>,
    /// Paths of message fields, e.g. `x = "pose.position.x"`, where the type is not a known one.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub fields: BTreeMap<Quantity, ColumnMap>,
    /// Columns of a CSV file, where the headers are not the default ones.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub columns: BTreeMap<Quantity, ColumnMap>,
    /// Frame of the forces.
    pub frame: WrenchFrame,
    /// Which signed axis of the sensor is x, y and z; only with `frame = "sensor"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub signs: Option<AxisSigns>,
    /// Fixed pose of the stream's own frame in the world.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transform: Option<Transform>,
    /// Which clock gives the time.
    pub time: TimeSource,
}

/// One number of a message or row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs, reason = "the names are the documentation: time, position, quaternion, ...")]
pub enum Quantity {
    T,
    X,
    Y,
    Z,
    Qx,
    Qy,
    Qz,
    Qw,
    Theta,
    Fx,
    Fy,
    Fz,
    Tx,
    Ty,
    Tz,
}

impl Quantity {
    /// What a pose may consist of.
    pub(crate) const POSE: [Self; 8] =
        [Self::X, Self::Y, Self::Z, Self::Qx, Self::Qy, Self::Qz, Self::Qw, Self::Theta];
    /// What a wrench may consist of.
    pub(crate) const WRENCH: [Self; 6] =
        [Self::Fx, Self::Fy, Self::Fz, Self::Tx, Self::Ty, Self::Tz];

    /// The quantities of a stream, in the order of a row's values.
    pub(crate) fn of(role: StreamRole) -> &'static [Self] {
        if role == StreamRole::Wrench { &Self::WRENCH } else { &Self::POSE }
    }

    /// The key in `dataset.toml`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::T => "t",
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::Qx => "qx",
            Self::Qy => "qy",
            Self::Qz => "qz",
            Self::Qw => "qw",
            Self::Theta => "theta",
            Self::Fx => "fx",
            Self::Fy => "fy",
            Self::Fz => "fz",
            Self::Tx => "tx",
            Self::Ty => "ty",
            Self::Tz => "tz",
        }
    }
}

/// A column or field and the affine map to SI units: `value = scale · number + offset`.
///
/// In TOML either the bare name or a table, `{ column = "X [mm]", scale = 1e-3 }`; `field` is
/// another word for `column`.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnMap {
    /// Header of the column, or path of the field.
    pub column: String,
    /// Factor to SI units.
    pub scale: f64,
    /// Offset in SI units, added after scaling.
    pub offset: f64,
}

impl ColumnMap {
    /// The column as it is, without scale and offset.
    #[must_use]
    pub fn plain(column: impl Into<String>) -> Self {
        Self { column: column.into(), scale: 1.0, offset: 0.0 }
    }
}

/// Frame in which forces are logged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WrenchFrame {
    /// Forces of the object on the pusher, in the world frame.
    #[default]
    World,
    /// Forces in the frame of a sensor that keeps its orientation in the world.
    Sensor,
}

/// The clock that gives a sample its time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TimeSource {
    /// The stamp in the message; a missing or zero stamp falls back to the log time.
    #[default]
    Stamp,
    /// The time at which the message was logged.
    Log,
}

fn pose_settings<'de, D: Deserializer<'de>>(deserializer: D) -> Result<StreamSettings, D::Error> {
    let settings = StreamSettings::deserialize(deserializer)?;
    if settings.frame == WrenchFrame::Sensor || settings.signs.is_some() {
        return Err(serde::de::Error::custom(
            "`frame` and `signs` are keys of streams.wrench; poses take `transform`",
        ));
    }
    check_quantities::<D>(&settings, &Quantity::POSE)?;
    Ok(settings)
}

fn wrench_settings<'de, D: Deserializer<'de>>(deserializer: D) -> Result<StreamSettings, D::Error> {
    let settings = StreamSettings::deserialize(deserializer)?;
    let rotated = settings.signs.is_some() || settings.transform.is_some();
    if rotated && settings.frame == WrenchFrame::World {
        return Err(serde::de::Error::custom(
            "`signs` and `transform` need frame = \"sensor\": forces in the world frame have none",
        ));
    }
    check_quantities::<D>(&settings, &Quantity::WRENCH)?;
    Ok(settings)
}

fn check_quantities<'de, D: Deserializer<'de>>(
    settings: &StreamSettings,
    known: &[Quantity],
) -> Result<(), D::Error> {
    let maps = settings.fields.iter().chain(&settings.columns);
    for (&quantity, map) in maps {
        if quantity != Quantity::T && !known.contains(&quantity) {
            let names: Vec<_> = known.iter().map(|known| known.name()).collect();
            return Err(serde::de::Error::custom(format!(
                "`{}` is no quantity of this stream, expected t, {}",
                quantity.name(),
                names.join(", ")
            )));
        }
        if !(map.scale.is_finite() && map.scale != 0.0 && map.offset.is_finite()) {
            return Err(serde::de::Error::custom(format!(
                "`{}` must have a finite scale other than 0 and a finite offset, got {} and {}",
                quantity.name(),
                map.scale,
                map.offset
            )));
        }
    }
    Ok(())
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ColumnTable {
    #[serde(alias = "field")]
    column: String,
    #[serde(default = "one")]
    scale: f64,
    #[serde(default)]
    offset: f64,
}

fn one() -> f64 {
    1.0
}

impl Serialize for ColumnMap {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.scale == 1.0 && self.offset == 0.0 {
            return serializer.serialize_str(&self.column);
        }
        let Self { column, scale, offset } = self.clone();
        ColumnTable { column, scale, offset }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for ColumnMap {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ColumnVisitor)
    }
}

struct ColumnVisitor;

impl<'de> Visitor<'de> for ColumnVisitor {
    type Value = ColumnMap;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a name or a table { column, scale, offset }")
    }

    fn visit_str<E: serde::de::Error>(self, column: &str) -> Result<ColumnMap, E> {
        Ok(ColumnMap::plain(column))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<ColumnMap, A::Error> {
        let ColumnTable { column, scale, offset } =
            ColumnTable::deserialize(MapAccessDeserializer::new(map))?;
        Ok(ColumnMap { column, scale, offset })
    }
}

#[cfg(test)]
mod tests {
    use super::{ColumnMap, Quantity, Streams, TimeSource, WrenchFrame};

    fn error(text: &str) -> String {
        toml::from_str::<Streams>(text).unwrap_err().to_string()
    }

    #[test]
    fn the_documented_keys_are_read() {
        let streams: Streams = toml::from_str(
            r#"
            [robot]
            topic = "/tip"
            time = "log"
            columns = { x = { column = "X [mm]", scale = 1e-3 }, t = "stamp" }
            [object]
            transform = { tf_parent = "world", tf_child = "viconworld" }
            [wrench]
            frame = "sensor"
            signs = ["-x", "+y", "-z"]
            transform = { translation_m = [0.0, 0.1], yaw_rad = 1.5 }
            "#,
        )
        .unwrap();
        assert_eq!(streams.robot.topic.as_deref(), Some("/tip"));
        assert_eq!(streams.robot.time, TimeSource::Log);
        assert_eq!(streams.robot.columns[&Quantity::T], ColumnMap::plain("stamp"));
        assert_eq!(streams.robot.columns[&Quantity::X].scale, 1e-3);
        assert_eq!(streams.wrench.frame, WrenchFrame::Sensor);
        let text = toml::to_string(&streams).unwrap();
        assert_eq!(toml::from_str::<Streams>(&text).unwrap(), streams);
    }

    #[test]
    fn a_wrong_key_names_its_line_and_the_allowed_ones() {
        let message = error("[robot]\ntopik = \"/tip\"\n");
        assert!(message.contains("line 2"), "{message}");
        assert!(message.contains("unknown field `topik`"), "{message}");
        assert!(message.contains("`topic`"), "{message}");
        let message = error("[robot.columns]\nfx = \"a\"\n");
        assert!(message.contains("`fx` is no quantity of this stream"), "{message}");
        let message = error("[robot.columns]\nx = { column = \"a\", scale = 0.0 }\n");
        assert!(message.contains("finite scale other than 0"), "{message}");
        let message = error("[robot.columns]\nx = 3\n");
        assert!(message.contains("a name or a table"), "{message}");
    }

    #[test]
    fn signs_need_the_sensor_frame() {
        let message = error("[wrench]\nsigns = [\"-x\", \"+y\", \"-z\"]\n");
        assert!(message.contains("frame = \"sensor\""), "{message}");
        let message = error("[object]\nsigns = [\"-x\", \"+y\", \"-z\"]\n");
        assert!(message.contains("poses take `transform`"), "{message}");
        let message = error("[wrench]\nframe = \"tool\"\n");
        assert!(message.contains("unknown variant `tool`, expected `world` or `sensor`"));
    }
}
