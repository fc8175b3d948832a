//! A slice of a few minutes that a broken verdict does not pass.

use std::fs;
use std::path::Path;
use std::time::Duration;

use anyhow::{Result, ensure};

use super::case::{Asked, Case, Family, Pushes, Sessions, Setup, Size};
use super::plan;
use super::queue::Queue;
use super::record::{self, Record};
use super::score::is_right;

/// Seed of the slice: of development, for it runs with every change.
const SEED: u64 = 500_000;
const N_PUSHES: usize = 60;
/// What takes longer hangs.
const PATIENCE: Duration = Duration::from_secs(600);
/// Effects that such a set shows many times over.
const PLAIN: [&str; 6] = [
    "table-anisotropy",
    "friction-center-offset",
    "pusher-friction",
    "table-tilt",
    "contact-bias",
    "stream-latency",
];

/// A few sets where nothing is hidden, where a plain effect is, where the force that would show it
/// is missing, and one of pushes that cannot tell effects apart.
pub(super) fn cases() -> Vec<Case> {
    let setup = Setup { n_pushes: N_PUSHES, ..Setup::RICH };
    let first = |family: Family, n: usize| plan::cases(family, SEED).into_iter().take(n);
    let mut cases: Vec<Case> = first(Family::Nothing, 2).chain(first(Family::Narrow, 1)).collect();
    for id in PLAIN {
        let known = plan::cases(Family::Typical, SEED).into_iter();
        cases.extend(known.filter(|case| case.hidden.first() == Some(&Asked::typical(id))).take(1));
    }
    cases.extend(first(Family::Untestable, 1));
    for case in &mut cases {
        let Setup { pushes, has_force, .. } = case.setup;
        case.name = format!("quick/{}", case.name);
        let is_plain = !matches!(pushes, Pushes::Narrow | Pushes::Central);
        case.setup = if is_plain { Setup { pushes, has_force, ..setup } } else { case.setup };
        case.setup.sessions = Sessions::Alike;
        // No oracle is asked.
        case.hidden.iter_mut().for_each(|asked| asked.size = Size::Typical(1.0));
    }
    cases
}

/// Runs the slice.
///
/// # Errors
/// A wrong name, a plain effect that is not found, no answer.
pub(super) fn run(n_jobs: usize, folder: &Path) -> Result<()> {
    let results = folder.join("quick.jsonl");
    if results.exists() {
        fs::remove_file(&results)?;
    }
    let queue = Queue { folder, results: &results, n_jobs, patience: PATIENCE, seed: SEED };
    let cases = cases();
    queue.run(&cases)?;
    let records = record::read(&results)?;
    let broken: Vec<String> = records.iter().filter_map(broken).collect();
    ensure!(records.len() == cases.len(), "{} of {} trials ran", records.len(), cases.len());
    ensure!(broken.is_empty(), "broken verdicts:\n{}", broken.join("\n"));
    println!("{} trials, every verdict holds", records.len());
    Ok(())
}

/// What is wrong with an answer; none if it holds.
fn broken(record: &Record) -> Option<String> {
    let hidden: Vec<&str> = record.truth.iter().map(|effect| effect.id.as_str()).collect();
    (!is_right(record))
        .then(|| format!("{}: {:?}, told {}", record.case, hidden, record.outcome.text()))
}

#[cfg(test)]
mod tests {
    use super::super::record::{Outcome, Record};
    use super::super::score::tests::answer;
    use super::super::truth::{TrueEffect, Truth};
    use super::{PLAIN, broken, cases};

    fn told(named: &[&str]) -> Option<String> {
        let case = cases().into_iter().find(|case| case.about == PLAIN[0]).unwrap();
        let truth = TrueEffect { id: PLAIN[0].into(), values: [].into() };
        let truth = Truth { hidden: vec![truth], drawn: Vec::new() };
        let record = Record::failed(&case, String::new(), truth, 1.0);
        let outcome = Outcome::Answer(Box::new(answer(named, &[])));
        broken(&Record { outcome, ..record })
    }

    #[test]
    fn a_missed_and_a_wrong_name_break_the_slice() {
        assert_eq!(told(&[PLAIN[0]]), None);
        assert!(told(&[]).unwrap().contains("none found"));
        assert!(told(&[PLAIN[0], "edge-rounding"]).is_some());
        assert_eq!(cases().len(), 2 + 1 + PLAIN.len() + 1);
    }
}
