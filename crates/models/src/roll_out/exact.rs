//! Gaussians that go through learnt processes in closed form.

use std::sync::Arc;

use faer::Mat;
use filter::{FilterError, Gaussian, Mixture, Rule};
use gp_core::{GaussianInput, UncertainOutputs};
use nalgebra::{DMatrix, DVector, Matrix3, Rotation2, Vector3};
use planar::{Pose, perpendicular};

use super::push_state::{N_POSE, N_STATES, mean_square_size};
use super::settle::Holding;
use super::{PushMotion, PushParticle, StepErrors};
use crate::learnt::closed_form::ClosedForm;
use crate::{ModelError, Noise, PushModel, StepInput};

/// What carries the Gaussians of one push: see [`super::Matching::Exact`].
pub(super) struct Exact<'a> {
    /// One for each way of a mixture, or one.
    forms: Vec<Arc<ClosedForm>>,
    first: PushParticle,
    rule: &'a dyn Rule,
}

/// A state that is pushed from the start of a step.
struct Touching {
    state: DVector<f64>,
    weight: f64,
    input: StepInput,
}

/// The points of a Gaussian, all of them pushed, and the covariance that they keep.
struct Touched {
    all: Vec<Touching>,
    kept: DMatrix<f64>,
}

/// A part of a Gaussian that goes one way: its probability, its points, and which process says how.
struct Part {
    share: f64,
    gaussian: Gaussian,
    touched: Touched,
    edge: usize,
    form: usize,
}

impl<'a> Exact<'a> {
    /// For a model, from the start of a push.
    ///
    /// # Errors
    /// `NoClosedForm` for a model that has none.
    pub(super) fn of(
        model: &dyn PushModel,
        first: PushParticle,
        rule: &'a dyn Rule,
    ) -> Result<Self, ModelError> {
        let forms = match (model.as_mixture(), model.as_processes()) {
            (Some(mixture), _) => mixture.modes.iter().map(|(_, one)| one.closed_form()).collect(),
            (None, Some(processes)) => processes.closed_form().map(|form| vec![form]),
            (None, None) => {
                let of = format!("a model of kind {}", model.kind());
                Err(ModelError::NoClosedForm { of })
            }
        };
        Ok(Self { forms: forms?, first, rule })
    }

    /// A mixture after a step.
    ///
    /// # Errors
    /// What the model says.
    pub(super) fn moved(
        &self,
        motion: &PushMotion<'_>,
        state: &Mixture,
    ) -> Result<Mixture, ModelError> {
        let mut moved = Vec::new();
        for (component, weight) in state.components() {
            match self.parts(motion, component)? {
                Some(parts) => {
                    for part in parts {
                        let gaussian = self.carried(motion, &part)?;
                        moved.push((gaussian, weight * part.share));
                    }
                }
                None => {
                    let ways = motion.moved_by_points(&self.first, component, self.rule)?;
                    moved.extend(ways.into_iter().map(|(part, share)| (part, weight * share)));
                }
            }
        }
        Ok(Mixture::new(moved)?)
    }

    /// The points of a Gaussian; none if one of them is not pushed from the start of the step.
    fn touching(
        &self,
        motion: &PushMotion<'_>,
        gaussian: &Gaussian,
    ) -> Result<Option<Touched>, ModelError> {
        let Some(along_w) = motion.direction_w() else { return Ok(None) };
        let mut all = Vec::new();
        // The contact knows the pose, and a gap shifts it by nothing that the model sees.
        let (points, kept) = gaussian.points_of_first(self.rule, N_POSE);
        for (state, weight) in points {
            let particle = motion.particle(&self.first, &state);
            let begin = motion.begins(&particle, &along_w).filter(|_| particle.touches());
            let Some(begin) = begin else { return Ok(None) };
            let Some(input) = motion.input(&particle, &begin, &along_w)? else { return Ok(None) };
            if input.distance() < motion.step.distance() {
                return Ok(None);
            }
            all.push(Touching { state, weight, input });
        }
        Ok(Some(Touched { all, kept }))
    }

