//! `docs/model.schema.json` against the files that are written and the rules of the reader.

use dataset::{ObjectChoice, ObjectSpec, PusherSpec, SupportSpec};
use models::{
    Analytical, Calibration, CharacteristicLength, Cluster, ContactGap, Description,
    EffectiveSurface, EndCheck, Estimate, GpPushModel, Hybrid, MadeFor, ModelEffect, ModelFile,
    ProcessKind, PushModel, Split, StepCorrelation, StepFeatures, StepInput, StepObservation,
    SurfaceKind, Training, learn_options, model_kinds,
};
use nalgebra::{Matrix3, Vector3};
use planar::Shape;
use serde_json::{Value, json};
use std::sync::Arc;

fn schema() -> Value {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/model.schema.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Whether a value obeys a schema made of the words that ours uses.
fn obeys(value: &Value, schema: &Value, root: &Value) -> bool {
    let Value::Object(rules) = schema else { return schema.as_bool().unwrap() };
    rules.iter().all(|(word, rule)| obeys_word(value, word, rule, rules, root))
}

fn obeys_word(
    value: &Value,
    word: &str,
    rule: &Value,
    rules: &serde_json::Map<String, Value>,
    root: &Value,
) -> bool {
    let length = || match value {
        Value::Array(items) => items.len() as u64,
        Value::String(text) => text.chars().count() as u64,
        _ => 0,
    };
    match word {
        "$schema" | "$id" | "$defs" | "title" | "description" | "default" => true,
        "$ref" => obeys(value, root.pointer(&rule.as_str().unwrap()[1..]).unwrap(), root),
        "const" => value == rule,
        "enum" => rule.as_array().unwrap().contains(value),
        "type" => match rule.as_str().unwrap() {
            "object" => value.is_object(),
            "array" => value.is_array(),
            "string" => value.is_string(),
            "integer" => value.is_i64(),
            "number" => value.is_number(),
            other => panic!("type {other}"),
        },
        "minimum" => value.as_f64().is_none_or(|number| number >= rule.as_f64().unwrap()),
        "maximum" => value.as_f64().is_none_or(|number| number <= rule.as_f64().unwrap()),
        "minItems" | "minLength" => length() >= rule.as_u64().unwrap(),
        "maxItems" | "maxLength" => length() <= rule.as_u64().unwrap(),
        "items" => value.as_array().unwrap().iter().all(|item| obeys(item, rule, root)),
        "required" => {
            rule.as_array().unwrap().iter().all(|key| value.get(key.as_str().unwrap()).is_some())
        }
        "properties" => rule
            .as_object()
            .unwrap()
            .iter()
            .all(|(key, rule)| value.get(key).is_none_or(|value| obeys(value, rule, root))),
        "additionalProperties" => {
            let known = |key: &str| rules.get("properties").is_some_and(|of| of.get(key).is_some());
            let of = value.as_object();
            of.is_none_or(|of| of.iter().all(|(key, item)| known(key) || obeys(item, rule, root)))
        }
        "oneOf" => {
            rule.as_array().unwrap().iter().filter(|rule| obeys(value, rule, root)).count() == 1
        }
        other => panic!("the schema uses {other}, which this test does not know"),
    }
}

/// A description as the JSON of its `model.toml`.
fn written(description: &Description) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.toml");
    let description = description.clone();
    let split = Some(Split {
        set: "00ff".into(),
        seed: 7,
        cluster: Cluster::Push,
        fit: vec!["push-0#0".into(), "push-0#1".into()],
        confirm: vec!["push-1#0".into()],
        confirm_set: Some("ff00".into()),
    });
    let object = ObjectChoice::Fixed(Box::new(ObjectSpec::mit("hex").unwrap()));
    let pusher = PusherSpec { radius: 0.00475, friction: 0.25 };
    let support = SupportSpec { friction: 0.25, gravity: 9.81 };
    let made_for = Some(MadeFor::new("hexagons", &object, pusher, support));
    let calibration = Some(calibration());
    let file = ModelFile { split, made_for, calibration, ..ModelFile::new("x", description) };
    file.write(&path).unwrap();
    assert_eq!(ModelFile::read(&path).unwrap(), file);
    toml::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap()
}

