//! What can be trained, as people type it.

use anyhow::{Result, bail};
use clap::ValueEnum;
use models::ProcessKind;
use serde::{Serialize, Serializer};

use crate::tool::wrong_usage::WrongUsage;

/// A kind of model that learns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Kind {
    /// Exact Gaussian processes: best up to a thousand steps
    Gp,
    /// Sparse ones, through learnt pseudo-inputs
    Spgp,
    /// Random Fourier features: for a hundred thousand steps and more
    Rff,
    /// Exact ones whose noise depends on where a push is, too
    Vhgp,
    /// Physics, and one of the above on what it leaves over
    Hybrid,
}

/// What learns the rest beside physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Residual {
    Gp,
    Spgp,
    Rff,
    Vhgp,
}

/// An input beside p and β, or in place of p.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Extra {
    /// The pusher's mean speed
    Speed,
    /// The contact normal in the body's frame
    Edge,
    /// In place of p: the contact seen from the centroid, and the outline's curvature, by which
    /// several shapes are learnt from together
    Contact,
}

/// The kind with its process.
#[derive(Clone, Copy, Serialize)]
pub(super) struct Chosen {
    #[serde(serialize_with = "as_name")]
    pub(super) kind: Kind,
    #[serde(serialize_with = "as_id")]
    pub(super) process: ProcessKind,
}

impl Chosen {
    /// # Errors
    /// If a residual kind is given to a model without physics.
    pub(super) fn new(kind: Kind, residual: Option<Residual>) -> Result<Self> {
        let process = match (kind, residual) {
            (Kind::Hybrid, Some(Residual::Spgp)) | (Kind::Spgp, None) => ProcessKind::Spgp,
            (Kind::Hybrid, Some(Residual::Rff)) | (Kind::Rff, None) => ProcessKind::Rff,
            (Kind::Hybrid, Some(Residual::Vhgp)) | (Kind::Vhgp, None) => ProcessKind::Vhgp,
            (Kind::Hybrid, _) | (Kind::Gp, None) => ProcessKind::Gp,
            (_, Some(_)) => bail!(WrongUsage("--residual-kind is for --kind hybrid")),
        };
        Ok(Self { kind, process })
    }

    /// Steps that are learnt from within a minute or so.
    pub(super) fn most_rows(self) -> usize {
        match self.process {
            ProcessKind::Gp => 1000,
            ProcessKind::Vhgp => 300,
            ProcessKind::Spgp | ProcessKind::Rff => usize::MAX,
        }
    }
}

/// A value by the name that is typed.
pub(super) trait Typed: ValueEnum {
    fn name(&self) -> String {
        self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
    }
}

impl Typed for Kind {}
impl Typed for Residual {}
impl Typed for Extra {}

fn as_name<S: Serializer>(kind: &Kind, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(&kind.name())
}

fn as_id<S: Serializer>(kind: &ProcessKind, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(kind.id())
}
