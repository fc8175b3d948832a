//! Pushes of which the object's poses before and after are known: from files to rows.

use std::fs;
use std::path::Path;

use dataset::{
    Flags, IngestReport, IngestSettings, ObjectSpec, Preset, RecordingSet, Table, all_formats,
    ingest, is_end_points,
};
use nalgebra::Vector2;

const MANIFEST: &str = r#"name = "ends"
[object]
shape = "square"
side_m = 0.09
mass_kg = 0.8
[pusher]
radius_m = 0.005
friction = 0.25
[support]
friction = 0.25
[recordings]
format = "endpoints"
"#;
const POSES: &str = "push,x0_m,y0_m,theta0_rad,x1_m,y1_m,theta1_rad";
const ENDS: &str = "tip_x0_m,tip_y0_m,tip_x1_m,tip_y1_m,dt_s";

/// A folder with these files.
fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    for (name, text) in files {
        fs::write(dir.path().join(name), text).unwrap();
    }
    dir
}

fn ingested(files: &[(&str, &str)]) -> (Table, IngestReport) {
    let dir = folder(files);
    fs::write(dir.path().join("dataset.toml"), MANIFEST).unwrap();
    ingest(&RecordingSet::open(dir.path()).unwrap(), &IngestSettings::default()).unwrap()
}

/// What is said of a set of which nothing can be used.
fn refused(files: &[(&str, &str)]) -> String {
    let dir = folder(files);
    fs::write(dir.path().join("dataset.toml"), MANIFEST).unwrap();
    let set = RecordingSet::open(dir.path()).unwrap();
    let error = ingest(&set, &IngestSettings::default()).unwrap_err().to_string();
    error.replace(dir.path().to_str().unwrap(), "SET")
}

/// A push of the square along +x, with the pusher 2 mm away at first, and one that passes by.
fn two() -> String {
    format!(
        "{POSES},{ENDS}\n4,0.1,0,0,0.118,0,0.1,0.048,0.01,0.07,0.01,2\n\
         7,0.1,0,0,0.1,0,0,0.048,0.06,0.148,0.06,2\n"
    )
}

#[test]
fn a_push_is_a_row_from_before_the_touch_to_the_end() {
    let (table, report) = ingested(&[("ends.csv", &two())]);
    let [pushed, passed] = &table.rows[..] else { panic!("{table:?}") };
    assert_eq!((&*pushed.recording, pushed.push, pushed.step), ("ends", 4, 0));
    assert_eq!(pushed.flags, Flags::WHOLE_PUSH);
    assert_eq!((pushed.edge, pushed.dt), (1, 2.0));
    assert_eq!(pushed.pusher_start, Vector2::new(0.048, 0.01));
    assert_eq!(pushed.pusher_end, Vector2::new(0.07, 0.01));
    // The face is at 55 mm, so that the center of the pusher touches it from 50 mm on.
    assert!((pushed.gap_start - 2e-3).abs() < 1e-12 && (pushed.speed - 0.011).abs() < 1e-12);
    assert!((pushed.p - (0.5 - 0.01 / 0.09)).abs() < 1e-5 && pushed.beta.abs() < 1e-12);
    assert!((pushed.dx - 0.018).abs() < 1e-12 && pushed.dy.abs() < 1e-12);
    assert!((pushed.dtheta - 0.1).abs() < 1e-12 && pushed.pusher_way.is_empty());
    // It comes within 10 mm of the outline, and moves nothing: a push like any other.
    assert!((passed.dx.abs() + passed.dtheta.abs()) < 1e-12 && passed.flags == Flags::WHOLE_PUSH);
    assert_eq!(report.summary.pushes_used, 2);
    assert!(report.recordings[0].pushes[1].contact_lost);
}

