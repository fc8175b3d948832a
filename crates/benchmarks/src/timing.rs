//! Interleaved timing of a candidate and its reference.

use std::hint::black_box;
use std::time::Instant;

use serde::{Deserialize, Serialize};

/// What is timed: its name, its problem size, the threads it uses, and how often it runs.
pub(crate) struct Case<'a> {
    pub(crate) name: &'a str,
    /// What grows from row to row; the benchmark says what it counts.
    pub(crate) size: usize,
    pub(crate) threads: usize,
    /// Timed turns of each side, after one that is not counted.
    pub(crate) rounds: usize,
    /// Calls in one turn: many where a single one is shorter than the clock can tell.
    pub(crate) calls: usize,
}

/// Medians over the rounds, each of one call.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Row {
    pub(crate) name: String,
    pub(crate) size: usize,
    pub(crate) threads: usize,
    /// Time of the candidate, in s.
    pub(crate) median_seconds: f64,
    /// Time of the reference, in s.
    pub(crate) reference_seconds: f64,
    /// Candidate over reference: below 1 the candidate is faster.
    pub(crate) ratio: f64,
    /// Largest resident memory of a process that did it alone, in MB.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) peak_memory_mb: Option<f64>,
}

impl Case<'_> {
    /// Times both in turn, so that a change of the machine's load meets both alike; who goes first
    /// changes every round.
    pub(crate) fn compare<T, U>(
        &self,
        mut candidate: impl FnMut() -> T,
        mut reference: impl FnMut() -> U,
    ) -> Row {
        let round = |index: usize| {
            if index.is_multiple_of(2) {
                let time = self.turn(&mut candidate);
                (time, self.turn(&mut reference))
            } else {
                let reference_time = self.turn(&mut reference);
                (self.turn(&mut candidate), reference_time)
            }
        };
        let (times, reference_times) = (0..=self.rounds).map(round).skip(1).unzip();
        self.row(median(times), median(reference_times))
    }

    /// Mean time of one call over one turn, in s.
    fn turn<T>(&self, call: &mut impl FnMut() -> T) -> f64 {
        let start = Instant::now();
        for _ in 0..self.calls {
            black_box(call());
        }
        start.elapsed().as_secs_f64() / self.calls as f64
    }

    fn row(&self, median_seconds: f64, reference_seconds: f64) -> Row {
        Row {
            name: self.name.into(),
            size: self.size,
            threads: self.threads,
            median_seconds,
            reference_seconds,
            ratio: median_seconds / reference_seconds,
            peak_memory_mb: None,
        }
    }
}

/// The middle value, or the mean of the two middle ones.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len().is_multiple_of(2) {
        f64::midpoint(values[middle - 1], values[middle])
    } else {
        values[middle]
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use super::{Case, median};

    const CASE: Case<'_> = Case { name: "a", size: 10, threads: 2, rounds: 3, calls: 2 };

    #[test]
    fn the_median_ignores_order_and_outliers() {
        assert_eq!(median(vec![3.0, 1.0, 1e9]), 3.0);
        assert_eq!(median(vec![4.0, 1.0, 2.0, 1e9]), 3.0);
        assert_eq!(median(vec![5.0]), 5.0);
    }

    #[test]
    fn both_sides_take_turns_and_the_first_changes() {
        let calls = RefCell::new(String::new());
        CASE.compare(|| calls.borrow_mut().push('c'), || calls.borrow_mut().push('r'));
        assert_eq!(*calls.borrow(), "ccrrrrccccrrrrcc");
    }

    #[test]
    fn a_row_is_the_candidate_over_the_reference() {
        let row = CASE.row(3.0, 2.0);
        assert_eq!((row.name.as_str(), row.size, row.threads), ("a", 10, 2));
        assert_eq!((row.median_seconds, row.reference_seconds, row.ratio), (3.0, 2.0, 1.5));
    }
}