fn calibration() -> Calibration {
    let correlation = StepCorrelation {
        held: [0.4, 0.0, 1.25],
        length: 0.0625,
        own: [0.0; 3],
        freedom: 5.5,
        measured: [0.0, 0.0, 0.125],
        gap: ContactGap { offset: -1e-5, kept: 0.5, sd: 2e-5 },
        n_pushes: 40,
        n_steps: 400,
        ends: Some(EndCheck { n_pushes: 40, n_within: [20, 36, 38] }),
    };
    Calibration {
        n_pushes: 40,
        widened: Some(1.6),
        scatter_per_m: Some([[0.25, 0.0, 0.125], [0.0, 0.5, 0.0], [0.125, 0.0, 2.0]]),
        correlation: Some(correlation),
    }
}

#[test]
fn a_calibration_that_no_measurement_gives_is_refused_by_its_key() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.toml");
    let description = Analytical::nominal(0.25).unwrap().describe().unwrap();
    let refused = |change: &dyn Fn(&mut Calibration)| {
        let mut calibration = calibration();
        change(&mut calibration);
        let file = ModelFile {
            calibration: Some(calibration),
            ..ModelFile::new("x", description.clone())
        };
        file.write(&path).unwrap();
        ModelFile::read(&path).unwrap_err().to_string()
    };
    let expected = [
        (refused(&|of| of.widened = Some(0.0)), "calibration.widened", "0.0"),
        (
            refused(&|of| of.scatter_per_m = Some([[-1.0, 0.0, 0.0], [0.0; 3], [0.0; 3]])),
            "calibration.scatter_per_m",
            "positive semi-definite",
        ),
        (
            refused(&|of| of.correlation.as_mut().unwrap().own[1] = -0.5),
            "calibration.correlation.own",
            "-0.5",
        ),
        (
            refused(&|of| of.correlation.as_mut().unwrap().length = f64::INFINITY),
            "calibration.correlation.length",
            "inf",
        ),
        (
            refused(&|of| of.correlation.as_mut().unwrap().gap.kept = f64::NAN),
            "calibration.correlation.gap.kept",
            "NaN",
        ),
    ];
    for (error, key, value) in expected {
        let names = error.contains(key) && error.contains(value) && error.contains("model.toml");
        assert!(names, "{error}");
    }
}

fn models() -> Vec<Box<dyn PushModel>> {
    let nominal = Analytical::nominal(0.25).unwrap();
    let shape = Arc::new(Shape::square(0.09).unwrap());
    let step = |k: u32| {
        let (p, beta) = (f64::from(k) / 20.0, f64::from(k * 7 % 20) / 20.0 - 0.5);
        let bare = StepInput::on_edge(shape.clone(), 0.005, 1, p, beta, 0.004).unwrap();
        let input = bare.lasting(0.1 + 0.01 * f64::from(k * 11 % 20)).unwrap();
        let noise = 1e-5 * f64::from(k * 13 % 7);
        let outputs = input.outputs(&nominal.motion(&input).unwrap()) + Vector3::repeat(noise);
        StepObservation { input, outputs }
    };
    let steps: Vec<_> = (0..=20).map(step).collect();
    let features = StepFeatures { speed: true, ..StepFeatures::default() };
    let training = Training { features, ..Training::with(ProcessKind::Rff) };
    let length = CharacteristicLength::Given(Estimate::exact(0.035, "test"));
    let given = Analytical::new(Estimate::exact(0.2, "test"), length, Matrix3::identity());
    let on = |surface| nominal.clone().with_surface(surface).unwrap();
    vec![
        Box::new(nominal.clone()),
        Box::new(given.unwrap()),
        Box::new(on(SurfaceKind::UniformPatch)),
        Box::new(on(SurfaceKind::Points { n_points: 9 })),
        Box::new(on(SurfaceKind::named("quartic").unwrap())),
        Box::new(on(SurfaceKind::Effective(round()))),
        Box::new(GpPushModel::learn(&steps, &learn_options()).unwrap().0),
        Box::new(Hybrid::learn(nominal.clone(), &steps, &learn_options()).unwrap().0),
        Box::new(Hybrid::train(&nominal.describe().unwrap(), None, &steps, &training).unwrap().0),
        Box::new(GpPushModel::train(&steps, &training).unwrap().0),
    ]
}

