//! One way that the object may have gone.

use std::sync::Arc;

use effects::TrueOutline;
use filter::PlanarState;
use nalgebra::Vector3;
use planar::{Pose, Twist};
use serde::Serialize;

/// One way that the object may have gone, with the state of its contact.
#[derive(Clone, Debug, PartialEq)]
pub struct PushParticle {
    /// Pose of B in W.
    pub pose_wb: Pose,
    /// Mean velocity over the last step, of B's origin, axes of W.
    pub(super) twist_wb: Twist,
    /// The gap that contact holds, in m; none while the pusher is free.
    pub(super) contact_gap: Option<f64>,
    /// Since contact began, in s.
    pub(super) since_contact: f64,
    /// Standard normal numbers that neighboring steps share.
    pub(super) held: Vector3<f64>,
    /// By how much more than usual the model errs in this push.
    pub(super) size: f64,
    /// What contact holds beyond the nominal gap, in m.
    pub(super) gap_error: f64,
    /// What all steps of its push share; none where a model's pushes are alike.
    pub(super) drawn: Option<Arc<Drawn>>,
    pub(super) events: PushEvents,
}

/// What a push has drawn.
#[derive(Clone, Debug)]
pub(super) struct Drawn {
    /// Standard normal numbers, for the parameters that differ from push to push.
    pub(super) numbers: Vec<f64>,
    /// Outline and pusher that follow; none where all pushes have the same.
    pub(super) outline: Option<TrueOutline>,
}

impl PartialEq for Drawn {
    /// By the numbers, from which the rest follows.
    fn eq(&self, other: &Self) -> bool {
        self.numbers == other.numbers
    }
}

/// What happened over a step: numbers of particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct PushEvents {
    /// The pusher moved the object.
    pub pushed: usize,
    /// It met the object after a free way.
    pub touched: usize,
    /// It pushed at a vertex.
    pub at_vertex: usize,
    /// Contact was lost at the end.
    pub lost: usize,
    /// The model was asked beyond its training steps.
    pub unseen: usize,
}

impl PushParticle {
    /// At rest; the pusher touches if there is a gap that contact holds.
    pub(super) fn at(pose_wb: Pose, contact_gap: Option<f64>) -> Self {
        Self {
            pose_wb,
            twist_wb: Twist::default(),
            contact_gap,
            since_contact: 0.0,
            held: Vector3::zeros(),
            size: 1.0,
            gap_error: 0.0,
            drawn: None,
            events: PushEvents::default(),
        }
    }

    /// The same elsewhere, with errors of its own.
    pub(super) fn moved(&self, pose_wb: Pose, held: Vector3<f64>, gap_error: f64) -> Self {
        let contact_gap = self.contact_gap.map(|gap| gap + gap_error);
        Self { pose_wb, held, gap_error, contact_gap, ..self.clone() }
    }

    /// The standard normal numbers that its push has drawn, in the order of the model's effects.
    pub fn drawn(&self) -> &[f64] {
        self.drawn.as_ref().map_or(&[], |drawn| &drawn.numbers)
    }

    /// Whether the pusher touches it.
    pub fn touches(&self) -> bool {
        self.contact_gap.is_some()
    }

    /// What happened to it over the last step.
    pub fn events(&self) -> PushEvents {
        self.events
    }
}

impl PlanarState for PushParticle {
    fn planar(&self) -> [f64; 3] {
        [self.pose_wb.position.x, self.pose_wb.position.y, self.pose_wb.angle]
    }
}

impl PushEvents {
    /// All of them together.
    pub(super) fn sum(all: impl Iterator<Item = Self>) -> Self {
        all.fold(Self::default(), |sum, one| Self {
            pushed: sum.pushed + one.pushed,
            touched: sum.touched + one.touched,
            at_vertex: sum.at_vertex + one.at_vertex,
            lost: sum.lost + one.lost,
            unseen: sum.unseen + one.unseen,
        })
    }
}
