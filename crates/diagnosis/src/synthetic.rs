//! Steps whose residuals are known, for tests.

use std::f64::consts::PI;
use std::sync::Arc;

use dataset::{Flags, Manifest, RecordingSet, StepRow, SupportSpec, Table, ingest};
use effects::{Object, Rig, Setting, StepInput, Surface, Track, by_id};
use models::{
    Analytical, ChannelModel, ChannelObservation, Cluster, Description, Excluded, ModelEffect,
    PushModel,
};
use nalgebra::{DMatrix, DVector, Vector2};
use planar::{Pose, Shape, Twist};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::data::observations::Place;
use crate::predict::tangent::Tangent;
use crate::{
    Floor, FloorSource, NoiseFloor, Observations, Predictions, PushName, Whitening, steady_ingest,
};

/// What a miss may depend on.
pub(crate) struct Made {
    pub(crate) p: f64,
    pub(crate) beta: f64,
    pub(crate) edge: u32,
    pub(crate) speed: f64,
    pub(crate) direction: f64,
    /// 1 where the model turns counter-clockwise, −1 where clockwise.
    pub(crate) sense: f64,
}

const N_PUSHES: usize = 1200;
const STEPS_OF_A_PUSH: usize = 4;
/// In the units of the numbers.
const FLOORS: [f64; 7] = [1e-4, 1e-4, 2e-3, 0.05, 0.05, 5e-5, 5e-5];

impl Made {
    fn place(&self, step: u32) -> Place {
        let Self { p, beta, edge, speed, .. } = *self;
        let (flags, pose_sd, is_whole) = (Flags::default(), [[0.0; 2]; 2], false);
        Place { step, edge, p, beta, speed, flags, pose_sd, is_whole }
    }
}

/// Pushes of random kind with a model that misses `number` by `miss`, and every number by noise of a
/// tenth of the floor a push and as much a step.
pub(crate) fn made(
    number: usize,
    miss: impl Fn(&Made) -> f64,
) -> (Observations, Predictions, NoiseFloor) {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let shape = Arc::new(Shape::square(0.09).unwrap());
    let object = Arc::new(Object::new(shape, 0.8374, 1.13e-3, Vector2::zeros()).unwrap());
    let (mut steps, mut places, mut push_of, mut values) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for push in 0..N_PUSHES {
        let speed = [0.01, 0.02, 0.1, 0.2][rng.random_range(0..4)];
        let edge = rng.random_range(0..4);
        let (p, beta) = (rng.random::<f64>(), rng.random_range(-1.2..1.2));
        let direction = rng.random_range(-PI..PI);
        let yaw = rng.random_range(-PI..PI);
        let of_push: f64 = rng.random_range(-1.7..1.7);
        let sense = if p < 0.5 { 1.0 } else { -1.0 };
        for step in 0..STEPS_OF_A_PUSH {
            let made = Made { p, beta, edge, speed, direction, sense };
            let noise = |floor: f64, own: f64| 0.1 * floor * (of_push + own);
            let own: [f64; 7] = std::array::from_fn(|_| rng.random_range(-1.7..1.7));
            let predicted = [0.0036, -0.001 * beta, 0.03 * sense, 1.9, 0.3, 0.0, 0.0];
            let observed = std::array::from_fn(|k| {
                let missed = if k == number { miss(&made) } else { 0.0 };
                Some(predicted[k] + missed + noise(FLOORS[k], own[k]))
            });
            let start = Vector2::new(rng.random_range(-0.1..0.1), rng.random_range(-0.1..0.1));
            let way = 0.004 * Vector2::new(direction.cos(), direction.sin());
            let input = StepInput {
                object: object.clone(),
                pusher_radius: 0.00475,
                pose_wb: Pose { position: start, angle: yaw },
                twist_wb: Twist::default(),
                track: Track::straight(start, start + way, 0.004 / speed),
                touching: true,
                since_contact: 0.2 * step as f64,
                run_up: None,
                progress: push as f64 / N_PUSHES as f64,
                session: 0,
            };
            steps.push(ChannelObservation { input, observed });
            places.push(made.place(step as u32));
            push_of.push(push);
            values.push(predicted.map(Some));
        }
    }
    let name = |k: usize| PushName { recording: format!("made-{k}"), push: 0 };
    let observations = Observations {
        cluster_of: push_of.clone(),
        cluster: Cluster::Push,
        steps,
        places,
        push_of,
        pushes: (0..N_PUSHES).map(name).collect(),
        support: SupportSpec { friction: 0.25, gravity: 9.81 },
        set: String::new(),
        name: "synthetic".to_owned(),
        unknown: Vec::new(),
        excluded: Excluded::default(),
        runs: None,
    };
    let predictions = Predictions { variances: vec![[None; 7]; values.len()], values };
    (observations, predictions, floor())
}

