//! Models with effects: their files, their predictions, and the rows that they are asked about.

use dataset::{
    ContactForce, Flags, ObjectChoice, ObjectSpec, Phase, Provenance, StepForce, StepRow,
    SupportSpec, Table,
};
use effects::{Effect, EffectInfo, Object, PushPhysics, Rig, Setting, Spread, Surface, Track, all};
use models::{
    Analytical, Base, ChannelModel, CharacteristicLength, Description, Estimate, ExclusionReason,
    ModelEffect, ModelError, ModelFile, ProcessKind, PushModel, StepInput, StepSelection,
    SurfaceKind,
};
use nalgebra::{Matrix3, Vector2};
use planar::{Pose, Shape, Twist};
use std::f64::consts::TAU;
use std::sync::Arc;

const RADIUS: f64 = 0.00475;
/// What sliding of one push in thousands moves a mean, in m.
const RARE: f64 = 2e-6;
const TABLE: SupportSpec = SupportSpec { friction: 0.25, gravity: 9.81 };

const BASE: &str = r#"schema = "pushlab.model/1"
name = "thesis + table anisotropy"

[base]
kind = "analytical"
limit_surface = "ellipsoid"
pressure = "uniform"
[base.pusher_friction]
value = 0.25
source = "manifest"
"#;

const ANISOTROPY: &str = r#"
[[effects]]
id = "table-anisotropy"
[effects.parameters.ratio]
value = 1.34
se = 0.015
unit = "1"
source = "fit"
[effects.parameters.direction]
value = 0.59
unit = "rad"
"#;

fn read(text: &str) -> Result<ModelFile, ModelError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.toml");
    std::fs::write(&path, text).unwrap();
    ModelFile::read(&path)
}

fn nominal() -> Description {
    Analytical::nominal(0.25).unwrap().describe().unwrap()
}

fn with(effects: Vec<ModelEffect>) -> Description {
    Description { effects, ..nominal() }
}

fn typical(about: &EffectInfo) -> Vec<f64> {
    about.typical(&Rig::new(Surface::Ellipsoid, 0.25, 0.25).unwrap())
}

/// Steps about a square and a triangle, whose centroid is not its origin: 4 mm in 0.2 s.
fn asked() -> Vec<(StepInput, effects::StepInput)> {
    let triangle = planar::mit_object("tri1").unwrap().shape;
    let mut steps = Vec::new();
    for shape in [Shape::square(0.09).unwrap(), triangle] {
        let shape = Arc::new(shape);
        let object = Arc::new(Object::uniform(shape.clone(), 0.84).unwrap());
        for k in 0..18_u8 {
            let (edge, p) = (usize::from(k) % 3, 0.1 + 0.8 * f64::from(k) / 17.0);
            let beta = 1.2 * (f64::from(k * 7 % 18) / 17.0 - 0.5);
            let step = StepInput::on_edge(shape.clone(), RADIUS, edge, p, beta, 0.004).unwrap();
            let pose_wb = Pose::new(0.1, -0.2, 0.3 * f64::from(k));
            let start = pose_wb.transform_point(&step.start_b());
            let end = start + 0.004 * pose_wb.rotate(&step.direction_b());
            let channels = effects::StepInput {
                object: object.clone(),
                pusher_radius: RADIUS,
                pose_wb,
                twist_wb: Twist::default(),
                track: Track::straight(start, end, 0.2),
                touching: true,
                since_contact: 1.0,
                run_up: None,
                progress: 0.5,
                session: 0,
            };
            steps.push((step, channels));
        }
    }
    steps
}

/// Largest difference of the displacement in m and of the turn in rad.
fn difference(model: &Analytical) -> (f64, f64) {
    let steps = asked();
    let physics = ChannelModel::new(&model.describe().unwrap(), TABLE, &[]).unwrap();
    let channels = physics.predict(steps.iter().map(|(_, step)| step)).unwrap();
    let mut worst = (0.0_f64, 0.0_f64);
    for ((step, _), channels) in steps.iter().zip(&channels) {
        let outputs = step.outputs(&model.motion(step).unwrap());
        let moved = Vector2::new(channels.dx - outputs.x, channels.dy - outputs.y).norm();
        worst = (worst.0.max(moved), worst.1.max((channels.dtheta - outputs.z).abs()));
        assert!(channels.force_normal > 0.0 && channels.gap_end.abs() < 1e-12);
    }
    worst
}

