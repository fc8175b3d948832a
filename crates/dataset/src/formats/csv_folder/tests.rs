//! CSV folders, right and wrong.

use std::fs;

use super::{CsvFormat, decimal_nanoseconds};
use crate::formats::format::LogFormat;
use crate::input::limits::ReadLimits;
use crate::recording::Recording;
use crate::recording::settings::Streams;
use crate::{
    error::DatasetError,
    remark::{RemarkKind, StreamRole},
};

const ROBOT: &str = "t_s,x_m,y_m\n12.5,0.1,0.2\n12.25,0.3,0.4\n";
const OBJECT: &str = "t_s,x_m,y_m,theta_rad\n12.5,1,2,3\n";

fn read_with(files: &[(&str, &str)], settings: &str) -> Result<Recording, DatasetError> {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("push-7");
    fs::create_dir(&folder).unwrap();
    for (name, text) in files {
        fs::write(folder.join(name), text).unwrap();
    }
    CsvFormat.read(&folder, &toml::from_str::<Streams>(settings).unwrap(), &ReadLimits::default())
}

fn read_object(text: &str) -> Result<Recording, DatasetError> {
    read_with(&[("robot.csv", ROBOT), ("object.csv", text)], "")
}

#[test]
fn rows_become_streams_in_their_own_order() {
    let wrench = "t_s,fx_n,fy_n,tz_nm\n12.000001,1,2,0.5\n";
    let files = [("robot.csv", ROBOT), ("object.csv", OBJECT), ("wrench.csv", wrench)];
    let recording = read_with(&files, "").unwrap();
    assert_eq!((recording.name.as_str(), recording.epoch_ns), ("push-7", 12_000_000_000));
    assert_eq!((recording.robot.t.as_slice(), recording.robot.x[1]), (&[0.5, 0.25][..], 0.3));
    assert_eq!(recording.robot.theta, [0.0, 0.0]);
    assert_eq!(recording.object.theta, [3.0]);
    let wrench = recording.wrench.unwrap();
    assert_eq!((wrench.t[0], wrench.fx[0], wrench.tz[0]), (1e-6, 1.0, 0.5));
    assert_eq!(recording.remarks, []);
}