    /// The parts of a Gaussian by edge, and by the ways of a mixture; none if it may not touch.
    ///
    /// A process is smooth where the contact begins to slip: there is nothing to tell apart.
    fn parts(
        &self,
        motion: &PushMotion<'_>,
        gaussian: &Gaussian,
    ) -> Result<Option<Vec<Part>>, ModelError> {
        let Some(Touched { all, .. }) = self.touching(motion, gaussian)? else { return Ok(None) };
        let n_edges = motion.pushed.shape.n_edges() as i64;
        let base = all[0].input.edge() as i64;
        let ahead = |one: &Touching| {
            let ahead = (one.input.edge() as i64 - base).rem_euclid(n_edges);
            if 2 * ahead > n_edges { ahead - n_edges } else { ahead }
        };
        // The points come in the same order again.
        let mut next = all.iter().map(ahead);
        let edge = |_: &DVector<f64>| Ok::<_, ModelError>(next.next().unwrap_or(0));
        let mut parts = Vec::new();
        for (ahead, share, gaussian) in gaussian.split(self.rule, N_POSE, edge)? {
            let edge = (base + ahead).rem_euclid(n_edges) as usize;
            let Some(touched) = self.touching(motion, &gaussian)? else { return Ok(None) };
            let part = Part { share, gaussian, touched, edge, form: 0 };
            if motion.model.as_mixture().is_none() {
                parts.push(part);
                continue;
            }
            let Some(modes) = self.modes(motion, &part)? else { return Ok(None) };
            parts.extend(modes);
        }
        Ok(Some(parts))
    }

    /// A part once more by the ways of a mixture; none if one of them may not touch.
    fn modes(
        &self,
        motion: &PushMotion<'_>,
        whole: &Part,
    ) -> Result<Option<Vec<Part>>, ModelError> {
        let Touched { all, kept } = &whole.touched;
        let inputs: Vec<StepInput> = all.iter().map(|one| one.input.clone()).collect();
        let Some(mixture) = motion.model.as_mixture() else { return Ok(None) };
        let said = mixture.ways(&inputs, Noise::Excluded)?;
        let mut parts = Vec::new();
        for form in 0..self.forms.len() {
            let points = all.iter().zip(&said);
            let points: Vec<(DVector<f64>, f64)> = points
                .map(|(one, said)| (one.state.clone(), one.weight * said.modes[form].1))
                .collect();
            let share: f64 = points.iter().map(|(_, share)| share).sum();
            if share < LEAST_SHARE {
                continue;
            }
            let gaussian = match 1.0 - share < LEAST_SHARE {
                true => whole.gaussian.clone(),
                false => Gaussian::of_points(&points, kept)?,
            };
            let Some(touched) = self.touching(motion, &gaussian)? else { return Ok(None) };
            let (share, edge) = (whole.share * share, whole.edge);
            parts.push(Part { share, gaussian, touched, edge, form });
        }
        Ok(Some(parts))
    }

    /// A part after the step.
    fn carried(&self, motion: &PushMotion<'_>, part: &Part) -> Result<Gaussian, ModelError> {
        let form = &self.forms[part.form];
        let mut points = Vec::new();
        let all = &part.touched.all;
        let on_edge = |one: &&Touching| one.input.edge() == part.edge;
        // A part that is narrow about an end of the edge may have no point on it.
        let any = all.iter().any(|one| on_edge(&one));
        for one in all.iter().filter(|one| !any || on_edge(one)) {
            points.push((one, DVector::from_vec(form.inputs(&one.input)?)));
        }
        let inputs = Inputs::of(&points);
        let outputs = form.at(&inputs.gaussian()?)?;
        motion.pushed_on(&self.first, part, (&inputs, &outputs, form.noise), self.rule)
    }
}

/// Less probable ways are left out.
const LEAST_SHARE: f64 = 1e-9;

fn zeros(n: usize) -> DMatrix<f64> {
    DMatrix::zeros(n, n)
}

/// The Gaussian of a process' inputs, and their covariance with the state.
struct Inputs {
    mean: DVector<f64>,
    covariance: DMatrix<f64>,
    with_state: DMatrix<f64>,
}

impl Inputs {
    /// The moments of weighted points.
    fn of(points: &[(&Touching, DVector<f64>)]) -> Self {
        let total: f64 = points.iter().map(|(one, _)| one.weight).sum();
        let n = points[0].1.len();
        let (mut mean, mut state) = (DVector::zeros(n), DVector::zeros(N_STATES));
        for (one, input) in points {
            mean.axpy(one.weight / total, input, 1.0);
            state.axpy(one.weight / total, &one.state, 1.0);
        }
        let (mut covariance, mut with_state) = (zeros(n), DMatrix::zeros(N_STATES, n));
        for (one, input) in points {
            let (off, off_state) = (input - &mean, &one.state - &state);
            covariance.ger(one.weight / total, &off, &off, 1.0);
            with_state.ger(one.weight / total, &off_state, &off, 1.0);
        }
        Self { mean, covariance, with_state }
    }

    fn gaussian(&self) -> Result<GaussianInput, ModelError> {
        let n = self.mean.len();
        let covariance = Mat::from_fn(n, n, |i, j| self.covariance[(i, j)]);
        let gaussian = GaussianInput::new(self.mean.iter().copied().collect(), covariance);
        gaussian.map_err(crate::steps::prediction::of_output(0))
    }
}

