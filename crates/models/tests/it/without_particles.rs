//! Whole pushes by moments alone, beside very many particles of the same model.

use std::sync::Arc;

use filter::{GaussHermite, Gaussian, Unscented};
use models::{
    Analytical, ContactGap, GpPushModel, Matching, ModelError, Noise, ProcessKind, PushModel,
    PushPath, Pushed, RollOut, RollOutSettings, SlipMixture, StepCorrelation, StepErrors,
    StepFeatures, StepInput, StepObservation, Training, learn_options,
};
use nalgebra::{DMatrix, DVector, Vector2, Vector3};
use planar::{Pose, Shape};

const RADIUS: f64 = 0.005;
const WAY: f64 = 0.004;

fn square() -> Pushed {
    let shape = Arc::new(Shape::square(0.09).unwrap());
    Pushed { shape, pusher_radius: RADIUS, object: None }
}

/// Steps as the analytical model has them, with noise.
fn steps() -> Vec<StepObservation> {
    let (model, shape) = (Analytical::nominal(0.25).unwrap(), square().shape);
    let step = |k: usize| {
        let (p, beta) = ((k as f64 * 0.618).fract(), -0.9 + 1.8 * (k as f64 * 0.414).fract());
        let input = StepInput::on_edge(shape.clone(), RADIUS, 1, p, beta, WAY).unwrap();
        let mean = model.predict(std::slice::from_ref(&input), Noise::Excluded).unwrap()[0].mean;
        let noise = |prime: usize| 5e-5 * ((k * prime % 17) as f64 - 8.0) / 8.0;
        let noise = Vector3::new(noise(7919), noise(6007), 30.0 * noise(3571));
        StepObservation { input, outputs: mean + noise }
    };
    (0..150).map(step).collect()
}

fn training(process: ProcessKind) -> Training {
    let mut options = learn_options();
    options.n_starts = 1;
    Training { process, n_pseudo_inputs: 40, n_features: 100, ..Training::from(options) }
}

fn trained(process: ProcessKind) -> GpPushModel {
    GpPushModel::train(&steps(), &training(process)).unwrap().0
}

fn settings(errors: StepErrors) -> RollOutSettings {
    RollOutSettings {
        n_particles: 100_000,
        errors,
        touching: true,
        gap: ContactGap { sd: 1e-4, ..ContactGap::default() },
        start_sd: [5e-4, 2e-2],
        ..RollOutSettings::default()
    }
}

/// As pushes of a fixed shape share them.
fn held() -> StepErrors {
    StepErrors::Held(StepCorrelation {
        held: [0.3, 0.3, 0.3],
        length: 0.02,
        freedom: 1e6,
        own: [0.7, 0.7, 0.7],
        measured: [0.0; 3],
        gap: ContactGap { sd: 1e-4, ..ContactGap::default() },
        n_pushes: 20,
        n_steps: 200,
        ends: None,
    })
}

/// A push of five steps that begins at a height on the left face.
fn path(height: f64, along: [f64; 2]) -> PushPath {
    let start = Vector2::new(-0.05, height);
    PushPath::straight(start, start + Vector2::from(along), 0.02).unwrap()
}

/// The moments of the end, by the model's particles.
fn by_particles(model: &dyn PushModel, settings: &RollOutSettings, path: &PushPath) -> Gaussian {
    let roll_out = RollOut { model, pushed: &square(), settings };
    let moments = roll_out.run(&Pose::default(), path, |_, _| {}).unwrap();
    let last = moments[moments.len() - 1].pose_wb;
    let mean = DVector::from_iterator(3, last.mean.iter().copied());
    let covariance = DMatrix::from_iterator(3, 3, last.covariance.iter().copied());
    Gaussian::new(mean, covariance).unwrap()
}

/// The same without particles.
fn matched(
    model: &dyn PushModel,
    settings: &RollOutSettings,
    path: &PushPath,
    matching: Matching<'_>,
) -> Gaussian {
    let roll_out = RollOut { model, pushed: &square(), settings };
    let matched = roll_out.matched(&Pose::default(), path, matching, 1).unwrap();
    matched[matched.len() - 1].moments().unwrap()
}

/// The Kullback–Leibler divergence of the second Gaussian from the first, in nats.
fn divergence(a: &Gaussian, b: &Gaussian) -> f64 {
    let factor = b.covariance().clone().cholesky().unwrap();
    let off = a.mean() - b.mean();
    let size =
        |c: &DMatrix<f64>| 2.0 * c.clone().cholesky().unwrap().l().diagonal().map(f64::ln).sum();
    let trace = factor.solve(a.covariance()).trace();
    0.5 * (trace + off.dot(&factor.solve(&off)) - 3.0 + size(b.covariance()) - size(a.covariance()))
}

#[test]
fn what_is_carried_in_closed_form_has_the_moments_of_many_particles() {
    for kind in [ProcessKind::Gp, ProcessKind::Spgp, ProcessKind::Rff] {
        let model = trained(kind);
        // Particles read tables, which are within 10⁻³ of the variance; the closed form has none.
        let table = model.tabulated().unwrap().0;
        agree(&[[&table, &model]]);
    }
    // Where the contact goes is no Gaussian, and what its moments leave out depends on what was learnt.
    let mixture = |n: usize| {
        let training = training(ProcessKind::Gp);
        let mixture = SlipMixture::train(&steps()[..n], &training).unwrap();
        (mixture.tabulated().unwrap(), mixture)
    };
    let mixtures = [130, 140, 150].map(mixture);
    let pairs = mixtures.each_ref().map(|(table, mixture)| [table as &dyn PushModel, mixture]);
    agree(&pairs);
}

