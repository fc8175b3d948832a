//! Laws of roll-outs.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use filter::FilterError;
use nalgebra::{Matrix3, Vector2, Vector3};
use planar::{Pose, Shape};

use super::{Moment, PushParticle, Pushed, RollOut, RollOutSettings, StepErrors};
use crate::{
    Analytical, CharacteristicLength, ContactGap, Estimate, GpPushModel, ModelError, Noise,
    PushModel, PushPath, StepCorrelation, StepInput, StepObservation, learn_options,
};

const RADIUS: f64 = 0.005;
/// Where the pusher's center touches the left face of a square of 90 mm.
const FACE: f64 = -0.045 - RADIUS;

fn square() -> Pushed {
    let shape = Arc::new(Shape::square(0.09).unwrap());
    Pushed { shape, pusher_radius: RADIUS, object: None }
}

/// With a scatter of 2 % of the way, and as much in rad over 30 mm.
fn scattering() -> Analytical {
    let scatter = Matrix3::from_diagonal(&Vector3::new(4e-4, 4e-4, 0.44));
    let friction = Estimate::exact(0.25, "");
    Analytical::new(friction, CharacteristicLength::UniformPressure, scatter).unwrap()
}

fn straight(start: [f64; 2], end: [f64; 2]) -> PushPath {
    PushPath::straight(start.into(), end.into(), 0.02).unwrap()
}

fn ends(
    model: &dyn PushModel,
    settings: &RollOutSettings,
    path: &PushPath,
) -> (Vec<Moment>, Vec<PushParticle>) {
    let (pushed, mut last) = (square(), Vec::new());
    let roll_out = RollOut { model, pushed: &pushed, settings };
    let moments =
        roll_out.run(&Pose::default(), path, |_, particles| last = particles.to_vec()).unwrap();
    (moments, last)
}

fn particles(n_particles: usize) -> RollOutSettings {
    RollOutSettings { n_particles, ..RollOutSettings::default() }
}

#[test]
fn a_model_without_variance_goes_the_one_path_of_its_steps() {
    let model = Analytical::nominal(0.25).unwrap();
    let path = straight([FACE, 0.02], [FACE + 0.04, 0.025]);
    let (moments, last) = ends(&model, &particles(5), &path);
    let mut pose = Pose::default();
    for (step, moment) in path.steps(0.004).unwrap().iter().zip(&moments[1..]) {
        let shape = square().shape;
        let input = StepInput::between(shape, RADIUS, &pose, &step.start_w, &step.end_w).unwrap();
        pose = pose * model.motion(&input).unwrap();
        assert!((moment.pose_wb.mean.xy() - pose.position).norm() < 1e-12);
        assert!((moment.pose_wb.mean.z - pose.angle).abs() < 1e-12);
        assert!(moment.pose_wb.covariance.amax() < 1e-20);
        assert_eq!(moment.events.pushed, 5);
    }
    assert!(last.iter().all(|particle| particle.pose_wb == last[0].pose_wb));
    assert_eq!(moments.len(), 12);
    // Steps of a quarter of the length go the same way: the mechanics know no steps.
    let fine = RollOutSettings { step: 0.001, ..particles(1) };
    let fine = ends(&model, &fine, &path).0.pop().unwrap().pose_wb.mean;
    assert!((fine.xy() - pose.position).norm() < 2e-5, "{fine} {pose:?}");
    assert!((fine.z - pose.angle).abs() < 5e-4);
}

#[test]
fn the_mean_way_of_a_model_with_variance_is_that_of_the_one_without() {
    let path = straight([FACE, 0.01], [FACE + 0.03, 0.01]);
    let none = RollOutSettings { errors: StepErrors::None, ..particles(1) };
    let nominal = ends(&Analytical::nominal(0.25).unwrap(), &particles(1), &path).0;
    assert_eq!(ends(&scattering(), &none, &path).0, nominal);
}