#[test]
fn a_way_keeps_the_points_that_bend_it_through_both_kinds_of_table() {
    // Straight at a constant speed for 1 s, then to the left; samples on the line add nothing.
    let pushes = format!("{POSES}\n0,0.1,0,0,0.11,0.001,0.1\n1,0.1,0,0,0.11,0.001,0.1\n");
    let mut tip = "push,t_s,x_m,y_m\n".to_owned();
    for push in 0..2 {
        for (t, x, y) in
            [(0.5, 0.048, 0.0), (1.0, 0.053, 0.0), (1.5, 0.058, 0.0), (2.0, 0.06, 0.01)]
        {
            tip += &format!("{push},{t},{x},{y}\n");
        }
    }
    let (table, _) = ingested(&[("pushes.csv", &pushes), ("tip.csv", &tip)]);
    let row = &table.rows[0];
    assert_eq!(row.t, 0.5);
    assert_eq!(row.pusher_way, [(1.0, Vector2::new(0.058, 0.0))]);
    let dir = tempfile::tempdir().unwrap();
    let names = ["steps.csv", "steps.parquet"];
    for name in &names[..if cfg!(feature = "parquet") { 2 } else { 1 }] {
        let path = dir.path().join(name);
        table.write(&path).unwrap();
        assert_eq!(Table::read(&path).unwrap(), table, "{name}");
    }
    let text = fs::read_to_string(dir.path().join("steps.csv")).unwrap();
    assert!(text.contains("flags,pusher_way\n") && text.contains(",1 0.058 0\n"), "{text}");
    fs::write(dir.path().join("steps.csv"), text.replace(",1 0.058 0\n", ",1 0.058\n")).unwrap();
    let error = Table::read(&dir.path().join("steps.csv")).unwrap_err().to_string();
    assert!(error.contains("pusher_way is `1 0.058`, expected `t x y` joined by `;`"), "{error}");
}

#[test]
fn the_force_counts_from_where_it_sets_in() {
    let pushes = format!("{POSES}\n0,0.1,0,0,0.1,0,0.1\n1,0.1,0,0,0.11,0,0\n");
    let (mut tip, mut wrench) =
        ("push,t_s,x_m,y_m\n".to_owned(), "push,t_s,fx_n,fy_n\n".to_owned());
    for push in 0..2 {
        tip += &format!("{push},0,0.046,0\n{push},2,0.066,0\n");
        for k in 0..200 {
            let force = if k < 60 { 0.01 } else { 2.0 };
            wrench += &format!("{push},{},{force},0.5\n", f64::from(k) * 0.01);
        }
    }
    let files = [("pushes.csv", &*pushes), ("tip.csv", &*tip), ("wrench.csv", &*wrench)];
    let (table, report) = ingested(&files);
    let row = &table.rows[1];
    // The outline says where the push begins: the clock of a force may lag.
    assert_eq!((row.t, row.flags), (0.0, Flags::WHOLE_PUSH));
    assert!((row.pusher_start.x - 0.046).abs() < 1e-9 && (row.gap_start - 4e-3).abs() < 1e-9);
    let force = row.force.unwrap().mean;
    assert!((force.normal - 2.0).abs() < 1e-9 && (force.tangential - 0.5).abs() < 1e-9);
    assert_eq!(report.recordings[0].pushes[1].steady_force_n, Some(2.0_f64.hypot(0.5)));
    // Without the file there is none.
    let (table, _) = ingested(&files[..2]);
    assert!(table.rows[1].force.is_none() && table.rows[1].gap_start == row.gap_start);
}

#[test]
fn flips_of_the_tracking_and_pushes_without_a_way_are_named() {
    let rows = "0,0.1,0,0,0.118,0,0.1,0.048,0.01,0.07,0.01,2\n\
                1,0.1,0,0,0.1,0,1.6,0.03,0.01,0.04,0.01,2\n\
                2,0.1,0,0,0.13,0,0,0.02,0.01,0.04,0.01,2\n\
                3,0.1,0,0,0.13,0,0,0.05,0.01,0.05,0.01,2\n";
    let (table, report) = ingested(&[("ends.csv", &format!("{POSES},{ENDS}\n{rows}"))]);
    assert_eq!(table.rows.len(), 1);
    assert_eq!(report.summary.excluded["tracking flip"], 2);
    assert_eq!(report.summary.excluded["no way of the pusher"], 1);
    let text = report.to_text();
    assert!(
        text.contains("turns by 91.7° and moves by 0.0 mm while the pusher goes 0.0 mm"),
        "{text}"
    );
    assert!(text.contains("moves by 30.0 mm"), "{text}");
}

