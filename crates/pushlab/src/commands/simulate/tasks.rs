//! What is rolled out: recorded pushes, or a path from a file.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Result, bail, ensure};
use dataset::{MANIFEST_NAME, Manifest, StepLength, SupportSpec, quantile};
use effects::Object;
use gp_core::quantile::normal;
use models::{ModelFile, PushPath, Pushed, RecordedPush, SeenSteps, StepSelection};
use planar::Pose;

use super::Args;
use super::path_file::PathFile;
use super::rolled::Task;
use super::rows::Rows;
use crate::known::Known;
use crate::origin::{Input, Origin};
use crate::rig::Rig;
use crate::step_size::StepSize;
use crate::step_source::StepSource;
use crate::terminal::Terminal;
use crate::wrong_usage::WrongUsage;

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
        if is_path(&args.source) && args.known.mapping.is_none() {
            return Self::along_path(args, file, origin, terminal);
        }
        if args.object.is_some() {
            bail!(WrongUsage("--object is for a path; recorded pushes have their own"));
        }
        let source = StepSource::of(&args.source, args.known.clone());
        let set = Recorded::read(&source, args.step, file, origin, terminal)?;
        set.rig.warn_of_other(&args.model, file, terminal);
        let support = set.rig.support;
        let same = |path: &Path| path.canonicalize().ok() == args.source.canonicalize().ok();
        let chosen = set.chosen(args, args.measured_on().is_some_and(same))?;
        let others = match args.measured_on() {
            Some(path) if !same(path) => {
                Some(Recorded::others_of(args, path, args.step, file, (origin, terminal))?)
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
            Some(set) => Some(Recorded::others_of(args, set, None, file, (origin, terminal))?),
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

/// The pushes of a set or a table.
struct Recorded {
    /// Whether the ends of each push alone are known.
    is_of_ends: bool,
    rig: Rig,
    all: Vec<RecordedPush>,
    /// Those that the model has not seen, where it tells; else all.
    unseen: Vec<RecordedPush>,
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

impl Recorded {
    fn read(
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
        let set = Self::read(&StepSource::of(path, known), step, file, origin, terminal)?;
        set.has_steps(path)?;
        Ok(set.others(&[], file))
    }

    /// Pushes beside those that were chosen: of what a model learnt from those alone that it has not seen. The
    /// few numbers of physics leave of pushes that they were fitted to what they leave of others.
    fn others(&self, chosen: &[RecordedPush], file: &ModelFile) -> Vec<RecordedPush> {
        let names: HashSet<&str> = chosen.iter().map(|push| push.name.as_str()).collect();
        let all = if file.description.weights.is_some() { &self.unseen } else { &self.all };
        all.iter().filter(|push| !names.contains(push.name.as_str())).cloned().collect()
    }

    fn has_steps(&self, path: &Path) -> Result<()> {
        ensure!(
            !self.is_of_ends,
            "{} has poses before and after pushes, which do not tell how the errors of steps go \
             together; name a set of recordings with --correlation, or leave it out",
            path.display()
        );
        Ok(())
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
                    "{} has no push {name}{}; it has {}{}",
                    args.source.display(),
                    if self.is_of_ends { "" } else { " of two steps or more" },
                    known.join(", "),
                    if self.all.len() > 5 { ", …" } else { "" }
                )
            })
        };
        args.push.iter().map(named).collect()
    }
}
