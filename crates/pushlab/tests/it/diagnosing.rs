//! `pushlab diagnose` on recordings whose truth is known.

use serde_json::{Value, json};

use crate::schema;
use crate::small_set::SmallSet;

/// A set with something hidden in it, or nothing, and the nominal model.
fn generated(hidden: &[&str], more: &[&str]) -> SmallSet {
    let set = SmallSet::new();
    let hidden = hidden.iter().flat_map(|effect| ["--hidden", effect]);
    let words = ["generate", "-o", "pushes", "--seed", "11", "--pushes", "72", "--rig", "quiet"];
    let words: Vec<&str> = words.into_iter().chain(hidden).chain(more.iter().copied()).collect();
    set.done(&words);
    set.done(&["models", "init", "pushes"]);
    set
}

fn diagnosed(set: &SmallSet) -> Value {
    let run = set.done(&["diagnose", "pushes", "-o", "diagnosis.json", "--json", "--force"]);
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(schema::fault(&found, &schema::diagnosis()), None);
    assert_eq!(serde_json::from_str::<Value>(&set.read("diagnosis.json")).unwrap(), found);
    found
}

fn effect<'a>(found: &'a Value, id: &str) -> &'a Value {
    found["effects"].as_array().unwrap().iter().find(|effect| effect["id"] == id).unwrap()
}

#[test]
fn a_hidden_effect_is_named_with_its_size_and_closes_the_gap() {
    let set = generated(&["table-anisotropy: ratio=1.3, direction_deg=34"], &[]);
    let found = diagnosed(&set);
    assert_eq!(found["verdict"], "identified", "{}", found["sentence"]);
    let named: Vec<&str> =
        found["identified"].as_array().unwrap().iter().map(|id| id.as_str().unwrap()).collect();
    assert_eq!(named, ["table-anisotropy", "limit-surface-shape"]);
    let anisotropy = effect(&found, "table-anisotropy");
    assert_eq!(anisotropy["grade"], "identified");
    for (index, truth) in [(0, 1.3), (1, 34_f64.to_radians())] {
        let parameter = &anisotropy["parameters"][index];
        let [low, high] = ["low95", "high95"].map(|end| parameter[end].as_f64().unwrap());
        // The simulator's push is not the model's to better than one percent.
        let tolerance = 0.01 * truth;
        assert!(low - tolerance < truth && truth < high + tolerance, "{parameter}");
        assert!(high - low < 0.1 * truth, "{parameter}");
    }
    let error = &found["error"];
    let [before, after] = ["before", "after"].map(|key| error[key].as_f64().unwrap());
    assert!(before > 3.0 && after < 1.5, "{error}");
    assert!(error["gap_closed"].as_f64().unwrap() > 0.85, "{error}");
}

/// Friction that suits one side is where the fit stays if nothing looks farther.
#[test]
fn friction_that_differs_by_side_is_named_beside_friction_that_suits_one_side() {
    let set = SmallSet::new();
    let hidden = "pusher-friction-asymmetry";
    let words = ["generate", "-o", "pushes", "--rig", "quiet", "--seed", "530012", "-n", "60"];
    set.done(&[&words[..], &["--hidden", hidden]].concat());
    set.done(&["models", "init", "pushes"]);
    let found = diagnosed(&set);
    let identified = found["identified"].as_array().unwrap();
    assert!(identified.contains(&json!(hidden)), "{}", found["sentence"]);
    let asymmetry = effect(&found, hidden)["parameters"][0]["estimate"].as_f64().unwrap();
    assert!((asymmetry - 0.2).abs() < 0.01, "{asymmetry}");
}

#[test]
fn nothing_is_named_where_nothing_is_missing() {
    let set = generated(&[], &[]);
    set.done(&["add", "limit-surface-shape", "--set", "lambda=1", "-o", "patch.toml"]);
    let run = set.done(&["diagnose", "pushes", "--model", "patch.toml", "--json"]);
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(found["ambiguous"], json!([]));
    // The center of friction that is drawn for each push has a mean, which the pushes share.
    let shared = mean_center(&set);
    for id in ["identified", "effective"].iter().flat_map(|of| found[of].as_array().unwrap()) {
        assert_eq!(id, "friction-center-offset", "{}", found["sentence"]);
        for (parameter, shared) in effect(&found, "friction-center-offset")["parameters"]
            .as_array()
            .unwrap()
            .iter()
            .zip(shared)
        {
            let [low, high] = ["low95", "high95"].map(|end| parameter[end].as_f64().unwrap());
            assert!((low..high).contains(&shared), "{parameter} {shared}");
        }
    }
    let after = found["error"]["after"].as_f64().unwrap();
    assert!((0.7..1.4).contains(&after), "{after}");
    assert!(effect(&found, "table-anisotropy")["grade"] != "identified");
}

