//! Pushes of a step table, to be rolled out and compared with.

use std::sync::Arc;

use dataset::{ObjectChoice, StepRow, Table};
use effects::TrueOutline;
use nalgebra::Vector3;
use planar::{Pose, Shape, perpendicular};

use crate::{
    ChannelObservation, ModelError, PushPath, Pushed, StepInput, StepObservation, StepSelection,
};

/// A push as it was recorded: the steps that follow one another without a gap, from the first one.
#[derive(Clone, Debug)]
pub struct RecordedPush {
    /// `recording#number`, as in a [`crate::Split`].
    pub name: String,
    /// What was pushed, with all that effects act on.
    pub pushed: Pushed,
    /// The pusher's way, with a step from row to row, or to the next kink of a whole push.
    pub path: PushPath,
    /// Measured poses of B in W, at the start and after each step.
    pub poses_wb: Vec<Pose>,
    /// What was observed of each step, for models with effects too.
    pub steps: Vec<StepObservation>,
    /// Standard deviations of the measured start and end: of the place along each axis, in m, and of
    /// the angle, in rad, as far as the samples tell.
    pub pose_sd: [[f64; 2]; 2],
}

impl RecordedPush {
    /// The gap between pusher and outline at the start and after each step, in m: as measured, and
    /// as a model has outline and pusher.
    pub fn gaps(&self, outline: &TrueOutline) -> Vec<f64> {
        let centers = self.path.points().iter().map(|(_, center_w)| center_w);
        self.poses_wb.iter().zip(centers).map(|(pose, center)| outline.gap(pose, center)).collect()
    }
}

impl StepSelection {
    /// The pushes of a table, in its order, each from its first row that is not excluded.
    ///
    /// - `pusher_radius`: in m.
    ///
    /// # Errors
    /// As [`StepSelection::channel_steps`]; `Path` for a pusher that jumps.
    pub fn pushes(
        &self,
        table: &Table,
        objects: &ObjectChoice,
        pusher_radius: f64,
    ) -> Result<Vec<RecordedPush>, ModelError> {
        let found = self.channel_steps(table, objects, pusher_radius)?;
        let steps: Vec<_> =
            found.rows.iter().map(|row| &table.rows[*row]).zip(&found.steps).collect();
        let mut shapes: Vec<Arc<Shape>> = Vec::new();
        let of_one_push = |a: &(&StepRow, _), b: &(&StepRow, _)| {
            (&a.0.recording, a.0.push) == (&b.0.recording, b.0.push)
        };
        let push = |steps: &[(&StepRow, &ChannelObservation)]| {
            let follows =
                |pair: &[(&StepRow, &ChannelObservation)]| pair[0].0.step + 1 == pair[1].0.step;
            let n = 1 + steps.windows(2).take_while(|pair| follows(pair)).count();
            recorded(&steps[..n], pusher_radius, &mut shapes)
        };
        steps.chunk_by(of_one_push).map(push).collect()
    }
}

fn recorded(
    steps: &[(&StepRow, &ChannelObservation)],
    pusher_radius: f64,
    shapes: &mut Vec<Arc<Shape>>,
) -> Result<RecordedPush, ModelError> {
    let ((first, whole), (last, _)) = (steps[0], steps[steps.len() - 1]);
    let object = whole.input.object.clone();
    let shape = match shapes.iter().find(|shape| ***shape == *object.shape()) {
        Some(shape) => shape.clone(),
        None => {
            shapes.push(Arc::new(object.shape().clone()));
            shapes[shapes.len() - 1].clone()
        }
    };
    let points = |(row, _): &(&StepRow, &ChannelObservation)| {
        let kinks: Vec<_> = row.pusher_way.iter().map(|(t, place)| (row.t + t, *place)).collect();
        [(row.t, row.pusher_start)].into_iter().chain(kinks)
    };
    let ways = steps.iter().flat_map(points);
    let way: Vec<_> = ways.chain([(last.t + last.dt, last.pusher_end)]).collect();
    let observed = |(row, step): &(&StepRow, &ChannelObservation)| {
        let input = StepInput::of(step.input.clone(), shape.clone())?;
        Ok(StepObservation { input, outputs: Vector3::new(row.dx, row.dy, row.dtheta) })
    };
    let poses = steps.iter().map(|(row, _)| row.object_pose);
    Ok(RecordedPush {
        name: format!("{}#{}", first.recording, first.push),
        path: PushPath::stepwise(&way)?,
        poses_wb: poses.chain([end_pose(last)]).collect(),
        steps: steps.iter().map(observed).collect::<Result<_, ModelError>>()?,
        pose_sd: [
            [first.start_position_sd, first.start_angle_sd],
            [last.end_position_sd, last.end_angle_sd],
        ],
        pushed: Pushed { shape, pusher_radius, object: Some(object) },
    })
}

/// The measured pose at the end of a step.
fn end_pose(row: &StepRow) -> Pose {
    let along = row.pusher_velocity.normalize();
    let moved = row.dx * along + row.dy * perpendicular(&along);
    Pose { position: row.object_pose.position + moved, angle: row.object_pose.angle + row.dtheta }
}

#[cfg(test)]
mod tests {
    use dataset::{IngestSettings, RecordingSet, ingest};

    use crate::{RollOut, RollOutSettings, StepErrors, StepSelection};

    #[test]
    fn recorded_pushes_come_whole_and_a_fitted_model_follows_them() {
        let fixtures = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/pushes");
        let set = RecordingSet::open(fixtures.as_ref()).unwrap();
        let (table, _) = ingest(&set, &IngestSettings::default()).unwrap();
        let manifest = set.manifest();
        let selection = StepSelection::default();
        let pushes = selection.pushes(&table, &manifest.object, manifest.pusher.radius).unwrap();
        assert_eq!(pushes.len(), 60);
        let bare = selection.observations(&table, &manifest.object, manifest.pusher.radius);
        let fit = crate::Analytical::nominal(manifest.pusher.friction).unwrap();
        let fit = fit.fit(&bare.unwrap().steps).unwrap().model;
        let mut squares = 0.0;
        for push in &pushes {
            let n = push.steps.len();
            assert_eq!(push.poses_wb.len(), n + 1);
            assert_eq!(push.path.steps(1.0).unwrap().len(), n, "{}", push.name);
            let errors = StepErrors::None;
            let settings =
                RollOutSettings { n_particles: 1, errors, touching: true, ..Default::default() };
            let roll_out = RollOut { model: &fit, pushed: &push.pushed, settings: &settings };
            let end = roll_out.run(&push.poses_wb[0], &push.path, |_, _| {}).unwrap();
            let end = end[end.len() - 1].pose_wb.mean;
            squares += (end.xy() - push.poses_wb[n].position).norm_squared();
        }
        let rms = (squares / 60.0).sqrt();
        // An ellipsoid on pushes of a uniform patch: 1 mm after 50 mm, as `compare` finds, too.
        assert!(rms < 1.5e-3, "{rms}");
    }
}
