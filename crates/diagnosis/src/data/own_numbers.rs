//! Which numbers of a push are observed, and which of them follow from others.

use effects::Channels;

use crate::Observations;

/// Places of the motion and of the gaps among the numbers of a step.
const MOTION: std::ops::Range<usize> = 0..3;
const GAP_START: usize = 5;
const GAP_END: usize = 6;

impl Observations {
    /// Whether a number of a step is observed, and does not follow from others: the gap that ends a step is that
    /// which begins it, moved by the step, in what is measured and in any model.
    pub(crate) fn is_own(&self, step: usize, number: usize) -> bool {
        let is_there = |step: usize, number: usize| self.steps[step].observed[number].is_some();
        let has_motion = MOTION.into_iter().all(|k| is_there(step, k));
        let follows = match number {
            GAP_START => self.goes_on(step) && is_there(step - 1, GAP_END),
            GAP_END => has_motion && is_there(step, GAP_START),
            _ => false,
        };
        is_there(step, number) && !follows
    }

    /// The numbers of each push that are observed and its own, each as (step, number of
    /// [`effects::Channels`]).
    pub(crate) fn own_numbers(&self) -> Vec<Vec<(usize, usize)>> {
        self.numbers_of_pushes(|step, number| self.is_own(step, number))
    }

    /// The numbers of each push that are observed.
    pub(crate) fn all_numbers(&self) -> Vec<Vec<(usize, usize)>> {
        self.numbers_of_pushes(|step, number| self.steps[step].observed[number].is_some())
    }

    fn numbers_of_pushes(&self, is_one: impl Fn(usize, usize) -> bool) -> Vec<Vec<(usize, usize)>> {
        let mut numbers = vec![Vec::new(); self.pushes.len()];
        for (step, push) in self.push_of.iter().enumerate() {
            let own = (0..Channels::NAMES.len()).filter(|number| is_one(step, *number));
            numbers[*push].extend(own.map(|number| (step, number)));
        }
        numbers
    }
}

#[cfg(test)]
mod tests {
    use effects::{Setting, StepInput, by_id};
    use models::ModelEffect;
    use nalgebra::Vector2;
    use planar::{Pose, perpendicular};

    use super::{GAP_END, GAP_START};
    use crate::Predictions;
    use crate::synthetic::recorded;

    /// The gap at the end of a step from the gap at its start and the motion.
    fn moved(step: &StepInput, [dx, dy, dtheta, _, _, start, _]: [f64; 7]) -> f64 {
        let contact = |pose_wb: &Pose, center_w: &Vector2<f64>| {
            let center_b = pose_wb.inverse_transform_point(center_w);
            step.object.shape().contact(&center_b, step.pusher_radius)
        };
        let mut pose_wb = step.pose_wb;
        let first = contact(&pose_wb, &step.track.start());
        pose_wb.position += (start - first.gap) * pose_wb.rotate(&first.normal);
        let along = step.direction_w();
        pose_wb.position += dx * along + dy * perpendicular(&along);
        pose_wb.angle += dtheta;
        contact(&pose_wb, &step.track.end()).gap
    }

    #[test]
    fn the_gap_that_ends_a_step_follows_from_what_moved_and_is_counted_once() {
        let (all, mut model) = recorded(1);
        for id in ["pusher-compliance", "stream-latency", "yaw-offset"] {
            let about = by_id(id).unwrap().info();
            let typical: Vec<f64> = about.parameters.iter().map(|one| one.typical).collect();
            model.effects.push(ModelEffect::from(Setting::new(about, &typical)));
        }
        let predicted = Predictions::of(&model, &[], &all).unwrap();
        for (step, predicted) in all.steps.iter().zip(predicted.steps()) {
            for numbers in [&step.observed, predicted] {
                let numbers = numbers.map(Option::unwrap);
                let off = moved(&step.input, numbers) - numbers[GAP_END];
                // The object is set to the tip along its true normal, here along the measured one.
                assert!(off.abs() < 1e-6, "{off}");
            }
        }
        let own: Vec<(usize, usize)> = all.own_numbers().into_iter().flatten().collect();
        assert!(own.iter().all(|(_, number)| *number != GAP_END));
        let starts = own.iter().filter(|(_, number)| *number == GAP_START).count();
        let runs = (0..all.n_steps()).filter(|step| !all.goes_on(*step)).count();
        assert_eq!(starts, runs);
    }
}
