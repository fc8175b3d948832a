//! What is rolled out: recorded pushes, or a path from a file.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Result, bail, ensure};
use dataset::{IngestSettings, Manifest, RecordingSet, StepLength, SupportSpec};
use diagnosis::Observations;
use effects::Object;
use models::{
    ModelFile, PushModel, Pushed, RecordedPush, SeenSteps, StepCorrelation, StepSelection,
};
use planar::Pose;

use super::Args;
use super::path_file::PathFile;
use super::rolled::Task;
use crate::origin::{Input, Origin, readable};
use crate::recorded_steps::RecordedSteps;
use crate::step_size::StepSize;
use crate::terminal::Terminal;
use crate::wrong_usage::WrongUsage;

/// What is rolled out, and what is measured on.
pub(super) struct Source {
    pub(super) tasks: Vec<Task>,
    pub(super) support: SupportSpec,
    /// Whether they were recorded, from a start in contact.
    pub(super) is_recorded: bool,
    /// The longest step, in m.
    pub(super) longest: f64,
    measured_on: Option<Vec<RecordedPush>>,
}

/// The longest step of models that do not tell which they have learnt from, in m.
const USUAL_STEP: f64 = 4e-3;
/// Shorter recorded pushes have no way to go, in steps.
const FEWEST_STEPS: usize = 2;

impl Source {
    /// Reads what the arguments name.
    ///
    /// # Errors
    /// If it cannot be read, or options do not go together.
    pub(super) fn read(
        args: &Args,
        file: &ModelFile,
        origin: &mut Origin,
        terminal: &Terminal,
    ) -> Result<Self> {
        let effects = !file.description.effects.is_empty();
        let seen = file.description.weights.as_ref().and_then(|weights| weights.seen.as_ref());
        if !args.source.is_dir() {
            return Self::along_path(args, seen, effects, origin, terminal);
        }
        if args.manifest.is_some() || args.object.is_some() {
            bail!(WrongUsage("--manifest and --object are for a path; a set has its own"));
        }
        let set = Recorded::read(&args.source, args.step, file, origin, terminal)?;
        let support = set.support;
        let same = |path: &Path| path.canonicalize().ok() == args.source.canonicalize().ok();
        let chosen = set.chosen(args, args.correlation.as_deref().is_some_and(same))?;
        let measured_on = match args.correlation.as_deref() {
            Some(path) if same(path) => {
                let names: HashSet<&str> = chosen.iter().map(|push| push.name.as_str()).collect();
                let others = set.unseen.iter().filter(|push| !names.contains(push.name.as_str()));
                Some(others.cloned().collect())
            }
            Some(path) => Some(Recorded::read(path, args.step, file, origin, terminal)?.unseen),
            None => None,
        };
        let longest = chosen.iter().flat_map(|push| &push.steps);
        let longest = longest.map(|step| step.input.distance()).fold(USUAL_STEP, f64::max);
        let tasks = chosen.into_iter().map(|push| Task::recorded(push, effects)).collect();
        Ok(Self { tasks, support, is_recorded: true, longest, measured_on })
    }

    fn along_path(
        args: &Args,
        seen: Option<&SeenSteps>,
        effects: bool,
        origin: &mut Origin,
        terminal: &Terminal,
    ) -> Result<Self> {
        if !args.push.is_empty() {
            bail!(WrongUsage("--push is for recorded pushes; a path is one push"));
        }
        let Some(manifest_path) = &args.manifest else {
            bail!(WrongUsage("a path does not tell what is pushed; give a set's --manifest"));
        };
        origin.inputs.push(Input::file(&args.source)?);
        let PathFile { path, object_wb } = PathFile::read(&args.source)?;
        origin.inputs.push(Input::file(manifest_path)?);
        let manifest = Manifest::read(manifest_path)?;
        let spec = manifest.object.of("")?;
        let shape = Arc::new(spec.shape);
        let object =
            Object::new(shape.clone(), spec.mass, spec.moment_of_inertia, spec.center_of_mass)?;
        let object = effects.then(|| Arc::new(object));
        let pushed = Pushed { shape, pusher_radius: manifest.pusher.radius, object };
        let usual = seen.map_or(USUAL_STEP, |seen| seen.way[1]);
        let longest = match args.step.map(|StepSize(step)| step) {
            None => usual,
            Some(StepLength::Distance(way)) => way,
            Some(StepLength::Time(time)) => time * path.length() / path.duration(),
        };
        let name = args.source.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let start_wb = match (args.object, object_wb) {
            (Some(place), _) => place.pose_wb(),
            (None, Some(pose_wb)) => pose_wb,
            // As the help of --object says.
            (None, None) => Pose::new(0.0, 0.0, 0.0),
        };
        let (measured_wb, pose_sd) = (None, [[0.0; 2]; 2]);
        let task = Task { name, pushed, path, start_wb, measured_wb, pose_sd };
        let measured_on = match args.correlation.as_deref() {
            Some(set) => Some(Recorded::read(set, None, None, origin, terminal)?.unseen),
            None => None,
        };
        let support = manifest.support;
        Ok(Self { tasks: vec![task], support, is_recorded: false, longest, measured_on })
    }

