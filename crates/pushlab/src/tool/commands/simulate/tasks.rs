//! What is rolled out: recorded pushes, or a path from a file.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Result, bail, ensure};
use dataset::{MANIFEST_NAME, Manifest, StepLength, SupportSpec};
use effects::Object;
use models::{ModelFile, PushPath, Pushed, RecordedPush, SeenSteps};
use planar::Pose;

use super::Args;
use super::path_file::PathFile;
use super::rolled::Task;
use crate::tool::known::Known;
use crate::tool::origin::{Input, Origin};
use crate::tool::rig::Rig;
use crate::tool::step_size::StepSize;
use crate::tool::step_source::StepSource;
use crate::tool::terminal::Terminal;
use crate::tool::whole_pushes::WholePushes;
use crate::tool::wrong_usage::WrongUsage;

/// What is rolled out, and what is measured on.
pub(super) struct Source {
    pub(super) tasks: Vec<Task>,
    pub(super) support: SupportSpec,
    /// The longest step, in m.
    pub(super) longest: f64,
    /// Other pushes, which tell how sure a model may be of these.
    pub(super) others: Option<Vec<RecordedPush>>,
}

/// The longest step of models that do not tell which they have learnt from, in m.
const USUAL_STEP: f64 = 4e-3;

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
        if is_path(&args.source) && args.known.mapping.is_none() {
            return Self::along_path(args, file, origin, terminal);
        }
        if args.object.is_some() {
            bail!(WrongUsage("--object is for a path; recorded pushes have their own"));
        }
        let source = StepSource::of(&args.source, args.known.clone());
        let set = WholePushes::read(&source, args.step, file, origin, terminal)?;
        set.rig.warn_of_other(&args.model, file, terminal);
        let support = set.rig.support;
        let same = |path: &Path| path.canonicalize().ok() == args.source.canonicalize().ok();
        let chosen = chosen(&set, args, args.measured_on().is_some_and(same))?;
        let others = match args.measured_on() {
            Some(path) if !same(path) => {
                Some(others_of(args, path, args.step, file, (origin, terminal))?)
            }
            Some(path) => {
                set.has_steps(path)?;
                Some(set.others(&chosen, file))
            }
            None if set.is_of_ends || args.correlation.is_some() => None,
            None => Some(set.others(&chosen, file)),
        };
        let longest = match set.is_of_ends {
            true => {
                let of = |push: &RecordedPush| longest(args.step, seen(file), &push.path);
                chosen.iter().map(of).fold(f64::INFINITY, f64::min)
            }
            false => {
                let steps = chosen.iter().flat_map(|push| &push.steps);
                steps.map(|step| step.input.distance()).fold(USUAL_STEP, f64::max)
            }
        };
        let effects = !file.description.effects.is_empty();
        let of = |push| Task::recorded(push, set.is_of_ends, effects);
        let tasks = chosen.into_iter().map(of).collect();
        Ok(Self { tasks, support, longest, others })
    }

    fn along_path(
        args: &Args,
        file: &ModelFile,
        origin: &mut Origin,
        terminal: &Terminal,
    ) -> Result<Self> {
        if !args.push.is_empty() || args.known.preset.is_some() {
            bail!(WrongUsage("--push and --preset are for recorded pushes; a path is one push"));
        }
        let Some(manifest_path) = &args.known.manifest else {
            bail!(WrongUsage("a path does not tell what is pushed; give a set's --manifest"));
        };
        origin.inputs.push(Input::file(&args.source)?);
        let PathFile { path, object_wb } = PathFile::read(&args.source)?;
        origin.inputs.push(Input::file(manifest_path)?);
        let manifest = Manifest::read(manifest_path)?;
        Rig::from(&manifest).warn_of_other(&args.model, file, terminal);
        let spec = manifest.object.of("")?;
        let shape = Arc::new(spec.shape);
        let object =
            Object::new(shape.clone(), spec.mass, spec.moment_of_inertia, spec.center_of_mass)?;
        let effects = !file.description.effects.is_empty();
        let object = effects.then(|| Arc::new(object));
        let pushed = Pushed { shape, pusher_radius: manifest.pusher.radius, object };
        let longest = longest(args.step, seen(file), &path);
        let name = args.source.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let start_wb = match (args.object, object_wb) {
            (Some(place), _) => place.pose_wb(),
            (None, Some(pose_wb)) => pose_wb,
            // As the help of --object says.
            (None, None) => Pose::new(0.0, 0.0, 0.0),
        };
        let (measured_wb, pose_sd, touching) = (None, [[0.0; 2]; 2], false);
        let task = Task { name, pushed, path, start_wb, measured_wb, pose_sd, touching };
        let others = match args.measured_on() {
            Some(set) => Some(others_of(args, set, None, file, (origin, terminal))?),
            None => None,
        };
        let support = manifest.support;
        Ok(Self { tasks: vec![task], support, longest, others })
    }
}

