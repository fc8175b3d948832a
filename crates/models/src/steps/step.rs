//! A step of a push: what a model is asked, and what was observed.

use std::sync::Arc;

use nalgebra::{Vector2, Vector3};
use planar::{Contact, Feature, Pose, Shape, cross, perpendicular};

use crate::ModelError;
use crate::error::{not_negative, positive};

/// A straight motion of a round pusher at an object, in the body frame B at the start of the step.
///
/// β is the angle from the edge's inward normal to the pusher's motion, counter-clockwise positive
/// (at a vertex too, as in the table); p runs from 0 to 1 along the edge.
#[derive(Clone, Debug, PartialEq)]
pub struct StepInput {
    shape: Arc<Shape>,
    pusher_radius: f64,
    edge: usize,
    p: f64,
    beta: f64,
    start_b: Vector2<f64>,
    direction_b: Vector2<f64>,
    distance: f64,
    duration: Option<f64>,
    whole: Option<WholeStep>,
}

/// The step with all that effects act on; two are equal if they are one.
#[derive(Clone, Debug)]
struct WholeStep(Arc<effects::StepInput>);

impl PartialEq for WholeStep {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl StepInput {
    /// The step that starts in contact at `p` on `edge` and pushes along `beta` for `distance`.
    ///
    /// - `pusher_radius`: in m, 0 for a point; - `beta`: in rad; - `distance`: in m.
    ///
    /// # Errors
    /// `NoSuchEdge`; `InvalidValue` for p outside 0 to 1, a β that is not finite, a negative radius
    /// or a distance that is not positive.
    pub fn on_edge(
        shape: Arc<Shape>,
        pusher_radius: f64,
        edge: usize,
        p: f64,
        beta: f64,
        distance: f64,
    ) -> Result<Self, ModelError> {
        let n_edges = shape.n_edges();
        if edge >= n_edges {
            return Err(ModelError::NoSuchEdge { edge, n_edges });
        }
        if !(0.0..=1.0).contains(&p) {
            let (name, expected, unit) = ("p", "within 0 and 1", "(share of the edge)");
            return Err(ModelError::InvalidValue { name, expected, value: p, unit });
        }
        if !beta.is_finite() {
            let (name, expected) = ("beta", "finite");
            return Err(ModelError::InvalidValue { name, expected, value: beta, unit: "rad" });
        }
        not_negative("pusher radius", pusher_radius, "m")?;
        positive("distance", distance, "m")?;
        let normal = shape.inward_normal_at(edge, p);
        let start_b = shape.point_at(edge, p) - pusher_radius * normal;
        let direction_b = Pose::new(0.0, 0.0, beta).rotate(&normal);
        Ok(Self::new(shape, pusher_radius, (edge, p), beta, start_b, direction_b, distance))
    }

    /// The step of a pusher whose center moves from `start_w` to `end_w` (world frame, in m) while
    /// the object is first at `pose_wb`; the pusher may start away from the object.
    ///
    /// # Errors
    /// `InvalidValue` for a negative radius, a component that is not finite or a pusher at rest.
    pub fn between(
        shape: Arc<Shape>,
        pusher_radius: f64,
        pose_wb: &Pose,
        start_w: &Vector2<f64>,
        end_w: &Vector2<f64>,
    ) -> Result<Self, ModelError> {
        not_negative("pusher radius", pusher_radius, "m")?;
        let start_b = pose_wb.inverse_transform_point(start_w);
        let motion = pose_wb.inverse_rotate(&(end_w - start_w));
        let distance = positive("the pusher's travel", motion.norm(), "m")?;
        if !(start_b.x + start_b.y).is_finite() {
            let (name, expected, value) = ("start", "finite", start_b.x + start_b.y);
            return Err(ModelError::InvalidValue { name, expected, value, unit: "m" });
        }
        let contact = shape.contact(&start_b, pusher_radius);
        let (place, direction_b) = ((contact.edge, contact.p), motion / distance);
        let beta = beta(&shape.inward_normal_at(contact.edge, contact.p), &direction_b);
        Ok(Self::new(shape, pusher_radius, place, beta, start_b, direction_b, distance))
    }

