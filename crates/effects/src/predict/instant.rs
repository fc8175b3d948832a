//! What moves the object at one moment.

use std::cell::OnceCell;
use std::sync::Arc;

use mechanics::{ContactMode, Ellipsoid, MechanicsError};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use planar::{Contact, Pose, Twist, cross, perpendicular};

use crate::effect::{Snapshot, Stage};
use crate::error::positive;
use crate::object::pressure::Pressure;
use crate::object::spots::Spots;
use crate::predict::area_friction::{ellipsoid, turning_ratio};
use crate::predict::balance::{
    Balance, ContactKinematics, ContactSolution, closed_form, is_sliding,
};
use crate::predict::friction::Friction;
use crate::{ContactLaw, EffectError, PushPhysics, StepInput, Support};

/// The model at one pose and time of a step.
pub(crate) struct ForceBalance<'a> {
    pub(crate) physics: &'a PushPhysics,
    pub(crate) step: &'a StepInput,
    pub(crate) spots: Option<&'a Spots>,
    pub(crate) pose_wo: Pose,
    /// From axes of the outline to those of W.
    pub(crate) turn_wo: Matrix2<f64>,
    time: f64,
    pub(crate) support: Support,
    /// The support's [`turning_ratio`], once it was asked for.
    turning: OnceCell<f64>,
    /// Center of friction, in m, frame of the outline.
    pub(crate) center: Vector2<f64>,
    /// Largest friction force, in N.
    pub(crate) f_max: f64,
    /// Loads besides the pusher's per `f_max`, about the center of friction, axes of the outline.
    pub(crate) external: Vector3<f64>,
}

/// Motion and contact force of a moment.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rate {
    pub(crate) mode: ContactMode,
    /// Motion of the outline's origin, or with inertia of the center of mass, axes of W.
    pub(crate) twist_w: Twist,
    /// Contact force on the object, in N, axes of the outline.
    pub(crate) force_o: Vector2<f64>,
}

/// What one moment hands on to the next, to be faster.
#[derive(Clone, Debug, Default)]
pub(crate) struct Memory {
    ellipsoid: Option<(Support, Ellipsoid)>,
    pub(crate) pressure: Option<Arc<Pressure>>,
    /// The last answer and the one before, with their times.
    answers: [Option<(f64, ContactSolution)>; 2],
}

impl Memory {
    fn keep(&mut self, time: f64, answer: ContactSolution) {
        self.answers = [Some((time, answer)), self.answers[0]];
    }

    /// Where the last answers lead to at a time; none after a separation.
    fn foreseen(&self, time: f64) -> Option<ContactSolution> {
        let (last_time, last) =
            self.answers[0].filter(|(_, a)| a.mode != ContactMode::Separated)?;
        let before = self.answers[1].filter(|(at, a)| a.mode == last.mode && *at < last_time);
        let motion = before.map_or(last.motion, |(at, before)| {
            let ahead = (time - last_time) / (last_time - at);
            last.motion + ahead * (last.motion - before.motion)
        });
        Some(ContactSolution { motion, ..last })
    }
}

/// Speeds of a runaway that are tried, in the pusher's.
const FASTER: [f64; 4] = [1.0, 4.0, 16.0, 64.0];
/// Speed below which squares of velocities may underflow, in m/s.
const SLOWEST: f64 = 1e-60;

impl<'a> ForceBalance<'a> {
    pub(crate) fn new(
        physics: &'a PushPhysics,
        (step, spots): (&'a StepInput, Option<&'a Spots>),
        pose_wo: &Pose,
        time: f64,
        lean_o: &Vector2<f64>,
    ) -> Result<Self, EffectError> {
        let moment = Snapshot { rig: physics.rig(), step, pose_wo: *pose_wo, time };
        let mut support = physics.support(&moment).checked()?;
        support.center_o += lean_o;
        let of_spots = spots.map_or_else(Vector2::zeros, |spots| spots.center);
        let center = step.object.centroid() + of_spots + support.center_o;
        let nominal = physics.rig().nominal_force(step.object.mass());
        let f_max = nominal * (support.friction / physics.rig().support_friction());
        positive("the largest force of friction with the table", f_max, "N")?;
        let (sin, cos) = pose_wo.angle.sin_cos();
        let turn_wo = Matrix2::new(cos, -sin, sin, cos);
        let external = if physics.acts_at(Stage::Load) {
            let load_w = physics.load(&moment);
            let force = turn_wo.tr_mul(&load_w.force);
            let torque = load_w.torque - cross(&center, &force);
            Vector3::new(force.x, force.y, torque) / f_max
        } else {
            Vector3::zeros()
        };
        let (pose_wo, turning) = (*pose_wo, OnceCell::new());
        Ok(Self {
            physics,
            step,
            spots,
            pose_wo,
            turn_wo,
            time,
            support,
            turning,
            center,
            f_max,
            external,
        })
    }

