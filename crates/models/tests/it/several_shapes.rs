//! One model of several outlines: what it sees of a contact, and what it knows of outlines beside.

use crate::known_steps::{inputs, nmse, spread};
use models::{
    Analytical, GpPushModel, Hybrid, ModelError, ModelFile, Noise, PushModel, StepFeatures,
    StepInput, StepObservation, Training, Weights,
};
use nalgebra::Vector3;
use planar::{Ellipse, MitObject, Shape, mit_object};
use sha2::{Digest, Sha256};
use std::sync::Arc;

const CONTACT: StepFeatures = StepFeatures { contact: true, speed: false, normal: false };

fn mit(name: &str) -> Shape {
    let MitObject { shape, .. } = mit_object(name).unwrap();
    shape
}

/// Steps all round an outline, of the analytical model with a little noise.
fn steps(shape: Shape, n: usize) -> Vec<StepObservation> {
    let (shape, model) = (Arc::new(shape), Analytical::nominal(0.25).unwrap());
    let step = |k: usize| {
        let (p, beta) = (spread(k, 0.7548776662), 1.6 * spread(k, 0.5698402909) - 0.8);
        let edge = k % shape.n_edges();
        let input = StepInput::on_edge(shape.clone(), 0.00475, edge, p, beta, 0.004).unwrap();
        let noise = |ratio: f64| spread(7 * k, ratio) - 0.5;
        let noise = Vector3::new(5e-5 * noise(0.31), 5e-5 * noise(0.47), 1e-3 * noise(0.83));
        StepObservation { outputs: input.outputs(&model.motion(&input).unwrap()) + noise, input }
    };
    (0..n).map(step).collect()
}

fn learn(steps: &[StepObservation], features: StepFeatures) -> GpPushModel {
    GpPushModel::train(steps, &Training { features, ..Training::default() }).unwrap().0
}

#[test]
fn outlines_learnt_together_are_told_apart_by_contact_and_curvature() {
    let shapes = ["rect1", "ellip2", "tri1"].map(|name| steps(mit(name), 240));
    let train: Vec<_> = shapes.iter().flat_map(|own| own[..100].to_vec()).collect();
    let (plain, contact) = (learn(&train, StepFeatures::default()), learn(&train, CONTACT));
    for own in &shapes {
        let [plain, contact] = [&plain, &contact].map(|model| nmse(model, &own[100..]));
        assert!(contact < 0.5 * plain && contact < 0.05, "{contact} {plain}");
    }
    let other = steps(mit("hex"), 120);
    assert!(nmse(&contact, &other) < 0.1, "{}", nmse(&contact, &other));
    let refused = plain.predict(&inputs(&other), Noise::Excluded);
    assert!(matches!(refused, Err(ModelError::UnknownOutline { n_known: 3 })));
}

#[test]
fn a_disc_is_the_same_all_round() {
    let disc = || Shape::Ellipse(Ellipse::disc(0.045).unwrap());
    let train = [steps(disc(), 60), steps(Shape::square(0.09).unwrap(), 60)].concat();
    let model = learn(&train, CONTACT);
    let shape = Arc::new(disc());
    let at = |p: f64| StepInput::on_edge(shape.clone(), 0.00475, 0, p, 0.4, 0.004).unwrap();
    let said = model.predict(&[at(0.05), at(0.4), at(0.93)], Noise::Included).unwrap();
    for other in &said[1..] {
        assert!((other.mean - said[0].mean).norm() < 1e-9);
        assert!((other.covariance - said[0].covariance).norm() < 1e-9);
    }
}

#[test]
fn a_turn_about_a_centroid_apart_from_the_origin_ties_the_outputs_together() {
    let steps = steps(mit("tri1"), 120);
    let model = learn(&steps, CONTACT);
    let said = model.predict(&inputs(&steps), Noise::Included).unwrap();
    for said in &said {
        let covariance = said.covariance;
        assert_eq!(covariance, covariance.transpose());
        assert!(covariance.symmetric_eigenvalues().min() > 0.0);
    }
    // The origin of the data set's triangle is its corner: what turns, moves it.
    assert!(said.iter().any(|said| said.covariance[(0, 2)].abs() > 1e-9));
    let parts = model.parts(&inputs(&steps)).unwrap();
    let apart = |i: usize| (parts[i].unexplained - said[i].mean).norm();
    assert!((0..steps.len()).all(|i| apart(i) < 1e-12));
}

#[test]
fn a_model_of_contacts_comes_back_from_its_file_alone_and_beside_physics() {
    let folder = tempfile::tempdir().unwrap();
    let steps = [steps(mit("tri1"), 60), steps(mit("ellip2"), 60)].concat();
    let training = Training { features: CONTACT, ..Training::default() };
    let base = Analytical::nominal(0.4).unwrap().describe().unwrap();
    let (hybrid, _) = Hybrid::train(&base, None, &steps, &training).unwrap();
    for model in [Box::new(learn(&steps, CONTACT)) as Box<dyn PushModel>, Box::new(hybrid)] {
        assert!(nmse(&*model, &steps) < 0.05);
        let path = folder.path().join("model.toml");
        let description = model.describe().unwrap();
        ModelFile::new("shapes", description).write(&path).unwrap();
        let back = ModelFile::read(&path).unwrap().description.build().unwrap();
        let asked = inputs(&steps[50..70]);
        let [one, two] = [&model, &back].map(|m| m.predict(&asked, Noise::Included).unwrap());
        assert_eq!(one, two);
    }
}

/// Schema 2 called the orthogonal discrepancy `beside_physics`.
#[test]
fn weights_of_schema_2_are_read_and_of_others_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (path, steps) = (folder.path().join("model.toml"), steps(mit("tri1"), 60));
    let base = Analytical::nominal(0.4).unwrap().describe().unwrap();
    let training = Training { features: CONTACT, ..Training::default() };
    let (hybrid, _) = Hybrid::train(&base, None, &steps, &training).unwrap();
    let description = hybrid.describe().unwrap();
    let file = ModelFile::new("tri1", description);
    let read_as = |schema: &str, key: &str| {
        let weights = file.description.weights.as_ref().unwrap();
        let now = serde_json::to_string(weights).unwrap();
        assert!(now.contains("\"orthogonal_discrepancy\":") && now.contains(Weights::SCHEMA));
        let old = now.replace(Weights::SCHEMA, schema).replace("orthogonal_discrepancy", key);
        file.write(&path).unwrap();
        let model = std::fs::read_to_string(&path).unwrap();
        let line = |start: &str| model.lines().find(|line| line.starts_with(start)).unwrap();
        let (sha256, name) = (line("sha256 = "), line("weights = ").split('"').nth(1).unwrap());
        std::fs::write(folder.path().join(name), &old).unwrap();
        let model = model.replace(sha256, &format!("sha256 = \"{:x}\"", Sha256::digest(&old)));
        std::fs::write(&path, model).unwrap();
        ModelFile::read(&path).map(|file| file.description.build().unwrap())
    };
    let back = read_as("pushlab.weights/2", "beside_physics").unwrap();
    let asked = inputs(&steps[20..40]);
    let [one, two] =
        [&hybrid as &dyn PushModel, &*back].map(|m| m.predict(&asked, Noise::Included).unwrap());
    assert_eq!(one, two);
    let refused = read_as("pushlab.weights/1", "beside_physics").err().unwrap().to_string();
    assert!(
        refused.contains("reads pushlab.weights/2, pushlab.weights/3, pushlab.weights/4"),
        "{refused}"
    );
}
