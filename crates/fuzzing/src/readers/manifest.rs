//! What stands beside recordings and tables: manifests with their sessions, and mappings.

use std::fs;
use std::path::Path;

use anyhow::Result;
use dataset::{Manifest, ObjectChoice, Preset, RecordingSet, TableMapping};

use super::super::reader::{NEXT_FILE, Reader, Verdict, not_finite, write_files};
use super::recording::{push, write};

/// A set's manifest and sessions.
pub(super) struct Manifests;
/// The mapping of a table of others.
pub(super) struct Mappings;

/// A manifest of recordings beside it.
pub(super) const MANIFEST: &str = r#"name = "square"

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
path = "."
"#;

/// Every key that a manifest may have.
const FULL: &str = r#"name = "full"

[object]
shape = "polygon"
vertices_m = [[-0.05, -0.05], [0.05, -0.05], [0.0, 0.06]]
mass_kg = 0.8
moment_of_inertia_kg_m2 = 0.001
center_of_mass_m = [0.001, 0.0]

[pusher]
radius_m = 0.005
friction = 0.3

[support]
friction = 0.2
gravity_m_s2 = 9.81

[recordings]
format = "mit-json"
path = "."

[streams.robot]
topic = "tip_pose"
[streams.object]
topic = "object_pose"
transform = { translation_m = [0.1, 0.0], yaw_rad = 0.5 }
[streams.wrench]
topic = "ft_wrench"
frame = "sensor"
signs = ["-x", "+y", "-z"]
columns = { fx = { column = "F [kN]", scale = 1e3, offset = 0.5 } }
"#;

const SESSIONS: &str = "recording,session,repeat\npush,monday,a\npush-1,monday,\n";

impl Reader for Manifests {
    fn name(&self) -> &'static str {
        "manifest"
    }

    fn corpus(&self, _: &Path) -> Result<Vec<Vec<u8>>> {
        let bundle = |manifest: &str| [manifest, SESSIONS].join(&char::from(NEXT_FILE).to_string());
        let ellipse = MANIFEST.replace(
            "shape = \"square\"\nside_m = 0.09",
            "shape = \"ellipse\"\nsemi_axes_m = [0.05, 0.06]",
        );
        Ok([MANIFEST, FULL, &ellipse].map(|text| bundle(text).into_bytes()).into())
    }

    fn tokens(&self) -> &'static [&'static str] {
        &[
            "shape = \"rect1\"",
            "shape = \"ellipse\"",
            "semi_axes_m",
            "vertices_m",
            "[[",
            "]]",
            "\"\"\"",
            "columns",
            "scale",
            "transform",
            "path = \"/\"",
            "path = \"..\"",
            "mcap",
            "csv",
            "1979-05-27",
            "\u{1e}",
            "{}",
            "[object]",
        ]
    }

    fn read(&self, dir: &Path, input: &[u8]) -> Verdict {
        if let Err(error) = prepare(dir)
            .and_then(|()| Ok(write_files(dir, &["dataset.toml", "sessions.csv"], input)?))
        {
            return Verdict::Wrong(format!("scratch is not usable: {error}"));
        }
        Verdict::of(RecordingSet::open(dir), |set| wrong(set.manifest()))
    }
}

/// The recording that the manifest is of.
fn prepare(dir: &Path) -> Result<()> {
    if !dir.join("push.json").exists() {
        write("mit-json", &push(2), dir)?;
    }
    Ok(())
}

fn wrong(manifest: &Manifest) -> Option<String> {
    let Manifest { object, pusher, support, .. } = manifest;
    let numbers = [pusher.radius, pusher.friction, support.friction, support.gravity];
    if let Some(wrong) = not_finite([("a constant", &numbers[..])]) {
        return Some(wrong);
    }
    let ObjectChoice::Fixed(object) = object else { return None };
    let inertia = [object.mass, object.moment_of_inertia];
    not_finite([("inertia", &inertia[..])])
}

impl Reader for Mappings {
    fn name(&self) -> &'static str {
        "mapping"
    }

    fn corpus(&self, _: &Path) -> Result<Vec<Vec<u8>>> {
        Ok(vec![Preset::MitTable.text().as_bytes().to_vec()])
    }

    fn tokens(&self) -> &'static [&'static str] {
        &["[constants]", "[columns]", "scale", "offset", "\"hex\"", "\"ellip1\"", "edge", "dt_s"]
    }

    fn read(&self, dir: &Path, input: &[u8]) -> Verdict {
        let path = dir.join("mapping.toml");
        match fs::write(&path, input) {
            Ok(()) => Verdict::of(TableMapping::read(&path), |_| None),
            Err(error) => Verdict::Wrong(format!("scratch is not usable: {error}")),
        }
    }
}
