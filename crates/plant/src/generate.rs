//! Recording sets with a sealed truth.

use std::fs;
use std::path::{Path, PathBuf};

use dataset::{Recording, RecordingWriter, all_writers};
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use crate::design::push_name;
use crate::pushed_object::{manifest_text, object_of, streams_text};
use crate::random::{Purpose, Random};
use crate::sealed_truth::{SealedPush, SealedTruth};
use crate::sensors::Streams;
use crate::{
    Design, Hidden, HiddenEffect, Nominal, Numerics, PlannedPush, Plant, PlantError, PushedObject,
    Scatter, Sensors, TipPath, Trajectory, Truth, Variation,
};

/// Stamp of the first push, in s.
const FIRST_EPOCH: i64 = 1000;
/// From the end of a push to the next one, and between sessions, in s.
const PAUSE: i64 = 20;
const SESSION_PAUSE: i64 = 3600;
const SESSIONS_HEADER: &str = "recording,session,repeat\n";

/// What a recording set is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct GenerateSettings {
    /// Title of the set.
    pub name: String,
    /// The object.
    pub object: PushedObject,
    /// What the manifest claims.
    pub nominal: Nominal,
    /// What is true before anything is hidden.
    pub truth: Truth,
    /// What is hidden in the truth, in this order.
    pub hidden: Vec<Hidden>,
    /// Which pushes are made.
    pub design: Design,
    /// How they scatter.
    pub scatter: Scatter,
    /// What records them.
    pub sensors: Sensors,
    /// How finely they are simulated.
    pub numerics: Numerics,
    /// How recordings are written: `mcap-ros2`, `mcap-ros1`, `mcap-json`, `csv` or `mit-json`, or
    /// another one of `dataset`'s writers.
    pub format: String,
    /// Seed of everything random.
    pub seed: u64,
}

impl Default for GenerateSettings {
    fn default() -> Self {
        Self {
            name: "simulated pushes".into(),
            object: PushedObject::default(),
            nominal: Nominal::default(),
            truth: Truth::default(),
            hidden: Vec::new(),
            design: Design::default(),
            scatter: Scatter::default(),
            sensors: Sensors::default(),
            numerics: Numerics::default(),
            format: "mcap-ros2".into(),
            seed: 7,
        }
    }
}

/// What was made.
#[derive(Clone, Debug, PartialEq)]
pub struct GenerateReport {
    /// The recording set's folder.
    pub set: PathBuf,
    /// The file with the truth, beside it.
    pub sealed_truth: PathBuf,
    /// Number of pushes.
    pub n_pushes: usize,
    /// Pushes of the grid left out because the tip would have begun inside the object.
    pub n_blocked: usize,
    /// Time that all the pushes take on the rig, in s.
    pub rig_time: f64,
}

/// One simulated push of a set, as it is written and as it really was.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedPush {
    /// How it was planned.
    pub plan: PlannedPush,
    /// How it differs from the others.
    pub variation: Variation,
    /// Where the object really was at the start.
    pub start: planar::Pose,
    /// What happened.
    pub trajectory: Trajectory,
    /// What was recorded.
    pub recording: Recording,
}

/// Simulates pushes and writes them as a recording set, with the truth sealed in a file beside it.
///
/// `out` gets `dataset.toml`, `sessions.csv` and `pushes/`; the truth goes to `OUT.truth.toml`,
/// which nothing else reads. The same settings give the same bytes on any machine and any number of
/// threads.
///
/// # Errors
/// `Io` if `out` has no name of its own (as `.`), has files in it or cannot be written, or if the
/// file for its truth is there; an error of the settings; `Push` with the
/// name of a push that could not be simulated.
pub fn generate(settings: &GenerateSettings, out: &Path) -> Result<GenerateReport, PlantError> {
    generate_each(settings, out, |_| {})
}

