//! Particles in great numbers: what they cost, and how near the fast way is.

use std::sync::Arc;

use allocation_counter::{AllocationInfo, measure};
use models::{
    Analytical, GpPushModel, ModelError, Noise, ProcessKind, PushModel, PushPath, Pushed, RollOut,
    RollOutSettings, StepFeatures, StepInput, StepObservation, Training, learn_options,
};
use nalgebra::{Vector2, Vector3};
use planar::{Pose, Shape};

const RADIUS: f64 = 0.005;
const WAY: f64 = 0.004;

fn square() -> Pushed {
    let shape = Arc::new(Shape::square(0.09).unwrap());
    Pushed { shape, pusher_radius: RADIUS, object: None }
}

/// Steps of one face as the analytical model has them, with noise.
fn steps() -> Vec<StepObservation> {
    let (model, shape) = (Analytical::nominal(0.25).unwrap(), square().shape);
    let step = |k: usize| {
        let (p, beta) = ((k as f64 * 0.618).fract(), -0.9 + 1.8 * (k as f64 * 0.414).fract());
        let input = StepInput::on_edge(shape.clone(), RADIUS, 1, p, beta, WAY).unwrap();
        let mean = model.predict(std::slice::from_ref(&input), Noise::Excluded).unwrap()[0].mean;
        let noise = 2e-5 * ((k * 7919 % 17) as f64 - 8.0) / 8.0;
        StepObservation { input, outputs: mean + Vector3::new(noise, -noise, 30.0 * noise) }
    };
    (0..150).map(step).collect()
}

fn trained(process: ProcessKind) -> GpPushModel {
    let mut options = learn_options();
    options.n_starts = 1;
    let training =
        Training { process, n_pseudo_inputs: 40, n_features: 100, ..Training::from(options) };
    GpPushModel::train(&steps(), &training).unwrap().0
}

/// Allocations of one step of so many particles.
fn allocations(model: &dyn PushModel, n_particles: usize) -> AllocationInfo {
    let (pushed, start) = (square(), Vector2::new(-0.05, 0.01));
    let path = PushPath::straight(start, start + Vector2::new(0.004, 0.001), 0.02).unwrap();
    let step = path.steps(0.005).unwrap()[0];
    let settings = RollOutSettings {
        n_particles,
        touching: true,
        start_sd: [1e-4, 5e-3],
        ..RollOutSettings::default()
    };
    let roll_out = RollOut { model, pushed: &pushed, settings: &settings };
    let mut filter = roll_out.start(&Pose::default(), &path).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    // Counted is the thread that works, which is the pool's.
    let motion = roll_out.motion(&step).unwrap();
    pool.install(|| {
        // The pool's own first allocations are not the step's.
        filter.clone().predict(&motion).unwrap();
        measure(|| filter.predict(&motion).unwrap())
    })
}

#[test]
fn a_step_allocates_by_the_thousand_particles_and_never_by_the_particle() {
    let table = trained(ProcessKind::Spgp).tabulated().unwrap().0;
    let nominal = Analytical::nominal(0.25).unwrap();
    for model in [&table as &dyn PushModel, &nominal] {
        // One chunk of particles, hardly filled and full: lists grow by doubling.
        let (few, many) = (allocations(model, 8).count_total, allocations(model, 1024).count_total);
        assert!(few > 0, "it is this thread that was counted");
        assert!(many < few + 40 && many < 60, "{}: {few} and {many}", model.kind());
    }
}

#[test]
fn a_table_is_within_a_thousandth_of_the_prior_variance_of_every_process() {
    let shape = square().shape;
    // Places that no node and no trial of the table knows, far beyond the training steps too.
    let place = |k: usize| {
        let (p, beta) = ((k as f64 * 0.7548).fract(), -1.6 + 3.2 * (k as f64 * 0.5698).fract());
        StepInput::on_edge(shape.clone(), RADIUS, 2, p, beta, 0.003).unwrap()
    };
    let inputs: Vec<StepInput> = (0..3000).map(place).collect();
    for kind in ProcessKind::ALL {
        let model = trained(kind);
        let (table, report) = model.tabulated().unwrap();
        assert!(report.variance_error <= 1e-3 && report.mean_error <= 1e-2, "{report:?}");
        for noise in [Noise::Included, Noise::Excluded] {
            let (all, fast) =
                (model.predict(&inputs, noise).unwrap(), table.predict(&inputs, noise).unwrap());
            for k in 0..3 {
                // No prior is narrower than the widest belief about the function.
                let function = model.predict(&inputs, Noise::Excluded).unwrap();
                let prior = function.iter().map(|said| said.covariance[(k, k)]).fold(0.0, f64::max);
                for (one, other) in all.iter().zip(&fast) {
                    let off = (one.covariance[(k, k)] - other.covariance[(k, k)]).abs();
                    assert!(off <= 1e-3 * prior, "{kind:?}, output {k}: {off} of {prior}");
                    let off = (one.mean[k] - other.mean[k]).abs();
                    assert!(off <= 0.03 * prior.sqrt(), "{kind:?}, output {k}: {off}");
                }
            }
        }
        assert_eq!(table.seen(), model.seen());
        assert_eq!(table.describe().unwrap(), model.describe().unwrap());
    }
}

#[test]
fn a_model_that_sees_more_than_place_and_angle_has_no_table() {
    let timed = steps().into_iter().enumerate().map(|(k, step)| {
        let duration = 0.1 + 0.01 * (k % 7) as f64;
        StepObservation { input: step.input.lasting(duration).unwrap(), ..step }
    });
    let features = StepFeatures { speed: true, ..StepFeatures::default() };
    let mut options = learn_options();
    options.n_starts = 1;
    let training = Training { features, ..Training::from(options) };
    let model = GpPushModel::train(&timed.collect::<Vec<_>>(), &training).unwrap().0;
    let error = model.tabulated().unwrap_err();
    assert!(matches!(&error, ModelError::NoTable { inputs } if inputs.contains("speed_m_s")));
}
