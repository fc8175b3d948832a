//! Bad input through the tool: exit code 1 with path, place, value and remedy, or a counted repair.

use crate::small_set::{SmallSet, manifest};

const ROBOT: &str = "set/pushes/push-0/robot.csv";
const OBJECT: &str = "set/pushes/push-0/object.csv";

fn assert_names(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "no {part:?} in {message}");
    }
    assert!(!message.contains("panicked"), "{message}");
}

/// A set of one recording, so that its faults are the set's.
fn lone_push() -> SmallSet {
    let set = SmallSet::new();
    std::fs::remove_dir_all(set.path("set/pushes/push-1")).unwrap();
    set
}

#[test]
fn a_missing_path_is_named_by_every_command() {
    let set = SmallSet::new();
    for command in ["ingest", "inspect", "init"] {
        let message = set.error(&[command, "nowhere"]);
        assert_names(&message, &["cannot read nowhere", "No such file", "help: check the path"]);
    }
    assert_names(&set.error(&["describe", "nowhere.csv"]), &["cannot read nowhere.csv"]);
    assert_names(&set.error(&["models", "show", "no.toml"]), &["cannot read no.toml"]);
    assert_names(&set.error(&["models", "init", "nowhere"]), &["cannot read nowhere"]);
    assert_names(
        &set.error(&["ingest", "set", "-o", "none/steps.csv"]),
        &["cannot write none/steps.csv", "no folder none; make it first"],
    );
}

#[test]
fn an_unreadable_file_is_named() {
    let set = SmallSet::new();
    std::fs::write(set.path("set/dataset.toml"), [0xff, 0xfe, 0x00]).unwrap();
    let message = set.error(&["ingest", "set"]);
    assert_names(&message, &["set/dataset.toml: byte 0", "UTF-8", "the file that is meant"]);
    let set = lone_push();
    std::fs::write(set.path(OBJECT), [0xff; 64]).unwrap();
    assert_names(&set.error(&["ingest", "set"]), &["set: none of 1 recordings", "object.csv"]);
    let set = SmallSet::written_by("mcap-ros2");
    std::fs::remove_file(set.path("set/pushes/push-1.mcap")).unwrap();
    set.write("set/pushes/push-0.mcap", "this is no MCAP file");
    assert_names(&set.error(&["ingest", "set"]), &["push-0.mcap", "byte 0"]);
    assert_names(&set.error(&["inspect", "set"]), &["push-0.mcap", "byte 0"]);
}

#[test]
fn a_wrong_column_is_named_with_those_that_are_there() {
    let set = lone_push();
    set.edit(OBJECT, "theta_rad", "yaw");
    let message = set.error(&["ingest", "set"]);
    assert_names(&message, &["object.csv", "theta_rad", "t_s, x_m, y_m, yaw"]);
}

#[test]
fn stamps_out_of_order_and_doubled_are_repaired_and_counted() {
    let set = lone_push();
    let text = set.read(OBJECT);
    let mut lines: Vec<_> = text.lines().collect();
    lines.swap(60, 61);
    lines.insert(100, lines[99]);
    set.write(OBJECT, &(lines.join("\n") + "\n"));
    let run = set.done(&["ingest", "set"]);
    assert_names(&run.stdout, &["repairs of the object stream: 1 backward, 1 duplicate"]);
}

#[test]
fn what_is_not_finite_is_counted_or_refused_with_its_line() {
    let set = lone_push();
    let text = set.read(OBJECT);
    let mut lines: Vec<_> = text.lines().map(str::to_owned).collect();
    let stamp = |line: &str| line.split(',').next().unwrap().to_owned();
    lines[40] = format!("{},NaN,0,0", stamp(&lines[40]));
    set.write(OBJECT, &(lines.join("\n") + "\n"));
    set.done(&["ingest", "set", "--report", "report.txt"]);
    let report = set.read("report.txt");
    assert_names(&report, &["1 of 201 rows excluded: a value is not finite, first at line 41"]);
    for line in &mut lines[1..] {
        *line = format!("{},NaN,0,0", stamp(line));
    }
    set.write(OBJECT, &(lines.join("\n") + "\n"));
    let message = set.error(&["ingest", "set"]);
    assert_names(&message, &["201 of 201 rows of the object stream", "not finite", "line 2"]);
}

