//! `pushlab fit` and `pushlab add` on the fixture pushes, whose object stands on a uniform patch.

use std::path::Path;

use serde_json::Value;

use crate::small_set::SmallSet;

fn pushes() -> SmallSet {
    let set = SmallSet::new();
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/pushes");
    crate::documentation::copy(&from, &set.path("pushes"));
    set.done(&["models", "init", "pushes"]);
    set
}

fn result(stdout: &str) -> Value {
    serde_json::from_str::<Value>(stdout).unwrap()
}

#[test]
fn a_fitted_effect_lowers_the_error_of_pushes_that_no_fit_has_seen() {
    let set = pushes();
    let add = ["add", "limit-surface-shape", "--fit", "pushes", "-o", "better.toml", "--json"];
    let added = set.done(&add).stdout;
    let fitted = result(&added);
    let lambda = &fitted["effects"][0]["parameters"][0];
    let [value, se] = ["value", "se"].map(|key| lambda[key].as_f64().unwrap());
    assert!((value - 1.0).abs() < 3.0 * se && se < 0.05, "{lambda}");
    // The pushes stand on the exact patch, where the mixture ends: so does the interval.
    let [low, high] = ["low95", "high95"].map(|key| lambda["interval"][key].as_f64().unwrap());
    assert!(value <= 1.0 && low > 1.0 - 6.0 * se && low < value && high == 1.0, "{lambda}");
    assert_eq!((&fitted["n_pushes"], &fitted["n_kept"]), (&45.into(), &15.into()));
    let written = set.read("better.toml");
    assert!(written.contains("[split]") && written.contains("fit to 45 pushes"), "{written}");
    let compare = ["compare", "pushes", "--model", "better.toml", "--against", "model.toml"];
    let compared = result(&set.done(&[&compare[..], &["--json"]].concat()).stdout);
    assert_eq!(compared["part"]["pushes"], "confirm");
    assert_eq!(compared["n_pushes"], 15);
    let turn = &compared["against"]["changes"][2];
    let [before, after] = ["before", "after"].map(|key| turn[key].as_f64().unwrap());
    assert!(after < 0.5 * before, "{turn}");
    let again = set.done(&[&add[..], &["--jobs", "1", "--force"]].concat()).stdout;
    assert_eq!(added, again);
    assert_eq!(written, set.read("better.toml"));
    let shown = set.done(&["models", "show", "better.toml"]).stdout;
    assert!(shown.contains("15 others are kept"), "{shown}");
    // Nothing else is hidden in these pushes.
    let tilt = ["add", "table-tilt", "--fit", "pushes", "--model", "better.toml", "-o", "c.toml"];
    let message = set.error(&tilt);
    assert!(message.contains("do not tell it from nothing"), "{message}");
    assert!(!set.exists("c.toml"));
}

#[test]
fn values_beside_a_spread_are_weighted_by_what_it_leaves_and_old_scatter_goes() {
    let set = pushes();
    let add = |model: &str, to: &str| {
        let add = ["add", "pusher-friction", "--per-push", "--fit", "pushes", "--model", model];
        result(&set.done(&[&add[..], &["-o", to, "--json"]].concat()).stdout)
    };
    let fitted = add("model.toml", "spread.toml");
    assert!(!set.read("spread.toml").contains("scatter_per_m"));
    // By the noise of repeats alone it is 6.1: the ellipsoid misses the exact patch.
    let after = fitted["whitened_rms"][1].as_f64().unwrap();
    assert!((0.8..3.0).contains(&after), "{}", fitted["whitened_rms"]);
    let old = "[[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 900.0]]";
    set.edit("model.toml", "[base]", &format!("[base]\nscatter_per_m = {old}"));
    add("model.toml", "renewed.toml");
    let text = set.read("renewed.toml");
    let scatter = text.lines().find_map(|line| line.strip_prefix("scatter_per_m = ")).unwrap();
    let scatter: Vec<Vec<f64>> = serde_json::from_str(scatter).unwrap();
    // A tenth of the way, and a tenth of a degree a millimeter, at the most.
    assert!(scatter[0][0] > 0.0 && scatter[0][0] < 0.01 && scatter[2][2] < 3.0, "{scatter:?}");
}

#[test]
fn values_by_hand_are_checked_and_raise_the_error_where_they_are_wrong() {
    let set = pushes();
    let add = |values: [&'static str; 2]| {
        let [ratio, direction] = values;
        [
            "add",
            "table-anisotropy",
            "--set",
            ratio,
            "--set",
            direction,
            "-o",
            "grain.toml",
            "--force",
        ]
    };
    set.done(&add(["ratio=1.3", "direction=0.6"]));
    let compare = ["compare", "pushes", "--model", "grain.toml", "--against", "model.toml"];
    let compared = result(&set.done(&[&compare[..], &["--json"]].concat()).stdout);
    assert_eq!(compared["part"]["pushes"], "all");
    let turn = &compared["against"]["changes"][2];
    let [change, se] = ["square_change", "square_change_se"].map(|key| turn[key].as_f64().unwrap());
    assert!(change > 2.0 * se, "{turn}");
    let message = set.error(&add(["ratio=9", "direction=0.6"]));
    assert!(message.contains("ratio must be within 0.25 and 4"), "{message}");
    let message = set.error(&add(["ratio=1.3", "angle=0.6"]));
    assert!(message.contains("no parameter `angle`"), "{message}");
    let message = set.wrong_usage(&add(["ratio", "direction=0.6"]));
    assert!(message.contains("expected NAME=VALUE"), "{message}");
    set.wrong_usage(&["add", "table-tilt", "-o", "tilted.toml"]);
    let twice = ["add", "table-anisotropy", "--fit", "pushes", "--model", "grain.toml"];
    let message = set.error(&[&twice[..], &["-o", "twice.toml"]].concat());
    assert!(message.contains("already in the model"), "{message}");
    let same = ["add", "inertia", "--set", "kappa=1", "-o", "model.toml"];
    assert!(set.error(&same).contains("belongs to the input"));
}

