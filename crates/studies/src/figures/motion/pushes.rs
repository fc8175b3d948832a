//! The pushes of the data, split so that each question meets pushes that nothing has seen.

use models::{RecordedPush, StepObservation};

/// More pushes than this are split once; fewer take turns.
const TURNS_BELOW: usize = 100;
const N_TURNS: usize = 4;
/// Most pushes that are tested in all.
const MOST_TESTED: usize = 100;

/// How often the pushes to learn from are split, to measure on what a part has not seen.
const N_FOLDS: usize = 5;

/// Pushes to learn from, and to be tested on.
pub(crate) struct Turn<'a> {
    pub(crate) learn: Vec<&'a RecordedPush>,
    pub(crate) test: Vec<&'a RecordedPush>,
}

/// The pushes to learn from without some of them, and those.
pub(crate) struct Fold<'a> {
    pub(crate) learn: Vec<&'a RecordedPush>,
    pub(crate) left_out: Vec<&'a RecordedPush>,
}

impl<'a> Turn<'a> {
    /// Each push to learn from is left out once.
    pub(crate) fn folds(&self) -> [Fold<'a>; N_FOLDS] {
        std::array::from_fn(|fold| {
            let part = |is_left_out: bool| {
                let all = self.learn.iter().enumerate();
                all.filter(|(k, _)| (k % N_FOLDS == fold) == is_left_out)
                    .map(|(_, push)| *push)
                    .collect()
            };
            Fold { learn: part(false), left_out: part(true) }
        })
    }
}

/// Three quarters to learn from, a quarter to test; few pushes take turns, so that each is tested once.
pub(crate) fn turns(pushes: &[RecordedPush]) -> Vec<Turn<'_>> {
    let n = pushes.len();
    let n_turns = if n < TURNS_BELOW { N_TURNS } else { 1 };
    let quarter = |k: usize| (k % N_TURNS * n / N_TURNS)..((k % N_TURNS + 1) * n / N_TURNS);
    let part = |k: usize| pushes[quarter(k)].iter();
    let most = MOST_TESTED.div_ceil(n_turns);
    let turn = |k: usize| Turn {
        learn: part(k + 1).chain(part(k + 2)).chain(part(k + 3)).collect(),
        test: part(k).take(most).collect(),
    };
    (0..n_turns).map(turn).collect()
}

/// The steps of some pushes.
pub(crate) fn steps_of(pushes: &[&RecordedPush]) -> Vec<StepObservation> {
    pushes.iter().flat_map(|push| push.steps.iter().cloned()).collect()
}
