//! Whole pushes as a model goes through them.

use std::sync::Arc;

use effects::{Effect, StepInput, Track, TrueOutline, deviations};
use mechanics::Polyline;
use models::{Base, ChannelModel, Description, Noise, PushModel, Pushed};
use nalgebra::Vector2;
use planar::{Pose, Shape, perpendicular, wrap_angle};

use crate::{DiagnosisError, Observations, PushName};

/// A push as measured, and as a model goes through it from the measured start along the measured
/// way of the pusher.
///
/// Of each push the steps that follow one another without a gap, from the first that is compared.
#[derive(Clone, Debug, PartialEq)]
pub struct Rollout {
    /// Which push.
    pub push: PushName,
    /// Time from the start, in s, at the start and at the end of each step.
    pub times: Vec<f64>,
    /// The pusher's center then, in m, frame W.
    pub pusher_w: Vec<Vector2<f64>>,
    /// Measured pose of B in W then.
    pub measured_wb: Vec<Pose>,
    /// Predicted pose of B in W then.
    pub predicted_wb: Vec<Pose>,
    /// Gap between pusher and outline then, both as the model has them, in m: 0 while they touch, but
    /// for errors of the measured start.
    pub gaps: Vec<f64>,
    /// Index of its first step.
    pub(crate) first: usize,
    /// Whether the push is one step, of which the ends alone are known.
    pub(crate) is_whole: bool,
}

impl Rollout {
    /// Distance of the predicted origin of B from the measured one at the end, in m, and predicted
    /// less measured turn, in rad.
    pub fn end_error(&self) -> (f64, f64) {
        match (self.predicted_wb.last(), self.measured_wb.last()) {
            (Some(predicted), Some(measured)) => (
                (predicted.position - measured.position).norm(),
                wrap_angle(predicted.angle - measured.angle),
            ),
            _ => (0.0, 0.0),
        }
    }

    /// The first step of the push.
    pub fn first_step<'a>(&self, observations: &'a Observations) -> &'a StepInput {
        &observations.steps[self.first].input
    }
}

/// Every push of the observations by one model; `own` are effects besides those of the catalogue.
///
/// An analytical model integrates the whole way at once, so that what it remembers, such as the
/// speed of the object, is its own; a learnt one goes from step to step. Where parameters differ from push
/// to push, poses are the mean over pushes.
///
/// # Errors
/// `Model` for what the model refuses.
pub fn roll_out(
    model: &Description,
    own: &[Arc<dyn Effect>],
    observations: &Observations,
) -> Result<Vec<Rollout>, DiagnosisError> {
    let runs = runs(observations);
    let mut rollouts: Vec<Rollout> = runs.iter().map(|run| measured(observations, run)).collect();
    match model.base {
        Base::Analytical(_) => {
            let model = ChannelModel::new(model, observations.support, own)?;
            let ways = runs.iter().map(|run| way(observations, run));
            let ways = ways.collect::<Result<Vec<_>, _>>()?;
            let paths = model.predict_paths(&ways)?;
            for ((rollout, (way, times)), path) in rollouts.iter_mut().zip(&ways).zip(paths) {
                let outline = model.true_outline(&way.object, way.pusher_radius)?;
                let gap = |(time, pose): (&f64, &Pose)| gap_at(&outline, way, *time, pose);
                rollout.gaps.push(gap((&0.0, &way.pose_wb)));
                rollout.gaps.extend(times.iter().zip(&path).map(gap));
                rollout.predicted_wb.extend(path);
            }
        }
        _ => {
            let model = model.build_in(observations.support, own)?;
            step_by_step(model.as_ref(), observations, &runs, &mut rollouts)?;
        }
    }
    Ok(rollouts)
}

/// The steps of each push that follow one another, by their indices.
fn runs(observations: &Observations) -> Vec<Vec<usize>> {
    /// Steps that end and begin within this time follow one another, in s.
    const SAME_TIME: f64 = 1e-6;
    let mut runs: Vec<Vec<usize>> = vec![Vec::new(); observations.pushes.len()];
    for (index, push) in observations.push_of.iter().enumerate() {
        runs[*push].push(index);
    }
    for run in &mut runs {
        run.sort_by_key(|index| observations.places[*index].step);
        let step = |index: usize| &observations.steps[index].input;
        let end = |index: usize| step(index).since_contact + step(index).track.duration();
        let follows =
            |pair: &[usize]| (end(pair[0]) - step(pair[1]).since_contact).abs() < SAME_TIME;
        let n_following = run.windows(2).take_while(|pair| follows(pair)).count();
        run.truncate(n_following + 1);
    }
    runs.retain(|run| !run.is_empty());
    runs
}

/// What was measured, and the start of the prediction.
fn measured(observations: &Observations, run: &[usize]) -> Rollout {
    let first = &observations.steps[run[0]].input;
    let mut rollout = Rollout {
        push: observations.pushes[observations.push_of[run[0]]].clone(),
        times: vec![0.0],
        pusher_w: vec![first.track.start()],
        measured_wb: vec![first.pose_wb],
        predicted_wb: vec![first.pose_wb],
        gaps: Vec::new(),
        first: run[0],
        is_whole: observations.places[run[0]].is_whole,
    };
    for index in run {
        let step = &observations.steps[*index];
        let [dx, dy, dtheta, ..] = step.observed.map(Option::unwrap_or_default);
        let StepInput { pose_wb, track, since_contact, .. } = &step.input;
        rollout.times.push(since_contact + track.duration() - first.since_contact);
        rollout.pusher_w.push(track.end());
        rollout.measured_wb.push(moved_by(pose_wb, &step.input.direction_w(), [dx, dy, dtheta]));
    }
    rollout
}