#[test]
fn what_is_known_of_points_is_for_fits_of_points() {
    let set = pushes();
    let fit = ["fit", "pushes", "--free", "support-points", "--points", "3", "--by-statics"];
    let told = set.done(&[&fit[..], &["-o", "feet.toml", "--json"]].concat()).stdout;
    let fitted = result(&told);
    let follows = fitted["effects"][0]["follows"].as_array().unwrap();
    // The square's center of mass is its origin.
    for center in &follows[..2] {
        assert!(center["value"].as_f64().unwrap().abs() < 1e-3, "{center}");
    }
    let written = set.read("feet.toml");
    assert!(written.contains("share3") && !written.contains("share4"), "{written}");
    let made_by = fitted["made_by"]["arguments"].to_string();
    assert!(made_by.contains(r#""--points","3","--by-statics""#), "{made_by}");
    for wrong in [
        &["fit", "pushes", "--free", "pusher-friction", "--points", "3", "-o", "a.toml"][..],
        &["add", "table-tilt", "--fit", "pushes", "--by-statics", "-o", "a.toml"],
        &["add", "support-points", "--set", "x1=0.1", "--by-statics", "-o", "a.toml"],
    ] {
        let message = set.wrong_usage(wrong);
        assert!(message.contains("are for fits of support-points"), "{message}");
    }
    let again = ["--points", "4", "--model", "feet.toml", "-o", "a.toml"];
    let again = [&["fit", "pushes", "--free", "support-points"][..], &again].concat();
    assert!(set.wrong_usage(&again).contains("the model has support points"));
    let message = set.wrong_usage(&["fit", "pushes", "--free", "support-points", "--points", "7"]);
    assert!(message.contains("7 is not in 3..=6"), "{message}");
}

#[test]
fn an_effect_that_there_is_not_is_refused_before_anything_is_read() {
    let set = SmallSet::new();
    for wrong in [
        &["fit", "nowhere", "-o", "a.toml", "--free", "inertia,table-tild"][..],
        &["statistics", "nowhere", "-o", "a.json", "--free", "table-tild"],
        &["add", "table-tild", "--set", "x=0.1", "-o", "a.toml"],
        &["suggest", "nowhere", "-o", "a.csv", "--for", "table-tild"],
    ] {
        let message = set.wrong_usage(wrong);
        assert!(message.contains("a similar value exists: 'table-tilt'"), "{message}");
    }
}

#[test]
fn few_pushes_tell_no_field_of_friction_and_one_by_hand_is_drawn_where_objects_lay() {
    let set = SmallSet::new();
    let hidden = ["generate", "--hidden", "friction-field: sd=0.3", "-n", "30", "--format", "csv"];
    set.done(&[&hidden[..], &["-o", "pushes"]].concat());
    set.done(&["models", "init", "pushes"]);
    set.edit("model.toml", "limit_surface = \"ellipsoid\"", "limit_surface = \"uniform-patch\"");
    let message = set.error(&["add", "friction-field", "--fit", "pushes", "-o", "field.toml"]);
    assert!(message.contains("friction-field cannot be determined"), "{message}");
    let by_hand = ["add", "friction-field", "--set", "x=0", "--set", "y=0", "--set", "half_x=0.2"];
    let one_wave = ["--set", "half_y=0.2", "--set", "x1_y0=0.1", "-o", "field.toml"];
    set.done(&[&by_hand[..], &one_wave].concat());
    let has_map = |model: &str| {
        set.done(&["report", "pushes", "--model", model, "-o", "page.html", "--force"]);
        set.read("page.html").contains("Friction over the table")
    };
    assert!(has_map("field.toml") && !has_map("model.toml"));
}

#[test]
fn nuisances_are_written_where_they_are_asked_for() {
    let set = pushes();
    let fit = ["fit", "pushes", "--free", "pusher-friction", "-o"];
    let plain = set.done(&[&fit[..], &["plain.toml"]].concat()).stdout;
    let whole = set.done(&[&fit[..], &["whole.toml", "--nuisances"]].concat()).stdout;
    assert!(plain.contains("left open beside it, not written"), "{plain}");
    assert!(whole.contains("left open beside it, written, too"), "{whole}");
    let numbers = |text: &str| text.lines().skip(1).filter(|l| !l.contains("left open")).count();
    assert_eq!(numbers(&plain), numbers(&whole));
    assert!(!set.read("plain.toml").contains("pose-offset"));
    let written = set.read("whole.toml");
    for id in ["pose-offset", "pusher-radius", "yaw-offset"] {
        assert!(written.contains(&format!("id = \"{id}\"")), "{id} {written}");
    }
    // Both predict, and no number is of another push: they differ by little on a rig as claimed.
    let error = |model: &str| {
        let told = set.done(&["compare", "pushes", "--model", model, "--json"]).stdout;
        result(&told)["channels"][0]["rms"].as_f64()
    };
    let [one, other] = ["plain.toml", "whole.toml"].map(error);
    assert!(one.zip(other).is_some_and(|(one, other)| (other / one - 1.0).abs() < 0.2));
    let message =
        set.wrong_usage(&["add", "table-tilt", "--set", "ax=0.1", "--nuisances", "-o", "a.toml"]);
    assert!(message.contains("--nuisances is for fits"), "{message}");
}
