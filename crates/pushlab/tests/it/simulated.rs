//! `pushlab simulate` on simulated recordings and on paths.

use serde_json::Value;

use crate::small_set::SmallSet;

/// A set with a trained model, and a nominal one.
fn trained() -> SmallSet {
    let set = SmallSet::new();
    set.done(&["generate", "-o", "sim", "--pushes", "24"]);
    set.done(&["models", "init", "sim"]);
    set.done(&["train", "sim", "--kind", "rff", "-n", "100", "-o", "rff.toml"]);
    set
}

fn result(stdout: &str) -> Value {
    serde_json::from_str::<Value>(stdout).unwrap()
}

#[test]
fn recorded_pushes_are_rolled_out_and_compared_with_their_ends() {
    let set = trained();
    let simulate = ["simulate", "sim", "--model", "rff.toml", "--particles", "400", "-n", "3"];
    let simulate = [&simulate[..], &["--correlation", "none"]].concat();
    let text = set.done(&[&simulate[..], &["-o", "out"]].concat()).stdout;
    assert!(text.contains("3 pushes, 400 particles each"), "{text}");
    assert!(text.contains("taken for independent"), "{text}");
    assert!(text.contains("95 % regions hold"), "{text}");
    let json = result(&set.done(&[&simulate[..], &["-o", "again", "--json"]].concat()).stdout);
    let pushes = json["pushes"].as_array().unwrap();
    assert_eq!(pushes.len(), 3);
    for push in pushes {
        let file = push["file"].as_str().unwrap();
        for ending in ["mcap", "svg", "png"] {
            let bytes = std::fs::read(set.path(&format!("out/{file}.{ending}"))).unwrap();
            assert!(bytes.len() > 1000, "{file}.{ending}: {} bytes", bytes.len());
        }
        let moments = push["moments"].as_array().unwrap();
        let end = &moments[moments.len() - 1];
        assert_eq!(end["events"]["pushed"], 400);
        let error = push["end"]["error"][0].as_f64().unwrap();
        assert!(error < 0.01, "{error}");
    }
    let table = set.read("out/poses.csv");
    assert!(table.starts_with("# tool: pushlab"), "{table}");
    let lines: Vec<_> = table.lines().filter(|line| !line.starts_with('#')).collect();
    let n_moments = pushes.iter().map(|push| push["moments"].as_array().unwrap().len());
    assert_eq!(lines.len(), 1 + n_moments.sum::<usize>());
    let n_columns = lines[0].split(',').count();
    assert!(lines.iter().all(|line| line.split(',').count() == n_columns));
    // The same for one thread.
    set.done(&[&simulate[..], &["-o", "one", "--jobs", "1", "-q"]].concat());
    assert_eq!(set.read("out/poses.csv"), set.read("one/poses.csv"));
}

