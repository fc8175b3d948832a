//! Contact that holds: draws conditioned on the pusher's place.

use effects::TrueOutline;
use nalgebra::{Matrix3, Rotation2, RowVector3, Vector2, Vector3};
use planar::{Pose, perpendicular};

/// Linearisations: the second leaves less than a micrometer of a millimeter.
const ROUNDS: usize = 2;
/// The gap is not known better than this, in m: a covariance that has less along the normal hardly moves.
const GAP_SD: f64 = 1e-6;
/// A draw moves by no more standard deviations than this. What would need more is not what the
/// covariance is about, and following it would send an object whose covariance is nearly flat along the
/// normal far away.
const FARTHEST: f64 = 10.0;

/// The pose after a motion along a direction and its left normal, in m, and a turn, in rad.
pub(super) fn moved_by(
    pose_wb: &Pose,
    along_w: &Vector2<f64>,
    [along, left, turn]: [f64; 3],
) -> Pose {
    let position = pose_wb.position + along * along_w + left * perpendicular(along_w);
    Pose { position, angle: pose_wb.angle + turn }
}

/// A contact that is to hold.
pub(super) struct Holding<'a> {
    /// Of the model.
    pub(super) outline: &'a TrueOutline,
    /// The pusher's center, in m, frame W.
    pub(super) center_w: Vector2<f64>,
    /// Its motion, a unit vector in W.
    pub(super) along_w: Vector2<f64>,
    /// The gap that is known, in m.
    pub(super) gap: f64,
    /// More gap than this beyond it is a loss, in m.
    pub(super) tolerance: f64,
}

impl Holding<'_> {
    /// A draw given that the gap is known to a micrometer: x + C Hᵀ (HCHᵀ + r)⁻¹ (gap − g(x)), H the slope
    /// of the gap g and r its variance; none where the draw leaves more than the tolerance between
    /// pusher and outline.
    ///
    /// Exact for a Gaussian draw and a gap that is linear in it; a draw without variance stays.
    ///
    /// - `covariance`: of the draw along the pusher's motion, its left normal, and of the turn.
    pub(super) fn settled(&self, drawn_wb: &Pose, covariance: &Matrix3<f64>) -> Option<Pose> {
        let mut pose_wb = *drawn_wb;
        for round in 0..ROUNDS {
            let (now, slope) = self.gap_and_slope(&pose_wb);
            if round == 0 && now - self.gap > self.tolerance {
                return None;
            }
            let spread: Vector3<f64> = covariance * slope.transpose();
            let variance = (slope * spread).x;
            if variance <= 0.0 {
                break;
            }
            let known = variance + GAP_SD * GAP_SD;
            let farthest = FARTHEST * known.sqrt();
            let by = spread * ((self.gap - now).clamp(-farthest, farthest) / known);
            pose_wb = moved_by(&pose_wb, &self.along_w, by.into());
        }
        Some(pose_wb)
    }

    /// The Gaussian of a draw given that the gap is known, its covariance in W; none where the mean
    /// leaves more than the tolerance.
    ///
    /// (I − K H) C (I − K H)ᵀ + r K Kᵀ, r the variance of the gap, keeps what is left of the covariance
    /// positive although it has next to none along the normal.
    ///
    /// - `mean_wb`, `covariance`: of the draw before; the latter as of [`Holding::settled`].
    /// - `axes`: turns (along, left, turn) into W.
    pub(super) fn settled_gaussian(
        &self,
        mean_wb: &Pose,
        covariance: &Matrix3<f64>,
        axes: &Matrix3<f64>,
    ) -> Option<(Pose, Matrix3<f64>)> {
        let mean_wb = self.settled(mean_wb, covariance)?;
        let slope_w = self.gap_and_slope(&mean_wb).1 * axes.transpose();
        let covariance_w = axes * covariance * axes.transpose();
        let spread: Vector3<f64> = covariance_w * slope_w.transpose();
        let variance = (slope_w * spread).x;
        if variance <= 0.0 {
            return Some((mean_wb, covariance_w));
        }
        let known = GAP_SD * GAP_SD;
        let gain = spread / (variance + known);
        let keeps = Matrix3::identity() - gain * slope_w;
        let left = keeps * covariance_w * keeps.transpose() + known * gain * gain.transpose();
        Some((mean_wb, 0.5 * (left + left.transpose())))
    }

    /// The gap, and its slope along the pusher's motion, its left normal, and over the turn.
    fn gap_and_slope(&self, pose_wb: &Pose) -> (f64, RowVector3<f64>) {
        let Self { outline, center_w, along_w, .. } = self;
        let turn = Rotation2::new(pose_wb.angle);
        let center_b = outline.center_b(pose_wb, center_w);
        let contact = outline.contact(&center_b);
        let normal_w = turn * contact.normal;
        let by_turn = normal_w.dot(&perpendicular(&(turn * contact.point)));
        let left = normal_w.dot(&perpendicular(along_w));
        (contact.gap, RowVector3::new(normal_w.dot(along_w), left, by_turn))
    }
}

