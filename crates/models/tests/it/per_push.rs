//! Parameters that differ from push to push: a push draws them once, and all its steps share the draw.

use std::sync::Arc;

use dataset::SupportSpec;
use effects::{Object, Setting, Spread, Track, by_id};
use filter::{PlanarSummary, Unscented};
use models::{
    Analytical, Base, CharacteristicLength, Description, Estimate, Hybrid, Matching, ModelEffect,
    Noise, PoseSeen, ProcessKind, PushModel, PushParticle, PushPath, Pushed, RecordedPush, RollOut,
    RollOutSettings, Setup, StepCorrelation, StepInput, StepObservation, Training,
};
use nalgebra::{Matrix3, Vector2, Vector3};
use planar::{Pose, Shape, Twist, perpendicular};

pub(crate) const TABLE: SupportSpec = SupportSpec { friction: 0.25, gravity: 9.81 };
const RADIUS: f64 = 0.005;
const FACE: f64 = -0.045 - RADIUS;

/// An effect with values, of which some differ from push to push.
pub(crate) type Varied<'a> = (&'a str, &'a [f64], &'a [(&'a str, Spread)]);

pub(crate) fn description(effects: &[Varied<'_>], scatter: f64) -> Description {
    let scatter = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 1100.0)) * scatter;
    let friction = Estimate::exact(0.25, "");
    let base = Analytical::new(friction, CharacteristicLength::UniformPressure, scatter).unwrap();
    let effect = |(id, values, spreads): &Varied<'_>| {
        let about = by_id(id).unwrap().info();
        let spreads = spreads.iter().map(|(name, spread)| ((*name).to_owned(), *spread));
        ModelEffect::from(Setting { per_push: spreads.collect(), ..Setting::new(about, values) })
    };
    let effects = effects.iter().map(effect).collect();
    Description { effects, ..base.describe().unwrap() }
}

