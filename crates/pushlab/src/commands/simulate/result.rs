//! What `simulate` tells, for people and for programs.

use std::fmt;
use std::path::{Path, PathBuf};

use models::{Moment, RollOutSettings, StepCorrelation};
use serde::Serialize;

use super::rolled::{MeasuredEnd, PROBABILITIES, Rolled};

/// All pushes that were rolled out.
#[derive(Serialize)]
pub(super) struct Simulated {
    folder: PathBuf,
    /// The model's name.
    model: String,
    n_particles: usize,
    /// Longest step, in m.
    longest_step: f64,
    /// How errors of steps go together; none if they were taken for independent.
    correlation: Option<StepCorrelation>,
    /// The probabilities of the quantiles.
    probabilities: [f64; 3],
    pushes: Vec<Push>,
    coverage: Vec<Coverage>,
}

/// One push.
#[derive(Serialize)]
struct Push {
    name: String,
    /// Names of its files without their endings.
    file: String,
    /// At the start and after each step.
    moments: Vec<Moment>,
    quantiles: Vec<Vec<[f64; 3]>>,
    /// Share of the pushed particle steps at which the model was asked beyond its training steps.
    unseen: f64,
    /// Particles that lost contact, counted each time.
    lost: usize,
    end: Option<MeasuredEnd>,
}

/// How many measured ends a region holds.
#[derive(Serialize)]
struct Coverage {
    level: f64,
    n_within: usize,
    n_ends: usize,
}

const LEVELS: [f64; 3] = [0.5, 0.9, 0.95];
/// More than this beyond the training steps deserves a word.
const WORTH_A_WORD: f64 = 0.01;

impl Simulated {
    pub(super) fn new(
        folder: &Path,
        model: &str,
        settings: &RollOutSettings,
        correlation: Option<StepCorrelation>,
        rolled: &[Rolled],
    ) -> Self {
        let push = |one: &Rolled| Push {
            name: one.name.clone(),
            file: one.file_name(),
            moments: one.moments.clone(),
            quantiles: one.quantiles.clone(),
            unseen: one.unseen(),
            lost: one.moments.iter().map(|moment| moment.events.lost).sum(),
            end: one.end,
        };
        let ends: Vec<MeasuredEnd> = rolled.iter().filter_map(|one| one.end).collect();
        let within = |level: f64| Coverage {
            level,
            n_within: ends.iter().filter(|end| end.level <= level).count(),
            n_ends: ends.len(),
        };
        Self {
            folder: folder.to_owned(),
            model: model.to_owned(),
            n_particles: settings.n_particles,
            longest_step: settings.step,
            correlation,
            probabilities: PROBABILITIES,
            pushes: rolled.iter().map(push).collect(),
            coverage: if ends.is_empty() { Vec::new() } else { LEVELS.map(within).into() },
        }
    }
}

impl fmt::Display for Simulated {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { model, n_particles, pushes, .. } = self;
        let (n, unit) = (pushes.len(), if pushes.len() == 1 { "push" } else { "pushes" });
        writeln!(f, "{model}: {n} {unit}, {n_particles} particles each")?;
        match &self.correlation {
            Some(found) => writeln!(f, "  {}", Shares(found))?,
            None => writeln!(
                f,
                "  errors of steps taken for independent, which is too sure of whole pushes: \
                 --correlation SET"
            )?,
        }
        for push in pushes {
            write!(f, "{push}")?;
        }
        for Coverage { level, n_within, n_ends } in &self.coverage {
            writeln!(
                f,
                "  {:.0} % regions hold {n_within} of {n_ends} measured ends",
                100.0 * level
            )?;
        }
        writeln!(f, "wrote {}", self.folder.display())
    }
}

impl fmt::Display for Push {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(last) = self.moments.last() else { return Ok(()) };
        let (mean, covariance) = (last.pose_wb.mean, last.pose_wb.covariance);
        let sd = |axis: usize| covariance[(axis, axis)].max(0.0).sqrt();
        writeln!(
            f,
            "  {}: after {:.2} s at ({:.2} ± {:.2}, {:.2} ± {:.2}) mm, {:.2} ± {:.2}°",
            self.name,
            last.time,
            1e3 * mean.x,
            1e3 * sd(0),
            1e3 * mean.y,
            1e3 * sd(1),
            mean.z.to_degrees(),
            sd(2).to_degrees(),
        )?;
        if let Some(end) = &self.end {
            let [place, turn] = end.error;
            writeln!(
                f,
                "    measured {:.2} mm and {:.2}° from there, within the {:.0} % region",
                1e3 * place,
                turn.to_degrees(),
                (100.0 * end.level).ceil()
            )?;
        }
        if self.lost > 0 {
            writeln!(f, "    contact was lost {} times, of all particles", self.lost)?;
        }
        if self.unseen > WORTH_A_WORD {
            let share = 100.0 * self.unseen;
            writeln!(f, "    {share:.0} % of the steps are beyond those that the model has seen")?;
        }
        Ok(())
    }
}

/// A measured correlation in one line.
struct Shares<'a>(&'a StepCorrelation);

impl fmt::Display for Shares<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let StepCorrelation { held, length, n_pushes, .. } = self.0;
        let [dx, dy, dtheta] = held.map(|share| format!("{share:.2}"));
        write!(
            f,
            "of the model's variance of a step {dx} (dx), {dy} (dy), {dtheta} (dtheta) goes on over \
             {:.0} mm of a push, by {n_pushes} pushes",
            1e3 * length
        )
    }
}
