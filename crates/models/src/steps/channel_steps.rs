//! Rows of a step table as steps of which every channel is observed.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use dataset::{Flags, ObjectChoice, ObjectSpec, Phase, StepRow, Table};
use effects::{Object, PushMoment, RunUp, StepInput, Track};
use mechanics::Polyline;

use crate::steps::table_steps::object_of;
use crate::{Excluded, ModelError, StepSelection};

/// A step with everything that was observed of it.
#[derive(Clone, Debug)]
pub struct ChannelObservation {
    /// What was done, and where the object was.
    pub input: StepInput,
    /// The numbers of [`effects::Channels`] in their order; a force is there where it was measured
    /// and its zero is known.
    pub observed: [Option<f64>; 7],
}

/// The steps of a table, and what became of its other rows.
#[derive(Clone, Debug)]
pub struct ChannelSteps {
    /// One observation a selected row, in the table's order.
    pub steps: Vec<ChannelObservation>,
    /// The row of each step, counted from 0.
    pub rows: Vec<usize>,
    /// The rows excluded.
    pub excluded: Excluded,
}

impl StepSelection {
    /// The steps of a table with all that effects act on; objects are shared by their steps.
    ///
    /// The measured start pose and velocity, the pusher's way with its mean acceleration, the time
    /// since contact and the session are the row's; what is behind a step are the rows of its push
    /// in contact, the excluded ones too. The object's mass and moment come from the
    /// manifest. A push's place in the set is its rank by time, or, where recordings overlap
    /// in time and so cannot share a clock, by the order of the table.
    ///
    /// - `pusher_radius`: in m.
    ///
    /// # Errors
    /// `Row` with the reason for a row that is no step.
    pub fn channel_steps(
        &self,
        table: &Table,
        objects: &ObjectChoice,
        pusher_radius: f64,
    ) -> Result<ChannelSteps, ModelError> {
        let (places, sessions) = (places(table), sessions(table));
        let run_ups = run_ups(table);
        let mut made = BTreeMap::new();
        let (steps, rows, excluded) = self.select(table, |row| {
            let object = match made.get(&row.shape) {
                Some(object) => Arc::clone(object),
                None => {
                    let object = Arc::new(rigid_object(&object_of(row, objects)?)?);
                    made.insert(row.shape.clone(), object.clone());
                    object
                }
            };
            let input = StepInput {
                object,
                pusher_radius,
                pose_wb: row.object_pose,
                twist_wb: row.object_twist,
                track: track(row)?,
                touching: is_touching(row),
                since_contact: row.since_contact,
                run_up: run_ups.get(&push_of(row)).cloned(),
                progress: places[&push_of(row)],
                session: row.session.as_ref().map_or(0, |session| sessions[session]),
            };
            Ok(ChannelObservation { input, observed: observed(row)? })
        })?;
        Ok(ChannelSteps { steps, rows, excluded })
    }
}

/// The pusher's way over a row.
fn track(row: &StepRow) -> Result<Track, ModelError> {
    let (start, end) = (row.pusher_start, row.pusher_end);
    if row.pusher_way.is_empty() {
        return Ok(Track::accelerated(start, end, row.pusher_acceleration, row.dt));
    }
    let inner = row.pusher_way.iter().copied();
    let points: Vec<_> = [(0.0, start)].into_iter().chain(inner).chain([(row.dt, end)]).collect();
    Ok(Track::kinked(Arc::new(Polyline::new(&points)?)))
}

/// Whether the pusher is known to touch from the start on: a whole push may begin before that.
fn is_touching(row: &StepRow) -> bool {
    if row.is_whole_push() {
        return row.flags.contains(Flags::STARTS_IN_CONTACT);
    }
    row.phase == Phase::Contact && !row.flags.contains(Flags::CONTACT_LOST)
}

/// An object as its specification has it.
///
/// # Errors
/// `Effects` for a mass or a moment that no object has.
pub fn rigid_object(spec: &ObjectSpec) -> Result<Object, ModelError> {
    let ObjectSpec { shape, mass, moment_of_inertia, center_of_mass, .. } = spec;
    Ok(Object::new(Arc::new(shape.clone()), *mass, *moment_of_inertia, *center_of_mass)?)
}

