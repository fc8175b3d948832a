//! A model, observed steps and their noise go in, a test of every effect that the model lacks comes
//! out, before any of them is fitted.

pub(crate) mod screened;
pub(crate) mod untestable;
pub(crate) mod whitened;

use std::sync::Arc;

use effects::Effect;
use models::Description;

use crate::data::thinning::thinned;
use crate::predict::tangent::Tangent;
use crate::screen::whitened::Whitened;
use crate::{DiagnosisError, NoiseModel, Observations, Screen, ScreenSettings, Whitening};

/// Tests every effect that an analytical model does not have; `own` are effects besides those of
/// the catalogue.
///
/// # Errors
/// `Model` for what the model refuses; `NotACovariance`.
pub fn screen(
    model: &Description,
    own: &[Arc<dyn Effect>],
    observations: &Observations,
    noise: &NoiseModel,
    settings: &ScreenSettings,
) -> Result<Screen, DiagnosisError> {
    let n_pushes_in_all = observations.pushes().len();
    let observations = &*thinned(observations, settings.most_steps)?;
    let tangent = Tangent::of(model, own, observations)?;
    let whitening = noise.whitening_at(observations, &tangent.linearisation)?;
    let found = screen_at(&tangent, observations, &whitening, settings);
    Ok(Screen { n_pushes_in_all, ..found })
}

/// The same with slopes that are known, of all observations.
pub(crate) fn screen_at(
    tangent: &Tangent,
    observations: &Observations,
    whitening: &Whitening,
    settings: &ScreenSettings,
) -> Screen {
    Whitened::new(observations, tangent, whitening, settings).screen()
}

#[cfg(test)]
mod tests {
    use models::Cluster;

    use super::{Screen, ScreenSettings, screen_at};
    use crate::split;
    use crate::synthetic::{SessionErrors, recorded, white};

    /// What differs from session to session, and by what standard deviation in its unit.
    const SESSIONS: [(&str, f64); 7] = [
        ("friction-center-offset", 2e-3),
        ("contact-bias", 1e-3),
        ("table-tilt", 0.05),
        ("table-anisotropy", 0.03),
        ("body-anisotropy", 0.03),
        ("limit-surface-shape", 0.3),
        ("force-bias", 0.1),
    ];
    const N_SESSIONS: u32 = 15;

    /// The part to fit to of pushes that were recorded in fifteen sessions.
    fn sessions() -> SessionErrors {
        let (all, model) = recorded(N_SESSIONS);
        let fitted = all.part(&split(&all, 7).unwrap().fit).unwrap();
        SessionErrors::of((fitted, model), &SESSIONS)
    }

    /// The screen of a set in which nothing is missing but what differs from session to session;
    /// `lasting` is what all sessions have of it, in its standard deviations.
    fn screened(sessions: &SessionErrors, seed: u64, lasting: f64) -> Screen {
        let settings = ScreenSettings { n_flips: 999, seed, ..ScreenSettings::default() };
        let whitening = white(&sessions.observations);
        screen_at(&sessions.tangent, &sessions.observed(seed, lasting), &whitening, &settings)
    }

    /// Sets in which some effect has an adjusted probability of at most 0.05.
    fn alarms(sessions: &SessionErrors, n_sets: u64, lasting: f64) -> usize {
        let is_alarm = |seed: &u64| {
            let found = screened(sessions, *seed, lasting);
            found.effects.iter().any(|effect| effect.p_adjusted <= 0.05)
        };
        (0..n_sets).filter(is_alarm).count()
    }

    #[test]
    fn what_differs_from_session_to_session_is_no_effect() {
        let sessions = sessions();
        let calibration = screened(&sessions, 0, 0.0).calibration;
        assert_eq!((calibration.cluster, calibration.n_clusters), (Cluster::Session, 11));
        // 95 % of binomial counts of 80 draws at 0.05 are at most 7.
        let n = alarms(&sessions, 80, 0.0);
        assert!(n <= 7, "{n} of 80 where at most 4 are expected");
        let n = alarms(&sessions, 10, 3.0);
        assert!(n >= 8, "{n} of 10 that all sessions share");
    }
}
