//! Every command on a small set: what it writes, prints and carries.

use crate::small_set::SmallSet;
use dataset::{Flags, Table};
use serde_json::Value;

fn document(text: &str) -> Value {
    let document: Value = serde_json::from_str(text).unwrap();
    let keys: Vec<_> = document.as_object().unwrap().keys().cloned().collect();
    let made_by = &document["made_by"];
    let command = made_by["arguments"][0].as_str().unwrap();
    assert!(["schema", "made_by", "warnings"].iter().all(|key| keys.contains(&(*key).into())));
    assert!(document["schema"].as_str().unwrap().starts_with(&format!("pushlab.{command}")));
    assert_eq!(made_by["tool"], concat!("pushlab ", env!("CARGO_PKG_VERSION")));
    document
}

/// The pusher carries the square: each full step of 0.2 s at 20 mm/s moves it by 4 mm.
#[test]
fn recordings_become_the_steps_that_were_made() {
    let set = SmallSet::new();
    let run = set.done(&["ingest", "set", "-o", "steps.csv"]);
    assert!(run.stdout.contains("2 recordings, 2 pushes used, 0 excluded"), "{}", run.stdout);
    assert!(run.stdout.ends_with("wrote steps.csv\n"), "{}", run.stdout);
    let table = Table::read(&set.path("steps.csv")).unwrap();
    assert_eq!(table.len(), 10);
    for row in &table.rows {
        assert_eq!(row.edge, 1);
        // The first contact is known to a sample of 10 ms, in which the square moves by 0.2 mm; the
        // kinks of first touch and stop bend the spline by less.
        let tolerance = if row.flags.contains(Flags::FIRST_TOUCH) { 2e-4 } else { 1e-6 };
        assert!((row.dx - 0.004).abs() < tolerance, "step {}: {}", row.step, row.dx);
        assert!(row.dy.abs() < 1e-6 && row.dtheta.abs() < 1e-6);
        assert!((row.force.unwrap().mean.normal - 2.0).abs() < 0.05);
    }
}

#[test]
fn every_format_gives_the_same_steps() {
    let rows = |writer: &str| {
        let set = SmallSet::written_by(writer);
        set.done(&["ingest", "set", "-o", "steps.parquet", "-q"]);
        Table::read(&set.path("steps.parquet")).unwrap().rows
    };
    let csv = rows("csv");
    for writer in ["mcap-ros2", "mcap-ros1", "mcap-json", "mit-json"] {
        assert_eq!(rows(writer), csv, "{writer}");
    }
}

#[test]
fn a_table_carries_what_made_it() {
    let set = SmallSet::new();
    set.done(&["ingest", "set", "-o", "steps.csv", "--step", "4mm", "--curve", "smooth"]);
    let table = Table::read(&set.path("steps.csv")).unwrap();
    let get = |key: &str| table.provenance.get(key).unwrap_or_default();
    assert_eq!(get("tool"), concat!("pushlab ", env!("CARGO_PKG_VERSION")));
    assert_eq!(get("arguments"), "ingest set --step 0.004m --curve smooth");
    assert!(get("settings").contains("\"step\":{\"distance\":0.004}"), "{}", get("settings"));
    let sources = table.provenance.entries.iter().filter(|(key, _)| key == "source");
    let sources: Vec<_> = sources.map(|(_, value)| value.rsplit(' ').next().unwrap()).collect();
    assert_eq!(sources, ["pushes/push-0", "pushes/push-1", "dataset.toml"]);
    // A table is described with the same record.
    let described = document(&set.done(&["describe", "steps.csv", "--json"]).stdout);
    assert_eq!(described["rows"], table.len());
    assert_eq!(described["provenance"][0][1], get("tool"));
}

#[test]
fn threads_change_no_byte() {
    let set = SmallSet::new();
    let pushes = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/pushes");
    let outputs = ["1", "2"].map(|jobs| {
        let (table, report) = (format!("{jobs}.csv"), format!("{jobs}.json"));
        let files = ["-o", &table, "--report", &report];
        let stdout =
            set.done(&[&["ingest", pushes, "--json", "--jobs", jobs], &files[..]].concat());
        [set.read(&table), set.read(&report), stdout.stdout]
    });
    assert_eq!(outputs[0], outputs[1]);
    // The report in JSON is the document that `--json` prints.
    assert_eq!(outputs[0][1], outputs[0][2]);
}

