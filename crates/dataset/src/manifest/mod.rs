//! A folder of recordings goes in, what was pushed, by what, on what, and where the recordings are,
//! comes out: the manifest of a recording set, `dataset.toml`.

pub(crate) mod init;
pub(crate) mod object;
pub(crate) mod object_support;
mod open_values;
pub(crate) mod part;
pub(crate) mod preset;
pub(crate) mod recording_set;
pub(crate) mod session;
pub(crate) mod text;
pub(crate) mod unread;

use std::path::Path;

use serde::Deserialize;
use serde_spanned::Spanned;

use crate::error::DatasetError;
use crate::input::limits::ReadLimits;
use crate::input::map::read_text;
use crate::manifest::object::{ObjectChoice, ObjectTable};
use crate::manifest::object_support::ObjectSupport;
use crate::manifest::text::{LARGEST, Source};
use crate::recording::settings::Streams;

/// Name of the manifest within a recording set.
pub const MANIFEST_NAME: &str = "dataset.toml";

/// What is known of a recording set beforehand.
#[derive(Clone, Debug, PartialEq)]
pub struct Manifest {
    /// Title of the set.
    pub name: String,
    /// The pushed object.
    pub object: ObjectChoice,
    /// What it rests on.
    pub object_support: ObjectSupport,
    /// The pusher.
    pub pusher: PusherSpec,
    /// The table.
    pub support: SupportSpec,
    /// Where the recordings are.
    pub recordings: RecordingsSpec,
    /// How their streams are found.
    pub streams: Streams,
    /// What reading one of them may cost.
    pub limits: ReadLimits,
}

/// The round pusher, nominally.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PusherSpec {
    /// Radius, in m; 0 for a point.
    pub radius: f64,
    /// Coefficient of friction between pusher and object.
    pub friction: f64,
}

/// The table, nominally.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupportSpec {
    /// Coefficient of friction between object and table.
    pub friction: f64,
    /// Gravity, in m/s².
    pub gravity: f64,
}

/// Where the recordings are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordingsSpec {
    /// Name of the log format; none takes the one that finds recordings.
    pub format: Option<String>,
    /// Folder, relative to the manifest's.
    pub path: String,
}

impl Manifest {
    /// Reads and checks a manifest.
    ///
    /// # Errors
    /// `Io`; `NotAFile` and `OverLimit` as [`read_text`]; `Parse` with the line for TOML that is broken, keys that are not known or missing, and
    /// wrong types; `Manifest` with line, key, value, unit and allowed values for the rest.
    pub fn read(path: &Path) -> Result<Self, DatasetError> {
        let text = read_text(path)?;
        Self::parse(&text, path)
    }

    /// Checks the text of a manifest; `path` is for messages alone.
    ///
    /// # Errors
    /// `Parse` and `Manifest` as [`Manifest::read`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, DatasetError> {
        let source = Source::new(text, path);
        let table: ManifestTable = source.parse_filled()?;
        let ManifestTable { name, object, pusher, support, recordings, streams, limits } = table;
        let chosen = object.check(&source)?;
        Ok(Self {
            name,
            object_support: ObjectSupport::of(&object, &chosen, &source)?,
            object: chosen,
            pusher: pusher.check(&source)?,
            support: support.check(&source)?,
            recordings: RecordingsSpec {
                format: recordings.format.map(|format| source.format(format)).transpose()?,
                path: recordings.path,
            },
            streams,
            limits,
        })
    }
}

