//! What `simulate` tells, for people and for programs.

use std::fmt;
use std::path::{Path, PathBuf};

use models::{Base, Calibration, Moment, PushModel, RollOutSettings};
use serde::Serialize;

use super::method::{Method, Tables};
use super::rolled::{MeasuredEnd, PROBABILITIES, Rolled};
use crate::tool::whole_pushes::Told as OfWholePushes;

/// How pushes were rolled out.
pub(super) struct How<'a> {
    pub(super) settings: &'a RollOutSettings,
    pub(super) tables: Option<Tables>,
    pub(super) matched: Option<Method>,
    /// None where nothing tells it.
    pub(super) calibration: Option<Calibration>,
    pub(super) sureness: Sureness,
}

/// What a model knows of how far apart like pushes end, beside how the errors of their steps go together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sureness {
    /// Its steps have errors.
    OfSteps,
    /// Parameters differ from push to push.
    OfPushes,
    /// It is physics without any scatter.
    None,
}

impl Sureness {
    pub(super) fn of(base: &Base, model: &dyn PushModel) -> Self {
        match base {
            _ if model.n_drawn() > 0 => Self::OfPushes,
            Base::Analytical(base) if base.scatter().iter().all(|of| *of == 0.0) => Self::None,
            _ => Self::OfSteps,
        }
    }

    fn told(self) -> &'static str {
        match self {
            Self::OfPushes => {
                "what differs from push to push is drawn for each as widely as the model says: \
                 `pushlab calibrate SET` tells whether so much shows"
            }
            Self::OfSteps => {
                "errors of steps taken for independent, which is too sure of whole pushes: \
                 `pushlab calibrate SET`"
            }
            Self::None => {
                "no push differs from another in the model, which is too sure of all: \
                 `pushlab add --all --from DIAGNOSIS`"
            }
        }
    }
}

/// All pushes that were rolled out.
#[derive(Serialize)]
pub(super) struct Simulated {
    folder: PathBuf,
    /// The model's name.
    model: String,
    /// None if the motion was carried without.
    n_particles: Option<usize>,
    /// How it was carried without particles.
    matched: Option<Method>,
    /// How near the tables are that the model was read from; none if it was asked itself.
    tables: Option<Tables>,
    /// Longest step, in m.
    longest_step: f64,
    /// How sure the model may be of whole pushes; none if nothing told it.
    calibration: Option<Calibration>,
    #[serde(skip)]
    sureness: Sureness,
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
        How { settings, tables, matched, calibration, sureness }: How<'_>,
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
            n_particles: matched.is_none().then_some(settings.n_particles),
            matched,
            tables,
            longest_step: settings.step,
            calibration,
            sureness,
            probabilities: PROBABILITIES,
            pushes: rolled.iter().map(push).collect(),
            coverage: if ends.is_empty() { Vec::new() } else { LEVELS.map(within).into() },
        }
    }
}

impl fmt::Display for Simulated {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { model, n_particles, matched, pushes, .. } = self;
        let (n, unit) = (pushes.len(), if pushes.len() == 1 { "push" } else { "pushes" });
        match (n_particles, matched) {
            (Some(n_particles), _) => {
                writeln!(f, "{model}: {n} {unit}, {n_particles} particles each")?;
            }
            (None, matched) => {
                let method = matched.map_or("moments", Method::name);
                writeln!(f, "{model}: {n} {unit}, without particles ({method})")?;
            }
        }
        if let Some(Tables { mean_error, variance_error, .. }) = self.tables {
            writeln!(
                f,
                "  read from tables: means within {mean_error:.1e} of a step's standard deviation, \
                 variances within {variance_error:.1e} of its variance"
            )?;
        }
        match &self.calibration {
            Some(found) => writeln!(f, "  {}", OfWholePushes(found))?,
            None => writeln!(f, "  {}", self.sureness.told())?,
        }
        for push in pushes {
            write!(f, "{}", Told { push, by_particles: n_particles.is_some() })?;
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

/// A push in words.
struct Told<'a> {
    push: &'a Push,
    by_particles: bool,
}

impl fmt::Display for Told<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { push, by_particles } = self;
        let Some(last) = push.moments.last() else { return Ok(()) };
        let (mean, covariance) = (last.pose_wb.mean, last.pose_wb.covariance);
        let sd = |axis: usize| covariance[(axis, axis)].max(0.0).sqrt();
        writeln!(
            f,
            "  {}: after {:.2} s at ({:.2} ± {:.2}, {:.2} ± {:.2}) mm, {:.2} ± {:.2}°",
            push.name,
            last.time,
            1e3 * mean.x,
            1e3 * sd(0),
            1e3 * mean.y,
            1e3 * sd(1),
            mean.z.to_degrees(),
            sd(2).to_degrees(),
        )?;
        if let Some(end) = &push.end {
            let [place, turn] = end.error;
            write!(
                f,
                "    measured {:.2} mm and {:.2}° from there, ",
                1e3 * place,
                turn.to_degrees()
            )?;
            match (100.0 * end.level).ceil() {
                100.0.. => writeln!(f, "beyond the 99 % region")?,
                level => writeln!(f, "within the {level:.0} % region")?,
            }
        }
        if push.lost > 0 {
            let whose = if *by_particles { "of all particles" } else { "on the mean way" };
            writeln!(f, "    contact was lost {} times, {whose}", push.lost)?;
        }
        if push.unseen > WORTH_A_WORD {
            let share = 100.0 * push.unseen;
            writeln!(f, "    {share:.0} % of the steps are beyond those that the model has seen")?;
        }
        Ok(())
    }
}
