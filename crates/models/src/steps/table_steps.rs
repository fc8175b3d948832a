//! Rows of a step table as observed steps.

use std::collections::BTreeMap;
use std::sync::Arc;

use dataset::{Flags, ObjectChoice, ObjectSpec, Phase, StepRow, Table};
use nalgebra::Vector3;
use planar::Shape;

use crate::{Excluded, ExclusionReason, ModelError, StepInput, StepObservation};

/// Which rows of a table are steps to learn from or to be tested on.
///
/// Rows after the contact and rows of a resting pusher, whose direction is not defined, never are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepSelection {
    /// Rows with any of these flags are excluded. A force without known zero (`UNTARED`) is not
    /// among them at first: an observation holds the motion alone.
    pub without: Flags,
}

impl Default for StepSelection {
    fn default() -> Self {
        let gaps = Flags::OBJECT_GAP | Flags::ROBOT_GAP;
        Self { without: gaps | Flags::SHORT | Flags::CONTACT_LOST | Flags::MOVING_AWAY }
    }
}

/// The observed steps of a table, and what became of its other rows.
#[derive(Clone, Debug, PartialEq)]
pub struct TableSteps {
    /// One observation a selected row, in the table's order.
    pub steps: Vec<StepObservation>,
    /// The row of each step, counted from 0.
    pub rows: Vec<usize>,
    /// The rows excluded.
    pub excluded: Excluded,
}

impl StepSelection {
    /// The observations in a table: shapes are shared by all the steps of an object.
    ///
    /// The pusher's path and the object's start pose are the row's; p, β and the edge follow from
    /// them, as in the table. `objects` says which outline a recording is about.
    ///
    /// - `pusher_radius`: in m.
    ///
    /// # Errors
    /// `Row` with the reason for a row that is no step: another shape than the object's, an object
    /// that the recording does not name, an output or a start that is not finite.
    pub fn observations(
        &self,
        table: &Table,
        objects: &ObjectChoice,
        pusher_radius: f64,
    ) -> Result<TableSteps, ModelError> {
        let mut shapes = BTreeMap::new();
        let (steps, rows, excluded) = self.select(table, |row| {
            let shape = match shapes.get(&row.shape) {
                Some(shape) => Arc::clone(shape),
                None => {
                    let shape = Arc::new(object_of(row, objects)?.shape);
                    shapes.insert(row.shape.clone(), shape.clone());
                    shape
                }
            };
            observation(row, shape, pusher_radius)
        })?;
        Ok(TableSteps { steps, rows, excluded })
    }

    /// What is observed in each row that is not excluded, with the rows' numbers.
    pub(crate) fn select<T>(
        &self,
        table: &Table,
        mut observe: impl FnMut(&StepRow) -> Result<T, ModelError>,
    ) -> Result<(Vec<T>, Vec<usize>, Excluded), ModelError> {
        let (mut found, mut rows, mut excluded) = (Vec::new(), Vec::new(), Excluded::default());
        for (index, row) in table.rows.iter().enumerate() {
            if let Some(reason) = self.reason(row) {
                excluded.add(reason, index);
                continue;
            }
            found.push(observe(row).map_err(|source| ModelError::Row {
                row: index,
                recording: row.recording.to_string(),
                source: Box::new(source),
            })?);
            rows.push(index);
        }
        Ok((found, rows, excluded))
    }

    fn reason(&self, row: &StepRow) -> Option<ExclusionReason> {
        if row.phase == Phase::After {
            return Some(ExclusionReason::AfterContact);
        }
        if row.flags.contains(Flags::PUSHER_AT_REST) {
            return Some(ExclusionReason::PusherAtRest);
        }
        let unwanted = |flag: Flags| self.without.contains(flag) && row.flags.contains(flag);
        let (_, name) = Flags::ALL.iter().find(|(flag, _)| unwanted(*flag))?;
        Some(ExclusionReason::Flag(name))
    }
}

impl TableSteps {
    /// What a model is asked for each step.
    pub fn inputs(&self) -> Vec<StepInput> {
        self.steps.iter().map(|step| step.input.clone()).collect()
    }

    /// One output of every step as it was observed: 0 for Δx in m, 1 for Δy in m, 2 for Δθ in rad.
    ///
    /// # Panics
    /// If there is no such output.
    pub fn observed(&self, output: usize) -> Vec<f64> {
        self.steps.iter().map(|step| step.outputs[output]).collect()
    }
}

