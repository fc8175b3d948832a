//! Faults of recordings, manifests and sets: each a named, counted repair, a reason, or an error.

use std::path::Path;

use crate::made::{HALF_SIDE, Made, manifest, write_set};
use dataset::{
    DatasetError, Exclusion, Flags, ForceZero, IngestReport, IngestSettings, Phase, Recording,
    RecordingSet, RepairKind, StreamRole, Table, UntaredReason, ingest,
};

fn try_run(recordings: &[Recording]) -> Result<(Table, IngestReport), DatasetError> {
    let dir = tempfile::tempdir().unwrap();
    write_set(dir.path(), "csv", recordings);
    ingest(&RecordingSet::open(dir.path()).unwrap(), &IngestSettings::default())
}

fn run(recording: Recording) -> (Table, IngestReport) {
    try_run(&[recording]).unwrap()
}

fn count(report: &IngestReport, stream: StreamRole, kind: RepairKind) -> u32 {
    let streams = &report.recordings[0].streams;
    let stream = streams.iter().find(|report| report.stream == stream).unwrap();
    stream.repairs.get(&kind).copied().unwrap_or_default()
}

/// Rows of a clean and a repaired recording agree within the noise that the repair leaves.
fn assert_same_rows(clean: &Table, repaired: &Table, tolerance: f64) {
    assert_eq!(clean.len(), repaired.len());
    for (a, b) in clean.rows.iter().zip(&repaired.rows) {
        for (a, b) in [(a.dx, b.dx), (a.dy, b.dy), (a.gap_end, b.gap_end)] {
            assert!((a - b).abs() < tolerance, "{a} {b}");
        }
    }
}

#[test]
fn rows_out_of_order_are_sorted_and_counted() {
    let clean = Made::default().recording("push");
    let mut shuffled = clean.clone();
    for (i, j) in [(20, 31), (60, 58), (90, 91)] {
        let object = &mut shuffled.object;
        for column in [&mut object.t, &mut object.x, &mut object.y, &mut object.theta] {
            column.swap(i, j);
        }
    }
    let (table, report) = run(shuffled);
    assert_eq!(count(&report, StreamRole::Object, RepairKind::Backward), 5);
    assert!(!report.recordings[0].streams[1].kept_row_order);
    assert_same_rows(&run(clean).0, &table, 1e-12);
}

#[test]
fn late_stamps_are_made_monotone_in_the_order_of_rows() {
    let clean = Made::default().recording("push");
    let mut late = clean.clone();
    // Two rows of a moving object arrive late: their stamps pass those of the rows after them.
    for i in [70, 80] {
        late.object.t[i] += 0.0125;
    }
    let (table, report) = run(late);
    let object = &report.recordings[0].streams[1];
    assert_eq!(object.repairs[&RepairKind::Backward], 2);
    assert!(object.kept_row_order);
    assert!((object.largest_step_back_s - 0.0025).abs() < 1e-9);
    assert_same_rows(&run(clean).0, &table, 1e-4);
}

#[test]
fn duplicated_stamps_are_merged_and_counted() {
    let clean = Made::default().recording("push");
    let mut doubled = clean.clone();
    for i in [100, 70, 40] {
        let object = &mut doubled.object;
        for column in [&mut object.t, &mut object.x, &mut object.y, &mut object.theta] {
            column.insert(i, column[i]);
        }
    }
    let (table, report) = run(doubled);
    assert_eq!(count(&report, StreamRole::Object, RepairKind::Duplicate), 3);
    assert_same_rows(&run(clean).0, &table, 1e-12);
}

#[test]
fn a_turn_across_pi_is_unwrapped_and_counted() {
    let made = Made { scene: planar::Pose::new(0.0, 0.0, -3.05), ..Made::default() };
    let mut recording = made.recording("push");
    let plain = run(recording.clone()).0;
    for theta in &mut recording.object.theta {
        *theta = planar::wrap_angle(*theta);
    }
    let (table, report) = run(recording);
    assert_eq!(count(&report, StreamRole::Object, RepairKind::Wrap), 1);
    // The digits of a wrapped angle are others.
    assert_same_rows(&plain, &table, 1e-7);
    assert!(table.rows.iter().all(|row| row.dtheta.abs() < 0.1));
}