/// Particles of the first of a pair and the closed form of the second agree, on average over the pairs.
fn agree(pairs: &[[&dyn PushModel; 2]]) {
    let (unscented, grid) = (&Unscented, &GaussHermite { order: 3 });
    for errors in [StepErrors::Independent, held()] {
        let settings = settings(errors);
        for (height, along) in [(0.01, [0.02, 0.004]), (0.03, [0.018, 0.012])] {
            let path = path(height, along);
            let truths = pairs.iter().map(|pair| by_particles(pair[0], &settings, &path));
            let truths: Vec<Gaussian> = truths.collect();
            let off = |how: Matching<'_>| {
                let pairs = pairs.iter().zip(&truths);
                let sum: f64 = pairs
                    .map(|(pair, truth)| {
                        divergence(truth, &matched(pair[1], &settings, &path, how))
                    })
                    .sum();
                sum / truths.len() as f64
            };
            let (exact, kind) = (off(Matching::Exact(grid)), pairs[0][0].kind());
            println!("{kind} {height}: {exact}");
            assert!(exact < 2.5e-3, "{kind} {height}: {exact}");
            if height < 0.02 {
                let by_points = off(Matching::Points(unscented));
                assert!(exact < 0.2 * by_points, "{height}: {exact} {by_points}");
            }
        }
    }
}

#[test]
fn without_errors_and_spread_the_one_way_is_that_of_a_particle() {
    let model = trained(ProcessKind::Gp);
    let settings = RollOutSettings { n_particles: 1, touching: true, ..settings(StepErrors::None) };
    let settings = RollOutSettings { gap: ContactGap::default(), start_sd: [0.0; 2], ..settings };
    let path = path(0.01, [0.02, 0.004]);
    let pushed = square();
    let roll_out = RollOut { model: &model, pushed: &pushed, settings: &settings };
    let mut way = Vec::new();
    let moments = roll_out.run(&Pose::default(), &path, |_, _| {}).unwrap();
    way.extend(moments.iter().map(|moment| moment.pose_wb.mean));
    let exact = Matching::Exact(&Unscented);
    let matched = roll_out.matched(&Pose::default(), &path, exact, 1).unwrap();
    for (mean, mixture) in way.iter().zip(&matched) {
        let found = mixture.moments().unwrap();
        assert!(mean.iter().zip(found.mean().iter()).all(|(a, b)| (a - b).abs() < 1e-12));
        assert!(found.covariance().amax() < 1e-20);
    }
}

#[test]
fn a_gaussian_across_an_edges_end_splits_and_joins_again() {
    let model = trained(ProcessKind::Gp);
    let settings = settings(StepErrors::Independent);
    let pushed = square();
    let roll_out = RollOut { model: &model, pushed: &pushed, settings: &settings };
    // A round pusher that touches the corner from the diagonal, within a degree either way.
    let corner = Vector2::new(-0.045, -0.045);
    let start = corner - RADIUS * Vector2::new(1.0, 1.0).normalize();
    let path = PushPath::straight(start, start + Vector2::new(0.002, 0.002), 0.02).unwrap();
    for (most, expected) in [(8, 2..=8), (1, 1..=1)] {
        let exact = Matching::Exact(&GaussHermite { order: 3 });
        let matched = roll_out.matched(&Pose::default(), &path, exact, most).unwrap();
        let parts = matched[matched.len() - 1].components();
        assert!(expected.contains(&parts.len()), "{}", parts.len());
        assert!((parts.iter().map(|(_, share)| share).sum::<f64>() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn models_without_a_closed_form_say_so() {
    let analytical = Analytical::nominal(0.25).unwrap();
    let changing = {
        let mut options = learn_options();
        options.n_starts = 1;
        let training = Training { process: ProcessKind::Vhgp, ..Training::from(options) };
        GpPushModel::train(&steps()[..40], &training).unwrap().0
    };
    let by_contact = {
        let features = StepFeatures { contact: true, ..StepFeatures::default() };
        let training = Training { features, ..training(ProcessKind::Gp) };
        GpPushModel::train(&steps()[..40], &training).unwrap().0
    };
    let (settings, pushed) = (settings(StepErrors::Independent), square());
    for (model, name) in [
        (&analytical as &dyn PushModel, "kind analytical"),
        (&changing, "kind vhgp"),
        (&by_contact, "lever"),
    ] {
        let roll_out = RollOut { model, pushed: &pushed, settings: &settings };
        let exact = Matching::Exact(&Unscented);
        let path = path(0.01, [0.02, 0.004]);
        let error = roll_out.matched(&Pose::default(), &path, exact, 1).unwrap_err();
        assert!(matches!(error, ModelError::NoClosedForm { .. }), "{error}");
        assert!(error.to_string().contains(name), "{error}");
    }
}
