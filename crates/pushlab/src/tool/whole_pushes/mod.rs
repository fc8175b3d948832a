//! Recordings or a table go in, whole pushes come out, and how sure a model may be of them.

mod rows;
mod told;

use std::collections::HashSet;
use std::path::Path;

use anyhow::{Result, ensure};
use dataset::quantile;
use gp_core::quantile::normal;
use models::{
    Calibration, CalibrationPhase, Description, ModelError, ModelFile, RecordedPush, Setup,
    StepSelection,
};

use self::rows::Rows;
pub(crate) use self::told::Told;
use crate::tool::origin::Origin;
use crate::tool::rig::Rig;
use crate::tool::step_size::StepSize;
use crate::tool::step_source::StepSource;
use crate::tool::terminal::Terminal;

/// Shorter recorded pushes have no way to go, in steps.
const FEWEST_STEPS: usize = 2;

/// The pushes of a set or a table.
pub(crate) struct WholePushes {
    /// Whether the ends of each push alone are known.
    pub(crate) is_of_ends: bool,
    pub(crate) rig: Rig,
    pub(crate) all: Vec<RecordedPush>,
    /// Those that the model has not seen, where it tells; else all.
    pub(crate) unseen: Vec<RecordedPush>,
}

/// How well the places of ends were measured, in m: where the pusher still touches, within its radius, the
/// median size of the gap, as the standard deviation of a normal number. None where it never touches.
fn sd_of_ends<'a>(pushes: impl Iterator<Item = &'a RecordedPush>) -> Option<f64> {
    let gap = |push: &RecordedPush| {
        let gap = *push.gaps(&push.pushed.stated()).last()?;
        (gap < push.pushed.pusher_radius).then_some(gap.abs())
    };
    Some(quantile(pushes.filter_map(gap).collect(), 0.5)? / normal(0.75))
}

impl WholePushes {
    /// Reads recordings or a table.
    ///
    /// # Errors
    /// If it cannot be read, or has no push.
    pub(crate) fn read(
        source: &StepSource,
        step: Option<StepSize>,
        file: &ModelFile,
        origin: &mut Origin,
        terminal: &Terminal,
    ) -> Result<Self> {
        let rows = Rows::read(source, step, terminal)?;
        let Rows { table, about, is_of_ends, inputs } = rows;
        origin.inputs.extend(inputs);
        let (rig, path) = (about.rig(), &source.set);
        let selection = StepSelection::default();
        let mut all = selection.pushes(&table, &rig.object, rig.pusher.radius)?;
        all.retain(|push| is_of_ends || push.steps.len() >= FEWEST_STEPS);
        let least = if is_of_ends { "" } else { " of two steps or more" };
        ensure!(!all.is_empty(), "{} has no push{least}", path.display());
        let is_of = |split: &&models::Split| {
            about.observations(&table).is_ok_and(|observations| observations.are_of(split))
        };
        let split = file.split.as_ref().filter(is_of);
        let is_unseen =
            |push: &RecordedPush| split.is_none_or(|split| split.confirm.contains(&push.name));
        if is_of_ends {
            // Of pushes that are to be held against a model their ends tell nothing, where others do.
            let sd = sd_of_ends(all.iter().filter(|push| !is_unseen(push)));
            if let Some(sd) = sd.or_else(|| sd_of_ends(all.iter())) {
                terminal.remark(format_args!(
                    "places of ends are taken as measured to {:.2} mm, which their gaps to the pusher show",
                    1e3 * sd
                ));
                all.iter_mut().for_each(|push| push.pose_sd[1][0] = push.pose_sd[1][0].hypot(sd));
            }
        }
        let unseen = all.iter().filter(|push| is_unseen(push)).cloned().collect();
        Ok(Self { is_of_ends, rig, all, unseen })
    }

    /// The same of pushes of which the steps are known.
    ///
    /// # Errors
    /// If it cannot be read, or the ends of its pushes alone are known.
    pub(crate) fn of_steps(
        source: &StepSource,
        step: Option<StepSize>,
        file: &ModelFile,
        origin: &mut Origin,
        terminal: &Terminal,
    ) -> Result<Self> {
        let set = Self::read(source, step, file, origin, terminal)?;
        set.has_steps(&source.set)?;
        Ok(set)
    }

    /// Pushes beside those that were chosen: of what a model learnt from those alone that it has not seen. The
    /// few numbers of physics leave of pushes that they were fitted to what they leave of others.
    pub(crate) fn others(&self, chosen: &[RecordedPush], file: &ModelFile) -> Vec<RecordedPush> {
        let names: HashSet<&str> = chosen.iter().map(|push| push.name.as_str()).collect();
        let all = if file.description.weights.is_some() { &self.unseen } else { &self.all };
        all.iter().filter(|push| !names.contains(push.name.as_str())).cloned().collect()
    }

    pub(crate) fn has_steps(&self, path: &Path) -> Result<()> {
        ensure!(
            !self.is_of_ends,
            "{} has poses before and after pushes, which do not tell how the errors of steps go \
             together; name a set of recordings",
            path.display()
        );
        Ok(())
    }
}

/// How sure a model may be of whole pushes, by some that it was not asked about; tells what it is at.
///
/// # Errors
/// If they are too few, or the model refuses them.
pub(crate) fn calibration(
    model: &Description,
    setup: &Setup,
    pushes: &[RecordedPush],
    terminal: &Terminal,
) -> Result<Calibration, ModelError> {
    let activity = terminal.activity();
    let found = model.calibration_with_progress(setup, pushes, &|phase| activity.tell(told(phase)));
    activity.finish();
    found
}

/// The same of a model that was just fitted, by the pushes of its set; none where they do not tell, and why is noted.
pub(crate) fn calibration_of_fitted(
    (source, step): (&StepSource, Option<StepSize>),
    file: &ModelFile,
    terminal: &Terminal,
) -> Option<Calibration> {
    // What is to be said of the set was said when it was read for the fit.
    let mut origin = Origin::new("");
    let silent = terminal.silent();
    let mut found = || -> Result<Calibration> {
        let pushes = WholePushes::of_steps(source, step, file, &mut origin, &silent)?;
        let setup = Setup { support: pushes.rig.support, own: Vec::new() };
        Ok(calibration(&file.description, &setup, &pushes.others(&[], file), terminal)?)
    };
    found()
        .inspect_err(|why| {
            terminal.note(format_args!(
                "how sure the model may be of whole pushes was not measured: {why:#}"
            ));
        })
        .ok()
}

/// What a calibration is at, in words.
fn told(phase: CalibrationPhase) -> String {
    match phase {
        CalibrationPhase::RollOuts { round, done, of } => {
            format!("how sure of whole pushes: try {round}, {done} of {of} rolled out")
        }
        _ => "how sure of whole pushes: measuring how the errors of steps go together".to_owned(),
    }
}
