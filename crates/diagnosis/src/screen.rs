//! Which effects would lower the error, before any of them is fitted.

use effects::Effect;
use models::{Cluster, Description};
use serde::Serialize;

use crate::tangent::Tangent;
use crate::thinning::thinned;
use crate::whitened::Whitened;
use crate::{DiagnosisError, NoiseModel, NotTestable, Observations, Tolerances, Whitening};

/// What a screen of effects found, the likeliest effect first.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Screen {
    /// Pushes of the set; a larger set than is needed is thinned.
    pub n_pushes_in_all: usize,
    /// Pushes used.
    pub n_pushes: usize,
    /// Steps used.
    pub n_steps: usize,
    /// Numbers used.
    pub n_numbers: usize,
    /// Root mean square of the whitened residual of each number of a step, nuisances fitted: 1
    /// where noise is all; none for what is not observed.
    pub whitened_rms: [Option<f64>; 7],
    /// Correlation of the same in consecutive steps of a push: 0 where the noise model is true.
    pub step_correlation: [Option<f64>; 7],
    /// How probabilities were found.
    pub calibration: Calibration,
    /// The nuisances as they would be fitted if nothing else were there.
    pub nuisances: Vec<Nuisance>,
    /// Every effect that the model does not have.
    pub effects: Vec<ScreenedEffect>,
    /// Pairs of effects that these data hardly tell apart, the most alike first.
    pub look_alikes: Vec<LookAlikes>,
}

/// How probabilities were found: by flipping the signs of whole clusters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Calibration {
    /// What flips as a whole.
    pub cluster: Cluster,
    /// How many there are.
    pub n_clusters: usize,
    /// Flips used.
    pub n_flips: usize,
    /// Effects that are tested together.
    pub n_tests: usize,
    /// The adjusted probability that an effect which every cluster shows is sure to get: each other
    /// test, too, has a flip that makes it as surprising as any can be.
    pub smallest_p: f64,
    /// Clusters that are missing for that to be 0.01.
    pub clusters_missing: usize,
}

/// A nominal value that every test takes as uncertain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Nuisance {
    /// Id of its effect.
    pub effect: &'static str,
    /// Its coordinate.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Standard error beforehand; none where nothing is known.
    pub tolerance: Option<f64>,
    /// One-step estimate of its change.
    pub change: f64,
}

/// The test of one effect.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScreenedEffect {
    /// Its id.
    pub id: &'static str,
    /// Why these data cannot show it, where that is so.
    pub not_testable: Option<NotTestable>,
    /// Twice the gain in log likelihood that one step would expect: the score statistic
    /// T = Uᵀ I⁻¹ U, less where the step would leave the parameters' range.
    pub statistic: f64,
    /// Degrees of freedom of T.
    pub freedom: usize,
    /// Probability of so large a statistic, were every cluster as likely of the other sign.
    pub p: f64,
    /// The same of any effect at least as surprising.
    pub p_adjusted: f64,
    /// Its coordinates.
    pub coordinates: Vec<ScreenedCoordinate>,
}

/// A coordinate of an effect: a parameter, or for a ratio along a direction φ one of
/// (e cos 2φ, e sin 2φ) with e = ½ ln ratio.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ScreenedCoordinate {
    /// Name.
    pub name: &'static str,
    /// SI unit; `1` for numbers without one.
    pub unit: &'static str,
    /// Change from its value in the model, by one step of generalised least squares.
    pub change: f64,
    /// Standard error of the change: by the noise model, or by the scatter over the clusters where
    /// that is larger.
    pub se: f64,
    /// Size that is found with probability 0.9 at an adjusted p of 0.01, were it the only one of
    /// the effect's coordinates.
    pub smallest_detectable: f64,
}

/// Two effects that look alike in these data.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LookAlikes {
    /// One effect.
    pub one: &'static str,
    /// The other.
    pub other: &'static str,
    /// Largest correlation of what they do to the observed numbers, beyond the nuisances.
    pub correlation: f64,
}

/// How a screen is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenSettings {
    /// How exactly nominal values are known.
    pub tolerances: Tolerances,
    /// Random flips of signs: with k tests p can hardly be adjusted to less than k/(1 + n).
    pub n_flips: usize,
    /// Seed of the flips.
    pub seed: u64,
    /// Steps above which a part of the pushes is used, chosen evenly over edges and speeds.
    pub most_steps: usize,
    /// Correlation from which two effects count as look-alikes.
    pub alike: f64,
}

impl Default for ScreenSettings {
    fn default() -> Self {
        Self {
            tolerances: Tolerances::default(),
            n_flips: 9999,
            seed: 7,
            most_steps: 20_000,
            alike: 0.9,
        }
    }
}

/// Noncentrality √δ at which a test of so many degrees at 0.01/23 is passed with probability 0.9.
pub(crate) const DETECTABLE: [f64; 3] = [4.80, 5.10, 5.32];

/// Tests every effect that an analytical model does not have; `own` are effects besides those of
/// the catalogue.
///
/// # Errors
/// `Model` for what the model refuses; `NotACovariance`.
pub fn screen(
    model: &Description,
    own: &[&'static dyn Effect],
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