#[test]
fn tables_and_moments_end_where_particles_do() {
    let set = trained();
    // Tails of what other pushes show are no Gaussian's.
    let model = ["--model", "rff.toml", "-n", "1", "--correlation", "none"];
    let simulate = [&["simulate", "sim", "--json"], &model[..]].concat();
    let run = |out: &str, more: &[&str]| {
        result(&set.done(&[&simulate[..], &["-o", out], more].concat()).stdout)
    };
    let end = |json: &Value| {
        let moments = json["pushes"][0]["moments"].as_array().unwrap().clone();
        let pose = &moments[moments.len() - 1]["pose_wb"];
        let numbers = |key: &str| -> Vec<f64> {
            pose[key].as_array().unwrap().iter().filter_map(Value::as_f64).collect()
        };
        let covariance = numbers("covariance");
        (numbers("mean"), [0, 4, 8].map(|k: usize| covariance[k].sqrt()))
    };
    let particles = run("particles", &["--particles", "4000"]);
    assert_eq!((&particles["tables"], &particles["matched"]), (&Value::Null, &Value::Null));
    let (mean, sd) = end(&particles);
    let table = |out: &str| {
        let text = set.read(&format!("{out}/poses.csv"));
        text.lines().filter(|line| !line.starts_with('#')).map(str::to_owned).collect::<Vec<_>>()
    };
    // The means of 4000 particles are known to 0.016 standard deviations, and a Gaussian knows nothing of
    // the skewness that a bent way makes.
    for (out, more, within) in [
        ("fast", &["--fast", "--particles", "4000"][..], 0.08),
        ("unscented", &["--matched", "unscented"], 0.2),
        ("gauss-hermite", &["--matched", "gauss-hermite"], 0.2),
        ("exact", &["--matched", "exact"], 0.2),
    ] {
        let json = run(out, more);
        let (found, found_sd) = end(&json);
        for axis in 0..3 {
            let off = (found[axis] - mean[axis]).abs() / sd[axis];
            let ratio = found_sd[axis] / sd[axis];
            assert!(off < within && (ratio - 1.0).abs() < 0.06, "{out}: {off} {ratio}");
        }
        if out == "fast" {
            assert!(json["tables"]["mean_error"].as_f64().unwrap() <= 0.01);
            assert!(json["tables"]["variance_error"].as_f64().unwrap() <= 1e-3);
        } else {
            assert_eq!((&json["n_particles"], json["matched"].as_str()), (&Value::Null, Some(out)));
        }
        let (table, of_particles) = (table(out), table("particles"));
        assert_eq!((table.len(), &table[0]), (of_particles.len(), &of_particles[0]));
        let level = json["pushes"][0]["end"]["level"].as_f64().unwrap();
        let expected = particles["pushes"][0]["end"]["level"].as_f64().unwrap();
        assert!((level - expected).abs() < 0.05, "{out}: {level} {expected}");
    }
    let inspected = set.done(&["inspect", "exact"]).stdout;
    assert!(!inspected.contains("/object/particles"), "{inspected}");
    let text =
        set.done(&["simulate", "sim", "--model", "rff.toml", "-n", "1", "--fast", "-o", "t"]);
    assert!(text.stdout.contains("read from tables: means within"), "{}", text.stdout);
}

#[test]
fn errors_that_a_push_holds_widen_its_end() {
    let set = trained();
    let sd = |more: &[&str]| {
        let simulate = ["simulate", "sim", "--model", "rff.toml", "--particles", "400", "--json"];
        let json = result(&set.done(&[&simulate[..], more].concat()).stdout);
        let moments = json["pushes"][0]["moments"].as_array().unwrap().clone();
        let covariance = &moments[moments.len() - 1]["pose_wb"]["covariance"];
        (json["calibration"]["n_pushes"].clone(), covariance[8].as_f64().unwrap().sqrt())
    };
    set.done(&["generate", "-o", "more", "--pushes", "8", "--seed", "9"]);
    let (none, independent) = sd(&["-n", "1", "-o", "a", "--correlation", "none"]);
    let (n, held) = sd(&["-n", "1", "-o", "b", "--correlation", "more"]);
    assert_eq!((none, n), (Value::Null, 8.into()));
    assert!(held > 1.2 * independent, "{held} {independent}");
    // By the pushes of the set that the model has not seen, if none were named.
    let (n, by_others) = sd(&["-n", "1", "-o", "c"]);
    assert!(n.as_u64().is_some_and(|n| n >= 4), "{n}");
    assert!(by_others > 1.2 * independent, "{by_others} {independent}");
}

#[test]
fn a_path_is_rolled_out_and_its_log_is_read_again() {
    let set = trained();
    set.write(
        "turn.toml",
        "kind = \"spline\"\nspeed_mm_s = 20\npoints_mm = [[-55, 0], [-30, 3], [5, 20]]\n\
         object = [0, 0, 0]\n",
    );
    let simulate = ["simulate", "turn.toml", "--manifest", "sim/dataset.toml", "--particles", "50"];
    for model in ["model.toml", "rff.toml"] {
        let out = model.trim_end_matches(".toml");
        let json = set.done(&[&simulate[..], &["--model", model, "-o", out, "--json"]].concat());
        let json = result(&json.stdout);
        let moments = json["pushes"][0]["moments"].as_array().unwrap();
        let still = moments[1]["pose_wb"]["mean"].as_array().unwrap();
        assert!(still.iter().all(|value| value.as_f64() == Some(0.0)), "free at first: {still:?}");
        let touched: u64 = moments.iter().map(|m| m["events"]["touched"].as_u64().unwrap()).sum();
        assert_eq!(touched, 50);
    }
    let inspected = set.done(&["inspect", "model"]).stdout;
    for part in ["/robot/tip_pose", "foxglove.PoseInFrame", "/object/pose", "foxglove.PosesInFrame"]
    {
        assert!(inspected.contains(part), "{part}: {inspected}");
    }
    let pose = inspected.lines().find(|line| line.contains("/object/pose")).unwrap();
    assert!(pose.contains("object") && pose.contains("robot"), "serves as a pose: {pose}");
}

