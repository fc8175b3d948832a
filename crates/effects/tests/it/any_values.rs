//! Whatever the effects and their values, a prediction is finite or refused with a reason.

use effects::all;
use effects::{
    EffectError, Object, PushMoment, PushPhysics, Rig, RunUp, StepInput, Surface, Track,
};
use mechanics::MechanicsError;
use nalgebra::Vector2;
use planar::{MIT_NAMES, Pose, Twist, mit_object};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

fn objects() -> Vec<Arc<Object>> {
    let object = |name: &&str| {
        let shape = Arc::new(mit_object(name).unwrap().shape);
        Arc::new(Object::uniform(shape, 0.8).unwrap())
    };
    MIT_NAMES.iter().filter(|name| !name.starts_with("ellip")).map(object).collect()
}

fn any_step(random: &mut ChaCha8Rng, object: &Arc<Object>) -> StepInput {
    let (edge, p) =
        (random.random_range(0..object.shape().n_edges()), random.random_range(0.0..1.0));
    let pose_wb = Pose::new(
        random.random_range(-0.5..0.5),
        random.random_range(-0.5..0.5),
        random.random_range(-7.0..7.0),
    );
    let normal = object.shape().inward_normal_at(edge, p);
    let gap = random.random_range(-5e-4..5e-4);
    let start_b = object.shape().point_at(edge, p) - (0.005 + gap) * normal;
    let start = pose_wb.transform_point(&start_b);
    let speed = 10_f64.powf(random.random_range(-2.0..-0.3));
    let turned = Pose::new(0.0, 0.0, random.random_range(-1.8..1.8));
    let direction = pose_wb.rotate(&turned.rotate(&normal));
    let way = if random.random_bool(0.1) { 0.0 } else { random.random_range(1e-4..0.015) };
    let bend = random.random_range(-0.5..0.5) * speed * speed / 0.01;
    let duration = (way / speed).max(0.01);
    let bend = bend * planar::perpendicular(&direction);
    let step = StepInput {
        object: object.clone(),
        pusher_radius: 0.005,
        pose_wb,
        twist_wb: Twist {
            linear: random.random_range(-0.5..1.0) * speed * direction,
            angular: random.random_range(-2.0..2.0),
        },
        track: Track::accelerated(start, start + way * direction, bend, duration),
        touching: random.random_bool(0.8),
        since_contact: random.random_range(0.0..0.1),
        run_up: None,
        progress: random.random_range(0.0..1.0),
        session: 0,
    };
    StepInput { run_up: random.random_bool(0.5).then(|| any_run_up(random, &step)), ..step }
}

/// A way to the start of a step, or to a place beside it, with moments near its contact.
fn any_run_up(random: &mut ChaCha8Rng, step: &StepInput) -> Arc<RunUp> {
    let n = random.random_range(1..6);
    let (start, velocity) = step.track.at(0.0);
    let mut moment = |k: i32| {
        let since_contact = step.since_contact * f64::from(k) / 4.0;
        let before = step.since_contact - since_contact;
        let mut shaken = |size: f64| size * random.random_range(-1.0..1.0);
        let Pose { position, angle } = step.pose_wb;
        PushMoment {
            since_contact,
            pose_wb: Pose::new(
                position.x + shaken(1e-2),
                position.y + shaken(1e-2),
                angle + shaken(0.5),
            ),
            pusher_w: start - before * velocity,
            pusher_velocity_w: velocity + Vector2::new(shaken(0.3), shaken(0.3)),
        }
    };
    Arc::new(RunUp::new((0..n).map(&mut moment).collect()).unwrap())
}

#[test]
fn a_prediction_is_finite_or_refused_with_a_reason() {
    let objects = objects();
    let (mut n_predicted, mut n_refused) = (0, 0);
    for seed in 0..1500 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let is_exact = random.random_bool(0.3);
        let surface = if is_exact { Surface::UniformPatch } else { Surface::Ellipsoid };
        let mut physics = PushPhysics::new(Rig::new(surface, 0.3, 0.25).unwrap());
        let share = random.random_range(0.0..0.4);
        for effect in all() {
            let about = effect.info();
            let reach = 10_f64.powf(random.random_range(-2.0..0.0));
            let value = |parameter: &effects::Parameter| {
                let (low, high) = parameter.range;
                let off = parameter.off(&Rig::new(Surface::Ellipsoid, 0.3, 0.25).unwrap());
                let away: f64 = random.random_range(-1.0..1.0);
                (off + reach * away * (high - low)).clamp(low, high)
            };
            let mut values: Vec<f64> = about.parameters.iter().map(value).collect();
            if about.id == "inertia" {
                values[0] = f64::from(u8::from(random.random_bool(0.7)));
            }
            if random.random_bool(share) {
                physics = physics.with(effect, &values).unwrap();
            }
        }
        let object = &objects[random.random_range(0..objects.len())];
        let step = any_step(&mut random, object);
        match physics.predict(&step) {
            Ok(channels) => {
                n_predicted += 1;
                let finite = channels.to_array().iter().all(|value| value.is_finite());
                let modest = channels.dx.hypot(channels.dy) < 0.2 && channels.dtheta.abs() < 4.0;
                assert!(finite && modest, "seed {seed}: {channels:?} {:?}", physics.settings());
            }
            // Beyond the object, and its reason says how far.
            Err(EffectError::OutOfRange { effect, value, high, .. })
                if effect == "pressure-radius" && value > high => {}
            // No pusher so high finds a lean of its own force, on a table that rubs so much.
            Err(EffectError::TooRound { .. })
            | Err(EffectError::NotConverged { what: "the lean under the push", .. })
            | Err(EffectError::Mechanics(MechanicsError::SlidesByItself { .. })) => n_refused += 1,
            Err(error) => panic!("seed {seed}: {error} {:?}", physics.settings()),
        }
    }
    assert!(n_predicted > 10 * n_refused && n_refused > 0, "{n_predicted} {n_refused}");
}