const STANDARD_GRAVITY: f64 = 9.81;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ManifestTable {
    name: String,
    object: ObjectTable,
    pusher: PusherTable,
    support: SupportTable,
    recordings: RecordingsTable,
    #[serde(default)]
    streams: Streams,
    #[serde(default)]
    limits: ReadLimits,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PusherTable {
    radius_m: Spanned<f64>,
    friction: Spanned<f64>,
}

impl PusherTable {
    pub(crate) fn check(&self, source: &Source<'_>) -> Result<PusherSpec, DatasetError> {
        Ok(PusherSpec {
            radius: source.not_negative("pusher.radius_m", &self.radius_m, " m", LARGEST)?,
            friction: source.friction("pusher.friction", &self.friction)?,
        })
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SupportTable {
    friction: Spanned<f64>,
    gravity_m_s2: Option<Spanned<f64>>,
}

impl SupportTable {
    pub(crate) fn check(&self, source: &Source<'_>) -> Result<SupportSpec, DatasetError> {
        let gravity = match &self.gravity_m_s2 {
            Some(gravity) => source.positive("support.gravity_m_s2", gravity, " m/s²")?,
            None => STANDARD_GRAVITY,
        };
        let friction = source.friction("support.friction", &self.friction)?;
        Ok(SupportSpec { friction, gravity })
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RecordingsTable {
    format: Option<Spanned<String>>,
    #[serde(default = "here")]
    path: String,
}

fn here() -> String {
    ".".to_owned()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::Manifest;
    use crate::manifest::object::ObjectChoice;

    const GOOD: &str = r#"name = "square on abs"

[object]
shape = "square"
side_m = 0.09
mass_kg = 0.8374

[pusher]
radius_m = 0.00475
friction = 0.25

[support]
friction = 0.25
gravity_m_s2 = 9.81

[recordings]
format = "mcap"
path = "pushes"

[streams.robot]
topic = "/robot/tip_pose"
"#;

    fn error(from: &str, to: &str) -> String {
        assert!(GOOD.contains(from));
        let text = GOOD.replacen(from, to, 1);
        Manifest::parse(&text, Path::new("set/dataset.toml")).unwrap_err().to_string()
    }

    #[test]
    fn the_documented_manifest_is_read() {
        let manifest = Manifest::parse(GOOD, Path::new("dataset.toml")).unwrap();
        assert_eq!(manifest.name, "square on abs");
        assert_eq!(manifest.pusher.radius, 0.00475);
        assert_eq!(manifest.recordings.format.as_deref(), Some("mcap"));
        assert_eq!(manifest.streams.robot.topic.as_deref(), Some("/robot/tip_pose"));
        let ObjectChoice::Fixed(object) = manifest.object else { panic!("one object") };
        assert_eq!(object.mass, 0.8374);
        assert!((object.moment_of_inertia - 0.8374 * 0.09 * 0.09 / 6.0).abs() < 1e-12);
    }

    #[test]
    fn impossible_values_name_file_line_key_value_unit_and_range() {
        assert_eq!(
            error("radius_m = 0.00475", "radius_m = -4.75"),
            "set/dataset.toml:9: pusher.radius_m = -4.75 m is not allowed, expected a number from 0 \
             to 1000000"
        );
        assert_eq!(
            error("friction = 0.25", "friction = nan"),
            "set/dataset.toml:10: pusher.friction = NaN is not allowed, expected a number from 0 to \
             10"
        );
        assert!(
            error("friction = 0.25", "friction = 1e308").contains("expected a number from 0 to 10")
        );
        assert!(error("gravity_m_s2 = 9.81", "gravity_m_s2 = 1e300").contains("1e-12 to 1e6"));
        assert_eq!(
            error("\"mcap\"", "\"rosbag9\""),
            "set/dataset.toml:17: recordings.format = rosbag9 is not allowed, expected one of \
             mcap, csv, mit-json, mit-hdf5, ros1-bag, endpoints"
        );
        assert_eq!(
            error("\"square\"", "\"sqare\""),
            "set/dataset.toml:4: object.shape = sqare is not allowed, expected one of square, \
             rectangle, polygon, ellipse, by-file-name, rect1, rect2, rect3, tri1, tri2, tri3, \
             ellip1, ellip2, ellip3, hex, butter"
        );
        assert_eq!(
            error("side_m = 0.09", "side_m = 90.0"),
            "set/dataset.toml:5: object.side_m = 90 m is not allowed, expected a length from \
             0.0001 to 10 m (lengths are in m, not mm)"
        );
    }

    #[test]
    fn a_pusher_may_be_a_point() {
        let text = GOOD.replacen("radius_m = 0.00475", "radius_m = 0.0", 1);
        let manifest = Manifest::parse(&text, Path::new("dataset.toml")).unwrap();
        assert_eq!(manifest.pusher.radius, 0.0);
    }

    #[test]
    fn unknown_and_missing_keys_name_the_line_and_what_is_known() {
        let message = error("gravity_m_s2 = 9.81", "gravity = 9.81");
        assert!(message.starts_with("set/dataset.toml:14: unknown field `gravity`"), "{message}");
        assert!(message.contains("gravity_m_s2"), "{message}");
        let message = error("topic = ", "topik = ");
        assert!(message.starts_with("set/dataset.toml:21: unknown field `topik`"), "{message}");
        let message = error("side_m = 0.09\n", "");
        assert!(message.contains("object.side_m = (missing)"), "{message}");
        let message = error("side_m = 0.09", "side_m = 0.09\nwidth_m = 0.1");
        assert!(message.contains(":6: object.width_m = 0.1 m is not allowed"), "{message}");
        let message = error("friction = 0.25", "friction = \"0.25\"");
        assert!(message.starts_with("set/dataset.toml:10: invalid type: string"), "{message}");
    }

    #[test]
    fn all_that_is_open_is_named_at_once() {
        let text = GOOD.replacen("radius_m = 0.00475", "radius_m = \"TODO\"", 1);
        let text =
            text.replacen("friction = 0.25\n\n[support]\nfriction = 0.25\n", "[support]\n", 1);
        let text = text.replacen("mass_kg = 0.8374\n", "", 1);
        let message = |text: &str| {
            Manifest::parse(text, Path::new("set/dataset.toml")).unwrap_err().to_string()
        };
        assert_eq!(
            message(&text),
            "set/dataset.toml:8: 4 values are still to be filled in: object.mass_kg (in kg), which is \
             missing, pusher.radius_m in line 8 (in m), pusher.friction (nominal, pusher-object), which \
             is missing, support.friction (nominal, object-table), which is missing"
        );
        let text = text.replacen("shape = \"square\"\nside_m = 0.09", "shape = \"hex\"", 1);
        assert!(
            message(&text).contains(": 3 values are"),
            "an MIT object has a mass: {}",
            message(&text)
        );
        let message = message("name = \"a\"\n[recordings]\n");
        assert!(message.starts_with("set/dataset.toml:1: 5 values"), "{message}");
    }

    #[test]
    fn degenerate_polygons_are_named() {
        let polygon = |vertices: &str| {
            error(
                "shape = \"square\"\nside_m = 0.09",
                &format!("shape = \"polygon\"\nvertices_m = {vertices}"),
            )
        };
        let message = polygon("[[0.0, 0.0], [0.1, 0.0]]");
        assert!(message.starts_with("set/dataset.toml:5: object.vertices_m"), "{message}");
        assert!(message.contains("at least 3 vertices, got 2"), "{message}");
        let message = polygon("[[0.0, 0.0], [0.0, 0.1], [0.1, 0.0]]");
        assert!(message.contains("clockwise"), "{message}");
        let message = polygon("[[0.0, 0.0], [0.1, 0.0], [0.2, 0.0]]");
        assert!(message.contains("set/dataset.toml:5"), "{message}");
    }
}
