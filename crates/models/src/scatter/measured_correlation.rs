//! How the errors of the steps of recorded pushes go together.

use crate::scatter::error_products::{ErrorProducts, Shares};
use crate::scatter::push_errors::PushErrors;
use crate::scatter::push_scatter::{PushScatter, PushSum};
use crate::{ContactGap, EndCheck, ModelError, PushModel, RecordedPush, StepCorrelation};

/// Fewer pushes with three steps do not tell what they share.
const FEWEST: usize = 4;

impl StepCorrelation {
    /// Measures it on pushes that the model has not seen, each as it was recorded.
    ///
    /// # Errors
    /// `TooFewPushes` for fewer than four pushes of three steps or more; `NoVariance` for a model that
    /// claims none; what the model refuses.
    pub fn measure<'a>(
        model: &dyn PushModel,
        pushes: impl IntoIterator<Item = &'a RecordedPush>,
    ) -> Result<Self, ModelError> {
        Self::measure_by(pushes.into_iter().map(|push| (model, push)))
    }

    /// The same where each push has a model of its own, which has not seen it: with models of one kind
    /// that each leave out a part of the pushes, all of them are measured on.
    ///
    /// # Errors
    /// As [`StepCorrelation::measure`].
    pub fn measure_by<'a, 'm>(
        pushes: impl IntoIterator<Item = (&'m dyn PushModel, &'a RecordedPush)>,
    ) -> Result<Self, ModelError> {
        let pushes: Vec<_> = pushes.into_iter().collect();
        let errors = pushes.iter().map(|(model, push)| PushErrors::of(*model, push));
        let errors = errors.collect::<Result<Vec<_>, _>>()?;
        let gaps = pushes.iter().map(|(model, push)| {
            Ok::<_, ModelError>(push.gaps(&model.true_outline(&push.pushed)?))
        });
        let gap = ContactGap::of_gaps(&gaps.collect::<Result<Vec<_>, _>>()?);
        Ok(Self { gap, ..Self::of_errors(&errors)? })
    }

    /// The same with the ends of pushes counted that are within the regions of roll-outs: each push by a
    /// model that has not seen it, as in [`StepCorrelation::measure_by`].
    ///
    /// # Errors
    /// As [`crate::RollOut::run`].
    pub fn checked<'a, 'm>(
        self,
        pushes: impl IntoIterator<Item = (&'m dyn PushModel, &'a RecordedPush)>,
    ) -> Result<Self, ModelError> {
        let ends = Some(EndCheck::of(&self, pushes)?);
        Ok(Self { ends, ..self })
    }

    /// Of whitened errors.
    pub(crate) fn of_errors(all: &[PushErrors]) -> Result<Self, ModelError> {
        let long: Vec<_> = all.iter().filter(|push| push.errors.len() >= 3).collect();
        if long.len() < FEWEST {
            return Err(ModelError::TooFewPushes { n_pushes: long.len(), needed: FEWEST });
        }
        let products: Vec<_> = long.iter().map(|push| ErrorProducts::of(push)).collect();
        let shares = Shares::of(&products);
        let sums: Vec<_> = long.iter().map(|push| PushSum::of(push, &shares)).collect();
        let PushScatter { scale, freedom } = PushScatter::of(&sums);
        let Shares { held, own, measured, length } = shares;
        Ok(Self {
            held: (scale * held).into(),
            length,
            own: (scale * own).into(),
            freedom,
            measured: measured.into(),
            gap: ContactGap::default(),
            n_pushes: long.len(),
            n_steps: long.iter().map(|push| push.errors.len()).sum(),
            ends: None,
        })
    }
}
