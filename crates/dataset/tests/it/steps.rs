//! From recordings with a known motion to rows: values, signs, symmetries, formats, threads.

use crate::made::{HALF_SIDE, Made, RADIUS, write_set};
use dataset::{
    Curve, Flags, ForceZero, IngestReport, IngestSettings, Phase, Recording, RecordingSet,
    RecordingWriter, StepLength, StepRow, Table, all_writers, ingest, ingest_each, provenance,
};
use nalgebra::Vector2;
use planar::{Pose, perpendicular};

fn run_set(recordings: &[Recording], settings: &IngestSettings) -> (Table, IngestReport) {
    let dir = tempfile::tempdir().unwrap();
    write_set(dir.path(), "csv", recordings);
    ingest(&RecordingSet::open(dir.path()).unwrap(), settings).unwrap()
}

fn run(made: Made) -> (Table, IngestReport) {
    run_set(&[made.recording("push-0000")], &IngestSettings::default())
}

fn assert_near(got: f64, want: f64, tolerance: f64, what: &str) {
    assert!((got - want).abs() <= tolerance, "{what}: {got}, expected {want} ± {tolerance}");
}

#[test]
fn a_known_push_becomes_its_steps() {
    let made = Made::default();
    let (table, report) = run(made);
    let push = &report.recordings[0].pushes[0];
    assert_near(push.contact_start_s, made.touch(), 0.01, "start of contact");
    assert_near(push.contact_end_s, made.stop(), 0.011, "end of contact");
    assert_near(push.rest_s, made.stop(), 0.02, "rest");
    assert_eq!(table.rows.iter().filter(|row| row.dt == 0.2).count(), 5);
    for row in &table.rows[1..4] {
        let t0 = row.t - 1000.0;
        let (start, end) = (made.object(t0), made.object(t0 + 0.2));
        let along = Pose::new(0.0, 0.0, made.scene.angle).rotate(&Vector2::x());
        let moved = end.position - start.position;
        assert_near(row.dx, moved.dot(&along), 2e-6, "dx");
        assert_near(row.dy, moved.dot(&perpendicular(&along)), 2e-6, "dy");
        assert_near(row.dtheta, made.yaw_rate * 0.2, 1e-5, "dtheta");
        assert_eq!((row.edge, row.phase), (1, Phase::Contact));
        assert_near(row.p, 0.5 - made.contact_y / (2.0 * HALF_SIDE), 1e-4, "p");
        let turned = made.yaw_rate * (t0 - made.touch());
        assert_near(row.beta, -turned, 1e-4, "beta");
        assert_near(row.speed, made.speed, 5e-6, "speed");
        assert_near(row.gap_start, 0.0, 2e-6, "gap");
        assert_near(row.slip, 0.0, 1e-5, "slip");
        assert_near(row.since_contact, t0 - made.touch(), 0.01, "time since contact");
        assert_near(row.object_twist.angular, made.yaw_rate, 1e-3, "yaw rate");
        assert_near(row.pusher_acceleration.norm(), 0.0, 1e-3, "acceleration");
        let force = row.force.unwrap();
        assert_near(force.mean.normal, made.force[0], 5e-3, "normal force");
        assert_near(force.mean.tangential, made.force[1], 5e-3, "tangential force");
        assert_near(force.start.normal, made.force[0], 0.02, "normal force at the start");
    }
}

