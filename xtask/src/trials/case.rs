//! One trial: what is hidden, how it is pushed, and which answers are right.

use models::SurfaceKind;
use plant::{Design, GenerateSettings, Layout};

/// A kind of trial, with a row of its own in the table of pass marks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Family {
    /// Nothing hidden, and a base that is right.
    Nothing,
    /// Nothing hidden, and the thesis' ellipsoid on a patch.
    Ellipsoid,
    /// One effect of the catalogue.
    Single,
    /// Two of them.
    Pair,
    /// An effect that no catalogue has.
    Outside,
    /// One edge, one orientation, one speed.
    Narrow,
    /// An effect that the sensors cannot show.
    Untestable,
    /// A nominal friction of the pusher that is a fifth too small.
    WrongNominal,
}

impl Family {
    pub(super) const ALL: [Self; 8] = [
        Self::Nothing,
        Self::Ellipsoid,
        Self::Single,
        Self::Pair,
        Self::Outside,
        Self::Narrow,
        Self::Untestable,
        Self::WrongNominal,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Nothing => "nothing",
            Self::Ellipsoid => "ellipsoid",
            Self::Single => "single",
            Self::Pair => "pair",
            Self::Outside => "outside",
            Self::Narrow => "narrow",
            Self::Untestable => "untestable",
            Self::WrongNominal => "wrong-nominal",
        }
    }
}

/// One trial.
#[derive(Clone, Debug)]
pub(super) struct Case {
    /// Unique, and the same in every run.
    pub(super) name: String,
    pub(super) family: Family,
    /// Surface of the model that is asked about.
    pub(super) surface: SurfaceKind,
    /// Effects as `plant` takes them.
    pub(super) hidden: Vec<String>,
    pub(super) settings: GenerateSettings,
    /// Whether the recordings have a force sensor.
    pub(super) has_force: bool,
}

/// Trials that are reported use seeds from here on; below are those of development.
pub(super) const FIRST_SEED: u64 = 1_000_000;
