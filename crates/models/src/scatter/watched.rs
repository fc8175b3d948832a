//! How sure a model may be of pushes that are watched.

use filter::{PlanarSummary, Simplex};
use nalgebra::{Matrix3, Vector3};
use planar::wrap_angle;
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};
use serde::Serialize;

use crate::{
    Calibration, Description, ModelError, PathStep, PoseSeen, PushModel, PushTracker, RecordedPush,
    RollOut, RollOutSettings, Setup, Wander,
};

/// How what differs from push to push shows while a push is watched, as recorded ones showed it
/// ([`Description::watched`]).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Watched {
    /// Pushes that it was measured on.
    pub n_pushes: usize,
    /// So many times as wide as in the model is what differs from push to push.
    pub widened: f64,
    /// How it goes on along the way.
    pub wander: Wander,
    /// So many times as large are the covariances of ends, foreseen with what was learnt and without, that nine in
    /// ten regions of 90 % hold them.
    pub scale: [f64; 2],
    /// The factors with which the region of 90 % would just hold each end, sorted, with what was learnt and
    /// without: ends are not normal, most are near and a few far off.
    #[serde(skip)]
    pub factors: [Vec<f64>; 2],
    /// Pushes that the model could go along, of which these factors are.
    pub n_ends: usize,
    /// Log density of every measured pose given those before it, in nats.
    pub log_evidence: f64,
}

/// Fewer pushes do not tell how much they differ.
const FEWEST: usize = 8;
/// More are not watched, but an even choice of them.
const MOST: usize = 30;
/// Where the search begins: factor on the spreads, length in m, scatter of places in √m.
const BEGIN: [f64; 3] = [0.7, 0.3, 3e-4];
/// Each is changed by such a factor, then by its root, as long as it helps.
const FACTORS: [f64; 2] = [2.0, std::f64::consts::SQRT_2];
/// Searches end after so many rounds at the latest.
const MOST_ROUNDS: usize = 8;

impl Description {
    /// The model with such spreads, and how they wander, that the measured poses of recorded pushes are most
    /// probable, each given those before it: the largest evidence, by a pattern search.
    ///
    /// Steps scatter alike in place and in angle at the outline's mean distance from the origin. Then the ends
    /// of all these pushes are foreseen after a share of the way, which tells how far off they are.
    ///
    /// # Errors
    /// `TooFewPushes` for fewer than eight, or fewer than eight that the model can go along; what the model
    /// refuses.
    pub fn watched(
        &self,
        setup: &Setup,
        pushes: &[RecordedPush],
        after: f64,
    ) -> Result<Watched, ModelError> {
        let n_pushes = pushes.len().min(MOST);
        if n_pushes < FEWEST {
            return Err(ModelError::TooFewPushes { n_pushes, needed: FEWEST });
        }
        let chosen: Vec<&RecordedPush> =
            (0..n_pushes).map(|k| &pushes[k * pushes.len() / n_pushes]).collect();
        let shape = &chosen[0].pushed.shape;
        let arm = shape.mean_distance(&nalgebra::Vector2::zeros());
        let of = |at: &[f64; 3]| -> Result<Watched, ModelError> {
            let [widened, length, scatter] = *at;
            let wander = Wander { length, scatter: [scatter, scatter / arm] };
            let wider = Calibration { widened: Some(widened), ..Calibration::default() };
            let model = self.with(&wider)?.build_in(setup.support, &setup.own)?;
            let one = |push: &&RecordedPush| evidence(model.as_ref(), push, wander);
            let evidences: Vec<Result<f64, ModelError>> = chosen.par_iter().map(one).collect();
            let log_evidence = evidences.into_iter().sum::<Result<f64, ModelError>>()?;
            let (scale, factors) = ([1.0; 2], [Vec::new(), Vec::new()]);
            Ok(Watched { n_pushes, widened, wander, scale, factors, n_ends: 0, log_evidence })
        };
        let (mut at, mut best) = (BEGIN, of(&BEGIN)?);
        for factor in FACTORS {
            for _ in 0..MOST_ROUNDS {
                let before = at;
                for k in 0..at.len() {
                    for by in [factor, 1.0 / factor] {
                        let mut there = at;
                        there[k] *= by;
                        // What some push cannot be watched with is no candidate.
                        let better = of(&there).ok();
                        if let Some(better) =
                            better.filter(|new| new.log_evidence > best.log_evidence)
                        {
                            (at, best) = (there, better);
                            break;
                        }
                    }
                }
                if at == before {
                    break;
                }
            }
        }
        let model = self.with(&best.calibration())?.build_in(setup.support, &setup.own)?;
        let one = |push: &RecordedPush| push.foreseen(model.as_ref(), best.wander, after);
        let ends: Vec<Result<[PlanarSummary; 2], ModelError>> =
            pushes.par_iter().map(one).collect();
        // A push that the model refuses tells nothing: it is counted out.
        let known = pushes.iter().zip(ends).filter_map(|(push, ends)| Some((push, ends.ok()?)));
        let known: Vec<(&RecordedPush, [PlanarSummary; 2])> = known.collect();
        let n_ends = known.len();
        if n_ends < FEWEST {
            return Err(ModelError::TooFewPushes { n_pushes: n_ends, needed: FEWEST });
        }
        let factors = [0, 1].map(|k| {
            let mut all: Vec<f64> =
                known.iter().map(|(push, ends)| push.widening(&ends[k])).collect();
            all.sort_by(f64::total_cmp);
            all
        });
        let scale = [0, 1].map(|k| nine_in_ten(&factors[k]));
        Ok(Watched { scale, factors, n_ends, ..best })
    }
}