/// `effects` states 4 µm over 4 mm for its midpoint rule, 1 µm more for its table of the patch; at
/// half the object's size that is 0.1 mrad.
#[test]
fn without_effects_the_motion_is_the_analytical_models() {
    let nominal = Analytical::nominal(0.25).unwrap();
    let length = CharacteristicLength::Given(Estimate::exact(0.033, "test"));
    let given = Analytical::new(Estimate::exact(0.2, "test"), length, Matrix3::zeros()).unwrap();
    for (model, limit) in [
        (nominal.clone(), 4e-6),
        (given, 4e-6),
        (nominal.clone().with_surface(SurfaceKind::UniformPatch).unwrap(), 5e-6),
        (nominal.clone().with_surface(SurfaceKind::Points { n_points: 49 }).unwrap(), 4e-6),
        (nominal.with_surface(SurfaceKind::named("quartic").unwrap()).unwrap(), 4e-6),
    ] {
        let (moved, turned) = difference(&model);
        assert!(moved < limit && turned < limit / 0.04, "{model:?}: {moved} m, {turned} rad");
    }
}

#[test]
fn with_effects_every_channel_is_that_of_the_physics() {
    let (steps, rig) = (asked(), Rig::new(Surface::Ellipsoid, 0.25, 0.25).unwrap());
    for effect in all() {
        let about = effect.info();
        let values = typical(about);
        let setting = Setting::new(about, &values);
        let model = ChannelModel::new(&with(vec![setting.into()]), TABLE, &[]).unwrap();
        let predicted = model.predict(steps.iter().map(|(_, step)| step)).unwrap();
        let physics = PushPhysics::new(rig.clone()).with(effect, &values).unwrap();
        for ((_, step), channels) in steps.iter().zip(&predicted) {
            assert_eq!(*channels, physics.predict(step).unwrap(), "{}", about.id);
        }
    }
}

#[test]
fn the_tables_friction_and_gravity_are_in_the_force() {
    let (_, step) = asked().remove(0);
    let force = |support: SupportSpec| {
        ChannelModel::new(&nominal(), support, &[]).unwrap().predict([&step]).unwrap()[0]
            .force_normal
    };
    let once = force(TABLE);
    assert!((force(SupportSpec { friction: 0.5, ..TABLE }) / once - 2.0).abs() < 1e-12);
    assert!((force(SupportSpec { gravity: 3.0 * 9.81, ..TABLE }) / once - 3.0).abs() < 1e-12);
}

#[test]
fn a_file_with_effects_comes_back_as_it_was() {
    let file = read(&format!("{BASE}{ANISOTROPY}")).unwrap();
    let effect = &file.description.effects[0];
    assert_eq!(effect.id, "table-anisotropy");
    let ratio = Estimate { value: 1.34, se: 0.015, source: "fit".into() };
    assert_eq!(effect.parameters["ratio"], ratio);
    assert_eq!(effect.parameters["direction"], Estimate::exact(0.59, ""));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.toml");
    let of = |effect: &Arc<dyn Effect>| {
        let mut effect = ModelEffect::from(Setting::new(effect.info(), &typical(effect.info())));
        for (k, known) in effect.parameters.values_mut().enumerate() {
            *known = Estimate {
                se: 0.1 / (3.0 + k as f64),
                source: "a \"fit\"".into(),
                ..known.clone()
            };
        }
        effect
    };
    let description = with(all().iter().map(of).collect());
    let written = ModelFile::new("all", description);
    written.write(&path).unwrap();
    assert_eq!(ModelFile::read(&path).unwrap(), written);
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains("[effects.parameters.direction]") && text.contains("unit = \"rad\""));
}

