//! What is known of recordings or a table beside what they say themselves.

use std::path::{Path, PathBuf};

use clap::builder::PossibleValuesParser;
use dataset::Preset;
use planar::MIT_NAMES;

use crate::tool::command_line::preset_parser;

/// What is known of a set or a table beside what it says itself.
#[derive(Clone, Default, clap::Args)]
pub(crate) struct Known {
    /// Manifest that says what a step table does not: the object, the pusher and the table that it is of;
    /// else dataset.toml beside it. The mapping of a table that was converted says it, too
    #[arg(long, value_name = "FILE")]
    pub(crate) manifest: Option<PathBuf>,
    /// What is known of public data, for recordings or a table of others
    #[arg(long, value_name = "NAME", value_parser = preset_parser())]
    pub(crate) preset: Option<Preset>,
    /// Of public data about several shapes, the pushes of this one alone
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(MIT_NAMES),
          requires = "preset")]
    pub(crate) shape: Option<String>,
    /// How the columns of a table of others become ours
    #[arg(long, value_name = "FILE", conflicts_with_all = ["preset", "manifest"])]
    pub(crate) mapping: Option<PathBuf>,
}

impl Known {
    /// The options as typed.
    pub(crate) fn words(&self) -> Vec<String> {
        let path = |path: &Path| path.display().to_string();
        let mut words = Vec::new();
        let mut option = |name: &str, value: Option<String>| {
            words.extend(value.into_iter().flat_map(|value| [format!("--{name}"), value]));
        };
        option("manifest", self.manifest.as_deref().map(path));
        option("preset", self.preset.map(|preset| preset.name().to_owned()));
        option("shape", self.shape.clone());
        option("mapping", self.mapping.as_deref().map(path));
        words
    }

    /// What is known, or what was known when a command with these words read the same.
    pub(crate) fn or_of(self, words: &[String]) -> Self {
        let after = |name: &str| {
            let pair = words.windows(2).find(|pair| pair[0] == format!("--{name}"))?;
            Some(pair[1].clone())
        };
        if self.manifest.is_some() || self.preset.is_some() || self.mapping.is_some() {
            return self;
        }
        Self {
            manifest: after("manifest").map(PathBuf::from),
            preset: after("preset").and_then(|name| Preset::by_name(&name)),
            shape: after("shape"),
            mapping: after("mapping").map(PathBuf::from),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use dataset::Preset;

    use super::Known;

    #[test]
    fn what_was_known_is_found_again_in_the_words_of_the_command() {
        for known in [
            Known { preset: Some(Preset::MitTable), ..Known::default() },
            Known { manifest: Some(PathBuf::from("a set/dataset.toml")), ..Known::default() },
            Known { mapping: Some(PathBuf::from("columns.toml")), ..Known::default() },
        ] {
            let mut words = ["diagnose", "t.csv", "--seed", "7"].map(str::to_owned).to_vec();
            words.extend(known.words());
            assert_eq!(Known::default().or_of(&words).words(), known.words());
            // What is named now counts.
            let now = Known { preset: Some(Preset::MitPush), ..Known::default() };
            assert_eq!(now.clone().or_of(&words).words(), now.words());
        }
        assert!(Known::default().or_of(&["diagnose".to_owned()]).words().is_empty());
    }
}
