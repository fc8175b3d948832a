//! What learnt processes say of a step that is uncertain itself, without points.

use gp_core::{Expansion, GaussianInput, SquaredExponentialBasis, UncertainOutputs};
use gp_rff::Waves;

use crate::process::Process;
use crate::steps::contact_place::ContactPlaces;
use crate::steps::prediction::of_output;
use crate::{ModelError, StepFeatures, StepInput};

/// Three processes as sums over functions whose moments under a Gaussian are known.
#[derive(Debug)]
pub(crate) struct ClosedForm {
    features: StepFeatures,
    outputs: Outputs,
    /// Variances of the noise, per squared meter of way.
    pub(crate) noise: [f64; 3],
}

#[derive(Debug)]
enum Outputs {
    SquaredExponentialBasis([Expansion<SquaredExponentialBasis>; 3]),
    Waves([Expansion<Waves>; 3]),
}

impl ClosedForm {
    /// Of processes for outputs per meter of way; O(N³).
    ///
    /// # Errors
    /// `NoClosedForm` for noise that depends on the input, and for outputs that are told at a place
    /// which depends on it; `Gp` for a kernel without moments.
    pub(crate) fn of(processes: &[Process; 3], features: StepFeatures) -> Result<Self, ModelError> {
        let of = |what: &str| ModelError::NoClosedForm { of: what.to_owned() };
        if features.contact {
            return Err(of(&format!("a model of {}", features.names().join(", "))));
        }
        let kind = || of(&format!("a model of kind {}", processes[0].kind().id()));
        let noise = |k: usize| processes[k].common_noise().ok_or_else(kind);
        let noise = [noise(0)?, noise(1)?, noise(2)?];
        let bumps = |k: usize| match &processes[k] {
            Process::Gp(process) => process.expansion().map_err(of_output(k)),
            Process::Spgp(process) => process.expansion().map_err(of_output(k)),
            Process::Rff(_) | Process::Vhgp(_) => Err(kind()),
        };
        let waves = |k: usize| match &processes[k] {
            Process::Rff(process) => process.expansion().map_err(of_output(k)),
            Process::Gp(_) | Process::Spgp(_) | Process::Vhgp(_) => Err(kind()),
        };
        let outputs = match &processes[0] {
            Process::Rff(_) => Outputs::Waves([waves(0)?, waves(1)?, waves(2)?]),
            Process::Gp(_) | Process::Spgp(_) | Process::Vhgp(_) => {
                Outputs::SquaredExponentialBasis([bumps(0)?, bumps(1)?, bumps(2)?])
            }
        };
        Ok(Self { features, outputs, noise })
    }

    /// The processes' inputs of a step.
    ///
    /// # Errors
    /// `NoSpeed` where the speed is an input and the step has none.
    pub(crate) fn inputs(&self, step: &StepInput) -> Result<Vec<f64>, ModelError> {
        let row = self.features.row(step, &mut ContactPlaces::default())?;
        Ok(row[..self.features.n_inputs()].to_vec())
    }

    /// Moments of the outputs, without noise, per meter of way.
    ///
    /// # Errors
    /// `Gp` for inputs of another number.
    pub(crate) fn at(&self, input: &GaussianInput) -> Result<UncertainOutputs, ModelError> {
        match &self.outputs {
            Outputs::SquaredExponentialBasis([a, b, c]) => Expansion::at(&[a, b, c], input),
            Outputs::Waves([a, b, c]) => Expansion::at(&[a, b, c], input),
        }
        .map_err(of_output(0))
    }
}
