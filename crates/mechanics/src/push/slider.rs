//! What is pushed, and by what.

use crate::{Ellipsoid, LimitSurface, MechanicsError, Push, PushMotion, predict};
use nalgebra::{Unit, Vector2};
use planar::{Contact, Pose, Shape, Twist};

/// An object on the table: its outline and its friction.
#[derive(Clone, Copy, Debug)]
pub struct Slider<'a> {
    /// Outline, in m, frame B.
    pub shape: &'a Shape,
    /// Friction with the table, frame S.
    pub surface: &'a dyn LimitSurface,
    /// Where the frame of `surface` is in the tracked body B.
    ///
    /// It is the identity for a surface in the shape's own frame, as [`Ellipsoid::uniform`] and
    /// [`crate::Patch::uniform`] are: they know where the centroid is, and moving them there shifts the
    /// friction twice. A surface about its center of friction has that center here;
    /// [`UniformSupport`] is one that goes with its place.
    pub pose_bs: Pose,
}

/// Uniform pressure on an ellipsoid about the centroid, with its place: what [`Slider::pose_bs`] and a
/// surface that is centered on S have to say together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UniformSupport {
    surface: Ellipsoid,
    pose_bs: Pose,
}

impl UniformSupport {
    /// Under `shape`, bearing `f_max` in N, with the characteristic length of uniform pressure.
    ///
    /// # Errors
    /// `NotPositive` if the force is not positive and finite.
    pub fn new(shape: &Shape, f_max: f64) -> Result<Self, MechanicsError> {
        Self::with_length(shape, f_max, shape.mean_distance(&shape.centroid()))
    }

    /// The same with another characteristic length Mmax/Fmax, in m.
    ///
    /// # Errors
    /// `NotPositive` if force or moment are not positive and finite.
    pub fn with_length(shape: &Shape, f_max: f64, length: f64) -> Result<Self, MechanicsError> {
        let center = shape.centroid();
        let surface = Ellipsoid::new(f_max, f_max * length)?;
        Ok(Self { surface, pose_bs: Pose::new(center.x, center.y, 0.0) })
    }

    /// The surface, upright and about the origin of S.
    pub fn surface(&self) -> &Ellipsoid {
        &self.surface
    }

    /// Where S is in B: at the centroid.
    pub fn pose_bs(&self) -> &Pose {
        &self.pose_bs
    }

    /// The object of this support; `shape` is the one that it was made for.
    pub fn slider<'a>(&'a self, shape: &'a Shape) -> Slider<'a> {
        Slider { shape, surface: &self.surface, pose_bs: self.pose_bs }
    }
}

/// A round pusher that does not turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pusher {
    /// Radius, in m.
    pub radius: f64,
    /// Coefficient of friction with the slider, dimensionless.
    pub friction: f64,
}

impl Slider<'_> {
    /// Where a pusher with its center at `center_w` touches or would touch, frame B.
    pub fn contact(&self, pusher: &Pusher, pose_wb: &Pose, center_w: &Vector2<f64>) -> Contact {
        self.shape.contact(&pose_wb.inverse_transform_point(center_w), pusher.radius)
    }

    /// The push at a contact, by a pusher with velocity `v_wp`, in m/s, frame W.
    pub fn push_at(
        &self,
        pusher: &Pusher,
        pose_wb: &Pose,
        contact: &Contact,
        v_wp: &Vector2<f64>,
    ) -> Push {
        let v_wp_b = pose_wb.inverse_rotate(v_wp);
        Push {
            p_sc: self.pose_bs.inverse_transform_point(&contact.point),
            normal_s: Unit::new_unchecked(self.pose_bs.inverse_rotate(&contact.normal)),
            v_wp_s: self.pose_bs.inverse_rotate(&v_wp_b),
            friction: pusher.friction,
        }
    }

    /// The push's motion and with it the body's velocity, in m/s and rad/s, at B's origin, frame W.
    ///
    /// # Errors
    /// As [`crate::predict`].
    pub fn velocity(
        &self,
        push: &Push,
        pose_wb: &Pose,
    ) -> Result<(PushMotion, Twist), MechanicsError> {
        let motion = predict(self.surface, push)?;
        let twist = self.velocity_of(&motion.twist_ws_s, pose_wb);
        Ok((motion, twist))
    }

    /// The velocity of B's origin, frame W, that belongs to a twist in S.
    pub(crate) fn velocity_of(&self, twist_ws_s: &Twist, pose_wb: &Pose) -> Twist {
        let at_body = twist_ws_s.shifted(&self.pose_bs.inverse().position);
        let linear = pose_wb.rotate(&self.pose_bs.rotate(&at_body.linear));
        Twist { linear, angular: at_body.angular }
    }
}
