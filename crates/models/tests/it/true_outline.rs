//! Effects that change what touches where, in everything that asks whether pusher and object touch.

use std::f64::consts::PI;
use std::sync::Arc;

use dataset::SupportSpec;
use effects::{Object, Setting, TrueOutline, by_id};
use filter::Unscented;
use models::{
    Analytical, CharacteristicLength, Description, Estimate, Matching, ModelEffect, Moment,
    PushModel, PushPath, Pushed, RollOut, RollOutSettings, StepErrors,
};
use nalgebra::{Matrix3, Vector2, Vector3};
use planar::{Ellipse, Pose, Shape, mit_object};

const TABLE: SupportSpec = SupportSpec { friction: 0.25, gravity: 9.81 };
const RADIUS: f64 = 0.005;

/// A model that scatters by 2 % of the way; pusher-friction, as it is nominally, makes it a model with
/// effects in any case.
fn model(effects: &[(&str, &[f64])]) -> Box<dyn PushModel> {
    let scatter = Matrix3::from_diagonal(&Vector3::new(4e-4, 4e-4, 0.44));
    let friction = Estimate::exact(0.25, "");
    let base = Analytical::new(friction, CharacteristicLength::UniformPressure, scatter).unwrap();
    let effect = |(id, values): &(&str, &[f64])| -> ModelEffect {
        Setting::new(by_id(id).unwrap().info(), values).into()
    };
    let plain: (&str, &[f64]) = ("pusher-friction", &[0.25]);
    let effects = std::iter::once(&plain).chain(effects).map(effect).collect();
    let description = Description { effects, ..base.describe().unwrap() };
    description.build_in(TABLE, &[]).unwrap()
}

fn pushed(shape: Shape, pusher_radius: f64) -> Pushed {
    let shape = Arc::new(shape);
    let object = Some(Arc::new(Object::uniform(shape.clone(), 0.84).unwrap()));
    Pushed { shape, pusher_radius, object }
}

/// A straight way of 30 mm from `gap` before the left side of the square or triangle.
fn path(pushed: &Pushed, radius: f64, y: f64, gap: f64) -> PushPath {
    let mut start = Vector2::new(-0.2, y);
    start.x += pushed.shape.contact(&start, radius).gap;
    for _ in 0..60 {
        start.x += pushed.shape.contact(&start, radius).gap;
    }
    start.x -= gap;
    PushPath::straight(start, start + Vector2::new(0.03, 0.012), 0.02).unwrap()
}

fn settings(touching: bool) -> RollOutSettings {
    RollOutSettings { n_particles: 60, touching, start_sd: [1e-4, 2e-3], ..Default::default() }
}

fn assert_same(one: &[Moment], other: &[Moment], case: &str) {
    for (a, b) in one.iter().zip(other) {
        assert_eq!(a.events, b.events, "{case} at {} s", a.time);
        let off = (a.pose_wb.mean - b.pose_wb.mean).amax();
        assert!(off < 1e-9, "{case} at {} s: {off}", a.time);
        let off = (a.pose_wb.covariance - b.pose_wb.covariance).amax();
        assert!(off < 1e-9, "{case} at {} s: {off}", a.time);
    }
}

#[test]
fn a_pusher_that_is_thicker_by_an_effect_pushes_as_one_that_is_stated_so() {
    let (plain, thicker) = (model(&[]), model(&[("pusher-radius", &[1e-3])]));
    for shape in [Shape::square(0.09).unwrap(), mit_object("tri1").unwrap().shape] {
        let stated = pushed(shape.clone(), RADIUS);
        let thin = pushed(shape, RADIUS - 1e-3);
        for (y, gap, touching) in
            [(0.012, 0.004, false), (0.012, 0.0, true), (0.043, 0.003, false), (-0.02, 5e-4, true)]
        {
            let path = path(&stated, RADIUS, y, gap);
            let settings = settings(touching);
            let run = |model: &dyn PushModel, pushed: &Pushed| {
                let roll_out = RollOut { model, pushed, settings: &settings };
                let mixtures = roll_out
                    .matched(&Pose::default(), &path, Matching::Points(&Unscented), 1)
                    .unwrap();
                let end = mixtures[mixtures.len() - 1].moments().unwrap();
                (roll_out.run(&Pose::default(), &path, |_, _| {}).unwrap(), end.mean().clone())
            };
            let (one, end) = run(plain.as_ref(), &stated);
            let (other, other_end) = run(thicker.as_ref(), &thin);
            let case = format!("y {y}, gap {gap}");
            assert!(one.iter().any(|moment| moment.events.pushed > 0), "{case}");
            assert_same(&one, &other, &case);
            assert!((end - other_end).amax() < 1e-9, "{case}");
        }
    }
}