    /// The step of a pusher whose nearest point of the outline is known, all in B at its start; it
    /// takes a duration in s.
    #[inline]
    pub(crate) fn at_contact(
        shape: Arc<Shape>,
        pusher_radius: f64,
        contact: &Contact,
        start_b: Vector2<f64>,
        (direction_b, distance, duration): (Vector2<f64>, f64, f64),
    ) -> Self {
        let &Contact { edge, p, normal, feature, .. } = contact;
        // At a vertex the contact has a normal of its own.
        let normal = match feature {
            Feature::Edge => normal,
            Feature::Vertex => shape.inward_normal_at(edge, p),
        };
        let beta = beta(&normal, &direction_b);
        let place = (edge, p);
        let step = Self::new(shape, pusher_radius, place, beta, start_b, direction_b, distance);
        Self { duration: Some(duration), ..step }
    }

    /// A step whose numbers have been checked.
    #[inline]
    fn new(
        shape: Arc<Shape>,
        pusher_radius: f64,
        (edge, p): (usize, f64),
        beta: f64,
        start_b: Vector2<f64>,
        direction_b: Vector2<f64>,
        distance: f64,
    ) -> Self {
        let (duration, whole) = (None, None);
        Self {
            shape,
            pusher_radius,
            edge,
            p,
            beta,
            start_b,
            direction_b,
            distance,
            duration,
            whole,
        }
    }

    /// A step of which all is known that effects act on; `shape` is its object's, to be shared.
    ///
    /// # Errors
    /// As [`StepInput::between`].
    pub fn of(step: effects::StepInput, shape: Arc<Shape>) -> Result<Self, ModelError> {
        let effects::StepInput { pusher_radius, pose_wb, track, .. } = &step;
        let bare = Self::between(shape, *pusher_radius, pose_wb, &track.start(), &track.end())?;
        let timed = bare.lasting(step.track.duration())?;
        Ok(Self { whole: Some(WholeStep(Arc::new(step))), ..timed })
    }

    /// The same for many steps; those of one object share its outline.
    ///
    /// # Errors
    /// As [`StepInput::between`].
    pub fn all_of<'a>(
        steps: impl IntoIterator<Item = &'a effects::StepInput>,
    ) -> Result<Vec<Self>, ModelError> {
        let mut last: Option<Arc<Shape>> = None;
        let input = |step: &effects::StepInput| {
            let shape = match &last {
                Some(shape) if **shape == *step.object.shape() => shape.clone(),
                _ => last.insert(Arc::new(step.object.shape().clone())).clone(),
            };
            Self::of(step.clone(), shape)
        };
        steps.into_iter().map(input).collect()
    }

    /// The same step with the time that it took, in s.
    ///
    /// # Errors
    /// `InvalidValue` if it is not positive and finite.
    pub fn lasting(self, duration: f64) -> Result<Self, ModelError> {
        positive("the step's duration", duration, "s")?;
        Ok(Self { duration: Some(duration), ..self })
    }

    /// The pusher's mean speed, in m/s, if it is known how long the step took.
    pub fn speed(&self) -> Option<f64> {
        self.duration.map(|duration| self.distance / duration)
    }

    /// The step with all that effects act on, if that is known.
    pub fn whole(&self) -> Option<&effects::StepInput> {
        self.whole.as_ref().map(|whole| &*whole.0)
    }

    /// The object's outline, in B.
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// The outline as it is shared between steps.
    pub fn shared_shape(&self) -> &Arc<Shape> {
        &self.shape
    }

    /// The pusher's radius, in m.
    pub fn pusher_radius(&self) -> f64 {
        self.pusher_radius
    }

    /// The edge touched at the start, from 0.
    pub fn edge(&self) -> usize {
        self.edge
    }

    /// Where on that edge, 0 to 1.
    pub fn p(&self) -> f64 {
        self.p
    }

    /// Angle from the inward normal to the pusher's motion, in rad.
    pub fn beta(&self) -> f64 {
        self.beta
    }