impl Watched {
    /// The spreads, as [`Description::with`] takes them.
    pub fn calibration(&self) -> Calibration {
        Calibration { widened: Some(self.widened), ..Calibration::default() }
    }

    /// The levels of the regions that just do not hold the measured end of a push, foreseen as by
    /// [`RecordedPush::foreseen`]: the shares of the other pushes that such regions would hold. An end is
    /// within the region of a larger level; beyond what any other push needed the level is 1.
    pub fn levels(&self, push: &RecordedPush, foreseen: &[PlanarSummary; 2]) -> [f64; 2] {
        [0, 1].map(|k| {
            let (factors, own) = (&self.factors[k], push.widening(&foreseen[k]));
            let n_nearer = factors.partition_point(|factor| *factor < own);
            if n_nearer == factors.len() {
                1.0
            } else {
                n_nearer as f64 / (factors.len() + 1) as f64
            }
        })
    }
}

/// χ² of three degrees of freedom is below it in nine cases of ten.
const NINE_IN_TEN: f64 = 6.251_388_631_170_325;
/// No region is made wider or narrower by a larger factor.
const MOST_WIDENED: f64 = 1e9;

/// The factor that suffices for nine in ten of one more than these pushes, as in conformal prediction.
fn nine_in_ten(sorted: &[f64]) -> f64 {
    let place = (0.9 * (sorted.len() + 1) as f64).ceil() as usize;
    let reached = sorted.get(place.min(sorted.len()).saturating_sub(1));
    reached.copied().unwrap_or(1.0)
}

/// The log density of a push's measured poses, each given those before it.
fn evidence(model: &dyn PushModel, push: &RecordedPush, wander: Wander) -> Result<f64, ModelError> {
    let settings = push.watched_settings();
    let roll_out = RollOut { model, pushed: &push.pushed, settings: &settings };
    let mut tracker =
        PushTracker::start(roll_out, &push.poses_wb[0], &push.path, wander, &Simplex)?;
    let steps = push.path.steps(settings.step)?;
    let mut sum = 0.0;
    for (step, pose_wb) in steps.iter().zip(&push.poses_wb[1..]) {
        tracker.predict(step)?;
        sum += tracker.update(&PoseSeen { pose_wb: *pose_wb, sd: push.pose_sd[0] })?.log_evidence;
    }
    Ok(sum)
}

impl RecordedPush {
    /// Where the push ends, foreseen after a share of its way ([`RecordedPush::watched_steps`]): with what was
    /// learnt until then, and without.
    ///
    /// # Errors
    /// As [`PushTracker::predict`].
    pub fn foreseen(
        &self,
        model: &dyn PushModel,
        wander: Wander,
        after: f64,
    ) -> Result<[PlanarSummary; 2], ModelError> {
        let settings = self.watched_settings();
        let roll_out = RollOut { model, pushed: &self.pushed, settings: &settings };
        let mut tracker =
            PushTracker::start(roll_out, &self.poses_wb[0], &self.path, wander, &Simplex)?;
        let steps = self.path.steps(settings.step)?;
        let (n_seen, _) = Self::watched_steps(&steps, after);
        let seen = |k: usize| PoseSeen { pose_wb: self.poses_wb[k], sd: self.pose_sd[0] };
        for (k, step) in steps.iter().enumerate().take(n_seen) {
            tracker.predict(step)?;
            tracker.update(&seen(k + 1))?;
        }
        let without = tracker.forgetful(&seen(n_seen))?;
        Ok([tracker.ahead(&steps[n_seen..])?, without.ahead(&steps[n_seen..])?])
    }

    /// How many steps are watched until a share of the way is gone, one at least and not all; and the share that
    /// they are.
    pub fn watched_steps(steps: &[PathStep], after: f64) -> (usize, f64) {
        let way: f64 = steps.iter().map(PathStep::distance).sum();
        let (mut gone, mut n_seen) = (0.0, 0);
        for step in &steps[..steps.len().saturating_sub(1)] {
            if n_seen > 0 && gone >= after * way {
                break;
            }
            gone += step.distance();
            n_seen += 1;
        }
        (n_seen, gone / way)
    }

    /// The factor on a foreseen covariance with which the measured end is on the border of the region of
    /// 90 %: the end's own noise stays as it is.
    fn widening(&self, foreseen: &PlanarSummary) -> f64 {
        let end = &self.poses_wb[self.poses_wb.len() - 1];
        let turn = wrap_angle(end.angle - foreseen.mean.z);
        let off =
            Vector3::new(end.position.x - foreseen.mean.x, end.position.y - foreseen.mean.y, turn);
        let [place_sd, angle_sd] = self.pose_sd[1];
        let own = Vector3::new(place_sd, place_sd, angle_sd).map(|sd| sd * sd);
        let is_within = |factor: f64| {
            let covariance = factor * foreseen.covariance + Matrix3::from_diagonal(&own);
            let square = covariance.cholesky().map(|root| off.dot(&root.solve(&off)));
            square.is_some_and(|square| square <= NINE_IN_TEN)
        };
        let (mut low, mut high) = (-MOST_WIDENED.ln(), MOST_WIDENED.ln());
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if is_within(middle.exp()) { high = middle } else { low = middle }
        }
        high.exp()
    }

    /// Settings with which a push of recorded steps is watched from its start, with its steps as they are.
    pub fn watched_settings(&self) -> RollOutSettings {
        let longest = self.steps.iter().map(|step| step.input.distance()).fold(0.0, f64::max);
        RollOutSettings {
            start_sd: self.pose_sd[0],
            touching: true,
            step: 1.01 * longest,
            ..RollOutSettings::default()
        }
    }
}