#[test]
fn points_that_bear_nothing_are_left_out_and_spreads_are_kept() {
    let points = "[[effects]]\nid = \"support-points\"\n[effects.parameters]\n";
    let three = "x1 = { value = 0.03 }\ny1 = { value = 0.0 }\nshare1 = { value = 1.0 }\n";
    let file = read(&format!("{BASE}{points}{three}")).unwrap();
    assert_eq!(file.description.effects[0].parameters.len(), 18);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.toml");
    let mut file = ModelFile { split: None, ..file };
    let friction = Setting::new(effects::by_id("pusher-friction").unwrap().info(), &[0.25]);
    let mut friction = ModelEffect::from(friction);
    friction.per_push.insert("friction".into(), Spread::RelativeSd(0.3));
    friction.per_place.insert("friction".into(), Spread::RelativeSd(0.4));
    friction.per_session.insert("friction".into(), Spread::RelativeSd(0.2));
    file.description.effects.push(friction);
    file.write(&path).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(!text.contains("share2") && text.contains("relative_sd = 0.3"), "{text}");
    assert!(text.contains("friction.per_place]\nrelative_sd = 0.4"), "{text}");
    assert!(text.contains("friction.per_session]\nrelative_sd = 0.2"), "{text}");
    assert_eq!(ModelFile::read(&path).unwrap(), file);
    // A place without a share, and a share without a place.
    for lacking in ["share1", "y1"] {
        let lines: Vec<&str> = three.lines().filter(|line| !line.starts_with(lacking)).collect();
        let error = read(&format!("{BASE}{points}{}", lines.join("\n"))).unwrap_err().to_string();
        assert!(error.contains(&format!("parameters.{lacking}")), "{error}");
    }
    let spread = |words: &str| {
        let text = format!(
            "{BASE}[[effects]]\nid = \"pusher-friction\"\n\
             parameters = {{ friction = {{ value = 0.25, {words} }} }}\n"
        );
        read(&text)
    };
    for (words, part) in
        [("{ relative_sd = 2.5 }", "2.5"), ("{ sd = -0.1 }", "-0.1"), ("{ width = 0.1 }", "width")]
    {
        for key in ["per_push", "per_session", "per_place"] {
            assert!(spread(&format!("{key} = {{ sd = 0.05 }}")).is_ok());
            let error = spread(&format!("{key} = {words}")).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        }
    }
    let one = "per_push = { sd = 0.05 }, per_place = ";
    assert!(spread(&format!("{one}{{ sd = 0.1 }}")).is_ok());
    let error = spread(&format!("{one}{{ relative_sd = 0.1 }}")).unwrap_err().to_string();
    assert!(
        error.contains("`friction` of pusher-friction") && error.contains("two units"),
        "{error}"
    );
    let one = "per_push = { sd = 0.05 }, per_session = ";
    assert!(spread(&format!("{one}{{ sd = 0.1 }}")).is_ok());
    let error = spread(&format!("{one}{{ relative_sd = 0.1 }}")).unwrap_err().to_string();
    assert!(error.contains("friction.per_session"), "{error}");
}

#[test]
fn a_push_of_an_unknown_session_differs_by_both_spreads() {
    let (steps, about) = (asked(), effects::by_id("pusher-friction").unwrap().info());
    let over = |per_push: f64, per_session: f64| {
        let mut effect = ModelEffect::from(Setting::new(about, &[0.25]));
        effect.per_push.insert("friction".into(), Spread::RelativeSd(per_push));
        effect.per_session.insert("friction".into(), Spread::RelativeSd(per_session));
        let model = ChannelModel::new(&with(vec![effect]), TABLE, &[]).unwrap();
        model.motion_over_pushes(steps.iter().map(|(_, step)| step)).unwrap()
    };
    let (push, both, session) = (over(0.5, 0.0), over(0.3, 0.4), over(0.0, 0.5));
    for ((push, both), session) in push.iter().zip(&both).zip(&session) {
        assert!((push.0 - both.0).norm() <= 1e-12 * push.0.norm());
        assert!((push.0 - session.0).norm() <= 1e-12 * push.0.norm());
        assert!((push.1 - both.1).norm() <= 1e-9 * push.1.norm() && push.1.norm() > 0.0);
    }
}