fn built(effects: &[Varied<'_>], scatter: f64) -> Box<dyn PushModel> {
    description(effects, scatter).build_in(TABLE, &[]).unwrap()
}

fn square() -> Pushed {
    let shape = Arc::new(Shape::square(0.09).unwrap());
    let object = Some(Arc::new(Object::uniform(shape.clone(), 0.84).unwrap()));
    Pushed { shape, pusher_radius: RADIUS, object }
}

fn path(y: f64) -> PushPath {
    let start = Vector2::new(FACE, y);
    PushPath::straight(start, start + Vector2::new(0.03, 0.016), 0.02).unwrap()
}

fn particles(n_particles: usize) -> RollOutSettings {
    RollOutSettings { n_particles, touching: true, ..RollOutSettings::default() }
}

fn ends(model: &dyn PushModel, settings: &RollOutSettings, y: f64) -> Vec<PushParticle> {
    let (pushed, mut last) = (square(), Vec::new());
    let roll_out = RollOut { model, pushed: &pushed, settings };
    roll_out.run(&Pose::default(), &path(y), |_, now| last = now.to_vec()).unwrap();
    last
}

fn matched(model: &dyn PushModel, y: f64) -> (Vector3<f64>, Matrix3<f64>) {
    let (pushed, settings) = (square(), particles(1));
    let roll_out = RollOut { model, pushed: &pushed, settings: &settings };
    let rule = Matching::Points(&Unscented);
    let end = roll_out.matched(&Pose::default(), &path(y), rule, 1).unwrap().pop().unwrap();
    let end = end.moments().unwrap();
    let mean = Vector3::from_iterator(end.mean().iter().copied());
    (mean, Matrix3::from_iterator(end.covariance().iter().copied()))
}

/// Mean and covariance of poses of equal weight.
fn moments(poses: &[Pose]) -> (Vector3<f64>, Matrix3<f64>) {
    let n = poses.len() as f64;
    let place = |pose: &Pose| Vector3::new(pose.position.x, pose.position.y, pose.angle);
    let mean = poses.iter().map(place).sum::<Vector3<f64>>() / n;
    let square = |pose: &Pose| (place(pose) - mean) * (place(pose) - mean).transpose();
    (mean, poses.iter().map(square).sum::<Matrix3<f64>>() / n)
}

fn poses(particles: &[PushParticle]) -> Vec<Pose> {
    particles.iter().map(|particle| particle.pose_wb).collect()
}

/// Numbers that cut a standard normal number into parts of equal probability, in their middles.
fn normal_places(n: usize) -> Vec<f64> {
    let place = |share: f64| {
        let (mut low, mut high) = (-8.0, 8.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let below = 0.5 * libm::erfc(-middle / std::f64::consts::SQRT_2);
            if below < share { low = middle } else { high = middle }
        }
        low
    };
    (0..n).map(|k| place((k as f64 + 0.5) / n as f64)).collect()
}

fn assert_near(
    (mean, covariance): (Vector3<f64>, Matrix3<f64>),
    brute: &(Vector3<f64>, Matrix3<f64>),
    (of_mean, of_sd): (f64, f64),
    case: &str,
) {
    let sd = brute.1.diagonal().map(f64::sqrt);
    let off = (mean - brute.0).component_div(&sd).amax();
    assert!(off < of_mean, "{case}: the mean is off by {off}");
    for k in 0..3 {
        let ratio = covariance[(k, k)].sqrt() / sd[k];
        assert!((ratio - 1.0).abs() < of_sd, "{case}: {ratio} of {k}");
    }
    let correlation = |c: &Matrix3<f64>| c[(1, 2)] / (c[(1, 1)] * c[(2, 2)]).sqrt();
    let off = correlation(&covariance) - correlation(&brute.1);
    assert!(off.abs() < 0.1, "{case}: the correlation is off by {off}");
}

#[test]
fn a_whole_push_scatters_as_whole_pushes_with_draws_of_their_own_do() {
    let relative = [("friction", Spread::RelativeSd(0.4))];
    let center = [("dx", Spread::Sd(0.003)), ("dy", Spread::Sd(0.005))];
    let thicker = [("excess", Spread::Sd(5e-4))];
    let plain: Varied<'_> = ("pusher-friction", &[0.25], &[]);
    let cases: [(&str, Varied<'_>); 3] = [
        ("friction", ("pusher-friction", &[0.25], &relative)),
        ("center", ("friction-center-offset", &[0.001, 0.004], &center)),
        ("thickness", ("pusher-radius", &[2e-4], &thicker)),
    ];
    for (name, varied) in cases {
        let (id, values, spreads) = varied;
        let about = by_id(id).unwrap().info();
        // Whole pushes, each by a model with values of its own.
        let places = normal_places(if spreads.len() == 1 { 120 } else { 16 });
        let n_pushes = places.len().pow(u32::try_from(spreads.len()).unwrap());
        let push = |k: usize| {
            let mut own = values.to_vec();
            for (axis, (parameter, spread)) in spreads.iter().enumerate() {
                let number = places[k / places.len().pow(axis as u32) % places.len()];
                let index = about.parameters.iter().position(|one| one.name == *parameter);
                let value = &mut own[index.unwrap()];
                *value = match spread {
                    Spread::Sd(sd) => *value + sd * number,
                    Spread::RelativeSd(sd) => *value * (sd * number).exp(),
                };
            }
            let alone: &[Varied<'_>] = &[plain, (id, &own, &[])];
            let alone = if id == plain.0 { &alone[1..] } else { alone };
            ends(&*built(alone, 0.0), &particles(1), 0.012)[0].pose_wb
        };
        let brute = moments(&(0..n_pushes).map(push).collect::<Vec<_>>());
        let all: &[Varied<'_>] = &[plain, varied];
        let model = built(if id == plain.0 { &all[1..] } else { all }, 0.0);
        let last = ends(&*model, &particles(3000), 0.012);
        assert_near(moments(&poses(&last)), &brute, (0.07, 0.07), name);
        // A few places of a draw see a kink of sticking and sliding no better.
        assert_near(matched(&*model, 0.012), &brute, (0.2, 0.2), name);
    }
}

#[test]
fn scatter_of_steps_adds_to_what_pushes_share() {
    let friction = [("friction", Spread::RelativeSd(0.4))];
    let model = |spreads: &[(&str, Spread)], scatter| {
        built(&[("pusher-friction", &[0.25], spreads)], scatter)
    };
    let variances =
        |model: &dyn PushModel| moments(&poses(&ends(model, &particles(6000), 0.012))).1.diagonal();
    let shared = variances(&*model(&friction, 0.0));
    let own = variances(&*model(&[], 1e-3));
    let both = variances(&*model(&friction, 1e-3));
    let ratio = both.component_div(&(shared + own));
    assert!(ratio.iter().all(|ratio| (ratio - 1.0).abs() < 0.15), "{ratio}");
    assert!(shared.y > 0.5 * own.y, "{shared} {own}");
}

#[test]
fn a_spread_of_nothing_changes_no_byte() {
    let none = [("friction", Spread::RelativeSd(0.0))];
    let with = built(&[("pusher-friction", &[0.25], &none)], 1e-3);
    let without = built(&[("pusher-friction", &[0.25], &[])], 1e-3);
    assert_eq!(ends(&*with, &particles(50), 0.01), ends(&*without, &particles(50), 0.01));
    assert_eq!(matched(&*with, 0.01), matched(&*without, 0.01));
    let steps: Vec<_> = recorded(&*without, 3).steps.into_iter().map(|step| step.input).collect();
    let said = |model: &dyn PushModel| model.predict(&steps, Noise::Included).unwrap();
    assert_eq!(said(&*with), said(&*without));
}

#[test]
fn draws_do_not_depend_on_the_number_of_threads() {
    let friction = [("friction", Spread::RelativeSd(0.4))];
    let model = built(&[("pusher-friction", &[0.25], &friction)], 1e-3);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| ends(&*model, &particles(700), 0.01))
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn a_filter_learns_what_its_push_has_drawn() {
    /// What the push has drawn.
    const TRUE: f64 = 1.5;
    let center = [("dy", Spread::Sd(0.006))];
    let model = built(&[("friction-center-offset", &[0.0, 0.0], &center)], 1e-5);
    let truth = built(&[("friction-center-offset", &[0.0, 0.006 * TRUE], &[])], 1e-5);
    let push = recorded(&*truth, 5);
    let settings = RollOutSettings { step: 0.01, ..particles(1000) };
    let roll_out = RollOut { model: &*model, pushed: &push.pushed, settings: &settings };
    let mut filter = roll_out.start(&push.poses_wb[0], &push.path).unwrap();
    let first: Vec<f64> = filter.particles().iter().map(|one| one.drawn()[0]).collect();
    let mean = first.iter().sum::<f64>() / first.len() as f64;
    assert!(mean.abs() < 0.15, "{mean}");
    for (step, pose_wb) in push.path.steps(0.01).unwrap().iter().zip(&push.poses_wb[1..]) {
        filter.predict(&roll_out.motion(step).unwrap()).unwrap();
        filter.update(&PoseSeen { pose_wb: *pose_wb, sd: [3e-4, 5e-3] }).unwrap();
    }
    let weights = filter.weights().as_slice();
    let known = filter.particles().iter().zip(weights);
    let (mut mean, mut square) = (0.0, 0.0);
    for (particle, weight) in known {
        let number = particle.drawn()[0];
        assert!(first.contains(&number), "a particle keeps its draw");
        mean += weight * number;
        square += weight * number * number;
    }
    let sd = (square - mean * mean).sqrt();
    assert!(sd < 0.4 && (mean - TRUE).abs() < 3.0 * sd, "{mean} {sd}");
    let now = PlanarSummary::of(filter.particles(), filter.weights()).unwrap().mean;
    let end = push.poses_wb[push.poses_wb.len() - 1];
    assert!((now.z - end.angle).abs() < 0.02, "{now} {end:?}");
}

/// A push as a model goes, with the model's scatter.
fn recorded(model: &dyn PushModel, seed: u64) -> RecordedPush {
    let settings = RollOutSettings { seed, ..particles(1) };
    let (pushed, mut poses_wb) = (square(), Vec::new());
    let y = 0.024 * ((seed * 7919 % 64) as f64 / 64.0 - 0.5);
    let way = path(y);
    let roll_out = RollOut { model, pushed: &pushed, settings: &settings };
    roll_out.run(&Pose::default(), &way, |_, now| poses_wb.push(now[0].pose_wb)).unwrap();
    let path_steps = way.steps(settings.step).unwrap();
    let corners: Vec<Vector2<f64>> =
        std::iter::once(way.start_w()).chain(path_steps.iter().map(|step| step.end_w)).collect();
    let steps = path_steps.iter().zip(poses_wb.windows(2)).map(|(step, ends)| {
        let whole = effects::StepInput {
            object: pushed.object.clone().unwrap(),
            pusher_radius: RADIUS,
            pose_wb: ends[0],
            twist_wb: Twist::default(),
            track: Track::straight(step.start_w, step.end_w, step.duration),
            touching: true,
            since_contact: step.time,
            run_up: None,
            progress: 0.5,
            session: 0,
        };
        let along = (step.end_w - step.start_w).normalize();
        let moved = ends[1].position - ends[0].position;
        let turn = ends[1].angle - ends[0].angle;
        let outputs = Vector3::new(moved.dot(&along), moved.dot(&perpendicular(&along)), turn);
        StepObservation { input: StepInput::of(whole, pushed.shape.clone()).unwrap(), outputs }
    });
    let steps = steps.collect();
    let path = PushPath::polyline(&corners, 0.02).unwrap();
    let pose_sd = [[1e-6, 1e-5]; 2];
    RecordedPush { name: format!("push#{seed}"), path, poses_wb, steps, pose_sd, pushed }
}

/// Pushes that each draw a center of friction.
pub(crate) fn drawing_pushes(sd: f64, n: u64) -> Vec<RecordedPush> {
    let places = normal_places(n as usize);
    let push = |k: u64| {
        let dy = sd * places[(k * 37 % n) as usize];
        recorded(&*built(&[("friction-center-offset", &[0.0, dy], &[])], 2e-4), k)
    };
    (0..n).map(push).collect()
}

#[test]
fn spreads_are_scaled_to_what_the_ends_of_pushes_show() {
    let pushes = drawing_pushes(0.004, 60);
    let setup = Setup { support: TABLE, own: Vec::new() };
    for sd in [0.0013, 0.004, 0.012] {
        let spread = [("dy", Spread::Sd(sd))];
        let model = description(&[("friction-center-offset", &[0.0, 0.0], &spread)], 2e-4);
        let found = model.calibration(&setup, &pushes).unwrap();
        let widened = found.widened.unwrap();
        assert!((0.7..1.4).contains(&(widened * sd / 0.004)), "{sd}: {widened}");
        let told = model.with(&found).unwrap().effects[0].per_push["dy"];
        assert_eq!(told, Spread::Sd(widened * sd));
        assert!(found.correlation.is_none() && found.n_pushes == 30);
    }
    let few =
        description(&[("friction-center-offset", &[0.0; 2], &[("dy", Spread::Sd(0.001))])], 0.0);
    let refused = few.calibration(&setup, &pushes[..7]).unwrap_err();
    assert!(refused.to_string().contains('7'), "{refused}");
}

#[test]
fn physics_without_scatter_get_that_of_the_steps() {
    let pushes = drawing_pushes(0.004, 40);
    let setup = Setup { support: TABLE, own: Vec::new() };
    let model = description(&[], 0.0);
    let found = model.calibration(&setup, &pushes).unwrap();
    let with = model.with(&found).unwrap();
    let Base::Analytical(base) = &with.base else { panic!("{with:?}") };
    assert!(base.scatter().diagonal().iter().all(|variance| *variance > 0.0));
    // What each push draws its steps share.
    let held = found.correlation.unwrap().held;
    assert!(held[1] > 0.5 && found.widened.is_none(), "{held:?}");
}

#[test]
fn what_pushes_draw_is_no_error_that_their_steps_share() {
    let pushes = drawing_pushes(0.004, 80);
    let spread = [("dy", Spread::Sd(0.004))];
    let measured = |spreads: &[(&str, Spread)]| {
        let model = built(&[("friction-center-offset", &[0.0, 0.0], spreads)], 2e-4);
        let found = StepCorrelation::measure(&*model, &pushes).unwrap();
        found.checked(pushes.iter().map(|push| (&*model, push))).unwrap()
    };
    let (with, without) = (measured(&spread), measured(&[]));
    // The variance of a whole push's turn, as a multiple of that of independent steps.
    let whole = |found: &StepCorrelation| {
        let kept = |k: usize, l: usize| (-0.0038 * k.abs_diff(l) as f64 / found.length).exp();
        let pairs = (0..9).flat_map(|k| (0..9).map(move |l| kept(k, l)));
        let shared = found.held[2] * pairs.sum::<f64>() / 9.0;
        (shared + found.own[2]) * found.freedom / (found.freedom - 2.0)
    };
    assert!(whole(&without) > 20.0, "{without:?}");
    assert!((0.5..2.0).contains(&whole(&with)), "{with:?}");
    // Of 80 ends 72 in the region of 90 %, give or take three standard deviations of 2.7.
    let ends = with.ends.unwrap();
    assert!((64..=80).contains(&ends.n_within[1]), "{ends:?}");
}

#[test]
fn a_hybrid_learns_beside_the_mean_over_pushes_and_rolls_out_with_one_draw() {
    let pushes = drawing_pushes(0.005, 40);
    let steps: Vec<_> = pushes.iter().flat_map(|push| push.steps.clone()).collect();
    let spread = [("dy", Spread::Sd(0.005))];
    let base = description(&[("friction-center-offset", &[0.0, 0.0], &spread)], 2e-4);
    let setup = Setup { support: TABLE, own: Vec::new() };
    let training = Training::with(ProcessKind::Rff);
    let (hybrid, _) = Hybrid::train(&base, Some(setup), &steps, &training).unwrap();
    let inputs: Vec<_> = steps[..30].iter().map(|step| step.input.clone()).collect();
    // Over the draws, what is said given one is what is said without.
    let marginal = hybrid.predict(&inputs, Noise::Included).unwrap();
    let none = Vector3::<f64>::zeros();
    let mut sums = vec![(none, none, none); inputs.len()];
    let places = effects::deviations(hybrid.n_drawn());
    for (weight, numbers) in &places {
        let draws = vec![numbers.as_slice(); inputs.len()];
        let said = hybrid.predict_drawn(&inputs, &draws, Noise::Included).unwrap();
        for ((mean, square, own), said) in sums.iter_mut().zip(said) {
            *mean += *weight * said.mean;
            *square += *weight * said.mean.component_mul(&said.mean);
            *own += *weight * said.covariance.diagonal();
        }
    }
    let mut n_alike = 0;
    for ((mean, square, own), said) in sums.iter().zip(&marginal) {
        assert!((mean - said.mean).amax() < 1e-12, "{mean} {}", said.mean);
        let shared = square - mean.component_mul(mean);
        // As much as was learnt, or as much as the draws make where that is more.
        for k in 0..3 {
            let (learnt, whole) = (said.covariance[(k, k)], shared[k] + own[k]);
            let most = learnt.max(shared[k]);
            assert!(whole > 0.999 * most && whole < 1.05 * most, "{learnt} {whole} {shared}");
            n_alike += usize::from(shared[k] < 0.9 * learnt);
        }
    }
    assert!(n_alike > 20, "{n_alike}");
    // A whole push scatters as pushes do, and more than of independent steps.
    let last = moments(&poses(&ends(&hybrid, &particles(600), 0.004))).1;
    let truth: Vec<Pose> = normal_places(60)
        .iter()
        .map(|number| {
            let own = [0.0, 0.005 * number];
            ends(&*built(&[("friction-center-offset", &own, &[])], 0.0), &particles(1), 0.004)[0]
                .pose_wb
        })
        .collect();
    let ratio = (last[(2, 2)] / moments(&truth).1[(2, 2)]).sqrt();
    assert!((0.8..1.3).contains(&ratio), "{ratio}");
}
