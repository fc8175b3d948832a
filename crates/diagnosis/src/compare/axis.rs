//! The steps of observations in the cells of one covariate.

use crate::data::covariate::Bins;
use crate::{Covariate, Observations};

/// A covariate that varies, with the cell of each step.
pub(crate) struct Axis {
    pub(crate) covariate: Covariate,
    pub(crate) bins: Bins,
    pub(crate) cell_of: Vec<usize>,
}

impl Axis {
    /// The covariates that vary over the steps, in their usual order.
    pub(crate) fn all(observations: &Observations) -> Vec<Self> {
        let known = Covariate::ALL.into_iter().filter(|known| observations.knows(*known));
        let axis = |covariate: Covariate| {
            let values = observations.values_of(covariate);
            let bins = covariate.bins(&values);
            let cell_of: Vec<_> = values.iter().map(|value| bins.cell(*value)).collect();
            let varies = cell_of.iter().any(|cell| *cell != cell_of[0]);
            varies.then_some(Self { covariate, bins, cell_of })
        };
        known.filter_map(axis).collect()
    }

    /// The first and the last cell with steps.
    pub(crate) fn used(&self) -> [usize; 2] {
        let cells = || self.cell_of.iter().copied();
        [cells().min().unwrap_or_default(), cells().max().unwrap_or_default()]
    }

    pub(crate) fn n_cells(&self) -> usize {
        self.bins.n_cells()
    }
}

/// The axes of each map: none for the mean of everything, one, or a pair that matters.
pub(crate) fn sets(axes: &[Axis]) -> Vec<Vec<usize>> {
    let place = |covariate| axes.iter().position(|axis| axis.covariate == covariate);
    let pairs = Covariate::PAIRS.into_iter().filter_map(|[a, b]| Some(vec![place(a)?, place(b)?]));
    let singles = (0..axes.len()).map(|axis| vec![axis]);
    std::iter::once(Vec::new()).chain(singles).chain(pairs).collect()
}
