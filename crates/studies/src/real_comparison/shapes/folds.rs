//! Plain fits, and their errors on pushes that they have not seen.

use anyhow::{Result, bail};
use diagnosis::{FitSettings, NoiseModel, Observations, fit_with_noise};
use models::Description;

use super::{Error, errors};

const N_FOLDS: usize = 5;
/// What is fitted; nothing for the nominal model.
pub(super) const FREE: [&[&str]; 4] = [
    &[],
    &["pusher-friction"],
    &["pusher-friction", "pressure-radius"],
    &["pusher-friction", "pressure-radius", "friction-center-offset"],
];

/// The mean error of a fit on all pushes, each by a fit to those of the other folds.
pub(super) struct Fitted {
    pub(super) error: Error,
    /// Folds in which a fit failed, whose pushes are predicted by the model without it.
    pub(super) n_failed: usize,
}

/// Every fit, in the order of [`FREE`]; pushes are dealt to the folds in turn.
///
/// # Errors
/// A model that cannot predict the pushes.
pub(super) fn fitted(all: &Observations, nominal: &Description) -> Result<Vec<Fitted>> {
    let names: Vec<String> = all.pushes().iter().map(ToString::to_string).collect();
    let mut sums = [(Error::default(), 0, 0); FREE.len()];
    for fold in 0..N_FOLDS {
        let part = |is_in: bool| {
            let names = names.iter().enumerate().filter(|(k, _)| (k % N_FOLDS == fold) == is_in);
            all.part(&names.map(|(_, name)| name.clone()).collect::<Vec<_>>())
        };
        let (train, aside) = (part(false)?, part(true)?);
        let settings =
            FitSettings { intervals: false, resemblances: false, ..FitSettings::default() };
        let noise = NoiseModel::learn(nominal, &settings.own, &train);
        let fit = |free: &[&str]| match (&noise, free) {
            (_, []) => Ok(nominal.clone()),
            (Ok(noise), _) => {
                Ok(fit_with_noise(&train, nominal, free, noise, &settings)?.description)
            }
            (Err(error), _) => bail!("{error}"),
        };
        for (free, (sum, n, n_failed)) in FREE.iter().zip(&mut sums) {
            let found = fit(free);
            // That a fit fails is an outcome, too.
            *n_failed += usize::from(found.is_err());
            for error in errors(found.as_ref().unwrap_or(nominal), &aside)? {
                sum.position += error.position;
                sum.angle += error.angle;
                *n += 1;
            }
        }
    }
    Ok(sums.map(|(sum, n, n_failed)| Fitted { error: sum.over(n), n_failed }).into())
}