/// What a model has learnt from, where it learnt.
fn seen(file: &ModelFile) -> Option<&SeenSteps> {
    file.description.weights.as_ref().and_then(|weights| weights.seen.as_ref())
}

/// The longest step along a path, in m: as asked for, else as the model has seen.
fn longest(step: Option<StepSize>, seen: Option<&SeenSteps>, path: &PushPath) -> f64 {
    match step.map(|StepSize(step)| step) {
        None => seen.map_or(USUAL_STEP, |seen| seen.way[1]),
        Some(StepLength::Distance(way)) => way,
        Some(StepLength::Time(time)) => time * path.length() / path.duration(),
    }
}

impl Task {
    /// Recorded steps begin in contact, a push of which the ends are known where its outlines say.
    fn recorded(push: RecordedPush, is_of_ends: bool, effects: bool) -> Self {
        let RecordedPush { name, mut pushed, path, poses_wb, pose_sd, .. } = push;
        if !effects {
            pushed.object = None;
        }
        let start_wb = poses_wb[0];
        let center_b = start_wb.inverse_transform_point(&path.start_w());
        let touching =
            !is_of_ends || pushed.shape.contact(&center_b, pushed.pusher_radius).gap <= 0.0;
        Self { name, pushed, path, start_wb, measured_wb: Some(poses_wb), pose_sd, touching }
    }
}

/// Whether a file is a path of the pusher: drawn in TOML, or points with a time.
fn is_path(file: &Path) -> bool {
    let ending = file.extension().and_then(|ending| ending.to_str());
    match ending {
        Some("toml") => !file.ends_with(MANIFEST_NAME),
        Some("csv") => PathFile::has_few_columns(file),
        _ => false,
    }
}

/// The pushes of another set or table, to be measured on.
fn others_of(
    args: &Args,
    path: &Path,
    step: Option<StepSize>,
    file: &ModelFile,
    (origin, terminal): (&mut Origin, &Terminal),
) -> Result<Vec<RecordedPush>> {
    // A set has its own manifest; a table may be about the object of the path or of the other table.
    let known = if path.is_dir() { Known::default() } else { args.known.clone() };
    let set = WholePushes::of_steps(&StepSource::of(path, known), step, file, origin, terminal)?;
    Ok(set.others(&[], file))
}

/// The pushes to roll out; no more than a half where the others are to be measured on.
fn chosen(set: &WholePushes, args: &Args, is_shared: bool) -> Result<Vec<RecordedPush>> {
    if args.push.is_empty() {
        ensure!(!set.unseen.is_empty(), "no push that the model has not seen; name some");
        let n = set.unseen.len();
        let most = if is_shared { n.div_ceil(2) } else { n };
        let wanted = (args.pushes as usize).min(most);
        return Ok((0..wanted).map(|k| set.unseen[k * n / wanted].clone()).collect());
    }
    let named = |name: &String| {
        let found = set.all.iter().find(|push| push.name == *name);
        found.cloned().ok_or_else(|| {
            let known: Vec<_> = set.all.iter().take(5).map(|p| p.name.as_str()).collect();
            anyhow::anyhow!(
                "{} has no push {name}{}; it has {}{}",
                args.source.display(),
                if set.is_of_ends { "" } else { " of two steps or more" },
                known.join(", "),
                if set.all.len() > 5 { ", …" } else { "" }
            )
        })
    };
    args.push.iter().map(named).collect()
}