/// As [`generate`], and calls `after_push` after each push, in no certain order, with the number of
/// pushes that the set will have.
///
/// # Errors
/// As [`generate`].
pub fn generate_each(
    settings: &GenerateSettings,
    out: &Path,
    after_push: impl Fn(usize) + Sync,
) -> Result<GenerateReport, PlantError> {
    let writer = writer(&settings.format)?;
    let set = Set::new(settings)?;
    let sealed_truth = sealed_path(out)?;
    make_folder(out, &sealed_truth)?;
    let folder = out.join("pushes");
    let written = set.pushes().map(|push| {
        let push = push?;
        writer.write(&push.recording, &folder)?;
        after_push(set.plan.len());
        let SimulatedPush { plan, variation, start, trajectory, recording } = push;
        let place = [start.position.x, start.position.y, start.angle];
        let sealed = SealedPush { recording: recording.name, plan, place, variation };
        Ok((sealed, trajectory.duration()))
    });
    let (pushes, durations): (Vec<_>, Vec<f64>) =
        written.collect::<Result<Vec<_>, PlantError>>()?.into_iter().unzip();
    let sessions = pushes.iter().map(|push| {
        format!("{},session-{},{}\n", push.recording, push.plan.session, push.plan.repeat)
    });
    let sessions: String = std::iter::once(SESSIONS_HEADER.to_owned()).chain(sessions).collect();
    write_file(&out.join("sessions.csv"), &sessions)?;
    let n_pushes = pushes.len();
    write_file(&sealed_truth, &SealedTruth::new(settings, &set, pushes).to_text()?)?;
    // The manifest comes last: a set without it is a set that was not finished.
    let format = writer.format();
    let manifest = manifest_text(&settings.name, &settings.object, &settings.nominal, format)
        + &streams_text(format, &settings.sensors);
    write_file(&out.join(dataset::MANIFEST_NAME), &manifest)?;
    Ok(GenerateReport {
        set: out.to_owned(),
        sealed_truth,
        n_pushes,
        n_blocked: set.n_blocked,
        rig_time: durations.iter().sum(),
    })
}

/// Simulates the pushes of a set without writing anything, in order.
///
/// # Errors
/// As [`generate`], without those of files.
pub fn simulate(settings: &GenerateSettings) -> Result<Vec<SimulatedPush>, PlantError> {
    Set::new(settings)?.pushes().collect()
}

/// A set about to be simulated.
pub(crate) struct Set<'a> {
    settings: &'a GenerateSettings,
    pub(crate) hidden: Vec<HiddenEffect>,
    plant: Plant,
    shape: planar::Shape,
    pub(crate) design: Design,
    plan: Vec<PlannedPush>,
    /// Whole seconds at which the pushes begin.
    epochs: Vec<i64>,
    n_blocked: usize,
}

impl<'a> Set<'a> {
    fn new(settings: &'a GenerateSettings) -> Result<Self, PlantError> {
        settings.sensors.check()?;
        settings.scatter.check()?;
        let nominal = &settings.nominal;
        let manifest = manifest_text(&settings.name, &settings.object, nominal, "csv");
        let object = object_of(&manifest, Path::new(dataset::MANIFEST_NAME))?;
        let (mut truth, mut design) = (settings.truth.clone(), settings.design.clone());
        let mut hidden = Vec::new();
        for (number, asked) in settings.hidden.iter().enumerate() {
            let is_possible = |effect: &HiddenEffect| {
                let (mut truth, mut design) = (truth.clone(), design.clone());
                effect.apply(&mut truth, &mut design).is_ok()
                    && Plant::new(&object, &truth, nominal.gravity, &settings.numerics).is_ok()
            };
            let effect = asked.resolved((settings.seed, number), is_possible)?;
            effect.apply(&mut truth, &mut design)?;
            hidden.push(effect);
        }
        let plant = Plant::new(&object, &truth, nominal.gravity, &settings.numerics)?;
        let plan = design.plan(&object.shape, nominal.pusher_radius, settings.seed)?;
        let (shape, n_blocked, plan) = (object.shape, plan.n_blocked, plan.pushes);
        let mut set =
            Self { settings, hidden, plant, shape, design, plan, epochs: Vec::new(), n_blocked };
        let mut next = FIRST_EPOCH;
        for index in 0..set.plan.len() {
            let session = |index: usize| set.plan[index].session;
            if index > 0 && session(index) != session(index - 1) {
                next += SESSION_PAUSE;
            }
            set.epochs.push(next);
            next += PAUSE + set.path(&set.plan[index]).duration().ceil() as i64;
        }
        Ok(set)
    }

