//! What every kind of model must do, on steps made from the mechanics with known parameters.

use crate::known_steps::{inputs, nmse, spread, unit_noise};
use models::{
    Analytical, Base, CharacteristicLength, Description, Estimate, GpPushModel, Hybrid, ModelError,
    ModelFile, Noise, ProcessKind, ProcessModel, PushModel, StepInput, StepObservation,
    SurfaceKind, Training, learn_options, model_kinds,
};
use nalgebra::{Matrix3, Vector3};
use planar::Shape;
use std::path::{Path, PathBuf};
use std::sync::Arc;

const MU_P: f64 = 0.22;
const C: f64 = 0.037;
const SD: [f64; 3] = [4e-5, 4e-5, 1e-3];

fn truth() -> Analytical {
    let length = CharacteristicLength::Given(Estimate::exact(C, "truth"));
    Analytical::new(Estimate::exact(MU_P, "truth"), length, Matrix3::zeros()).unwrap()
}

fn nominal() -> Analytical {
    Analytical::nominal(0.3).unwrap()
}

/// Steps 4 mm long on one face of a 90 mm square: the truth's motion plus `noise` times `SD`.
fn steps(n: usize, noise: f64) -> Vec<StepObservation> {
    let shape = Arc::new(Shape::square(0.09).unwrap());
    let step = |k: usize| {
        let (p, share) = (spread(k, 0.754_877_666), spread(k, 0.569_840_290));
        let beta = 1.6 * share - 0.8;
        let input = StepInput::on_edge(shape.clone(), 0.00475, 1, p, beta, 0.004).unwrap();
        let mean = truth().predict(std::slice::from_ref(&input), Noise::Excluded).unwrap()[0].mean;
        let error = Vector3::from_fn(|output, _| noise * SD[output] * unit_noise(k, output));
        StepObservation { input, outputs: mean + error }
    };
    (0..n).map(step).collect()
}

fn trained(n: usize) -> Vec<Box<dyn PushModel>> {
    let steps = steps(n, 1.0);
    model_kinds().iter().map(|kind| (kind.train)(&nominal(), &steps).unwrap()).collect()
}

/// The share of observations inside the 95 % interval, for each output.
fn shares_inside(model: &dyn PushModel, test: &[StepObservation]) -> [f64; 3] {
    let predictions = model.predict(&inputs(test), Noise::Included).unwrap();
    std::array::from_fn(|k| {
        let hit = test.iter().zip(&predictions).filter(|(step, prediction)| {
            let error = step.outputs[k] - prediction.mean[k];
            error.abs() < 1.96 * prediction.covariance[(k, k)].sqrt()
        });
        hit.count() as f64 / test.len() as f64
    })
}

#[test]
fn every_kind_predicts_unseen_steps_with_honest_intervals() {
    let steps = steps(800, 1.0);
    let test = &steps[400..];
    for n in [30, 60, 200] {
        for (model, kind) in trained(n).iter().zip(model_kinds()) {
            assert_eq!(model.kind(), kind.id);
            let shares = shares_inside(&**model, test);
            let honest = |share: &f64| (0.88..=1.0).contains(share);
            assert!(shares.iter().all(honest), "{}, {n} steps: {shares:?}", kind.id);
            // With enough steps the intervals are not too wide either.
            assert!(n < 200 || shares.iter().sum::<f64>() < 3.0 * 0.985, "{}: {shares:?}", kind.id);
            let nmse = nmse(&**model, test);
            assert!(n < 200 || nmse < 0.05, "{}: {nmse}", kind.id);
        }
    }
}

#[test]
fn every_covariance_is_symmetric_positive_and_larger_with_noise() {
    for model in trained(40) {
        let test = inputs(&steps(60, 0.0));
        let with = model.predict(&test, Noise::Included).unwrap();
        let without = model.predict(&test, Noise::Excluded).unwrap();
        for (with, without) in with.iter().zip(&without) {
            assert_eq!(with.mean, without.mean);
            assert_eq!(with.covariance, with.covariance.transpose());
            // Of two parameters the covariance has rank two: its third eigenvalue is rounding.
            let eigenvalues = without.covariance.symmetric_eigenvalues();
            assert!(eigenvalues.min() >= -1e-12 * eigenvalues.max());
            let gain = with.covariance - without.covariance;
            assert!((0..3).all(|k| gain[(k, k)] > 0.0));
        }
    }
}

