//! What an effect makes worse: a cause of what is missed leaves no measured number farther off.

use crate::compare::words::size;
use crate::cut_offs::{RAISED, SURE_SE};
use crate::data::clusters::ClusterMean;

/// The numbers of a step that are asked, as [`effects::Channels::NAMES`] has them first: how they are said, and
/// their units.
const NUMBERS: [(&str, &str); 5] = [
    ("the motion along x", "m"),
    ("the motion along y", "m"),
    ("the turn", "rad"),
    ("the normal force", "N"),
    ("the tangential force", "N"),
];

/// What is missed of each of these numbers, squared, with the cluster of its step.
#[derive(Clone, Debug, Default)]
pub(super) struct Missed([Vec<(usize, f64)>; NUMBERS.len()]);

/// A number of a step that held-out pushes miss by more with effects than without them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Raised {
    number: usize,
    /// Root mean square of what is missed without them and with them, in the number's unit.
    rms: [f64; 2],
}

impl Missed {
    /// Of residuals in the units of their numbers, with the clusters of their steps.
    pub(super) fn of(residuals: &[[Option<f64>; 7]], cluster_of: &[usize]) -> Self {
        let of_number = |number: usize| {
            let steps = residuals.iter().zip(cluster_of);
            let known = steps.filter_map(|(step, cluster)| Some((*cluster, step[number]?)));
            known.map(|(cluster, missed)| (cluster, missed * missed)).collect()
        };
        Self(std::array::from_fn(of_number))
    }

    /// Root mean square of what is missed of each number; none where it was not measured.
    pub(super) fn rms(&self) -> [Option<f64>; NUMBERS.len()] {
        self.0.each_ref().map(|squares| (!squares.is_empty()).then(|| rms(squares)))
    }
}

impl Raised {
    /// The number that is missed by the most more with an effect, where that is sure and a quarter of its mean
    /// square.
    pub(super) fn of(without: &Missed, with: &Missed) -> Option<Self> {
        let of_number = |number: usize| {
            let (before, after) = (&without.0[number], &with.0[number]);
            let pairs = before.iter().zip(after);
            let more: Vec<_> = pairs.map(|((cluster, a), (_, b))| (*cluster, b - a)).collect();
            let more = ClusterMean::of(&more)?;
            let found = Self { number, rms: [rms(before), rms(after)] };
            let is_sure = more.mean >= SURE_SE * more.se;
            (is_sure && found.times_as_much() >= 1.0 + RAISED).then_some(found)
        };
        let found = (0..NUMBERS.len()).filter_map(of_number);
        found.max_by(|a, b| a.times_as_much().total_cmp(&b.times_as_much()))
    }

    /// The mean square of what is missed with the effect over that without it.
    fn times_as_much(&self) -> f64 {
        let [before, after] = self.rms;
        (after / before).powi(2)
    }

    /// With `what` the number is missed by more.
    pub(super) fn sentence(&self, what: &str) -> String {
        let ((name, unit), [before, after]) = (NUMBERS[self.number], self.rms);
        format!(
            "with {what}, held-out pushes miss {name} by more, {} instead of {}",
            size(after, unit),
            size(before, unit)
        )
    }
}

fn rms(squares: &[(usize, f64)]) -> f64 {
    let n = squares.len().max(1) as f64;
    (squares.iter().map(|(_, square)| square).sum::<f64>() / n).sqrt()
}

#[cfg(test)]
mod tests {
    use super::{Missed, Raised};

    /// Twenty pushes of three steps that miss the tangential force by so much, in N, and turns by a tenth of it.
    fn missed(newton: impl Fn(usize) -> f64) -> Missed {
        let cluster_of: Vec<usize> = (0..60).map(|step| step / 3).collect();
        let step = |cluster: &usize| {
            let force = newton(*cluster);
            [None, None, Some(0.1), None, Some(force), None, None]
        };
        let residuals: Vec<_> = cluster_of.iter().map(step).collect();
        Missed::of(&residuals, &cluster_of)
    }

    #[test]
    fn what_is_missed_by_more_is_told_in_its_unit() {
        let without = missed(|_| 0.2);
        let raised = Raised::of(&without, &missed(|push| 0.25 + 0.001 * push as f64)).unwrap();
        let told = raised.sentence("it");
        assert!(told.contains("tangential force by more, 0.26 N instead of 0.20 N"), "{told}");
        let known = without.rms().map(|rms| rms.map(|rms| (1e9 * rms).round() / 1e9));
        assert_eq!(known, [None, None, Some(0.1), None, Some(0.2)]);
    }

    #[test]
    fn little_more_is_nothing_and_so_is_much_more_of_one_push_alone() {
        let without = missed(|_| 0.2);
        assert_eq!(Raised::of(&without, &without), None);
        assert_eq!(Raised::of(&without, &missed(|_| 0.22)), None);
        assert_eq!(Raised::of(&without, &missed(|_| 0.1)), None);
        assert_eq!(Raised::of(&without, &missed(|push| if push == 7 { 2.0 } else { 0.2 })), None);
    }
}