#[test]
fn nothing_is_evaluated_across_a_gap() {
    let mut recording = Made::default().recording("push");
    let object = &mut recording.object;
    let gap = 66..76;
    for column in [&mut object.t, &mut object.x, &mut object.y, &mut object.theta] {
        column.drain(gap.clone());
    }
    let (table, report) = run(recording);
    assert_eq!(count(&report, StreamRole::Object, RepairKind::Gap), 1);
    let push = &report.recordings[0].pushes[0];
    let object = push.streams.iter().find(|stream| stream.stream == StreamRole::Object).unwrap();
    assert_eq!(object.repairs.get(&RepairKind::Gap), Some(&1));
    assert!((object.longest_gap_s - 0.11).abs() < 1e-9, "{}", object.longest_gap_s);
    // The gap from 0.65 to 0.76 s holds the boundary at 0.7 s between the first two steps.
    assert_eq!(push.steps_lost_in_gaps, 2);
    assert!(table.rows.iter().all(|row| row.step >= 2));
}

#[test]
fn a_gap_inside_a_step_is_flagged() {
    let mut recording = Made::default().recording("push");
    let object = &mut recording.object;
    for column in [&mut object.t, &mut object.x, &mut object.y, &mut object.theta] {
        column.drain(76..84);
    }
    let (table, _) = run(recording);
    let flagged: Vec<_> =
        table.rows.iter().filter(|row| row.flags.contains(Flags::OBJECT_GAP)).collect();
    assert_eq!(flagged.iter().map(|row| row.step).collect::<Vec<_>>(), [1]);
}

#[test]
fn an_impossible_jump_sets_the_push_aside() {
    let mut recording = Made::default().recording("push");
    for x in &mut recording.object.x[90..] {
        *x += 0.05;
    }
    let good = Made::default().recording("good");
    let (_, report) = try_run(&[good, recording]).unwrap();
    let push = &report.recordings[1].pushes[0];
    assert!(
        matches!(push.excluded, Some(Exclusion::Teleport { way_m }) if (way_m - 0.05).abs() < 1e-3),
        "{:?}",
        push.excluded
    );
    assert_eq!(report.summary.excluded["impossible jump"], 1);
    assert_eq!(report.summary.pushes_used, 1);
}

#[test]
fn a_push_with_few_object_samples_is_set_aside() {
    let sparse = Made { rates: [250.0, 25.0, 100.0], duration: 0.18, ..Made::default() };
    let good = Made::default().recording("good");
    let (table, report) = try_run(&[good, sparse.recording("sparse")]).unwrap();
    let push = &report.recordings[1].pushes[0];
    assert!(
        matches!(push.excluded, Some(Exclusion::TooFewObjectSamples { found: 4, needed: 6 })),
        "{:?}",
        push.excluded
    );
    assert!(table.rows.iter().all(|row| &*row.recording == "good"));
}

#[test]
fn a_pusher_that_never_comes_near_is_named() {
    let mut far = Made::default().recording("far");
    for x in &mut far.object.x {
        *x += 0.2;
    }
    let error = try_run(&[far]).unwrap_err();
    let DatasetError::NothingUsable { recordings, reason, .. } = &error else { panic!("{error}") };
    assert_eq!(*recordings, 1);
    assert!(reason.contains("the pusher comes no nearer than"), "{reason}");
}

#[test]
fn a_zero_that_jumps_leaves_geometry_to_decide() {
    let made = Made { zero: [0.0, 0.0], ..Made::default() };
    let mut recording = made.recording("push");
    let wrench = recording.wrench.as_mut().unwrap();
    for i in 0..wrench.t.len() {
        if wrench.t[i] < 0.2 {
            wrench.fx[i] -= 1.6;
        }
    }
    let (table, report) = run(recording);
    let ForceZero::Untared { reason: UntaredReason::ZeroJumps { change_n } } =
        report.recordings[0].force_zero
    else {
        panic!("{:?}", report.recordings[0].force_zero)
    };
    assert!((change_n - 1.6).abs() < 0.02, "{change_n}");
    assert!(table.rows.iter().all(|row| row.flags.contains(Flags::UNTARED)));
    let push = &report.recordings[0].pushes[0];
    assert!((push.contact_start_s - made.touch()).abs() < 0.02, "{}", push.contact_start_s);
}

#[test]
fn a_force_that_would_pull_is_not_trusted() {
    // The zero read before the push is lost during it: with it subtracted, the object would pull.
    let made = Made { force: [-1.5, 0.0], ..Made::default() };
    let (_, report) = run(made.recording("push"));
    assert!(
        matches!(
            report.recordings[0].force_zero,
            ForceZero::Untared { reason: UntaredReason::Pulls { normal_n } }
                if (normal_n + 1.5).abs() < 0.05
        ),
        "{:?}",
        report.recordings[0].force_zero
    );
}