#[test]
fn every_prediction_of_a_batch_is_that_of_its_step_alone() {
    for model in trained(40) {
        let test = inputs(&steps(70, 0.0));
        let batch = model.predict(&test, Noise::Included).unwrap();
        for (step, expected) in test.iter().zip(batch) {
            let alone = model.predict(std::slice::from_ref(step), Noise::Included).unwrap()[0];
            assert!((alone.mean - expected.mean).norm() < 1e-12);
        }
        assert!(model.predict(&[], Noise::Included).unwrap().is_empty());
    }
}

#[test]
fn every_kind_comes_back_from_its_file_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let on = |surface| Box::new(nominal().with_surface(surface).unwrap()) as Box<dyn PushModel>;
    let surfaces = SurfaceKind::all().chain([SurfaceKind::Points { n_points: 64 }]);
    for model in trained(30).into_iter().chain(surfaces.map(on)) {
        let path = folder.path().join("model.toml");
        let description = model.describe().unwrap();
        let file = ModelFile::new("a \"name\"", description);
        file.write(&path).unwrap();
        let back = ModelFile::read(&path).unwrap();
        assert_eq!(back, file);
        let test = inputs(&steps(20, 0.0));
        let expected = model.predict(&test, Noise::Included).unwrap();
        let rebuilt = back.description.build().unwrap();
        assert_eq!(rebuilt.predict(&test, Noise::Included).unwrap(), expected);
    }
}

#[test]
fn a_fit_returns_the_parameters_that_made_the_steps() {
    let fit = nominal().fit(&steps(60, 0.0)).unwrap();
    assert!((fit.model.pusher_friction().value / MU_P - 1.0).abs() < 1e-5);
    let c = fit.model.characteristic_length(&steps(1, 0.0)[0].input);
    assert!((c / C - 1.0).abs() < 1e-5);
}

#[test]
fn a_fit_to_noisy_steps_is_right_within_its_standard_errors() {
    let fit = nominal().fit(&steps(300, 1.0)).unwrap();
    let mu_p = fit.model.pusher_friction();
    assert!((mu_p.value - MU_P).abs() < 3.0 * mu_p.se && mu_p.se < 0.01, "{mu_p:?}");
    let CharacteristicLength::Given(c) = fit.model.length() else { panic!("c was fitted") };
    assert!((c.value - C).abs() < 3.0 * c.se && c.se < 0.001, "{c:?}");
    let input = steps(1, 0.0)[0].input.clone();
    let scatter = fit.model.predict(&[input], Noise::Included).unwrap()[0].covariance;
    for k in 0..3 {
        assert!((scatter[(k, k)].sqrt() / SD[k] - 1.0).abs() < 0.15);
    }
}

#[test]
fn a_fit_refuses_what_it_cannot_know() {
    let few = nominal().fit(&steps(3, 1.0));
    assert!(matches!(few, Err(ModelError::TooFewSteps { needed: 4, actual: 3, .. })));
    let same = nominal().fit(&vec![steps(1, 0.0).remove(0); 5]);
    assert!(matches!(same, Err(ModelError::ConstantOutput { output: "dx", n_steps: 5 })));
    let sticking: Vec<_> =
        steps(200, 1.0).into_iter().filter(|step| step.input.beta().abs() < 0.05).collect();
    let model = Analytical::nominal(1.0).unwrap().fit(&sticking);
    assert!(matches!(model, Err(ModelError::Undetermined { parameter: "mu_p" })), "{model:?}");
}

#[test]
fn learning_curves_fall_and_the_hybrid_needs_fewer_steps() {
    let (steps, options) = (steps(320, 1.0), learn_options());
    let test = &steps[200..];
    let gp = |n: usize| nmse(&GpPushModel::learn(&steps[..n], &options).unwrap().0, test);
    let hybrid = |n: usize| nmse(&Hybrid::learn(nominal(), &steps[..n], &options).unwrap().0, test);
    assert!(gp(200) < gp(20));
    assert!(hybrid(20) < gp(20));
}