#[test]
fn a_quaternion_far_from_unit_is_refused_with_its_length() {
    let set = lone_push();
    let text = set.read(OBJECT);
    let rows = text.lines().skip(1).map(|line| {
        let mut cells = line.split(',');
        let [t, x, y] = std::array::from_fn(|_| cells.next().unwrap());
        format!("{t},{x},{y},0,0,0,0.5\n")
    });
    set.write(OBJECT, &format!("t_s,x_m,y_m,qx,qy,qz,qw\n{}", rows.collect::<String>()));
    let columns = "\n[streams.object.columns]\nx = \"x_m\"\ny = \"y_m\"\nqx = \"qx\"\n\
                   qy = \"qy\"\nqz = \"qz\"\nqw = \"qw\"\n";
    set.write("set/dataset.toml", &(manifest("csv") + columns));
    let message = set.error(&["ingest", "set"]);
    assert_names(&message, &["quaternion has length 0.500 instead of 1", "line 2", "object"]);
}

#[test]
fn an_unknown_shape_and_a_degenerate_polygon_name_the_line_and_what_is_allowed() {
    let set = SmallSet::new();
    set.edit("set/dataset.toml", "\"square\"", "\"sqare\"");
    let message = set.error(&["ingest", "set"]);
    assert_names(&message, &["set/dataset.toml:4: object.shape = sqare", "rectangle", "butter"]);
    let set = SmallSet::new();
    let polygon = "\"polygon\"\nvertices_m = [[0.0, 0.0], [0.1, 0.0], [0.2, 0.0]]";
    set.edit("set/dataset.toml", "\"square\"\nside_m = 0.09", polygon);
    let message = set.error(&["ingest", "set"]);
    assert_names(&message, &["set/dataset.toml:5: object.vertices_m", "counter-clockwise"]);
}

#[test]
fn wrong_keys_and_units_name_the_line_and_what_is_allowed() {
    let set = SmallSet::new();
    set.edit("set/dataset.toml", "side_m = 0.09", "side_m = 90.0");
    let message = set.error(&["ingest", "set"]);
    assert_names(&message, &["set/dataset.toml:5: object.side_m = 90 m", "in m, not mm"]);
    let set = SmallSet::new();
    set.edit("set/dataset.toml", "side_m", "side_mm");
    let message = set.error(&["models", "init", "set"]);
    assert_names(&message, &["set/dataset.toml:5: unknown field `side_mm`", "`side_m`"]);
}

#[test]
fn a_topic_that_is_not_there_is_answered_with_those_that_are() {
    let set = SmallSet::written_by("mcap-ros2");
    std::fs::remove_file(set.path("set/pushes/push-1.mcap")).unwrap();
    let manifest = manifest("mcap") + "\n[streams.object]\ntopic = \"/vicon/box\"\n";
    set.write("set/dataset.toml", &manifest);
    let message = set.error(&["ingest", "set"]);
    assert_names(&message, &["push-0.mcap", "/vicon/box", "set streams.object.topic to one of"]);
}

#[test]
fn empty_sets_and_short_tables_are_refused() {
    let set = SmallSet::new();
    std::fs::remove_dir_all(set.path("set/pushes")).unwrap();
    std::fs::create_dir(set.path("set/pushes")).unwrap();
    assert_names(&set.error(&["ingest", "set"]), &["set/pushes", "csv", "check `path`"]);
    assert_names(&set.error(&["inspect", "set"]), &["set/pushes"]);
    assert_names(&set.error(&["init", "set/pushes"]), &["set/pushes"]);

    let set = SmallSet::new();
    set.done(&["ingest", "set", "-o", "steps.csv"]);
    let text = set.read("steps.csv");
    let header = text.lines().position(|line| line.starts_with("recording,")).unwrap();
    let lines: Vec<_> = text.lines().take(header + 2).collect();
    set.write("one.csv", &(lines.join("\n") + "\n"));
    let message = set.error(&["describe", "one.csv"]);
    assert_names(&message, &["one.csv: the table has 1 row(s)", "at least 2", "ingest more"]);
}