/// The object that a row is about.
pub(crate) fn object_of(row: &StepRow, objects: &ObjectChoice) -> Result<ObjectSpec, ModelError> {
    let object = objects.of(&row.recording)?;
    if *object.name != *row.shape {
        let (found, expected) = (row.shape.to_string(), object.name);
        return Err(ModelError::OtherShape { found, expected });
    }
    Ok(object)
}

fn observation(
    row: &StepRow,
    shape: Arc<Shape>,
    pusher_radius: f64,
) -> Result<StepObservation, ModelError> {
    let (start_w, end_w) = (&row.pusher_start, &row.pusher_end);
    let input = StepInput::between(shape, pusher_radius, &row.object_pose, start_w, end_w)?;
    let input = input.lasting(row.dt)?;
    for (name, value, unit) in
        [("dx", row.dx, "m"), ("dy", row.dy, "m"), ("dtheta", row.dtheta, "rad")]
    {
        if !value.is_finite() {
            return Err(ModelError::InvalidValue { name, expected: "finite", value, unit });
        }
    }
    Ok(StepObservation { input, outputs: Vector3::new(row.dx, row.dy, row.dtheta) })
}

#[cfg(test)]
mod tests {
    use super::StepSelection;
    use crate::{Analytical, ExclusionReason, ModelError, StepInput};
    use dataset::{Flags, ObjectChoice, ObjectSpec, Phase, Provenance, StepRow, Table};
    use nalgebra::{Vector2, Vector3};
    use planar::{Pose, Shape, perpendicular};
    use std::sync::Arc;

    const RADIUS: f64 = 0.00475;

    fn square() -> ObjectChoice {
        ObjectChoice::Fixed(Box::new(ObjectSpec::mit("rect1").unwrap()))
    }

    /// The row that a recording of the analytical push would give: everything in the world frame.
    fn row(start_wb: Pose, edge: usize, p: f64, beta: f64) -> StepRow {
        let shape = Arc::new(Shape::square(0.09).unwrap());
        let step = StepInput::on_edge(shape.clone(), RADIUS, edge, p, beta, 0.004).unwrap();
        let end_wb = start_wb * Analytical::nominal(0.25).unwrap().motion(&step).unwrap();
        let along = start_wb.rotate(&step.direction_b());
        let moved = end_wb.position - start_wb.position;
        let pusher_start = start_wb.transform_point(&step.start_b());
        StepRow {
            recording: Arc::from("made"),
            shape: Arc::from("rect1"),
            dt: 0.2,
            speed: 0.02,
            edge: edge as u32,
            p,
            beta,
            object_pose: start_wb,
            pusher_start,
            pusher_end: pusher_start + 0.004 * along,
            pusher_velocity: 0.02 * along,
            dx: moved.dot(&along),
            dy: moved.dot(&perpendicular(&along)),
            dtheta: end_wb.angle - start_wb.angle,
            ..StepRow::default()
        }
    }

    fn table(rows: Vec<StepRow>) -> Table {
        Table { rows, provenance: Provenance::default() }
    }

    fn outputs(rows: Vec<StepRow>) -> Vec<Vector3<f64>> {
        let steps = StepSelection::default().observations(&table(rows), &square(), RADIUS).unwrap();
        steps.steps.iter().map(|step| step.outputs).collect()
    }

    const SCENES: [(usize, f64, f64); 5] =
        [(0, 0.3, 0.4), (1, 0.8, -0.7), (2, 0.1, 0.2), (3, 0.5, 0.0), (1, 0.95, 0.9)];

    #[test]
    fn a_row_is_the_step_between_its_poses_and_its_outputs_are_the_rows() {
        for (edge, p, beta) in SCENES {
            let row = row(Pose::new(0.4, -0.2, 2.5), edge, p, beta);
            let found = StepSelection::default()
                .observations(&table(vec![row.clone()]), &square(), RADIUS)
                .unwrap();
            let step = &found.steps[0];
            let shape = Arc::new(Shape::square(0.09).unwrap());
            let (start, end) = (&row.pusher_start, &row.pusher_end);
            let bare = StepInput::between(shape, RADIUS, &row.object_pose, start, end).unwrap();
            let expected = bare.lasting(row.dt).unwrap();
            assert_eq!(step.input, expected);
            assert_eq!(step.input.edge(), edge);
            assert!((step.input.p() - p).abs() < 1e-12 && (step.input.beta() - beta).abs() < 1e-12);
            assert_eq!(step.outputs, Vector3::new(row.dx, row.dy, row.dtheta));
        }
    }