#[test]
fn impossible_files_are_named_with_line_column_and_value() {
    let ends = |text: String| refused(&[("ends.csv", &text)]);
    let two = two();
    for (from, to, says) in [
        ("0.118", "0,118", "ends.csv:2: "),
        ("0.118", "12mm", "ends.csv:2: x1_m is `12mm`, expected a finite number, in SI units"),
        ("0.118", "inf", "ends.csv:2: x1_m is `inf`, expected a finite number"),
        ("\n7,", "\n4,", "ends.csv:3: push is 4, as in line 2; number the pushes"),
        ("\n7,", "\n-7,", "ends.csv:3: push is `-7`, expected a whole number"),
        (",2\n7", ",0\n7", "ends.csv:2: dt_s is `0`, expected a number above 0"),
        (",dt_s", ",seconds", "no column `dt_s`; the table has: push, x0_m"),
        ("tip_y1_m", "tip_y", "no column `tip_y1_m`"),
    ] {
        assert!(two.contains(from));
        let error = ends(two.replacen(from, to, 1));
        assert!(error.contains(says), "{says}: {error}");
    }
    let pushes = format!("{POSES}\n0,0.1,0,0,0.11,0,0\n1,0.1,0,0,0.11,0,0\n");
    let tip = "push,t_s,x_m,y_m\n0,0,0.05,0\n0,1,0.06,0\n";
    let with = |tip: &str| refused(&[("pushes.csv", &pushes), ("tip.csv", tip)]);
    for (from, to, says) in [
        ("0,1,", "0,0,", "tip.csv:3: t_s is 0, after 0 of the same push; times must increase"),
        ("0,1,", "9,1,", "tip.csv:3: push is 9, which is not in pushes.csv"),
        ("0.06", "six", "tip.csv:3: x_m is `six`, expected a finite number"),
        ("x_m", "x_mm", "tip.csv: no column `x_m`; the table has: push, t_s, x_mm, y_m"),
    ] {
        let error = with(&tip.replacen(from, to, 1));
        assert!(error.contains(says), "{says}: {error}");
    }
    let both = refused(&[("pushes.csv", &two), ("tip.csv", tip)]);
    assert!(
        both.contains("pushes.csv:1: the ends of the pusher's way are in columns and in tip.csv")
    );
}

#[test]
fn a_file_of_several_shapes_is_a_recording_each_or_about_one() {
    let row = "0.1,0,0,0.118,0,0.1,0.048,0.01,0.07,0.01\n";
    let mut text = "surface,shape,v_mm_s,push,obj_x0,obj_y0,obj_th0,obj_x1,obj_y1,obj_th1,tip_x0,\
                    tip_y0,tip_x1,tip_y1\n"
        .to_owned();
    for (shape, n) in [("rect1", 3), ("rect2", 2)] {
        (0..n).for_each(|push| text += &format!("abs,{shape},20,{push},{row}"));
    }
    let dir = folder(&[("abs.csv", &text)]);
    let path = dir.path().join("abs.csv");
    assert!(is_end_points(&path) && !is_end_points(dir.path()));
    let of = |path: &Path| RecordingSet::open_with_preset(path, Preset::MitEndpoints).unwrap();
    let (table, _) = ingest(&of(dir.path()), &IngestSettings::default()).unwrap();
    let names: Vec<&str> = table.rows.iter().map(|row| &*row.recording).collect();
    let [first, second] = ["abs_shape=rect1_v=20", "abs_shape=rect2_v=20"];
    assert_eq!(names, [first, first, first, second, second]);
    assert!((table.rows[0].dt - 1.1).abs() < 1e-12 && &*table.rows[4].shape == "rect2");
    let set = of(&path).about(ObjectSpec::mit("rect1").unwrap()).unwrap();
    let (table, report) = ingest(&set, &IngestSettings::default()).unwrap();
    assert_eq!(table.rows.len(), 3);
    assert_eq!(report.summary.excluded["other shape"], 2);
    let text = report.to_text();
    assert!(text.contains("excluded: 2 pushes of rect2, the set is about rect1"), "{text}");
    let source = table.provenance.get("source").unwrap();
    assert!(source.ends_with("abs.csv (abs_shape=rect1_v=20)"), "{source}");
}

#[test]
fn end_points_are_found_by_their_header_alone() {
    let format = all_formats().iter().find(|format| format.id() == "endpoints").unwrap();
    let dir = folder(&[("a.csv", &two()), ("b.csv", "push,x_m\n"), ("c.txt", &two())]);
    assert_eq!(format.find(dir.path()).unwrap(), [dir.path().join("a.csv")]);
    let fixtures = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/pushes");
    let logs = RecordingSet::open(fixtures.as_ref()).unwrap();
    let error = logs.about(ObjectSpec::mit("hex").unwrap()).err().unwrap().to_string();
    assert!(error.contains("do not tell pushes of hex from others"), "{error}");
}
