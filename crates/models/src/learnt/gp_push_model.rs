//! The model that knows no mechanics: processes learnt from observed steps.

use std::sync::Arc;

use gp_core::LearnOptions;

use crate::learnt::closed_form::ClosedForm;
use crate::learnt::step_processes::StepProcesses;
use crate::{ModelError, ProcessReport, StepObservation, TableReport, Training, Weights};

/// Three independent processes from what is seen of a step to the outputs per meter of the pusher's
/// way.
///
/// The object is not an input: the model is of the outlines that it was trained on and refuses
/// others, unless it sees the contact as several outlines have it ([`crate::StepFeatures::contact`]).
/// Use it at step lengths near those of the training.
#[derive(Clone, Debug)]
pub struct GpPushModel {
    pub(crate) processes: StepProcesses,
}

impl GpPushModel {
    /// Learns exact Gaussian processes of (p, β), with edges folded into one. O(N³).
    ///
    /// # Errors
    /// As [`GpPushModel::train`].
    pub fn learn(
        steps: &[StepObservation],
        options: &LearnOptions,
    ) -> Result<(Self, [ProcessReport; 3]), ModelError> {
        Self::train(steps, &options.clone().into())
    }

    /// Learns from observed steps; the reports are those of Δx, Δy and Δθ.
    ///
    /// # Errors
    /// `Gp` for fewer than two steps, outputs that do not vary, or a likelihood without maximum;
    /// `NoSpeed` where the speed is an input and a step has none, `ConstantInput` where it is the
    /// same in all.
    pub fn train(
        steps: &[StepObservation],
        training: &Training,
    ) -> Result<(Self, [ProcessReport; 3]), ModelError> {
        let inputs: Vec<_> = steps.iter().map(|step| &step.input).collect();
        let targets: Vec<_> = steps.iter().map(|step| step.outputs).collect();
        let (processes, reports) = StepProcesses::learn(&inputs, &targets, training)?;
        Ok((Self { processes }, reports))
    }

    /// The same model, read from a table of (p, β) that is made here: fast enough for particles.
    ///
    /// Means are within 0.01 standard deviations of an observed step and variances within 10⁻³ of its
    /// variance, measured at random places while the table is made; the report has both. A step then
    /// costs the same for every process, where an exact one needs O(N²) and a sparse one O(M²).
    ///
    /// # Errors
    /// `NoTable` for a model that sees more than (p, β); `TableTooCoarse` for processes that vary too
    /// fast.
    pub fn tabulated(&self) -> Result<(Self, TableReport), ModelError> {
        let (processes, report) = self.processes.tabulated()?;
        Ok((Self { processes }, report))
    }

    /// What the processes say of steps that are uncertain themselves; O(N³) when first asked.
    pub(crate) fn closed_form(&self) -> Result<Arc<ClosedForm>, ModelError> {
        self.processes.closed_form()
    }

    pub(crate) fn from_weights(weights: &Weights) -> Result<Self, ModelError> {
        Ok(Self { processes: StepProcesses::from_weights(weights)? })
    }
}
