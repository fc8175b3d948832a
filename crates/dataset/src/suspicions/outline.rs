//! Whether the outline fits the places of contact, once its frame is put where it fits best.

use nalgebra::{Matrix4, Vector2, Vector4};
use planar::perpendicular;

use super::mistake::View;
use super::numbers::length;
use super::places::{NEAR, SHARE, distance};
use super::scene::Scene;
use super::{Check, Explanation, Find, Suspicion};
use crate::curves::sample::quantile;

pub(super) const CHECK: Check = Check {
    id: "outline",
    looks_at: "the distance of the pusher from the outline, less what one offset of the tracked frame, \
               its turn and the pusher's radius explain",
    names: "an outline that is not the object's, and frames that do not fit each other",
    find: Find::Places(find),
};

/// Distances that no calibration explains, over the object's size: a warning, and an error.
const FAR: f64 = 0.4;
const ELSEWHERE: f64 = 1.0;
/// What is left of the distance where the outline is another, over the object's size.
const LEFT: f64 = 0.04;
/// How far the frame may be off, and the pusher's radius, over the object's size.
const OFFSET: f64 = 0.3;
const EXCESS: f64 = 0.12;

/// The frame that brings the outline to the pusher, and what that leaves.
struct Frame {
    /// Of the pusher in the body frame, in m.
    offset: Vector2<f64>,
    /// How much farther from the outline the pusher's center is than its radius, in m.
    excess: f64,
    /// The distance that is left in three quarters of the moments, in m.
    left: f64,
}

fn find(scene: &Scene<'_>) -> Option<Explanation> {
    let recorded = View::recorded();
    let distance = distance(scene, &recorded)?;
    let size = scene.size();
    if distance <= NEAR * size {
        return None;
    }
    let is_certain = distance > ELSEWHERE * size;
    let frame = Frame::of(scene)?;
    let off = frame.offset.norm();
    let (what, left) = if frame.left > LEFT * size {
        let what = if distance > FAR * size {
            "the frames of pusher and object do not fit each other, or the outline is another"
        } else {
            "the outline is not that of the object"
        };
        (what.to_owned(), format!("{} where it fits best", length(frame.left)))
    } else if off > OFFSET * size {
        let [x, y] = [0, 1].map(|axis| length(-frame.offset[axis]));
        let what =
            format!("the object's frame is off the outline's by {x} along x and {y} along y");
        (what, format!("{} with that corrected", length(frame.left)))
    } else if frame.excess.abs() > EXCESS * size {
        let how = if frame.excess > 0.0 { "small" } else { "large" };
        let what = format!("the outline or the pusher's radius is too {how}");
        (what, format!("{} all around", length(frame.excess)))
    } else {
        let view = Some(recorded);
        return Some(Explanation { distance, suspicion: None, view });
    };
    let suspicion = Suspicion {
        what,
        evidence: format!(
            "while the object moves, the pusher is {} from its outline (three quarters of the time, \
             or less), no single swap, sign, unit or shift of a clock brings it there, and {left}",
            length(distance)
        ),
        fix: "check [object] against the object, pusher.radius_m, and streams.robot and \
              streams.object (transform, columns or fields)"
            .into(),
        is_certain,
    };
    let view = (!is_certain).then_some(recorded);
    Some(Explanation { distance, suspicion: Some(suspicion), view })
}

impl Frame {
    /// Least squares of the gaps, reweighted so that some far moments do not decide.
    fn of(scene: &Scene<'_>) -> Option<Self> {
        const ROUNDS: usize = 12;
        // What a set that does not tell leaves at zero: sd of 3 % of the size against one of 0.3 %.
        const PRIOR: f64 = 1e-2;
        let size = scene.size();
        let mut found = Vector4::zeros();
        for _ in 0..ROUNDS {
            let rows = rows(scene, &found);
            let spread = quantile(rows.iter().map(|(gap, _)| gap.abs()).collect(), 0.5)?;
            let spread = spread.max(1e-3 * size);
            let mut normal = Matrix4::identity() * PRIOR * rows.len() as f64 * 1e-2;
            let mut right = -normal * found;
            for (gap, slope) in &rows {
                let weight = (2.0 * spread / gap.abs()).min(1.0);
                normal += weight * slope * slope.transpose();
                right -= weight * *gap * slope;
            }
            found += normal.cholesky()?.solve(&right);
        }
        let left = rows(scene, &found).into_iter().map(|(gap, _)| gap.abs());
        Some(Self {
            offset: found.xy() * size,
            excess: found[3] * size,
            left: size * quantile(left.collect(), SHARE)?,
        })
    }
}

/// Gap of each moment and its slope, over the object's size, with an offset and excess over the
/// size and a turn in rad.
fn rows(scene: &Scene<'_>, found: &Vector4<f64>) -> Vec<(f64, Vector4<f64>)> {
    let size = scene.size();
    let turn = nalgebra::Rotation2::new(found[2]);
    let row = |(recording, moment): &(usize, super::moment::Moment)| {
        let (position, angle) = moment.object[1];
        let pose = planar::Pose { position, angle };
        let center = turn * pose.inverse_transform_point(&moment.pusher[1]);
        let contact =
            scene.object(*recording).shape.contact(&(center + size * found.xy()), scene.radius());
        let normal = contact.normal;
        let of_turn = -normal.dot(&perpendicular(&center)) / size;
        let slope = Vector4::new(-normal.x, -normal.y, of_turn, -1.0);
        (contact.gap / size - found[3], slope)
    };
    scene.seen.iter().map(row).collect()
}