#[test]
fn reports_are_for_people_and_for_programs() {
    let set = SmallSet::new();
    set.done(&["ingest", "set", "--report", "report.txt"]);
    let text = set.read("report.txt");
    assert!(text.contains("push-1\n  robot: 201 of 201 samples at 100 Hz"), "{text}");
    assert!(text.contains("\n# arguments: ingest set\n# source: sha256 "), "{text}");
    assert!(!text.contains('\u{1b}'));
    set.done(&["ingest", "set", "--report", "report.json"]);
    let report = document(&set.read("report.json"));
    assert_eq!(report["made_by"]["inputs"].as_array().unwrap().len(), 3);
    assert_eq!(report["report"]["summary"]["pushes_used"], 2);
    assert_eq!(report["report"]["recordings"][1]["name"], "push-1");
}

#[test]
fn the_alias_table_is_ingest() {
    let set = SmallSet::new();
    set.done(&["ingest", "set", "-o", "a.csv"]);
    set.done(&["table", "set", "-o", "b.csv"]);
    assert_eq!(set.read("a.csv"), set.read("b.csv"));
}

#[test]
fn what_is_set_aside_is_named_with_its_reason() {
    let set = SmallSet::new();
    set.write("set/pushes/push-1/object.csv", "t_s,x_m,y_m,yaw\n1,2,3,4\n");
    let run = set.done(&["ingest", "set"]);
    assert!(run.stdout.contains("1 pushes used, 1 excluded"), "{}", run.stdout);
    assert!(run.stdout.contains("excluded\n  push-1: "), "{}", run.stdout);
    assert!(run.stdout.contains("no column"), "{}", run.stdout);
}

#[test]
fn a_draft_is_written_once_and_says_what_is_open() {
    let set = SmallSet::new();
    std::fs::remove_file(set.path("set/dataset.toml")).unwrap();
    let printed = set.done(&["init", "set", "-o", "-"]).stdout;
    assert!(!set.exists("set/dataset.toml"));
    let run = set.done(&["init", "set"]);
    assert_eq!(set.read("set/dataset.toml"), printed);
    assert!(printed.contains("\n# arguments: init set\n# source: sha256 "), "{printed}");
    assert!(run.stdout.contains("set/dataset.toml:5: shape = \"TODO\""), "{}", run.stdout);
    assert!(
        set.error(&["init", "set"])
            .contains("it exists; name another file, or replace it with --force")
    );
    assert_eq!(set.read("set/dataset.toml"), printed);
    let message = set.error(&["ingest", "set"]);
    assert!(message.contains("help: fill in what is marked TODO"), "{message}");
    set.edit("set/dataset.toml", "shape = \"TODO\"", "shape = \"rect1\"");
    set.edit("set/dataset.toml", "radius_m = \"TODO\"", "radius_m = 0.005");
    set.done(&["ingest", "set"]);
}

#[test]
fn recordings_are_inspected_with_and_without_a_manifest() {
    let set = SmallSet::written_by("mcap-ros2");
    let run = set.done(&["inspect", "set"]);
    assert!(run.stdout.starts_with("set/pushes/push-0.mcap\n"), "{}", run.stdout);
    assert!(run.stdout.contains("geometry_msgs/msg/WrenchStamped"), "{}", run.stdout);
    assert!(run.stdout.ends_with("1 more recordings of format mcap; --all shows them\n"));
    std::fs::remove_file(set.path("set/dataset.toml")).unwrap();
    assert_eq!(set.done(&["inspect", "set"]).stdout, run.stdout);
    let one = document(&set.done(&["inspect", "set/pushes/push-1.mcap", "--json"]).stdout);
    assert_eq!(one["made_by"]["inputs"][0]["path"], "set/pushes/push-1.mcap");
    assert_eq!(one["format"], "mcap");
    assert_eq!(one["recordings"][0]["streams"].as_array().unwrap().len(), 3);
    let all = document(&set.done(&["inspect", "set", "--all", "--json"]).stdout);
    assert_eq!(all["recordings"].as_array().unwrap().len(), 2);
}

#[test]
fn tables_of_others_are_converted_by_a_mapping() {
    let set = SmallSet::new();
    let theirs = "c,phi_rad,dx_c_m,dy_c_m_sign_flipped,dtheta_rad\n\
                  0.2,0.0,0.003,0.0,-0.03\n0.5,0.5,0.003,0.001,0.0\n";
    set.write("theirs.csv", theirs);
    set.done(&["ingest", "theirs.csv", "--preset", "mit-table", "-o", "ours.csv"]);
    let table = Table::read(&set.path("ours.csv")).unwrap();
    assert_eq!((table.rows[1].p, table.rows[1].beta, table.rows[1].dy), (0.5, 0.5, -0.001));
    let mapping = set.done(&["init", ".", "--preset", "mit-table", "-o", "-"]).stdout;
    set.write("map.toml", &mapping);
    set.done(&["ingest", "theirs.csv", "--mapping", "map.toml", "-o", "mapped.csv"]);
    let mapped = Table::read(&set.path("mapped.csv")).unwrap();
    assert_eq!(mapped.rows, table.rows);
    assert!(mapped.provenance.entries.iter().any(|(_, value)| value.ends_with(" map.toml")));
}

