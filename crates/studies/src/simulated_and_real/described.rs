//! The numbers that describe one table of steps.

use anyhow::{Context, Result};
use models::{
    Analytical, CharacteristicLength, Estimate, GpPushModel, Hybrid, StepObservation, learn_options,
};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::cells::neighbor_sd;
use crate::figures::inputs::SEED;
use crate::figures::models::steps::Steps;
use crate::held_out::{HeldOut, quantile, shuffled};

/// Training steps of the learning curves.
pub(super) const COUNTS: [usize; 5] = [20, 50, 100, 200, 500];
/// Shares of the steps below the quantiles.
pub(super) const SHARES: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];
const N_SPLITS: u64 = 6;
const MOST_TESTED: usize = 1000;
const MM: f64 = 1e3;
const DEGREES: f64 = 180.0 / std::f64::consts::PI;
/// Names of the outputs with their unit in the page, and what turns m and rad into it.
pub(super) const OUTPUTS: [(&str, &str, f64); 3] =
    [("Δx", "mm", MM), ("Δy", "mm", MM), ("Δθ", "°", DEGREES)];

/// A table of steps in numbers; outputs in the units of [`OUTPUTS`].
pub(super) struct Described {
    /// What it is.
    pub(super) name: &'static str,
    pub(super) n_steps: usize,
    /// Of each output, at [`SHARES`].
    pub(super) quantiles: [[f64; 5]; 3],
    /// Scatter of steps that begin alike, of each output.
    pub(super) neighbor_sd: [f64; 3],
    /// Normalized mean squared error of a model that misses nothing but this scatter.
    pub(super) scatter_nmse: f64,
    /// Friction of the pusher that the data claim.
    pub(super) nominal_friction: f64,
    /// Medians over the splits of the normalized mean squared error.
    pub(super) nominal_nmse: f64,
    pub(super) fitted_nmse: f64,
    pub(super) gp_nmse: [f64; 5],
    pub(super) hybrid_nmse: [f64; 5],
    /// Fitted to all steps.
    pub(super) friction: Estimate,
    /// Characteristic length, in m.
    pub(super) length: Estimate,
    /// That of uniform pressure, in m.
    pub(super) uniform_length: f64,
}

/// Errors on the held-out steps of one split.
struct Split {
    nominal: f64,
    fitted: f64,
    gp: Vec<f64>,
    hybrid: Vec<f64>,
}

impl Described {
    /// Describes a table and learns from it.
    ///
    /// # Errors
    /// A model that cannot be learned from these steps.
    pub(super) fn of(name: &'static str, data: &Steps) -> Result<Self> {
        let steps = &data.steps;
        let nominal = Analytical::nominal(data.friction)?;
        let fit = nominal.fit(steps)?.model;
        let CharacteristicLength::Given(length) = fit.length().clone() else {
            unreachable!("the fit of an ellipsoid gives its length")
        };
        let splits: Vec<Split> = (0..N_SPLITS)
            .into_par_iter()
            .map(|split| learn(&nominal, &shuffled(steps, SEED, split)))
            .collect::<Result<_>>()
            .with_context(|| format!("the {name} table"))?;
        let median =
            |value: &dyn Fn(&Split) -> f64| quantile(splits.iter().map(value).collect(), 0.5);
        let output = |k: usize| steps.iter().map(move |step| OUTPUTS[k].2 * step.outputs[k]);
        let sd = neighbor_sd(steps);
        let variance = |k: usize| {
            let mean = output(k).sum::<f64>() / steps.len() as f64;
            output(k).map(|value| (value - mean).powi(2)).sum::<f64>() / steps.len() as f64
        };
        let share = |k: usize| (OUTPUTS[k].2 * sd[k]).powi(2) / variance(k);
        Ok(Self {
            name,
            n_steps: steps.len(),
            quantiles: [0, 1, 2].map(|k| SHARES.map(|share| quantile(output(k).collect(), share))),
            neighbor_sd: [0, 1, 2].map(|k| OUTPUTS[k].2 * sd[k]),
            scatter_nmse: (0..3).map(share).sum::<f64>() / 3.0,
            nominal_friction: data.friction,
            nominal_nmse: median(&|split| split.nominal),
            fitted_nmse: median(&|split| split.fitted),
            gp_nmse: std::array::from_fn(|i| median(&|split| split.gp[i])),
            hybrid_nmse: std::array::from_fn(|i| median(&|split| split.hybrid[i])),
            friction: fit.pusher_friction().clone(),
            length,
            uniform_length: nominal.characteristic_length(&steps[0].input),
        })
    }
}

fn learn(nominal: &Analytical, steps: &[StepObservation]) -> Result<Split> {
    let most = COUNTS[COUNTS.len() - 1];
    let (train, test) = steps.split_at_checked(most).context("at least 501 steps are needed")?;
    let test = HeldOut::new(&test[..test.len().min(MOST_TESTED)]);
    let options = learn_options();
    let (mut gp, mut hybrid) = (Vec::new(), Vec::new());
    for count in COUNTS {
        let base = nominal.fit(&train[..count])?.model;
        gp.push(test.nmse(&GpPushModel::learn(&train[..count], &options)?.0)?);
        hybrid.push(test.nmse(&Hybrid::learn(base, &train[..count], &options)?.0)?);
    }
    let fitted = test.nmse(&nominal.fit(train)?.model)?;
    Ok(Split { nominal: test.nmse(nominal)?, fitted, gp, hybrid })
}
