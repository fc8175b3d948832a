//! Two tables compared where they begin alike: by cells of (p, β), by pairs, by neighbors.

use models::StepObservation;
use nalgebra::Vector3;

/// Borders of the cells: p, and β in °.
pub(super) const P_BORDERS: [f64; 6] = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0];
pub(super) const BETA_BORDERS: [f64; 6] = [-75.0, -45.0, -15.0, 15.0, 45.0, 75.0];
/// Cells with fewer steps of either table are left out.
const FEWEST: usize = 10;
/// Differences in p and in β (rad) that count as equally far.
const P_SCALE: f64 = 0.1;
const BETA_SCALE: f64 = 0.35;
/// Steps nearer than this, on those scales, begin alike.
const ALIKE: f64 = 0.1;

/// Mean outputs of both tables in one cell, in m, m and rad.
pub(super) struct Cell {
    /// Its first borders: p, and β in °.
    pub(super) p: f64,
    pub(super) beta: f64,
    /// Steps, means, and standard deviations about them, by table.
    pub(super) n: [usize; 2],
    pub(super) mean: [Vector3<f64>; 2],
    pub(super) sd: [Vector3<f64>; 2],
}

/// How far steps of two tables that begin alike are apart.
pub(super) struct Paired {
    pub(super) n: usize,
    /// Mean and root mean square of the differences (second table less first), in m, m and rad.
    pub(super) mean: Vector3<f64>,
    pub(super) rms: Vector3<f64>,
}

/// The cells in which both tables have steps, by p and then by β.
pub(super) fn common(tables: [&[StepObservation]; 2]) -> Vec<Cell> {
    let mut cells = Vec::new();
    for p in P_BORDERS.windows(2) {
        for beta in BETA_BORDERS.windows(2) {
            let own = tables.map(|steps| {
                let inside = steps.iter().filter(|step| {
                    (p[0]..p[1]).contains(&step.input.p())
                        && (beta[0]..beta[1]).contains(&step.input.beta().to_degrees())
                });
                inside.map(|step| step.outputs).collect::<Vec<_>>()
            });
            let n = [own[0].len(), own[1].len()];
            if n.iter().all(|&n| n >= FEWEST) {
                let mean = [0, 1].map(|i| mean(&own[i]));
                let sd = [0, 1].map(|i| rms(own[i].iter().map(|outputs| outputs - mean[i])));
                cells.push(Cell { p: p[0], beta: beta[0], n, mean, sd });
            }
        }
    }
    cells
}

/// Each step of the first table against the nearest one of the second that begins alike.
pub(super) fn paired(first: &[StepObservation], second: &[StepObservation]) -> Paired {
    let differences: Vec<_> = first
        .iter()
        .filter_map(|step| {
            let near = nearest(step, second.iter())?;
            Some(near.outputs - step.outputs)
        })
        .collect();
    Paired { n: differences.len(), mean: mean(&differences), rms: rms(differences.iter().copied()) }
}

/// Standard deviation of the outputs of steps that begin alike, in m, m and rad: from the
/// differences of nearest neighbors, on another edge if there are several, so that steps of one push
/// are not compared.
pub(super) fn neighbor_sd(steps: &[StepObservation]) -> Vector3<f64> {
    let one_edge = steps.iter().all(|step| step.input.edge() == steps[0].input.edge());
    let differences = steps.iter().enumerate().filter_map(|(i, step)| {
        let others = steps.iter().enumerate().filter(|(j, other)| {
            if one_edge { i != *j } else { step.input.edge() != other.input.edge() }
        });
        Some(step.outputs - nearest(step, others.map(|(_, other)| other))?.outputs)
    });
    rms(differences) / 2.0_f64.sqrt()
}

/// The nearest of the steps that begin alike.
fn nearest<'a>(
    step: &StepObservation,
    among: impl Iterator<Item = &'a StepObservation>,
) -> Option<&'a StepObservation> {
    let distance = |other: &StepObservation| {
        let p = (other.input.p() - step.input.p()) / P_SCALE;
        p.hypot((other.input.beta() - step.input.beta()) / BETA_SCALE)
    };
    let near = among.map(|other| (distance(other), other)).filter(|(far, _)| *far < ALIKE);
    near.min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, other)| other)
}

fn mean(values: &[Vector3<f64>]) -> Vector3<f64> {
    values.iter().sum::<Vector3<f64>>() / values.len().max(1) as f64
}

/// Root of the mean square of each component.
fn rms(values: impl Iterator<Item = Vector3<f64>>) -> Vector3<f64> {
    let (mut sum, mut n) = (Vector3::zeros(), 0);
    for value in values {
        sum += value.component_mul(&value);
        n += 1;
    }
    (sum / f64::from(n.max(1))).map(f64::sqrt)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use models::{StepInput, StepObservation};
    use nalgebra::Vector3;
    use planar::Shape;

    use super::{common, neighbor_sd, paired};

    /// Steps over all p and β of edges 0 and 1, with an offset of Δx that is `apart` on edge 1.
    fn steps(offset: f64, apart: f64) -> Vec<StepObservation> {
        let shape = Arc::new(Shape::square(0.09).unwrap());
        let step = |k: usize| {
            let (p, beta) = ((k / 2 % 50) as f64 / 50.0 + 0.001, (k / 100) as f64 / 20.0 - 1.0);
            let input = StepInput::on_edge(shape.clone(), 0.005, k % 2, p, beta, 0.004).unwrap();
            let dx = offset + apart * (k % 2) as f64;
            StepObservation { input, outputs: Vector3::new(dx, p, beta) }
        };
        (0..4000).map(step).collect()
    }

    #[test]
    fn a_known_shift_is_found_in_cells_and_pairs() {
        let (first, second) = (steps(0.0, 0.0), steps(0.25, 0.0));
        let cells = common([&first, &second]);
        assert!(cells.len() > 15, "{}", cells.len());
        for cell in &cells {
            assert!((cell.mean[1] - cell.mean[0] - Vector3::new(0.25, 0.0, 0.0)).norm() < 1e-12);
            assert!(cell.n[0] == cell.n[1] && cell.sd[0].x < 1e-12 && cell.sd[0].y < 0.1);
        }
        let pairs = paired(&first, &second);
        assert_eq!(pairs.n, first.len());
        assert!((pairs.mean - Vector3::new(0.25, 0.0, 0.0)).norm() < 1e-12);
        assert!((pairs.rms.x - 0.25).abs() < 1e-12);
    }

    #[test]
    fn neighbors_are_looked_for_on_another_edge() {
        let sd = neighbor_sd(&steps(0.0, 0.5));
        assert!((sd.x - 0.5 / 2.0_f64.sqrt()).abs() < 1e-12 && sd.y < 1e-12, "{sd}");
    }
}
