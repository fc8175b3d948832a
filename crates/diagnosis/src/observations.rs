//! The steps of a table with what a comparison asks of them.

use std::collections::HashMap;

use dataset::{Manifest, StepRow, SupportSpec, Table};
use models::{ChannelObservation, SetAside, StepSelection};
use serde::Serialize;

use crate::{Covariate, DiagnosisError};

/// Observed steps, the push of each, and the nominal table.
#[derive(Clone, Debug)]
pub struct Observations {
    pub(crate) steps: Vec<ChannelObservation>,
    pub(crate) places: Vec<Place>,
    /// Index of the push of each step.
    pub(crate) push_of: Vec<usize>,
    pub(crate) pushes: Vec<PushName>,
    pub(crate) support: SupportSpec,
    /// What was not measured.
    pub(crate) unknown: Vec<Covariate>,
    set_aside: SetAside,
}

/// A push by its recording and its number there.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize)]
pub struct PushName {
    /// The recording.
    pub recording: String,
    /// 0-based number within the recording.
    pub push: u32,
}

/// Where and how a step is, as the table states it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) step: u32,
    pub(crate) edge: u32,
    pub(crate) p: f64,
    pub(crate) beta: f64,
    pub(crate) speed: f64,
}

/// Fewer pushes say nothing about errors that are shared within a push.
const FEWEST_PUSHES: usize = 3;

impl Observations {
    /// The steps in contact of a table about the set of a manifest.
    ///
    /// # Errors
    /// `Model` for a row that is no step; `TooFewPushes`.
    pub fn of(table: &Table, manifest: &Manifest) -> Result<Self, DiagnosisError> {
        let found = StepSelection::default().channel_steps(
            table,
            &manifest.object,
            manifest.pusher.radius,
        )?;
        let rows: Vec<&StepRow> = found.rows.iter().map(|row| &table.rows[*row]).collect();
        let (mut pushes, mut known) = (Vec::new(), HashMap::new());
        let mut push = |row: &&StepRow| {
            let name = PushName { recording: row.recording.to_string(), push: row.push };
            *known.entry(name.clone()).or_insert_with(|| {
                pushes.push(name);
                pushes.len() - 1
            })
        };
        let push_of = rows.iter().map(&mut push).collect();
        if pushes.len() < FEWEST_PUSHES {
            let (n_pushes, needed) = (pushes.len(), FEWEST_PUSHES);
            let set_aside = found.set_aside.to_string();
            return Err(DiagnosisError::TooFewPushes { n_pushes, needed, set_aside });
        }
        let place = |row: &&StepRow| {
            let StepRow { step, edge, p, beta, speed, .. } = **row;
            Place { step, edge, p, beta, speed }
        };
        Ok(Self {
            places: rows.iter().map(place).collect(),
            steps: found.steps,
            push_of,
            pushes,
            support: manifest.support,
            unknown: Vec::new(),
            set_aside: found.set_aside,
        })
    }

    /// Whether the covariate was measured.
    pub(crate) fn knows(&self, covariate: Covariate) -> bool {
        !self.unknown.contains(&covariate)
    }

    /// How many steps there are.
    pub fn n_steps(&self) -> usize {
        self.steps.len()
    }

    /// The pushes, in the order of the table.
    pub fn pushes(&self) -> &[PushName] {
        &self.pushes
    }

    /// What was observed of each step.
    pub fn steps(&self) -> &[ChannelObservation] {
        &self.steps
    }

    /// Rows of the table that are not compared.
    pub fn set_aside(&self) -> &SetAside {
        &self.set_aside
    }
}