#[test]
fn on_every_surface_friction_is_found_again() {
    let test = inputs(&steps(24, 0.0));
    let mut motions = Vec::new();
    for surface in SurfaceKind::all() {
        let model =
            |friction| Analytical::nominal(friction).unwrap().with_surface(surface).unwrap();
        let made = model(MU_P).predict(&test, Noise::Excluded).unwrap();
        let observe = |(input, made): (&StepInput, &models::StepPrediction)| StepObservation {
            input: input.clone(),
            outputs: made.mean,
        };
        let made: Vec<_> = test.iter().zip(&made).map(observe).collect();
        let fit = model(0.3).fit(&made).unwrap();
        assert_eq!(fit.model.surface(), surface);
        let found = fit.model.pusher_friction().value;
        assert!((found / MU_P - 1.0).abs() < 1e-4, "{surface:?}: {found}");
        motions.push(made);
    }
    // The exact surface of a square is none of the others, but near to each.
    let of = |kind| SurfaceKind::all().position(|other| other == kind).unwrap();
    let exact = motions.remove(of(SurfaceKind::UniformPatch));
    for other in motions {
        let difference = |k: usize| (exact[k].outputs - other[k].outputs).norm();
        let largest = (0..24).map(difference).fold(0.0, f64::max);
        let turn = (0..24).map(|k| exact[k].outputs.z.abs()).fold(0.0, f64::max);
        assert!(largest > 1e-6 && largest < 0.3 * turn, "{largest} of {turn}");
    }
}

#[test]
fn standard_errors_of_parameters_widen_a_prediction_and_zero_does_not() {
    let model = |friction_se: f64, length_se: f64| {
        let estimate = |value, se| Estimate { value, se, source: "test".into() };
        let length = CharacteristicLength::Given(estimate(C, length_se));
        Analytical::new(estimate(MU_P, friction_se), length, Matrix3::zeros()).unwrap()
    };
    let test = inputs(&steps(20, 0.0));
    let at = |friction_se, length_se| {
        model(friction_se, length_se).predict(&test, Noise::Excluded).unwrap()
    };
    let (both, one, other) = (at(0.02, 0.001), at(0.02, 0.0), at(0.0, 0.001));
    for (i, exact) in at(0.0, 0.0).iter().enumerate() {
        assert_eq!(exact.covariance, Matrix3::zeros());
        let sum = one[i].covariance + other[i].covariance;
        assert!((both[i].covariance - sum).amax() <= 1e-12 * sum.amax());
        // A secant of the turn by c, by hand.
        let turned = |c: f64| {
            let length = CharacteristicLength::Given(Estimate::exact(c, "test"));
            let model = Analytical::new(Estimate::exact(MU_P, "test"), length, Matrix3::zeros());
            model.unwrap().motion(&test[i]).unwrap().angle
        };
        let sd = 0.5 * (turned(C + 0.001) - turned(C - 0.001)).abs();
        assert!((other[i].covariance[(2, 2)].sqrt() - sd).abs() < 1e-12);
    }
    assert!(one.iter().any(|p| p.covariance[(1, 1)] > 0.0));
}

#[test]
fn a_surface_that_cannot_be_is_refused() {
    let of_another = truth().with_surface(SurfaceKind::named("quartic").unwrap());
    assert!(matches!(of_another, Err(ModelError::LengthOfAnotherSurface { surface: "quartic" })));
    let few = nominal().with_surface(SurfaceKind::Points { n_points: 3 });
    assert!(matches!(few, Err(ModelError::InvalidValue { value: 3.0, .. })));
    let bad = Estimate { value: 0.2, se: f64::NAN, source: String::new() };
    let bad = Analytical::new(bad, CharacteristicLength::UniformPressure, Matrix3::zeros());
    assert!(matches!(bad, Err(ModelError::InvalidValue { name: "se of the pusher friction", .. })));
}

#[test]
fn a_push_through_the_center_goes_straight() {
    let shape = Arc::new(Shape::square(0.09).unwrap());
    let step = StepInput::on_edge(shape, 0.00475, 1, 0.5, 0.0, 0.02).unwrap();
    let mean = nominal().predict(&[step], Noise::Included).unwrap()[0].mean;
    assert!((mean - Vector3::new(0.02, 0.0, 0.0)).norm() < 1e-9, "{mean}");
}

#[test]
fn mirrored_steps_have_mirrored_motions() {
    let shape = Arc::new(Shape::square(0.09).unwrap());
    let mean = |p: f64, beta: f64| {
        let step = StepInput::on_edge(shape.clone(), 0.00475, 1, p, beta, 0.004).unwrap();
        nominal().predict(&[step], Noise::Excluded).unwrap()[0].mean
    };
    for k in 0..20 {
        let (p, beta) = (spread(k, 0.37), 1.8 * spread(k, 0.61) - 0.9);
        let (one, other) = (mean(p, beta), mean(1.0 - p, -beta));
        assert!((one - Vector3::new(other.x, -other.y, -other.z)).norm() < 1e-9);
    }
}

/// The weights files of a folder.
fn weights(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.filter(|path| path.to_string_lossy().ends_with(".weights.json")).collect()
}