/// The mean over pushes of the center of friction that was drawn for each, in m.
fn mean_center(set: &SmallSet) -> [f64; 2] {
    let truth: toml::Value = toml::from_str(&set.read("pushes.truth.toml")).unwrap();
    let pushes = truth["pushes"].as_array().unwrap();
    let of = |push: &toml::Value, axis: usize| {
        push["variation"]["pressure_shift"][axis].as_float().unwrap()
    };
    [0, 1].map(|axis| pushes.iter().map(|push| of(push, axis)).sum::<f64>() / pushes.len() as f64)
}

#[test]
fn what_a_diagnosis_cannot_start_from_is_told() {
    let set = SmallSet::new();
    let message = set.error(&["diagnose", "set"]);
    assert!(message.contains("model.toml") && message.contains("models init"), "{message}");
    set.done(&["models", "init", "set"]);
    let message = set.error(&["diagnose", "set"]);
    assert!(message.contains("pushes"), "{message}");
}

/// `compare` says of the model with what was found what the diagnosis says, and of the one before.
fn is_one_error(found: &Value, compared: &Value) {
    for (k, name) in ["dx_m", "dy_m", "dtheta_rad", "force_normal_n"].into_iter().enumerate() {
        let change = &compared["against"]["changes"][k];
        for (told, seen) in [("before_si", "before"), ("after_si", "after")] {
            let pair = [&found["error"][told][name], &change[seen]];
            let [told, seen] = pair.map(|value| value.as_f64().unwrap());
            assert!((told - seen).abs() < 1e-9 * seen, "{name}: {told} {seen}");
        }
    }
}

/// No effect is left without a reason, and what to type next is told.
fn is_answered(found: &Value) {
    for effect in found["effects"].as_array().unwrap() {
        assert!(!effect["why"].as_str().unwrap().is_empty(), "{effect}");
    }
    let next: Vec<_> =
        found["next"].as_array().unwrap().iter().map(|next| next.as_str().unwrap()).collect();
    assert_eq!(
        next[..2],
        [
            "pushlab add --all --from d.json --model patch.toml -o better.toml",
            "pushlab compare two --model better.toml --against patch.toml",
        ]
    );
}

#[test]
fn a_second_set_confirms_what_is_fitted_to_all_of_the_first() {
    let set = SmallSet::new();
    let hidden = "table-anisotropy: ratio=1.3, direction_deg=34";
    for (name, seed, pushes) in [("one", "11", "48"), ("two", "12", "16")] {
        let words = ["generate", "-o", name, "--rig", "quiet", "--seed", seed, "--pushes", pushes];
        set.done(&[&words[..], &["--hidden", hidden]].concat());
    }
    set.done(&["models", "init", "one"]);
    set.done(&["add", "limit-surface-shape", "--set", "lambda=1", "-o", "patch.toml"]);
    let words = ["diagnose", "one", "--model", "patch.toml", "--confirm"];
    let run = set.done(&[&words[..], &["two", "-o", "d.json", "--json"]].concat());
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(schema::fault(&found, &schema::diagnosis()), None);
    assert_eq!(found["identified"], json!(["table-anisotropy"]), "{}", found["sentence"]);
    let split = &found["split"];
    let n = |part: &str| split[part].as_array().unwrap().len();
    assert_eq!((n("fit"), n("confirm"), &found["data"]["pushes_used"]), (48, 16, &json!(64)));
    assert!(split["confirm_set"] != split["set"]);
    set.done(&["add", "--from", "d.json", "--model", "patch.toml", "-o", "better.toml"]);
    let against = ["--model", "better.toml", "--against", "patch.toml", "--json"];
    let compared = set.done(&[&["compare", "two"], &against[..]].concat());
    let compared: Value = serde_json::from_str(&compared.stdout).unwrap();
    assert_eq!(compared["n_pushes"], 16);
    let turn = &compared["against"]["changes"][2];
    let [before, after] = ["before", "after"].map(|key| turn[key].as_f64().unwrap());
    assert!(after < 0.5 * before, "{turn}");
    is_one_error(&found, &compared);
    is_answered(&found);
    // No push of the first set is unseen, none may be in both, and the rig has to be the same.
    assert!(
        set.error(&[&["compare", "one"], &against[..]].concat())
            .contains("the held-out pushes are too few")
    );
    assert!(set.error(&["diagnose", "one", "--model", "better.toml"]).contains("--confirm"));
    let refused = |second: &str| set.error(&[&words[..], &[second]].concat());
    assert!(refused("one").contains("is in one, too"));
    set.done(&["generate", "-o", "other", "--shape", "tri1", "--pushes", "8"]);
    assert!(refused("other").contains("its object has another outline"));
}

