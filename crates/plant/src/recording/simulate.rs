//! The pushes of a set, simulated.

use std::path::Path;

use dataset::Recording;
use nalgebra::Vector2;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use crate::design::layout::push_name;
use crate::random::{Purpose, Random};
use crate::recording::pushed_object::{manifest_text, object_of};
use crate::recording::sensors::Streams;
use crate::{
    Design, Hidden, HiddenEffect, Nominal, Numerics, PlannedPush, Plant, PlantError, PushedObject,
    Scatter, Sensors, TipPath, Trajectory, Truth, Variation,
};

/// Stamp of the first push, in s.
const FIRST_EPOCH: i64 = 1000;
/// From the end of a push to the next one, and between sessions, in s.
const PAUSE: i64 = 20;
const SESSION_PAUSE: i64 = 3600;

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

/// Simulates the pushes of a set without writing anything, in order.
///
/// # Errors
/// As [`crate::generate`], without those of files.
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
    pub(crate) plan: Vec<PlannedPush>,
    /// Whole seconds at which the pushes begin.
    epochs: Vec<i64>,
    pub(crate) n_blocked: usize,
}

impl<'a> Set<'a> {
    pub(crate) fn new(settings: &'a GenerateSettings) -> Result<Self, PlantError> {
        settings.sensors.check()?;
        settings.scatter.check()?;
        let nominal = &settings.nominal;
        let manifest = manifest_text(&settings.name, &settings.object, nominal, "csv");
        let object = object_of(&manifest, Path::new(dataset::MANIFEST_NAME))?;
        let (mut truth, mut design) = (settings.truth.clone(), settings.design.clone());
        if truth.texture_seed == 0 {
            truth.texture_seed = settings.seed;
        }
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

    pub(crate) fn pushes(
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
        let mut path = self.path(plan);
        let shift = Vector2::from(variation.shift);
        start.position += shift;
        let direction = Vector2::from(path.direction);
        path.start = (Vector2::from(path.start) + shift - variation.gap * direction).into();
        let trajectory = plant.push(&start, &path, &variation)?;
        let Streams { robot, object, wrench } =
            settings.sensors.read(plant, &trajectory, &variation, (seed, index));
        let recording =
            Recording::made(push_name(index), self.epochs[index], robot, object, wrench);
        Ok(SimulatedPush { plan: plan.clone(), variation, start, trajectory, recording })
    }
}
