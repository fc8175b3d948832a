//! The sparse process as a sum of bumps, for inputs that are uncertain.

use gp_core::{Expansion, GpError, SquaredExponentialBasis};

use crate::SparseGp;

impl SparseGp {
    /// The belief about f as a sum of the kernel's columns: what it says of uncertain inputs; O(M³).
    ///
    /// # Errors
    /// `NoClosedForm` for any kernel but the squared exponential of all inputs.
    pub fn expansion(&self) -> Result<Expansion<SquaredExponentialBasis>, GpError> {
        let basis = SquaredExponentialBasis::new(self.kernel(), self.pseudo_inputs())?;
        let prior = basis.signal_variance();
        let roots = vec![(-1.0, self.reduction.clone())];
        let weights = self.weights.clone();
        let whole = Expansion::new(basis, (self.mean(), &[]), weights, prior, roots)?;
        match &self.deviation {
            Some(one) => whole.with_deviation((one.constant, &[]), one.weights.clone()),
            None => Ok(whole),
        }
    }
}