#[test]
fn the_error_of_the_mean_falls_as_one_over_the_root_of_the_particles() {
    let (model, path) = (scattering(), straight([FACE, 0.01], [FACE + 0.02, 0.01]));
    let mean = |n_particles: usize, seed: u64| {
        let settings = RollOutSettings { seed, ..particles(n_particles) };
        ends(&model, &settings, &path).0.pop().unwrap().pose_wb.mean.z
    };
    let truth = mean(40_000, 1000);
    let error = |n: usize| {
        let squares = (0..40).map(|seed| (mean(n, seed) - truth).powi(2));
        (squares.sum::<f64>() / 40.0).sqrt()
    };
    let ratio = error(50) / error(800);
    // Four, give or take the spread of two variances of 40 numbers.
    assert!((2.9..5.5).contains(&ratio), "{ratio}");
}

#[test]
fn a_free_way_leaves_the_object_still_and_the_rest_of_the_step_pushes() {
    let model = Analytical::nominal(0.25).unwrap();
    let path = straight([FACE - 0.010, 0.0], [FACE + 0.010, 0.0]);
    let (moments, _) = ends(&model, &particles(3), &path);
    for moment in &moments[..3] {
        assert_eq!((moment.pose_wb.mean, moment.events.pushed), (Vector3::zeros(), 0));
    }
    assert_eq!((moments[3].events.touched, moments[4].events.touched), (3, 0));
    let end = moments.last().unwrap().pose_wb.mean;
    assert!((end.x - 0.010).abs() < 2e-6, "{end}");
    // A path that misses moves nothing.
    let miss = straight([FACE - 0.010, 0.06], [FACE + 0.2, 0.06]);
    let (moments, _) = ends(&scattering(), &particles(3), &miss);
    assert!(moments.iter().all(|moment| moment.pose_wb.mean == Vector3::zeros()));
    assert!(moments.iter().all(|moment| moment.events.pushed + moment.events.lost == 0));
}

#[test]
fn a_push_through_the_middle_stays_symmetric() {
    let path = straight([FACE, 0.0], [FACE + 0.03, 0.0]);
    let sticking = Analytical::nominal(0.25).unwrap();
    let mean = ends(&sticking, &particles(1), &path).0.pop().unwrap().pose_wb.mean;
    assert!(mean.y.abs() < 1e-12 && mean.z.abs() < 1e-12, "{mean}");
    let (_, last) = ends(&scattering(), &particles(4000), &path);
    let n_left = last.iter().filter(|particle| particle.pose_wb.angle > 0.0).count();
    // Half of 4000, give or take four standard deviations.
    assert!((1873..2128).contains(&n_left), "{n_left}");
}

#[test]
fn mirrored_pushes_end_mirrored() {
    let model = Analytical::nominal(0.25).unwrap();
    let end = |sign: f64| {
        let path = straight([FACE, 0.02 * sign], [FACE + 0.03, 0.03 * sign]);
        ends(&model, &particles(1), &path).0.pop().unwrap().pose_wb.mean
    };
    let (one, other) = (end(1.0), end(-1.0));
    assert!((one - Vector3::new(other.x, -other.y, -other.z)).amax() < 1e-9, "{one} {other}");
}

#[test]
fn contact_holds_its_gap_in_every_particle() {
    let path = straight([FACE - 0.0004, 0.01], [FACE + 0.03, 0.01]);
    let settings = RollOutSettings { touching: true, ..particles(500) };
    let (pushed, model) = (square(), scattering());
    let roll_out = RollOut { model: &model, pushed: &pushed, settings: &settings };
    let watch = |moment: &Moment, particles: &[PushParticle]| {
        for particle in particles.iter().filter(|particle| particle.touches()) {
            let gap = pushed.stated().gap(&particle.pose_wb, &moment.pusher_w.into());
            assert!((gap - 0.0004).abs() < 1e-7, "{gap}");
        }
    };
    roll_out.run(&Pose::default(), &path, watch).unwrap();
}