/// The quartic that is an ellipsoid.
fn round() -> EffectiveSurface {
    let ellipsoid = mechanics::Ellipsoid::new(2.0, 0.07).unwrap();
    let quartic = mechanics::Quartic::from_ellipsoid(&ellipsoid).unwrap();
    EffectiveSurface::new(*quartic.coefficients(), 0.035).unwrap()
}

#[test]
fn a_measured_surface_moves_objects_and_is_refused_where_it_cannot_be() {
    let nominal = Analytical::nominal(0.25).unwrap();
    let length = CharacteristicLength::Given(Estimate::exact(0.035, "test"));
    let given = Analytical::new(Estimate::exact(0.25, ""), length, Matrix3::zeros()).unwrap();
    let measured = nominal.with_surface(SurfaceKind::Effective(round())).unwrap();
    let shape = Arc::new(Shape::square(0.09).unwrap());
    for (p, beta) in [(0.2, 0.3), (0.5, -0.6), (0.9, 0.1)] {
        let input = StepInput::on_edge(shape.clone(), 0.005, 1, p, beta, 0.004).unwrap();
        let (one, other) = (measured.motion(&input).unwrap(), given.motion(&input).unwrap());
        assert!((one.position - other.position).norm() < 1e-8, "{one:?} {other:?}");
        assert!((one.angle - other.angle).abs() < 1e-7, "{one:?} {other:?}");
    }
    let good = written(&measured.describe().unwrap());
    let schema = schema();
    let hollow: Vec<f64> = (0..15).map(|k| f64::from(u8::from([0, 10, 14].contains(&k)))).collect();
    let hollow: Vec<f64> =
        hollow.iter().enumerate().map(|(k, c)| if k == 3 { 20.0 } else { *c }).collect();
    for (key, value, is_of_schema) in [
        ("pressure", json!("uniform"), true),
        ("limit_surface", json!("quartic"), true),
        ("quartic", json!({ "length": 0.03, "coefficients": [1.0, 2.0] }), true),
        ("quartic", json!({ "length": 0.03, "coefficients": hollow }), false),
        (
            "quartic",
            json!({ "length": -0.03, "coefficients": good["base"]["quartic"]["coefficients"] }),
            true,
        ),
    ] {
        let mut file = good.clone();
        file["base"][key] = value;
        assert!(!is_of_schema || !obeys(&file, &schema, &schema), "{key}");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.toml");
        std::fs::write(&path, toml::to_string(&file).unwrap()).unwrap();
        let error = ModelFile::read(&path).unwrap_err().to_string();
        assert!(error.contains("model.toml"), "{key}: {error}");
    }
}

#[test]
fn a_file_with_every_effect_obeys_the_schema() {
    let schema = schema();
    let rig = effects::Rig::new(effects::Surface::Ellipsoid, 0.25, 0.25).unwrap();
    let setting = |effect: &Arc<dyn effects::Effect>| {
        let about = effect.info();
        ModelEffect::from(effects::Setting::new(about, &about.typical(&rig)))
    };
    let nominal = Analytical::nominal(0.25).unwrap().describe().unwrap();
    let effects = effects::all().iter().map(setting).collect();
    let file = written(&Description { effects, ..nominal });
    assert!(obeys(&file, &schema, &schema), "{file:#}");
    let ids: Vec<_> = effects::all().iter().map(|effect| effect.info().id).collect();
    assert_eq!(schema.pointer("/$defs/effect/properties/id/enum").unwrap(), &json!(ids));
}

#[test]
fn every_file_that_is_written_obeys_the_schema() {
    let schema = schema();
    for model in models() {
        let file = written(&model.describe().unwrap());
        assert!(obeys(&file, &schema, &schema), "{file:#}");
    }
}