#[test]
fn a_model_that_was_fitted_knows_along_a_path_how_sure_it_may_be() {
    let set = trained();
    set.write("arc.csv", "t_s,x_m,y_m\n0,-0.06,0.004\n1,-0.04,0.004\n2,-0.02,0.004\n");
    let arc = ["simulate", "arc.csv", "--manifest", "sim/dataset.toml", "--particles", "400"];
    let end = |model: &str, more: &[&str]| {
        let out = format!("out-{}", model.len() + 100 * more.len());
        let words = ["--model", model, "--json", "-o", &out];
        let json = result(&set.done(&[&arc[..], &words, more].concat()).stdout);
        let moments = json["pushes"][0]["moments"].as_array().unwrap().clone();
        let covariance = &moments[moments.len() - 1]["pose_wb"]["covariance"];
        (json["calibration"]["n_pushes"].as_u64(), covariance[0].as_f64().unwrap().sqrt())
    };
    let nothing = ["--correlation", "none"];
    set.done(&["fit", "sim", "--free", "pusher-friction", "-o", "fitted.toml"]);
    for (model, least) in [("rff.toml", 4), ("fitted.toml", 20)] {
        let ((n, sure), (none, independent)) = (end(model, &[]), end(model, &nothing));
        assert!(n.is_some_and(|n| n >= least) && none.is_none(), "{model}: {n:?} {none:?}");
        assert!(sure > 1.2 * independent, "{model}: {sure} {independent}");
    }
    // Of another model nothing of it holds, until it is measured.
    let add = ["add", "table-tilt", "--set", "ax=0.01", "--set", "ay=0"];
    set.done(&[&add[..], &["--model", "fitted.toml", "-o", "tilted.toml"]].concat());
    assert!(!set.read("tilted.toml").contains("[calibration]"));
    set.done(&["calibrate", "sim", "--model", "tilted.toml", "-o", "sure.toml"]);
    assert!(end("sure.toml", &[]).0.is_some_and(|n| n >= 20));
    let shown = set.done(&["models", "show", "sure.toml"]).stdout;
    assert!(shown.contains("of whole pushes: of the model's variance"), "{shown}");
}

#[test]
fn a_path_beyond_the_training_steps_is_told_and_its_regions_are_wider() {
    let set = trained();
    let path = |name: &str, end: [f64; 2]| {
        let points = format!("points_mm = [[-50, 0], [{}, {}]]", end[0], end[1]);
        set.write(name, &format!("kind = \"straight\"\nspeed_mm_s = 20\n{points}\n"));
    };
    path("within.toml", [-38.0, 0.0]);
    // Half as steep again as any push of the set.
    path("beyond.toml", [-49.0, 12.0]);
    let text = |name: &str| {
        let about = ["--manifest", "sim/dataset.toml", "--model", "rff.toml"];
        let out = name.trim_end_matches(".toml");
        let simulate = ["simulate", name, "--particles", "200", "-o", out];
        set.done(&[&simulate[..], &about].concat()).stdout
    };
    let (within, beyond) = (text("within.toml"), text("beyond.toml"));
    assert!(!within.contains("beyond those that the model has seen"), "{within}");
    assert!(beyond.contains("beyond those that the model has seen"), "{beyond}");
}

