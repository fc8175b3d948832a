//! `pushlab train` on simulated pushes, and what reads its models.

use pushlab::dataset::{RecordingSet, ingest};
use pushlab::diagnosis::{NoiseFloor, Observations, steady_ingest};
use pushlab::gp_core::{Gp, GpModel};
use pushlab::models::ModelFile;
use serde_json::Value;

use crate::small_set::SmallSet;

fn simulated() -> SmallSet {
    let set = SmallSet::new();
    let generate = ["generate", "-o", "sim", "--rig", "quiet", "--pushes", "16"];
    set.done(&[&generate[..], &["--hidden", "body-anisotropy"]].concat());
    set.done(&["models", "init", "sim"]);
    set
}

fn result(stdout: &str) -> Value {
    serde_json::from_str::<Value>(stdout).unwrap()
}

/// Mean of a score over the outputs.
fn mean(trained: &Value, key: &str) -> f64 {
    let scores = trained["unseen"]["scores"].as_array().unwrap();
    assert_eq!(scores.len(), 3);
    scores.iter().map(|score| score[key].as_f64().unwrap()).sum::<f64>() / 3.0
}

/// The weights that a model names.
fn weights(set: &SmallSet, model: &str) -> String {
    let file: toml::Table = set.read(model).parse().unwrap();
    file["learned"]["weights"].as_str().unwrap().to_owned()
}

/// The floor of the turn about a learnt model, by the pushes that it has not seen alone: through the others it
/// passes.
fn floor_of_unseen(set: &SmallSet, model: &str) -> f64 {
    let recordings = RecordingSet::open(&set.path("sim")).unwrap();
    let (table, _) = ingest(&recordings, &steady_ingest()).unwrap();
    let all = Observations::steady(&table, recordings.manifest()).unwrap();
    let model = ModelFile::read(&set.path(model)).unwrap();
    let unseen = all.part(&model.split.unwrap().confirm).unwrap();
    NoiseFloor::about(&model.description, &[], &unseen).unwrap().numbers[2].unwrap().rms
}

#[test]
fn every_kind_is_trained_kept_and_compared_on_pushes_that_it_has_not_seen() {
    let set = simulated();
    for (kind, process) in
        [("gp", "gp"), ("spgp", "spgp"), ("rff", "rff"), ("vhgp", "vhgp"), ("hybrid", "rff")]
    {
        let model = format!("{kind}.toml");
        let mut train = vec!["train", "sim", "--kind", kind, "-n", "60", "-o", &model, "--json"];
        if kind == "hybrid" {
            train.extend(["--residual-kind", process]);
        }
        let printed = set.done(&train).stdout;
        let trained = result(&printed);
        assert_eq!((&trained["kind"], &trained["process"]), (&kind.into(), &process.into()));
        assert_eq!((&trained["n_pushes"], &trained["n_learnt"]), (&12.into(), &60.into()));
        assert_eq!(trained["unseen"]["n_pushes"], 4);
        let nmse = mean(&trained, "nmse");
        assert!(nmse < 0.3, "{kind}: {nmse}");
        let [compare, show] = [&["compare", "sim", "--model"][..], &["models", "show"]]
            .map(|command| set.done(&[command, &[&model, "--json"]].concat()).stdout);
        let compared = result(&compare);
        assert_eq!(
            (&compared["part"]["pushes"], &compared["n_pushes"]),
            (&"confirm".into(), &4.into())
        );
        for (score, channel) in trained["unseen"]["scores"]
            .as_array()
            .unwrap()
            .iter()
            .zip(compared["channels"].as_array().unwrap())
        {
            let [told, found] =
                [&score["nmse"], &channel["nmse"]].map(|nmse| nmse.as_f64().unwrap());
            assert!((told - found).abs() < 1e-9 * found, "{kind}: {told} {found}");
        }
        assert_eq!(compared["unexplained"], trained["unseen"]["unexplained"]);
        let floor = compared["floor"]["numbers"][2]["rms"].as_f64();
        assert_eq!(floor, Some(floor_of_unseen(&set, &model)), "{kind}");
        let shown = result(&show);
        assert_eq!((&shown["kind"], &shown["process"]), (&kind.into(), &process.into()));
        assert_eq!(shown["unexplained"], trained["unexplained"]);
        let weights = weights(&set, &model);
        let files = [set.read(&model), set.read(&weights)];
        assert_eq!(printed, set.done(&[&train[..], &["--jobs", "1", "--force"]].concat()).stdout);
        assert_eq!(files, [set.read(&model), set.read(&weights)]);
    }
}

