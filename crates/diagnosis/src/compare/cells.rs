//! In which cells of maps and regions of findings each step is, and what it adds to them.

use crate::compare::axis::Axis;
use crate::compare::reading::Reading;
use crate::{Covariate, DiagnosisError, Observations, Predictions};

/// A covariate that varies over the steps, in the cells of maps.
#[derive(Clone, Debug, PartialEq)]
pub struct CovariateCells {
    /// Of what.
    pub covariate: Covariate,
    /// Lower and upper end of each cell, in SI units.
    pub ranges: Vec<[f64; 2]>,
    /// The cell of each step.
    pub cell_of: Vec<usize>,
}

impl CovariateCells {
    /// Those of every covariate that varies.
    pub fn all(observations: &Observations) -> Vec<Self> {
        let cells = |axis: Axis| {
            let ranges = (0..axis.n_cells()).map(|cell| axis.bins.ends(cell)).collect();
            Self { covariate: axis.covariate, ranges, cell_of: axis.cell_of }
        };
        Axis::all(observations).into_iter().map(cells).collect()
    }
}

impl Observations {
    /// The push of a step, as an index into [`Observations::pushes`]; `step` is below
    /// [`Observations::n_steps`].
    pub fn push_of(&self, step: usize) -> usize {
        self.push_of[step]
    }
}

/// Observed less predicted of every step, in one number of a step as maps have it.
#[derive(Clone, Debug, PartialEq)]
pub struct StepResiduals {
    /// Which number; `drift` is dy, and `turn` dtheta, in the sense that the model predicts.
    pub name: &'static str,
    /// Its place in [`effects::Channels`].
    pub number: usize,
    /// One a step, in SI units; none where maps leave the step out.
    pub values: Vec<Option<f64>>,
}

/// The residuals of every number.
///
/// # Errors
/// `OtherSteps` if the predictions are of other observations.
pub fn step_residuals(
    observations: &Observations,
    predictions: &Predictions,
) -> Result<Vec<StepResiduals>, DiagnosisError> {
    let residuals = predictions.residuals(observations)?;
    let of = |reading: Reading| {
        let Reading { name, number, .. } = reading;
        let signs = reading.signs(predictions, observations);
        let value = |(sign, residual): (&f64, &[Option<f64>; 7])| {
            residual[number].filter(|_| *sign != 0.0).map(|value| sign * value)
        };
        StepResiduals { name, number, values: signs.iter().zip(&residuals).map(value).collect() }
    };
    Ok(Reading::all().map(of).collect())
}

#[cfg(test)]
mod tests {
    use super::{CovariateCells, step_residuals};
    use crate::MapSettings;
    use crate::compare::residual_map::residual_maps;
    use crate::compare::structure::Structure;
    use crate::synthetic::made;

    #[test]
    fn the_steps_of_a_cell_are_those_that_its_map_counts() {
        let (observations, predictions, floor) = made(2, |step| 0.02 * step.p);
        let residuals = predictions.residuals(&observations).unwrap();
        let settings = MapSettings { n_flips: 9, ..MapSettings::default() };
        let structure = Structure::of(&residuals, &observations, &predictions, &floor, &settings);
        let axes = CovariateCells::all(&observations);
        let numbers = step_residuals(&observations, &predictions).unwrap();
        let mut n_cells = 0;
        for map in residual_maps(&structure) {
            let number = numbers.iter().find(|number| number.name == map.name).unwrap();
            for cell in &map.cells {
                let mut values = number.values.clone();
                for ((covariate, index), ends) in
                    map.covariates.iter().zip(&cell.indices).zip(&cell.ranges)
                {
                    let axis = axes.iter().find(|axis| axis.covariate == *covariate).unwrap();
                    assert_eq!(axis.ranges[*index], *ends);
                    let is_out = |step: &usize| axis.cell_of[*step] != *index;
                    (0..values.len()).filter(is_out).for_each(|step| values[step] = None);
                }
                let values: Vec<f64> = values.into_iter().flatten().collect();
                assert_eq!(values.len(), cell.n_steps, "{}", map.name);
                let mean = values.iter().sum::<f64>() / values.len() as f64;
                assert!((mean - cell.mean).abs() < 1e-12, "{mean} and {}", cell.mean);
                n_cells += 1;
            }
        }
        assert!(n_cells > 100, "{n_cells}");
    }
}
