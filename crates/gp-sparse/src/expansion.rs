//! The sparse process as a sum of bumps, for inputs that are uncertain.

use gp_core::{Bumps, Expansion, GpError};

use crate::SparseGp;

impl SparseGp {
    /// The belief about f as a sum of the kernel's columns: what it says of uncertain inputs; O(M³).
    ///
    /// # Errors
    /// `NoClosedForm` for any kernel but the squared exponential of all inputs.
    pub fn expansion(&self) -> Result<Expansion<Bumps>, GpError> {
        let basis = Bumps::new(self.kernel(), self.pseudo_inputs())?;
        let prior = basis.signal_variance();
        let roots = vec![(-1.0, self.reduction.clone())];
        Expansion::new(basis, (self.mean(), &[]), self.weights.clone(), prior, roots)
    }
}
