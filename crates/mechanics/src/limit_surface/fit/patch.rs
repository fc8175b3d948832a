//! The pressure patch that fits wrench–twist pairs best.

use super::barrier::{Barrier, constrained_least_squares};
use super::{Fit, Scaled, WrenchTwist, least_squares, normalized, scored};
use crate::{LimitSurface, MechanicsError, Patch, QuadraticTraction};
use nalgebra::{DMatrix, DVector, Matrix4, Vector2, Vector4};
use planar::Shape;

/// Points around the outline, and from the centroid to each of them, where the traction is kept
/// above a hundredth of its mean, which leaves room for a dip between the points.
const N_AROUND: u32 = 96;
const N_INWARD: u32 = 16;
const FLOOR: f64 = 1e-2;

/// Fits the traction c₀ + c₁ x + c₂ y + c₃ |r|² over `shape` to the loads of the motions, among those
/// that are nowhere negative.
///
/// Plain least squares if they are positive, else an interior-point method with the traction kept
/// positive on a fine set of points. ρ is `length`, in m.
///
/// # Errors
/// As [`crate::fit_ellipsoid`], below 4 pairs.
pub fn fit_patch(
    shape: &Shape,
    pairs: &[WrenchTwist],
    length: f64,
) -> Result<Fit<Patch>, MechanicsError> {
    Scaled::new("a patch", pairs, length, 4)?;
    let family = Family::new(shape);
    let patches = (0..4).map(|k| family.basis(k)).collect::<Result<Vec<_>, _>>()?;
    let mut rows = DMatrix::zeros(3 * pairs.len(), 4);
    let mut loads = DVector::zeros(3 * pairs.len());
    for (i, pair) in pairs.iter().enumerate() {
        let even = normalized(&patches[0].wrench(&pair.twist)?, length);
        rows.fixed_view_mut::<3, 1>(3 * i, 0).copy_from(&even);
        for (k, patch) in patches.iter().enumerate().skip(1) {
            let load = normalized(&patch.wrench(&pair.twist)?, length) - even;
            rows.fixed_view_mut::<3, 1>(3 * i, k).copy_from(&load);
        }
        loads.fixed_rows_mut::<3>(3 * i).copy_from(&normalized(&pair.wrench, length));
    }
    let free = least_squares("a patch", rows.clone(), &loads)?;
    match family.patch(&free) {
        Ok(surface) => return scored(surface, pairs, length, 0),
        Err(MechanicsError::BadTraction { .. }) => {}
        Err(error) => return Err(error),
    }
    let start =
        DVector::from_vec(vec![1.0, 0.0, 0.0, 0.0]) * (loads.norm() / rows.column(0).norm());
    let (best, n_steps) =
        constrained_least_squares("a fit of a patch", &rows, &loads, &family, start)?;
    scored(family.patch(&best)?, pairs, length, n_steps)
}

/// Tractions Σ cₖ bₖ/area with b = (1, x/R, y/R, |r|²/R²), and where they must not be negative.
struct Family<'a> {
    shape: &'a Shape,
    area: f64,
    radius: f64,
    /// What gives the height above the floor at each of the points.
    heights: Vec<Vector4<f64>>,
}

impl<'a> Family<'a> {
    fn new(shape: &'a Shape) -> Self {
        let (radius, center) = (shape.bounding_radius(), shape.centroid());
        let per_edge = N_AROUND.div_ceil(shape.n_edges() as u32);
        let area = shape.area();
        let spread = shape.second_moment(&Vector2::zeros()) / (area * radius * radius);
        let mean = Vector4::new(1.0, center.x / radius, center.y / radius, spread);
        let mut heights = Vec::new();
        for edge in 0..shape.n_edges() {
            for k in 0..per_edge {
                let rim = shape.point_at(edge, f64::from(k) / f64::from(per_edge));
                for j in 0..=N_INWARD {
                    let r = center + f64::from(j) / f64::from(N_INWARD) * (rim - center);
                    let r = r / radius;
                    let basis = Vector4::new(1.0, r.x, r.y, r.norm_squared());
                    heights.push(basis - FLOOR * mean);
                }
            }
        }
        Self { shape, area, radius, heights }
    }

    fn traction(&self, c: &[f64]) -> QuadraticTraction {
        let radius = self.radius;
        let scaled = [c[0], c[1] / radius, c[2] / radius, c[3] / (radius * radius)];
        QuadraticTraction(scaled.map(|c| c / self.area))
    }

    /// The even traction, alone or lifted by another one, which is then nowhere negative.
    fn basis(&self, k: usize) -> Result<Patch, MechanicsError> {
        let mut c = [1.0, 0.0, 0.0, 0.0];
        if k > 0 {
            c[k] = 1.0;
        }
        Patch::quadratic(self.shape, self.traction(&c))
    }

    fn patch(&self, c: &DVector<f64>) -> Result<Patch, MechanicsError> {
        Patch::quadratic(self.shape, self.traction(c.as_slice()))
    }
}

impl Barrier for Family<'_> {
    fn parameter(&self) -> f64 {
        self.heights.len() as f64
    }

    fn at(&self, x: &DVector<f64>) -> Option<(f64, DVector<f64>, DMatrix<f64>)> {
        let c = Vector4::new(x[0], x[1], x[2], x[3]);
        let (mut value, mut gradient) = (0.0, Vector4::zeros());
        let mut hessian = Matrix4::zeros();
        for row in &self.heights {
            let height = row.dot(&c);
            if height <= 0.0 {
                return None;
            }
            value -= height.ln();
            gradient -= row / height;
            hessian += row * row.transpose() / (height * height);
        }
        Some((
            value,
            DVector::from_column_slice(gradient.as_slice()),
            DMatrix::from_column_slice(4, 4, hessian.as_slice()),
        ))
    }
}