#[test]
fn a_gap_that_is_not_known_spreads_along_the_normal() {
    let path = straight([FACE, 0.0], [FACE + 0.02, 0.0]);
    let settings = RollOutSettings {
        touching: true,
        gap: ContactGap { sd: 2e-4, ..Default::default() },
        ..particles(2000)
    };
    let end = ends(&scattering(), &settings, &path).0.pop().unwrap().pose_wb.covariance;
    let exact = RollOutSettings { gap: ContactGap::default(), ..settings };
    let without = ends(&scattering(), &exact, &path).0.pop().unwrap().pose_wb.covariance;
    let added = (end[(0, 0)] - without[(0, 0)]).sqrt();
    assert!((added / 2e-4 - 1.0).abs() < 0.1, "{added}");
}

#[test]
fn a_pusher_that_slides_off_is_counted_and_may_come_back() {
    let model = Analytical::nominal(0.05).unwrap();
    // Steeply along the face and off at its end, then back onto it.
    let corners = [[FACE, 0.03], [FACE + 0.004, 0.08], [FACE - 0.01, 0.0], [FACE + 0.03, 0.0]];
    let path = PushPath::polyline(&corners.map(Vector2::from), 0.02).unwrap();
    let (moments, _) = ends(&model, &particles(2), &path);
    let lost: usize = moments.iter().map(|moment| moment.events.lost).sum();
    let touched: usize = moments.iter().map(|moment| moment.events.touched).sum();
    assert_eq!((lost, touched), (2, 2), "one loss and one return each; the start is in contact");
    let pushed = moments.iter().map(|moment| moment.events.pushed > 0).collect::<Vec<_>>();
    let changes = pushed[1..].windows(2).filter(|pair| pair[0] != pair[1]).count();
    assert_eq!(changes, 2, "{pushed:?}");
}

#[test]
fn a_push_at_a_corner_is_counted_as_one() {
    let model = Analytical::nominal(0.25).unwrap();
    let path = straight([FACE, 0.047], [FACE + 0.008, 0.047]);
    let (moments, _) = ends(&model, &particles(1), &path);
    assert!(moments.iter().any(|moment| moment.events.at_vertex == 1));
    let middle = straight([FACE, 0.0], [FACE + 0.008, 0.0]);
    let (moments, _) = ends(&model, &particles(1), &middle);
    assert!(moments.iter().all(|moment| moment.events.at_vertex == 0));
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let path = straight([FACE - 0.003, 0.01], [FACE + 0.01, 0.012]);
    let (model, settings) = (scattering(), particles(3000));
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| ends(&model, &settings, &path))
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn held_errors_grow_with_the_way_and_independent_ones_with_its_root() {
    let shares = |held: f64, own: f64| {
        let (n_pushes, n_steps, measured) = (1, 1, [0.0; 3]);
        let (held, own) = ([held; 3], [own; 3]);
        let (length, gap) = (1e3, ContactGap::default());
        let freedom = 1e6;
        StepErrors::Held(StepCorrelation {
            held,
            length,
            freedom,
            own,
            measured,
            gap,
            n_pushes,
            n_steps,
            ends: None,
        })
    };
    let spread = |errors: StepErrors, way: f64| {
        let path = straight([FACE, 0.0], [FACE + way, 0.0]);
        let settings = RollOutSettings { errors, step: 0.002, ..particles(4000) };
        // Sideways, where contact holds nothing and the turn adds little over so short a way.
        ends(&scattering(), &settings, &path).0.pop().unwrap().pose_wb.covariance[(1, 1)].sqrt()
    };
    for (errors, growth) in
        [(StepErrors::Independent, 2.0), (shares(0.0, 1.0), 2.0), (shares(1.0, 0.0), 4.0)]
    {
        let ratio = spread(errors.clone(), 0.008) / spread(errors, 0.002);
        assert!((ratio / growth - 1.0).abs() < 0.12, "{ratio} {growth}");
    }
}