#[test]
fn foreign_columns_are_mapped_to_si_and_to_the_world() {
    let robot = "X [mm],Y [mm],stamp [ms],unit\n100,200,1500.5,mm\n";
    let settings = r#"
        [robot.columns]
        t = { column = "stamp [ms]", scale = 1e-3 }
        x = { column = "X [mm]", scale = 1e-3, offset = 1.0 }
        y = { column = "Y [mm]", scale = 1e-3 }
        [robot.transform]
        translation_m = [10.0, 20.0]
        yaw_rad = 1.5707963267948966
    "#;
    // The column without a number is not asked for and so may hold anything.
    let recording = read_with(&[("robot.csv", robot), ("object.csv", OBJECT)], settings).unwrap();
    assert_eq!(recording.epoch_ns, 1_000_000_000);
    assert_eq!(recording.robot.t, [0.5005]);
    assert!((recording.robot.x[0] - 9.8).abs() < 1e-12, "{}", recording.robot.x[0]);
    assert!((recording.robot.y[0] - 21.1).abs() < 1e-12, "{}", recording.robot.y[0]);
    assert!((recording.robot.theta[0] - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
}

#[test]
fn a_sensor_frame_is_turned_by_signs_and_transform() {
    let wrench = "t_s,fx_n,fy_n,fz_n,tx_nm,ty_nm,tz_nm\n12,1,2,3,0.1,0.2,0.3\n";
    let files = [("robot.csv", ROBOT), ("object.csv", OBJECT), ("wrench.csv", wrench)];
    let signed = "[wrench]\nframe = \"sensor\"\nsigns = [\"-x\", \"+y\", \"-z\"]\n";
    let read = read_with(&files, signed).unwrap().wrench.unwrap();
    assert_eq!((read.fx[0], read.fy[0], read.tz[0]), (-1.0, 2.0, -0.3));
    // A quarter turn and an arm of 1 m along x: torque grows by the force along y.
    let turned = format!(
        "{signed}transform = {{ translation_m = [1.0, 0.0], yaw_rad = 1.5707963267948966 }}\n"
    );
    let read = read_with(&files, &turned).unwrap().wrench.unwrap();
    let expected = [-2.0, -1.0, -1.3];
    for (value, expected) in [read.fx[0], read.fy[0], read.tz[0]].into_iter().zip(expected) {
        assert!((value - expected).abs() < 1e-12, "{value} {expected}");
    }
    let planar = "t_s,fx_n,fy_n\n12,1,2\n";
    let files = [("robot.csv", ROBOT), ("object.csv", OBJECT), ("wrench.csv", planar)];
    let error = read_with(&files, "[wrench]\nframe = \"sensor\"\nsigns = [\"z\", \"y\", \"x\"]\n");
    assert!(error.unwrap_err().to_string().contains("need fz"));
}

#[test]
fn a_wrong_column_names_file_line_and_key() {
    let error = read_object("t_s,x_m,y_m\n1,2,3\n").unwrap_err();
    assert!(matches!(error, DatasetError::Parse { line: 1, .. }));
    let message = error.to_string();
    assert!(
        message.ends_with(
            "object.csv:1: no column `theta_rad` among t_s, x_m, y_m; set \
             streams.object.columns.theta"
        ),
        "{message}"
    );
}

#[test]
fn wrong_text_and_short_rows_name_their_line() {
    let error = read_object("t_s,x_m,y_m,theta_rad\n1,2,3,4\n1,\"2,5\",3,4\n").unwrap_err();
    assert!(
        error.to_string().contains("object.csv:3: `2,5` in column x_m is no number"),
        "{error}"
    );
    let error = read_object("t_s,x_m,y_m,theta_rad\n1,2,3,4\n1,2\n").unwrap_err();
    assert!(error.to_string().contains("object.csv:3: 2 fields where the first line has 4"));
    let error = read_object("").unwrap_err();
    assert!(error.to_string().contains("object.csv:1: the file is empty"), "{error}");
    let error = read_object("t_s,x_m,y_m,theta_rad\n").unwrap_err();
    assert!(matches!(error, DatasetError::NoSamples { stream: StreamRole::Object, .. }));
    assert!(error.to_string().contains("the object stream (object.csv) has no samples"));
}

#[test]
fn rows_that_are_not_finite_are_set_aside_and_counted() {
    let rows = "t_s,x_m,y_m,theta_rad\n1,2,3,4\n2,NaN,3,4\nnan,2,3,4\n4,2,3,4\n5,2,3,4\n";
    let recording = read_object(rows).unwrap();
    assert_eq!(recording.object.t, [0.0, 3.0, 4.0]);
    let remark = &recording.remarks[0];
    assert_eq!((remark.kind, remark.count), (RemarkKind::NonFiniteExcluded, 2));
    assert_eq!(remark.text, "2 of 5 rows excluded: a value is not finite, first at line 3");
    let error = read_object("t_s,x_m,y_m,theta_rad\n1,inf,3,4\n2,NaN,3,4\n3,2,3,4\n").unwrap_err();
    assert!(matches!(error, DatasetError::MostlyUnusable { excluded: 2, total: 3, .. }));
    assert!(error.to_string().contains("not finite, first at line 2; check the sensor"), "{error}");
}

#[test]
fn a_missing_file_is_named() {
    let error = read_with(&[("robot.csv", ROBOT)], "").unwrap_err();
    assert!(matches!(error, DatasetError::Io { action: "read", .. }));
    assert!(error.to_string().contains("object.csv"), "{error}");
    let error = read_with(
        &[("robot.csv", ROBOT), ("object.csv", OBJECT)],
        "[object]\ntransform = { tf_parent = \"world\", tf_child = \"vicon\" }\n",
    );
    let message = error.unwrap_err().to_string();
    assert!(message.contains("no frame `world ← vicon` for the object stream"), "{message}");
}

#[test]
fn folders_are_found_in_order() {
    let dir = tempfile::tempdir().unwrap();
    // The last is what a killed run leaves.
    for name in ["b", "a", "c", ".b.x1y2z3.part"] {
        fs::create_dir(dir.path().join(name)).unwrap();
    }
    for name in ["b", "a", ".b.x1y2z3.part"] {
        fs::write(dir.path().join(name).join("robot.csv"), ROBOT).unwrap();
    }
    let found = CsvFormat.find(dir.path()).unwrap();
    assert_eq!(found, [dir.path().join("a"), dir.path().join("b")]);
    assert_eq!(CsvFormat.find(&found[0]).unwrap(), [found[0].clone()]);
    let inspection = CsvFormat.inspect(&found[0], &ReadLimits::default()).unwrap();
    assert_eq!(inspection.streams[0].columns, ["t_s", "x_m", "y_m"]);
    assert_eq!(inspection.streams[0].fits, [StreamRole::Robot]);
    assert_eq!(inspection.streams[0].rate_hz, Some(4.0));
    let error = CsvFormat.find(&dir.path().join("c")).unwrap_err();
    assert!(matches!(error, DatasetError::NoRecordings { format: "csv", .. }), "{error}");
}

#[test]
fn decimal_times_are_exact() {
    assert_eq!(decimal_nanoseconds("1476728847.652993"), Some(1_476_728_847_652_993_000));
    assert_eq!(decimal_nanoseconds("3"), Some(3_000_000_000));
    for other in ["-1.0", "1e3", "", ".5", "1.0000000001", "9999999999999"] {
        assert_eq!(decimal_nanoseconds(other), None, "{other}");
    }
}
