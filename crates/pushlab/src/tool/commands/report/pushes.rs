//! Every push as measured and as predicted, to be played.

use std::collections::HashMap;
use std::sync::Arc;

use ::report::{PlayedPush, PlayedSteps, Player, Section};
use diagnosis::{PushName, Rollout};
use effects::Object;
use planar::Pose;

use super::measure::Measure;
use super::steps::StepsOf;
use super::{Report, groups, tag};

/// Most bytes of the embedded pushes.
const LIMIT: usize = 4_000_000;
/// Corners of a drawn ellipse.
const CORNERS: usize = 64;

pub(super) fn section(player: Player) -> Section {
    Section::new("pushes", "Pushes as measured and as predicted").player(player)
}

/// The pushes, those that the first model ends farthest from first.
pub(super) fn player(report: &Report) -> Player {
    let first = &report.models[0].rollouts;
    let mut objects: Vec<Arc<Object>> = Vec::new();
    let mut played: Vec<(f64, usize, PlayedPush)> = Vec::new();
    let worst = badness(first);
    let steps = StepsOf::new(report);
    let names = report.all.pushes().iter().zip(0..);
    let number_of: HashMap<&PushName, usize> = names.collect();
    for (index, rollout) in first.iter().enumerate() {
        let step = rollout.first_step(&report.in_contact);
        let known = objects.iter().position(|object| Arc::ptr_eq(object, &step.object));
        let outline = known.unwrap_or_else(|| {
            objects.push(step.object.clone());
            objects.len() - 1
        });
        let push_of = number_of[&rollout.push];
        let steps = steps.of_push(push_of, step.since_contact);
        played.push((worst[index], push_of, PlayedPush { steps, ..push(report, index, outline) }));
    }
    played.sort_by(|a, b| b.0.total_cmp(&a.0));
    let outline = |object: &Arc<Object>| {
        object.shape().outline(CORNERS).iter().map(|corner| [corner.x, corner.y]).collect()
    };
    let step = first.first().map(|rollout| rollout.first_step(&report.in_contact));
    let place_of: HashMap<usize, usize> =
        played.iter().enumerate().map(|(place, (_, push, _))| (*push, place)).collect();
    let places =
        |group: Vec<usize>| group.iter().filter_map(|push| place_of.get(push).copied()).collect();
    let groups = groups::of(report).into_iter().map(places).collect();
    let name = |(index, model): (usize, &super::Tried)| format!("{} – {}", tag(index), model.name);
    Player {
        pusher_radius: step.map_or(0.0, |step| step.pusher_radius),
        models: report.models.iter().enumerate().map(name).collect(),
        outlines: objects.iter().map(outline).collect(),
        axes: steps.axes(),
        numbers: steps.numbers(),
        pushes: played.into_iter().map(|(.., push)| push).collect(),
        order: format!("those that {} predicts worst first", tag(0)),
        groups_are: groups::ARE.to_owned(),
        groups,
        limit: LIMIT,
    }
}

/// Errors of place and turn at the end, each over its root mean square in the set.
fn badness(rollouts: &[Rollout]) -> Vec<f64> {
    let errors: Vec<_> = rollouts.iter().map(Rollout::end_error).collect();
    let rms = |pick: fn(&(f64, f64)) -> f64| {
        let square = errors.iter().map(|error| pick(error).powi(2)).sum::<f64>();
        (square / errors.len() as f64).sqrt().max(f64::MIN_POSITIVE)
    };
    let (distance, turn) = (rms(|error| error.0), rms(|error| error.1));
    errors.iter().map(|error| (error.0 / distance).hypot(error.1 / turn)).collect()
}

fn push(report: &Report, index: usize, outline: usize) -> PlayedPush {
    let measured = &report.models[0].rollouts[index];
    let poses = |poses: &[Pose]| -> Vec<[f64; 3]> {
        poses.iter().map(|pose| [pose.position.x, pose.position.y, pose.angle]).collect()
    };
    let mut name = measured.push.to_string();
    let mut predicted = Vec::new();
    for (model, tried) in report.models.iter().enumerate() {
        let (distance, turn) = tried.rollouts[index].end_error();
        let (distance, turn) = (Measure::of("m").text(distance), Measure::of("rad").signed(turn));
        name += &format!(" · {} {distance}, {turn}", tag(model));
        predicted.push(Some(poses(&tried.rollouts[index].predicted_wb)));
    }
    PlayedPush {
        name,
        outline,
        times: measured.times.clone(),
        measured: poses(&measured.measured_wb),
        pusher: measured.pusher_w.iter().map(|place| [place.x, place.y]).collect(),
        predicted,
        steps: PlayedSteps::default(),
    }
}