/// A set of one recording whose manifest has a point for a pusher.
fn run_point(made: Made) -> (Table, IngestReport) {
    let dir = tempfile::tempdir().unwrap();
    write_set(dir.path(), "csv", &[made.recording("push-0000")]);
    let path = dir.path().join("dataset.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let point = text.replace(&format!("radius_m = {RADIUS}"), "radius_m = 0.0");
    assert_ne!(point, text);
    std::fs::write(&path, point).unwrap();
    ingest(&RecordingSet::open(dir.path()).unwrap(), &IngestSettings::default()).unwrap()
}

#[test]
fn a_point_pushes_like_any_pusher_even_where_it_seems_to_be_inside() {
    // On the outline, and a tracking error outside and inside of it.
    for radius in [0.0, 2e-5, -2e-5] {
        let made = Made { radius, ..Made::default() };
        let (table, report) = run_point(made);
        assert!(report.summary.excluded.is_empty(), "{radius}: {:?}", report.summary.excluded);
        let push = &report.recordings[0].pushes[0];
        assert_near(push.contact_start_s, made.touch(), 0.01, "start of contact");
        assert_near(push.contact_end_s, made.stop(), 0.011, "end of contact");
        assert_eq!(table.rows.iter().filter(|row| row.dt == 0.2).count(), 5, "{radius}");
        for row in &table.rows[1..4] {
            let t0 = row.t - 1000.0;
            assert_eq!((row.edge, row.phase), (1, Phase::Contact));
            assert_near(row.p, 0.5 - made.contact_y / (2.0 * HALF_SIDE), 1e-4, "p");
            assert_near(row.beta, -made.yaw_rate * (t0 - made.touch()), 3e-4, "beta");
            assert_near(row.dtheta, made.yaw_rate * 0.2, 1e-5, "dtheta");
            assert_near(row.gap_start, radius, 2e-6, "gap");
            assert_near(row.slip, 0.0, 2e-5, "slip");
            let normal = made.object(t0).rotate(&Vector2::x());
            assert_near(row.contact_normal.dot(&normal), 1.0, 1e-6, "normal");
            let force = row.force.unwrap();
            assert_near(force.mean.normal, made.force[0], 5e-3, "normal force");
            assert_near(force.mean.tangential, made.force[1], 5e-3, "tangential force");
        }
    }
}

#[test]
fn the_zero_of_the_force_is_found_and_reported() {
    let (_, report) = run(Made::default());
    let ForceZero::Tared { offset_n, noise_sd_n, n_samples } = report.recordings[0].force_zero
    else {
        panic!("{:?}", report.recordings[0].force_zero)
    };
    assert_near(offset_n[0], 0.4, 3e-3, "zero x");
    assert_near(offset_n[1], -0.7, 3e-3, "zero y");
    assert!((1e-3..6e-3).contains(&noise_sd_n) && n_samples > 20, "{noise_sd_n} {n_samples}");
    assert_near(report.summary.steady_force_n.unwrap().median, 2.0f64.hypot(0.3), 0.01, "steady");
}

#[test]
fn rows_do_not_depend_on_where_the_table_stands() {
    let (here, _) = run(Made::default());
    let there = Made { scene: Pose::new(-1.0, 2.0, -2.9), ..Made::default() };
    let (there, _) = run(there);
    assert_eq!(here.len(), there.len());
    for (a, b) in here.rows.iter().zip(&there.rows) {
        for (what, a, b) in invariants(a, b) {
            // The noise of the force moves the moment of first contact by some 0.1 ms.
            assert_near(b, a, if what == "force" { 0.02 } else { 3e-4 * (1.0 + a.abs()) }, what);
        }
    }
}

fn invariants<'a>(a: &'a StepRow, b: &'a StepRow) -> Vec<(&'static str, f64, f64)> {
    vec![
        ("dx", 100.0 * a.dx, 100.0 * b.dx),
        ("dy", 100.0 * a.dy, 100.0 * b.dy),
        ("dtheta", a.dtheta, b.dtheta),
        ("p", a.p, b.p),
        ("beta", a.beta, b.beta),
        ("gap", a.gap_end, b.gap_end),
        ("force", a.force.unwrap().mean.normal, b.force.unwrap().mean.normal),
    ]
}

#[test]
fn a_mirrored_push_has_mirrored_signs() {
    let made = Made { zero: [0.0, 0.0], ..Made::default() };
    let (straight, _) = run(made);
    let (mirrored, _) = run(Made { mirrored: true, ..made });
    assert_eq!(straight.len(), mirrored.len());
    for (a, b) in straight.rows.iter().zip(&mirrored.rows) {
        assert_eq!(a.edge, b.edge);
        let (fa, fb) = (a.force.unwrap().mean, b.force.unwrap().mean);
        assert_near(b.p, 1.0 - a.p, 1e-5, "p");
        assert_near(b.beta, -a.beta, 1e-5, "beta");
        assert_near(b.dx, a.dx, 1e-5, "dx");
        assert_near(b.dy, -a.dy, 1e-5, "dy");
        assert_near(b.dtheta, -a.dtheta, 1e-5, "dtheta");
        assert_near(fb.normal, fa.normal, 0.02, "normal force");
        assert_near(fb.tangential, -fa.tangential, 0.02, "tangential force");
    }
}

