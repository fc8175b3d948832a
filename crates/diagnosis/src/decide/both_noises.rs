//! A model under the noise that was learnt beside it, and under that which is usual.

use std::cell::OnceCell;

use crate::Whitening;
use crate::cut_offs::FAR_OFF;
use crate::fit::Refit;

/// A model at its minimum, and what it is under the noise that is usual.
///
/// Where a push is missed by far more than is usual, that noise is asked as well: what was learnt beside a model
/// that misses so much may be the missing effect itself.
pub(super) struct BothNoises<'r, 'a> {
    pub(super) here: &'r Refit<'a>,
    usual: &'a Whitening,
    plain: OnceCell<Option<Refit<'a>>>,
}

impl<'r, 'a> BothNoises<'r, 'a> {
    pub(super) fn new(here: &'r Refit<'a>, usual: &'a Whitening) -> Self {
        Self { here, usual, plain: OnceCell::new() }
    }

    /// The model under the noise that is usual, if it misses a push by far more than that.
    pub(super) fn plain(&self) -> Option<&Refit<'a>> {
        let found = || self.here.roughly_rewhitened(self.usual).ok();
        self.plain.get_or_init(|| found().filter(|plain| plain.scale() >= FAR_OFF)).as_ref()
    }
}
