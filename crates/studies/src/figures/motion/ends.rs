//! Where held-out pushes end, among the particles of every model.

use std::f64::consts::TAU;

use anyhow::{Context, Result};
use filter::{PlanarSummary, Weights};
use models::{
    ContactGap, PushParticle, RecordedPush, RollOut, RollOutSettings, StepCorrelation, StepErrors,
};
use nalgebra::{Matrix3, Vector3};
use planar::{Pose, wrap_angle};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use report::Color;

use super::pushes::Turn;
use super::trained::{Learnt, Setting, Trained, learn};
use crate::figures::seed::SEED;

/// The levels of the regions whose coverage is told.
pub(crate) const LEVELS: [f64; 3] = [0.5, 0.9, 0.95];

/// How one push ended among the particles of one model.
#[derive(Clone, Copy, Debug)]
pub(crate) struct End {
    /// Share of the particles that are nearer to their mean than the observed end, by the distance
    /// of Mahalanobis: the level of the region whose border it is on.
    pub(crate) level: f64,
    /// Observed less mean: place in m, and turn in rad.
    pub(crate) error: [f64; 2],
    /// Root of the sum of the variances of x and y, in m, and of the angle's, in rad.
    pub(crate) sd: [f64; 2],
    /// Negative log density of the end under the Gaussian with the particles' moments, in nats of m,
    /// m and rad.
    pub(crate) nlpd: f64,
}

/// All ends of a model, with errors drawn anew each step and with errors held.
pub(crate) struct Ends {
    pub(crate) name: &'static str,
    pub(crate) color: Color,
    pub(crate) independent: Vec<End>,
    pub(crate) held: Vec<End>,
    /// One a turn.
    pub(crate) correlations: Vec<StepCorrelation>,
    /// Of all particle steps, the share beyond the model's training steps.
    pub(crate) unseen: f64,
}

/// The ends of the pushes of every turn, by every model.
///
/// # Errors
/// What a fit or a model says.
pub(crate) fn all_ends(
    setting: &Setting,
    turns: &[Turn<'_>],
    n_particles: usize,
) -> Result<Vec<Ends>> {
    let mut all: Vec<Ends> = Vec::new();
    for turn in turns {
        for (index, learnt) in learn(setting, turn, &[])?.into_iter().enumerate() {
            let own = ends_of(learnt, turn, n_particles)?;
            match all.get_mut(index) {
                None => all.push(own),
                Some(known) => {
                    known.independent.extend(own.independent);
                    known.held.extend(own.held);
                    known.correlations.extend(own.correlations);
                    known.unseen += own.unseen;
                }
            }
        }
    }
    all.iter_mut().for_each(|ends| ends.unseen /= turns.len() as f64);
    Ok(all)
}

fn ends_of(learnt: Learnt, turn: &Turn<'_>, n_particles: usize) -> Result<Ends> {
    let Learnt { trained, correlation } = learnt;
    let with = |errors: StepErrors| {
        let settings = RollOutSettings {
            n_particles,
            seed: SEED,
            errors,
            ..recorded_settings(correlation.gap)
        };
        let end = |push: &&RecordedPush| end_of(&trained, push, &settings);
        turn.test.par_iter().map(end).collect::<Result<Vec<_>>>()
    };
    let (independent, unseen): (Vec<End>, Vec<f64>) =
        with(StepErrors::Independent)?.into_iter().unzip();
    let held = with(StepErrors::Held(correlation.clone()))?;
    Ok(Ends {
        name: trained.name,
        color: trained.color,
        unseen: unseen.iter().sum::<f64>() / unseen.len() as f64,
        independent,
        held: held.into_iter().map(|(end, _)| end).collect(),
        correlations: vec![correlation],
    })
}

/// Settings for recorded pushes: in contact, with a gap that was measured.
pub(crate) fn recorded_settings(gap: ContactGap) -> RollOutSettings {
    RollOutSettings { touching: true, gap, step: 0.02, ..RollOutSettings::default() }
}

/// How a push ends, and the share of the particle steps beyond the training steps.
fn end_of(
    trained: &Trained,
    push: &RecordedPush,
    settings: &RollOutSettings,
) -> Result<(End, f64)> {
    let settings = RollOutSettings { start_sd: push.pose_sd[0], ..settings.clone() };
    let roll_out =
        RollOut { model: trained.model.as_ref(), pushed: &push.pushed, settings: &settings };
    let mut particles = Vec::new();
    let watch = |_: &_, now: &[PushParticle]| particles = now.to_vec();
    let moments = roll_out.run(&push.poses_wb[0], &push.path, watch)?;
    let unseen: usize = moments.iter().map(|moment| moment.events.unseen).sum();
    let share = unseen as f64 / (settings.n_particles * (moments.len() - 1)) as f64;
    let end_wb = &push.poses_wb[push.poses_wb.len() - 1];
    Ok((End::of(&particles, end_wb, push.pose_sd[1])?, share))
}

impl End {
    /// Of particles, where the end was measured with standard deviations in m and rad.
    fn of(particles: &[PushParticle], end_wb: &Pose, measured_sd: [f64; 2]) -> Result<Self> {
        let weights = Weights::equal(particles.len());
        let summary = PlanarSummary::of(particles, &weights)?;
        let measured = [end_wb.position.x, end_wb.position.y, end_wb.angle];
        let level = summary.level(particles, &weights, measured, measured_sd)?;
        let [place_sd, angle_sd] = measured_sd.map(|sd| sd.max(1e-8));
        let own = Vector3::new(place_sd, place_sd, angle_sd).map(|sd| sd * sd);
        let spread = summary.covariance + Matrix3::from_diagonal(&own);
        let off = end_wb.position - summary.mean.xy();
        let off = Vector3::new(off.x, off.y, wrap_angle(end_wb.angle - summary.mean.z));
        let root = spread.cholesky().context("a covariance is positive")?;
        let log_size = 2.0 * root.l().diagonal().map(f64::ln).sum();
        Ok(Self {
            level,
            error: [off.xy().norm(), off.z],
            sd: [(spread[(0, 0)] + spread[(1, 1)]).sqrt(), spread[(2, 2)].sqrt()],
            nlpd: 0.5 * (off.dot(&root.solve(&off)) + log_size + 3.0 * TAU.ln()),
        })
    }
}

/// The share of the ends within the region of a level.
pub(crate) fn coverage(ends: &[End], level: f64) -> f64 {
    ends.iter().filter(|end| end.level <= level).count() as f64 / ends.len() as f64
}
