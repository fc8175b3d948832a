//! The corner of the real table that fails, beside its mirror image.

use anyhow::{Result, ensure};
use diagnosis::Cell;
use models::ChannelObservation;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use report::{ColorMap, Figure, HeatMap, Panel};

use super::source::Compared;
use crate::residual_grid::{grid, largest};

/// Number, its sign, its unit for people, and what turns SI into it.
pub(super) const NUMBERS: [(&str, &str, &str, f64); 3] = [
    ("dx", "Δx", "mm", 1e3),
    ("dy", "Δy", "mm", 1e3),
    ("dtheta", "Δθ", "°", 180.0 / std::f64::consts::PI),
];
/// The corner: p above, β above, in rad. Its mirror image has 1 − p and −β.
const P: f64 = 0.8;
const BETA: f64 = 0.3;
pub(super) const N_EXCHANGES: usize = 9999;
const SEED: u64 = 1;

/// Errors in the corner and in its mirror image, over the numbers of [`NUMBERS`].
pub(super) struct Corner {
    pub(super) here: Errors,
    pub(super) mirrored: Errors,
    /// How often steps exchanged at random between the two differ as much in their mean squares.
    pub(super) chance: [f64; 3],
    /// Share of the squared error of each number on the worst hundredth of the steps.
    pub(super) worst_hundredth: [f64; 3],
}

/// Errors of some steps, in mm, mm and degrees.
pub(super) struct Errors {
    pub(super) n_steps: usize,
    pub(super) rms: [f64; 3],
    pub(super) median: [f64; 3],
}

impl Corner {
    pub(super) fn of(table: &Compared) -> Result<Self> {
        let residuals: Vec<(f64, f64, [f64; 3])> = table
            .observations
            .steps()
            .iter()
            .zip(table.predictions.steps())
            .filter_map(|(step, predicted)| {
                let (p, beta) = place(step);
                let residual = |k: usize| Some(NUMBERS[k].3 * (step.observed[k]? - predicted[k]?));
                Some((p, beta, [residual(0)?, residual(1)?, residual(2)?]))
            })
            .collect();
        let of = |is_there: &dyn Fn(f64, f64) -> bool| {
            let steps = residuals.iter().filter(|(p, beta, _)| is_there(*p, *beta));
            steps.map(|(_, _, errors)| *errors).collect::<Vec<_>>()
        };
        let here = of(&|p, beta| p > P && beta > BETA);
        let mirrored = of(&|p, beta| 1.0 - p > P && -beta > BETA);
        ensure!(!here.is_empty() && !mirrored.is_empty(), "the table has no steps in its corners");
        let worst = |k: usize| {
            let mut squares: Vec<f64> = residuals.iter().map(|(_, _, e)| e[k] * e[k]).collect();
            squares.sort_by(|a, b| b.total_cmp(a));
            let n = squares.len().div_ceil(100);
            squares[..n].iter().sum::<f64>() / squares.iter().sum::<f64>()
        };
        Ok(Self {
            chance: [0, 1, 2].map(|k| chance([&here, &mirrored], k)),
            here: Errors::of(&here),
            mirrored: Errors::of(&mirrored),
            worst_hundredth: [0, 1, 2].map(worst),
        })
    }

    /// Maps of the root mean square error over p and β.
    pub(super) fn picture(&self, table: &Compared) -> Result<String> {
        let mut figure = Figure::new(1, 3).panel_size(300.0, 290.0);
        for (name, sign, unit, per) in NUMBERS {
            let value = |cell: &Cell| Some(per * cell.rms);
            let panel = Panel::new("contact position p", "push direction β / °");
            let panel = panel.title(&format!("error of {sign}"));
            figure = figure.with(match grid(&table.nominal, name, value) {
                Some(grid) => {
                    let map = HeatMap::new(grid, &format!("RMS error / {unit}"));
                    panel.with(
                        map.map(ColorMap::Viridis)
                            .range(0.0, largest(&table.nominal, &[name], value)),
                    )
                }
                None => panel,
            });
        }
        Ok(figure
            .named("Error of the analytical model on the MIT square's one-step pushes")
            .svg()?)
    }
}

/// The share of random exchanges of steps between two places after which the mean squares of a number
/// are as many times each other as they are, or more.
fn chance(places: [&[[f64; 3]]; 2], k: usize) -> f64 {
    let n = places[0].len();
    let mut squares: Vec<f64> = places.concat().iter().map(|errors| errors[k].powi(2)).collect();
    let apart = |squares: &[f64]| {
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        (mean(&squares[..n]) / mean(&squares[n..])).ln().abs()
    };
    let seen = apart(&squares);
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let as_far = (0..N_EXCHANGES).filter(|_| {
        squares.shuffle(&mut random);
        apart(&squares) >= seen
    });
    (as_far.count() + 1) as f64 / (N_EXCHANGES + 1) as f64
}

/// p and β, which the mapping has turned into the step's geometry.
fn place(step: &ChannelObservation) -> (f64, f64) {
    let input = &step.input;
    let shape = input.object.shape();
    let center = input.pose_wb.inverse_transform_point(&input.track.start());
    let contact = shape.contact(&center, input.pusher_radius);
    let motion = input.pose_wb.inverse_rotate(&input.track.mean_velocity());
    let normal = shape.inward_normal_at(contact.edge, contact.p);
    (contact.p, planar::cross(&normal, &motion).atan2(normal.dot(&motion)))
}

impl Errors {
    fn of(errors: &[[f64; 3]]) -> Self {
        let n = errors.len();
        let rms = |k: usize| (errors.iter().map(|e| e[k] * e[k]).sum::<f64>() / n as f64).sqrt();
        let median =
            |k: usize| crate::held_out::quantile(errors.iter().map(|e| e[k].abs()).collect(), 0.5);
        Self { n_steps: n, rms: [0, 1, 2].map(rms), median: [0, 1, 2].map(median) }
    }
}

#[cfg(test)]
mod tests {
    use super::chance;

    /// Errors of some size, a few of which are much larger.
    fn errors(n: usize, size: f64, n_large: usize) -> Vec<[f64; 3]> {
        let error = |i: usize| {
            let error = size * (1.7 * i as f64).sin();
            [if i < n_large { 20.0 * size } else { error }, error, 0.1]
        };
        (0..n).map(error).collect()
    }

    #[test]
    fn places_differ_where_their_sizes_do_and_not_by_an_outlier() {
        let (same, twice, one) = (errors(80, 0.3, 0), errors(70, 0.6, 0), errors(70, 0.3, 1));
        assert!(chance([&same, &twice], 1) < 0.001);
        assert!(chance([&same, &errors(70, 0.3, 0)], 1) > 0.3);
        // One step alone lies in either place by chance.
        assert!(chance([&same, &one], 0) > 0.2);
        assert!(chance([&same, &errors(70, 0.3, 12)], 0) < 0.001);
    }
}
