//! The density of a cloud of positions, and its modes.

use serde::{Deserialize, Serialize};

use crate::planar_summary::poses;
use crate::{FilterError, PlanarState, Weights};

/// A kernel density estimate of positions on a regular grid.
///
/// The Gaussian kernel has Silverman's width sd·n^(−1/6) along each axis, with the effective number
/// of particles; positions are shared among the four nearest nodes.
///
/// # Source
/// Silverman (1986), Density Estimation for Statistics and Data Analysis, section 4.3.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DensityGrid {
    /// x and y of the first node, in m.
    pub origin: [f64; 2],
    /// Distance of the nodes along x and y, in m.
    pub spacing: [f64; 2],
    /// Nodes along x and y.
    pub size: [usize; 2],
    /// Density at the nodes in 1/m², x running fastest.
    pub density: Vec<f64>,
}

/// A place where the density is largest among its surroundings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mode {
    /// x and y, in m.
    pub position: [f64; 2],
    /// Its density, in 1/m².
    pub density: f64,
}

/// Kernel widths that the grid reaches beyond the outermost position.
const MARGIN: f64 = 4.0;

impl DensityGrid {
    /// The density of weighted states' positions on `n` nodes along each axis.
    ///
    /// # Errors
    /// As [`crate::PlanarSummary::of`]; `OutOfRange` for fewer than 8 nodes, or positions that do
    /// not differ along an axis.
    pub fn of<S: PlanarState>(
        states: &[S],
        weights: &Weights,
        n: usize,
    ) -> Result<Self, FilterError> {
        if n < 8 {
            let (name, expected, value) = ("nodes along an axis", "8 or more", n as f64);
            return Err(FilterError::OutOfRange { name, expected, value });
        }
        let poses = poses(states, weights)?;
        let axes = [0, 1].map(|axis| Axis::of(&poses, axis, weights.effective_size(), n));
        let [x, y] = axes;
        let (x, y) = (x?, y?);
        let mut mass = vec![0.0; n * n];
        for (pose, weight) in &poses {
            let ((i, right), (j, above)) = (x.place(pose[0]), y.place(pose[1]));
            mass[j * n + i] += weight * (1.0 - right) * (1.0 - above);
            mass[j * n + i + 1] += weight * right * (1.0 - above);
            mass[(j + 1) * n + i] += weight * (1.0 - right) * above;
            mass[(j + 1) * n + i + 1] += weight * right * above;
        }
        let along_x: Vec<f64> = mass.chunks(n).flat_map(|row| x.smoothed(row)).collect();
        let columns: Vec<Vec<f64>> = (0..n)
            .map(|i| y.smoothed(&along_x.iter().skip(i).step_by(n).copied().collect::<Vec<_>>()))
            .collect();
        let area = x.spacing * y.spacing;
        let density = (0..n * n).map(|k| columns[k % n][k / n] / area).collect();
        let (origin, spacing) = ([x.start, y.start], [x.spacing, y.spacing]);
        Ok(Self { origin, spacing, size: [n, n], density })
    }

    /// The places denser than their eight neighbours and than `least` times the densest, the
    /// densest first.
    #[must_use]
    pub fn modes(&self, least: f64) -> Vec<Mode> {
        let [n, m] = self.size;
        let floor = least * self.density.iter().copied().fold(0.0, f64::max);
        let is_mode = |i: usize, j: usize| {
            let here = self.density[j * n + i];
            let around = (j - 1..=j + 1).flat_map(|j| (i - 1..=i + 1).map(move |i| j * n + i));
            here >= floor && around.filter(|k| *k != j * n + i).all(|k| self.density[k] < here)
        };
        let inner =
            (1..m.saturating_sub(1)).flat_map(|j| (1..n.saturating_sub(1)).map(move |i| (i, j)));
        let mut modes: Vec<Mode> = inner
            .filter(|(i, j)| is_mode(*i, *j))
            .map(|(i, j)| Mode {
                position: [
                    self.origin[0] + i as f64 * self.spacing[0],
                    self.origin[1] + j as f64 * self.spacing[1],
                ],
                density: self.density[j * n + i],
            })
            .collect();
        modes.sort_by(|a, b| b.density.total_cmp(&a.density));
        modes
    }
}

/// One axis of a grid.
struct Axis {
    start: f64,
    spacing: f64,
    /// Kernel at whole numbers of nodes from its middle; it and its mirror sum to 1.
    kernel: Vec<f64>,
}

impl Axis {
    fn of(
        poses: &[([f64; 3], f64)],
        axis: usize,
        n_effective: f64,
        n: usize,
    ) -> Result<Self, FilterError> {
        let mean: f64 = poses.iter().map(|(pose, weight)| weight * pose[axis]).sum();
        let variance: f64 =
            poses.iter().map(|(pose, weight)| weight * (pose[axis] - mean).powi(2)).sum();
        let sd = variance.sqrt();
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for (pose, _) in poses {
            (low, high) = (low.min(pose[axis]), high.max(pose[axis]));
        }
        if sd <= 1e-12 * low.abs().max(high.abs()) {
            let (name, expected) = ("spread of the positions", "positive along both axes");
            return Err(FilterError::OutOfRange { name, expected, value: sd });
        }
        let width = sd * n_effective.powf(-1.0 / 6.0);
        let start = low - MARGIN * width;
        let spacing = (high + MARGIN * width - start) / (n - 1) as f64;
        let reach = ((MARGIN * width / spacing).ceil() as usize).clamp(1, n - 1);
        let bell = |k: usize| (-0.5 * (k as f64 * spacing / width).powi(2)).exp();
        let sum = 1.0 + 2.0 * (1..=reach).map(bell).sum::<f64>();
        let kernel = (0..=reach).map(|k| bell(k) / sum).collect();
        Ok(Self { start, spacing, kernel })
    }

    /// The node before a place, and the share of the way to the next.
    fn place(&self, value: f64) -> (usize, f64) {
        let place = (value - self.start) / self.spacing;
        (place as usize, place.fract())
    }

    fn smoothed(&self, row: &[f64]) -> Vec<f64> {
        let (mut smooth, reach) = (vec![0.0; row.len()], self.kernel.len() - 1);
        for (k, mass) in row.iter().enumerate().filter(|(_, mass)| **mass > 0.0) {
            let first = k.saturating_sub(reach);
            let near = smooth.iter_mut().enumerate().skip(first).take(k + reach + 1 - first);
            near.for_each(|(at, value)| *value += mass * self.kernel[at.abs_diff(k)]);
        }
        smooth
    }
}
