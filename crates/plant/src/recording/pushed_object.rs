//! The object that is pushed, and what is nominally known of the rig.

use std::path::Path;

use dataset::{Manifest, ObjectChoice, ObjectSpec};
use serde::{Deserialize, Serialize};

use crate::{PlantError, Sensors, Truth};

/// An object for a recording set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "kebab-case", deny_unknown_fields)]
pub enum PushedObject {
    /// One of the eleven objects of the MIT push data set.
    Mit {
        /// Its name there.
        name: String,
    },
    /// A square plate.
    Square {
        /// Side, in m.
        side: f64,
        /// Mass, in kg.
        mass: f64,
    },
    /// A rectangular plate.
    Rectangle {
        /// Extent along x, in m.
        width: f64,
        /// Extent along y, in m.
        height: f64,
        /// Mass, in kg.
        mass: f64,
    },
    /// Any plate without crossing edges.
    Polygon {
        /// Corners, counter-clockwise, in m.
        vertices: Vec<[f64; 2]>,
        /// Mass, in kg.
        mass: f64,
    },
    /// An elliptic plate.
    Ellipse {
        /// Semi-axes along x and y, in m.
        semi_axes: [f64; 2],
        /// Mass, in kg.
        mass: f64,
    },
    /// An object as a manifest tells it.
    Told {
        /// The keys of `[object]` in `dataset.toml`.
        object: toml::Table,
    },
}

impl Default for PushedObject {
    /// The thesis' square: 90 mm, 0.8374 kg.
    fn default() -> Self {
        Self::Mit { name: "rect1".into() }
    }
}

/// What the manifest claims of the rig.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Nominal {
    /// Radius of the tip, in m.
    pub pusher_radius: f64,
    /// Friction of the tip.
    pub pusher_friction: f64,
    /// Friction of the support.
    pub support_friction: f64,
    /// Gravity, in m/s².
    pub gravity: f64,
}

impl Default for Nominal {
    fn default() -> Self {
        Self {
            pusher_radius: 0.00475,
            pusher_friction: 0.25,
            support_friction: 0.25,
            gravity: 9.81,
        }
    }
}

impl Nominal {
    /// A plain rig that is just as the manifest claims.
    #[must_use]
    pub fn truth(&self) -> Truth {
        let mut truth = Truth::default();
        truth.tip.radius = self.pusher_radius;
        truth.tip_friction.coefficient = self.pusher_friction;
        truth.support_friction.coefficient = self.support_friction;
        truth
    }
}

impl PushedObject {
    /// The object's part of `dataset.toml`.
    fn lines(&self) -> String {
        match self {
            Self::Mit { name } => format!("shape = {}", quoted(name)),
            Self::Square { side, mass } => {
                format!("shape = \"square\"\nside_m = {side:?}\nmass_kg = {mass:?}")
            }
            Self::Rectangle { width, height, mass } => format!(
                "shape = \"rectangle\"\nwidth_m = {width:?}\nheight_m = {height:?}\n\
                 mass_kg = {mass:?}"
            ),
            Self::Polygon { vertices, mass } => {
                format!("shape = \"polygon\"\nvertices_m = {vertices:?}\nmass_kg = {mass:?}")
            }
            Self::Ellipse { semi_axes, mass } => {
                format!("shape = \"ellipse\"\nsemi_axes_m = {semi_axes:?}\nmass_kg = {mass:?}")
            }
            Self::Told { object } => object.to_string().trim_end().to_owned(),
        }
    }
}

/// The object that a recording set is about, and what is nominally known of its rig.
///
/// - `path`: a `dataset.toml`, or the folder of the set.
///
/// # Errors
/// `Dataset` for a manifest that cannot be read or is wrong; `Design` for one that tells the object
/// by the names of its recordings.
pub fn read_rig(path: &Path) -> Result<(PushedObject, Nominal), PlantError> {
    let path = if path.is_dir() { path.join(dataset::MANIFEST_NAME) } else { path.to_owned() };
    let text = dataset::read_text(&path)?;
    let manifest = Manifest::parse(&text, &path)?;
    if manifest.object == ObjectChoice::ByFileName {
        let what = "tells the object by the names of its recordings; name an object instead";
        return Err(PlantError::Design { what: format!("{} {what}", path.display()) });
    }
    let mut tables: toml::Table = text
        .parse()
        .map_err(|error: toml::de::Error| PlantError::Design { what: error.to_string() })?;
    let object = match tables.remove("object") {
        Some(toml::Value::Table(object)) => object,
        _ => toml::Table::new(),
    };
    let nominal = Nominal {
        pusher_radius: manifest.pusher.radius,
        pusher_friction: manifest.pusher.friction,
        support_friction: manifest.support.friction,
        gravity: manifest.support.gravity,
    };
    Ok((PushedObject::Told { object }, nominal))
}