/// Pushes of edge 0 in one orientation at three places, fifteen of each.
fn alike_pushes() -> String {
    let header = "edge,p,angle_deg,speed_mm_s,travel_mm,x_mm,y_mm,theta_deg,repeat";
    let places = [("0.35", "a"), ("0.5", "b"), ("0.65", "c")];
    let push = |(p, repeat): &(&str, &str)| format!("0,{p},0,20,25,0,0,0,{repeat}");
    let lines = places.iter().cycle().take(45).map(push);
    [header.to_owned()].into_iter().chain(lines).collect::<Vec<_>>().join("\n")
}

/// The lines of a list of pushes by the columns of another.
fn as_columns(list: &str, header: &str) -> Vec<String> {
    let mut lines = list.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let place = |name: &str| names.iter().position(|known| *known == name).unwrap();
    let places: Vec<usize> = header.split(',').map(place).collect();
    let line = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        places.iter().map(|place| cells[*place]).collect::<Vec<_>>().join(",")
    };
    lines.map(line).collect()
}

#[test]
fn what_alike_pushes_leave_open_the_suggested_ones_decide() {
    const TRUTH: &str = "friction-center-offset";
    let set = SmallSet::new();
    set.write("rig.toml", "[sensors.force]\nrate = 0.0\n");
    set.write("alike.csv", &alike_pushes());
    let generate = |name: &str, design: &str, seed: &str| {
        let words = [
            "generate",
            "-o",
            name,
            "--rig",
            "quiet",
            "--settings",
            "rig.toml",
            "--design",
            design,
        ];
        set.done(&[&words[..], &["--seed", seed, "--hidden", TRUTH, "--format", "csv"]].concat());
    };
    generate("few", "alike.csv", "302");
    set.done(&["models", "init", "few"]);
    set.done(&["add", "limit-surface-shape", "--set", "lambda=1", "-o", "patch.toml"]);
    let diagnose = |name: &str| {
        let words =
            ["diagnose", name, "--model", "patch.toml", "-o", "d.json", "--json", "--force"];
        serde_json::from_str::<Value>(&set.done(&words).stdout).unwrap()
    };
    let found = diagnose("few");
    assert_eq!(found["verdict"], "ambiguous", "{}", found["sentence"]);
    assert_eq!(found["identified"], json!([]));
    let groups = found["ambiguous"].as_array().unwrap();
    assert_eq!(groups.len(), 1, "{}", found["ambiguous"]);
    let members: Vec<&str> =
        groups[0].as_array().unwrap().iter().map(|id| id.as_str().unwrap()).collect();
    assert!(members.len() > 1 && members.contains(&TRUTH), "{members:?}");
    for member in &members {
        let finding = effect(&found, member);
        assert_eq!(finding["grade"], "ambiguous");
        assert!(finding["parameters"][0]["estimate"].is_number(), "{finding}");
    }

    let words = ["suggest", "few", "--from", "d.json", "--model", "patch.toml", "-n", "20"];
    set.done(&[&words[..], &["--area", "-100,100,-100,100", "-o", "more.csv"]].concat());
    let alike = alike_pushes();
    let header = alike.lines().next().unwrap();
    let both = [alike.clone(), as_columns(&set.read("more.csv"), header).join("\n")].join("\n");
    set.write("both.csv", &both);
    generate("more", "both.csv", "303");
    let found = diagnose("more");
    assert_eq!((&found["identified"], &found["ambiguous"]), (&json!([TRUTH]), &json!([])));
    for (index, truth) in [(0, 8e-3), (1, -4e-3)] {
        let parameter = &effect(&found, TRUTH)["parameters"][index];
        let [low, high] = ["low95", "high95"].map(|end| parameter[end].as_f64().unwrap());
        let tolerance = 1e-4;
        assert!(low - tolerance < truth && truth < high + tolerance, "{parameter}");
    }
    assert!(found["error"]["gap_closed"].as_f64().unwrap() > 0.9, "{}", found["error"]);
}