#[test]
fn places_move_the_expected_motion_and_only_pushes_have_a_covariance() {
    let (steps, about) = (asked(), effects::by_id("pusher-friction").unwrap().info());
    let over = |per_push: f64, per_place: f64| {
        let mut effect = ModelEffect::from(Setting::new(about, &[0.25]));
        effect.per_push.insert("friction".into(), Spread::RelativeSd(per_push));
        effect.per_place.insert("friction".into(), Spread::RelativeSd(per_place));
        let model = ChannelModel::new(&with(vec![effect]), TABLE, &[]).unwrap();
        model.motion_over_pushes(steps.iter().map(|(_, step)| step)).unwrap()
    };
    let (whole, both, places) = (over(0.5, 0.0), over(0.3, 0.4), over(0.0, 0.5));
    let mut n_moved = 0;
    for ((whole, both), places) in whole.iter().zip(&both).zip(&places) {
        assert!((whole.0 - both.0).amax() < 1e-12 && (whole.0 - places.0).amax() < 1e-12);
        assert!((0.36 * whole.1 - both.1).amax() <= 1e-9 * whole.1.amax());
        assert_eq!(places.1, Matrix3::zeros());
        n_moved += usize::from(whole.1.amax() > 0.0);
    }
    assert!(n_moved > 2, "{n_moved}");
}

#[test]
fn a_motion_over_pushes_is_that_of_many_drawn_ones() {
    let (steps, rig) = (asked(), Rig::new(Surface::Ellipsoid, 0.25, 0.25).unwrap());
    let about = effects::by_id("pusher-friction").unwrap().info();
    let mut effect = ModelEffect::from(Setting::new(about, &[0.25]));
    effect.per_push.insert("friction".into(), Spread::RelativeSd(0.3));
    let model = ChannelModel::new(&with(vec![effect]), TABLE, &[]).unwrap();
    let found = model.motion_over_pushes(steps.iter().map(|(_, step)| step)).unwrap();
    let expected = model.predict(steps.iter().map(|(_, step)| step)).unwrap();
    // A fine midpoint rule over the normal number.
    let places: Vec<f64> = (0..4000).map(|k| -6.0 + 12.0 * (f64::from(k) + 0.5) / 4000.0).collect();
    let weight = |z: f64| (-0.5 * z * z).exp() / TAU.sqrt() * 12.0 / 4000.0;
    let mut n_seen = 0;
    for (((_, step), (mean, covariance)), channels) in steps.iter().zip(&found).zip(&expected) {
        assert_eq!([mean.x, mean.y, mean.z], [channels.dx, channels.dy, channels.dtheta]);
        let (mut sum, mut square, mut whole) = (0.0, 0.0, 0.0);
        for z in places.iter().step_by(20) {
            let friction = 0.25 * (0.3 * z).exp();
            let physics = PushPhysics::new(rig.clone());
            let physics = physics.with(effects::PusherFriction, &[friction]).unwrap();
            let dy = physics.predict(step).unwrap().dy;
            sum += weight(*z) * dy;
            square += weight(*z) * dy * dy;
            whole += weight(*z);
        }
        let (exact, variance) = (sum / whole, square / whole - (sum / whole).powi(2));
        // Five places see a kink of sticking and sliding no better, and what is rare not at all.
        let sd = variance.max(0.0).sqrt();
        assert!((mean.y - exact).abs() < 0.25 * sd + RARE, "{} {exact} {sd}", mean.y);
        let found = covariance.m22.sqrt();
        assert!((found - sd).abs() < 0.35 * sd + RARE, "{found} {sd}");
        n_seen += usize::from(sd > 10.0 * RARE);
    }
    assert!(n_seen > 2, "{n_seen}");
}