/// Standard deviations of the noise of each number.
pub(crate) const NOISE: [f64; 7] = [3e-5, 3e-5, 1.5e-3, 0.05, 0.05, 5e-5, 5e-5];

/// The recorded pushes, taken in so many sessions, and the thesis' nominal model.
pub(crate) fn recorded(n_sessions: u32) -> (Observations, Description) {
    let (table, manifest) = recorded_table(n_sessions);
    described(&table, &manifest)
}

/// A third of the steps of the same pushes, each of which is repeated in its session.
pub(crate) fn repeated(n_sessions: u32, n_copies: usize) -> (Observations, Description) {
    let (mut table, manifest) = recorded_table(n_sessions);
    table.rows.retain(|row| row.step % 3 == 1);
    let copy = |k: usize| {
        let named = |row: &StepRow| format!("{}-{k}", row.recording).into();
        let rows =
            table.rows.iter().map(move |row| StepRow { recording: named(row), ..row.clone() });
        rows.collect::<Vec<_>>()
    };
    table.rows = (0..n_copies).flat_map(copy).collect();
    described(&table, &manifest)
}

/// The recorded pushes as a model with an effect of some values makes them, in noise of [`NOISE`]; and the
/// nominal model and that one.
pub(crate) fn pushed_with(
    (id, values): (&str, &[f64]),
    seed: u64,
) -> (Observations, Description, Description) {
    let (mut observations, model) = recorded(1);
    let mut truth = model.clone();
    truth.effects.push(ModelEffect::from(Setting::new(by_id(id).unwrap().info(), values)));
    let predicted = Predictions::of(&truth, &[], &observations).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for (step, predicted) in observations.steps.iter_mut().zip(predicted.steps()) {
        for (number, value) in step.observed.iter_mut().enumerate() {
            let made = predicted[number].map(|at| at + NOISE[number] * normal(&mut rng));
            *value = value.and(made);
        }
    }
    (observations, model, truth)
}

/// The same pushes in so many times their noise about a model.
pub(crate) fn in_more_noise(
    mut observations: Observations,
    truth: &Description,
    times: f64,
) -> Observations {
    let predicted = Predictions::of(truth, &[], &observations).unwrap();
    for (step, predicted) in observations.steps.iter_mut().zip(predicted.steps()) {
        for (value, predicted) in step.observed.iter_mut().zip(predicted) {
            *value = value.zip(*predicted).map(|(value, at)| at + times * (value - at));
        }
    }
    observations
}

/// Recorded pushes as the nominal model makes them with a number of an effect that each has of its own, its
/// coordinate off by a standard deviation, in a tenth of [`NOISE`]; that model, and how far off each is.
pub(crate) fn with_own(id: &str, sd: f64, seed: u64) -> (Observations, Description, Vec<f64>) {
    let (mut observed, model) = recorded(1);
    let about = by_id(id).unwrap().info();
    let rig = Rig::new(Surface::Ellipsoid, 0.25, 0.25).unwrap();
    let middle = about.to_coordinates(&about.off(&rig))[0];
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let off: Vec<f64> = observed.pushes.iter().map(|_| sd * normal(&mut rng)).collect();
    for (step, push) in observed.steps.iter_mut().zip(&observed.push_of) {
        let mut own = model.clone();
        let values = about.from_coordinates(&[middle + off[*push]]);
        own.effects.push(Setting::new(about, &values).into());
        let physics = ChannelModel::new(&own, observed.support, &[]).unwrap();
        let made = physics.predict([&step.input]).unwrap()[0].to_array();
        for (k, value) in step.observed.iter_mut().enumerate() {
            *value = value.map(|_| made[k] + 0.1 * NOISE[k] * normal(&mut rng));
        }
    }
    (observed, model, off)
}

