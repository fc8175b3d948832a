//! What is learnt beside physics: it says nothing that the fitted physics could say.

use std::sync::Arc;

use crate::known_steps::{inputs, spread, unit_noise};
use dataset::SupportSpec;
use effects::{Object, Track};
use models::{
    Analytical, Base, ChannelModel, CharacteristicLength, Description, Estimate, GpPushModel,
    Hybrid, ModelEffect, ModelError, ModelFile, Noise, Parts, ProcessKind, PushModel, Setup,
    StepFeatures, StepInput, StepObservation, Training, learn_options, model_kinds,
};
use nalgebra::{Matrix3, Vector2, Vector3};
use planar::{Pose, Shape, Twist};

const SD: Vector3<f64> = Vector3::new(4e-5, 4e-5, 1e-3);
const TABLE: SupportSpec = SupportSpec { friction: 0.25, gravity: 9.81 };

fn truth() -> Analytical {
    at(0.22_f64.ln(), 0.037_f64.ln())
}

/// The model with ln μp and ln c.
fn at(friction: f64, length: f64) -> Analytical {
    let exact = |x: f64| Estimate::exact(x.exp(), "test");
    let length = CharacteristicLength::Given(exact(length));
    Analytical::new(exact(friction), length, Matrix3::zeros()).unwrap()
}

fn nominal() -> Description {
    Analytical::nominal(0.3).unwrap().describe().unwrap()
}

fn input(shape: &Arc<Shape>, edge: usize, k: usize) -> StepInput {
    let (p, beta) = (spread(k, 0.754_877_666), 1.6 * spread(k, 0.569_840_290) - 0.8);
    StepInput::on_edge(shape.clone(), 0.00475, edge, p, beta, 0.004).unwrap()
}

/// What no value of μp and c says: another motion in one part of the edge.
fn discrepancy(step: &StepInput) -> Vector3<f64> {
    let bump = (-0.5 * ((step.p() - 0.75) / 0.12).powi(2)).exp();
    bump * Vector3::new(-2e-4, 3e-4, 0.012)
}

fn steps(n: usize, missing: f64) -> Vec<StepObservation> {
    let shape = Arc::new(Shape::square(0.09).unwrap());
    let step = |k: usize| {
        let input = input(&shape, 1, k);
        let mean = truth().predict(std::slice::from_ref(&input), Noise::Excluded).unwrap()[0].mean;
        let noise = SD.map_with_location(|output, _, sd| sd * unit_noise(k, output));
        StepObservation { outputs: mean + missing * discrepancy(&input) + noise, input }
    };
    (0..n).map(step).collect()
}

fn outputs(model: &Analytical, steps: &[StepObservation]) -> Vec<Vector3<f64>> {
    let found = model.predict(&inputs(steps), Noise::Excluded).unwrap();
    found.iter().map(|found| found.mean).collect()
}

/// Slopes of a model's outputs by ln μp and ln c, over 2 % to either side.
fn jacobian(model: &Analytical, steps: &[StepObservation]) -> [Vec<Vector3<f64>>; 2] {
    let here =
        [model.pusher_friction().value.ln(), model.characteristic_length(&steps[0].input).ln()];
    [0, 1].map(|k| {
        let moved = |size: f64| {
            let mut there = here;
            there[k] += size;
            outputs(&at(there[0], there[1]), steps)
        };
        moved(0.02).iter().zip(moved(-0.02)).map(|(high, low)| (high - low) / 0.04).collect()
    })
}

/// Over the outputs' variances.
fn product(one: &[Vector3<f64>], other: &[Vector3<f64>], steps: &[StepObservation]) -> f64 {
    let n = steps.len() as f64;
    let mean = steps.iter().map(|step| step.outputs).sum::<Vector3<f64>>() / n;
    let square = |step: &StepObservation| (step.outputs - mean).map(|x| x * x);
    let variance = steps.iter().map(square).sum::<Vector3<f64>>() / n;
    one.iter().zip(other).map(|(a, b)| a.component_mul(b).component_div(&variance).sum()).sum()
}

fn unexplained(parts: &[Parts]) -> Vec<Vector3<f64>> {
    parts.iter().map(|parts| parts.unexplained).collect()
}