#[test]
fn each_contact_of_a_recording_is_a_push() {
    let made = Made { yaw_rate: 0.0, ..Made::default() };
    let first = made.recording("two");
    let moved =
        Made { scene: made.scene * Pose::new(made.speed * made.duration, 0.0, 0.0), ..made };
    let second = moved.recording("two");
    // Between the pushes the pusher backs off in one sample, far faster than it pushes.
    let mut both = first.clone();
    let later = first.object.t.last().unwrap() + 0.02;
    let append = |to: &mut Vec<f64>, from: &[f64], shift: f64| {
        to.extend(from.iter().map(|value| value + shift));
    };
    for (to, from) in [(&mut both.robot, &second.robot), (&mut both.object, &second.object)] {
        append(&mut to.t, &from.t, later);
        append(&mut to.x, &from.x, 0.0);
        append(&mut to.y, &from.y, 0.0);
        append(&mut to.theta, &from.theta, 0.0);
    }
    let (to, from) = (both.wrench.as_mut().unwrap(), second.wrench.as_ref().unwrap());
    append(&mut to.t, &from.t, later);
    append(&mut to.fx, &from.fx, 0.0);
    append(&mut to.fy, &from.fy, 0.0);
    let (table, report) = run_set(&[both], &IngestSettings::default());
    let pushes = &report.recordings[0].pushes;
    assert_eq!(pushes.len(), 2, "{}", report.to_text());
    assert_near(pushes[1].contact_start_s, later + made.touch(), 0.01, "second contact");
    assert_eq!(table.rows.iter().map(|row| row.push).max(), Some(1));
}

#[test]
fn the_same_push_through_every_format_gives_the_same_table() {
    let recording = Made::default().recording("push-0000");
    let through = |writer: &&dyn RecordingWriter| {
        let dir = tempfile::tempdir().unwrap();
        write_set(dir.path(), writer.id(), std::slice::from_ref(&recording));
        let set = RecordingSet::open(dir.path()).unwrap();
        ingest(&set, &IngestSettings::default()).unwrap().0
    };
    let tables: Vec<_> = all_writers().iter().map(through).collect();
    // CSV, MIT JSON and HDF5, MCAP with ROS 1, ROS 2, JSON and protobuf messages, ROS 1 bag.
    #[cfg(all(feature = "protobuf", feature = "hdf5", feature = "bag"))]
    assert_eq!(tables.len(), 8);
    for table in &tables[1..] {
        assert_eq!(table.len(), tables[0].len());
        for (a, b) in tables[0].rows.iter().zip(&table.rows) {
            assert_eq!(
                (&a.recording, a.edge, a.phase, a.flags),
                (&b.recording, b.edge, b.phase, b.flags)
            );
            assert_near(b.t, a.t, 1e-5, "t");
            for (what, a, b) in invariants(a, b) {
                // Formats differ in the last digits of their stamps and quaternions.
                assert_near(b, a, 1e-5, what);
            }
        }
    }
}

#[test]
fn bytes_do_not_depend_on_the_number_of_threads() {
    let dir = tempfile::tempdir().unwrap();
    let recordings: Vec<_> = (0..11)
        .map(|i| {
            let made = Made { contact_y: -0.02 + 0.004 * f64::from(i), ..Made::default() };
            made.recording(&format!("push-{i:04}"))
        })
        .collect();
    write_set(dir.path(), "csv", &recordings);
    let set = RecordingSet::open(dir.path()).unwrap();
    let files = [1, 3].map(|n_threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        let (table, report) = pool.install(|| ingest(&set, &IngestSettings::default()).unwrap());
        let path = dir.path().join(format!("table-{n_threads}.csv"));
        table.write(&path).unwrap();
        (std::fs::read(path).unwrap(), report.to_text())
    });
    assert_eq!(files[0], files[1]);
}

#[test]
fn a_sink_gets_the_rows_that_a_table_holds() {
    let dir = tempfile::tempdir().unwrap();
    let recordings = ["a", "b", "c"].map(|name| Made::default().recording(name));
    write_set(dir.path(), "csv", &recordings);
    let set = RecordingSet::open(dir.path()).unwrap();
    let settings = IngestSettings::default();
    let mut rows = Vec::new();
    let mut names = Vec::new();
    let report = ingest_each(&set, &settings, |recording, own| {
        names.push(recording.name.clone());
        rows.extend(own);
        Ok(())
    })
    .unwrap();
    let (table, whole) = ingest(&set, &settings).unwrap();
    assert_eq!(names, ["a", "b", "c"]);
    assert_eq!((rows, report.clone()), (table.rows, whole));
    assert_eq!(provenance(&set, &report), table.provenance);
    assert_eq!(table.provenance.entries.iter().filter(|(key, _)| key == "source").count(), 3);
    assert!(table.provenance.get("settings").unwrap().contains("\"longest_gap\":0.05"));
}

#[test]
fn steps_may_be_lengths_of_the_pusher_s_way() {
    let settings =
        IngestSettings { step: StepLength::Distance(0.004), ..IngestSettings::default() };
    let (table, _) = run_set(&[Made::default().recording("push")], &settings);
    let full: Vec<_> = table.rows.iter().filter(|row| !row.flags.contains(Flags::SHORT)).collect();
    assert!(full.len() >= 4, "{}", full.len());
    for row in full {
        assert_near((row.pusher_end - row.pusher_start).norm(), 0.004, 1e-6, "way");
        assert_near(row.dt, 0.2, 1e-4, "time");
    }
}