    /// How the errors of the steps of a push go together, where that was asked for.
    ///
    /// # Errors
    /// Too few pushes, or a model without scatter.
    pub(super) fn correlation(&self, model: &dyn PushModel) -> Result<Option<StepCorrelation>> {
        let measure = |pushes: &Vec<RecordedPush>| StepCorrelation::measure(model, pushes);
        Ok(self.measured_on.as_ref().map(measure).transpose()?)
    }
}

impl Task {
    fn recorded(push: RecordedPush, effects: bool) -> Self {
        let RecordedPush { name, mut pushed, path, poses_wb, pose_sd, .. } = push;
        if !effects {
            pushed.object = None;
        }
        Self { name, pushed, path, start_wb: poses_wb[0], measured_wb: Some(poses_wb), pose_sd }
    }
}

/// The pushes of a set.
struct Recorded {
    support: SupportSpec,
    all: Vec<RecordedPush>,
    /// Those that the model has not seen, where it tells; else all.
    unseen: Vec<RecordedPush>,
}

impl Recorded {
    fn read<'a>(
        path: &Path,
        step: Option<StepSize>,
        file: impl Into<Option<&'a ModelFile>>,
        origin: &mut Origin,
        terminal: &Terminal,
    ) -> Result<Self> {
        readable(path)?;
        let set = RecordingSet::open(path)?;
        let usual = IngestSettings::default();
        let step = step.map_or(usual.step, |StepSize(step)| step);
        let settings = IngestSettings { step, ..usual };
        let RecordedSteps { table, inputs, .. } = RecordedSteps::read(&set, &settings, terminal)?;
        origin.inputs.extend(inputs);
        let manifest = set.manifest();
        let selection = StepSelection::default();
        let mut all = selection.pushes(&table, &manifest.object, manifest.pusher.radius)?;
        all.retain(|push| push.steps.len() >= FEWEST_STEPS);
        ensure!(!all.is_empty(), "{} has no push of two steps or more", path.display());
        let split = file.into().and_then(|file| file.split.as_ref());
        let is_of = |split: &&models::Split| {
            Observations::of(&table, manifest).is_ok_and(|observations| observations.are_of(split))
        };
        let unseen = match split.filter(is_of) {
            Some(split) => {
                let kept = |push: &&RecordedPush| split.confirm.contains(&push.name);
                all.iter().filter(kept).cloned().collect()
            }
            None => all.clone(),
        };
        Ok(Self { support: manifest.support, all, unseen })
    }

    /// The pushes to roll out; no more than a half where the others are to be measured on.
    fn chosen(&self, args: &Args, is_shared: bool) -> Result<Vec<RecordedPush>> {
        if args.push.is_empty() {
            ensure!(!self.unseen.is_empty(), "no push that the model has not seen; name some");
            let n = self.unseen.len();
            let most = if is_shared { n.div_ceil(2) } else { n };
            let wanted = (args.pushes as usize).min(most);
            return Ok((0..wanted).map(|k| self.unseen[k * n / wanted].clone()).collect());
        }
        let named = |name: &String| {
            let found = self.all.iter().find(|push| push.name == *name);
            found.cloned().ok_or_else(|| {
                let known: Vec<_> = self.all.iter().take(5).map(|p| p.name.as_str()).collect();
                anyhow::anyhow!(
                    "{} has no push {name} of two steps or more; it has {}{}",
                    args.source.display(),
                    known.join(", "),
                    if self.all.len() > 5 { ", …" } else { "" }
                )
            })
        };
        args.push.iter().map(named).collect()
    }
}
