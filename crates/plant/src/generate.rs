//! Recording sets with a sealed truth.

use std::path::{Path, PathBuf};

use dataset::{Recording, RecordingWriter, all_writers};
use output::{Existing, OutputFile, OutputFolder};
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

/// Where a recording set goes, and the truth beside it.
#[derive(Debug)]
pub struct SetOutput {
    folder: OutputFolder,
    sealed_truth: OutputFile,
    comment: String,
}

impl SetOutput {
    /// Takes the places of a new or empty folder and of `OUT.truth.toml` beside it.
    ///
    /// # Errors
    /// `Output` if `out` has no name of its own (as `.`), has files in it or cannot be written, or
    /// if the file for its truth is there.
    pub fn new(out: &Path) -> Result<Self, PlantError> {
        Self::apart_from(&[], out)
    }

    /// The same, and makes sure first that neither is one of the inputs, or lies in one.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn apart_from(inputs: &[PathBuf], out: &Path) -> Result<Self, PlantError> {
        let folder = OutputFolder::apart_from(inputs, out, Existing::Refuse)?;
        let name = out.file_name().unwrap_or_default().to_string_lossy();
        let path = out.with_file_name(format!("{name}.truth.toml"));
        let sealed_truth = OutputFile::apart_from(inputs, &path, Existing::Refuse)?;
        Ok(Self { folder, sealed_truth, comment: String::new() })
    }

    /// The same with lines at the end of the truth, as `# made by …`.
    #[must_use]
    pub fn with_comment(self, comment: String) -> Self {
        Self { comment, ..self }
    }
}

/// Simulates pushes and writes them as a recording set, with the truth sealed in a file beside it.
///
/// `out` gets `dataset.toml`, `sessions.csv` and `pushes/`; the truth goes to `OUT.truth.toml`,
/// which nothing else reads. The same settings give the same bytes on any machine and any number of
/// threads.
///
/// # Errors
/// As [`SetOutput::new`] and [`generate_each`].
pub fn generate(settings: &GenerateSettings, out: &Path) -> Result<GenerateReport, PlantError> {
    generate_each(settings, SetOutput::new(out)?, |_| {})
}

/// As [`generate`], and calls `after_push` after each push, in no certain order, with the number of
/// pushes that the set will have.
///
/// The folder appears when it is whole, after the truth: there is no set without its truth.
///
/// # Errors
/// An error of the settings; `Push` with the name of a push that could not be simulated; `Output`
/// if a file cannot be written.
pub fn generate_each(
    settings: &GenerateSettings,
    out: SetOutput,
    after_push: impl Fn(usize) + Sync,
) -> Result<GenerateReport, PlantError> {
    let writer = writer(&settings.format)?;
    let set = Set::new(settings)?;
    let part = out.folder.begin()?;
    let pushes_folder = part.path().join("pushes");
    let written = set.pushes().map(|push| {
        let push = push?;
        writer.write(&push.recording, &pushes_folder)?;
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
    part.write("sessions.csv", sessions)?;
    let n_pushes = pushes.len();
    let format = writer.format();
    let manifest = manifest_text(&settings.name, &settings.object, &settings.nominal, format)
        + &streams_text(format, &settings.sensors);
    part.write(dataset::MANIFEST_NAME, manifest)?;
    let report = GenerateReport {
        set: out.folder.path().to_owned(),
        sealed_truth: out.sealed_truth.path().to_owned(),
        n_pushes,
        n_blocked: set.n_blocked,
        rig_time: durations.iter().sum(),
    };
    let truth = SealedTruth::new(settings, &set, pushes).to_text()?;
    out.sealed_truth.write(truth + &out.comment)?;
    out.folder.finish(part)?;
    Ok(report)
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