#[test]
fn every_impossible_effect_names_its_line_key_and_what_is_allowed() {
    let replaced = |from: &str, to: &str| format!("{BASE}{}", ANISOTROPY.replace(from, to));
    let length = "[base.characteristic_length]\nvalue = 0.03\n";
    let base = BASE.replace("pressure = \"uniform\"\n", "");
    let radius =
        "[[effects]]\nid = \"pressure-radius\"\nparameters = { ratio = { value = 0.9 } }\n";
    for (text, line, key, part) in [
        (replaced("table-anisotropy", "table-anisotrpy"), 13, "effects.id", "table-anisotropy,"),
        (replaced("1.34", "9.0"), 14, "effects.parameters.ratio.value", "to"),
        (replaced("1.34", "nan"), 14, "effects.parameters.ratio.value", "got NaN"),
        (replaced("0.015", "-1.0"), 14, "effects.parameters.ratio.se", "-1"),
        (replaced("\"rad\"", "\"deg\""), 19, "effects.parameters.direction.unit", "\"rad\""),
        (replaced(".ratio", ".raito"), 12, "effects.parameters.ratio", "ratio (from"),
        (
            format!("{BASE}{ANISOTROPY}[effects.parameters.phase]\nvalue = 1\n"),
            22,
            "effects.parameters.phase",
            "direction (from",
        ),
        (replaced("se = 0.015", "sd = 0.015"), 16, "sd", "unknown field"),
        (format!("{BASE}{ANISOTROPY}{ANISOTROPY}"), 23, "effects", "second time"),
        (
            replaced(
                "id = \"table-anisotropy\"",
                "id = \"inertia\"\n[effects.parameters.kappa]\nvalue = 0.5",
            )
            .split("[effects.parameters.ratio]")
            .next()
            .unwrap()
            .to_owned(),
            12,
            "effects",
            "switch",
        ),
        (format!("{base}{length}{radius}"), 12, "effects", "say the same"),
    ] {
        let error = read(&text).unwrap_err();
        let ModelError::Invalid { line: found, key: named, problem, .. } = &error else {
            panic!("{error}")
        };
        assert_eq!((*found, named.as_str()), (line, key), "{error}");
        assert!(problem.contains(part), "{error}");
    }
}

#[test]
fn effects_need_mechanics_and_a_set_up() {
    let effect: ModelEffect = Setting::new(all()[0].info(), &typical(all()[0].info())).into();
    let error = with(vec![effect.clone()]).build().unwrap_err();
    assert!(matches!(&error, ModelError::EffectsNeedMore { effects } if *effects == effect.id));
    let gp = Description { base: Base::Process(ProcessKind::Gp), ..nominal() };
    let error = ChannelModel::new(&gp, TABLE, &[]).unwrap_err();
    assert!(matches!(error, ModelError::MotionAlone { kind: "gp" }));
    let smooth = SupportSpec { friction: 0.0, ..TABLE };
    let error = ChannelModel::new(&nominal(), smooth, &[]).unwrap_err();
    assert!(matches!(error, ModelError::Effects(_)), "{error}");
    let twice = with(vec![effect.clone(), effect]);
    assert!(matches!(ChannelModel::new(&twice, TABLE, &[]), Err(ModelError::Effects(_))));
}

fn row(recording: &str, t: f64) -> StepRow {
    let force = ContactForce { normal: 2.0, tangential: -0.3 };
    StepRow {
        recording: Arc::from(recording),
        session: Some(Arc::from(if t < 100.0 { "monday" } else { "tuesday" })),
        t,
        dt: 0.2,
        shape: Arc::from("rect1"),
        edge: 1,
        p: 0.5,
        speed: 0.02,
        object_pose: Pose::new(0.1, 0.2, 0.0),
        object_twist: Twist::new(0.02, 0.001, 0.1),
        pusher_start: Vector2::new(0.1 + 0.045 + RADIUS, 0.2),
        pusher_end: Vector2::new(0.1 + 0.041 + RADIUS, 0.2),
        pusher_velocity: Vector2::new(-0.02, 0.0),
        pusher_acceleration: Vector2::new(0.03, 0.01),
        dx: 0.004,
        dy: 1e-4,
        dtheta: -0.01,
        force: Some(StepForce { mean: force, ..StepForce::default() }),
        gap_start: 1e-5,
        gap_end: -2e-5,
        since_contact: 0.4,
        ..StepRow::default()
    }
}

fn converted(rows: Vec<StepRow>) -> models::ChannelSteps {
    let objects = ObjectChoice::Fixed(Box::new(ObjectSpec::mit("rect1").unwrap()));
    let table = Table { rows, provenance: Provenance::default() };
    StepSelection::default().channel_steps(&table, &objects, RADIUS).unwrap()
}

