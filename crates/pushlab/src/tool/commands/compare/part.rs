//! Which pushes of a set a comparison may use.

use std::fmt;

use anyhow::{Context, Result};
use diagnosis::{NoiseFloor, Observations, PushName};
use models::{Base, Description, Split};
use serde::Serialize;

/// The pushes compared.
#[derive(Serialize)]
#[serde(rename_all = "snake_case", tag = "pushes")]
pub(in crate::tool::commands) enum Part {
    /// All of the set, which no model says that it was fitted to.
    All,
    /// The held-out ones.
    Confirm {
        /// How many pushes the split leaves out, for a model was fitted to them.
        n_fitted: usize,
        #[serde(skip)]
        names: Vec<String>,
    },
}

impl Part {
    /// What the splits of the models leave: the pushes that each of those of this set confirms with.
    pub(in crate::tool::commands) fn of<'a>(
        splits: impl Iterator<Item = &'a Split>,
        observations: &Observations,
    ) -> Self {
        let concerns = |split: &&Split| observations.are_of(split) || observations.confirm(split);
        splits.filter(concerns).fold(Self::All, |part, split| {
            // Where another set confirms, all of this one was fitted to.
            let has_unseen = split.confirm_set.is_none() || observations.confirm(split);
            let unseen = if has_unseen { &split.confirm[..] } else { &[] };
            let names = unseen.iter().filter(|name| part.has(name)).cloned().collect();
            Self::Confirm { n_fitted: split.fit.len(), names }
        })
    }

    fn has(&self, push: &String) -> bool {
        match self {
            Self::All => true,
            Self::Confirm { names, .. } => names.contains(push),
        }
    }

    /// Which part a push was in: `all` where no model was fitted to any.
    fn name_of(&self, push: &String) -> &'static str {
        match self {
            Self::All => "all",
            Self::Confirm { .. } if self.has(push) => "held_out",
            Self::Confirm { .. } => "fitted",
        }
    }

    /// The same of the push of each step.
    pub(super) fn names_of_steps(&self, all: &Observations) -> Vec<String> {
        let of_push = |push: &PushName| self.name_of(&push.to_string()).to_owned();
        let names: Vec<String> = all.pushes().iter().map(of_push).collect();
        (0..all.n_steps()).map(|step| names[all.push_of(step)].clone()).collect()
    }

    /// The observations of these pushes.
    ///
    /// # Errors
    /// If they are too few.
    pub(in crate::tool::commands) fn observations(
        &self,
        all: Observations,
    ) -> Result<Observations> {
        match self {
            Self::All => Ok(all),
            Self::Confirm { names, .. } => {
                all.part(names).context("the held-out pushes are too few; fit both models anew")
            }
        }
    }
}

/// The noise floor about a model, of all pushes: its few numbers leave of pushes that they were fitted to what they
/// leave of others. What was learnt freely does not, and has the floor of the pushes that it has not seen.
///
/// # Errors
/// What the model refuses.
pub(in crate::tool::commands) fn floor_about(
    model: &Description,
    all: &Observations,
    unseen: &Observations,
) -> Result<NoiseFloor> {
    let pushes = if matches!(model.base, Base::Analytical(_)) { all } else { unseen };
    Ok(NoiseFloor::about(model, &[], pushes)?)
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::All => Ok(()),
            Self::Confirm { n_fitted, .. } => {
                writeln!(f, "  the held-out pushes; {n_fitted} others were fitted to")
            }
        }
    }
}