/// The largest cosine of the learnt part with a slope of the physics, over the training steps.
fn largest_cosine(hybrid: &Hybrid, steps: &[StepObservation]) -> f64 {
    let left = unexplained(&hybrid.parts(&inputs(steps)).unwrap());
    let norm = |values: &[Vector3<f64>]| product(values, values, steps).sqrt();
    let cosine = |slope: &Vec<Vector3<f64>>| {
        (product(slope, &left, steps) / (norm(slope) * norm(&left))).abs()
    };
    jacobian(hybrid.analytical(), steps).iter().map(cosine).fold(0.0, f64::max)
}

#[test]
fn what_is_learnt_is_orthogonal_to_the_slopes_of_the_physics() {
    let steps = steps(80, 1.0);
    for process in ProcessKind::ALL {
        let training = Training { n_pseudo_inputs: 20, ..Training::with(process) };
        let (hybrid, report) = Hybrid::train(&nominal(), None, &steps, &training).unwrap();
        assert_eq!(hybrid.orthogonal_discrepancy().parameters.len(), 2);
        assert!(report.kept.is_empty());
        let cosine = largest_cosine(&hybrid, &steps);
        assert!(cosine < 1e-9, "{process:?}: {cosine}");
    }
    // Without the projection it is not.
    let Base::Analytical(base) = nominal().base else { panic!("analytical") };
    let fitted = base.fit(&steps).unwrap().model;
    let (plain, _) = Hybrid::learn(fitted, &steps, &learn_options()).unwrap();
    let cosine = largest_cosine(&plain, &steps);
    assert!(cosine > 1e-4, "{cosine}");
}

#[test]
fn what_the_physics_can_explain_goes_to_the_physics() {
    let before = steps(80, 1.0);
    let train = |steps: &[StepObservation], process| {
        Hybrid::train(&nominal(), None, steps, &Training::with(process)).unwrap().0
    };
    for process in [ProcessKind::Gp, ProcessKind::Rff] {
        let old = train(&before, process);
        let change: Vec<_> = {
            let [by_friction, by_length] = jacobian(old.analytical(), &before);
            by_friction.iter().zip(&by_length).map(|(a, b)| 0.04 * a - 0.03 * b).collect()
        };
        let mut after = before.clone();
        after.iter_mut().zip(&change).for_each(|(step, change)| step.outputs += change);
        let new = train(&after, process);
        let parts = |model: &Hybrid| model.parts(&inputs(&before)).unwrap();
        let (old_parts, new_parts) = (parts(&old), parts(&new));
        let difference = |pick: fn(&Parts) -> Vector3<f64>| -> Vec<Vector3<f64>> {
            new_parts.iter().zip(&old_parts).map(|(new, old)| pick(new) - pick(old)).collect()
        };
        let norm = |values: &[Vector3<f64>]| product(values, values, &before).sqrt();
        let physics = difference(|parts| parts.physics);
        let missed: Vec<_> = physics.iter().zip(&change).map(|(a, b)| a - b).collect();
        // What is left is the curvature of the physics, and its kinks.
        assert!(norm(&missed) < 0.1 * norm(&change), "{} of {}", norm(&missed), norm(&change));
        let learnt = norm(&difference(|parts| parts.unexplained));
        assert!(learnt < 0.1 * norm(&change), "{process:?}: {learnt} of {}", norm(&change));
        let friction = |model: &Hybrid| model.analytical().pusher_friction().value.ln();
        assert!((friction(&new) - friction(&old) - 0.04).abs() < 4e-3);
    }
}

#[test]
fn on_pushes_of_the_physics_alone_next_to_nothing_is_unexplained() {
    let share = |missing: f64, process| {
        let training = Training { n_pseudo_inputs: 20, ..Training::with(process) };
        let (hybrid, _) = Hybrid::train(&nominal(), None, &steps(150, missing), &training).unwrap();
        hybrid.orthogonal_discrepancy().unexplained
    };
    for process in ProcessKind::ALL {
        let nothing = share(0.0, process);
        assert!(nothing.all < 2e-3, "{process:?}: {nothing:?}");
        let something = share(1.0, process);
        assert!(something.all > 5.0 * nothing.all.max(2e-3), "{process:?}: {something:?}");
    }
}

