//! A range of a covariate, as a finding names it.

use serde::Serialize;

use crate::Covariate;
use crate::compare::axis::Axis;
use crate::statistics::box_search::CellRange;

/// A range of a covariate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Condition {
    /// Of what.
    pub covariate: Covariate,
    /// Lower end; none where the range goes down to the end of the data. Angles may pass π.
    pub from: Option<f64>,
    /// Upper end; none where the range goes up to the end of the data. For edges the last of them.
    pub to: Option<f64>,
}

impl Condition {
    /// None for a range that holds every step.
    pub(crate) fn of(axis: &Axis, range: CellRange) -> Option<Self> {
        let (covariate, n) = (axis.covariate, axis.n_cells());
        let (last, [first_used, last_used]) = (range.first + range.n - 1, axis.used());
        let is_open = [range.first <= first_used, last >= last_used];
        if range.n == n || (is_open == [true; 2] && !covariate.is_periodic()) {
            return None;
        }
        let [from, to] = [axis.bins.ends(range.first)[0], axis.bins.ends(last % n)[1]];
        let condition = |from, to| Some(Self { covariate, from, to });
        match covariate {
            Covariate::Edge => condition(Some(from + 0.5), Some(to - 0.5)),
            _ if covariate.is_periodic() => {
                let to = if last >= n { to + std::f64::consts::TAU } else { to };
                condition(Some(from), Some(to))
            }
            _ => condition((!is_open[0]).then_some(from), (!is_open[1]).then_some(to)),
        }
    }
}