#[test]
fn a_sensor_that_repeats_one_value_sees_no_contact() {
    let mut recording = Made::default().recording("push");
    let wrench = recording.wrench.as_mut().unwrap();
    wrench.fx.fill(1.54);
    wrench.fy.fill(0.54);
    let (table, report) = run(recording);
    assert_eq!(
        report.recordings[0].force_zero,
        ForceZero::Untared { reason: UntaredReason::Blind }
    );
    assert!(table.len() >= 5);
    assert_eq!(report.summary.untared["sees no contact"], 1);
}

#[test]
fn without_a_force_stream_geometry_alone_decides() {
    let made = Made::default();
    let mut recording = made.recording("push");
    recording.wrench = None;
    let (table, report) = run(recording);
    assert_eq!(report.recordings[0].force_zero, ForceZero::NoForce);
    assert!(table.rows.iter().all(|row| row.force.is_none()));
    let push = &report.recordings[0].pushes[0];
    assert!((push.contact_start_s - made.touch()).abs() < 0.02, "{}", push.contact_start_s);
}

#[test]
fn a_row_that_is_not_finite_is_dropped_and_named() {
    let dir = tempfile::tempdir().unwrap();
    write_set(dir.path(), "csv", &[Made::default().recording("push")]);
    let path = dir.path().join("pushes/push/object.csv");
    let text = std::fs::read_to_string(&path).unwrap();
    let mut lines: Vec<_> = text.lines().map(str::to_owned).collect();
    let stamp = lines[40].split(',').next().unwrap().to_owned();
    lines[40] = format!("{stamp},NaN,0.1,0.2");
    std::fs::write(&path, lines.join("\n")).unwrap();
    let set = RecordingSet::open(dir.path()).unwrap();
    let (_, report) = ingest(&set, &IngestSettings::default()).unwrap();
    let text = report.to_text();
    assert!(
        text.contains("1 of 181 rows excluded: a value is not finite, first at line 41"),
        "{text}"
    );
}

#[test]
fn a_file_that_cannot_be_read_is_set_aside_and_the_rest_is_used() {
    let dir = tempfile::tempdir().unwrap();
    write_set(dir.path(), "csv", &["a", "b"].map(|name| Made::default().recording(name)));
    std::fs::write(dir.path().join("pushes/b/object.csv"), "t_s,x_m,y_m,yaw\n1,2,3,4\n").unwrap();
    let set = RecordingSet::open(dir.path()).unwrap();
    let (_, report) = ingest(&set, &IngestSettings::default()).unwrap();
    let Some(Exclusion::Unreadable { error }) = &report.recordings[1].excluded else {
        panic!("{:?}", report.recordings[1].excluded)
    };
    assert!(error.contains("object.csv") && error.contains("theta_rad"), "{error}");
    assert_eq!(report.summary.pushes_used, 1);
}

#[test]
fn what_is_missing_is_named() {
    let error = |path: &Path| RecordingSet::open(path).err().unwrap().to_string();
    let dir = tempfile::tempdir().unwrap();
    let missing = dir.path().join("nowhere");
    let message = error(&missing);
    assert!(message.starts_with("cannot read ") && message.contains("nowhere"), "{message}");
    let message = error(dir.path());
    assert!(message.contains("no dataset.toml, and no preset fits (mit-push, "), "{message}");
    std::fs::write(dir.path().join("dataset.toml"), manifest("csv")).unwrap();
    let message = error(dir.path());
    assert!(message.contains("pushes"), "{message}");
    std::fs::create_dir(dir.path().join("pushes")).unwrap();
    let Err(DatasetError::NoRecordings { format, .. }) = RecordingSet::open(dir.path()) else {
        panic!("an empty set was opened")
    };
    assert_eq!(format, "csv");
}

#[test]
fn a_tracker_that_drifts_after_the_stop_makes_no_motion() {
    let made = Made::default();
    let mut recording = made.recording("push");
    let object = &mut recording.object;
    for (t, theta) in object.t.iter().zip(&mut object.theta) {
        *theta += 0.05 * (t - made.stop() - 0.15).max(0.0);
    }
    let (table, report) = run(recording);
    let push = &report.recordings[0].pushes[0];
    assert!((push.rest_s - made.stop()).abs() < 0.03, "{} {}", push.rest_s, made.stop());
    assert!(table.rows.iter().all(|row| row.phase == Phase::Contact));
}

#[test]
fn fast_motion_is_no_jump_and_an_outlier_is_one() {
    // 6 mm from sample to sample of the robot.
    let fast = Made { speed: 0.3, duration: 0.3, rates: [50.0, 100.0, 100.0], ..Made::default() };
    let (_, report) = run(fast.recording("push"));
    assert_eq!(count(&report, StreamRole::Robot, RepairKind::Jump), 0, "{}", report.to_text());
    let mut outlier = Made::default().recording("push");
    outlier.object.x[20] += 0.006;
    let (_, report) = run(outlier);
    assert_eq!(count(&report, StreamRole::Object, RepairKind::Jump), 2, "there and back");
    let largest = report.recordings[0].streams[1].largest_jump_m;
    assert!((largest - 0.006).abs() < 1e-5, "{largest}");
}