#[test]
fn models_begin_with_the_nominal_values_of_a_set() {
    let set = SmallSet::new();
    set.done(&["models", "init", "set"]);
    let shown = set.done(&["models", "show"]).stdout;
    assert!(shown.starts_with("nominal model of small (analytical)\n"), "{shown}");
    assert!(shown.contains("pusher friction: 0.25  (set/dataset.toml sha256:"), "{shown}");
    assert!(set.error(&["models", "init", "set"]).contains("model.toml: it exists"));
    let shown = document(&set.done(&["models", "show", "--json"]).stdout);
    assert_eq!(shown["parameters"][0]["value"], 0.25);
    assert_eq!(shown["parameters"][1]["value"], Value::Null);
    set.done(&["models", "init", "--preset", "mit-table", "-o", "mit.toml"]);
    let kinds = document(&set.done(&["models", "list", "--json"]).stdout);
    assert_eq!(kinds["kinds"][0]["id"], "analytical");
}

#[test]
fn models_begin_with_what_the_manifest_says_that_the_object_rests_on() {
    let set = SmallSet::new();
    let manifest = |support: &str| {
        format!(
            "name = \"feet\"\n[object]\nshape = \"square\"\nside_m = 0.1\nmass_kg = 1.0\n\
             center_of_mass_m = [0.01, 0.0]\n{support}\n[pusher]\nradius_m = 0.0\nfriction = 0.25\n\
             [support]\nfriction = 0.3\n[recordings]\nformat = \"csv\"\n"
        )
    };
    let begun = |support: &str| -> Value {
        set.write("feet.toml", &manifest(support));
        set.done(&["models", "init", "feet.toml", "-o", "feet-model.toml", "--force"]);
        let show = ["models", "show", "feet-model.toml", "--manifest", "feet.toml", "--json"];
        document(&set.done(&show).stdout)
    };
    let value = |shown: &Value, name: &str| -> f64 {
        let parameters = shown["parameters"].as_array().unwrap();
        let found = parameters.iter().find(|one| one["name"].as_str().unwrap().starts_with(name));
        found.unwrap_or_else(|| panic!("{name} in {shown}"))["value"].as_f64().unwrap()
    };
    let patch = begun("support = \"patch\"");
    assert_eq!(patch["limit_surface"], "uniform-patch");
    // The mean distance of a square's points from its middle: 0.382597858 of its side.
    assert!((value(&patch, "characteristic length c under") - 0.038_259_8).abs() < 1e-6);
    // The center of mass is between two feet and one: five eighths of the weight on the one at +x.
    let places = "support = \"points\"\n\
                  support_points_m = [[0.04, 0.0], [-0.04, 0.03], [-0.04, -0.03]]\n";
    let feet = begun(places);
    assert!((value(&feet, "support-points share1") - 0.625).abs() < 1e-12);
    assert!((value(&feet, "support-points share2") - 0.1875).abs() < 1e-12);
    assert!((value(&feet, "center of friction x under") - 0.01).abs() < 1e-9);
    assert!(value(&feet, "center of friction y under").abs() < 1e-9);
    // 0.03 m to one foot, √(0.05² + 0.03²) m to the others.
    let mean = 0.625 * 0.03 + 0.375 * 0.05_f64.hypot(0.03);
    assert!((value(&feet, "characteristic length c under") / mean - 1.0).abs() < 1e-9);
    let given = begun(&format!("{places}support_shares = [0.2, 0.4, 0.4]"));
    assert!((value(&given, "center of friction x under") + 0.024).abs() < 1e-9);
    let row = "[0.04, 0.04, 0.04, 0.04, 0.04]";
    let map = format!("support = \"map\"\nsupport_map = [{row}, {row}, {row}, {row}, {row}]");
    let map = begun(&map);
    assert!((value(&map, "characteristic length c under") - 0.0383).abs() < 1e-3);
    set.write("feet.toml", &manifest("support = \"feet\""));
    let error = set.error(&["models", "init", "feet.toml", "-o", "feet-model.toml", "--force"]);
    assert!(error.contains("feet.toml") && error.contains("object.support"), "{error}");
}

#[test]
fn quiet_runs_print_nothing_but_write_everything() {
    let set = SmallSet::new();
    let run = set.done(&["-q", "ingest", "set", "-o", "steps.csv"]);
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
    assert!(set.exists("steps.csv"));
    let run = set.done(&["-q", "ingest", "set", "--json"]);
    document(&run.stdout);
}