#[test]
fn damaged_tables_name_line_column_value_and_unit() {
    let set = SmallSet::new();
    set.done(&["ingest", "set", "-o", "steps.csv", "-q"]);
    let text = set.read("steps.csv");
    let header = text.lines().position(|line| line.starts_with("recording,")).unwrap();
    set.write("renamed.csv", &text.replacen(",beta_rad,", ",beta,", 1));
    assert_names(&set.error(&["describe", "renamed.csv"]), &["no column `beta_rad`"]);
    let mut lines: Vec<_> = text.lines().map(str::to_owned).collect();
    let place = lines[header].split(',').position(|name| name == "dx_m").unwrap();
    let mut cells: Vec<_> = lines[header + 3].split(',').map(str::to_owned).collect();
    cells[place] = "wide".to_owned();
    lines[header + 3] = cells.join(",");
    set.write("wide.csv", &(lines.join("\n") + "\n"));
    let line = format!("wide.csv:{}: ", header + 4);
    let message = set.error(&["describe", "wide.csv"]);
    assert_names(&message, &[&line, "dx_m is `wide`", "expected -1e12 to 1e12 m"]);
    set.write("none.parquet", "this is no Parquet file");
    assert_names(&set.error(&["describe", "none.parquet"]), &["none.parquet: "]);
}

#[test]
fn what_was_probably_meant_is_said() {
    let set = SmallSet::new();
    set.done(&["ingest", "set", "-o", "steps.csv", "-q"]);
    assert_names(&set.error(&["ingest", "steps.csv"]), &["pushlab describe", "--mapping FILE"]);
    let message = set.error(&["ingest", "."]);
    assert_names(&message, &["holds tables and no recordings", "such as ./steps.csv"]);
    assert_names(&set.error(&["inspect", "steps.csv"]), &["pushlab describe"]);
    let mcap = SmallSet::written_by("mcap-ros1");
    let message = mcap.error(&["ingest", "set/pushes/push-0.mcap"]);
    assert_names(&message, &["is one recording", "pushlab init"]);
}

#[test]
fn inputs_are_never_overwritten() {
    let set = SmallSet::new();
    let theirs = "c,phi_rad,dx_c_m,dy_c_m_sign_flipped,dtheta_rad\n\
                  0.2,0.0,0.003,0.0,-0.03\n0.5,0.5,0.003,0.001,0.0\n";
    set.write("theirs.csv", theirs);
    let message =
        set.error(&["ingest", "theirs.csv", "--preset", "mit-table", "-o", "./theirs.csv"]);
    assert_names(&message, &["belongs to the input theirs.csv", "name another output"]);
    assert_eq!(set.read("theirs.csv"), theirs);
    let robot = set.read(ROBOT);
    assert_names(&set.error(&["ingest", "set", "-o", ROBOT]), &["belongs to the input"]);
    assert_eq!(set.read(ROBOT), robot);
}

#[cfg(unix)]
#[test]
fn devices_are_no_input() {
    let set = SmallSet::new();
    for command in ["ingest", "inspect", "models init"] {
        let mut arguments: Vec<_> = command.split(' ').collect();
        arguments.push("/dev/zero");
        assert_names(&set.error(&arguments), &["/dev/zero: it is neither a file nor a folder"]);
    }
}

