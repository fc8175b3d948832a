//! Observed rows without ids as runs.

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use crate::data::clusters::{clusters, numbered};
use crate::data::local_residuals::Point;
use crate::data::nominal_motion::NominalMotion;
use crate::data::observations::Place;
use crate::data::runs::{FoundRuns, runs};
use crate::{DiagnosisError, Observations, PushName, Runs};

/// Inputs whose standard deviation is below this are the same in every row.
const SAME: f64 = 0.02;

impl Observations {
    /// Which rows are taken for steps of one push, where the table has no ids and rows nearly alike share
    /// their errors.
    pub fn runs(&self) -> Option<&Runs> {
        self.runs.as_ref()
    }

    /// Rows that share their errors as the steps of one push each; as they are where none do.
    ///
    /// # Errors
    /// `Model` for a pusher's friction that no model can have.
    pub(crate) fn in_runs(mut self, pusher_friction: f64) -> Result<Self, DiagnosisError> {
        let model = NominalMotion::new(pusher_friction, self.support)?;
        let of = |step| Ok(model.beside(step)?.map(|b| b.map(|(observed, at)| observed - at)));
        let values: Result<Vec<Option<[f64; 3]>>, DiagnosisError> =
            self.steps.par_iter().map(of).collect();
        let (points, sds) = self.points();
        let Some(found) = of_known(&points, &values?, sds) else { return Ok(self) };
        let mut pushes: Vec<PushName> = Vec::new();
        for (run, row) in found.of_row.iter().zip(&self.push_of) {
            if *run == pushes.len() {
                let PushName { recording, push } = &self.pushes[*row];
                pushes.push(PushName { recording: format!("run in {recording}"), push: *push });
            }
        }
        (self.cluster, self.cluster_of) = clusters(&self.steps, &found.of_row);
        (self.pushes, self.push_of, self.runs) = (pushes, found.of_row, Some(found.runs));
        Ok(self)
    }

    /// The inputs of each row that vary, and the standard deviations of p and β.
    fn points(&self) -> (Vec<Point>, [f64; 2]) {
        let inputs: [fn(&Place) -> f64; 3] =
            [|place| place.p, |place| place.beta, |place| place.speed.max(1e-4).ln()];
        let mut columns: Vec<Vec<f64>> =
            inputs.iter().map(|of| self.places.iter().map(of).collect()).collect();
        columns.push((0..self.n_steps()).map(|step| self.way(step).max(1e-5).ln()).collect());
        let sds: Vec<f64> = columns.iter().map(|values| sd(values)).collect();
        let used: Vec<usize> = (0..columns.len()).filter(|k| sds[*k] > SAME).collect();
        let point = |row: usize| Point {
            kind: self.places[row].edge,
            at: used.iter().map(|k| columns[*k][row] / sds[*k]).collect(),
        };
        ((0..self.n_steps()).map(point).collect(), [sds[0], sds[1]])
    }
}

/// Runs of the rows whose values are known; each of the others is a run of its own.
fn of_known(points: &[Point], values: &[Option<[f64; 3]>], sds: [f64; 2]) -> Option<FoundRuns> {
    let known = |row: &usize| values[*row].is_some();
    let rows: Vec<usize> = (0..points.len()).filter(known).collect();
    let own: Vec<Point> = rows.iter().map(|row| points[*row].clone()).collect();
    let own_values: Vec<[f64; 3]> = values.iter().flatten().copied().collect();
    let FoundRuns { mut runs, of_row } = runs(&own, &own_values, sds)?;
    let n = runs.n;
    let mut all: Vec<usize> = (0..points.len()).map(|row| n + row).collect();
    rows.iter().zip(&of_row).for_each(|(row, run)| all[*row] = *run);
    let of_row = numbered(all.into_iter());
    runs.n += points.len() - rows.len();
    runs.n_rows = points.len();
    Some(FoundRuns { runs, of_row })
}

fn sd(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / n).sqrt()
}