/// The slope of the gap along a motion of the pusher, its left normal, and over a turn.
pub(crate) fn gap_slope(
    outline: &TrueOutline,
    pose_wb: &Pose,
    center_w: &Vector2<f64>,
    along_w: &Vector2<f64>,
) -> RowVector3<f64> {
    let (center_w, along_w) = (*center_w, *along_w);
    Holding { outline, center_w, along_w, gap: 0.0, tolerance: 0.0 }.gap_and_slope(pose_wb).1
}

#[cfg(test)]
mod tests {
    use effects::TrueOutline;
    use nalgebra::{Matrix3, Vector2, Vector3};
    use planar::{Pose, Shape};

    use super::Holding;

    #[test]
    fn a_settled_draw_has_the_gap_and_moves_as_its_covariance_says() {
        let outline = &TrueOutline::stated(&Shape::square(0.09).unwrap(), 0.005);
        let (center, along) = (Vector2::new(-0.05, 0.02), Vector2::x());
        let drawn = Pose::new(0.0004, 0.0001, 0.003);
        let held =
            |gap| Holding { outline, center_w: center, along_w: along, gap, tolerance: 1e-3 };
        let stiff = Matrix3::from_diagonal(&Vector3::new(1e-8, 1e-8, 0.0));
        let settled = held(0.0001).settled(&drawn, &stiff).unwrap();
        assert!((outline.gap(&settled, &center) - 0.0001).abs() < 1e-9);
        assert!((settled.angle - drawn.angle).abs() < 1e-12, "an angle without variance stays");
        let turning = Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, 1e-4));
        let settled = held(0.0001).settled(&drawn, &turning).unwrap();
        assert!((outline.gap(&settled, &center) - 0.0001).abs() < 1e-7);
        assert_eq!(settled.position, drawn.position);
        assert_eq!(held(0.0).settled(&drawn, &Matrix3::zeros()), Some(drawn));
        let axes = Matrix3::identity();
        let (mean, left) = held(0.0001).settled_gaussian(&drawn, &stiff, &axes).unwrap();
        assert_eq!(Some(mean), held(0.0001).settled(&drawn, &stiff));
        // Along the normal the micrometer is left to which the gap is known, across it all.
        assert!((left[(1, 1)] / 1e-8 - 1.0).abs() < 1e-4 && left[(0, 0)] < 1.2e-12, "{left}");
        assert_eq!(held(-0.002).settled(&drawn, &stiff), None);
    }

    #[test]
    fn a_covariance_that_is_all_but_flat_along_the_normal_sends_no_object_away() {
        let outline = &TrueOutline::stated(&Shape::square(0.09).unwrap(), 0.005);
        let (center, along) = (Vector2::new(-0.05, 0.02), Vector2::x());
        let held = Holding { outline, center_w: center, along_w: along, gap: 0.0, tolerance: 1e-3 };
        let drawn = Pose::new(-0.0005, 0.0, 0.0);
        // What one parameter leaves open: a direction along the surface, but for rounding.
        for off in [0.0, 1e-12, 1e-9, 1e-7, 1e-5] {
            let open = Vector3::new(off, 2e-4, -1e-6);
            let settled = held.settled(&drawn, &(open * open.transpose())).unwrap();
            let moved = (settled.position - drawn.position).norm();
            assert!(moved <= 2.0 * 10.0 * open.norm(), "{off}: {moved}");
        }
    }
}