#[test]
fn parts_sum_to_the_prediction_and_their_shares_are_those_of_the_kind() {
    let steps = steps(40, 1.0);
    let Base::Analytical(nominal) = nominal().base else { panic!("analytical") };
    for kind in model_kinds() {
        let model = (kind.train)(&nominal, &steps).unwrap();
        let found = model.predict(&inputs(&steps), Noise::Excluded).unwrap();
        let parts = model.parts(&inputs(&steps)).unwrap();
        for (found, Parts { physics, unexplained, unexplained_share }) in found.iter().zip(&parts) {
            assert!((physics + unexplained - found.mean).norm() < 1e-12);
            match kind.id {
                "analytical" => assert_eq!(*unexplained_share, 0.0),
                "hybrid" => assert!((0.0..1.0).contains(unexplained_share)),
                _ => assert_eq!((*unexplained_share, *physics), (1.0, Vector3::zeros())),
            }
        }
    }
}

#[test]
fn physics_that_the_steps_do_not_determine_are_kept() {
    let sticking: Vec<_> =
        steps(400, 1.0).into_iter().filter(|step| step.input.beta().abs() < 0.1).collect();
    let base = Analytical::nominal(0.8).unwrap().describe().unwrap();
    let (hybrid, report) = Hybrid::train(&base, None, &sticking, &Training::default()).unwrap();
    assert_eq!(report.kept, ["pusher-friction"]);
    assert_eq!(hybrid.analytical().pusher_friction().value, 0.8);
    assert_eq!(hybrid.orthogonal_discrepancy().parameters, ["characteristic-length"]);
    let few = Hybrid::train(&base, None, &sticking[..3], &Training::default());
    assert!(matches!(few, Err(ModelError::TooFewSteps { needed: 4, actual: 3, .. })));
    let gp = Description { base: Base::Process(ProcessKind::Gp), ..base };
    let error = Hybrid::train(&gp, None, &sticking, &Training::default()).unwrap_err();
    assert!(matches!(error, ModelError::NoPhysics { kind: "gp" }));
}

/// Steps with everything that effects act on, by the truth with its center of friction moved.
fn whole_steps(n: usize, offset: f64) -> Vec<StepObservation> {
    let shape = Arc::new(Shape::square(0.09).unwrap());
    let object = Arc::new(Object::uniform(shape.clone(), 0.8).unwrap());
    let base = Description { base: Base::Analytical(truth()), ..with_offset(offset) };
    let model = ChannelModel::new(&base, TABLE, &[]).unwrap();
    let step = |k: usize| {
        let bare = input(&shape, k % 4, k);
        let pose_wb = Pose::new(0.1, 0.2, 6.0 * spread(k, 0.33));
        let start_w = pose_wb.transform_point(&bare.start_b());
        let end_w = start_w + 0.004 * pose_wb.rotate(&bare.direction_b());
        let whole = effects::StepInput {
            object: object.clone(),
            pusher_radius: 0.00475,
            pose_wb,
            twist_wb: Twist::default(),
            track: Track::accelerated(start_w, end_w, Vector2::zeros(), 0.2),
            touching: true,
            since_contact: 0.0,
            run_up: None,
            progress: 0.0,
            session: 0,
        };
        let found = model.predict([&whole]).unwrap()[0];
        let input = StepInput::of(whole, shape.clone()).unwrap();
        let noise = SD.map_with_location(|output, _, sd| sd * unit_noise(k, output));
        let outputs = Vector3::new(found.dx, found.dy, found.dtheta);
        StepObservation { outputs: outputs + discrepancy(&input) + noise, input }
    };
    (0..n).map(step).collect()
}

/// The nominal model that knows of the center's offset, with another size.
fn with_offset(dx: f64) -> Description {
    let exact = |value| Estimate::exact(value, "test");
    let parameters = [("dx".to_owned(), exact(dx)), ("dy".to_owned(), exact(0.0))].into();
    let effect = ModelEffect::new("friction-center-offset", parameters);
    Description { effects: vec![effect], ..nominal() }
}

