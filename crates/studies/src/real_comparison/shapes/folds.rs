//! Plain fits, and their errors on pushes that they have not seen.

use anyhow::Result;
use diagnosis::{Observations, SupportPointsFit};
use models::Description;

use super::pushes::{Error, errors};
use crate::real_comparison::plain_fit::fit;

const N_FOLDS: usize = 2;
/// What is fitted, each with the start that an earlier one of them gives; nothing for the nominal model.
const FREE: [(&[&str], usize); 5] = [
    (&[], 0),
    (&["pusher-friction"], 0),
    (&["pusher-friction", "pressure-radius"], 0),
    // Friction that was fitted beside a wrong support may lead to wrong points.
    (&["pusher-friction", "support-points"], 0),
    (&["pusher-friction", "support-points", "approach-gap"], 3),
];
/// Those, and the last with its nuisances.
pub(super) const N_MODELS: usize = FREE.len() + 1;

/// The mean error of a fit on all pushes, each by a fit to those of the other folds.
pub(super) struct Fitted {
    pub(super) error: Error,
    /// Folds in which a fit failed, whose pushes are predicted by the model without it.
    pub(super) n_failed: usize,
}

/// Sums over pushes and folds.
#[derive(Clone, Copy, Default)]
struct Sum {
    error: Error,
    n: usize,
    n_failed: usize,
}

/// Every model in its order, and the last one of each fold without nuisances.
///
/// # Errors
/// A model that cannot predict the pushes.
pub(super) fn of_folds(
    all: &Observations,
    nominal: &Description,
) -> Result<(Vec<Fitted>, Vec<Description>)> {
    let mut sums = [Sum::default(); N_MODELS];
    let mut last = Vec::new();
    for (train, aside) in folds(all)? {
        let mut models: Vec<Description> = Vec::new();
        let mut whole = nominal.clone();
        for ((free, from), sum) in FREE.iter().zip(&mut sums) {
            let mut found = models.get(*from).unwrap_or(nominal).clone();
            if !free.is_empty() {
                // That a fit fails is an outcome, too.
                match fit(&train, found.clone(), free, SupportPointsFit::default()) {
                    Ok(fit) => (found, whole) = (fit.description, fit.with_nuisances),
                    Err(_) => sum.n_failed += 1,
                }
            }
            sum.add(&errors(&found, &aside)?);
            models.push(found);
        }
        sums[N_MODELS - 1].add(&errors(&whole, &aside)?);
        sums[N_MODELS - 1].n_failed = sums[N_MODELS - 2].n_failed;
        last.extend(models.pop());
    }
    let fitted = sums.map(|sum| Fitted { error: sum.error.over(sum.n), n_failed: sum.n_failed });
    Ok((fitted.into_iter().collect(), last))
}

/// The pushes that a fit has and those that it has not seen, fold by fold; they are dealt in turn.
///
/// # Errors
/// Too few pushes for so many folds.
pub(super) fn folds(all: &Observations) -> Result<Vec<(Observations, Observations)>> {
    let names: Vec<String> = all.pushes().iter().map(ToString::to_string).collect();
    let fold = |fold: usize| {
        let part = |is_in: bool| {
            let names = names.iter().enumerate().filter(|(k, _)| (k % N_FOLDS == fold) == is_in);
            all.part(&names.map(|(_, name)| name.clone()).collect::<Vec<_>>())
        };
        Ok((part(false)?, part(true)?))
    };
    (0..N_FOLDS).map(fold).collect()
}

impl Sum {
    fn add(&mut self, errors: &[Error]) {
        for error in errors {
            self.error.position += error.position;
            self.error.angle += error.angle;
            self.n += 1;
        }
    }
}
