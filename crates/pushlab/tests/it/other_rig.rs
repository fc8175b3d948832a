//! A model that was made for one object, used on another.

use serde_json::Value;

use crate::comparison::pushes;
use crate::small_set::SmallSet;

/// The sixty pushes, and the same said to be of another object and pusher.
fn two_rigs() -> SmallSet {
    let set = pushes();
    crate::documentation::copy(&set.path("pushes"), &set.path("others"));
    set.edit("others/dataset.toml", "mass_kg = 0.8374", "mass_kg = 1.2");
    set.edit("others/dataset.toml", "radius_m = 0.00475", "radius_m = 0.005");
    set
}

fn warnings(set: &SmallSet, arguments: &[&str]) -> Vec<String> {
    let run = set.done(&[arguments, &["--json"]].concat());
    let document: Value = serde_json::from_str(&run.stdout).unwrap();
    let told = document["warnings"].as_array().unwrap().iter();
    let told = told.map(|warning| warning.as_str().unwrap().to_owned());
    told.filter(|warning| warning.contains("was made for another rig")).collect()
}

#[test]
fn what_differs_is_said_once_with_both_values_and_nothing_where_nothing_differs() {
    let set = two_rigs();
    let simulate = ["--particles", "10", "-n", "1", "--correlation", "none", "-o", "out"];
    for (command, rest) in [
        ("compare", &["--against", "model.toml"][..]),
        ("report", &["--force"]),
        ("check", &["--model", "model.toml"]),
        ("simulate", &simulate),
    ] {
        let of = |name: &str| {
            let found = warnings(&set, &[&[command, name], rest].concat());
            let _ = std::fs::remove_dir_all(set.path("out"));
            found
        };
        assert_eq!(of("pushes"), Vec::<String>::new(), "{command}");
        let told = of("others");
        assert_eq!(told.len(), 1, "{command}: {told:?}");
        let differs = "mass 0.8374 kg there, 1.2 kg here; pusher radius 4.75 mm there, 5 mm here;";
        assert!(
            told[0].starts_with("model.toml was made") && told[0].contains(differs),
            "{told:?}"
        );
    }
    let text = set.read("model.toml");
    let start = text.find("[made_for]").unwrap();
    set.write("model.toml", &text[..start]);
    let old = warnings(&set, &["compare", "others"]);
    assert!(old.is_empty(), "a file of before tells nothing: {old:?}");
}

#[test]
fn a_fit_and_a_training_make_a_model_for_what_they_read() {
    let set = two_rigs();
    let fit = ["fit", "others", "--free", "pusher-friction", "-o", "fitted.toml"];
    set.done(&fit);
    set.done(&["train", "others", "--kind", "gp", "-n", "60", "-o", "gp.toml"]);
    let set_by_hand = ["--set", "ax=0.01", "--set", "ay=0", "-o", "tilted.toml"];
    set.done(&[&["add", "table-tilt", "--model", "fitted.toml"], &set_by_hand[..]].concat());
    for model in ["fitted.toml", "gp.toml", "tilted.toml"] {
        let table: toml::Table = set.read(model).parse().unwrap();
        assert_eq!(table["made_for"]["object"]["mass_kg"].as_float(), Some(1.2), "{model}");
        assert_eq!(table["made_for"]["pusher_radius_m"].as_float(), Some(0.005), "{model}");
        assert!(warnings(&set, &["compare", "others", "--model", model]).is_empty());
        assert_eq!(warnings(&set, &["compare", "pushes", "--model", model]).len(), 1);
    }
}
