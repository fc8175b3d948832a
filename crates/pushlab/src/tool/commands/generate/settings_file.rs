//! What of a simulation no option names: sensors, scatter, the design's details, what is true.

use std::path::Path;

use anyhow::{Context, Result};
use plant::{Design, Nominal, Numerics, Profile, Scatter, Sensors, Truth};
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

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
    /// Everything as usual on a rig of which so much is claimed.
    pub(super) fn usual(profile: &Profile, nominal: &Nominal) -> Self {
        Self {
            sensors: profile.sensors(),
            scatter: profile.scatter(),
            truth: Some(profile.truth(nominal)),
            ..Self::default()
        }
    }

    /// Reads a file over what is usual: single keys may be left out at any depth.
    ///
    /// # Errors
    /// If it cannot be read, or with the line and what it should be.
    pub(super) fn read(path: &Path, usual: &Self) -> Result<Self> {
        let context = || format!("cannot read {}", path.display());
        let text = dataset::read_text(path).with_context(context)?;
        // Of the text itself, so that an error has its line.
        toml::from_str::<Self>(&text).with_context(context)?;
        let mut merged = Table::try_from(usual).with_context(context)?;
        merge(&mut merged, text.parse().with_context(context)?);
        merged.try_into().with_context(context)
    }
}

/// Puts the values of one table into another; tables within are merged, too.
fn merge(into: &mut Table, from: Table) {
    for (key, value) in from {
        match (into.get_mut(&key), value) {
            (Some(Value::Table(below)), Value::Table(values)) => merge(below, values),
            (_, value) => drop(into.insert(key, value)),
        }
    }
}

#[cfg(test)]
mod tests {
    use plant::{Nominal, Profile, Truth};

    use super::SettingsFile;

    const PAGE: &str = include_str!("../../../../../../docs/simulated-recordings.md");

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
    fn keys_that_are_left_out_stay_as_usual_at_any_depth() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("rig.toml");
        let text = "[sensors.object]\nrate = 200.0\n[truth.clocks]\nforce_latency = 0.01\n\
                    [design]\nlayout = { narrow = { edge = 2 } }\n";
        std::fs::write(&path, text).unwrap();
        let nominal = Nominal { pusher_radius: 0.006, ..Nominal::default() };
        for profile in Profile::all() {
            let usual = SettingsFile::usual(profile, &nominal);
            let read = SettingsFile::read(&path, &usual).unwrap();
            let mut expected = usual;
            expected.sensors.object.rate = 200.0;
            expected.design.layout = plant::Layout::Narrow { edge: 2 };
            expected.truth.as_mut().unwrap().clocks.force_latency = 0.01;
            assert_eq!(read, expected);
        }
    }

    #[test]
    fn the_truth_on_the_page_is_one() {
        let shown = PAGE.split("```toml\n").nth(2).unwrap().split("```").next().unwrap();
        let truth = toml::from_str::<SettingsFile>(shown).unwrap().truth.unwrap();
        truth.check().unwrap();
        assert!(truth != Truth::default());
    }
}
