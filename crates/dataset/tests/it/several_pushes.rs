//! Many pushes in one log: each is found as in a recording of its own, and what lies between is no push.

use dataset::{IngestReport, IngestSettings, ReadLimits, Recording, RecordingSet, Table, ingest};
use planar::{Pose, wrap_angle};

use crate::made::{Made, write_set};

/// Between two pushes, in s.
const PAUSE: f64 = 4.0;

/// What the log does between two pushes.
#[derive(Clone, Copy, PartialEq)]
enum Between {
    /// It is stopped.
    Stopped,
    /// It goes on: the tip is lifted and goes straight to the next start, over the object, which is carried
    /// to its next place meanwhile.
    Carried,
}

fn pushes() -> Vec<Made> {
    let scene = |x, y, angle| Pose::new(x, y, angle);
    vec![
        Made { contact_y: 0.01, ..Made::default() },
        Made { scene: scene(0.25, -0.1, 2.0), contact_y: -0.02, yaw_rate: 0.2, ..Made::default() },
        Made { scene: scene(0.32, -0.22, -1.2), speed: 0.03, yaw_rate: 0.0, ..Made::default() },
    ]
}

/// The recordings one after the other, as one.
fn joined(parts: &[Recording], between: Between) -> Recording {
    let mut all = parts[0].clone();
    for part in &parts[1..] {
        let last = *all.robot.t.last().unwrap();
        let shift = last.max(*all.object.t.last().unwrap()) + PAUSE;
        if between == Between::Carried {
            carry(&mut all, part, shift);
        }
        for (own, other) in [(&mut all.robot, &part.robot), (&mut all.object, &part.object)] {
            own.t.extend(other.t.iter().map(|t| t + shift));
            own.x.extend(&other.x);
            own.y.extend(&other.y);
            own.theta.extend(&other.theta);
        }
        if let (Some(own), Some(other)) = (&mut all.wrench, &part.wrench) {
            own.t.extend(other.t.iter().map(|t| t + shift));
            own.fx.extend(&other.fx);
            own.fy.extend(&other.fy);
        }
    }
    all
}

/// Samples between the end of a log and `until`, with which it comes to the start of the next part.
fn carry(all: &mut Recording, next: &Recording, until: f64) {
    // The object is taken up after a quarter of the time, and laid down after three.
    let shares: [fn(f64) -> f64; 2] = [|u| u, |u| (2.0 * u - 0.5).clamp(0.0, 1.0)];
    for ((own, other), share) in
        [(&mut all.robot, &next.robot), (&mut all.object, &next.object)].into_iter().zip(shares)
    {
        let from = own.t.len() - 1;
        let [t, x, y, theta] = [own.t[from], own.x[from], own.y[from], own.theta[from]];
        let turn = wrap_angle(other.theta[0] - theta);
        for k in 1..(100.0 * (until - t)) as usize {
            let now = t + 0.01 * k as f64;
            let way = share((now - t) / (until - t));
            own.t.push(now);
            own.x.push(x + way * (other.x[0] - x));
            own.y.push(y + way * (other.y[0] - y));
            own.theta.push(wrap_angle(theta + way * turn));
        }
    }
    if let Some(wrench) = &mut all.wrench {
        let (t, from) = (*wrench.t.last().unwrap(), wrench.t.len() - 10);
        for k in 1..(100.0 * (until - t)) as usize {
            wrench.t.push(t + 0.01 * k as f64);
            wrench.fx.push(wrench.fx[from + k % 10]);
            wrench.fy.push(wrench.fy[from + k % 10]);
        }
    }
}

fn table(writer: &str, recordings: &[Recording]) -> (Table, IngestReport) {
    let dir = tempfile::tempdir().unwrap();
    write_set(dir.path(), writer, recordings);
    ingest(&RecordingSet::open(dir.path()).unwrap(), &IngestSettings::default()).unwrap()
}

fn separate(has_force: bool) -> Vec<Recording> {
    let one = |(k, made): (usize, &Made)| {
        let mut recording = made.recording(&format!("push-{k}"));
        if !has_force {
            recording.wrench = None;
        }
        recording
    };
    pushes().iter().enumerate().map(one).collect()
}