#[test]
fn every_number_of_a_step_is_its_rows_and_its_manifests() {
    let row = row("a", 50.0);
    let found = converted(vec![row.clone()]);
    let step = &found.steps[0];
    let spec = ObjectSpec::mit("rect1").unwrap();
    assert_eq!(step.input.object.shape(), &spec.shape);
    assert_eq!(step.input.object.mass(), spec.mass);
    assert_eq!(step.input.object.moment_of_inertia(), spec.moment_of_inertia);
    assert_eq!(*step.input.object.center_of_mass(), spec.center_of_mass);
    assert_eq!((step.input.pose_wb, step.input.twist_wb), (row.object_pose, row.object_twist));
    assert_eq!((step.input.pusher_radius, step.input.since_contact), (RADIUS, 0.4));
    let track = &step.input.track;
    assert_eq!((track.start(), track.end()), (row.pusher_start, row.pusher_end));
    assert!((track.mean_velocity() - row.pusher_velocity).norm() < 1e-12);
    let change = track.at(0.2).1 - track.at(0.0).1;
    assert!((change - 0.2 * row.pusher_acceleration).norm() < 1e-15);
    assert!(step.input.touching);
    let values = [0.004, 1e-4, -0.01, 2.0, -0.3, 1e-5, -2e-5];
    assert_eq!(step.observed, values.map(Some));
}

#[test]
fn pushes_are_placed_by_time_and_sessions_numbered() {
    let rows = vec![row("c", 200.0), row("a", 50.0), row("a", 50.2), row("b", 60.0)];
    let found = converted(rows);
    let of = |f: fn(&effects::StepInput) -> f64| -> Vec<f64> {
        found.steps.iter().map(|step| f(&step.input)).collect()
    };
    assert_eq!(of(|input| input.progress), [1.0, 0.0, 0.0, 0.5]);
    assert_eq!(of(|input| f64::from(input.session)), [0.0, 1.0, 1.0, 1.0]);
}

#[test]
fn recordings_without_a_common_clock_keep_the_order_of_the_table() {
    let found = converted(vec![row("a", 0.3), row("b", 0.25), row("c", 0.2)]);
    let places: Vec<_> = found.steps.iter().map(|step| step.input.progress).collect();
    assert_eq!(places, [0.0, 0.5, 1.0]);
}

#[test]
fn an_unknown_force_is_missing_and_unusable_rows_are_counted() {
    let flagged = |flags: Flags| StepRow { flags, ..row("a", 1.0) };
    let rows = vec![
        flagged(Flags::UNTARED),
        StepRow { force: None, ..row("a", 2.0) },
        flagged(Flags::CONTACT_LOST),
        StepRow { phase: Phase::After, ..row("a", 3.0) },
        flagged(Flags::SHORT),
    ];
    let found = converted(rows);
    assert_eq!(found.rows, [0, 1]);
    for step in &found.steps {
        assert_eq!(step.observed[3..5], [None, None]);
        assert_eq!(step.observed[0], Some(0.004));
    }
    assert_eq!(found.excluded.to_string(), "1 after contact, 1 contact_lost, 1 short");
    assert_eq!(found.excluded.rows[&ExclusionReason::AfterContact], [3]);
    assert_eq!(found.excluded.n_rows(), 3);
}

#[test]
fn a_row_that_is_no_step_is_named() {
    let table = |row: StepRow| Table { rows: vec![row], provenance: Provenance::default() };
    let objects = ObjectChoice::Fixed(Box::new(ObjectSpec::mit("rect1").unwrap()));
    let refused = |row: StepRow| {
        StepSelection::default().channel_steps(&table(row), &objects, RADIUS).unwrap_err()
    };
    let error = refused(StepRow { gap_end: f64::NAN, ..row("a", 1.0) });
    let ModelError::Row { row: 0, recording, source } = error else { panic!("{error}") };
    assert_eq!(recording, "a");
    assert!(matches!(*source, ModelError::InvalidValue { name: "gap at the end", .. }));
    let error = refused(StepRow { shape: Arc::from("hex"), ..row("a", 1.0) });
    assert!(matches!(error, ModelError::Row { .. }));
}
