//! The pushes of the data, split so that each question meets pushes that nothing has seen.

use anyhow::Result;
use dataset::{ObjectChoice, Table};
use models::{RecordedPush, StepObservation, StepSelection};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use crate::figures::inputs::{Inputs, SEED};

/// Fewer pushes cannot be split.
const FEWEST: usize = 16;
/// Pushes with fewer steps have no way to go.
const FEWEST_STEPS: usize = 3;
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

/// The pushes of the first object, in a random order.
///
/// # Errors
/// [`super::super::inputs::Lacking`] for a table of single steps, or too few pushes.
pub(crate) fn pushes(inputs: &Inputs) -> Result<Vec<RecordedPush>> {
    let (table, pusher) = (inputs.table()?, inputs.pusher()?);
    let too_few = || inputs.lacking("16 whole pushes of one object");
    let first = table.rows.first().ok_or_else(too_few)?;
    let objects = ObjectChoice::Fixed(Box::new(inputs.object(&first.recording)?));
    let rows = table.rows.iter().filter(|row| row.shape == first.shape).cloned().collect();
    let table = Table { rows, provenance: table.provenance.clone() };
    let mut pushes = StepSelection::default().pushes(&table, &objects, pusher.radius)?;
    pushes.retain(|push| push.steps.len() >= FEWEST_STEPS);
    if pushes.len() < FEWEST {
        return Err(too_few());
    }
    pushes.shuffle(&mut ChaCha8Rng::seed_from_u64(SEED));
    Ok(pushes)
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
