//! Which pushes a model was fitted to, and which were kept to confirm it.

use std::collections::HashSet;

use serde::{Deserialize, Serialize};

/// The parts of a recording set, chosen before anything is fitted.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Split {
    /// SHA-256 over the hashes of the set's recordings: a split of other recordings does not fit.
    pub set: String,
    /// Seed of the choice.
    pub seed: u64,
    /// What was chosen as a whole.
    pub cluster: Cluster,
    /// Pushes to fit to, each as `recording#number`.
    pub fit: Vec<String>,
    /// Held-out pushes.
    pub confirm: Vec<String>,
    /// The set that these are of, as `set`, where it is another one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub confirm_set: Option<String>,
}

/// What shares errors, and so stays in one part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Cluster {
    /// The steps of a push.
    Push,
    /// The pushes of a measuring session.
    Session,
}

impl Split {
    /// What contradicts itself: an empty part, or a push that stands twice.
    pub(crate) fn problem(&self) -> Option<String> {
        for (part, names) in [("fit", &self.fit), ("confirm", &self.confirm)] {
            if names.is_empty() {
                return Some(format!("{part} names no push"));
            }
        }
        // Two sets may well have recordings of one name.
        let place = |part: &'static str| if self.confirm_set.is_some() { part } else { "" };
        let fit = self.fit.iter().map(|name| (place("fit"), name));
        let confirm = self.confirm.iter().map(|name| (place("confirm"), name));
        let mut known = HashSet::new();
        let twice = fit.chain(confirm).find(|name| !known.insert(*name));
        twice.map(|(_, name)| format!("{name} stands twice; a push is in one part"))
    }
}
