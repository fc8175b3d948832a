//! What was done, a line a reader.

use super::watch::Outcome;

/// Above the lines of [`row`].
pub(super) const HEADER: &str =
    "reader            cases   accepted   cases/s   slowest in ms (case)   failures";

/// The line of a reader.
pub(super) fn row(name: &str, outcome: &Outcome) -> String {
    let tally = &outcome.tally;
    let slowest = format!("{:.1} ({})", 1e3 * tally.slowest, tally.slowest_case);
    format!(
        "{name:<14} {:>8} {:>9.1}% {:>9.0} {slowest:>22} {:>10}",
        tally.cases,
        100.0 * tally.accepted as f64 / tally.cases.max(1) as f64,
        tally.cases as f64 / tally.busy.max(1e-9),
        outcome.faults.len(),
    )
}

/// The line of all readers.
pub(super) fn total(outcomes: &[Outcome]) -> String {
    let mut sum = Outcome::default();
    for outcome in outcomes {
        sum.tally.cases += outcome.tally.cases;
        sum.tally.busy += outcome.tally.busy;
    }
    let n_faults: usize = outcomes.iter().map(|outcome| outcome.faults.len()).sum();
    let rate = sum.tally.cases as f64 / sum.tally.busy.max(1e-9);
    format!(
        "{} cases by {} readers, {rate:.0}/s, {n_faults} failures",
        sum.tally.cases,
        outcomes.len()
    )
}

#[cfg(test)]
mod tests {
    use super::super::worker::Tally;
    use super::{HEADER, Outcome, row, total};

    #[test]
    fn lines_have_the_numbers_of_their_reader() {
        let tally =
            Tally { cases: 2000, accepted: 500, busy: 0.5, slowest: 0.0123, slowest_case: 7 };
        let outcome = Outcome { tally, faults: Vec::new() };
        let line = row("mcap", &outcome);
        assert_eq!(
            line.split_whitespace().collect::<Vec<_>>().join(" "),
            "mcap 2000 25.0% 4000 12.3 (7) 0"
        );
        assert!(line.len() <= HEADER.len() + 4, "{line}");
        assert_eq!(total(&[outcome]), "2000 cases by 1 readers, 4000/s, 0 failures");
    }
}