#[test]
fn a_model_is_asked_for_its_own_outline() {
    let square = pushed(Shape::square(0.09).unwrap(), RADIUS);
    let outline = |effects: &[(&str, &[f64])]| -> TrueOutline {
        model(effects).true_outline(&square).unwrap()
    };
    let center = Vector2::new(-0.055, 0.01);
    let plain = outline(&[]);
    assert_eq!(plain.contact(&center), square.shape.contact(&center, RADIUS));
    let thick = outline(&[("pusher-radius", &[2e-3])]);
    assert!((thick.contact(&center).gap - 0.003).abs() < 1e-15);
    assert!((thick.pusher_radius() - 0.007).abs() < 1e-15);
    // Of a point and an outline that is 2 mm smaller on every side: at an edge, and about a corner.
    let smaller = |shape: Shape| {
        model(&[("pusher-radius", &[-4e-3])]).true_outline(&pushed(shape, 2e-3)).unwrap()
    };
    let (found, stated) = (smaller(Shape::square(0.09).unwrap()), Shape::square(0.086).unwrap());
    for center in [center, Vector2::new(-0.047, 0.046), Vector2::new(-0.0425, 0.02)] {
        let (found, stated) = (found.contact(&center), stated.contact(&center, 0.0));
        assert!((found.gap - stated.gap).abs() < 1e-15, "{found:?} {stated:?}");
        assert!((found.point - stated.point).norm() < 1e-15, "{found:?} {stated:?}");
    }
    assert_eq!(found.pusher_radius(), 0.0);
    let disc = smaller(Shape::Ellipse(Ellipse::new(0.045, 0.045).unwrap()));
    for gap in [0.003, -1e-3] {
        let found = disc.contact(&Vector2::new(0.0, -0.043 - gap));
        assert!((found.gap - gap).abs() < 1e-12, "{found:?}");
        assert!((found.point - Vector2::new(0.0, -0.043)).norm() < 1e-12, "{found:?}");
    }
    // The outline is 1 mm farther along x and 2 mm along y than the frame that is tracked.
    let moved = outline(&[("pose-offset", &[1e-3, 2e-3])]).contact(&center);
    assert!((moved.gap - 0.006).abs() < 1e-15 && (moved.point.x + 0.044).abs() < 1e-15);
    assert!(
        (moved.p - square.shape.contact(&(center - Vector2::new(1e-3, 2e-3)), 0.0).p).abs() < 1e-12
    );
    // A corner of 4 mm radius is (√2 − 1) · 4 mm behind the sharp one, along the diagonal.
    let diagonal = Vector2::new(-0.06, 0.06);
    let sharp = plain.contact(&diagonal);
    let round = outline(&[("edge-rounding", &[4e-3])]).contact(&diagonal);
    let behind = (2.0_f64.sqrt() - 1.0) * 4e-3;
    assert!((round.gap - sharp.gap - behind).abs() < 1e-15, "{round:?} {sharp:?}");
    assert!(((round.point - sharp.point).norm() - behind).abs() < 1e-15);
    // A tip that is 1 mm farther along x of the table than it is told: nearer, farther, or along the edge.
    let beside = outline(&[("robot-offset", &[1e-3, 0.0])]);
    for (angle, gap) in [(0.0, 0.004), (PI, 0.006), (0.5 * PI, 0.005)] {
        let pose = Pose::new(0.3, -0.2, angle);
        let told = beside.gap(&pose, &pose.transform_point(&center));
        assert!((told - gap).abs() < 1e-15, "{angle}: {told}");
    }
    let late = outline(&[("stream-latency", &[0.02])]);
    assert_eq!((late.latency(), late.contact(&center)), (0.02, plain.contact(&center)));
}

#[test]
fn a_point_that_is_measured_just_inside_of_the_outline_pushes_all_the_same() {
    let square = pushed(Shape::square(0.09).unwrap(), 0.0);
    let model = model(&[]);
    for overlap in [0.0, 1e-4, -1e-4] {
        let start = Vector2::new(-0.045 + overlap, 0.01);
        let path = PushPath::straight(start, start + Vector2::new(0.02, 0.0), 0.02).unwrap();
        let errors = StepErrors::None;
        let settings =
            RollOutSettings { n_particles: 1, errors, touching: true, ..Default::default() };
        let roll_out = RollOut { model: model.as_ref(), pushed: &square, settings: &settings };
        let moments = roll_out.run(&Pose::default(), &path, |_, _| {}).unwrap();
        let end = moments[moments.len() - 1].pose_wb.mean;
        assert!((0.015..0.02).contains(&end.x) && end.z < -0.05, "{overlap}: {end}");
        assert!(moments[1..].iter().all(|moment| moment.events.pushed == 1), "{overlap}");
    }
    let deep = Vector2::new(-0.04, 0.01);
    let path = PushPath::straight(deep, deep + Vector2::new(0.02, 0.0), 0.02).unwrap();
    let settings = RollOutSettings { touching: true, ..Default::default() };
    let roll_out = RollOut { model: model.as_ref(), pushed: &square, settings: &settings };
    let error = roll_out.run(&Pose::default(), &path, |_, _| {}).unwrap_err();
    assert!(matches!(error, models::ModelError::PusherInside { .. }), "{error}");
}
