//! What is measured while an object is pushed.

use std::collections::HashMap;

use anyhow::Result;
use dataset::{Flags, Table};
use effects::TrueOutline;
use filter::{
    DifferentiableMeasurement, FilterError, Gaussian, GaussianMeasurement, LinearMeasurement,
    MeasurementModel,
};
use models::{ForceSeen, PoseSeen, PushParticle, PushPath, RecordedPush, RollOut};
use nalgebra::{DMatrix, DVector, Vector2};
use planar::{Pose, perpendicular};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::figures::inputs::SEED;

/// What a filter has to go by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Task {
    /// Rare and noisy poses.
    Capture,
    /// The contact force at every step, and a start that is wrong.
    Force,
}

/// Motion capture a hundred times as noisy as that of the recordings, in m and rad.
const CAPTURE_SD: [f64; 2] = [2e-3, 0.04];
/// It reports after every so many steps.
const EVERY: usize = 3;
/// How far objects are turned that a filter with force alone begins with, in rad; and how sure it is.
const TURNED: f64 = 0.1;
const TURNED_SD: [f64; 2] = [1e-3, TURNED];
/// Of the direction of a force, in rad.
const FORCE_SD: f64 = 0.03;
/// A smaller force is none, in N.
const LEAST_FORCE: f64 = 0.3;

impl Task {
    pub(super) const ALL: [Self; 2] = [Self::Capture, Self::Force];

    pub(super) fn id(self) -> &'static str {
        match self {
            Self::Capture => "capture",
            Self::Force => "force",
        }
    }

    /// How well the start is known, in m and rad.
    pub(super) fn start_sd(self) -> [f64; 2] {
        match self {
            Self::Capture => [0.0; 2],
            Self::Force => TURNED_SD,
        }
    }
}

/// The forces of all pushes, by recording and number as in their names.
pub(super) struct Tasks {
    /// Where the pusher's center was when a step began, and the mean force over it, in W.
    forces: HashMap<String, Vec<[Vector2<f64>; 2]>>,
    friction: f64,
}

/// What is seen of a push.
pub(super) struct Seen<'a> {
    pub(super) start_wb: Pose,
    /// At the start, and after each step.
    pub(super) measured: Vec<Option<Measured<'a>>>,
}

/// One measurement.
#[derive(Clone, Copy)]
pub(super) enum Measured<'a> {
    Pose(PoseSeen),
    Force(ForceSeen<'a>),
}

impl Tasks {
    pub(super) fn of(table: &Table, friction: f64) -> Self {
        let mut forces: HashMap<String, Vec<[Vector2<f64>; 2]>> = HashMap::new();
        for row in table.rows.iter().filter(|row| !row.flags.contains(Flags::UNTARED)) {
            let Some(force) = row.force else { continue };
            let normal = row.contact_normal;
            let force_w =
                force.mean.normal * normal + force.mean.tangential * perpendicular(&normal);
            let push = format!("{}#{}", row.recording, row.push);
            forces.entry(push).or_default().push([row.pusher_start, force_w]);
        }
        Self { forces, friction }
    }

    /// What is seen of a push, which is the so many-th; nothing where no force was measured, or none whose
    /// zero is known.
    pub(super) fn seen<'a>(
        &self,
        task: Task,
        push: &'a RecordedPush,
        number: usize,
    ) -> Option<Seen<'a>> {
        match task {
            Task::Capture => Some(captured(push, number)),
            Task::Force => self.felt(push, number),
        }
    }

    fn felt<'a>(&self, push: &'a RecordedPush, number: usize) -> Option<Seen<'a>> {
        let forces = self.forces.get(&push.name)?;
        let mut start_wb = push.poses_wb[0];
        start_wb.angle += if number.is_multiple_of(2) { TURNED } else { -TURNED };
        let points = push.path.points();
        let measured = points.iter().map(|(_, center_w)| {
            // The force over the step that begins here.
            let [_, force_w] = forces.iter().find(|[start, _]| start == center_w)?;
            Some(Measured::Force(ForceSeen {
                pushed: &push.pushed,
                center_w: *center_w,
                force_w: *force_w,
                friction: self.friction,
                angle_sd: FORCE_SD,
                threshold: LEAST_FORCE,
            }))
        });
        Some(Seen { start_wb, measured: measured.collect() })
    }
}

fn captured(push: &RecordedPush, number: usize) -> Seen<'_> {
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    random.set_stream(number as u64);
    let measured = push.poses_wb.iter().enumerate().map(|(k, truth)| {
        let noise: [f64; 3] = std::array::from_fn(|_| random.sample(StandardNormal));
        let [place_sd, angle_sd] = CAPTURE_SD;
        let pose_wb = Pose::new(
            truth.position.x + place_sd * noise[0],
            truth.position.y + place_sd * noise[1],
            truth.angle + angle_sd * noise[2],
        );
        let is_seen = k > 0 && k.is_multiple_of(EVERY);
        is_seen.then_some(Measured::Pose(PoseSeen { pose_wb, sd: CAPTURE_SD }))
    });
    Seen { start_wb: push.poses_wb[0], measured: measured.collect() }
}

