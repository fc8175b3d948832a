//! Where each sum over rows is kept.

/// Places of the sums of M features and a mean of P terms.
///
/// Plain: the lower triangle of ΦᵀΦ by columns, then Φᵀ1, Φᵀy, yᵀy and 1ᵀy. Extended, which more than a
/// constant mean and weighed rows need: the lower triangles of (Φ, y, H)ᵀW(Φ, y, H) and of HᵀH by columns,
/// then Σ ln w.
#[derive(Clone, Copy)]
pub(crate) struct Layout {
    pub(crate) n_features: usize,
    pub(crate) n_basis: usize,
    pub(crate) is_extended: bool,
}

impl Layout {
    /// How many sums there are.
    pub(crate) fn length(self) -> usize {
        match self.is_extended {
            true => self.log_weights() + 1,
            false => triangle(self.n_features) + 2 * self.n_features + 2,
        }
    }

    /// Where the product of columns `i` ≥ `j` of (Φ, y, H) is; plain sums have none of 1 and 1.
    pub(crate) fn product(self, i: usize, j: usize) -> usize {
        let m = self.n_features;
        if self.is_extended {
            return packed(self.width(), i, j);
        }
        match (i.checked_sub(m), j < m) {
            (None, _) => packed(m, i, j),
            (Some(output), true) => triangle(m) + (1 - output) * m + j,
            (Some(output), false) => triangle(m) + 2 * m + output,
        }
    }

    /// Where the product of columns `i` ≥ `j` of H without weights is.
    pub(crate) fn spread(self, i: usize, j: usize) -> usize {
        triangle(self.width()) + packed(self.n_basis, i, j)
    }

    /// Where Σ ln w is.
    pub(crate) fn log_weights(self) -> usize {
        triangle(self.width()) + triangle(self.n_basis)
    }

    /// Columns of (Φ, y, H).
    fn width(self) -> usize {
        self.n_features + 1 + self.n_basis
    }
}

/// Entries of the lower triangle of an n×n matrix.
fn triangle(n: usize) -> usize {
    n * (n + 1) / 2
}

/// The place of entry (i, j) of the lower triangle of an n×n matrix by columns.
fn packed(n: usize, i: usize, j: usize) -> usize {
    triangle(n) - triangle(n - j) + i - j
}
