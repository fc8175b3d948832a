//! What folding the edges of an object into one costs.

use anyhow::Result;
use dataset::StepRow;
use nalgebra::{Matrix3, Vector3};
use planar::Shape;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use report::{Claim, Verdict};

use crate::figures::claims::{judged, untestable};
use crate::figures::inputs::{Inputs, SEED};

/// Steps of one edge from which a step is predicted, by a plane.
const N_NEIGHBORS: usize = 12;
/// Differences in p and β (rad) that count as equally far.
const P_SCALE: f64 = 0.1;
const BETA_SCALE: f64 = 0.35;
/// Steps farther apart than this, on those scales, tell nothing of noise.
const FARTHEST: f64 = 2.0;
/// Pushes that start closer than this, on those scales, are repeats.
const REPEAT: f64 = 0.3;
/// Predicted steps below which nothing is said.
const FEWEST_STEPS: usize = 50;
/// Steps looked at, at most: more do not change the answer.
const MOST_STEPS: usize = 1500;
/// Shuffles of the edges: for a careful look and for a quick one.
const N_SHUFFLES: [usize; 2] = [100, 20];
/// Where shuffling alone gives ratios above this, a ratio within their range tells nothing.
const LARGEST_SCATTER: f64 = 1.5;

/// Steps of a table, ready to predict each other.
struct Steps {
    /// Edge of each unit: the repeats of a push on one edge.
    edges: Vec<usize>,
    n_edges: usize,
    steps: Vec<Step>,
}

struct Step {
    unit: usize,
    outputs: [f64; 3],
    /// Steps near by, the nearest first, with their offsets; none of a push that starts alike.
    near: Vec<(usize, [f64; 2])>,
}

/// Mean squared errors of Δx, Δy, Δθ of steps predicted from their own edge and from another.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Errors {
    own: [f64; 3],
    other: [f64; 3],
    n: usize,
}

/// Judges whether steps are predicted worse from another edge than from their own.
///
/// # Errors
/// An object that is not known.
pub(super) fn claim(inputs: &Inputs, rows: &[&StepRow], claim: &str) -> Result<Claim> {
    let shape = inputs.object(&rows[0].recording)?.shape;
    if !has_equal_edges(&shape) || rows.iter().any(|row| row.shape != rows[0].shape) {
        return Ok(untestable(claim, "the object's edges are not all alike"));
    }
    if rows.iter().all(|row| row.edge == rows[0].edge) {
        return Ok(untestable(claim, "the steps are on one edge alone"));
    }
    let steps = Steps::new(rows, shape.n_edges());
    let errors = steps.errors(&steps.edges);
    if errors.n < FEWEST_STEPS {
        return Ok(untestable(claim, "too few steps have neighbors on two edges"));
    }
    let shuffled = steps.shuffled(N_SHUFFLES[usize::from(inputs.quick())]);
    let at = |share: f64| shuffled[(share * (shuffled.len() - 1) as f64).round() as usize];
    let rms = |mean_square: f64| mean_square.sqrt();
    let value = format!(
        "RMS error from the own edge and from another: Δx {:.3} and {:.3} mm, Δy {:.3} and {:.3} \
         mm, Δθ {:.2}° and {:.2}°; variance {:.2} times as large in the mean, {:.2} to {:.2} \
         where edges are shuffled ({} steps)",
        1e3 * rms(errors.own[0]),
        1e3 * rms(errors.other[0]),
        1e3 * rms(errors.own[1]),
        1e3 * rms(errors.other[1]),
        rms(errors.own[2]).to_degrees(),
        rms(errors.other[2]).to_degrees(),
        errors.ratio(),
        at(0.05),
        at(0.95),
        errors.n
    );
    let reason = "each step is predicted by a plane through the 12 nearest steps of other, not \
                  repeated pushes on its own edge, and on another; holds if the ratio is above 95 % \
                  of those with the edges shuffled among the pushes";
    let holds = errors.ratio() > at(0.95);
    let judged = judged(claim, value, holds, reason);
    Ok(if holds || at(0.95) < LARGEST_SCATTER {
        judged
    } else {
        let verdict = Verdict::NotTestable;
        Claim { verdict, reason: format!("too few pushes to tell: {reason}"), ..judged }
    })
}