fn observed(row: &StepRow) -> Result<[Option<f64>; 7], ModelError> {
    // The gap of a whole push is given at its start, and follows from the motion at its end.
    let gap = |gap: f64| (!row.is_whole_push()).then_some(gap);
    let force = row.force.filter(|_| !row.flags.contains(Flags::UNTARED)).map(|force| force.mean);
    let values = [
        ("dx", Some(row.dx), "m"),
        ("dy", Some(row.dy), "m"),
        ("dtheta", Some(row.dtheta), "rad"),
        ("normal force", force.map(|force| force.normal), "N"),
        ("tangential force", force.map(|force| force.tangential), "N"),
        ("gap at the start", gap(row.gap_start), "m"),
        ("gap at the end", gap(row.gap_end), "m"),
    ];
    match values.iter().find(|(_, value, _)| value.is_some_and(|value| !value.is_finite())) {
        Some(&(name, value, unit)) => {
            let value = value.unwrap_or_default();
            Err(ModelError::InvalidValue { name, expected: "finite", value, unit })
        }
        None => Ok(values.map(|(_, value, _)| value)),
    }
}

/// A push by recording and number.
type PushName = (Arc<str>, u32);

fn push_of(row: &StepRow) -> PushName {
    (row.recording.clone(), row.push)
}

/// Each push as its rows in contact have it; none for whole pushes.
///
/// A row with numbers that no push has is left out: where it is a step, it is refused as such.
fn run_ups(table: &Table) -> HashMap<PushName, Arc<RunUp>> {
    let mut pushes: HashMap<PushName, Vec<PushMoment>> = HashMap::new();
    let in_contact = |row: &&StepRow| row.phase == Phase::Contact && !row.is_whole_push();
    for row in table.rows.iter().filter(in_contact) {
        let moment = PushMoment {
            since_contact: row.since_contact,
            pose_wb: row.object_pose,
            pusher_w: row.pusher_start,
            pusher_velocity_w: row.pusher_velocity - 0.5 * row.dt * row.pusher_acceleration,
        };
        if moment.validate().is_ok() {
            pushes.entry(push_of(row)).or_default().push(moment);
        }
    }
    let run_up = |(push, mut moments): (PushName, Vec<PushMoment>)| {
        moments.sort_by(|a, b| a.since_contact.total_cmp(&b.since_contact));
        moments.dedup_by_key(|moment| moment.since_contact);
        Some((push, Arc::new(RunUp::new(moments).ok()?)))
    };
    pushes.into_iter().filter_map(run_up).collect()
}

/// Place of each push in the order of the set: 0 for the first, 1 for the last.
fn places(table: &Table) -> HashMap<PushName, f64> {
    let mut spans: Vec<(PushName, [f64; 2])> = Vec::new();
    for row in &table.rows {
        let (push, ends) = (push_of(row), [row.t, row.t + row.dt]);
        match spans.last_mut() {
            Some((last, span)) if *last == push => {
                *span = [span[0].min(ends[0]), span[1].max(ends[1])];
            }
            _ => spans.push((push, ends)),
        }
    }
    let mut by_time = spans.clone();
    by_time.sort_by(|a, b| a.1[0].total_cmp(&b.1[0]));
    if by_time.windows(2).all(|pair| pair[0].1[1] <= pair[1].1[0] + OVERLAP) {
        spans = by_time;
    }
    let last = (spans.len().max(2) - 1) as f64;
    spans.into_iter().enumerate().map(|(rank, (push, _))| (push, rank as f64 / last)).collect()
}

/// Pushes that overlap by less are one after the other, in s: rounding of Unix times.
const OVERLAP: f64 = 1e-3;

