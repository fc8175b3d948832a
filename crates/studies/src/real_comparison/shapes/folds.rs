//! Plain fits, and their errors on pushes that they have not seen.

use anyhow::Result;
use diagnosis::Observations;
use models::Description;

use super::pushes::{Error, errors};
use crate::real_comparison::plain_fit::fitted;

const N_FOLDS: usize = 2;
/// What is fitted, each with the start that an earlier one of them gives; nothing for the nominal model.
pub(super) const FREE: [(&[&str], usize); 5] = [
    (&[], 0),
    (&["pusher-friction"], 0),
    (&["pusher-friction", "pressure-radius"], 0),
    (&["pusher-friction", "support-points"], 1),
    (&["pusher-friction", "support-points", "approach-gap"], 3),
];

/// The mean error of a fit on all pushes, each by a fit to those of the other folds.
pub(super) struct Fitted {
    pub(super) error: Error,
    /// Folds in which a fit failed, whose pushes are predicted by the model without it.
    pub(super) n_failed: usize,
}

/// Every fit, in the order of [`FREE`], and the last model of each fold; pushes are dealt to the folds in
/// turn.
///
/// # Errors
/// A model that cannot predict the pushes.
pub(super) fn of_folds(
    all: &Observations,
    nominal: &Description,
) -> Result<(Vec<Fitted>, Vec<Description>)> {
    let names: Vec<String> = all.pushes().iter().map(ToString::to_string).collect();
    let mut sums = [(Error::default(), 0, 0); FREE.len()];
    let mut last = Vec::new();
    for fold in 0..N_FOLDS {
        let part = |is_in: bool| {
            let names = names.iter().enumerate().filter(|(k, _)| (k % N_FOLDS == fold) == is_in);
            all.part(&names.map(|(_, name)| name.clone()).collect::<Vec<_>>())
        };
        let (train, aside) = (part(false)?, part(true)?);
        let mut models: Vec<Description> = Vec::new();
        for ((free, from), (sum, n, n_failed)) in FREE.iter().zip(&mut sums) {
            let start = models.get(*from).unwrap_or(nominal);
            let found = match free {
                [] => Ok(nominal.clone()),
                _ => fitted(&train, start.clone(), free),
            };
            // That a fit fails is an outcome, too.
            *n_failed += usize::from(found.is_err());
            let found = found.unwrap_or_else(|_| start.clone());
            for error in errors(&found, &aside)? {
                sum.position += error.position;
                sum.angle += error.angle;
                *n += 1;
            }
            models.push(found);
        }
        last.extend(models.pop());
    }
    let fitted = sums.map(|(sum, n, n_failed)| Fitted { error: sum.over(n), n_failed }).into_iter();
    Ok((fitted.collect(), last))
}