impl PushMotion<'_> {
    /// A Gaussian of states moved by what processes say of it, with the contact that holds.
    fn pushed_on(
        &self,
        first: &PushParticle,
        part: &Part,
        (inputs, outputs, noise): (&Inputs, &UncertainOutputs, [f64; 3]),
        rule: &dyn Rule,
    ) -> Result<Gaussian, ModelError> {
        let way = self.step.distance();
        let Some(along_w) = self.direction_w() else { return Ok(part.gaussian.clone()) };
        let axes = Rotation2::from_basis_unchecked(&[along_w, perpendicular(&along_w)]);
        let axes: Matrix3<f64> = axes.matrix().to_homogeneous();
        let variance = match self.settings.errors {
            StepErrors::None => Vector3::zeros(),
            StepErrors::Independent | StepErrors::Held(_) => {
                Vector3::from_fn(|k, _| way * way * (outputs.variance[k] + noise[k]))
            }
        };
        let drawn = self.drawn(&part.gaussian, (inputs, outputs), &(way * axes), &variance)?;
        let nominal = first.contact_gap.unwrap_or(0.0);
        let covariance = Matrix3::from_diagonal(&variance);
        let settled = |point: DVector<f64>| {
            let held = Holding {
                outline: &self.outline,
                center_w: self.step.end_w,
                along_w,
                gap: nominal + point[N_POSE],
                tolerance: self.settings.tolerance,
            };
            let drawn_wb = Pose::new(point[0], point[1], point[2]);
            let pose_wb = held.settled(&drawn_wb, &covariance).unwrap_or(drawn_wb);
            let mut mean = point;
            (mean[0], mean[1]) = (pose_wb.position.x, pose_wb.position.y);
            mean[2] = pose_wb.angle;
            mean
        };
        // Contact knows the pose and the gap.
        let (points, kept) = drawn.points_of_first(rule, N_POSE + 1);
        let points: Vec<_> =
            points.into_iter().map(|(point, weight)| (settled(point), weight)).collect();
        Ok(Gaussian::of_points(&points, &kept)?)
    }

    /// States and outputs together are Gaussian, and the state after the draw is linear in them.
    ///
    /// - `by_way`: turns outputs per meter of way into W, for the step's way; - `variance`: of a draw
    ///   along the pusher's motion, its left normal, and of the turn.
    fn drawn(
        &self,
        state: &Gaussian,
        (inputs, outputs): (&Inputs, &UncertainOutputs),
        by_way: &Matrix3<f64>,
        variance: &Vector3<f64>,
    ) -> Result<Gaussian, FilterError> {
        let (n, slopes) = (N_STATES + N_POSE, &outputs.slopes);
        let slopes = DMatrix::from_fn(slopes.nrows(), N_POSE, |i, a| slopes[(i, a)]);
        // By Stein's lemma.
        let with_state = &inputs.with_state * slopes;
        let mut joint = zeros(n);
        joint.view_mut((0, 0), (N_STATES, N_STATES)).copy_from(state.covariance());
        joint.view_mut((0, N_STATES), (N_STATES, N_POSE)).copy_from(&with_state);
        joint.view_mut((N_STATES, 0), (N_POSE, N_STATES)).copy_from(&with_state.transpose());
        let of_means = |a: usize, b: usize| {
            outputs.covariance[(a, b)] - if a == b { outputs.variance[a] } else { 0.0 }
        };
        let of_means = DMatrix::from_fn(N_POSE, N_POSE, of_means);
        joint.view_mut((N_STATES, N_STATES), (N_POSE, N_POSE)).copy_from(&of_means);

        let (held, own) = match &self.settings.errors {
            StepErrors::None => (Vector3::zeros(), Vector3::zeros()),
            StepErrors::Independent => (Vector3::zeros(), Vector3::repeat(1.0)),
            StepErrors::Held(shares) => {
                (Vector3::from(shares.held), mean_square_size(state) * Vector3::from(shares.own))
            }
        };
        let axes = by_way / self.step.distance();
        let of_held = axes * Matrix3::from_diagonal(&variance.component_mul(&held).map(f64::sqrt));
        let mut linear = DMatrix::identity(N_STATES, n);
        linear.view_mut((0, N_STATES), (N_POSE, N_POSE)).copy_from(by_way);
        linear.view_mut((0, N_POSE + 1), (N_POSE, N_POSE)).copy_from(&of_held);
        let mut covariance = &linear * joint * linear.transpose();
        let own = axes * Matrix3::from_diagonal(&variance.component_mul(&own)) * axes.transpose();
        let mut of_pose = covariance.view_mut((0, 0), (N_POSE, N_POSE));
        of_pose += own;
        let covariance = 0.5 * (&covariance + covariance.transpose());

        let said = DVector::from_row_slice(&outputs.mean);
        let mean = DVector::from_iterator(n, state.mean().iter().chain(&said).copied());
        Gaussian::new(linear * mean, covariance)
    }
}
