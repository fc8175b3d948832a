//! What an effect must fulfil to be claimed.

use std::fmt;

use crate::cut_offs::{HINT, LARGE, LATER_SHARE, NAME, SIZE, TOLERANCES};
use crate::{
    DiagnosisError, EffectFit, Fit, Gain, Observations, Screen, ScreenedEffect, Undetermined,
};

/// Rules for an effect that explains more than those before it.
pub(super) struct Rules {
    /// Fall of the sum of squares by the effects before.
    pub(super) gain_so_far: f64,
    pub(super) is_first: bool,
}

/// What speaks against naming an effect.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Objection {
    NotSure { p: f64 },
    Small { size: f64 },
    LittleMore { share: f64 },
    Undetermined { why: String },
    WithinTolerance { parameter: &'static str },
    MeanFriction,
    RightBeside { rival: &'static str },
    NotPredictive { gain: Gain },
    OneCluster { cluster: String },
    NotConfirmed { gain: Gain },
    Superfluous,
    Unsettled { why: String },
}

impl Objection {
    /// Whether the effect may be missing none the less: not one that is seen and does not matter, nor
    /// one that a fit takes for chance or that held-out pushes do not miss.
    pub(super) fn is_hint(&self) -> bool {
        match self {
            Self::Small { .. }
            | Self::LittleMore { .. }
            | Self::WithinTolerance { .. }
            | Self::Superfluous
            | Self::MeanFriction => false,
            Self::NotSure { p } => *p <= HINT,
            Self::NotConfirmed { gain } | Self::NotPredictive { gain } => gain.mean >= gain.se,
            Self::OneCluster { .. }
            | Self::RightBeside { .. }
            | Self::Undetermined { .. }
            | Self::Unsettled { .. } => true,
        }
    }
}

impl From<DiagnosisError> for Objection {
    /// What speaks against an effect whose fit ends with an error.
    fn from(why: DiagnosisError) -> Self {
        match why {
            DiagnosisError::OneCluster { cluster, .. } => Self::OneCluster { cluster },
            why => Self::Unsettled { why: why.to_string() },
        }
    }
}

impl Rules {
    /// What speaks against an effect by its size alone.
    pub(super) fn objection(&self, p: f64, gain: f64, size: f64) -> Option<Objection> {
        let share = gain / self.gain_so_far;
        if size < SIZE {
            Some(Objection::Small { size })
        } else if p > NAME {
            Some(Objection::NotSure { p })
        } else if !self.is_first && share < LATER_SHARE && size < LARGE {
            Some(Objection::LittleMore { share })
        } else {
            None
        }
    }

    /// What speaks against an effect by its estimate.
    ///
    /// That another effect looks like it does not: the two are rivals. `tolerance` is the standard error
    /// with which it is a nuisance.
    pub(super) fn objection_to(fit: &Fit, id: &str, tolerance: Option<f64>) -> Option<Objection> {
        let effect = fit.effects.iter().find(|effect| effect.id == id)?;
        match &effect.undetermined {
            None | Some(Undetermined::LooksLike { .. }) => {}
            Some(why) => return Some(Objection::Undetermined { why: why.to_string() }),
        }
        if effect.p > NAME {
            return Some(Objection::NotSure { p: effect.p });
        }
        let tolerance = tolerance.filter(|tolerance| tolerance.is_finite())?;
        let is_within = |parameter: &&crate::ParameterFit| {
            let off = parameter.off.unwrap_or_default();
            (parameter.value - off).abs() <= TOLERANCES * (tolerance + parameter.se)
        };
        let mut within = effect.parameters.iter().filter(is_within);
        let n_within = within.clone().count();
        let first = within.next().filter(|_| n_within == effect.parameters.len());
        first.map(|parameter| Objection::WithinTolerance { parameter: parameter.name })
    }

    /// What speaks against an effect by what it predicts of clusters that are left out of the fit:
    /// the simpler model stays where it is within a standard error. Of each push's part of the sum in
    /// the simpler model and in the other one, where all clusters can be left out.
    pub(super) fn objection_to_gain(
        observations: &Observations,
        left_out: [Result<Vec<f64>, DiagnosisError>; 2],
    ) -> Option<Objection> {
        let (without, with) = match left_out {
            [Ok(without), Ok(with)] => (without, with),
            [Err(why), _] | [_, Err(why)] => return Some(why.into()),
        };
        let gain = Gain::of(&Self::gains(observations, &[without, with]));
        (!gain.is_sure()).then_some(Objection::NotPredictive { gain })
    }

    /// The gain of each cluster, in nats, from its pushes' parts of the sums of two models.
    pub(super) fn gains(observations: &Observations, [without, with]: &[Vec<f64>; 2]) -> Vec<f64> {
        let of_push = |push: &usize| 0.5 * (without[*push] - with[*push]);
        let clusters = observations.pushes_of_clusters().into_iter();
        clusters.map(|pushes| pushes.iter().map(of_push).sum()).collect()
    }
}

impl fmt::Display for Objection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotSure { p } => write!(f, "it may be chance (p {p:.3})"),
            Self::Small { size } => {
                write!(f, "it changes what is predicted by {size:.2} of the noise alone")
            }
            Self::LittleMore { share } if *share <= 0.0 => {
                f.write_str("it adds nothing to what is explained before it")
            }
            Self::LittleMore { share } => {
                let percent = 100.0 * share;
                write!(f, "it adds {percent:.1} % to what is explained before it")
            }
            Self::Undetermined { why } => f.write_str(why),
            Self::WithinTolerance { parameter } => {
                write!(f, "{parameter} is within what the manifest leaves open")
            }
            Self::MeanFriction => f.write_str(
                "it is between friction along the grain and across, either of which may be nominal",
            ),
            Self::RightBeside { rival } => {
                write!(f, "its nominal value is right if {rival} is the one of its group")
            }
            Self::NotPredictive { gain } => {
                let Gain { mean, se } = gain;
                write!(f, "pushes left out of the fit gain {mean:.1} ± {se:.1} nats alone")
            }
            Self::OneCluster { cluster } => {
                write!(f, "it rests on {cluster} alone: without that its fit leaves a number open")
            }
            Self::Superfluous => f.write_str("a later effect explains what it explained"),
            Self::Unsettled { why } => write!(f, "its fit does not settle: {why}"),
            Self::NotConfirmed { gain } => {
                let Gain { mean, se } = gain;
                write!(f, "pushes that no fit has seen gain {mean:.1} ± {se:.1} nats alone")
            }
        }
    }
}

