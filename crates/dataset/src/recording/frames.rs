//! Frames published in a log, and the fixed transform between two of them.

use std::collections::BTreeMap;

use nalgebra::Isometry3;

/// Change of a transform within a log that still counts as none, in m and rad.
const FIXED_WITHIN: f64 = 1e-3;

/// Each child frame with its parent and the first pose published.
#[derive(Default)]
pub(crate) struct Frames {
    edges: BTreeMap<String, Edge>,
}

struct Edge {
    parent: String,
    pose: Isometry3<f64>,
    n_changed: u64,
}

impl Frames {
    /// Notes a published transform.
    pub(crate) fn add(&mut self, parent: &str, child: &str, pose: Isometry3<f64>) {
        let trim = |name: &str| name.trim_start_matches('/').to_owned();
        let edge = self.edges.entry(trim(child)).or_insert_with(|| Edge {
            parent: trim(parent),
            pose,
            n_changed: 0,
        });
        let moved = (pose.translation.vector - edge.pose.translation.vector).norm();
        let turned = pose.rotation.angle_to(&edge.pose.rotation);
        edge.n_changed += u64::from(moved > FIXED_WITHIN || turned > FIXED_WITHIN);
    }

    /// How many frames were published.
    pub(crate) fn len(&self) -> usize {
        self.edges.len()
    }

    /// The pose of `child` in `parent`, and how many messages along the way differ from it.
    pub(crate) fn find(&self, parent: &str, child: &str) -> Option<(Isometry3<f64>, u64)> {
        let parent = parent.trim_start_matches('/');
        let mut frame = child.trim_start_matches('/');
        let mut pose = Isometry3::identity();
        let mut n_changed = 0;
        for _ in 0..=self.edges.len() {
            if frame == parent {
                return Some((pose, n_changed));
            }
            let edge = self.edges.get(frame)?;
            pose = edge.pose * pose;
            n_changed += edge.n_changed;
            frame = &edge.parent;
        }
        None
    }

    /// The frames as (parent, child).
    pub(crate) fn pairs(&self) -> Vec<(String, String)> {
        self.edges.iter().map(|(child, edge)| (edge.parent.clone(), child.clone())).collect()
    }

    /// The frames as text for an error.
    pub(crate) fn listed(&self) -> String {
        let pairs: Vec<_> =
            self.edges.iter().map(|(child, edge)| format!("{} ← {child}", edge.parent)).collect();
        if pairs.is_empty() { "no frames".into() } else { pairs.join(", ") }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Isometry3, Vector3};

    use super::Frames;

    #[test]
    fn a_chain_of_frames_composes_and_a_loop_ends() {
        let step = |x: f64, yaw: f64| {
            Isometry3::new(Vector3::new(x, 0.0, 0.0), Vector3::new(0.0, 0.0, yaw))
        };
        let mut frames = Frames::default();
        frames.add("world", "/camera", step(1.0, 0.5));
        frames.add("/camera", "block", step(2.0, 0.25));
        frames.add("camera", "block", step(2.1, 0.25));
        frames.add("a", "b", step(0.0, 0.0));
        frames.add("b", "a", step(0.0, 0.0));
        let (pose, n_changed) = frames.find("world", "block").unwrap();
        let expected = step(1.0, 0.5) * step(2.0, 0.25);
        assert!((pose.translation.vector - expected.translation.vector).norm() < 1e-15);
        assert!(pose.rotation.angle_to(&expected.rotation) < 1e-15);
        assert_eq!(n_changed, 1);
        assert!(frames.find("world", "a").is_none() && frames.find("block", "world").is_none());
        assert_eq!(frames.listed(), "b ← a, a ← b, camera ← block, world ← camera");
    }
}
