//! The rows of which whole pushes are made.

use std::path::Path;

use anyhow::{Result, bail, ensure};
use dataset::{IngestSettings, Table, TableMapping};

use crate::tool::opened::{About, Opened, OpenedTable};
use crate::tool::origin::Input;
use crate::tool::recorded_steps::RecordedSteps;
use crate::tool::step_size::StepSize;
use crate::tool::step_source::StepSource;
use crate::tool::terminal::Terminal;
use crate::tool::wrong_usage::WrongUsage;

/// Steps of pushes, with what says what they are of.
pub(super) struct Rows {
    pub(super) table: Table,
    pub(super) about: About,
    /// Whether the ends of each push alone are known.
    pub(super) is_of_ends: bool,
    pub(super) inputs: Vec<Input>,
}

/// Columns that tell which rows follow one another, when and where.
const OF_WHOLE_PUSHES: [&str; 6] =
    ["push", "step", "t_s", "object_x_m", "object_y_m", "object_theta_rad"];

impl Rows {
    /// Reads recordings as steps of a length, or a table, whose steps are made.
    ///
    /// # Errors
    /// If it cannot be read, or its rows do not tell which of them follow one another.
    pub(super) fn read(
        source: &StepSource,
        step: Option<StepSize>,
        terminal: &Terminal,
    ) -> Result<Self> {
        match source.open()? {
            Opened::Recordings(set) => {
                let is_of_ends = set.is_of_end_points();
                let usual = IngestSettings::default();
                let step = step.filter(|_| !is_of_ends).map_or(usual.step, |StepSize(step)| step);
                let settings = IngestSettings { step, ..usual };
                let RecordedSteps { table, inputs, .. } =
                    RecordedSteps::read(&set, &settings, terminal)?;
                let about = About::Manifest(Box::new(set.manifest().clone()));
                Ok(Self { table, about, is_of_ends, inputs })
            }
            Opened::Table(opened) => {
                let OpenedTable { table, about, inputs, .. } = *opened;
                let is_of_ends = table.rows.iter().all(|row| row.is_whole_push());
                if step.is_some() && !is_of_ends {
                    bail!(WrongUsage("--step is for recordings; the steps of a table are made"));
                }
                if let About::Mapping(mapping) = &about {
                    follow_one_another(mapping, &source.set)?;
                }
                Ok(Self { table, about, is_of_ends, inputs })
            }
        }
    }
}

/// Refuses a table of others whose rows are steps without a before and after.
fn follow_one_another(mapping: &TableMapping, path: &Path) -> Result<()> {
    let lacking: Vec<_> = OF_WHOLE_PUSHES.into_iter().filter(|name| !mapping.gives(name)).collect();
    ensure!(
        lacking.is_empty(),
        "whole pushes are rolled out, and {} does not tell which of its rows follow one another: its \
         mapping has no {}; add them to its [columns] or [constants], or let `pushlab compare` tell how \
         wrong the model is on each step",
        path.display(),
        lacking.join(", ")
    );
    Ok(())
}
