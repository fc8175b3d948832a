//! The law of every writer: what it writes is read back, to the stated rounding.

use std::fs;

use proptest::prelude::{ProptestConfig, Strategy, prop, prop_assert, prop_assert_eq, proptest};

use super::all_writers;
use crate::error::DatasetError;
use crate::formats::list::format_by_id;
use crate::input::limits::ReadLimits;
use crate::recording::settings::Streams;
use crate::recording::{PoseStream, Recording, WrenchStream};

fn poses() -> impl Strategy<Value = PoseStream> {
    let sample = (0.0..2.0, -1.0..1.0, -1.0..1.0, -3.1..3.1);
    prop::collection::vec(sample, 1..20).prop_map(|samples: Vec<(f64, f64, f64, f64)>| PoseStream {
        t: samples.iter().map(|s| s.0).collect(),
        x: samples.iter().map(|s| s.1).collect(),
        y: samples.iter().map(|s| s.2).collect(),
        theta: samples.iter().map(|s| s.3).collect(),
        ..PoseStream::default()
    })
}

fn recordings() -> impl Strategy<Value = Recording> {
    // Times out of order and duplicated, as real streams are.
    (poses(), poses(), poses(), 0_i64..2_000_000_000, proptest::bool::ANY).prop_map(
        |(robot, object, forces, seconds, with_forces)| Recording {
            name: "push-0001".into(),
            path: "nowhere".into(),
            sha256: String::new(),
            epoch_ns: seconds * 1_000_000_000,
            robot,
            object,
            wrench: with_forces.then(|| WrenchStream {
                source: String::new(),
                t: forces.t,
                fx: forces.x,
                fy: forces.y,
                tz: forces.theta,
            }),
            remarks: Vec::new(),
        },
    )
}

/// Columns of a recording with the rounding of each; times count from the clock's zero.
fn columns(recording: &Recording) -> Vec<(Vec<f64>, f64)> {
    let mut columns = Vec::new();
    let mut times = |t: &[f64]| {
        // Counted from a day that both epochs share, to keep the digits.
        let day = recording.epoch_ns.rem_euclid(86_400_000_000_000) as f64 / 1e9;
        columns.push((t.iter().map(|t| t + day).collect::<Vec<_>>(), 1e-6));
    };
    times(&recording.robot.t);
    times(&recording.object.t);
    for stream in [&recording.robot, &recording.object] {
        for column in [&stream.x, &stream.y, &stream.theta] {
            columns.push((column.clone(), 1e-6));
        }
    }
    if let Some(wrench) = &recording.wrench {
        columns.push((wrench.fx.clone(), 1e-3));
        columns.push((wrench.fy.clone(), 1e-3));
        columns.push((wrench.tz.clone(), 1e-6));
    }
    columns
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn what_is_written_is_read_back(recording in recordings()) {
        let dir = tempfile::tempdir().unwrap();
        for writer in all_writers() {
            let folder = dir.path().join(writer.id());
            let path = writer.write(&recording, &folder).unwrap();
            let format = format_by_id(writer.format()).unwrap();
            prop_assert_eq!(format.find(&folder).unwrap(), [path.clone()]);
            let back = format.read(&path, &Streams::default(), &ReadLimits::default()).unwrap();
            prop_assert_eq!(&back.name, "push-0001");
            prop_assert_eq!(&back.remarks, &[], "{}", writer.id());
            let (before, after) = (columns(&recording), columns(&back));
            prop_assert_eq!(before.len(), after.len());
            for ((before, rounding), (after, _)) in before.iter().zip(&after) {
                prop_assert_eq!(before.len(), after.len());
                for (before, after) in before.iter().zip(after) {
                    // Half a unit of rounding, and the digits of an f64 time in MIT JSON.
                    let allowed = 0.5 * rounding + 2.5e-7;
                    prop_assert!((before - after).abs() <= allowed, "{}: {before} {after}", writer.id());
                }
            }
            // A second pass finds nothing left to round, so the bytes stay the same.
            let again = writer.write(&back, &dir.path().join("again")).unwrap();
            if path.is_file() && !["mit-json", "mit-hdf5"].contains(&writer.id()) {
                prop_assert_eq!(fs::read(&path).unwrap(), fs::read(again).unwrap());
            }
        }
    }
}

fn small() -> Recording {
    let poses = PoseStream {
        t: vec![0.5],
        x: vec![0.1],
        y: vec![-0.000_000_1],
        theta: vec![0.3],
        ..PoseStream::default()
    };
    Recording {
        name: "p".into(),
        path: "nowhere".into(),
        sha256: String::new(),
        epoch_ns: 1_000_000_000,
        robot: poses.clone(),
        object: poses,
        wrench: Some(WrenchStream {
            t: vec![0.25],
            fx: vec![1.0006],
            fy: vec![2.0],
            ..WrenchStream::default()
        }),
        remarks: Vec::new(),
    }
}

#[test]
fn csv_text_is_as_documented() {
    let dir = tempfile::tempdir().unwrap();
    let writer = all_writers().iter().find(|writer| writer.id() == "csv").unwrap();
    let path = writer.write(&small(), dir.path()).unwrap();
    let text = |name: &str| fs::read_to_string(path.join(name)).unwrap();
    assert_eq!(text("robot.csv"), "t_s,x_m,y_m,theta_rad\n1.500000,0.100000,0.000000,0.300000\n");
    assert_eq!(text("wrench.csv"), "t_s,fx_n,fy_n\n1.250000,1.001,2.000\n");
    let without = Recording { wrench: None, ..small() };
    writer.write(&without, dir.path()).unwrap();
    assert!(!path.join("wrench.csv").exists(), "forces of an earlier recording stay behind");
}

#[test]
fn messages_of_an_mcap_file_stand_in_the_order_of_time() {
    let dir = tempfile::tempdir().unwrap();
    for writer in all_writers().iter().filter(|writer| writer.format() == "mcap") {
        let bytes = fs::read(writer.write(&small(), dir.path()).unwrap()).unwrap();
        let messages = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap);
        let topics: Vec<_> = messages.map(|message| message.channel.topic.clone()).collect();
        assert_eq!(topics, ["/ft_sensor/wrench", "/robot/tip_pose", "/vicon/object_pose"]);
    }
}

#[test]
fn what_is_no_number_is_not_written() {
    let dir = tempfile::tempdir().unwrap();
    for writer in all_writers() {
        let mut recording = small();
        recording.object.x[0] = f64::NAN;
        let error = writer.write(&recording, dir.path()).unwrap_err();
        assert!(matches!(error, DatasetError::Unwritable { .. }));
        assert!(error.to_string().contains("sample 0 of the object stream is [0.5, NaN"));
        recording = small();
        recording.robot.x.push(1.0);
        let error = writer.write(&recording, dir.path()).unwrap_err().to_string();
        assert!(error.contains("the robot stream has columns of [1, 2, 1, 1] values"), "{error}");
    }
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 0);
}