    /// The pusher's center at the start, in m, frame B.
    pub fn start_b(&self) -> Vector2<f64> {
        self.start_b
    }

    /// The direction of the pusher's motion, a unit vector in B.
    pub fn direction_b(&self) -> Vector2<f64> {
        self.direction_b
    }

    /// How far the pusher moves, in m.
    pub fn distance(&self) -> f64 {
        self.distance
    }

    /// (Δx, Δy, Δθ) of the body frame's motion `pose_bb` (end seen from start): along the pusher's
    /// motion and along its left normal, in m, and counter-clockwise, in rad.
    ///
    /// The thesis calls Δy parallel to the contact's normal (section 4.3) and Δθ negative for
    /// counter-clockwise turns (section 5.1); its figure 4.6 and the measurements say what is here.
    pub fn outputs(&self, pose_bb: &Pose) -> Vector3<f64> {
        let left = perpendicular(&self.direction_b);
        let moved = &pose_bb.position;
        Vector3::new(self.direction_b.dot(moved), left.dot(moved), pose_bb.angle)
    }
}

/// The angle from an inward normal to a direction, in rad.
fn beta(normal: &Vector2<f64>, direction_b: &Vector2<f64>) -> f64 {
    cross(normal, direction_b).atan2(normal.dot(direction_b))
}

/// A step with what the object did.
#[derive(Clone, Debug, PartialEq)]
pub struct StepObservation {
    /// What was done.
    pub input: StepInput,
    /// (Δx, Δy, Δθ): along the pusher's motion, along its left normal (m), counter-clockwise (rad).
    pub outputs: Vector3<f64>,
}

#[cfg(test)]
mod tests {
    use super::StepInput;
    use crate::ModelError;
    use nalgebra::Vector2;
    use planar::{Pose, Shape};
    use std::sync::Arc;

    fn square() -> Arc<Shape> {
        Arc::new(Shape::square(0.09).unwrap())
    }

    #[test]
    fn both_constructors_describe_the_same_step() {
        for (edge, p, beta) in [(0, 0.3, 0.4), (1, 0.8, -0.7), (3, 0.5, 0.0)] {
            let step = StepInput::on_edge(square(), 0.005, edge, p, beta, 0.004).unwrap();
            let pose_wb = Pose::new(0.4, -0.2, 2.5);
            let start_w = pose_wb.transform_point(&step.start_b());
            let end_w = start_w + pose_wb.rotate(&(step.direction_b() * step.distance()));
            let same = StepInput::between(square(), 0.005, &pose_wb, &start_w, &end_w).unwrap();
            assert_eq!(same.edge(), edge);
            assert!((same.p() - p).abs() < 1e-12 && (same.beta() - beta).abs() < 1e-12);
            assert!((same.distance() - 0.004).abs() < 1e-15);
        }
    }

    #[test]
    fn outputs_are_expressed_along_the_push() {
        let step = StepInput::on_edge(square(), 0.0, 1, 0.5, 0.0, 0.004).unwrap();
        assert!((step.direction_b() - Vector2::x()).norm() < 1e-15);
        let outputs = step.outputs(&Pose::new(0.003, 0.001, 0.1));
        assert_eq!(outputs.as_slice(), [0.003, 0.001, 0.1]);
    }

    #[test]
    fn impossible_steps_are_refused() {
        let refused = |edge, p, beta, distance| {
            StepInput::on_edge(square(), 0.0, edge, p, beta, distance).unwrap_err()
        };
        assert!(matches!(
            refused(4, 0.5, 0.0, 0.1),
            ModelError::NoSuchEdge { edge: 4, n_edges: 4 }
        ));
        for (p, beta, distance, name) in [
            (1.5, 0.0, 0.1, "p"),
            (f64::NAN, 0.0, 0.1, "p"),
            (0.5, f64::INFINITY, 0.1, "beta"),
            (0.5, 0.0, 0.0, "distance"),
        ] {
            let error = refused(0, p, beta, distance);
            assert!(matches!(error, ModelError::InvalidValue { name: n, .. } if n == name));
        }
    }
}
