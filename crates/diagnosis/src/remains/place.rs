//! Where a component gains most.

use crate::compare::axis::Axis;
use crate::compare::words;
use crate::statistics::box_search::CellRange;
use crate::{Condition, Observations};

/// Share of the gain that a place has to hold, and share of the steps that it may hold at most.
const LEAST_GAIN: f64 = 0.6;
const MOST_STEPS: f64 = 0.35;

/// Where gains of steps gather, along the covariate along which they do most; none where they do not.
pub(super) fn place(gains: &[f64], observations: &Observations) -> Option<String> {
    let total: f64 = gains.iter().sum();
    let mut best = (0.0, None);
    for axis in Axis::all(observations) {
        let mut cells = vec![(0.0, 0.0); axis.n_cells()];
        for (gain, cell) in gains.iter().zip(&axis.cell_of) {
            cells[*cell].0 += gain / total;
            cells[*cell].1 += 1.0 / gains.len() as f64;
        }
        for range in CellRange::all(cells.len(), axis.covariate.is_periodic()) {
            let own = range.cells(cells.len()).map(|cell| cells[cell]);
            let (gain, steps) = own.fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
            let merit = gain - steps;
            if gain >= LEAST_GAIN && steps <= MOST_STEPS && merit > best.0 {
                best = (merit, Condition::of(&axis, range));
            }
        }
    }
    best.1.map(|condition| words::place(&[condition]).trim_start().to_owned())
}

#[cfg(test)]
mod tests {
    use super::place;
    use crate::Covariate;
    use crate::synthetic::recorded;

    #[test]
    fn a_place_is_told_where_the_gain_is() {
        let observations = recorded(1).0;
        let values = observations.values_of(Covariate::P);
        let at = |p: &f64| if *p > 0.8 { 1.0 } else { 0.01 };
        let gains: Vec<f64> = values.iter().map(at).collect();
        let told = place(&gains, &observations).unwrap();
        assert!(told.contains("p > 0.8"), "{told}");
        assert_eq!(place(&vec![1.0; values.len()], &observations), None);
    }
}
