//! What the force says about one push, from its samples as recorded.

use dataset::{ForceZero, WrenchStream};

use super::choice::Choice;
use crate::held_out::quantile;

/// Samples from which the force alone can guess its zero: the first ones.
const N_ZERO: usize = 5;
/// Consecutive samples above the threshold that count as contact.
const N_SUSTAINED: usize = 3;
/// A static peak falls into this time, the dynamic level right after it into the next, in s.
const PEAK_TIME: f64 = 0.15;
const LEVEL_TIME: f64 = 0.4;

/// Magnitudes of the force over time.
pub(super) struct Forces {
    /// Time since first contact, in s, increasing.
    pub(super) t: Vec<f64>,
    /// As recorded, in N.
    pub(super) recorded: Vec<f64>,
    /// With the zero subtracted, in N; empty if it is not known.
    pub(super) tared: Vec<f64>,
    components: Vec<[f64; 2]>,
}

impl Forces {
    /// The forces of a push, within the time that belongs to it.
    pub(super) fn of(choice: &Choice, wrench: &WrenchStream) -> Self {
        let (from, until) = choice.window();
        let mut order: Vec<_> =
            (0..wrench.len()).filter(|&i| (from..until).contains(&wrench.t[i])).collect();
        order.sort_by(|&a, &b| wrench.t[a].total_cmp(&wrench.t[b]));
        let of = |f: &dyn Fn(usize) -> f64| order.iter().map(|&i| f(i)).collect::<Vec<f64>>();
        let tared = match choice.recording.force_zero {
            ForceZero::Tared { offset_n: [x, y], .. } => {
                of(&|i| (wrench.fx[i] - x).hypot(wrench.fy[i] - y))
            }
            _ => Vec::new(),
        };
        Self {
            t: of(&|i| wrench.t[i] - choice.push.contact_start_s),
            recorded: of(&|i| wrench.fx[i].hypot(wrench.fy[i])),
            tared,
            components: order.iter().map(|&i| [wrench.fx[i], wrench.fy[i]]).collect(),
        }
    }

    /// Start and end of contact by nothing but the force: it starts where the force leaves its first
    /// level by `threshold`, and ends where it last exceeds half of its own median in between.
    pub(super) fn contact_by_force(&self, threshold: f64) -> Option<(f64, f64)> {
        let head = self.components.get(..N_ZERO)?;
        let zero = [0, 1].map(|k| head.iter().map(|f| f[k]).sum::<f64>() / N_ZERO as f64);
        let change = |f: &[f64; 2]| (f[0] - zero[0]).hypot(f[1] - zero[1]);
        let changes: Vec<f64> = self.components.iter().map(change).collect();
        let exceeds = |level: f64| move |run: &[f64]| run.iter().all(|change| *change > level);
        let start = changes.windows(N_SUSTAINED).position(exceeds(threshold))?;
        let pressing = changes[start..].iter().copied().filter(|change| *change > threshold);
        let half = 0.5 * median(pressing.collect())?;
        let end = changes.windows(N_SUSTAINED).rposition(exceeds(half))? + N_SUSTAINED - 1;
        Some((self.t[start], self.t[end]))
    }

    /// Largest force right after first contact over the level that follows.
    pub(super) fn peak_over_level(&self) -> Option<f64> {
        let between = |from: f64, to: f64| {
            let inside = self.t.iter().zip(&self.tared).filter(|(t, _)| (from..to).contains(*t));
            inside.map(|(_, force)| *force).collect::<Vec<f64>>()
        };
        let peak = between(0.0, PEAK_TIME).into_iter().reduce(f64::max)?;
        Some(peak / median(between(PEAK_TIME, LEVEL_TIME))?)
    }
}

/// The middle value, or the mean of the two middle ones.
pub(super) fn median(values: Vec<f64>) -> Option<f64> {
    (!values.is_empty()).then(|| quantile(values, 0.5))
}

#[cfg(test)]
mod tests {
    use super::{Forces, median};

    /// Free for 0.2 s at a zero of 1 N, then `level` with a peak at first, then free again.
    fn forces(peak: f64, level: f64) -> Forces {
        let t: Vec<f64> = (0..200).map(|k| f64::from(k) / 100.0 - 0.2).collect();
        let force = |t: &f64| match t {
            t if !(0.0..1.0).contains(t) => 0.0,
            t if *t < 0.05 => peak,
            _ => level,
        };
        let tared: Vec<f64> = t.iter().map(force).collect();
        let components = tared.iter().map(|f| [1.0, *f]).collect();
        Forces { recorded: tared.iter().map(|f| f.hypot(1.0)).collect(), t, tared, components }
    }

    #[test]
    fn contact_is_where_the_force_leaves_its_first_level() {
        let (start, end) = forces(2.0, 2.0).contact_by_force(0.5).unwrap();
        assert!(start.abs() < 1e-9 && (end - 0.99).abs() < 1e-9, "{start} {end}");
        assert_eq!(forces(0.1, 0.1).contact_by_force(0.5), None);
    }

    #[test]
    fn a_peak_is_measured_against_the_level_after_it() {
        assert_eq!(forces(3.0, 2.0).peak_over_level(), Some(1.5));
        assert_eq!(forces(2.0, 2.0).peak_over_level(), Some(1.0));
    }

    #[test]
    fn the_median_of_an_even_number_is_between_the_middle_two() {
        assert_eq!(median(vec![4.0, 1.0, 3.0, 2.0]), Some(2.5));
        assert_eq!(median(vec![3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(Vec::new()), None);
    }
}
