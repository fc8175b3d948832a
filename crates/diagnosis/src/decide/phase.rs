//! What a diagnosis is at, for those who wait for it.

use std::fmt;

/// What a diagnosis is at.
///
/// Phases come in the same order for any number of threads, all on the thread that asked. They say nothing of
/// the answer: an effect that is tried, or refitted, may be refused in the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DiagnosePhase {
    /// The noise is learnt beside the model so far.
    Noise,
    /// Every effect is tested by its score.
    Screening,
    /// An effect is fitted beside the model so far, as the `number`th `of` those worth it.
    Trying {
        /// Its id.
        effect: &'static str,
        /// From 1.
        number: usize,
        /// How many are tried.
        of: usize,
    },
    /// An effect that is as good as the best is brought to its minimum.
    Comparing {
        /// Its id.
        effect: &'static str,
        /// From 1.
        number: usize,
        /// How many are compared.
        of: usize,
    },
    /// All numbers are refitted with an effect, and pushes left out of the fit are asked.
    Refitting {
        /// Its id.
        effect: &'static str,
    },
    /// Nominal numbers are asked for, and every estimate gets its interval.
    Intervals,
    /// The held-out pushes are asked, without each of the effects in turn.
    Confirming {
        /// Its id.
        effect: &'static str,
        /// From 1.
        number: usize,
        /// How many there are.
        of: usize,
    },
    /// What is left over is searched for structure, and for what of the rig it comes from.
    Remains,
    /// What differs from push to push is measured.
    Scatter,
    /// Each other effect of a group is fitted in the place of the one that was added.
    Rivals,
}

impl fmt::Display for DiagnosePhase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Noise => f.write_str("learning the noise"),
            Self::Screening => f.write_str("screening all effects"),
            Self::Trying { effect, number, of } => write!(f, "trying {effect}, {number} of {of}"),
            Self::Comparing { effect, number, of } => {
                write!(f, "comparing {effect} with the best, {number} of {of}")
            }
            Self::Refitting { effect } => write!(f, "refitting all with {effect}"),
            Self::Intervals => f.write_str("asking for nominal numbers and intervals"),
            Self::Confirming { effect, number, of } => {
                write!(f, "asking held-out pushes about {effect}, {number} of {of}")
            }
            Self::Remains => f.write_str("looking at what remains"),
            Self::Scatter => f.write_str("measuring what differs from push to push"),
            Self::Rivals => f.write_str("fitting what else it could be"),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use rayon::ThreadPoolBuilder;

    use super::DiagnosePhase;
    use crate::synthetic::pushed_with;
    use crate::{DiagnoseSettings, diagnose, diagnose_with_progress};

    #[test]
    fn phases_are_told_in_one_order_and_change_nothing() {
        let (observations, model, _) = pushed_with(("friction-center-offset", &[0.01, 0.0]), 1);
        let settings = DiagnoseSettings::default();
        let on_threads = |n| {
            let pool = ThreadPoolBuilder::new().num_threads(n).build().unwrap();
            pool.install(|| {
                let told = RefCell::new(Vec::new());
                let tell = |phase| told.borrow_mut().push(phase);
                let found = diagnose_with_progress(&observations, &model, &settings, &tell);
                (found.unwrap().diagnosis, told.into_inner())
            })
        };
        let (found, told) = on_threads(1);
        assert_eq!((found.clone(), told.clone()), on_threads(3));
        assert_eq!(found, diagnose(&observations, &model, &settings).unwrap().diagnosis);
        assert_eq!(told[..2], [DiagnosePhase::Noise, DiagnosePhase::Screening]);
        let effect = "friction-center-offset";
        for phase in [
            DiagnosePhase::Refitting { effect },
            DiagnosePhase::Intervals,
            DiagnosePhase::Remains,
            DiagnosePhase::Scatter,
        ] {
            assert!(told.contains(&phase), "{phase}: {told:?}");
        }
        let mut counts = told.iter().filter_map(|phase| match phase {
            DiagnosePhase::Trying { number, of, .. }
            | DiagnosePhase::Comparing { number, of, .. }
            | DiagnosePhase::Confirming { number, of, .. } => Some((number, of)),
            _ => None,
        });
        assert!(counts.all(|(number, of)| (1..=*of).contains(number)), "{told:?}");
    }
}
