//! The sparse process as a sum of bumps, for inputs that are uncertain.

use faer::Mat;
use faer::linalg::matmul::matmul;
use faer::{Accum, Par};
use gp_core::{Bumps, Expansion, GpError};

use crate::SparseGp;

impl SparseGp {
    /// The belief about f as a sum of the kernel's columns: what it says of uncertain inputs; O(M³).
    ///
    /// # Errors
    /// `NoClosedForm` for any kernel but the squared exponential of all inputs.
    pub fn expansion(&self) -> Result<Expansion<Bumps>, GpError> {
        let basis = Bumps::new(self.kernel(), self.pseudo_inputs())?;
        let (prior, m) = (basis.signal_variance(), self.weights.len());
        let mut known = Mat::zeros(m, m);
        let (root, factor) = (&self.root_inverse, &self.factor_inverse);
        matmul(known.as_mut(), Accum::Replace, root, factor, 1.0, Par::Seq);
        let roots = vec![(-1.0, factor.clone()), (1.0, known)];
        Expansion::new(basis, (self.mean(), &[]), self.weights.clone(), prior, roots)
    }
}