#[test]
fn a_model_keeps_its_weights_until_another_one_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("square.toml");
    let file = |n: usize| {
        let description = trained(n).pop().unwrap().describe().unwrap();
        ModelFile::new("square", description)
    };
    let (old, new) = (file(30), file(40));
    assert!(old.description.weights.is_some() && old != new);
    old.write(&path).unwrap();
    let before = weights(folder.path());
    // As if the run was killed when the new weights were whole, and the model not yet.
    let aside = folder.path().join("aside");
    std::fs::create_dir(&aside).unwrap();
    new.write(&aside.join("square.toml")).unwrap();
    for whole in weights(&aside) {
        std::fs::copy(&whole, folder.path().join(whole.file_name().unwrap())).unwrap();
    }
    assert_eq!(ModelFile::read(&path).unwrap(), old);
    new.write(&path).unwrap();
    assert_eq!(ModelFile::read(&path).unwrap(), new);
    let after = weights(folder.path());
    assert!(after.len() == 1 && after != before, "{after:?}");
    // Another model of the folder may name them, too.
    std::fs::copy(&path, folder.path().join("copy.toml")).unwrap();
    old.write(&path).unwrap();
    assert_eq!(ModelFile::read(&folder.path().join("copy.toml")).unwrap(), new);
    assert_eq!(ModelFile::read(&path).unwrap(), old);
}

#[test]
fn weights_that_were_changed_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("square.toml");
    let (model, _) = GpPushModel::learn(&steps(20, 1.0), &learn_options()).unwrap();
    let description: Description = model.describe().unwrap();
    ModelFile::new("square", description).write(&path).unwrap();
    let weights = weights(folder.path()).pop().unwrap();
    let text = std::fs::read_to_string(&weights).unwrap();
    std::fs::write(&weights, text.replacen('1', "2", 1)).unwrap();
    let error = ModelFile::read(&path).unwrap_err();
    assert!(matches!(&error, ModelError::Weights { .. }) && error.to_string().contains("SHA-256"));
    std::fs::remove_file(&weights).unwrap();
    assert!(matches!(ModelFile::read(&path), Err(ModelError::Io { action: "read", .. })));
}

/// Its sparse processes did not keep what the steps leave open of their mean.
#[test]
fn weights_of_an_older_release_say_what_they_lack() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("square.toml");
    let training = Training::with(ProcessKind::Spgp);
    let (model, _) = GpPushModel::train(&steps(30, 1.0), &training).unwrap();
    let mut description = model.describe().unwrap();
    for process in &mut description.weights.as_mut().unwrap().outputs {
        let ProcessModel::Spgp(model) = process else { panic!("not sparse") };
        (model.version, model.deviation) = (1, None);
    }
    ModelFile::new("square", description).write(&path).unwrap();
    let rebuilt = ModelFile::read(&path).and_then(|file| file.description.build());
    let ModelError::Gp { source, .. } = rebuilt.err().unwrap() else { panic!("another error") };
    assert!(source.to_string().contains("without the uncertainty of its learnt mean"), "{source}");
}

/// The analytical model of a file, as people would write it.
const ANALYTICAL: &str = r#"schema = "pushlab.model/1"
name = "x"

[base]
kind = "analytical"
limit_surface = "ellipsoid"
pressure = "uniform"

[base.pusher_friction]
value = 0.25
se = 0.0
source = "manifest"
"#;

fn read(text: &str) -> Result<ModelFile, ModelError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.toml");
    std::fs::write(&path, text).unwrap();
    ModelFile::read(&path)
}

#[test]
fn a_file_chooses_its_surface() {
    let points = "\"points\"\nn_points = 7";
    for (value, surface) in [
        ("\"ellipsoid\"", SurfaceKind::Ellipsoid),
        ("\"uniform-patch\"", SurfaceKind::UniformPatch),
        ("\"quartic\"", SurfaceKind::named("quartic").unwrap()),
        ("\"points\"", SurfaceKind::Points { n_points: mechanics::PointSet::ENOUGH }),
        (points, SurfaceKind::Points { n_points: 7 }),
    ] {
        let file = read(&ANALYTICAL.replace("\"ellipsoid\"", value)).unwrap();
        let Base::Analytical(model) = file.description.base else { panic!("{value}") };
        assert_eq!(model.surface(), surface);
    }
    let file = read(&ANALYTICAL.replace("limit_surface = \"ellipsoid\"\n", "")).unwrap();
    assert_eq!(
        file.description.base,
        Base::Analytical(
            Analytical::new(
                Estimate::exact(0.25, "manifest"),
                CharacteristicLength::UniformPressure,
                Matrix3::zeros(),
            )
            .unwrap()
        )
    );
}

