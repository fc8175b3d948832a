//! What further pushes are to tell.

use crate::DiagnosisError;
use crate::decide::{Diagnosis, Grade};

/// What further pushes are to tell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Aim {
    /// Which one of each group is missing.
    Rivals(Vec<Vec<String>>),
    /// How large the effects are.
    Precision(Vec<String>),
    /// Whether an effect is there that the pushes so far could not show.
    Testable(Vec<String>),
}

impl Aim {
    /// What a diagnosis leaves open: its rivals, else the size of what it names, else of its hints.
    ///
    /// # Errors
    /// `NothingToSuggest` where it has none of them.
    pub fn of(found: &Diagnosis) -> Result<Self, DiagnosisError> {
        let groups: Vec<_> =
            found.ambiguous.iter().filter(|group| group.len() > 1).cloned().collect();
        if !groups.is_empty() {
            return Ok(Self::Rivals(groups));
        }
        if !found.identified.is_empty() {
            return Ok(Self::Precision(found.identified.clone()));
        }
        let hints = found.effects.iter().filter(|effect| effect.grade == Grade::Hint);
        let hints: Vec<String> = hints.map(|effect| effect.id.clone()).take(MOST_HINTS).collect();
        match hints.is_empty() {
            false => Ok(Self::Precision(hints)),
            true => Err(DiagnosisError::NothingToSuggest),
        }
    }

    /// The effects of each description that is to be fitted beside those known.
    pub(super) fn claims<'a>(&'a self, known: &[&'a str]) -> Vec<Vec<&'a str>> {
        let with = |others: &[&'a str]| {
            let others = others.iter().filter(|id| !known.contains(id));
            known.iter().chain(others).copied().collect::<Vec<_>>()
        };
        match self {
            Self::Rivals(groups) => {
                let first = |g: &'a Vec<String>| g[0].as_str();
                let firsts: Vec<&str> = groups.iter().map(first).collect();
                let member = |(k, id): (usize, &'a String)| {
                    let mut ids = firsts.clone();
                    ids[k] = id;
                    with(&ids)
                };
                let all = groups.iter().enumerate();
                all.flat_map(|(k, group)| group.iter().map(move |id| (k, id))).map(member).collect()
            }
            Self::Precision(ids) => vec![with(&ids.iter().map(String::as_str).collect::<Vec<_>>())],
            Self::Testable(_) => vec![known.to_vec()],
        }
    }

    /// Places in [`Aim::claims`] of each pair of rivals, with their ids.
    pub(super) fn pairs(&self) -> Vec<([usize; 2], [&str; 2])> {
        let Self::Rivals(groups) = self else { return Vec::new() };
        let mut first = 0;
        let mut pairs = Vec::new();
        for group in groups {
            for one in 0..group.len() {
                for other in one + 1..group.len() {
                    let names = [group[one].as_str(), group[other].as_str()];
                    pairs.push(([first + one, first + other], names));
                }
            }
            first += group.len();
        }
        pairs
    }
}

/// Hints whose sizes are made certain together.
const MOST_HINTS: usize = 3;