/// Probability of an estimate as far off, of any effect asked for: no flips tell it, for every screen
/// leaves nominal numbers open, so it is that of the estimate alone times their number (Bonferroni).
pub(super) fn p_of_number(effect: &EffectFit, screen: &Screen) -> f64 {
    let is_other = |one: &&ScreenedEffect| one.not_testable.is_none() && one.id != effect.id;
    let n_others = screen.effects.iter().filter(is_other).count();
    (effect.p * (1 + n_others) as f64).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::{Objection, Rules, p_of_number};
    use crate::predict::tangent::Tangent;
    use crate::screen::screen_at;
    use crate::synthetic::{recorded, white};
    use crate::{DiagnosisError, EffectFit, Gain, ScreenSettings};

    #[test]
    fn a_name_is_sure_large_and_no_small_share() {
        let first = Rules { gain_so_far: 0.0, is_first: true };
        assert_eq!(first.objection(0.005, 40.0, 0.5), None);
        assert_eq!(first.objection(0.02, 40.0, 0.5), Some(Objection::NotSure { p: 0.02 }));
        // What does not matter is no hint, however sure or unsure it is.
        assert_eq!(first.objection(0.005, 40.0, 0.2), Some(Objection::Small { size: 0.2 }));
        assert_eq!(first.objection(0.02, 40.0, 0.2), Some(Objection::Small { size: 0.2 }));
        let later = Rules { gain_so_far: 1000.0, is_first: false };
        assert!(matches!(later.objection(0.005, 5.0, 0.5), Some(Objection::LittleMore { .. })));
        let less = later.objection(0.005, -5.0, 0.5).unwrap().to_string();
        assert!(less.starts_with("it adds nothing"), "{less}");
        // What is large needs no share, and a share needs no more than its size.
        assert_eq!(later.objection(0.005, 5.0, 0.8), None);
        assert_eq!(later.objection(0.005, 20.0, 0.5), None);
    }

    #[test]
    fn what_rests_on_one_cluster_alone_is_told() {
        let observations = recorded(1).0;
        let parts = |each: f64| Ok(vec![each; observations.pushes().len()]);
        let objection = |parts| Rules::objection_to_gain(&observations, parts);
        assert_eq!(objection([parts(8.0), parts(2.0)]), None);
        assert!(matches!(
            objection([parts(2.0), parts(2.5)]),
            Some(Objection::NotPredictive { .. })
        ));
        let alone = || {
            let cluster = observations.name_of_cluster(3);
            Err(DiagnosisError::OneCluster { cluster, pushes: Vec::new() })
        };
        for parts in [[alone(), parts(2.0)], [parts(8.0), alone()], [alone(), alone()]] {
            let found = objection(parts).unwrap();
            let told = format!("it rests on push {} alone", observations.pushes()[3]);
            assert!(found.is_hint() && found.to_string().starts_with(&told), "{found}");
        }
        let sessions = recorded(15).0;
        let name = sessions.name_of_cluster(3);
        assert!(name.starts_with("the session of push "), "{name}");
    }

    #[test]
    fn what_is_seen_and_does_not_matter_is_no_hint() {
        assert!(!Objection::Small { size: 0.1 }.is_hint());
        assert!(!Objection::Superfluous.is_hint());
        assert!(Objection::NotSure { p: 0.02 }.is_hint());
        assert!(!Objection::NotSure { p: 0.08 }.is_hint());
        let not_confirmed = |mean, se| Objection::NotConfirmed { gain: Gain { mean, se } };
        assert!(not_confirmed(18.0, 8.0).is_hint() && !not_confirmed(-7.0, 6.0).is_hint());
    }

    #[test]
    fn the_probability_of_a_nominal_number_counts_all_effects_asked_for() {
        let (observations, model) = recorded(1);
        let tangent = Tangent::of(&model, &[], &observations).unwrap();
        let settings = ScreenSettings { n_flips: 9, ..ScreenSettings::default() };
        let screen = screen_at(&tangent, &observations, &white(&observations), &settings);
        let tested = screen.effects.iter().filter(|effect| effect.not_testable.is_none());
        let n_tested = tested.count() as f64;
        assert!(n_tested > 15.0 && n_tested < screen.effects.len() as f64 + 0.5, "{n_tested}");
        let found = |p: f64| EffectFit {
            id: "pusher-friction",
            parameters: Vec::new(),
            follows: Vec::new(),
            p,
            resemblances: Vec::new(),
            undetermined: None,
        };
        let adjusted = |p: f64| p_of_number(&found(p), &screen);
        assert!((adjusted(1e-4) - 1e-4 * n_tested).abs() < 1e-15);
        assert_eq!(adjusted(0.2), 1.0);
        // One that the model carries is not in the screen, and still a test.
        let mut carried = screen.clone();
        carried.effects.retain(|effect| effect.id != "pusher-friction");
        assert_eq!(p_of_number(&found(1e-4), &carried), adjusted(1e-4));
    }
}
