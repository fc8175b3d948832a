//! Where the tracking of the object has jumped.

use std::collections::HashSet;

use models::ChannelObservation;

/// Motion over the pusher's way that no contact makes, beyond what poses are off by, in m and rad.
const LARGEST_WAYS: f64 = 3.0;
const POSES_OFF: [f64; 2] = [5e-3, 0.1];
/// Least distance, over the mean one of the outline, at which an object's load may press: the turn of a
/// push is at most its way over twice that.
const LEAST_LEVER: f64 = 0.1;

/// Share of the pushes that a tracking may lose.
const MOST_JUMPING: f64 = 0.1;

/// Whether no contact moves the object as far as in a step: the tracking has jumped.
fn is_jump(step: &ChannelObservation) -> bool {
    let [Some(dx), Some(dy), Some(dtheta), ..] = step.observed else { return false };
    let track = &step.input.track;
    let way = (track.end() - track.start()).norm();
    let lever = 2.0 * LEAST_LEVER * step.input.object.mean_distance();
    dx.hypot(dy) > LARGEST_WAYS * way + POSES_OFF[0] || dtheta.abs() > way / lever + POSES_OFF[1]
}

/// Which of some steps, each with its push in the order of time, follow a jump or are one; none where a
/// good part of the pushes would jump, for then a unit is wrong.
pub(crate) fn after_jumps<'a>(
    steps: impl Iterator<Item = (usize, &'a ChannelObservation)>,
) -> Vec<bool> {
    let (mut lost, mut pushes) = (HashSet::new(), HashSet::new());
    let is_after = |(push, step): (usize, &ChannelObservation)| {
        pushes.insert(push);
        if is_jump(step) {
            lost.insert(push);
        }
        lost.contains(&push)
    };
    let mut found: Vec<bool> = steps.map(is_after).collect();
    if lost.len() as f64 > MOST_JUMPING * pushes.len() as f64 {
        found.fill(false);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::after_jumps;
    use crate::synthetic::recorded;

    #[test]
    fn a_flip_of_the_tracking_takes_the_rest_of_its_push_alone() {
        let (mut all, _) = recorded(11);
        let marked =
            |all: &crate::Observations| after_jumps(all.push_of.iter().copied().zip(&all.steps));
        assert!(marked(&all).iter().all(|is_after| !is_after));
        let flip = (1..all.n_steps()).find(|step| all.goes_on(*step)).unwrap();
        all.steps[flip].observed[2] = Some(113.0_f64.to_radians());
        let found = marked(&all);
        for (step, is_after) in found.into_iter().enumerate() {
            assert_eq!(is_after, all.push_of[step] == all.push_of[flip] && step >= flip, "{step}");
        }
        // In degrees nearly all turn too far: that is told by others.
        for step in &mut all.steps {
            step.observed[2] = step.observed[2].map(|turn| 57.3 * turn);
        }
        assert!(marked(&all).iter().all(|is_after| !is_after));
    }
}
