//! The table of one-step pushes, with its runs.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use dataset::{ObjectChoice, StepRow, TableMapping};
use diagnosis::{Observations, Predictions, RepeatTolerance, noise_floor};
use models::{ChannelModel, ChannelObservation, Description, StepObservation, StepSelection};
use nalgebra::Vector3;

/// Squared errors of a row's three outputs.
pub(super) type Squares = [f64; 3];

/// Which rows of a table without ids are steps of one push: `runs.csv` beside it, a line for each row.
#[derive(serde::Deserialize)]
pub(super) struct Run {
    row: usize,
    pub(super) run: u32,
    pub(super) fold: usize,
}

/// The table with the steps of each run together.
pub(super) struct Table {
    pub(super) mapping: TableMapping,
    /// Of each row, in its order.
    pub(super) runs: Vec<Run>,
    observations: Observations,
    steps: Vec<ChannelObservation>,
    /// The same without anything but the motion.
    pub(super) motions: Vec<StepObservation>,
    /// Of each row's push.
    names: Vec<String>,
}

impl Table {
    /// # Errors
    /// Files that cannot be read, or do not fit each other.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let of = path.with_file_name("runs.csv");
        let mut reader =
            csv::Reader::from_path(&of).with_context(|| format!("cannot read {}", of.display()))?;
        let runs: Result<Vec<Run>, _> = reader.deserialize().collect();
        let mut runs = runs.with_context(|| format!("cannot read {}", of.display()))?;
        let mapping = TableMapping::mit_table()?;
        let mut table = mapping.read_table(path)?;
        let n = table.rows.len();
        ensure!(
            n > 0 && runs.len() == n && runs.iter().enumerate().all(|(k, run)| run.row == k),
            "{}: a row for each of the table's {n} is needed, in order",
            of.display()
        );
        runs.sort_by_key(|run| (run.run, run.row));
        let row = |run: &Run| StepRow { push: run.run, ..table.rows[run.row].clone() };
        table.rows = runs.iter().map(row).collect();
        let observations = Observations::of_rows(&table, &mapping)?;
        let objects = ObjectChoice::Fixed(Box::new(mapping.object.clone()));
        let found =
            StepSelection::default().channel_steps(&table, &objects, mapping.pusher.radius)?;
        ensure!(found.steps.len() == n, "{}: not every row is a step", path.display());
        let name = |row: &StepRow| format!("{}#{}", row.recording, row.push);
        let names = table.rows.iter().map(name).collect();
        let motions =
            StepSelection::default().observations(&table, &objects, mapping.pusher.radius)?.steps;
        ensure!(motions.len() == n, "{}: not every row is a motion", path.display());
        Ok(Self { mapping, runs, observations, steps: found.steps, motions, names })
    }

    /// The pushes of some rows.
    pub(super) fn part(&self, rows: &[usize]) -> Result<Observations> {
        let mut names: Vec<String> = rows.iter().map(|row| self.names[*row].clone()).collect();
        names.dedup();
        Ok(self.observations.part(&names)?)
    }

    /// In the order of the outputs.
    pub(super) fn variances(&self) -> Squares {
        let n = self.motions.len() as f64;
        let sum: Vector3<f64> = self.motions.iter().map(|step| step.outputs).sum();
        let square = |step: &StepObservation| (step.outputs - sum / n).map(|off| off * off);
        (self.motions.iter().map(square).sum::<Vector3<f64>>() / n).into()
    }

    /// Squares of what predicted motions of some rows miss.
    pub(super) fn squares(
        &self,
        told: impl Iterator<Item = Vector3<f64>>,
        rows: &[usize],
    ) -> Vec<Squares> {
        let miss = |(row, told): (&usize, Vector3<f64>)| {
            (self.motions[*row].outputs - told).map(|miss| miss * miss).into()
        };
        rows.iter().zip(told).map(miss).collect()
    }

    /// The motions of some rows by a model.
    ///
    /// # Errors
    /// What the model refuses.
    pub(super) fn predicted(
        &self,
        model: &Description,
        rows: &[usize],
    ) -> Result<Vec<Vector3<f64>>> {
        let channels = ChannelModel::new(model, self.mapping.support, &[])?;
        let told = channels.predict(rows.iter().map(|row| &self.steps[*row].input))?;
        Ok(told
            .iter()
            .map(|told| told.to_array())
            .map(|[dx, dy, dtheta, ..]| Vector3::new(dx, dy, dtheta))
            .collect())
    }

    /// What rows of different runs that begin alike differ by beside a model, mean squares.
    pub(super) fn floor(&self, model: &Description) -> Result<Squares> {
        let predictions = Predictions::of(model, &[], &self.observations)?;
        let floor = noise_floor(&self.observations, &predictions, &RepeatTolerance::default())?;
        let of = |k: usize| floor.numbers[k].map(|floor| floor.rms.powi(2));
        let squares = [0, 1, 2].map(of);
        let known: Option<Vec<f64>> = squares.into_iter().collect();
        known.and_then(|all| all.try_into().ok()).context("no rows begin alike")
    }
}
