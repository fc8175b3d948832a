//! Laws of the integration: parts of a step, shorter sub-steps, and the energy of a step.

use std::sync::Arc;

use effects::{
    Channels, Effect, Geometry, MeasurementModel, PushPhysics, Snapshot, StepInput, Surface, Track,
    all, by_id,
};
use nalgebra::Vector2;
use planar::{Pose, Twist, Wrench, perpendicular};

use super::world::World;

/// Steps at constant velocity, so that parts of a track are tracks of the same kind.
fn straight_steps() -> Vec<StepInput> {
    let straight = |step: StepInput| {
        let (start, end, duration) = (step.track.start(), step.track.end(), step.track.duration());
        StepInput { track: Track::straight(start, end, duration), ..step }
    };
    World::PLAIN.steps().into_iter().map(straight).collect()
}

/// The step from one time to another, in s, with its object as it is at first.
fn part(step: &StepInput, from: f64, to: f64) -> StepInput {
    let track = Track::straight(step.track.at(from).0, step.track.at(to).0, to - from);
    StepInput { track, since_contact: step.since_contact + from, ..step.clone() }
}

/// The step with its object where the model sets it at first: against the pusher.
fn settled(physics: &PushPhysics, step: &StepInput) -> StepInput {
    let mut step = step.clone();
    for _ in 0..6 {
        let center = step.pose_wb.inverse_transform_point(&step.track.start());
        let contact = step.object.shape().contact(&center, step.pusher_radius);
        let gap = physics.predict(&step).unwrap().gap_start;
        step.pose_wb.position += (gap - contact.gap) * step.pose_wb.rotate(&contact.normal);
    }
    step
}

/// The step with its object moving at first as the pusher moves it without inertia.
fn moving(surface: &Surface, step: &StepInput) -> StepInput {
    let plain = PushPhysics::new(World::PLAIN.rig(surface.clone()));
    let time = 1e-3 * step.track.duration();
    let after = pose_after(&plain, step, time);
    let linear = (after.position - step.pose_wb.position) / time;
    let twist_wb = Twist { linear, angular: (after.angle - step.pose_wb.angle) / time };
    if step.touching { StepInput { twist_wb, ..step.clone() } } else { step.clone() }
}

/// The pose after some time, in s.
fn pose_after(physics: &PushPhysics, step: &StepInput, time: f64) -> Pose {
    let part = part(step, 0.0, time);
    let Channels { dx, dy, dtheta, .. } = physics.predict(&part).unwrap();
    let along = part.direction_w();
    let moved = dx * along + dy * perpendicular(&along);
    Pose { position: step.pose_wb.position + moved, angle: step.pose_wb.angle + dtheta }
}

/// The rest of a step from a time on, in s, with the object as it is then.
fn rest(physics: &PushPhysics, step: &StepInput, time: f64) -> StepInput {
    let nudge = 1e-3 * step.track.duration();
    let pose = |time: f64| pose_after(physics, step, time);
    let (before, after) = (pose(time - nudge), pose(time + nudge));
    let linear = (after.position - before.position) / (2.0 * nudge);
    let twist_wb = Twist { linear, angular: (after.angle - before.angle) / (2.0 * nudge) };
    StepInput { pose_wb: pose(time), twist_wb, ..part(step, time, step.track.duration()) }
}

/// Displacement in W and turn times 50 mm, in m.
fn motion(from: &Pose, to: &Pose) -> [f64; 3] {
    let moved = to.position - from.position;
    [moved.x, moved.y, 0.05 * (to.angle - from.angle)]
}

fn apart<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn model(effect: &Arc<dyn Effect>, surface: &Surface, longest: f64) -> PushPhysics {
    let rig = World::PLAIN.rig(surface.clone()).with_longest_substep(longest).unwrap();
    let typical = effect.info().typical(&rig);
    PushPhysics::new(rig).with(effect, &typical).unwrap()
}

/// Whether a pusher may touch two facets at once, which the model's one contact does not follow.
fn is_concave(step: &StepInput) -> bool {
    step.object.shape().n_edges() > 8
}