fn has_equal_edges(shape: &Shape) -> bool {
    let Shape::Polygon(polygon) = shape else { return false };
    let lengths: Vec<f64> = polygon.edges().map(|(a, b)| (b - a).norm()).collect();
    lengths.iter().all(|length| (length - lengths[0]).abs() < 1e-6)
}

impl Errors {
    /// Variance from another edge over that from the own, in the mean over the outputs.
    fn ratio(&self) -> f64 {
        self.own.iter().zip(self.other).map(|(own, other)| other / own).sum::<f64>() / 3.0
    }
}

impl Steps {
    fn new(rows: &[&StepRow], n_edges: usize) -> Self {
        let rows: Vec<_> = rows.iter().step_by(rows.len().div_ceil(MOST_STEPS)).copied().collect();
        let starts = start_groups(&rows);
        let mut units: Vec<(usize, u32)> = Vec::new();
        let mut unit_of = |unit: (usize, u32)| {
            units.iter().position(|known| *known == unit).unwrap_or_else(|| {
                units.push(unit);
                units.len() - 1
            })
        };
        let steps = rows
            .iter()
            .zip(&starts)
            .map(|(row, start)| Step {
                unit: unit_of((*start, row.edge)),
                outputs: [row.dx, row.dy, row.dtheta],
                near: near(row, *start, &rows, &starts),
            })
            .collect();
        let edges = units.iter().map(|(_, edge)| *edge as usize).collect();
        Self { edges, n_edges, steps }
    }

    /// Errors over all steps with enough neighbors on their own edge and on another.
    fn errors(&self, edges: &[usize]) -> Errors {
        let mut sum = Errors { own: [0.0; 3], other: [0.0; 3], n: 0 };
        for step in &self.steps {
            let own = edges[step.unit];
            let Some(here) = self.squared_error(step, edges, own) else { continue };
            let others = (0..self.n_edges).filter(|edge| *edge != own);
            let there: Vec<_> =
                others.filter_map(|edge| self.squared_error(step, edges, edge)).collect();
            if there.is_empty() {
                continue;
            }
            for k in 0..3 {
                sum.own[k] += here[k];
                sum.other[k] += there.iter().map(|e| e[k]).sum::<f64>() / there.len() as f64;
            }
            sum.n += 1;
        }
        let n = sum.n.max(1) as f64;
        Errors { own: sum.own.map(|s| s / n), other: sum.other.map(|s| s / n), n: sum.n }
    }

    /// Ratios, in order, with the edges shuffled among the units.
    fn shuffled(&self, n: usize) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(SEED);
        let mut edges = self.edges.clone();
        let mut ratios: Vec<f64> = (0..n)
            .map(|_| {
                edges.shuffle(&mut rng);
                self.errors(&edges).ratio()
            })
            .collect();
        ratios.sort_by(f64::total_cmp);
        ratios
    }

    /// Squared errors of a step's outputs by a plane through the nearest steps on an edge.
    fn squared_error(&self, step: &Step, edges: &[usize], edge: usize) -> Option<[f64; 3]> {
        let on_edge = step.near.iter().filter(|(i, _)| edges[self.steps[*i].unit] == edge);
        let mut normal = Matrix3::zeros();
        let mut sides = [Vector3::zeros(); 3];
        let mut n = 0;
        for (i, [x, y]) in on_edge.take(N_NEIGHBORS) {
            let features = Vector3::new(1.0, *x, *y);
            normal += features * features.transpose();
            for (side, output) in sides.iter_mut().zip(self.steps[*i].outputs) {
                *side += output * features;
            }
            n += 1;
        }
        // Neighbors along a line, or all on one side, leave the plane open.
        let inverse = normal.try_inverse().filter(|inv| n == N_NEIGHBORS && inv.m11 < 1.0)?;
        Some([0, 1, 2].map(|k| ((inverse * sides[k]).x - step.outputs[k]).powi(2)))
    }
}