#[test]
fn every_impossible_file_names_its_line_and_key() {
    let good = ANALYTICAL;
    let effect = "\n[[effects]]\nid = \"table-tilt\"\n";
    let length = "\n[base.characteristic_length]\nvalue = 0.03\n";
    let learned = "\n[learned]\nweights = \"w.json\"\nsha256 = \"00\"\ninputs = [\"p\"]\n";
    let given = || format!("{}{length}", good.replace("pressure = \"uniform\"\n", ""));
    let scatter =
        |rows: &str| good.replace("pressure =", &format!("scatter_per_m = {rows}\npressure ="));
    for (text, line, key, part) in [
        (good.replace("model/1", "model/9"), 1, "schema", "pushlab.model/1"),
        (good.replace("name = \"x\"", "name = 3"), 2, "name", "expected a string"),
        (good.replace("analytical", "oracle"), 5, "base.kind", "analytical, gp, spgp"),
        (
            good.replace("ellipsoid", "sphere"),
            6,
            "base.limit_surface",
            "ellipsoid, uniform-patch, points, quartic",
        ),
        (good.replace("\"uniform\"", "\"rim\""), 7, "base.pressure", "allowed: uniform"),
        (good.replace("pressure =", "presure ="), 7, "presure", "unknown field"),
        (good.replace("pressure =", "n_points = 9\npressure ="), 7, "base.n_points", "points"),
        (
            good.replace("\"ellipsoid\"", "\"points\"\nn_points = 3"),
            7,
            "base.n_points",
            "from 4 to 10000, got 3",
        ),
        (good.replace("0.25", "-0.25"), 9, "base.pusher_friction.value", "-0.25"),
        (good.replace("0.25", "nan"), 9, "base.pusher_friction.value", "from 0 to 10, got NaN"),
        (good.replace("se = 0.0", "se = -1.0"), 9, "base.pusher_friction.se", "-1"),
        (good.replace("se = 0.0", "sd = 0.0"), 11, "sd", "unknown field"),
        (good.replace("pressure = \"uniform\"\n", ""), 4, "base.pressure", "either"),
        (format!("{good}{length}"), 4, "base.pressure", "either"),
        (given().replace("0.03", "0.0"), 13, "base.characteristic_length.value", "to 10, got 0.0"),
        (
            given().replace("ellipsoid", "quartic"),
            13,
            "base.characteristic_length",
            "on quartic give pressure",
        ),
        (good.split("\n[base.pusher").next().unwrap().into(), 4, "base.pusher_friction", "missing"),
        (good.split("[base]").next().unwrap().to_owned() + "base = 3", 4, "base", "a table with"),
        (scatter("[[1, 2, 0], [3, 1, 0], [0, 0, 1]]"), 7, "base.scatter_per_m", "symmetric"),
        (scatter("[[1, 2, 0], [2, 1, 0], [0, 0, 1]]"), 7, "base.scatter_per_m", "semi-definite"),
        (good.replace("analytical", "gp"), 4, "learned", "needs"),
        (format!("{good}{learned}"), 14, "learned", "no weights"),
        (format!("{}{learned}", good.replace("analytical", "hybrid")), 14, "learned.inputs", "p"),
        (format!("{}{learned}", good.replace("analytical", "gp")), 6, "base", "no mechanics"),
        (format!("{good}{effect}"), 14, "effects.parameters.ax", "ay (from"),
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
fn a_standard_error_that_rounding_hides_changes_nothing() {
    let length = CharacteristicLength::Given(Estimate::exact(0.035, "test"));
    let with_se = |se: f64| {
        let friction = Estimate { se, ..Estimate::exact(0.25, "test") };
        Analytical::new(friction, length.clone(), Matrix3::zeros()).unwrap()
    };
    let shape = Arc::new(Shape::square(0.09).unwrap());
    let step = StepInput::on_edge(shape, 0.00475, 1, 0.3, 0.8, 0.004).unwrap();
    let said =
        |model: &Analytical| model.predict(std::slice::from_ref(&step), Noise::Included).unwrap();
    for se in [1e-308, 1e-20] {
        assert_eq!(said(&with_se(se)), said(&with_se(0.0)), "{se}");
    }
    assert_ne!(said(&with_se(0.05)), said(&with_se(0.0)));
}