#[test]
fn two_half_steps_are_the_whole_step() {
    for surface in super::SURFACES {
        let steps = straight_steps();
        for effect in all() {
            let (id, physics) = (effect.info().id, model(effect, &surface, 1e-3));
            // Whole and halves are each within 4 µm over 4 mm.
            let (farthest, strongest) = (6e-6, 2e-2);
            for (index, step) in steps.iter().enumerate().filter(|(_, step)| !is_concave(step)) {
                let step = settled(&physics, step);
                let step = if id == "inertia" { moving(&surface, &step) } else { step };
                let duration = step.track.duration();
                let whole = physics.predict(&step).unwrap();
                let first = physics.predict(&part(&step, 0.0, 0.5 * duration)).unwrap();
                let late = rest(&physics, &step, 0.5 * duration);
                let second = physics.predict(&late).unwrap();
                // Between its cones a sticking pusher does what it is measured to do.
                let is_open = id == "pusher-stiction" && changes(&first, &second);
                let end = pose_after(&physics, &late, 0.5 * duration);
                let whole_end = pose_after(&physics, &step, duration);
                let [a, b] = [&end, &whole_end].map(|end| motion(&step.pose_wb, end));
                let force = |c: &Channels| [c.force_normal, c.force_tangential];
                let [one, two, both] = [&first, &second, &whole].map(force);
                let mean = [0, 1].map(|k| 0.5 * (one[k] + two[k]));
                let gaps = ([first.gap_start, second.gap_end], [whole.gap_start, whole.gap_end]);
                let found = [apart(a, b), apart(mean, both), apart(gaps.0, gaps.1)];
                let is_near = found[0] < farthest && found[1] < strongest && found[2] < farthest;
                assert!(is_near || is_open, "{id} {surface:?} step {index}: {found:?}");
            }
        }
    }
}

/// Whether the direction of the force in the cone is another one in the second half of a step.
fn changes(first: &Channels, second: &Channels) -> bool {
    let ratio = |c: &Channels| c.force_tangential / c.force_normal;
    (ratio(first) - ratio(second)).abs() > 0.01
}

/// Effects of which the change is no smooth function of the sub-steps.
const JUMPS: [&str; 2] = ["inertia", "pusher-stiction"];

/// What an effect of its typical size changes, and what it changes in half the sub-steps.
fn changes_by(effect: &Arc<dyn Effect>, surface: &Surface, step: &StepInput) -> [[f64; 7]; 2] {
    let with = model(effect, surface, 1e-3);
    let without = PushPhysics::new(World::PLAIN.rig(surface.clone()));
    let change = |with: &PushPhysics, without: &PushPhysics| -> [f64; 7] {
        let [with, without] = [with, without].map(|one| one.predict(step).unwrap().to_array());
        std::array::from_fn(|k| with[k] - without[k])
    };
    let roughly = [&with, &without].map(|one| one.clone().in_half_the_substeps());
    [change(&with, &without), change(&roughly[0], &roughly[1])]
}

/// Inertia is switched: what sub-steps miss is not the same on both sides; a pusher that sticks more at rest
/// lets go at another sub-step.
#[test]
fn differences_in_half_the_substeps_are_nearly_those_in_all() {
    for surface in super::SURFACES {
        let steps = straight_steps();
        let steps: Vec<_> = steps.iter().filter(|step| !is_concave(step)).collect();
        for effect in all().iter().filter(|effect| !JUMPS.contains(&effect.info().id)) {
            let of_steps: Vec<_> =
                steps.iter().map(|step| changes_by(effect, &surface, step)).collect();
            for number in 0..7 {
                let square = |of: fn(&[[f64; 7]; 2], usize) -> f64| -> f64 {
                    of_steps.iter().map(|changes| of(changes, number).powi(2)).sum()
                };
                let (size, missed) =
                    (square(|c, k| c[0][k]).sqrt(), square(|c, k| c[1][k] - c[0][k]).sqrt());
                let id = effect.info().id;
                assert!(missed <= 0.1 * size + 1e-9, "{id} {surface:?} {number}: {missed} {size}");
            }
        }
    }
}

#[test]
fn shorter_substeps_come_nearer_to_the_limit() {
    for surface in super::SURFACES {
        let steps = straight_steps();
        let steps: Vec<_> = steps.iter().filter(|step| !is_concave(step)).step_by(5).collect();
        for effect in all() {
            let id = effect.info().id;
            let steps: Vec<_> = match id {
                "inertia" => steps.iter().map(|step| moving(&surface, step)).collect(),
                _ => steps.iter().map(|step| (*step).clone()).collect(),
            };
            let limit = model(effect, &surface, 3e-5);
            let [coarse, fine] = [1e-3, 2.5e-4].map(|longest| {
                let physics = model(effect, &surface, longest);
                root_mean_square(steps.iter().map(|step| end_apart(&physics, &limit, step)))
            });
            assert!(fine < coarse / 3.0, "{id} {surface:?}: {coarse} {fine}");
        }
    }
}

