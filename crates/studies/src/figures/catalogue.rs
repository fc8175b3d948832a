//! The one list of all figures.

use anyhow::Result;
use report::Claim;

use super::claims::untestable;
use super::inputs::Inputs;
use super::sketch::Sketch;
use super::{comparison, learning, mechanics, missing, models, motion, recordings};

/// A figure: its number in the thesis, its title and the function that draws it.
#[derive(Debug)]
pub(crate) struct Entry {
    pub(crate) id: &'static str,
    pub(crate) chapter: Chapter,
    pub(crate) title: &'static str,
    pub(crate) draw: fn(&Inputs) -> Result<Sketch>,
    /// The claims that it settles.
    pub(crate) claims: &'static [&'static str],
}

/// A chapter of the thesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Chapter {
    Mechanics,
    Learning,
    Recordings,
    Models,
    Motion,
    Comparison,
    Diagnosis,
}

impl Chapter {
    pub(crate) const ALL: [Self; 7] = [
        Self::Mechanics,
        Self::Learning,
        Self::Recordings,
        Self::Models,
        Self::Motion,
        Self::Comparison,
        Self::Diagnosis,
    ];

    /// Whether its figures are drawn from pushes.
    pub(crate) fn needs_data(self) -> bool {
        matches!(self, Self::Recordings | Self::Models | Self::Motion | Self::Comparison)
    }

    pub(crate) fn anchor(self) -> &'static str {
        match self {
            Self::Mechanics => "mechanics",
            Self::Learning => "learning",
            Self::Recordings => "recordings",
            Self::Models => "models",
            Self::Motion => "motion",
            Self::Comparison => "comparison",
            Self::Diagnosis => "diagnosis",
        }
    }

    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Mechanics => "Mechanics of pushing",
            Self::Learning => "Learning from data",
            Self::Recordings => "From recordings to a table",
            Self::Models => "Learned models of pushing",
            Self::Motion => "The motion over time",
            Self::Comparison => "Where a model fails",
            Self::Diagnosis => "What a model lacks",
        }
    }
}

const fn entry(
    id: &'static str,
    chapter: Chapter,
    title: &'static str,
    draw: fn(&Inputs) -> Result<Sketch>,
) -> Entry {
    Entry { id, chapter, title, draw, claims: &[] }
}

impl Entry {
    const fn settles(mut self, claims: &'static [&'static str]) -> Self {
        self.claims = claims;
        self
    }

    /// Its claims on data that lack something.
    pub(crate) fn untestable(&self, lacking: &str) -> Vec<Claim> {
        self.claims.iter().map(|claim| untestable(claim, lacking)).collect()
    }
}

/// All figures, in the order of the thesis.
pub(crate) const ALL: &[Entry] = &[
    entry("2.1", Chapter::Mechanics, "the friction cone", mechanics::friction_cone::draw),
    entry("2.2", Chapter::Mechanics, "a rigid body and its COR", mechanics::rigid_body::draw),
    entry("2.3", Chapter::Mechanics, "friction at pusher and support", mechanics::pressure::draw),
    entry("2.4", Chapter::Mechanics, "the motion cone", mechanics::motion_cone::draw),
    entry("2.5", Chapter::Mechanics, "limit curve", mechanics::limit_curve::draw),
    entry("2.6", Chapter::Mechanics, "a limit surface and its normals", mechanics::normals::draw),
    entry("2.7", Chapter::Mechanics, "one support point", mechanics::one_point::draw),
    entry("2.8", Chapter::Mechanics, "two and three support points", mechanics::few_points::draw),
    entry(
        "2.9",
        Chapter::Mechanics,
        "the ellipsoid beside the exact surface",
        mechanics::ellipsoid::draw,
    )
    .settles(&mechanics::ellipsoid::CLAIMS),
    entry("2.10", Chapter::Mechanics, "sticking and sliding", mechanics::stick_slide::draw),
    entry("2.11", Chapter::Mechanics, "the analytical push", mechanics::analytical::draw)
        .settles(&mechanics::analytical::CLAIMS),
    entry("3.1", Chapter::Learning, "functions from three priors", learning::prior::draw),
    entry("3.2", Chapter::Learning, "posterior and density of data", learning::posterior::draw),
    entry("4.3", Chapter::Recordings, "two recorded pushes", recordings::two_pushes::draw),
    entry("4.4", Chapter::Recordings, "force and contact", recordings::force_profile::draw)
        .settles(&recordings::force_profile::CLAIMS),
    entry("4.5", Chapter::Recordings, "notation of the inputs", recordings::inputs_notation::draw),
    entry(
        "4.6",
        Chapter::Recordings,
        "notation of the outputs",
        recordings::outputs_notation::draw,
    ),
    entry("4.7", Chapter::Recordings, "outputs over inputs", recordings::outputs::draw)
        .settles(&recordings::outputs::CLAIMS),
    entry("5.1", Chapter::Models, "noise of the sensors", recordings::noise::draw),
    entry("5.2", Chapter::Models, "the learned push", models::gp_maps::draw)
        .settles(&models::gp_maps::CLAIMS),
    entry("5.3", Chapter::Models, "error and time step", models::time_step::draw)
        .settles(&models::time_step::CLAIMS),
    entry("5.4", Chapter::Models, "error and pseudo-inputs", models::pseudo_inputs::draw)
        .settles(&models::pseudo_inputs::CLAIMS),
    entry("5.5", Chapter::Models, "error and random features", models::random_features::draw)
        .settles(&models::random_features::CLAIMS),
    entry("5.6", Chapter::Models, "speeds pooled and apart", models::pooled_speeds::draw)
        .settles(&models::pooled_speeds::CLAIMS),
    entry("5.7", Chapter::Models, "learning curves", models::learning_curves::draw)
        .settles(&models::learning_curves::CLAIMS),
    entry("6.1", Chapter::Motion, "particles on recorded pushes", motion::clouds::draw)
        .settles(&motion::clouds::CLAIMS),
    entry("6.2", Chapter::Motion, "errors at the end of a push", motion::errors::draw)
        .settles(&motion::errors::CLAIMS),
    entry("6.3", Chapter::Motion, "analytical and learnt roll-outs", motion::beside::draw),
    entry("6.4", Chapter::Motion, "new paths of the pusher", motion::new_paths::draw),
    entry("6.5", Chapter::Motion, "two ways to go at a vertex", motion::vertex::draw),
    entry(
        "M.1",
        Chapter::Comparison,
        "model against measurement, and where it fails",
        comparison::where_it_fails::draw,
    ),
    entry("M.2", Chapter::Diagnosis, "which effect is missing", missing::which_effect::draw),
    entry(
        "M.3",
        Chapter::Diagnosis,
        "the error falling as effects are added",
        missing::error_falls::draw,
    ),
    entry("M.4", Chapter::Motion, "what the uncertainty covers", motion::calibration::draw),
    entry("M.5", Chapter::Learning, "what is taken for noise", learning::known_noise::draw),
    entry("M.6", Chapter::Learning, "noise that changes", learning::changing_noise::draw),
    entry("M.7", Chapter::Models, "several shapes in one model", models::shapes::draw),
    entry("M.8", Chapter::Motion, "pushes without particles", motion::without_particles::draw),
    entry("M.9", Chapter::Motion, "repeats of a push at a vertex", motion::repeats::draw),
    entry("M.10", Chapter::Diagnosis, "a diagnosis at a glance", missing::at_a_glance::draw),
    entry("M.11", Chapter::Motion, "pushes followed by filters", motion::estimation::draw),
];