#[test]
fn the_schema_refuses_what_the_reader_refuses() {
    let schema = schema();
    let good = written(&Analytical::nominal(0.25).unwrap().describe().unwrap());
    for (pointer, key, value) in [
        ("", "schema", json!("pushlab.model/9")),
        ("", "effects", json!([{ "id": "table-tilt" }])),
        ("", "effects", json!([{ "id": "oracle", "parameters": {} }])),
        ("", "effects", json!([{ "id": "inertia", "parameters": { "kappa": 1.0 } }])),
        ("", "effects", json!([{ "id": "inertia", "parameters": { "kappa": { "value": "on" } } }])),
        ("", "extra", json!(1)),
        ("", "learned", json!({})),
        ("", "learned", json!({ "weights": "w", "sha256": "0", "inputs": ["beta_rad", "p"] })),
        ("", "split", json!({ "set": "", "seed": 7, "cluster": "push", "fit": ["a#0"] })),
        ("", "made_for", json!({ "set": "squares" })),
        ("/made_for", "pusher_radius_m", json!(-0.005)),
        ("/made_for", "pusher", json!("steel")),
        ("/made_for/object", "mass_kg", json!(-1.0)),
        ("/made_for/object", "size_m", json!([0.09])),
        ("/split", "cluster", json!("block")),
        ("/split", "confirm", json!([])),
        ("/split", "seed", json!(-1)),
        ("/base", "kind", json!("oracle")),
        ("/base", "kind", json!("gp")),
        ("/base", "kind", json!("hybrid")),
        ("/base", "limit_surface", json!("sphere")),
        ("/base", "pressure", json!("rim")),
        ("/base", "n_points", json!(9)),
        ("/base", "characteristic_length", json!({ "value": 0.03 })),
        ("/base", "scatter_per_m", json!([[1.0, 0.0, 0.0]])),
        ("/base/pusher_friction", "value", json!(-0.25)),
        ("/base/pusher_friction", "value", json!(1e308)),
        ("/base/pusher_friction", "se", json!(-1e9)),
        ("/base/pusher_friction", "se", json!(1e308)),
        ("/base/pusher_friction", "se", json!("small")),
        ("/base/pusher_friction", "sd", json!(0.0)),
    ] {
        let mut file = good.clone();
        file.pointer_mut(pointer).unwrap()[key] = value;
        assert!(!obeys(&file, &schema, &schema), "{pointer}/{key}");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.toml");
        std::fs::write(&path, toml::to_string(&file).unwrap()).unwrap();
        assert!(ModelFile::read(&path).is_err(), "{pointer}/{key}");
    }
}

#[test]
fn what_a_model_was_made_for_is_checked_with_its_line_and_may_be_left_out() {
    let good = written(&Analytical::nominal(0.25).unwrap().describe().unwrap());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.toml");
    let mut file = good.clone();
    file["made_for"]["object"]["mass_kg"] = json!(0.0);
    let text = toml::to_string(&file).unwrap();
    let line = 1 + text.lines().position(|line| line == "[made_for]").unwrap();
    std::fs::write(&path, &text).unwrap();
    let message = ModelFile::read(&path).unwrap_err().to_string();
    let expected = "made_for.object.mass_kg: must be positive and finite, got 0.0";
    assert!(
        message.contains(&format!("model.toml:{line}:")) && message.contains(expected),
        "{message}"
    );
    file.as_object_mut().unwrap().remove("made_for");
    std::fs::write(&path, toml::to_string(&file).unwrap()).unwrap();
    assert_eq!(ModelFile::read(&path).unwrap().made_for, None);
}

#[test]
fn the_schema_lists_the_kinds_and_surfaces_that_there_are() {
    let schema = schema();
    let kinds: Vec<_> = model_kinds().iter().map(|kind| kind.id).collect();
    assert_eq!(schema.pointer("/$defs/base/properties/kind/enum").unwrap(), &json!(kinds));
    let names = SurfaceKind::all().map(SurfaceKind::name);
    let names: Vec<_> = names.chain([SurfaceKind::EFFECTIVE]).collect();
    let surfaces = schema.pointer("/$defs/base/properties/limit_surface/enum").unwrap();
    assert_eq!(surfaces, &json!(names));
}
