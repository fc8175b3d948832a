//! What of a simulation no option names: sensors, scatter, the design's details, what is true.

use std::path::Path;

use anyhow::{Context, Result};
use plant::{Design, Numerics, Scatter, Sensors, Truth};
use serde::{Deserialize, Serialize};

/// A file of settings; what it leaves out is as usual.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct SettingsFile {
    /// Which pushes are made; options of the command line come before it.
    pub(super) design: Design,
    /// What records them.
    pub(super) sensors: Sensors,
    /// How they scatter.
    pub(super) scatter: Scatter,
    /// How finely they are simulated.
    pub(super) numerics: Numerics,
    /// What is true before anything is hidden; as the manifest claims if it is left out.
    pub(super) truth: Option<Truth>,
}

impl SettingsFile {
    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read, or with the line and what it should be.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let context = || format!("cannot read {}", path.display());
        let text = std::fs::read_to_string(path).with_context(context)?;
        toml::from_str(&text).with_context(context)
    }
}

#[cfg(test)]
mod tests {
    use super::SettingsFile;

    const PAGE: &str = include_str!("../../../../../docs/simulated-recordings.md");

    #[test]
    fn the_page_shows_every_setting_with_its_usual_value() {
        let shown = PAGE.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
        let read: SettingsFile = toml::from_str(shown).unwrap();
        assert_eq!(read, SettingsFile::default());
        let keys = |text: &str| {
            let lines = text.lines().filter_map(|line| Some(line.split_once(" = ")?.0.to_owned()));
            lines.collect::<Vec<_>>()
        };
        let written = toml::to_string(&SettingsFile::default()).unwrap();
        assert_eq!(keys(shown), keys(&written), "{written}");
    }

    #[test]
    fn the_truth_on_the_page_is_one() {
        let shown = PAGE.split("```toml\n").nth(2).unwrap().split("```").next().unwrap();
        let truth = toml::from_str::<SettingsFile>(shown).unwrap().truth.unwrap();
        truth.check().unwrap();
        assert!(truth != plant::Truth::default());
    }
}