    /// A contact in the outline's frame, whose force acts at a point there, with a pusher that has a
    /// velocity in W.
    pub(crate) fn touch(
        &self,
        contact: &Contact,
        acting_o: &Vector2<f64>,
        velocity_w: &Vector2<f64>,
    ) -> ContactKinematics {
        let velocity = self.turn_wo.tr_mul(velocity_w);
        let [point, acting] = [&contact.point, acting_o].map(|place| place - self.center);
        ContactKinematics { point, acting, normal: contact.normal, velocity }
    }

    /// The quasi-static motion.
    pub(crate) fn pushed(
        &self,
        touch: &ContactKinematics,
        law: &ContactLaw,
        memory: &mut Memory,
    ) -> Result<Rate, EffectError> {
        if memory.answers[0].is_none() {
            self.refuse_sliding_by_itself(memory)?;
        }
        if touch.approach() <= 0.0 {
            return Ok(self.rate(&ContactSolution::AT_REST));
        }
        let speed = touch.velocity.amax();
        if speed < SLOWEST {
            // The push scales with its speed.
            let scale = 2.0 * SLOWEST / speed;
            let faster = ContactKinematics { velocity: scale * touch.velocity, ..*touch };
            let rate = self.pushed(&faster, law, memory)?;
            return Ok(Rate { twist_w: 1.0 / scale * rate.twist_w, ..rate });
        }
        let guess = self.guess(touch, law, memory)?;
        let local = self.local(&guess.motion);
        let is_closed = self.is_quadric()
            && law.static_ratio == 1.0
            && !law.is_caught()
            && touch.acting == touch.point
            && self.external == Vector3::zeros();
        let answer = if is_closed && local.is_none() {
            closed_form(&self.ellipsoid(memory)?, touch, law)?
        } else {
            let friction = self.friction(local, memory)?;
            let found = self.balance(&friction, None).touched(touch, law, &guess);
            found.map_err(|error| self.runaway(touch, memory).unwrap_or(error))?
        };
        memory.keep(self.time, answer);
        Ok(self.rate(&answer))
    }

    /// Why there is no push of an object that rests but slides by itself at the pusher's speed, or at one that
    /// it reaches while it turns.
    fn runaway(&self, touch: &ContactKinematics, memory: &mut Memory) -> Option<EffectError> {
        if self.external == Vector3::zeros() {
            return None;
        }
        let speed = touch.velocity.norm();
        let of_speed = |times: f64| self.overload(times * speed, memory).ok().flatten();
        let level = FASTER.into_iter().find_map(of_speed)?;
        Some(MechanicsError::SlidesByItself { level }.into())
    }

    /// The motion with inertia: friction, pusher and loads act for `duration`, in s, on an object
    /// that moves with `target`. Both are motions of the center of mass, axes of W.
    pub(crate) fn pushed_with_inertia(
        &self,
        touch: &ContactKinematics,
        law: &ContactLaw,
        duration: f64,
        target: &Twist,
        memory: &mut Memory,
    ) -> Result<Rate, EffectError> {
        let center = self.step.object.center_of_mass();
        let mut guess = self.guess(touch, law, memory)?;
        if guess.mode == ContactMode::Separated {
            guess.motion = self.to_motion(target, center);
        }
        let pull = self.to_motion(target, center);
        let inertia = Some((self.mass() / (self.f_max * duration), pull));
        let local = self.local(&guess.motion);
        let friction = self.friction(local, memory)?;
        let answer = self.balance(&friction, inertia).touched(touch, law, &guess)?;
        memory.keep(self.time, answer);
        Ok(self.rate_at(&answer, center))
    }

    /// The motion after an inelastic impact with Coulomb friction on an object that moved with
    /// `target`, both of the center of mass, axes of W.
    pub(crate) fn struck(
        &self,
        touch: &ContactKinematics,
        law: &ContactLaw,
        target: &Twist,
    ) -> Result<Twist, EffectError> {
        let center = self.step.object.center_of_mass();
        let motion = self.to_motion(target, center);
        let inertia = Some((self.mass() / self.step.object.mass(), motion));
        let length = self.step.object.mean_distance();
        let balance = Balance { friction: None, length, external: Vector3::zeros(), inertia };
        let mode = ContactMode::Separated;
        let guess = ContactSolution { mode, motion, force: Vector2::zeros() };
        let answer = balance.touched(touch, law, &guess)?;
        let pushes = answer.mode != ContactMode::Separated;
        Ok(if pushes { self.to_twist(&answer.motion, center) } else { *target })
    }

