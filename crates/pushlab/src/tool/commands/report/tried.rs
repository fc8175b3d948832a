//! A model with all that the page shows of it.

use anyhow::Result;
use diagnosis::{
    Comparison, MapSettings, NoiseFloor, Observations, OutlineMap, Predictions, PushEnds, Rollout,
    StepResiduals, compare, outline_maps, push_ends, roll_out, step_residuals,
};
use models::{Base, ModelFile};

use super::super::compare::Part;
use super::outlines;

/// A model with all that the page shows of it.
pub(super) struct Tried {
    /// Its name, and where that is not enough its file.
    pub(super) name: String,
    pub(super) file: ModelFile,
    /// On the pushes that no model was fitted to.
    pub(super) comparison: Comparison,
    /// Where it fails, on all pushes if `is_of_all`, else on those that it was not fitted to.
    pub(super) found: Comparison,
    pub(super) is_of_all: bool,
    /// Pushes of the set that it was fitted to.
    pub(super) n_fitted: usize,
    pub(super) outlines: Vec<OutlineMap>,
    /// Of all pushes.
    pub(super) rollouts: Vec<Rollout>,
    /// Of the pushes that no model was fitted to; none where every push is one step.
    pub(super) ends: Option<PushEnds>,
    /// Of all steps.
    pub(super) residuals: Vec<StepResiduals>,
}

/// The pushes that models are tried on, and how well they may be predicted at best.
pub(super) struct Trial<'a> {
    pub(super) all: &'a Observations,
    /// Those that no model was fitted to.
    pub(super) unseen: &'a Observations,
    /// All steps in contact of all pushes, near vertices too.
    pub(super) in_contact: &'a Observations,
    pub(super) part: &'a Part,
    pub(super) floor: &'a NoiseFloor,
}

impl Trial<'_> {
    /// Everything of a model.
    pub(super) fn of(&self, name: String, file: ModelFile) -> Result<Tried> {
        let Self { all, unseen, in_contact, part, floor } = *self;
        let model = &file.description;
        let is_same = matches!(part, Part::All);
        let of_all = Predictions::of(model, &[], all)?;
        let of_unseen = if is_same { of_all.clone() } else { Predictions::of(model, &[], unseen)? };
        let settings = MapSettings::default();
        let comparison = compare(unseen, &of_unseen, floor, &settings)?;
        // What was learnt freely passes through the pushes that it was learnt from: there is nothing to
        // see in them. A few numbers of physics leave their errors where they are.
        let split = file.split.iter().filter(|split| all.are_of(split));
        let n_fitted = split.map(|split| split.fit.len()).sum();
        let is_of_all = n_fitted == 0 || matches!(model.base, Base::Analytical(_));
        let found = match is_of_all {
            true if !is_same => compare(all, &of_all, floor, &settings)?,
            _ => comparison.clone(),
        };
        let seen = if is_of_all { in_contact } else { &part.observations(in_contact.clone())? };
        let along = Predictions::of(model, &[], seen)?;
        let rollouts = roll_out(model, &[], in_contact)?;
        let names = unseen.pushes();
        let of_unseen: Vec<Rollout> =
            rollouts.iter().filter(|one| names.contains(&one.push)).cloned().collect();
        Ok(Tried {
            name,
            comparison,
            found,
            is_of_all,
            n_fitted,
            outlines: outline_maps(seen, &along, &outlines::SETTINGS)?,
            ends: push_ends(&of_unseen),
            rollouts,
            residuals: step_residuals(all, &of_all)?,
            file,
        })
    }
}