/// The text of `dataset.toml`: what a user of the set is told.
pub(crate) fn manifest_text(
    name: &str,
    object: &PushedObject,
    nominal: &Nominal,
    format: &str,
) -> String {
    format!(
        "name = {}\n\n[object]\n{}\n\n[pusher]\nradius_m = {:?}\nfriction = {:?}\n\n\
         [support]\nfriction = {:?}\ngravity_m_s2 = {:?}\n\n\
         [recordings]\nformat = \"{format}\"\npath = \"pushes\"\n",
        quoted(name),
        object.lines(),
        nominal.pusher_radius,
        nominal.pusher_friction,
        nominal.support_friction,
        nominal.gravity,
    )
}

/// What the manifest says of the streams that were recorded, in formats whose streams have names.
pub(crate) fn streams_text(format: &str, sensors: &Sensors) -> String {
    if !["mcap", "ros1-bag"].contains(&format) {
        return String::new();
    }
    let named = [
        ("robot", "/robot/tip_pose", true),
        ("object", "/vicon/object_pose", true),
        ("wrench", "/ft_sensor/wrench", sensors.force.rate > 0.0),
    ];
    let recorded = named.iter().filter(|(_, _, is_recorded)| *is_recorded);
    recorded.map(|(role, topic, _)| format!("\n[streams.{role}]\ntopic = \"{topic}\"\n")).collect()
}

/// The object that a manifest's text tells of.
///
/// # Errors
/// `Dataset` for an object that is not possible, `Design` for one that is not told.
pub(crate) fn object_of(text: &str, path: &Path) -> Result<ObjectSpec, PlantError> {
    let manifest = Manifest::parse(text, path)?;
    Ok(manifest.object.of("")?)
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

#[cfg(test)]
mod tests {
    use super::{Nominal, PushedObject, manifest_text, object_of, read_rig};
    use crate::Truth;
    use std::path::Path;

    #[test]
    fn the_usual_claims_are_true_of_the_usual_rig() {
        assert_eq!(Nominal::default().truth(), Truth::default());
    }

    #[test]
    fn a_rig_is_read_from_a_manifest_or_its_folder_and_told_again() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join(dataset::MANIFEST_NAME);
        let nominal = Nominal { pusher_radius: 0.006, gravity: 9.8, ..Nominal::default() };
        let told =
            PushedObject::Polygon { vertices: vec![[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]], mass: 1.5 };
        let text = manifest_text("a", &told, &nominal, "csv")
            .replace("mass_kg", "center_of_mass_m = [0.02, 0.03]\nmass_kg");
        std::fs::write(&path, &text).unwrap();
        for from in [dir.path(), &path] {
            let (object, read) = read_rig(from).unwrap();
            assert_eq!(read, nominal);
            let again = manifest_text("a", &object, &read, "csv");
            assert_eq!(object_of(&again, &path).unwrap(), object_of(&text, &path).unwrap());
        }
        std::fs::write(&path, text.replace("vertices_m", "vertices_mm")).unwrap();
        let message = read_rig(&path).unwrap_err().to_string();
        assert!(message.contains("dataset.toml:5"), "{message}");
        let by_name = "shape = \"by-file-name\"\n\n[pusher]";
        let (start, end) = (text.find("shape").unwrap(), text.find("[pusher]").unwrap());
        std::fs::write(&path, text.replace(&text[start..end + 8], by_name)).unwrap();
        let message = read_rig(&path).unwrap_err().to_string();
        assert!(message.contains("by the names of its recordings"), "{message}");
    }

    #[test]
    fn every_object_is_told_in_a_manifest_that_is_read_back() {
        for (object, area) in [
            (PushedObject::default(), 0.0081),
            (PushedObject::Square { side: 0.1, mass: 1.0 }, 0.01),
            (PushedObject::Rectangle { width: 0.1, height: 0.05, mass: 1.0 }, 0.005),
            (
                PushedObject::Polygon {
                    vertices: vec![[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]],
                    mass: 1.0,
                },
                0.005,
            ),
            (
                PushedObject::Ellipse { semi_axes: [0.05, 0.04], mass: 1.0 },
                0.002 * std::f64::consts::PI,
            ),
        ] {
            let text = manifest_text("a \"set\"", &object, &Nominal::default(), "mcap");
            let spec = object_of(&text, Path::new("dataset.toml")).unwrap();
            assert!((spec.shape.area() - area).abs() < 1e-12, "{text}");
        }
        let object = PushedObject::Square { side: -0.1, mass: 1.0 };
        let text = manifest_text("a", &object, &Nominal::default(), "csv");
        assert!(object_of(&text, Path::new("dataset.toml")).is_err());
    }
}