    #[test]
    fn a_model_that_made_the_rows_predicts_their_outputs() {
        let model = Analytical::nominal(0.25).unwrap();
        let rows: Vec<_> = SCENES
            .iter()
            .map(|&(edge, p, beta)| row(Pose::new(-0.1, 0.3, -1.2), edge, p, beta))
            .collect();
        let found = StepSelection::default().observations(&table(rows), &square(), RADIUS).unwrap();
        for step in &found.steps {
            let error = step.outputs - step.input.outputs(&model.motion(&step.input).unwrap());
            assert!(error.norm() < 1e-9, "{error}");
        }
        assert!(Arc::ptr_eq(
            found.steps[0].input.shared_shape(),
            found.steps[4].input.shared_shape()
        ));
    }

    #[test]
    fn a_turned_scene_has_the_same_outputs_and_a_mirrored_one_mirrored() {
        for (edge, p, beta) in SCENES {
            let here = outputs(vec![row(Pose::new(0.0, 0.0, 0.0), edge, p, beta)])[0];
            let turned = outputs(vec![row(Pose::new(0.7, -0.3, 1.9), edge, p, beta)])[0];
            assert!((here - turned).norm() < 1e-9, "{here} {turned}");
            let mirrored = outputs(vec![row(Pose::new(0.0, 0.0, 0.4), edge, 1.0 - p, -beta)])[0];
            let expected = Vector3::new(here.x, -here.y, -here.z);
            assert!((mirrored - expected).norm() < 1e-9, "{mirrored} {expected}");
        }
    }

    #[test]
    fn rows_that_are_no_steps_are_counted_by_reason() {
        let good = || row(Pose::new(0.0, 0.0, 0.0), 1, 0.4, 0.1);
        let flagged = |flags: Flags| StepRow { flags, ..good() };
        let rows = vec![
            flagged(Flags::SHORT),
            good(),
            StepRow { phase: Phase::After, flags: Flags::SHORT, ..good() },
            flagged(Flags::PUSHER_AT_REST),
            flagged(Flags::UNTARED | Flags::FIRST_TOUCH),
            flagged(Flags::SHORT | Flags::OBJECT_GAP),
        ];
        let found =
            StepSelection::default().observations(&table(rows.clone()), &square(), RADIUS).unwrap();
        assert_eq!(found.rows, [1, 4]);
        assert_eq!(found.excluded.rows[&ExclusionReason::AfterContact], [2]);
        assert_eq!(found.excluded.rows[&ExclusionReason::PusherAtRest], [3]);
        assert_eq!(
            found.excluded.to_string(),
            "1 after contact, 1 pusher at rest, 1 object_gap, 1 short"
        );
        let strict = StepSelection { without: StepSelection::default().without | Flags::UNTARED };
        assert_eq!(strict.observations(&table(rows), &square(), RADIUS).unwrap().rows, [1]);
    }

    #[test]
    fn impossible_rows_are_named_by_number_recording_and_reason() {
        let good = || row(Pose::new(0.0, 0.0, 0.0), 1, 0.4, 0.1);
        let refused = |row: StepRow, objects: &ObjectChoice| {
            let table = table(vec![good(), row]);
            match StepSelection::default().observations(&table, objects, RADIUS).unwrap_err() {
                ModelError::Row { row: 1, recording, source } if recording == "made" => *source,
                other => panic!("{other}"),
            }
        };
        let other = refused(StepRow { shape: Arc::from("hex"), ..good() }, &square());
        let ModelError::OtherShape { found, expected } = other else { panic!("{other}") };
        assert_eq!((found.as_str(), expected.as_str()), ("hex", "rect1"));
        let still = StepRow { pusher_end: good().pusher_start, ..good() };
        let error = refused(still, &square());
        assert!(matches!(error, ModelError::InvalidValue { name: "the pusher's travel", .. }));
        let error = refused(StepRow { dy: f64::NAN, ..good() }, &square());
        assert!(matches!(error, ModelError::InvalidValue { name: "dy", .. }));
        let nowhere = StepRow { pusher_start: Vector2::new(f64::NAN, 0.0), ..good() };
        assert!(matches!(refused(nowhere, &square()), ModelError::InvalidValue { .. }));
        let table = table(vec![good()]);
        let error =
            StepSelection::default().observations(&table, &ObjectChoice::ByFileName, RADIUS);
        assert!(matches!(error, Err(ModelError::Row { row: 0, .. })));
    }
}