#[test]
fn effects_are_fitted_with_the_physics_and_come_back_from_the_file() {
    let steps = whole_steps(120, 0.004);
    let setup = || Some(Setup { support: TABLE, own: Vec::new() });
    let training = Training::with(ProcessKind::Rff);
    let base = with_offset(0.001);
    let (hybrid, report) = Hybrid::train(&base, setup(), &steps, &training).unwrap();
    assert!(report.kept.is_empty());
    assert_eq!(hybrid.orthogonal_discrepancy().parameters.len(), 4);
    let dx = &hybrid.effects()[0].parameters["dx"];
    assert!((dx.value - 0.004).abs() < 3.0 * dx.se && dx.se < 5e-4, "{dx:?}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.toml");
    let file = ModelFile::new("x", hybrid.describe().unwrap());
    file.write(&path).unwrap();
    let back = ModelFile::read(&path).unwrap();
    assert_eq!(back, file);
    let test = inputs(&steps);
    let built = back.description.build_in(TABLE, &[]).unwrap();
    let expected = hybrid.predict(&test, Noise::Included).unwrap();
    assert_eq!(built.predict(&test, Noise::Included).unwrap(), expected);
    // Without a set-up, or about bare steps, effects have nothing to act on.
    let error = back.description.build().unwrap_err();
    assert!(matches!(error, ModelError::EffectsNeedMore { .. }));
    let error = built.predict(&inputs(&self::steps(2, 0.0)), Noise::Included).unwrap_err();
    assert!(matches!(error, ModelError::EffectsNeedMore { .. }));
    // Physics without a parameter that was fitted are not those of the weights.
    let bare = Description { effects: Vec::new(), ..back.description };
    let error = bare.build().unwrap().predict(&test, Noise::Included).unwrap_err();
    assert!(matches!(error, ModelError::OtherPhysics { .. }), "{error}");
}

#[test]
fn speed_and_normal_are_inputs_where_they_are_asked_for() {
    let shape = Arc::new(Shape::rectangle(0.09, 0.06).unwrap());
    // The motion is another one on every second edge, and falls with the speed.
    let step = |k: usize| {
        let duration = 0.1 + 0.2 * spread(k, 0.41);
        let input = input(&shape, k % 4, k).lasting(duration).unwrap();
        let size =
            if input.edge().is_multiple_of(2) { 1.0 } else { 0.5 } - 10.0 * input.speed().unwrap();
        let noise = Vector3::from_fn(|output, _| 0.02 * unit_noise(k, output));
        StepObservation { outputs: 0.004 * (Vector3::new(1.0, 0.5, 8.0) * size + noise), input }
    };
    let steps: Vec<_> = (0..240).map(step).collect();
    let (train, test) = steps.split_at(160);
    let error = |speed: bool, normal: bool| {
        let features = StepFeatures { contact: false, speed, normal };
        let training = Training { features, ..Training::default() };
        let (model, _) = GpPushModel::train(train, &training).unwrap();
        let found = model.predict(&inputs(test), Noise::Excluded).unwrap();
        let square = |k: usize| (found[k].mean - test[k].outputs).norm_squared();
        (0..test.len()).map(square).sum::<f64>().sqrt()
    };
    let (neither, speed, normal, both) =
        (error(false, false), error(true, false), error(false, true), error(true, true));
    assert!(both < 0.3 * speed.min(normal) && speed.max(normal) < neither);
    let features = StepFeatures { speed: true, ..StepFeatures::default() };
    let bare = self::steps(20, 0.0);
    let untimed = GpPushModel::train(&bare, &Training { features, ..Training::default() });
    assert!(matches!(untimed, Err(ModelError::NoSpeed)));
    let (model, _) = GpPushModel::learn(&bare, &learn_options()).unwrap();
    let other = model.predict(&inputs(test), Noise::Excluded).unwrap_err();
    assert!(matches!(other, ModelError::UnknownOutline { n_known: 1 }));
}

#[test]
fn inputs_that_never_change_are_refused() {
    let mut steps = steps(60, 1.0);
    steps.iter_mut().for_each(|step| step.input = step.input.clone().lasting(0.2).unwrap());
    for (features, expected) in [
        (StepFeatures { speed: true, ..StepFeatures::default() }, "speed_m_s"),
        (StepFeatures { normal: true, ..StepFeatures::default() }, "normal_x"),
    ] {
        let model = GpPushModel::train(&steps, &Training { features, ..Training::default() });
        let Err(ModelError::ConstantInput { input, n_steps: 60 }) = model else { panic!() };
        assert_eq!(input, expected);
    }
}