/// Steps of a face as the analytical model has them, with noise, up to 0.4 rad from the normal.
fn learnt() -> GpPushModel {
    let model = Analytical::nominal(0.25).unwrap();
    let shape = square().shape;
    let step = |k: usize| {
        let (p, beta) = (0.1 + 0.8 * (k % 9) as f64 / 8.0, -0.4 + 0.1 * (k / 9) as f64);
        let input = StepInput::on_edge(shape.clone(), RADIUS, 1, p, beta, 0.004).unwrap();
        let noise = 2e-5 * ((k * 7919 % 17) as f64 - 8.0) / 8.0;
        let mean = model.predict(std::slice::from_ref(&input), Noise::Excluded).unwrap()[0].mean;
        StepObservation { input, outputs: mean + Vector3::new(noise, -noise, 30.0 * noise) }
    };
    let steps: Vec<_> = (0..81).map(step).collect();
    GpPushModel::learn(&steps, &learn_options()).unwrap().0
}

#[test]
fn what_a_learnt_model_has_not_seen_is_counted_and_widens_the_cloud() {
    let model = learnt();
    let at_angle = |beta: f64| {
        let end = [FACE + 0.012 * beta.cos(), 0.012 * beta.sin()];
        let path = straight([FACE, 0.0], end);
        let moments = ends(&model, &particles(300), &path).0;
        (moments[1].events.unseen, moments[3].pose_wb.covariance[(2, 2)].sqrt())
    };
    let ((inside, narrow), (outside, wide)) = (at_angle(0.2), at_angle(1.2));
    assert_eq!((inside, outside), (0, 300));
    assert!(wide > 3.0 * narrow, "{wide} {narrow}");
    // The span comes back from the weights.
    let built = model.describe().unwrap().build().unwrap();
    assert_eq!(built.seen(), model.seen());
    assert!(model.seen().unwrap().way[0] > 0.0039);
}

#[test]
fn what_cannot_be_rolled_out_is_refused_with_the_reason() {
    let (pushed, nominal) = (square(), Analytical::nominal(0.25).unwrap());
    let path = straight([FACE, 0.0], [FACE + 0.01, 0.0]);
    let refused = |model: &dyn PushModel, settings: RollOutSettings, path: &PushPath, start| {
        let roll_out = RollOut { model, pushed: &pushed, settings: &settings };
        roll_out.run(&start, path, |_, _| {}).unwrap_err()
    };
    let home = Pose::default();
    let none = refused(&nominal, particles(0), &path, home);
    assert!(matches!(none, ModelError::Filter(FilterError::Empty { .. })), "{none}");
    let inside = refused(&nominal, particles(1), &straight([FACE + 0.02, 0.0], [0.1, 0.0]), home);
    assert!(inside.to_string().contains("starts 20.00 mm inside"), "{inside}");
    let nowhere = refused(&nominal, particles(1), &path, Pose::new(f64::NAN, 0.0, 0.0));
    assert!(nowhere.to_string().contains("x of the start must be finite"), "{nowhere}");
    for (settings, says) in [
        (RollOutSettings { step: 0.0, ..particles(1) }, "length of a step"),
        (RollOutSettings { start_sd: [-1.0, 0.0], ..particles(1) }, "sd of the start's place"),
        (
            RollOutSettings { gap: ContactGap { sd: -1.0, ..Default::default() }, ..particles(1) },
            "sd of the gap",
        ),
        (RollOutSettings { tolerance: f64::NAN, ..particles(1) }, "tolerance of contact"),
    ] {
        let error = refused(&nominal, settings, &path, home).to_string();
        assert!(error.contains(says), "{error}");
    }
    let learnt = learnt();
    let long = RollOutSettings { step: 0.01, ..particles(1) };
    let error = refused(&learnt, long, &path, home);
    assert!(matches!(error, ModelError::StepTooLong { .. }), "{error}");
    assert!(error.to_string().contains("longest of 4.00 mm"), "{error}");
    let disc = Pushed { shape: Arc::new(Shape::square(0.1).unwrap()), ..square() };
    let settings = particles(1);
    let other = RollOut { model: &learnt, pushed: &disc, settings: &settings };
    let path = straight([-0.06, 0.0], [0.0, 0.0]);
    let error = other.run(&Pose::new(0.0, 0.0, FRAC_PI_2), &path, |_, _| {}).unwrap_err();
    let ModelError::Filter(FilterError::Motion { step, source }) = &error else {
        panic!("{error}")
    };
    assert!(source.to_string().contains("train one on pushes of this object"), "{source} {step}");
}