    fn balance<'b>(
        &'b self,
        friction: &'b Friction<'b>,
        inertia: Option<(Matrix3<f64>, Vector3<f64>)>,
    ) -> Balance<'b> {
        let length = friction.length();
        Balance { friction: Some(friction), length, external: self.external, inertia }
    }

    /// Acceleration of the center of mass without a pusher, and the power that slows it, in W.
    pub(crate) fn free_acceleration(
        &self,
        twist_w: &Twist,
        memory: &mut Memory,
    ) -> Result<(Twist, f64), EffectError> {
        let center = self.step.object.center_of_mass();
        let motion = self.to_motion(twist_w, center);
        let local = self.local(&motion);
        let (load, _) = self.friction(local, memory)?.load(&motion)?;
        let net = self.f_max * (self.external - load);
        let power = -net.dot(&motion);
        let object = &self.step.object;
        let torque = net.z - cross(&(center - self.center), &net.xy());
        let linear = self.turn_wo * (net.xy() / object.mass());
        Ok((Twist { linear, angular: torque / object.moment_of_inertia() }, power))
    }

    /// Where a search starts: at the moment before, else at the push on the ellipsoid.
    fn guess(
        &self,
        touch: &ContactKinematics,
        law: &ContactLaw,
        memory: &mut Memory,
    ) -> Result<ContactSolution, EffectError> {
        if let Some(answer) = memory.foreseen(self.time) {
            return Ok(answer);
        }
        let ellipsoid = self.ellipsoid(memory)?;
        let moving = ContactLaw { static_ratio: 1.0, ..*law };
        let answer = closed_form(&ellipsoid, touch, &moving)?;
        if law.static_ratio == 1.0 || self.slides_already(touch, &answer) {
            return Ok(answer);
        }
        // What does not slide is asked first whether it is held.
        let held = closed_form(&ellipsoid, touch, law)?;
        let mode = if is_sliding(held.mode) { ContactMode::Sticking } else { held.mode };
        Ok(ContactSolution { mode, ..held })
    }

    /// Whether a contact slides at the start of a step: one that just came about, and one whose
    /// measured slip is more than half of the one that sliding has.
    fn slides_already(&self, touch: &ContactKinematics, sliding: &ContactSolution) -> bool {
        let measured = touch.slip(&self.to_motion(&self.step.twist_wb, &Vector2::zeros()));
        let slip = touch.slip(&sliding.motion);
        is_sliding(sliding.mode) && (!self.step.touching || measured * slip > 0.5 * slip * slip)
    }

    /// The ellipsoid of the moment, made anew only if it changed; its largest force is 1.
    fn ellipsoid(&self, memory: &mut Memory) -> Result<Ellipsoid, EffectError> {
        if self.support.length_ratio == 1.0
            && self.support.tensor_o.is_zero()
            && self.spots.is_none()
        {
            return Ok(*self.step.object.ellipsoid());
        }
        if let Some((support, surface)) = &memory.ellipsoid {
            let same = support.tensor_o == self.support.tensor_o
                && support.length_ratio == self.support.length_ratio;
            if same {
                return Ok(*surface);
            }
        }
        let inverse = ellipsoid(&self.support, self.length());
        let surface = Ellipsoid::from_inverse(inverse)?;
        memory.ellipsoid = Some((self.support, surface));
        Ok(surface)
    }

    /// Whether friction is the ellipsoid, but for that of single points.
    pub(crate) fn is_quadric(&self) -> bool {
        self.support.shape == 0.0 && self.physics.rig().given().is_none() && self.spots.is_none()
    }

    /// c of the ellipsoid, in m.
    pub(crate) fn length(&self) -> f64 {
        let object = &self.step.object;
        let turning = self.support.length_ratio * self.turning();
        let mean = object.mean_distance();
        turning * self.spots.map_or(mean, |s| (1.0 - s.share) * mean + s.share * s.mean_distance)
    }

    /// How much larger the largest moment of friction is by its directions.
    pub(crate) fn turning(&self) -> f64 {
        *self.turning.get_or_init(|| turning_ratio(&self.step.object, &self.support))
    }

    /// Mass matrix at the center of friction, axes of the outline.
    fn mass(&self) -> Matrix3<f64> {
        let object = &self.step.object;
        let (m, arm) = (object.mass(), object.center_of_mass() - self.center);
        let (x, y) = (m * arm.x, m * arm.y);
        let turn = object.moment_of_inertia() + m * arm.norm_squared();
        Matrix3::new(m, 0.0, -y, 0.0, m, x, -y, x, turn)
    }

    /// From a motion of the point `at` (frame of the outline) in W to one at S in the outline's axes.
    fn to_motion(&self, twist_w: &Twist, at: &Vector2<f64>) -> Vector3<f64> {
        let linear = self.turn_wo.tr_mul(&twist_w.linear)
            + twist_w.angular * perpendicular(&(self.center - at));
        Vector3::new(linear.x, linear.y, twist_w.angular)
    }

    /// The inverse of [`ForceBalance::to_motion`].
    fn to_twist(&self, motion: &Vector3<f64>, at: &Vector2<f64>) -> Twist {
        let linear = motion.xy() + motion.z * perpendicular(&(at - self.center));
        Twist { linear: self.turn_wo * linear, angular: motion.z }
    }

    fn rate(&self, answer: &ContactSolution) -> Rate {
        self.rate_at(answer, &Vector2::zeros())
    }

    fn rate_at(&self, answer: &ContactSolution, at: &Vector2<f64>) -> Rate {
        let twist_w = self.to_twist(&answer.motion, at);
        Rate { mode: answer.mode, twist_w, force_o: self.f_max * answer.force }
    }
}