/// Noise of known spread, white, from mixed bits.
fn noise(seed: u64, sd: f64) -> f64 {
    let mixed = (seed + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let uniform = (mixed ^ (mixed >> 32)) as f64 / 2f64.powi(64);
    sd * 3f64.sqrt() * (2.0 * uniform - 1.0)
}

/// A pusher that rests at the upper left vertex of the square and then slides past it.
fn at_the_vertex(direction: f64) -> Recording {
    let made = Made::default().recording("vertex");
    let away = Vector2::new(-40.0_f64.to_radians().cos(), 40.0_f64.to_radians().sin());
    let touch = Vector2::new(-HALF_SIDE, HALF_SIDE) + crate::made::RADIUS * away;
    let along = Vector2::new(direction.cos(), direction.sin());
    let mut recording = Recording { wrench: None, ..made };
    let (robot, object) = (&mut recording.robot, &mut recording.object);
    for (i, t) in robot.t.iter().enumerate() {
        let place = touch + 0.02 * (t - 0.5).max(0.0) * along;
        (robot.x[i], robot.y[i]) = (place.x, place.y);
    }
    for (i, t) in object.t.iter().enumerate() {
        // It is drawn along for a moment.
        let x = 0.01 * (t - 0.5).clamp(0.0, 0.2);
        (object.x[i], object.y[i], object.theta[i]) = (x, 0.0, 0.0);
    }
    recording
}

#[test]
fn a_pusher_that_leaves_a_vertex_moves_away_whatever_the_edge_that_it_faces() {
    let settings = IngestSettings { step: StepLength::Time(0.05), ..IngestSettings::default() };
    let first = |direction: f64| {
        let (table, _) = run_set(&[at_the_vertex(direction)], &settings);
        let row = table.rows.iter().find(|row| !row.flags.contains(Flags::PUSHER_AT_REST)).unwrap();
        assert!(row.flags.contains(Flags::VERTEX), "{}", row.flags);
        (row.beta, row.flags.contains(Flags::MOVING_AWAY))
    };
    // Against the vertex it moves at 120°, against the edge's normal at 80°.
    let (beta, moves_away) = first(80.0_f64.to_radians());
    assert!((0.0..1.5).contains(&beta) && moves_away, "{beta} {moves_away}");
    // Into the vertex at 80°, and as far from the edge's normal as before.
    let (_, moves_away) = first(40.0_f64.to_radians());
    assert!(!moves_away);
}

#[test]
fn stated_uncertainties_are_those_of_the_steps_and_smoothing_lowers_them() {
    // Each push touches and stops elsewhere between the samples.
    let made = |push: u64| Made { speed: 0.02 + 0.0003 * push as f64, ..Made::default() };
    let recordings: Vec<_> = (0..12)
        .map(|push| {
            let mut recording = made(push).recording(&format!("push-{push:04}"));
            let object = &mut recording.object;
            for (i, x) in object.x.iter_mut().chain(&mut object.y).enumerate() {
                *x += noise(push * 1000 + i as u64, 1e-4);
            }
            recording
        })
        .collect();
    let rms = |curve: Curve| {
        let settings = IngestSettings { curve, ..IngestSettings::default() };
        let (table, _) = run_set(&recordings, &settings);
        let rows: Vec<_> =
            table.rows.iter().filter(|r| r.phase == Phase::Contact && r.dt > 0.15).collect();
        let misses = rows.iter().map(|row| {
            let t0 = row.t - 1000.0;
            let made = made(row.recording[5..].parse().unwrap());
            let (start, end) = (made.object(t0), made.object(t0 + row.dt));
            let along = row.pusher_velocity / row.speed;
            (row.dx - (end.position - start.position).dot(&along)).powi(2)
        });
        let stated = rows.iter().map(|r| r.start_position_sd.powi(2) + r.end_position_sd.powi(2));
        let n = rows.len() as f64;
        assert!(n > 50.0);
        ((misses.sum::<f64>() / n).sqrt(), (stated.sum::<f64>() / n).sqrt())
    };
    let (rough, rough_sd) = rms(IngestSettings::default().curve);
    let (smooth, smooth_sd) = rms(Curve::Smooth);
    assert!((0.75..1.25).contains(&(rough / rough_sd)), "{rough} {rough_sd}");
    assert!((0.75..1.25).contains(&(smooth / smooth_sd)), "{smooth} {smooth_sd}");
    assert!(smooth < 0.6 * rough, "{smooth} {rough}");
}
