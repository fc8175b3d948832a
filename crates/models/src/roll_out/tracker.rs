//! A push that is watched: what differs from push to push is learnt from its beginning.

use std::cell::RefCell;

use filter::{FilterError, Gaussian, GaussianUpdate, LinearMeasurement, PlanarSummary, Rule};
use nalgebra::{DMatrix, DVector, Matrix3, Rotation2};
use planar::{Pose, perpendicular};
use serde::{Deserialize, Serialize};

use super::push_state::{N_POSE, N_STATES};
use super::settle::{Holding, moved_by};
use super::{PushMotion, PushParticle, RollOut};
use crate::error::{not_negative, positive};
use crate::{ModelError, PathStep, PoseSeen, PushPath};

/// How what a push has drawn goes on along its way, and what its steps err by beside it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wander {
    /// The way over which what was drawn is forgotten to 1/e, in m; new draws take its place.
    pub length: f64,
    /// What steps err by besides, as standard deviations per root of the way: of the place along each axis,
    /// in √m, and of the angle, in rad/√m.
    pub scatter: [f64; 2],
}

/// The pose of a pushed object and the numbers that its push has drawn, as one Gaussian, which goes along
/// the pusher's path and learns from measured poses.
///
/// The numbers are those of the parameters that differ from push to push ([`crate::PushModel::n_drawn`]),
/// each standard normal at the start: where the center of friction is, the friction, and so on. Where the
/// object goes tells about them, and they tell where it will go.
///
/// What model, object and settings say is as in a [`RollOut`], but for its particles and the errors of
/// steps: those are the model's, independent, and what [`Wander`] adds.
#[derive(Clone)]
pub struct PushTracker<'a> {
    roll_out: RollOut<'a>,
    path: &'a PushPath,
    wander: Wander,
    rule: &'a dyn Rule,
    /// The push's start, of which all points are copies.
    first: PushParticle,
    state: Gaussian,
}

impl<'a> PushTracker<'a> {
    /// At the start of a push along a path.
    ///
    /// - `rule`: by which the Gaussian goes through the mechanics, which are asked at each of its points.
    ///
    /// # Errors
    /// As [`RollOut::run`]; `InvalidValue` for a length that is not positive, or a scatter that is negative.
    pub fn start(
        roll_out: RollOut<'a>,
        start_wb: &Pose,
        path: &'a PushPath,
        wander: Wander,
        rule: &'a dyn Rule,
    ) -> Result<Self, ModelError> {
        roll_out.check()?;
        positive("length of wandering", wander.length, "m")?;
        not_negative("scatter of places", wander.scatter[0], "m^(1/2)")?;
        not_negative("scatter of angles", wander.scatter[1], "rad/m^(1/2)")?;
        let first = roll_out.first(start_wb, path)?;
        let n_drawn = roll_out.model.n_drawn();
        let [place_sd, angle_sd] = roll_out.settings.start_sd;
        let mut mean = DVector::zeros(N_POSE + n_drawn);
        put(&mut mean, start_wb);
        let drawn = std::iter::repeat_n(1.0, n_drawn);
        let sds: Vec<f64> = [place_sd, place_sd, angle_sd].into_iter().chain(drawn).collect();
        let state = Gaussian::independent(mean, &sds)?;
        Ok(Self { roll_out, path, wander, rule, first, state })
    }

    /// The same push, of which the pose is known anew, and nothing else.
    ///
    /// # Errors
    /// `Filter` for a standard deviation that is none.
    pub fn forgetful(&self, seen: &PoseSeen) -> Result<Self, ModelError> {
        let mut mean = DVector::zeros(self.state.mean().len());
        put(&mut mean, &seen.pose_wb);
        let mut sds = vec![1.0; mean.len()];
        sds[..N_POSE].copy_from_slice(&[seen.sd[0], seen.sd[0], seen.sd[1]]);
        Ok(Self { state: Gaussian::independent(mean, &sds)?, ..self.clone() })
    }

    /// x and y in m, the angle in rad, and the numbers.
    pub fn state(&self) -> &Gaussian {
        &self.state
    }

    /// Where the object is.
    ///
    /// # Errors
    /// `Filter` if rounding left no covariance.
    pub fn pose(&self) -> Result<PlanarSummary, ModelError> {
        let mean = self.state.mean().rows(0, N_POSE).into_owned();
        let covariance = self.state.covariance().view((0, 0), (N_POSE, N_POSE)).into_owned();
        Ok(PlanarSummary::of_gaussian(&Gaussian::new(mean, covariance)?)?)
    }

    /// Learns from a measured pose.
    ///
    /// # Errors
    /// `Filter` for a pose or a standard deviation that is no number.
    pub fn update(&mut self, seen: &PoseSeen) -> Result<GaussianUpdate, ModelError> {
        let Pose { position, angle } = seen.pose_wb;
        let [place_sd, angle_sd] = seen.sd;
        let noise = Gaussian::independent(DVector::zeros(N_POSE), &[place_sd, place_sd, angle_sd])?;
        let matrix = DMatrix::identity(N_POSE, self.state.mean().len());
        let measured = DVector::from_row_slice(&[position.x, position.y, angle]);
        let seen = LinearMeasurement::new(measured, matrix, noise)?.with_angles(&[N_POSE - 1])?;
        let update = self.state.updated(&seen)?;
        self.state = update.posterior.clone();
        Ok(update)
    }

