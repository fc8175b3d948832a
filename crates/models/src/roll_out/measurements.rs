//! What sensors say of a pushed object: measurement models for a particle filter.

use filter::MeasurementModel;
use nalgebra::Vector2;
use planar::{Pose, wrap_angle};

use crate::{PushParticle, Pushed};

/// A pose that motion capture reported.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseSeen {
    /// Of B in W.
    pub pose_wb: Pose,
    /// Standard deviations: of the place along each axis, in m, and of the angle, in rad.
    pub sd: [f64; 2],
}

/// A contact force that the pusher's sensor reported, without any camera.
///
/// By Coulomb's law the force on the object lies within the friction cone of its contact, wherever the
/// pusher sticks or slips; so the likelihood is flat for a force within the particle's cone, and falls
/// with the angle beyond it as a Gaussian. A force above the threshold says that the pusher touches,
/// one below that it does not.
#[derive(Clone, Copy, Debug)]
pub struct ForceSeen<'a> {
    /// What is pushed.
    pub pushed: &'a Pushed,
    /// The pusher's center, in m, frame W.
    pub center_w: Vector2<f64>,
    /// Force on the object, in N, frame W.
    pub force_w: Vector2<f64>,
    /// Of pusher and object.
    pub friction: f64,
    /// Standard deviation of the force's direction, in rad.
    pub angle_sd: f64,
    /// A smaller force is none, in N.
    pub threshold: f64,
}

/// Log odds of a sensor that tells contact wrongly: once in a thousand times.
const WRONG: f64 = -6.9;

impl MeasurementModel for PoseSeen {
    type State = PushParticle;

    fn log_likelihood(&self, state: &PushParticle) -> f64 {
        let off = state.pose_wb.position - self.pose_wb.position;
        let turn = wrap_angle(state.pose_wb.angle - self.pose_wb.angle);
        let [place_sd, angle_sd] = self.sd;
        -0.5 * (off.norm_squared() / (place_sd * place_sd) + (turn / angle_sd).powi(2))
    }
}

impl MeasurementModel for ForceSeen<'_> {
    type State = PushParticle;

    fn log_likelihood(&self, state: &PushParticle) -> f64 {
        let is_felt = self.force_w.norm() > self.threshold;
        if is_felt != state.touches() {
            return WRONG;
        }
        if !is_felt {
            return 0.0;
        }
        let center_b = state.pose_wb.inverse_transform_point(&self.center_w);
        let contact = self.pushed.shape.contact(&center_b, self.pushed.pusher_radius);
        let normal_w = state.pose_wb.rotate(&contact.normal);
        let beyond = normal_w.angle(&self.force_w) - self.friction.atan();
        -0.5 * (beyond.max(0.0) / self.angle_sd).powi(2)
    }
}
