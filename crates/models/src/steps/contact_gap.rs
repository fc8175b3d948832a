//! What contact makes of the gap that was measured when it began.

use serde::{Deserialize, Serialize};

/// The gap between pusher and outline as a model has them, as it is measured, while contact holds:
/// offset + kept · (the gap when contact began) ± sd.
///
/// An outline and a pusher that are not as they are nominally keep their gap through a push, and
/// `kept` is near 1; a first pose of a contact that has not closed yet says nothing of it, and `kept`
/// is near 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactGap {
    /// In m.
    pub offset: f64,
    /// Share of the gap when contact began.
    pub kept: f64,
    /// Standard deviation about it, in m.
    pub sd: f64,
}

impl Default for ContactGap {
    /// Contact holds the gap exactly.
    fn default() -> Self {
        Self { offset: 0.0, kept: 1.0, sd: 0.0 }
    }
}

impl ContactGap {
    /// By least squares over the gaps of each push, at its start and after each step
    /// ([`crate::RecordedPush::gaps`]); the sd is as of so many pushes, not steps.
    pub(crate) fn of_gaps(pushes: &[Vec<f64>]) -> Self {
        let pairs = || pushes.iter().flat_map(|gaps| gaps[1..].iter().map(|gap| (gaps[0], *gap)));
        let n = pairs().count().max(1) as f64;
        let mean = |of: &dyn Fn((f64, f64)) -> f64| pairs().map(of).sum::<f64>() / n;
        let (first, later) = (mean(&|(first, _)| first), mean(&|(_, later)| later));
        let variance = mean(&|(own, _)| (own - first).powi(2));
        let product = mean(&|(own, held)| (own - first) * (held - later));
        let kept = if variance > LEAST_SD * LEAST_SD { product / variance } else { 1.0 };
        let offset = later - kept * first;
        let left = mean(&|(own, held)| (held - offset - kept * own).powi(2));
        // Two numbers were learnt from as many pushes as there are.
        let n_pushes = pushes.len() as f64;
        let sd = (left * n_pushes / (n_pushes - 2.0).max(1.0)).sqrt();
        Self { offset, kept, sd }
    }

    /// The gap that contact holds if it began with one, in m.
    pub(crate) fn held(&self, first: f64) -> f64 {
        self.offset + self.kept * first
    }
}

/// Gaps that scatter by less, in m, are the same.
const LEAST_SD: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::ContactGap;

    #[test]
    fn gaps_that_stay_are_kept_and_those_of_an_open_contact_are_not() {
        let wiggle = |k: usize| 1e-5 * ((k * 7919 % 17) as f64 - 8.0) / 8.0;
        let push = |held: &dyn Fn(f64) -> f64, k: usize| -> Vec<f64> {
            let first = 1e-4 * (k as f64 * 0.618).fract();
            std::iter::once(first)
                .chain((0..9).map(|step| held(first) + wiggle(9 * k + step)))
                .collect()
        };
        let found = |held: &dyn Fn(f64) -> f64| {
            ContactGap::of_gaps(&(0..200).map(|k| push(held, k)).collect::<Vec<_>>())
        };
        for (truth, offset, kept) in
            [(&(|gap| gap) as &dyn Fn(f64) -> f64, 0.0, 1.0), (&|_| -4e-5, -4e-5, 0.0)]
        {
            let found = found(truth);
            assert!((found.kept - kept).abs() < 0.03, "{found:?}");
            assert!((found.offset - offset).abs() < 2e-6, "{found:?}");
            assert!((found.sd / 6.1e-6 - 1.0).abs() < 0.05, "{found:?}");
        }
    }

    #[test]
    fn gaps_that_all_begin_alike_are_kept_with_what_they_change() {
        let found = ContactGap::of_gaps(&vec![vec![2e-5, 3e-5, 3e-5]; 5]);
        assert!((found.kept - 1.0).abs() < 1e-12 && (found.offset - 1e-5).abs() < 1e-12);
        assert!(found.sd < 1e-12 && (found.held(0.0) - 1e-5).abs() < 1e-12, "{found:?}");
    }
}