#[test]
fn what_cannot_be_simulated_is_refused_with_the_reason() {
    let set = trained();
    set.write("inside.toml", "kind = \"straight\"\nspeed_mm_s = 20\npoints_mm = [[0, 0], [9, 0]]");
    set.write("push.toml", "kind = \"straight\"\nspeed_mm_s = 20\npoints_mm = [[-55, 0], [9, 0]]");
    set.write("jump.csv", "t_s,x_m,y_m\n0,-0.06,0\n0.01,0.06,0\n");
    set.write("nan.csv", "t_s,x_m,y_m\n0,-0.06,0\n1,nan,0\n");
    set.done(&["generate", "-o", "hexes", "--shape", "hex", "--pushes", "3"]);
    let about = ["--manifest", "sim/dataset.toml"];
    let hex = ["--manifest", "hexes/dataset.toml", "--object", "20,0,0"];
    for (source, more, says) in [
        ("inside.toml", &about[..], "inside the object"),
        ("jump.csv", &about, "line 3: the point is a jump of 120.0 mm"),
        ("nan.csv", &about, "line 3: the point is (NaN, 0) m"),
        ("push.toml", &hex, "train one on pushes of this object"),
        ("push.toml", &["--manifest", "sim/dataset.toml", "--step", "9mm"], "take shorter steps"),
        ("sim", &["--push", "push-9999#0"], "has no push push-9999#0"),
        ("none", &[], "cannot read none"),
        ("push.toml", &["--manifest", "none.toml"], "none.toml"),
    ] {
        let command = ["simulate", source, "--model", "rff.toml", "-o", "out", "--particles", "9"];
        let message = set.error(&[&command[..], more].concat());
        assert!(message.contains(says), "{source}: {message}");
        assert!(!set.path("out").exists(), "{source} has left a folder");
    }
    let few = ["simulate", "sim", "-o", "out", "--particles", "9", "--correlation", "hexes"];
    let why = set.error(&few);
    assert!(why.contains("at least 4"), "{why}");
    // Physics without any scatter are as sure as the set's other pushes let them be.
    let text = set.done(&["simulate", "sim", "-o", "sure", "--particles", "50", "-n", "2"]).stdout;
    assert!(text.contains("goes on over") && text.contains("regions hold"), "{text}");
    for (source, more, says) in [
        ("sim", &about[..], "a set has its own"),
        ("push.toml", &[], "give a set's --manifest"),
        ("push.toml", &["--manifest", "sim/dataset.toml", "--push", "a#0"], "a path is one push"),
    ] {
        let command = ["simulate", source, "--model", "rff.toml", "-o", "out"];
        let message = set.wrong_usage(&[&command[..], more].concat());
        assert!(message.contains(says), "{source}: {message}");
    }
    for (source, model, more, says) in [
        ("broken.toml", "rff.toml", &about[..], "broken.toml is no path"),
        ("broken.csv", "rff.toml", &about, "line 2: 2 values, expected 3"),
        ("push.toml", "none.toml", &about, "cannot read none.toml"),
        ("push.toml", "broken-model.toml", &about, "broken-model.toml"),
    ] {
        set.write("broken.toml", "kind = \"straight\"\nspeed_mm_s = 20\npoints_mm = [[-55, 0]");
        set.write("broken.csv", "t_s,x_m,y_m\n0,-0.06\n");
        set.write("broken-model.toml", "kind = 3\n");
        let command = ["simulate", source, "--model", model, "-o", "out", "--particles", "9"];
        let message = set.error(&[&command[..], more].concat());
        assert!(message.contains(says), "{source}, {model}: {message}");
        assert!(!set.path("out").exists(), "{source} has left a folder");
    }
    let none = ["simulate", "sim", "--model", "rff.toml", "-o", "out", "--particles", "0"];
    assert!(set.wrong_usage(&none).contains("--particles"), "no particles at all");
    let full = ["simulate", "sim", "--model", "rff.toml", "-o", "sim"];
    assert!(set.error(&full).contains("the folder is not empty"));
}

#[test]
fn what_has_no_tables_and_no_closed_form_is_refused_with_the_reason() {
    let set = SmallSet::new();
    set.done(&["generate", "-o", "sim", "--pushes", "3"]);
    set.done(&["models", "init", "sim"]);
    let simulate = ["simulate", "sim", "-o", "out"];
    for (more, says) in [
        (&["--fast"][..], "a model of kind analytical is none"),
        (&["--matched", "exact"], "what a model of kind analytical says of an uncertain step"),
    ] {
        let message = set.error(&[&simulate[..], more].concat());
        assert!(message.contains(says), "{message}");
        assert!(!set.path("out").exists(), "{more:?} has left a folder");
    }
    for (more, says) in [
        (&["--matched", "exact", "--particles", "9"][..], "cannot be used with"),
        (&["--matched", "exact", "--fast"], "cannot be used with"),
        (&["--matched", "guess"], "unscented, gauss-hermite, exact"),
    ] {
        let message = set.wrong_usage(&[&simulate[..], more].concat());
        assert!(message.contains(says), "{message}");
    }
}
