//! Where on the table objects were.

use std::sync::Arc;

use effects::Object;
use nalgebra::Vector2;
use planar::Pose;

use crate::{Covariate, Observations};

/// The outlines of pushed objects, where they lay as each step began.
#[derive(Clone, Debug)]
pub struct Footprints {
    outlines: Vec<Outline>,
}

#[derive(Clone, Debug)]
struct Outline {
    push: usize,
    pose_wb: Pose,
    object: Arc<Object>,
    /// About the body's origin, in m.
    radius: f64,
}

impl Footprints {
    /// Those of observations; none where it was not measured where objects lay.
    pub fn of(observations: &Observations) -> Self {
        let outline = |(step, push): (&models::ChannelObservation, &usize)| {
            let object = step.input.object.clone();
            let radius = object.shape().bounding_radius();
            Outline { push: *push, pose_wb: step.input.pose_wb, object, radius }
        };
        let covariates = [Covariate::TableX, Covariate::TableY, Covariate::Orientation];
        if covariates.iter().any(|covariate| observations.unknown.contains(covariate)) {
            return Self { outlines: Vec::new() };
        }
        let steps = observations.steps.iter().zip(&observations.push_of);
        Self { outlines: steps.map(outline).collect() }
    }

    /// Lower left and upper right corner of a rectangle about all of them, in m, frame W; none of none.
    pub fn bounds(&self) -> Option<[Vector2<f64>; 2]> {
        let around = |outline: &Outline| {
            let (middle, reach) = (outline.pose_wb.position, Vector2::repeat(outline.radius));
            [middle - reach, middle + reach]
        };
        let both = |[a, b]: [Vector2<f64>; 2], [c, d]: [Vector2<f64>; 2]| [a.inf(&c), b.sup(&d)];
        self.outlines.iter().map(around).reduce(both)
    }

    /// How many pushes had their object over a place, in m, frame W. Takes a time in proportion to the steps.
    pub fn n_pushes_over(&self, place_w: &Vector2<f64>) -> usize {
        let (mut n, mut last) = (0, None);
        for Outline { push, pose_wb, object, radius } in &self.outlines {
            let away = place_w - pose_wb.position;
            // Steps of a push follow each other.
            if last != Some(push)
                && away.norm_squared() <= radius * radius
                && object.shape().contains(&pose_wb.inverse_transform_point(place_w))
            {
                (n, last) = (n + 1, Some(push));
            }
        }
        n
    }
}