    /// Goes on by one step of the path.
    ///
    /// # Errors
    /// What the model refuses; `Filter` for a state that is no longer finite.
    pub fn predict(&mut self, step: &PathStep) -> Result<(), ModelError> {
        let (points, _) = self.state.points_of_first(self.rule, self.state.mean().len());
        let points: Vec<DVector<f64>> = points.into_iter().map(|(point, _)| point).collect();
        // The points come in the same order again.
        let moved = RefCell::new(self.moved(step, &points)?.into_iter());
        let next = |_: &DVector<f64>| {
            moved.borrow_mut().next().ok_or(FilterError::Empty { what: "points" })
        };
        let prediction = self.state.predicted_by(self.rule, next)?;
        self.state = prediction.state().clone();
        Ok(())
    }

    /// Where the object will be after some more steps.
    ///
    /// # Errors
    /// As [`PushTracker::predict`].
    pub fn ahead(&self, steps: &[PathStep]) -> Result<PlanarSummary, ModelError> {
        let mut ahead = self.clone();
        steps.iter().try_for_each(|step| ahead.predict(step))?;
        ahead.pose()
    }

    /// Points after a step, each with what the step leaves open.
    fn moved(&self, step: &PathStep, points: &[DVector<f64>]) -> Result<Vec<Gaussian>, ModelError> {
        let motion = self.roll_out.motion(step)?;
        let particle = |point: &DVector<f64>| {
            let numbers = point.iter().skip(N_POSE).copied().collect();
            let first = self.roll_out.with_draw(&self.first, self.path, numbers)?;
            let mut of_pose = DVector::zeros(N_STATES);
            of_pose.rows_mut(0, N_POSE).copy_from(&point.rows(0, N_POSE));
            Ok(motion.particle(&first, &of_pose))
        };
        let particles = points.iter().map(particle).collect::<Result<Vec<_>, ModelError>>()?;
        let way = step.distance();
        let kept = (-way / self.wander.length).exp();
        let [place, angle] = self.wander.scatter.map(|sd| sd * sd * way);
        let besides = Matrix3::from_diagonal(&[place, place, angle].into());
        let gaussian = |(point, (pose_wb, own)): (&DVector<f64>, (Pose, Matrix3<f64>))| {
            let (d, mut mean) = (point.len(), kept * point);
            put(&mut mean, &pose_wb);
            let mut covariance = (1.0 - kept * kept) * DMatrix::identity(d, d);
            covariance.view_mut((0, 0), (N_POSE, N_POSE)).copy_from(&(own + besides));
            Ok(Gaussian::new(mean, covariance)?)
        };
        points.iter().zip(motion.poses_after(&particles)?).map(gaussian).collect()
    }
}

/// Writes a pose where a state has it.
fn put(state: &mut DVector<f64>, Pose { position, angle }: &Pose) {
    (state[0], state[1], state[2]) = (position.x, position.y, *angle);
}

impl PushMotion<'_> {
    /// The mean poses of particles after the step, with the covariances that the model leaves open, in W.
    fn poses_after(
        &self,
        particles: &[PushParticle],
    ) -> Result<Vec<(Pose, Matrix3<f64>)>, ModelError> {
        let still = |one: &PushParticle| (one.pose_wb, Matrix3::zeros());
        let mut poses: Vec<_> = particles.iter().map(still).collect();
        let Some(along_w) = self.direction_w() else { return Ok(poses) };
        let (mut begun, mut inputs) = (Vec::new(), Vec::new());
        for (k, particle) in particles.iter().enumerate() {
            if let Some(begin) = self.begins(particle, &along_w)
                && let Some(input) = self.input(particle, &begin, &along_w)?
            {
                begun.push((k, begin));
                inputs.push(input);
            }
        }
        let said = self.said(begun.iter().map(|(k, _)| &particles[*k]), &inputs)?;
        let axes = Rotation2::from_basis_unchecked(&[along_w, perpendicular(&along_w)]);
        let axes = axes.matrix().to_homogeneous();
        for ((k, begin), said) in begun.iter().zip(said) {
            let held = Holding {
                outline: self.outline_of(&particles[*k]),
                center_w: self.step.end_w,
                along_w,
                gap: begin.gap,
                tolerance: self.settings.tolerance,
            };
            let drawn_wb = moved_by(&particles[*k].pose_wb, &along_w, said.mean.into());
            poses[*k] = held
                .settled_gaussian(&drawn_wb, &said.covariance, &axes)
                .unwrap_or_else(|| (drawn_wb, axes * said.covariance * axes.transpose()));
        }
        Ok(poses)
    }
}
