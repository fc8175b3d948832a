//! What was told of what was hidden.

use std::collections::BTreeMap;

use diagnosis::Verdict;

use super::case::Family;
use super::record::{Outcome, Record};

/// How often each answer was given, the most frequent first, for each hidden effect.
pub(super) fn confusion(records: &[Record]) -> BTreeMap<String, Vec<(String, usize)>> {
    let mut counts: BTreeMap<String, BTreeMap<String, usize>> = BTreeMap::new();
    for record in records.iter().filter(|record| is_clear(record)) {
        let hidden = match (record.about.is_empty(), record.has_ellipsoid()) {
            (true, false) => "nothing".to_owned(),
            (true, true) => "nothing, on an ellipsoid".to_owned(),
            (false, false) => record.about.clone(),
            (false, true) => format!("{}, on an ellipsoid", record.about),
        };
        *counts.entry(hidden).or_default().entry(told(record)).or_default() += 1;
    }
    let ordered = |(hidden, answers): (String, BTreeMap<String, usize>)| {
        let mut answers: Vec<_> = answers.into_iter().collect();
        answers.sort_by_key(|(_, n)| std::cmp::Reverse(*n));
        (hidden, answers)
    };
    counts.into_iter().map(ordered).collect()
}

/// Effects as large as they should be named, and none.
fn is_clear(record: &Record) -> bool {
    match record.family {
        Family::Single => record.multiple.is_some_and(|multiple| multiple >= 2.0),
        Family::Nothing | Family::Ellipsoid | Family::Typical | Family::Outside => true,
        _ => false,
    }
}

/// An answer in a few words.
fn told(record: &Record) -> String {
    let answer = match &record.outcome {
        Outcome::Failed(_) => return "failed".to_owned(),
        Outcome::Answer(answer) => answer,
    };
    let groups = answer.ambiguous.iter().map(|group| group.join(" or "));
    let claims: Vec<String> = answer.identified.iter().cloned().chain(groups).collect();
    match answer.verdict {
        Verdict::Identified | Verdict::Ambiguous => claims.join(" + "),
        Verdict::Effective => format!("effective: {}", answer.effective.join(" + ")),
        Verdict::Unexplained => "unexplained".to_owned(),
        Verdict::NoneFound => "none found".to_owned(),
        Verdict::Inconclusive => "inconclusive".to_owned(),
    }
}
