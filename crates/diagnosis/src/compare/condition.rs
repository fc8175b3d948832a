//! A range of a covariate, as a finding names it.

use serde::Serialize;

use crate::compare::axis::Axis;
use crate::statistics::box_search::CellRange;
use crate::{Covariate, Observations};

/// A range of a covariate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Condition {
    /// Of what.
    pub covariate: Covariate,
    /// Lower end; none where the range goes down to the end of the data. Angles may pass π.
    pub from: Option<f64>,
    /// Upper end; none where the range goes up to the end of the data. For edges the last of them.
    pub to: Option<f64>,
}

impl Condition {
    /// None for a range that holds every step.
    pub(crate) fn of(axis: &Axis, range: CellRange) -> Option<Self> {
        let (covariate, n) = (axis.covariate, axis.n_cells());
        let (last, [first_used, last_used]) = (range.first + range.n - 1, axis.used());
        let is_open = [range.first <= first_used, last >= last_used];
        if range.n == n || (is_open == [true; 2] && !covariate.is_periodic()) {
            return None;
        }
        let [from, to] = [axis.bins.ends(range.first)[0], axis.bins.ends(last % n)[1]];
        let condition = |from, to| Some(Self { covariate, from, to });
        match covariate {
            Covariate::Edge => condition(Some(from + 0.5), Some(to - 0.5)),
            _ if covariate.is_periodic() => {
                let to = if last >= n { to + std::f64::consts::TAU } else { to };
                condition(Some(from), Some(to))
            }
            _ => condition((!is_open[0]).then_some(from), (!is_open[1]).then_some(to)),
        }
    }

    /// Whether a step is within the range.
    pub(crate) fn holds(&self, observations: &Observations, step: usize) -> bool {
        let value = observations.value_of(self.covariate, step);
        let is_within = |value: f64| {
            self.from.is_none_or(|from| from <= value) && self.to.is_none_or(|to| value <= to)
        };
        // A range of angles may pass π.
        is_within(value)
            || (self.covariate.is_periodic() && is_within(value + std::f64::consts::TAU))
    }
}

#[cfg(test)]
mod tests {
    use super::Condition;
    use crate::Covariate;
    use crate::synthetic::made;
    use std::f64::consts::PI;

    #[test]
    fn a_step_is_in_a_range_with_both_ends() {
        let (mut steps, ..) = made(0, |_| 0.0);
        let mut holds = |covariate, value: f64, from, to| {
            match covariate {
                Covariate::Edge => steps.places[0].edge = value as u32,
                Covariate::Orientation => steps.steps[0].input.pose_wb.angle = value,
                _ => steps.places[0].p = value,
            }
            Condition { covariate, from, to }.holds(&steps, 0)
        };
        let p = [0.2, 0.5, 0.6, 0.199, 0.601];
        let within = p.map(|p| holds(Covariate::P, p, Some(0.2), Some(0.6)));
        assert_eq!(within, [true, true, true, false, false]);
        assert!(
            holds(Covariate::P, 0.9, Some(0.8), None) && !holds(Covariate::P, 0.7, Some(0.8), None)
        );
        assert!(
            holds(Covariate::P, 0.1, None, Some(0.2)) && !holds(Covariate::P, 0.3, None, Some(0.2))
        );
        // One edge, and a range of edges.
        let edges = |edge: u32| holds(Covariate::Edge, f64::from(edge), Some(1.0), Some(2.0));
        assert_eq!([0, 1, 2, 3].map(edges), [false, true, true, false]);
    }

    #[test]
    fn a_range_of_angles_may_pass_the_half_turn() {
        let (mut steps, ..) = made(0, |_| 0.0);
        let past = Condition {
            covariate: Covariate::Orientation,
            from: Some(0.75 * PI),
            to: Some(1.25 * PI),
        };
        let mut holds = |angle: f64| {
            steps.steps[0].input.pose_wb.angle = angle;
            past.holds(&steps, 0)
        };
        let angles = [0.8, 1.0, -0.9, -0.7, 0.7, 0.0, 2.8].map(|turns| holds(turns * PI));
        assert_eq!(angles, [true, true, true, false, false, false, true]);
    }
}
