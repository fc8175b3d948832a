//! A model with all that the page shows of it.

use anyhow::Result;
use diagnosis::{
    Comparison, MapSettings, NoiseFloor, Observations, OutlineMap, Predictions, PushEnds,
    RepeatTolerance, Rollout, StepResiduals, compare, noise_floor, outline_maps, push_ends,
    roll_out, step_residuals,
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
    pub(super) part: &'a Part,
    /// One for all models, of `unseen` and of `all`.
    floors: Option<[NoiseFloor; 2]>,
}

impl<'a> Trial<'a> {
    pub(super) fn new(all: &'a Observations, unseen: &'a Observations, part: &'a Part) -> Self {
        Self { all, unseen, part, floors: None }
    }

    /// The floors, once a model was tried.
    pub(super) fn into_floors(self) -> Option<[NoiseFloor; 2]> {
        self.floors
    }

    /// Everything of a model; the first one is that of the floors.
    pub(super) fn of(&mut self, name: String, file: ModelFile) -> Result<Tried> {
        let (all, unseen, model) = (self.all, self.unseen, &file.description);
        let is_same = matches!(self.part, Part::All);
        let of_all = Predictions::of(model, &[], all)?;
        let of_unseen = if is_same { of_all.clone() } else { Predictions::of(model, &[], unseen)? };
        let floor =
            |predictions: &Predictions, observations: &Observations| -> Result<NoiseFloor> {
                let floor = noise_floor(observations, predictions, &RepeatTolerance::default())?;
                Ok(floor.for_all_places(model, &[], observations)?)
            };
        let [floor, floor_of_all] = match &mut self.floors {
            Some(floors) => floors,
            none => {
                let least = floor(&of_unseen, unseen)?;
                let of_all = if is_same { least.clone() } else { floor(&of_all, all)? };
                none.insert([least, of_all])
            }
        };
        let settings = MapSettings::default();
        let comparison = compare(unseen, &of_unseen, floor, &settings)?;
        // What was learnt freely passes through the pushes that it was learnt from: there is nothing to
        // see in them. A few numbers of physics leave their errors where they are.
        let split = file.split.iter().filter(|split| all.are_of(split));
        let n_fitted = split.map(|split| split.fit.len()).sum();
        let is_of_all = n_fitted == 0 || matches!(model.base, Base::Analytical(_));
        let (seen, predicted) = if is_of_all { (all, &of_all) } else { (unseen, &of_unseen) };
        let found = match is_of_all {
            true if !is_same => compare(all, &of_all, floor_of_all, &settings)?,
            _ => comparison.clone(),
        };
        let rollouts = roll_out(model, &[], all)?;
        let names = unseen.pushes();
        let of_unseen: Vec<Rollout> =
            rollouts.iter().filter(|one| names.contains(&one.push)).cloned().collect();
        Ok(Tried {
            name,
            comparison,
            found,
            is_of_all,
            n_fitted,
            outlines: outline_maps(seen, predicted, &outlines::SETTINGS)?,
            ends: push_ends(&of_unseen),
            rollouts,
            residuals: step_residuals(all, &of_all)?,
            file,
        })
    }
}