/// A pipe that nobody writes to would be waited for, a device read until memory is full.
#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused_wherever_a_file_is_read() {
    let set = SmallSet::new();
    set.done(&["ingest", "set", "-o", "steps.csv", "-q"]);
    set.done(&["models", "init", "set", "-q"]);
    let pipes = ["pipe.toml", "pipe.csv", "pipe.parquet", "pipe.json", "piped.toml"];
    for pipe in pipes {
        let status = std::process::Command::new("mkfifo").arg(set.path(pipe)).status();
        assert!(status.unwrap().success());
        let device = set.path(&pipe.replace("pipe", "zero"));
        std::os::unix::fs::symlink("/dev/zero", device).unwrap();
    }
    for file in ["pipe", "zero"] {
        let name = |ending: &str| format!("{file}.{ending}");
        for (arguments, ending) in [
            (vec!["describe"], "csv"),
            (vec!["describe"], "parquet"),
            (vec!["models", "show"], "toml"),
            (vec!["compare", "steps.csv", "--manifest"], "toml"),
            (vec!["compare", "steps.csv", "--mapping"], "toml"),
            (vec!["suggest", "-o", "list.csv", "--from"], "json"),
        ] {
            let path = name(ending);
            let run = set.ends(&[&arguments[..], &[&path]].concat());
            assert_eq!(run.code, Some(1), "{arguments:?} {path}: {}", run.stderr);
            assert_names(&run.stderr, &[&path]);
        }
    }
    for file in ["dataset.toml", "sessions.csv"] {
        let set = SmallSet::new();
        let path = set.path(&format!("set/{file}"));
        let _ = std::fs::remove_file(&path);
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        let run = set.ends(&["check", "set"]);
        assert_eq!(run.code, Some(1), "{file}: {}", run.stderr);
        assert_names(&run.stderr, &[file]);
    }
}

#[cfg(unix)]
#[test]
fn weights_that_are_a_pipe_are_refused() {
    let set = SmallSet::new();
    set.write(
        "gp.toml",
        "schema = \"pushlab.model/1\"\nname = \"a\"\n\n[base]\nkind = \"gp\"\n\n[learned]\n\
         weights = \"gp.weights.json\"\nsha256 = \"00\"\ninputs = [\"p\", \"beta_rad\"]\n",
    );
    let weights = set.path("gp.weights.json");
    assert!(std::process::Command::new("mkfifo").arg(weights).status().unwrap().success());
    let run = set.ends(&["models", "show", "gp.toml"]);
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert_names(&run.stderr, &["gp.weights.json"]);
}

#[test]
fn a_path_of_1000_km_is_refused_with_the_number_of_its_steps() {
    let set = SmallSet::new();
    set.done(&["models", "init", "set", "-q"]);
    let far = "kind = \"straight\"\nspeed_mm_s = 20\npoints_mm = [[-100, 0], [1000000000, 0]]\n";
    set.write("far.toml", far);
    let arguments = ["simulate", "far.toml", "--manifest", "set/dataset.toml", "-o", "out"];
    let run = set.ends(&arguments);
    assert_eq!(run.code, Some(1), "{}", run.stderr);
    assert_names(&run.stderr, &["steps along the path, at most 20000", "shorten the path"]);
}

#[test]
fn friction_beyond_any_material_is_refused_with_its_range() {
    let set = SmallSet::new();
    set.done(&["models", "init", "set", "-q"]);
    set.edit("model.toml", "value = 0.25", "value = 1e308");
    let message = set.error(&["models", "show", "model.toml"]);
    assert_names(&message, &["base.pusher_friction.value: must be from 0 to 10, got 1e308"]);
    set.edit("model.toml", "value = 1e308", "value = 0.25");
    set.edit("model.toml", "se = 0.0", "se = -1e9");
    let message = set.error(&["models", "show", "model.toml"]);
    assert_names(&message, &["base.pusher_friction.se: must be from 0 to 10, got -1000000000.0"]);
}

#[test]
fn a_broken_model_file_names_line_and_key() {
    let set = SmallSet::new();
    set.done(&["models", "init", "set", "-q"]);
    set.edit("model.toml", "value = 0.25", "value = -0.25");
    let message = set.error(&["models", "show", "model.toml"]);
    assert_names(&message, &["model.toml:", "base.pusher_friction.value", "got -0.25"]);
    set.edit("model.toml", "kind = \"analytical\"", "kind = \"magic\"");
    let message = set.error(&["models", "show", "model.toml"]);
    assert_names(
        &message,
        &["base.kind", "`magic` is not known", "analytical, gp, spgp, rff, vhgp, hybrid"],
    );
}
