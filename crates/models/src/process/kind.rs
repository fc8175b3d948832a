//! The kinds of processes.

/// How an output is learnt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ProcessKind {
    /// An exact Gaussian process: O(N³).
    #[default]
    Gp,
    /// A sparse one, through learnt pseudo-inputs: O(N M²).
    Spgp,
    /// Bayesian linear regression on random Fourier features: O(N M²).
    Rff,
    /// An exact one whose noise is a function of the input too: O(N³) a step, of many.
    Vhgp,
}

impl ProcessKind {
    /// Every kind.
    pub const ALL: [Self; 4] = [Self::Gp, Self::Spgp, Self::Rff, Self::Vhgp];

    /// The name in `model.toml`.
    pub fn id(self) -> &'static str {
        match self {
            Self::Gp => "gp",
            Self::Spgp => "spgp",
            Self::Rff => "rff",
            Self::Vhgp => "vhgp",
        }
    }

    /// The kind of this name.
    pub fn by_id(id: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.id() == id)
    }
}
