//! The one list of all figures.

use anyhow::Result;

use super::inputs::Inputs;
use super::learning;
use super::mechanics;
use super::sketch::Sketch;

/// A figure: its number in the thesis, its title and the function that draws it.
#[derive(Debug)]
pub(crate) struct Entry {
    pub(crate) id: &'static str,
    pub(crate) chapter: Chapter,
    pub(crate) title: &'static str,
    pub(crate) draw: fn(&Inputs) -> Result<Sketch>,
}

/// A chapter of the thesis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Chapter {
    Mechanics,
    Learning,
    Recordings,
    Models,
}

impl Chapter {
    pub(crate) const ALL: [Self; 4] =
        [Self::Mechanics, Self::Learning, Self::Recordings, Self::Models];

    pub(crate) fn anchor(self) -> &'static str {
        match self {
            Self::Mechanics => "mechanics",
            Self::Learning => "learning",
            Self::Recordings => "recordings",
            Self::Models => "models",
        }
    }

    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Mechanics => "Mechanics of pushing",
            Self::Learning => "Learning from data",
            Self::Recordings => "From recordings to a table",
            Self::Models => "Learned models of pushing",
        }
    }
}

const fn entry(
    id: &'static str,
    chapter: Chapter,
    title: &'static str,
    draw: fn(&Inputs) -> Result<Sketch>,
) -> Entry {
    Entry { id, chapter, title, draw }
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
    ),
    entry("2.10", Chapter::Mechanics, "sticking and sliding", mechanics::stick_slide::draw),
    entry("2.11", Chapter::Mechanics, "the analytical push", mechanics::analytical::draw),
    entry("3.1", Chapter::Learning, "functions from three priors", learning::prior::draw),
    entry("3.2", Chapter::Learning, "posterior and density of data", learning::posterior::draw),
];