#[test]
fn a_robots_yaw_is_of_no_concern() {
    let clean = Made::default().recording("push");
    let mut spinning = clean.clone();
    for (i, theta) in spinning.robot.theta.iter_mut().enumerate() {
        *theta = if i % 3 == 0 { 3.1 } else { -2.9 };
    }
    let (table, report) = run(spinning);
    assert_eq!(report.recordings[0].streams[0].repairs.len(), 0);
    assert_eq!(table.rows, run(clean).0.rows);
}

#[test]
fn a_contact_that_is_lost_is_named() {
    let made = Made { yaw_rate: 0.0, ..Made::default() };
    let (_, report) = run(made.recording("push"));
    assert_eq!(report.summary.contacts_lost, 0);
    // A quarter of a second before the stop the object is kicked 6 mm ahead of the pusher.
    let mut recording = made.recording("push");
    let loss = made.stop() - 0.25;
    let along = made.scene.rotate(&nalgebra::Vector2::x());
    let object = &mut recording.object;
    for (i, t) in object.t.iter().enumerate() {
        let ahead = (0.2 * (t - loss)).clamp(0.0, 0.006);
        object.x[i] += ahead * along.x;
        object.y[i] += ahead * along.y;
    }
    let wrench = recording.wrench.as_mut().unwrap();
    for (i, _) in wrench.t.iter().enumerate().filter(|(_, t)| **t > loss) {
        (wrench.fx[i], wrench.fy[i]) = (made.zero[0], made.zero[1]);
    }
    let (_, report) = run(recording);
    let push = &report.recordings[0].pushes[0];
    assert!(push.contact_lost && (push.contact_end_s - loss).abs() < 0.02, "{push:?}");
    assert!(report.to_text().contains("1 pushes lose contact while the pusher goes on"));
}

#[test]
fn the_first_contact_is_known_though_the_first_step_is_lost() {
    let made = Made::default();
    let mut recording = made.recording("push");
    let object = &mut recording.object;
    for column in [&mut object.t, &mut object.x, &mut object.y, &mut object.theta] {
        column.drain(45..56);
    }
    let (table, report) = run(recording);
    assert!(table.rows[0].step > 0, "the step that begins in the gap is lost");
    let first = report.recordings[0].pushes[0].first_contact.unwrap();
    assert_eq!(first.edge, 1);
    assert!((first.p - (0.5 - made.contact_y / (2.0 * HALF_SIDE))).abs() < 1e-3, "{}", first.p);
    assert!(first.beta_rad.abs() < 1e-2, "{}", first.beta_rad);
    assert!((first.speed_m_s - made.speed).abs() < 1e-4, "{}", first.speed_m_s);
}

#[test]
fn a_sensor_that_rings_out_of_reach_is_not_in_contact() {
    let made = Made::default();
    let mut recording = made.recording("push");
    // Long before the touch, 4 mm away, the tool is accelerated; the force goes on to the touch.
    let wrench = recording.wrench.as_mut().unwrap();
    for (i, _) in wrench.t.iter().enumerate().filter(|(_, t)| (0.35..0.51).contains(*t)) {
        wrench.fx[i] += 1.0;
    }
    let (_, report) = run(recording);
    let push = &report.recordings[0].pushes[0];
    assert!(push.contact_start_s > made.touch() - 0.11, "{}", push.contact_start_s);
}

#[test]
fn poses_sent_twice_are_taken_once() {
    let made = Made { rates: [40.0, 100.0, 100.0], ..Made::default() };
    let clean = made.recording("push");
    let mut doubled = clean.clone();
    let robot = &mut doubled.robot;
    for column in [&mut robot.x, &mut robot.y, &mut robot.theta] {
        *column = column.iter().flat_map(|value| [*value, *value]).collect();
    }
    robot.t = robot.t.iter().flat_map(|t| [*t, t + 0.0125]).collect();
    let (table, report) = run(doubled);
    // The pusher moves for 1.2 s; at rest a pose that stays is no repeat.
    let repeated = count(&report, StreamRole::Robot, RepairKind::Repeated);
    assert!((46..=48).contains(&repeated), "{repeated}");
    // Poses kept at rest change the curve by 14 µm at the kinks; half a repeat's way is 125 µm.
    assert_same_rows(&run(clean).0, &table, 2e-5);
}
