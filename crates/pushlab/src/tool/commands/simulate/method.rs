//! How the motion is carried through a push, as people type it.

use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use filter::{GaussHermite, Unscented};
use models::{GpPushModel, Matching, PushModel, TableReport};
use serde::Serialize;

/// A way to do without particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Method {
    /// By a few points about the mean: for every model, and the fastest
    Unscented,
    /// By a grid of points, three along each axis: for every model
    GaussHermite,
    /// Through gp, spgp and rff models in closed form
    Exact,
}

impl Method {
    pub(super) fn matching(self) -> Matching<'static> {
        const GRID: GaussHermite = GaussHermite { order: 3 };
        match self {
            Self::Unscented => Matching::Points(&Unscented),
            Self::GaussHermite => Matching::Points(&GRID),
            Self::Exact => Matching::Exact(&GRID),
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Unscented => "unscented",
            Self::GaussHermite => "gauss-hermite",
            Self::Exact => "exact",
        }
    }
}

/// How near the tables of a model are to it, by the worst of the outputs.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Tables {
    /// Nodes along p and along β.
    n: [usize; 2],
    /// Of the mean, over the standard deviation of an observation.
    pub(super) mean_error: f64,
    /// Of the variance, over that of an observation.
    pub(super) variance_error: f64,
}

/// A learnt model read from tables.
///
/// # Errors
/// For a model that is not learnt, sees more than (p, β), or varies too fast.
pub(super) fn tabulated(model: &dyn PushModel) -> Result<(GpPushModel, Tables)> {
    let Some(processes) = model.as_processes() else {
        bail!(
            "--fast reads learnt models from tables, and a model of kind {} is none; leave it out",
            model.kind()
        );
    };
    let (table, report) = processes.tabulated().context("cannot make tables for --fast")?;
    let TableReport { n, mean_error, variance_error } = report;
    Ok((table, Tables { n, mean_error, variance_error }))
}
