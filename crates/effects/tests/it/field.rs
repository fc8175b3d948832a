//! A field of friction over the table, against answers found in another way.

use std::sync::Arc;

use effects::{
    Channels, Effect, FrictionCenterOffset, FrictionField, FrictionGradient, Object, PressureMap,
    PushPhysics, Rig, StepInput, SupportPoints, Surface, TableAnisotropy, Track,
};
use nalgebra::Vector2;
use planar::{Pose, Shape, Twist};

/// Effects with their values.
type Effects<'a> = &'a [(Arc<dyn Effect>, Vec<f64>)];

/// The field's values, with one of its waves.
fn values(sides: [f64; 4], wave: &str, amplitude: f64) -> Vec<f64> {
    let parameters = FrictionField.info().parameters;
    let is_wave = parameters.iter().map(|p| if p.name == wave { amplitude } else { 0.0 });
    sides.into_iter().chain(is_wave.skip(4)).collect()
}

/// Pushes of a square about a place of the table.
fn pushes(center: [f64; 2]) -> Vec<StepInput> {
    let object = Arc::new(Object::uniform(Arc::new(Shape::square(0.09).unwrap()), 0.8).unwrap());
    let push = |k: usize| {
        let (y, beta) = (0.016 * (k % 5) as f64 - 0.032, 0.5 * (k % 3) as f64 - 0.5);
        let pose_wb = Pose::new(center[0], center[1], 0.7 * k as f64);
        let start = Vector2::new(-0.05, y);
        let end = start + 4e-3 * Vector2::new(beta.cos(), beta.sin());
        let [start, end] = [start, end].map(|place| pose_wb.transform_point(&place));
        StepInput {
            object: object.clone(),
            pusher_radius: 0.005,
            pose_wb,
            twist_wb: Twist::default(),
            track: Track::straight(start, end, 0.2),
            touching: true,
            since_contact: 1.0,
            run_up: None,
            progress: 0.5,
            session: 0,
        }
    };
    (0..15).map(push).collect()
}

fn predict(physics: &PushPhysics, steps: &[StepInput]) -> Vec<[f64; 7]> {
    physics.predict_all(steps).unwrap().iter().map(Channels::to_array).collect()
}

/// An object that is small beside the field's waves slides as before, under a load that is in proportion.
#[test]
fn an_even_field_scales_the_force_of_every_support_and_leaves_the_motion() {
    let points = [0.038, 0.031, 0.4, -0.036, 0.0, 0.3, 0.0, -0.033, 0.3];
    let points: Vec<f64> = points.into_iter().chain([0.0; 9]).collect();
    let map = [0.04; 25].to_vec();
    let supports: [Effects<'_>; 5] = [
        &[],
        &[(Arc::new(SupportPoints), points)],
        &[(Arc::new(PressureMap), map)],
        &[(Arc::new(FrictionCenterOffset), vec![0.008, -0.004])],
        &[(Arc::new(TableAnisotropy), vec![1.4, 0.6])],
    ];
    // cos π/3 of half a wave of 20 m: within 0.3 % over the square.
    let field = values([10.0 / 3.0, 0.0, 10.0, 10.0], "x1_y0", 0.4);
    let ratio = 0.2_f64.exp();
    let steps = pushes([0.0, 0.0]);
    // What is more of an ellipsoid's friction is that of a uniform pressure: a fifth of the way there.
    for (surface, tolerances) in [
        (Surface::Ellipsoid, [6e-5, 6e-5, 2.5e-3, 0.03, 0.03]),
        (Surface::UniformPatch, [1e-5, 1e-5, 5e-4, 0.015, 0.015]),
    ] {
        for (number, support) in supports.iter().enumerate() {
            let plain = PushPhysics::new(Rig::new(surface.clone(), 0.25, 0.25).unwrap());
            let plain = support.iter().fold(plain, |physics, (effect, values)| {
                physics.with(effect.clone(), values).unwrap()
            });
            let with = plain.clone().with(FrictionField, &field).unwrap();
            for (a, b) in predict(&plain, &steps).iter().zip(predict(&with, &steps)) {
                let b = [b[0], b[1], b[2], b[3] / ratio, b[4] / ratio];
                let is_near = (0..5).all(|k| (a[k] - b[k]).abs() < tolerances[k]);
                assert!(is_near, "{surface:?} {number}: {a:?} {b:?}");
            }
        }
    }
}

#[test]
fn half_a_long_wave_is_a_gradient() {
    // −a sin(π x / 2h) about the middle: of slope −a π / 2h.
    let (half, amplitude) = (1.0, -0.2);
    let field = values([0.0, 0.0, half, half], "x1_y0", amplitude);
    let slope = -amplitude * std::f64::consts::FRAC_PI_2 / half;
    let steps = pushes([0.01, 0.3]);
    let plain = PushPhysics::new(Rig::new(Surface::UniformPatch, 0.25, 0.25).unwrap());
    let by = |effect: Arc<dyn Effect>, values: &[f64]| -> Vec<[f64; 7]> {
        let with = predict(&plain.clone().with(effect, values).unwrap(), &steps);
        let of = |(a, b): (&[f64; 7], [f64; 7])| std::array::from_fn(|k| a[k] - b[k]);
        with.iter().zip(predict(&plain, &steps)).map(of).collect()
    };
    let gradient = by(Arc::new(FrictionGradient), &[slope, 0.0]);
    let field = by(Arc::new(FrictionField), &field);
    for number in 0..5 {
        let sum = |of: &dyn Fn(usize) -> f64| (0..steps.len()).map(|k| of(k).powi(2)).sum::<f64>();
        let size = sum(&|k| gradient[k][number]).sqrt();
        let apart = sum(&|k| gradient[k][number] - field[k][number]).sqrt();
        assert!(size > 1e-6 && apart < 0.1 * size, "{number}: {apart} of {size}");
    }
}

#[test]
fn waves_are_the_cosines_of_their_names_and_end_at_the_rectangle() {
    let sides = [0.1, -0.2, 0.3, 0.2];
    // A quarter of the length along x, two thirds along y: cos 2π/4, cos 3π·2/3 and their product.
    let place = Vector2::new(-0.05, -0.2 + 0.2 / 3.0);
    for (wave, expected) in [("x2_y0", 0.0), ("x0_y3", 1.0), ("x1_y3", 0.5_f64.sqrt())] {
        let values = values(sides, wave, 0.3);
        let found = FrictionField::log_ratio(&values, &place);
        assert!((found - 0.3 * expected).abs() < 1e-12, "{wave} {found}");
        let [corner, far] = [Vector2::new(0.4, -0.4), Vector2::new(7.0, -3.0)];
        let [corner, far] = [corner, far].map(|at| FrictionField::log_ratio(&values, &at));
        assert!((far - corner).abs() < 1e-12 && far.abs() > 0.29, "{wave} {corner} {far}");
    }
}
