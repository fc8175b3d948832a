//! Presets: what is known of public data sets, so that they are read without a manifest.

use std::{fs, path::Path};

use crate::error::DatasetError;
use crate::manifest::Manifest;
use crate::manifest::object::shape_in_name;

/// A public data set whose units, signs, frames and shapes are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// The MIT push data set's raw pushes, JSON or HDF5.
    MitPush,
    /// ROS recordings of the same rig of 2015, as bag or MCAP.
    MitRig2015,
    /// The step table of the MIT square at 20 mm/s and 0.2 s.
    MitTable,
    /// The end points of the MIT pushes: the object's poses before and after each.
    MitEndpoints,
    /// Pushes of a triangle on known supports, with the object's poses before and after each.
    CmuKnownSupports,
}

impl Preset {
    /// Every preset.
    pub const ALL: [Self; 5] = [
        Self::MitPush,
        Self::MitRig2015,
        Self::MitTable,
        Self::MitEndpoints,
        Self::CmuKnownSupports,
    ];

    /// Its name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::MitPush => "mit-push",
            Self::MitRig2015 => "mit-rig-2015",
            Self::MitTable => "mit-table",
            Self::MitEndpoints => "mit-endpoints",
            Self::CmuKnownSupports => "cmu-known-supports",
        }
    }

    /// The preset with this name.
    #[must_use]
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|preset| preset.name() == name)
    }

    /// The commented file that `init` writes: a manifest, or the mapping of a foreign table.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::MitPush => include_str!("presets/mit-push.toml"),
            Self::MitRig2015 => include_str!("presets/mit-rig-2015.toml"),
            Self::MitTable => include_str!("presets/mit-table.toml"),
            Self::MitEndpoints => include_str!("presets/mit-endpoints.toml"),
            Self::CmuKnownSupports => include_str!("presets/cmu-known-supports.toml"),
        }
    }

    /// The manifest of a preset for recordings; none for tables.
    ///
    /// # Errors
    /// None for the texts that are built in, which a test reads.
    pub fn manifest(self) -> Option<Result<Manifest, DatasetError>> {
        let path = format!("preset {}", self.name());
        match self {
            Self::MitTable => None,
            _ => Some(Manifest::parse(self.text(), Path::new(&path))),
        }
    }

    /// The preset whose recordings a folder without manifest holds, by the names of its files.
    #[must_use]
    pub fn of_recordings(dir: &Path) -> Option<Self> {
        let names: Vec<_> = fs::read_dir(dir)
            .ok()?
            .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
            .collect();
        let any = |test: fn(&str) -> bool| names.iter().any(|name| test(name));
        if any(|name| shape_in_name(name).is_some() && name.starts_with("motion_surface=")) {
            Some(Self::MitPush)
        } else if any(|name| {
            (name.ends_with(".bag") || name.ends_with(".mcap")) && name.contains("_block_Test_")
        }) {
            Some(Self::MitRig2015)
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Preset;
    use crate::ingest::table_mapping::TableMapping;
    use crate::manifest::object::ObjectChoice;

    #[test]
    fn every_preset_has_a_name_and_a_text_that_is_read() {
        for preset in Preset::ALL {
            assert_eq!(Preset::by_name(preset.name()), Some(preset));
            if let Some(manifest) = preset.manifest() {
                manifest.unwrap();
            }
        }
        TableMapping::mit_table().unwrap();
        assert_eq!(Preset::by_name("mit"), None);
    }

    #[test]
    fn shapes_come_from_the_names_of_the_files() {
        let object = Preset::MitPush.manifest().unwrap().unwrap().object;
        assert_eq!(object, ObjectChoice::ByFileName);
        let name = "motion_surface=plywood_shape=tri2_a=0_v=100_i=0.000_s=0.000_t=0.000";
        assert_eq!(object.of(name).unwrap().name, "tri2");
        let message = object.of("motion_shape=tri9_a=0").unwrap_err().to_string();
        assert!(message.starts_with("unknown object `tri9`"), "{message}");
    }

    #[test]
    fn a_folder_is_known_by_the_names_in_it() {
        let dir = tempfile::tempdir().unwrap();
        assert_eq!(Preset::of_recordings(dir.path()), None);
        std::fs::write(dir.path().join("St_block_Test_st_1.mcap"), "").unwrap();
        assert_eq!(Preset::of_recordings(dir.path()), Some(Preset::MitRig2015));
        std::fs::write(dir.path().join("motion_surface=abs_shape=hex_a=0.json"), "").unwrap();
        assert_eq!(Preset::of_recordings(dir.path()), Some(Preset::MitPush));
    }
}
