//! The sparse process as a sum of bumps, for inputs that are uncertain.

use gp_core::{Expansion, GpError, SquaredExponentialBasis};

use crate::{Deviation, SparseGp};

impl SparseGp {
    /// The belief about f as a sum of the kernel's columns: what it says of uncertain inputs; O(M³).
    ///
    /// # Errors
    /// `NoClosedForm` for any kernel but the squared exponential of all inputs; `PolynomialMean`.
    pub fn expansion(&self) -> Result<Expansion<SquaredExponentialBasis>, GpError> {
        if self.monomials.degree() > 1 {
            return Err(GpError::PolynomialMean);
        }
        let basis = SquaredExponentialBasis::new(self.kernel(), self.pseudo_inputs())?;
        let prior = basis.signal_variance();
        let roots = vec![(-1.0, self.reduction.clone())];
        let center = self.monomials.center();
        let trend = |one: &Deviation| {
            let shift: f64 = one.coefficients.iter().zip(center).map(|(g, c)| g * c).sum();
            one.constant - shift
        };
        let own = (trend(&self.mean), &*self.mean.coefficients);
        let whole = Expansion::new(basis, own, self.mean.weights.clone(), prior, roots)?;
        self.deviations.iter().try_fold(whole, |whole, one| {
            whole.with_deviation((trend(one), &one.coefficients), one.weights.clone())
        })
    }
}