    fn path(&self, plan: &PlannedPush) -> TipPath {
        let radius = self.settings.nominal.pusher_radius;
        plan.path(&self.shape, radius, self.design.acceleration, self.design.rests)
    }

    pub(crate) fn truth(&self) -> &Truth {
        self.plant.truth()
    }

    fn pushes(
        &self,
    ) -> impl IndexedParallelIterator<Item = Result<SimulatedPush, PlantError>> + '_ {
        self.plan.par_iter().enumerate().map(|(index, plan)| {
            self.push(index, plan).map_err(|source| PlantError::Push {
                name: push_name(index),
                source: Box::new(source),
            })
        })
    }

    fn push(&self, index: usize, plan: &PlannedPush) -> Result<SimulatedPush, PlantError> {
        let Self { settings, plant, .. } = self;
        let (seed, scatter) = (settings.seed, &settings.scatter);
        let mut variation = scatter.draw(seed, plan.session, index);
        let age = index as f64 / (self.plan.len() - 1).max(1) as f64 - 0.5;
        variation.support_friction *= 1.0 + age * plant.truth().support_friction.drift;
        let mut random = Random::new(seed, Purpose::Placing, index as u64);
        let mut start = plan.pose();
        start.position.x += random.normal(scatter.placing_sd);
        start.position.y += random.normal(scatter.placing_sd);
        start.angle += random.normal(scatter.turning_sd);
        let trajectory = plant.push(&start, &self.path(plan), &variation)?;
        let Streams { robot, object, wrench } =
            settings.sensors.read(plant, &trajectory, &variation, (seed, index));
        let recording =
            Recording::made(push_name(index), self.epochs[index], robot, object, wrench);
        Ok(SimulatedPush { plan: plan.clone(), variation, start, trajectory, recording })
    }
}

fn writer(name: &str) -> Result<&'static dyn RecordingWriter, PlantError> {
    let found = all_writers().iter().find(|writer| writer.id() == name);
    found.copied().ok_or_else(|| PlantError::UnknownFormat {
        name: name.to_owned(),
        allowed: all_writers().iter().map(|writer| writer.id()).collect::<Vec<_>>().join(", "),
    })
}

/// Makes the set's folder; neither files in it nor a truth that is there are touched.
fn make_folder(out: &Path, sealed_truth: &Path) -> Result<(), PlantError> {
    let is_full = out.exists() && {
        let mut entries = fs::read_dir(out).map_err(|error| PlantError::io("read", out, error))?;
        entries.next().is_some()
    };
    if is_full {
        return Err(refused("write a set to", out, "the folder is not empty; choose a new one"));
    }
    if sealed_truth.exists() {
        let why = "the file exists; remove it or name another set";
        return Err(refused("seal a truth in", sealed_truth, why));
    }
    fs::create_dir_all(out).map_err(|error| PlantError::io("create", out, error))
}

/// `OUT.truth.toml`, beside the folder.
fn sealed_path(out: &Path) -> Result<PathBuf, PlantError> {
    let name = out.file_name().ok_or_else(|| {
        refused("seal a truth beside", out, "the folder needs a name; name a new one")
    })?;
    Ok(out.with_file_name(format!("{}.truth.toml", name.to_string_lossy())))
}

fn refused(what: &'static str, path: &Path, why: &str) -> PlantError {
    PlantError::io(what, path, std::io::Error::other(why))
}

/// Writes under a temporary name first: a killed run leaves no half file.
fn write_file(path: &Path, text: &str) -> Result<(), PlantError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let temporary = path.with_file_name(format!(".{name}.part"));
    fs::write(&temporary, text)
        .and_then(|()| fs::rename(&temporary, path))
        .map_err(|error| PlantError::io("write", path, error))
}