/// For particles: of poses a density, of forces a likelihood up to a factor.
impl MeasurementModel for Measured<'_> {
    type State = PushParticle;

    fn log_likelihood(&self, state: &PushParticle) -> f64 {
        match self {
            Self::Pose(seen) => {
                let [place_sd, angle_sd] = seen.sd;
                let size = 1.5 * std::f64::consts::TAU.ln() + 2.0 * place_sd.ln() + angle_sd.ln();
                seen.log_likelihood(state) - size
            }
            Self::Force(seen) => seen.log_likelihood(state),
        }
    }
}

/// The direction of a felt force as a Gaussian has it: that of the contact's normal, give or take the cone
/// of friction.
pub(super) struct Direction<'a> {
    seen: ForceSeen<'a>,
    angle: DVector<f64>,
    noise: Gaussian,
}

impl<'a> Direction<'a> {
    /// None of a force that is too small to have one.
    ///
    /// # Errors
    /// For a friction that is no number.
    pub(super) fn of(seen: ForceSeen<'a>) -> Result<Option<Self>> {
        if seen.force_w.norm() <= seen.threshold {
            return Ok(None);
        }
        // A direction anywhere in the cone has a third of the square of its half angle as variance.
        let sd = seen.angle_sd.hypot(seen.friction.atan() / 3_f64.sqrt());
        let noise = Gaussian::independent(DVector::zeros(1), &[sd])?;
        let angle = DVector::from_element(1, seen.force_w.y.atan2(seen.force_w.x));
        Ok(Some(Self { seen, angle, noise }))
    }
}

impl GaussianMeasurement for Direction<'_> {
    type State = DVector<f64>;

    fn measured(&self) -> &DVector<f64> {
        &self.angle
    }

    fn noise(&self) -> &Gaussian {
        &self.noise
    }

    fn expected(&self, state: &DVector<f64>) -> Result<DVector<f64>, FilterError> {
        let pose_wb = Pose::new(state[0], state[1], state[2]);
        let center_b = pose_wb.inverse_transform_point(&self.seen.center_w);
        let contact = self.seen.pushed.shape.contact(&center_b, self.seen.pushed.pusher_radius);
        let normal_w = pose_wb.rotate(&contact.normal);
        Ok(DVector::from_element(1, normal_w.y.atan2(normal_w.x)))
    }

    fn angles(&self) -> &[usize] {
        &[0]
    }
}

impl DifferentiableMeasurement for Direction<'_> {
    /// The normal of an edge turns with the object, and knows no place.
    fn jacobian(&self, state: &DVector<f64>) -> Result<DMatrix<f64>, FilterError> {
        Ok(DMatrix::from_fn(1, state.len(), |_, k| if k == 2 { 1.0 } else { 0.0 }))
    }
}

/// That the pusher touches at the start: the gap of a state is the one that contact holds.
pub(super) struct Touch {
    outline: TrueOutline,
    center_w: Vector2<f64>,
    held: DVector<f64>,
    noise: Gaussian,
}

/// To which the gap is known where they touch, in m.
const TOUCH_SD: f64 = 1e-4;

impl Touch {
    /// # Errors
    /// For an outline that the model has not.
    pub(super) fn of(roll_out: &RollOut<'_>, start_wb: &Pose, path: &PushPath) -> Result<Self> {
        let outline = roll_out.model.true_outline(roll_out.pushed)?;
        let (center_w, gap) = (path.start_w(), roll_out.settings.gap);
        let held = gap.offset + gap.kept * outline.gap(start_wb, &center_w);
        let noise = Gaussian::independent(DVector::zeros(1), &[TOUCH_SD])?;
        Ok(Self { outline, center_w, held: DVector::from_element(1, held), noise })
    }
}

impl GaussianMeasurement for Touch {
    type State = DVector<f64>;

    fn measured(&self) -> &DVector<f64> {
        &self.held
    }

    fn noise(&self) -> &Gaussian {
        &self.noise
    }

    fn expected(&self, state: &DVector<f64>) -> Result<DVector<f64>, FilterError> {
        let pose_wb = Pose::new(state[0], state[1], state[2]);
        let gap = self.outline.gap(&pose_wb, &self.center_w);
        Ok(DVector::from_element(1, gap - state[3]))
    }
}

/// A pose as Gaussians have it.
///
/// # Errors
/// For numbers that are none.
pub(super) fn linear(seen: &PoseSeen, n_states: usize) -> Result<LinearMeasurement> {
    let Pose { position, angle } = seen.pose_wb;
    let [place_sd, angle_sd] = seen.sd;
    let noise = Gaussian::independent(DVector::zeros(3), &[place_sd, place_sd, angle_sd])?;
    let measured = DVector::from_vec(vec![position.x, position.y, angle]);
    Ok(LinearMeasurement::new(measured, DMatrix::identity(3, n_states), noise)?
        .with_angles(&[2])?)
}