#[test]
fn a_hybrid_tells_what_its_physics_do_not_explain() {
    let set = simulated();
    let hybrid = ["train", "sim", "--kind", "hybrid", "--residual-kind", "rff", "-o", "h.toml"];
    let text = set.done(&hybrid).stdout;
    assert!(text.contains("of the physics alone"), "{text}");
    assert!(text.contains("share of what it says that no physics explains"), "{text}");
    let trained = result(&set.done(&[&hybrid[..], &["--json", "--force"]].concat()).stdout);
    let share = trained["unexplained"]["all"].as_f64().unwrap();
    assert!(share > 1e-3 && share < 0.3, "{share}");
    assert!(mean(&trained, "nmse") < mean(&trained, "nmse_of_physics"));
    assert!(set.read("h.toml").contains("[learned.unexplained]"));
    // With the effect that is hidden there, less is left to be learnt.
    let grain = ["add", "body-anisotropy", "--set", "ratio=1.1", "--set", "direction=0.5"];
    set.done(&[&grain[..], &["-o", "grain.toml"]].concat());
    let with_effect = [&hybrid[..6], &["--model", "grain.toml", "-o", "g.toml", "--json"]].concat();
    let explained = result(&set.done(&with_effect).stdout);
    assert!(explained["unexplained"]["all"].as_f64().unwrap() < 0.5 * share, "{explained}");
    let compared = set.done(&["compare", "sim", "--model", "g.toml", "--against", "h.toml"]).stdout;
    assert!(compared.contains("share of what it says that no physics explains"), "{compared}");
}

#[test]
fn what_cannot_be_trained_or_read_is_refused_with_the_reason() {
    let set = simulated();
    let train = ["train", "sim", "--kind", "rff", "-o", "m.toml"];
    set.done(&train);
    for (more, says) in [
        (&["--model", "model.toml"][..], "--model is for --kind hybrid"),
        (&["--residual-kind", "gp"], "--residual-kind is for --kind hybrid"),
        (&["-n", "5"], "5 is not in 20.."),
    ] {
        let message = set.wrong_usage(&[&train[..], more].concat());
        assert!(message.contains(says), "{message}");
    }
    let missing = ["train", "sim", "--kind", "hybrid", "--model", "none.toml", "-o", "n.toml"];
    assert!(set.error(&missing).contains("pushlab models init"));
    let of_gp = ["train", "sim", "--kind", "hybrid", "--model", "m.toml", "-o", "n.toml"];
    assert!(set.error(&of_gp).contains("kind rff has no physics"));
    let long = set.error(&[&train[..], &["--step", "30cm", "--force"]].concat());
    assert!(long.contains("at least 20 steps") || long.contains("pushes"), "{long}");
    // Another object.
    set.done(&["generate", "-o", "hexes", "--shape", "hex", "--pushes", "3"]);
    let other = set.error(&["compare", "hexes", "--model", "m.toml"]);
    assert!(other.contains("none of the 1 that the model was trained on"), "{other}");
    // Weights that were changed, or are gone.
    let weights = weights(&set, "m.toml");
    set.edit(&weights, "1", "2");
    assert!(set.error(&["models", "show", "m.toml"]).contains("SHA-256"));
    std::fs::remove_file(set.path(&weights)).unwrap();
    assert!(set.error(&["compare", "sim", "--model", "m.toml"]).contains(&weights));
}

#[test]
fn a_report_shows_how_processes_were_learnt_and_what_they_say_of_left_out_rows() {
    let set = simulated();
    set.done(&["train", "sim", "--kind", "gp", "-n", "60", "-o", "gp.toml"]);
    set.done(&["report", "sim", "--model", "gp.toml", "-o", "gp.html"]);
    let page = set.read("gp.html");
    assert_eq!(page.matches("id=\"learning\"").count(), 1);
    for told in ["condition number", "starts that found it", "<td>60</td>", "Δθ: residuals are"] {
        assert!(page.contains(told), "{told}");
    }
    // What the table says is what the process says.
    let weights: Value = serde_json::from_str(&set.read(&weights(&set, "gp.toml"))).unwrap();
    let gp: GpModel = serde_json::from_value(weights["outputs"][2]["gp"].clone()).unwrap();
    let gp = Gp::from_model(&gp).unwrap();
    let evidence = format!("{:.1}", gp.log_marginal_likelihood()).replace('-', "−");
    let evidence = format!("<td>{evidence}</td>");
    assert!(page.contains(&evidence), "{evidence}");
    let starts = weights["learning"][2]["starts"].as_array().unwrap();
    let history = starts[0]["history"].as_array().unwrap();
    assert!(history.len() > 3 && history[0].as_f64() < history[history.len() - 1].as_f64());
    // Weights of before do not tell, and physics have no processes.
    set.done(&["train", "sim", "--kind", "rff", "-n", "60", "-o", "rff.toml"]);
    set.done(&["report", "sim", "--model", "rff.toml", "-o", "rff.html"]);
    assert!(!set.read("rff.html").contains("id=\"learning\""));
}