/// The same steps, in the same order; of pushes that are one recording's here and another's there.
fn assert_same(one: &Table, other: &Table, tolerance: f64) {
    let told = |table: &Table| {
        let rows = table.rows.iter().map(|row| (row.push, row.step, row.phase, row.t, row.dt));
        rows.collect::<Vec<_>>()
    };
    assert_eq!(one.len(), other.len(), "{:?}\n{:?}", told(one), told(other));
    for (a, b) in one.rows.iter().zip(&other.rows) {
        assert_eq!((a.step, a.edge, a.phase), (b.step, b.edge, b.phase));
        let numbers = [(a.dx, b.dx), (a.dy, b.dy), (a.dtheta, b.dtheta), (a.p, b.p)];
        assert!(numbers.iter().all(|(a, b)| (a - b).abs() < tolerance), "{numbers:?}");
    }
}

#[test]
fn pushes_of_a_log_that_is_stopped_between_them_are_those_of_their_own_recordings() {
    for has_force in [true, false] {
        let parts = separate(has_force);
        let (apart, _) = table("csv", &parts);
        for writer in ["csv", "mcap-ros2", "mcap-json"] {
            let (together, report) = table(writer, &[joined(&parts, Between::Stopped)]);
            // Stamps are rounded to the digits of a longer time.
            assert_same(&apart, &together, 1e-6);
            let recording = &report.recordings[0];
            assert_eq!((recording.pushes.len(), report.summary.pushes_used), (3, 3), "{writer}");
            assert_eq!((recording.pauses_s.len(), recording.passes), (2, 0));
            let [start, end] = recording.pauses_s[0];
            assert!((end - start - PAUSE).abs() < 0.02, "{start} {end}");
            let text = report.to_text();
            for part in
                ["one recording has 3 pushes, split", "2 pauses of the log", "cut at a pause"]
            {
                assert!(text.contains(part), "no {part}: {text}");
            }
        }
    }
}

#[test]
fn what_happens_between_pushes_of_a_log_that_goes_on_is_no_push() {
    for has_force in [true, false] {
        let parts = separate(has_force);
        let (apart, _) = table("csv", &parts);
        let (together, report) = table("csv", &[joined(&parts, Between::Carried)]);
        let recording = &report.recordings[0];
        let text = report.to_text();
        assert_eq!(report.summary.pushes_used, 3, "force {has_force}: {text}");
        assert!(recording.pauses_s.is_empty() && recording.passes > 0, "{text}");
        assert_same(&apart, &together, 2e-5);
        assert!(text.contains("set aside: "), "{text}");
    }
}

#[test]
fn a_recording_of_one_push_is_not_said_to_be_split() {
    let (_, report) = table("csv", &separate(true));
    let text = report.to_text();
    assert!(!text.contains("split") && !text.contains("set aside"), "{text}");
}

#[test]
fn a_look_at_a_log_tells_its_pauses_and_the_rate_between_them() {
    let parts = separate(true);
    for writer in ["csv", "mcap-ros2"] {
        let look = |recording: &Recording| {
            let dir = tempfile::tempdir().unwrap();
            write_set(dir.path(), writer, std::slice::from_ref(recording));
            let set = RecordingSet::open(dir.path()).unwrap();
            set.format().inspect(&set.recordings()[0], &ReadLimits::default()).unwrap()
        };
        let (one, all) = (look(&parts[0]), look(&joined(&parts, Between::Stopped)));
        assert!(one.remarks.is_empty(), "{writer}: {:?}", one.remarks);
        let told: Vec<_> = all.remarks.iter().map(|remark| remark.text.as_str()).collect();
        assert_eq!(told.len(), 1, "{writer}: {told:?}");
        assert!(told[0].starts_with("the log pauses 2 times for more than 1 s, 4.0 s"), "{told:?}");
        for (one, all) in one.streams.iter().zip(&all.streams) {
            let [one, all] = [one, all].map(|stream| stream.rate_hz.unwrap());
            assert!((one / all - 1.0).abs() < 0.01, "{writer}: {one} {all} Hz");
        }
    }
}