#[test]
fn few_substeps_follow_an_impact_on_an_object_at_rest() {
    let effect = by_id("inertia").unwrap();
    for surface in super::SURFACES {
        let [physics, limit] = [1e-3, 3e-5].map(|longest| model(effect, &surface, longest));
        for step in straight_steps().iter().filter(|step| step.touching && !is_concave(step)) {
            let step = StepInput { twist_wb: Twist::default(), ..step.clone() };
            let apart = end_apart(&physics, &limit, &step);
            assert!(apart < 2e-5, "{surface:?}: {apart} m, {:?}", step.pose_wb);
        }
    }
}

/// How far two models' ends of a step are from each other, in m.
fn end_apart(one: &PushPhysics, other: &PushPhysics, step: &StepInput) -> f64 {
    let end = |physics| pose_after(physics, step, step.track.duration());
    apart(motion(&end(one), &end(other)), [0.0; 3])
}

fn root_mean_square(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n_values = values.len() as f64;
    (values.map(|value| value * value).sum::<f64>() / n_values).sqrt()
}

/// Energy in J: what the pusher and other loads do, less what the object takes up.
fn dissipated(effect: &Arc<dyn Effect>, physics: &PushPhysics, step: &StepInput) -> [f64; 2] {
    let typical = effect.info().typical(physics.rig());
    let (mut measurement, mut geometry) = (MeasurementModel::default(), Geometry::default());
    effect.measurement(&typical, step, &mut measurement);
    effect.geometry(&typical, step, &mut geometry);
    let pose_bo = Pose { position: measurement.offset_b, angle: measurement.yaw };
    let duration = step.track.duration();
    let found = physics.predict(step).unwrap();
    let end = pose_after(physics, step, duration);
    // The true force, in W.
    let center_b = step.pose_wb.inverse_transform_point(&step.track.start());
    let normal_b = step.object.shape().contact(&center_b, step.pusher_radius).normal;
    let normal = step.pose_wb.rotate(&normal_b);
    let shown = found.force_normal * normal + found.force_tangential * perpendicular(&normal);
    let force =
        Pose::new(0.0, 0.0, -measurement.force_turn).rotate(&(shown - measurement.force_bias_w));
    // Where it acts, and how far that goes.
    let [before, after] = [step.pose_wb, end].map(|pose_wb| pose_wb * pose_bo);
    let center_o = before.inverse_transform_point(&step.track.at(-measurement.latency).0);
    let contact = step.object.shape().contact(&center_o, step.pusher_radius);
    let place = contact.point - geometry.contact_shift * perpendicular(&contact.normal);
    let way = |place: &Vector2<f64>| after.transform_point(place) - before.transform_point(place);
    let mut load = Wrench::default();
    let moment = Snapshot { rig: physics.rig(), step, pose_wo: before, time: 0.0 };
    effect.load(&typical, &moment, &mut load);
    let work = force.dot(&way(&place))
        + load.force.dot(&way(&Vector2::zeros()))
        + load.torque * (after.angle - before.angle);
    let taken = match effect.has_inertia(&typical) {
        true => {
            kinetic(step, &rest(physics, step, 0.99 * duration).twist_wb, &end)
                - kinetic(step, &step.twist_wb, &step.pose_wb)
        }
        false => 0.0,
    };
    [work - taken, force.norm() * step.track.mean_velocity().norm() * duration]
}

fn kinetic(step: &StepInput, twist: &Twist, pose: &Pose) -> f64 {
    let object = &step.object;
    let arm = pose.rotate(object.center_of_mass());
    let speed = twist.velocity_at(&arm);
    0.5 * (object.mass() * speed.norm_squared()
        + object.moment_of_inertia() * twist.angular * twist.angular)
}

#[test]
fn no_effect_makes_energy() {
    for surface in super::SURFACES {
        let steps = straight_steps();
        for effect in all() {
            let physics = model(effect, &surface, 1e-3);
            for step in steps.iter().filter(|step| step.touching) {
                // After some way, so that contact is made and the object goes with the pusher.
                let step = rest(&physics, &settled(&physics, step), 0.7 * step.track.duration());
                let short = part(&step, 0.0, 0.02 * step.track.duration());
                let [energy, scale] = dissipated(effect, &physics, &short);
                assert!(energy > 0.1 * scale, "{} {surface:?}: {energy} J", effect.info().id);
            }
        }
    }
}