/// The way from the start of a push to the end of its last step, and when each of them ends, in s from the start.
fn way(
    observations: &Observations,
    run: &[usize],
) -> Result<(StepInput, Vec<f64>), models::ModelError> {
    /// Straight pieces of a step.
    const PIECES: u32 = 4;
    let first = &observations.steps[run[0]].input;
    if observations.places[run[0]].is_whole {
        return Ok((first.clone(), vec![first.track.duration()]));
    }
    let mut way = vec![(0.0, first.track.start())];
    let mut times = Vec::new();
    for index in run {
        let StepInput { track, since_contact, .. } = &observations.steps[*index].input;
        let start = since_contact - first.since_contact;
        for piece in 1..=PIECES {
            let time = track.duration() * f64::from(piece) / f64::from(PIECES);
            way.push((start + time, track.at(time).0));
        }
        times.push(start + track.duration());
    }
    let polyline = Polyline::new(&way).map_err(effects::EffectError::from)?;
    Ok((StepInput { track: Track::polyline(Arc::new(polyline)), ..first.clone() }, times))
}

/// The gap at a time of a step's track where a model has the object at `pose_wb` then.
fn gap_at(outline: &TrueOutline, step: &StepInput, time: f64, pose_wb: &Pose) -> f64 {
    // The object's stream shows what the pusher did so much earlier.
    outline.gap(pose_wb, &step.track.at(time - outline.latency()).0)
}

/// Each step from where the one before it ended, all pushes abreast; the mean over what pushes draw.
fn step_by_step(
    model: &dyn PushModel,
    observations: &Observations,
    runs: &[Vec<usize>],
    rollouts: &mut [Rollout],
) -> Result<(), DiagnosisError> {
    let shape = |run: &Vec<usize>| observations.steps[run[0]].input.object.shape().clone();
    let shapes: Vec<_> = runs.iter().map(|run| Arc::new(shape(run))).collect();
    for rollout in rollouts.iter_mut() {
        rollout.predicted_wb.resize(rollout.measured_wb.len(), Pose::new(0.0, 0.0, 0.0));
    }
    for (weight, numbers) in deviations(model.n_drawn()) {
        let poses = poses_given_draw(model, observations, (runs, &shapes), &numbers)?;
        for (rollout, poses) in rollouts.iter_mut().zip(poses) {
            for (mean, pose) in rollout.predicted_wb[1..].iter_mut().zip(&poses[1..]) {
                mean.position += weight * pose.position;
                mean.angle += weight * pose.angle;
            }
        }
    }
    for ((rollout, run), shape) in rollouts.iter_mut().zip(runs).zip(shapes) {
        let StepInput { object, pusher_radius, .. } = &observations.steps[run[0]].input;
        let object = Some(object.clone());
        let pushed = Pushed { shape, pusher_radius: *pusher_radius, object };
        let outline = model.true_outline(&pushed)?;
        let first = &observations.steps[run[0]].input;
        rollout.gaps.push(gap_at(&outline, first, 0.0, &first.pose_wb));
        for (index, end_wb) in run.iter().zip(&rollout.predicted_wb[1..]) {
            let step = &observations.steps[*index].input;
            rollout.gaps.push(gap_at(&outline, step, step.track.duration(), end_wb));
        }
    }
    Ok(())
}

/// The poses of each push that has drawn such numbers, at its start and after each step.
fn poses_given_draw(
    model: &dyn PushModel,
    observations: &Observations,
    (runs, shapes): (&[Vec<usize>], &[Arc<Shape>]),
    numbers: &[f64],
) -> Result<Vec<Vec<Pose>>, DiagnosisError> {
    let start = |run: &Vec<usize>| vec![observations.steps[run[0]].input.pose_wb];
    let mut poses: Vec<Vec<Pose>> = runs.iter().map(start).collect();
    let longest = runs.iter().map(Vec::len).max().unwrap_or(0);
    for k in 0..longest {
        let moving: Vec<usize> = (0..runs.len()).filter(|push| k < runs[*push].len()).collect();
        let input = |push: &usize| {
            let measured = &observations.steps[runs[*push][k]].input;
            let pose_wb = poses[*push][k];
            models::StepInput::of(StepInput { pose_wb, ..measured.clone() }, shapes[*push].clone())
        };
        let inputs = moving.iter().map(input).collect::<Result<Vec<_>, _>>()?;
        let draws = vec![numbers; inputs.len()];
        let said = model.predict_drawn(&inputs, &draws, Noise::Excluded)?;
        for (push, step) in moving.iter().zip(said) {
            let along_w = observations.steps[runs[*push][k]].input.direction_w();
            let end_wb = moved_by(&poses[*push][k], &along_w, step.mean.into());
            poses[*push].push(end_wb);
        }
    }
    Ok(poses)
}

/// The pose after a displacement along a direction and its left normal, in m, and a turn, in rad.
pub(crate) fn moved_by(pose_wb: &Pose, along_w: &Vector2<f64>, [dx, dy, dtheta]: [f64; 3]) -> Pose {
    let position = pose_wb.position + dx * along_w + dy * perpendicular(along_w);
    Pose { position, angle: pose_wb.angle + dtheta }
}