/// Sessions in the order of the table.
fn sessions(table: &Table) -> HashMap<Arc<str>, u32> {
    let mut numbers = HashMap::new();
    for session in table.rows.iter().filter_map(|row| row.session.as_ref()) {
        let next = numbers.len() as u32;
        numbers.entry(session.clone()).or_insert(next);
    }
    numbers
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use dataset::{Flags, ObjectChoice, ObjectSpec, Provenance, StepRow, Table};
    use effects::{PushMoment, RunUp};
    use nalgebra::Vector2;
    use planar::Pose;

    use crate::StepSelection;

    #[test]
    fn a_whole_push_begins_before_the_touch_and_keeps_its_way_and_no_gap() {
        let bend = Vector2::new(-0.03, 0.01);
        let row = StepRow {
            recording: Arc::from("ends"),
            shape: Arc::from("rect1"),
            dt: 2.0,
            pusher_start: Vector2::new(-0.052, 0.0),
            pusher_end: Vector2::new(-0.02, 0.0),
            pusher_way: vec![(1.5, bend)],
            pusher_velocity: Vector2::new(0.016, 0.0),
            gap_start: 2e-3,
            flags: Flags::WHOLE_PUSH,
            ..StepRow::default()
        };
        let pressed = Flags::WHOLE_PUSH | Flags::STARTS_IN_CONTACT;
        let rows = vec![row.clone(), StepRow { flags: pressed, push: 1, ..row.clone() }];
        let late = StepRow { pusher_way: vec![(2.5, bend)], push: 2, ..row };
        let square = ObjectChoice::Fixed(Box::new(ObjectSpec::mit("rect1").unwrap()));
        let steps = |rows: Vec<StepRow>| {
            let table = Table { rows, provenance: Provenance::default() };
            StepSelection::default().channel_steps(&table, &square, 0.00475)
        };
        let found = steps(rows.clone()).unwrap().steps;
        assert_eq!([0, 1].map(|k: usize| found[k].input.touching), [false, true]);
        assert_eq!(found[0].input.track.at(1.5).0, bend);
        assert_eq!(found[0].observed[5..], [None, None]);
        let error = steps([rows, vec![late]].concat()).unwrap_err().to_string();
        assert!(error.contains("row 2") || error.contains("later than the one before"), "{error}");
        assert!(found.iter().all(|step| step.input.run_up.is_none()));
    }

    #[test]
    fn behind_a_step_are_all_rows_of_its_push() {
        let row = |push: u32, step: u32| StepRow {
            recording: Arc::from("one"),
            shape: Arc::from("rect1"),
            push,
            step,
            dt: 0.2,
            t: 10.0 * f64::from(push) + 0.2 * f64::from(step),
            since_contact: 0.2 * f64::from(step),
            object_pose: Pose::new(0.004 * f64::from(step), 0.0, 0.0),
            pusher_start: Vector2::new(0.004 * f64::from(step) - 0.052, 0.0),
            pusher_velocity: Vector2::new(0.02, 0.0),
            pusher_acceleration: Vector2::new(0.01, 0.0),
            ..StepRow::default()
        };
        let lost = StepRow { flags: Flags::CONTACT_LOST, ..row(0, 1) };
        let rows = vec![row(0, 0), lost, row(0, 2), row(1, 0), row(1, 1)];
        let table = Table { rows, provenance: Provenance::default() };
        let object = ObjectChoice::Fixed(Box::new(ObjectSpec::mit("rect1").unwrap()));
        let steps = StepSelection::default().channel_steps(&table, &object, 0.00475).unwrap();
        assert_eq!(steps.rows, [0, 2, 3, 4]);
        let moment = |k: f64| PushMoment {
            since_contact: 0.2 * k,
            pose_wb: Pose::new(0.004 * k, 0.0, 0.0),
            pusher_w: Vector2::new(0.004 * k - 0.052, 0.0),
            pusher_velocity_w: Vector2::new(0.019, 0.0),
        };
        let run_up = |n: u8| RunUp::new((0..n).map(f64::from).map(moment).collect()).unwrap();
        let found: Vec<_> = steps.steps.iter().map(|step| step.input.run_up.as_deref()).collect();
        assert_eq!(found, [3, 3, 2, 2].map(run_up).each_ref().map(Some));
    }
}