fn recorded_table(n_sessions: u32) -> (Table, Manifest) {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/pushes");
    let set = RecordingSet::open(folder.as_ref()).unwrap();
    let mut table = ingest(&set, &steady_ingest()).unwrap().0;
    for row in &mut table.rows {
        let session = row.recording[5..].parse::<u32>().unwrap() % n_sessions;
        row.session = Some(format!("day {session}").into());
    }
    (table, set.manifest().clone())
}

fn described(table: &Table, manifest: &Manifest) -> (Observations, Description) {
    let model = Analytical::nominal(manifest.pusher.friction).unwrap().describe().unwrap();
    (Observations::steady(table, manifest).unwrap(), model)
}

/// Pushes of a model that is true but for what differs from session to session.
pub(crate) struct SessionErrors {
    /// The pushes, as recorded.
    pub(crate) observations: Observations,
    /// The model.
    pub(crate) model: Description,
    /// Its slopes on them.
    pub(crate) tangent: Tangent,
    /// Coordinates of what differs, with their standard deviations.
    sizes: Vec<(usize, f64)>,
}

impl SessionErrors {
    /// - `differs`: effects that differ from session to session, and by what standard deviation in
    ///   the unit of their coordinates.
    pub(crate) fn of(
        (observations, model): (Observations, Description),
        differs: &[(&str, f64)],
    ) -> Self {
        let tangent = Tangent::of(&model, &[], &observations).unwrap();
        let of = |(id, sd): &(&str, f64)| {
            let mut effects = tangent.candidates.effects.iter();
            let found = effects.find(|one| one.effect.info().id == *id).unwrap();
            let sd = *sd;
            found.coordinates.clone().map(move |k| (k, sd))
        };
        let sizes = differs.iter().flat_map(of).collect();
        Self { observations, model, tangent, sizes }
    }

    /// The pushes as observed with errors that those of a session share and noise of [`NOISE`];
    /// `lasting` is what all sessions have of the former, in their standard deviations.
    pub(crate) fn observed(&self, seed: u64, lasting: f64) -> Observations {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut draw = |(k, sd): &(usize, f64)| (*k, sd * (normal(&mut rng) + lasting));
        let last = self.observations.steps.iter().map(|step| step.input.session).max();
        let session = |_| self.sizes.iter().map(&mut draw).collect();
        let sessions: Vec<Vec<(usize, f64)>> = (0..=last.unwrap_or(0)).map(session).collect();
        let mut observed = self.observations.clone();
        for (index, step) in observed.steps.iter_mut().enumerate() {
            let of_session = &sessions[step.input.session as usize];
            for (number, value) in step.observed.iter_mut().enumerate() {
                let slope = |k: usize| self.tangent.slopes(k)[index][number];
                let shared: f64 = of_session.iter().map(|(k, size)| size * slope(*k)).sum();
                let predicted = self.tangent.linearisation.predicted[index][number];
                let noise = NOISE[number] * normal(&mut rng);
                value.iter_mut().for_each(|value| *value = predicted + shared + noise);
            }
        }
        observed
    }
}

/// The covariance of noise of [`NOISE`].
pub(crate) fn white(observations: &Observations) -> Whitening {
    let covariance = |numbers: Vec<(usize, usize)>| {
        let variances = numbers.iter().map(|(_, number)| NOISE[*number].powi(2));
        let variances = DVector::from_iterator(numbers.len(), variances);
        (numbers, DMatrix::from_diagonal(&variances))
    };
    Whitening::new(observations.own_numbers().into_iter().map(covariance)).unwrap()
}

/// A normal number.
pub(crate) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (radius, angle): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * radius.ln()).sqrt() * (2.0 * PI * angle).cos()
}

fn floor() -> NoiseFloor {
    let floor = |rms: f64| {
        Some(Floor { rms, low95: 0.9 * rms, high95: 1.1 * rms, constant: rms, per_meter: 0.0 })
    };
    NoiseFloor {
        source: FloorSource::Repeats,
        n_repeats: 9,
        n_cells: 3,
        widened: Vec::new(),
        numbers: FLOORS.map(floor),
    }
}