/// Numbers of the pushes that the rows belong to; those that start alike have the same.
fn start_groups(rows: &[&StepRow]) -> Vec<usize> {
    let mut starts: Vec<&StepRow> = Vec::new();
    let mut groups: Vec<usize> = Vec::with_capacity(rows.len());
    for (i, row) in rows.iter().enumerate() {
        let is_same = |a: &StepRow, b: &StepRow| (&a.recording, a.push) == (&b.recording, b.push);
        let group = if i > 0 && is_same(row, rows[i - 1]) {
            groups[i - 1]
        } else {
            let alike = |start: &&StepRow| length(offset(row, start)) < REPEAT;
            starts.iter().position(alike).unwrap_or_else(|| {
                starts.push(row);
                starts.len() - 1
            })
        };
        groups.push(group);
    }
    groups
}

fn near(
    row: &StepRow,
    start: usize,
    rows: &[&StepRow],
    starts: &[usize],
) -> Vec<(usize, [f64; 2])> {
    let mut near: Vec<_> = (0..rows.len())
        .filter(|&i| starts[i] != start)
        .map(|i| (i, offset(rows[i], row)))
        .filter(|(_, offset)| length(*offset) < FARTHEST)
        .collect();
    near.sort_by(|(_, a), (_, b)| length(*a).total_cmp(&length(*b)));
    near
}

/// From one step to another, on the scales of p and β.
fn offset(to: &StepRow, from: &StepRow) -> [f64; 2] {
    [(to.p - from.p) / P_SCALE, (to.beta - from.beta) / BETA_SCALE]
}

fn length([x, y]: [f64; 2]) -> f64 {
    x.hypot(y)
}

#[cfg(test)]
mod tests {
    use dataset::StepRow;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::{Errors, Steps, has_equal_edges};

    /// One-step pushes at random places of two edges: a plane, plus `shift` on the second edge and
    /// uniform scatter of ± `noise`.
    fn steps(shift: f64, noise: f64) -> Steps {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let rows: Vec<_> = (0..800)
            .map(|push| {
                let edge = push % 2;
                let (p, beta) = (rng.random_range(0.0..1.0), rng.random_range(-1.0..1.0));
                let scatter = noise * rng.random_range(-1.0..1.0);
                let dx = 0.1 * p - 0.2 * beta + f64::from(edge) * shift + scatter;
                StepRow { edge, push, p, beta, dx, dy: dx, dtheta: dx, ..StepRow::default() }
            })
            .collect();
        Steps::new(&rows.iter().collect::<Vec<_>>(), 2)
    }

    fn dx_errors(steps: &Steps) -> [f64; 2] {
        let Errors { own, other, n } = steps.errors(&steps.edges);
        assert!(n > 700, "{n}");
        [own[0], other[0]]
    }

    #[test]
    fn edges_alike_predict_each_other_and_others_do_not() {
        let [own, other] = dx_errors(&steps(0.0, 0.0));
        assert!(own < 1e-24 && other < 1e-24, "{own} {other}");
        let [own, other] = dx_errors(&steps(0.01, 0.0));
        assert!(own < 1e-24 && (other - 1e-4).abs() < 1e-12, "{own} {other}");
        let [own, other] = dx_errors(&steps(0.0, 0.001));
        assert!((other / own - 1.0).abs() < 0.1, "{}", other / own);
    }

    #[test]
    fn shuffling_removes_what_the_edges_have_of_their_own() {
        let steps = steps(0.003, 0.001);
        let ratio = steps.errors(&steps.edges).ratio();
        let shuffled = steps.shuffled(20);
        assert!(ratio > 5.0, "{ratio}");
        assert!(shuffled[0] > 0.8 && shuffled[19] < 1.25, "{shuffled:?}");
    }

    #[test]
    fn repeats_do_not_predict_each_other() {
        let row = |push: u32, p: f64| StepRow { push, p, ..StepRow::default() };
        let rows = [row(0, 0.5), row(1, 0.51), row(2, 0.6)];
        let steps = Steps::new(&rows.iter().collect::<Vec<_>>(), 2);
        assert_eq!(steps.steps[0].near.iter().map(|(i, _)| *i).collect::<Vec<_>>(), [2]);
    }

    #[test]
    fn a_square_has_equal_edges_and_a_rectangle_has_not() {
        assert!(has_equal_edges(&planar::Shape::square(0.09).unwrap()));
        assert!(!has_equal_edges(&planar::Shape::rectangle(0.09, 0.1).unwrap()));
    }
}
