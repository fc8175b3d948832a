//! Three outputs of one-step pushes, each by a process of its own and together.

use std::fmt::Write;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use faer::Mat;
use gp_core::{
    Coregionalization, Gp, GpBuilder, Kernel, Mean, Posterior, SquaredExponential, White,
};
use indicatif::{ProgressBar, ProgressStyle};
use models::{OUTPUTS, StepObservation};
use nalgebra::{Matrix3, Vector3};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use crate::held_out::{quantile, shuffled};

/// Training steps, and random splits with so many.
const COUNTS: [(usize, u64); 2] = [(100, 10), (500, 5)];
/// Steps of a split that are not tested on.
const MOST: usize = 1500;
const SEED: u64 = 1;
/// Of outputs of variance 1, where the noise is a part of the kernel.
const LEAST_NOISE: f64 = 1e-6;

/// Who predicts the outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// A process each.
    Alone,
    /// One coregionalised process, and noise of each output's own.
    Together,
    /// The same, and noise that the outputs share.
    TogetherWithNoise,
}

const KINDS: [(Kind, &str); 3] = [
    (Kind::Alone, "a process each"),
    (Kind::Together, "one for all, noise of their own"),
    (Kind::TogetherWithNoise, "one for all, noise that goes together"),
];

/// On steps that were not learnt from.
#[derive(Clone, Copy)]
struct Score {
    /// Squared error over variance, mean of the outputs.
    nmse: f64,
    /// Mean negative log density of a step's three outputs together, in nats of m, m and rad.
    nlpd: f64,
    /// ln p of what was learnt from, in nats of the same.
    log_evidence: f64,
}

/// Scores of all kinds.
pub(super) struct SharedOutputs {
    n_steps: usize,
    /// By kind, by count, one a split.
    scores: Vec<[Vec<Score>; COUNTS.len()]>,
}

impl SharedOutputs {
    /// Learns from random parts of a table of one-step pushes.
    ///
    /// # Errors
    /// A table that cannot be read or is too short; what a process says.
    pub(super) fn of(path: &Path) -> Result<Self> {
        let (steps, _) = super::source::one_step_pushes(path)?;
        ensure!(steps.len() > MOST, "{}: fewer than {MOST} steps", path.display());
        let mut jobs = Vec::new();
        for (place, (_, n_splits)) in COUNTS.iter().enumerate().rev() {
            for kind in 0..KINDS.len() {
                jobs.extend((0..*n_splits).map(|split| (kind, place, split)));
            }
        }
        let style = ProgressStyle::with_template("{bar:30} {pos}/{len} processes, {elapsed}")?;
        let bar = ProgressBar::new(jobs.len() as u64).with_style(style);
        let score = |(kind, place, split): &(usize, usize, u64)| {
            let shuffled = shuffled(&steps, SEED, *split);
            let (train, test) = shuffled.split_at(MOST);
            let train = &train[..COUNTS[*place].0];
            let found = Split::new(train, test).score(KINDS[*kind].0);
            bar.inc(1);
            found.with_context(|| format!("{}, split {split}", KINDS[*kind].1))
        };
        let found = jobs.par_iter().map(score).collect::<Result<Vec<_>>>()?;
        bar.finish_and_clear();
        let mut scores = vec![[const { Vec::new() }; COUNTS.len()]; KINDS.len()];
        for ((kind, place, _), score) in jobs.into_iter().zip(found) {
            scores[kind][place].push(score);
        }
        Ok(Self { n_steps: steps.len(), scores })
    }

    /// The section of the page.
    pub(super) fn text(&self) -> String {
        let splits: Vec<String> = COUNTS.iter().map(|(n, k)| format!("{k} with {n}")).collect();
        let mut text = HEAD.to_owned();
        let _ = writeln!(
            text,
            "Medians over random splits of the {} steps ({}), with the lowest and the highest of them;\nevery \
             split is tested on {} steps that none has seen.\n",
            self.n_steps,
            splits.join(", "),
            self.n_steps - MOST
        );
        text += &self.table("error²/variance, mean of the outputs", |s| s.nmse, 4);
        text += "\n";
        text += &self.table(
            "negative log density of a step's outputs together, in nats",
            |s| s.nlpd,
            3,
        );
        text += "\n";
        text += &self.table(
            "log evidence of what was learnt from, in nats a step",
            |s| s.log_evidence,
            3,
        );
        text + "\n" + &self.verdict()
    }

    fn table(&self, corner: &str, value: fn(&Score) -> f64, digits: usize) -> String {
        let heads = COUNTS.iter().map(|(n, _)| format!(" {n} steps |"));
        let mut text = format!("| {corner} |{}\n|---|---|---|\n", heads.collect::<String>());
        for ((_, name), by_count) in KINDS.iter().zip(&self.scores) {
            let _ = write!(text, "| {name} |");
            for scores in by_count {
                let at = |share| {
                    let value = quantile(scores.iter().map(value).collect(), share);
                    format!("{value:.digits$}").replace('-', "−")
                };
                let _ = write!(text, " {} ({} to {}) |", at(0.5), at(0.0), at(1.0));
            }
            text.push('\n');
        }
        text
    }

    /// By how much those together are better than those alone, split by split.
    fn verdict(&self) -> String {
        let gain = |kind: usize, place: usize, value: fn(&Score) -> f64| {
            let pairs = self.scores[0][place].iter().zip(&self.scores[kind][place]);
            let gains: Vec<f64> = pairs.map(|(alone, one)| value(alone) - value(one)).collect();
            let n_better = gains.iter().filter(|gain| **gain > 0.0).count();
            (quantile(gains.clone(), 0.5), n_better, gains.len())
        };
        let mut text = "Against a process each, split by split:\n\n".to_owned();
        for (kind, (_, name)) in KINDS.iter().enumerate().skip(1) {
            let told = COUNTS.iter().enumerate().map(|(place, (n, _))| {
                let (error, n_error, of) = gain(kind, place, |score| score.nmse);
                let (density, n_density, _) = gain(kind, place, |score| score.nlpd);
                let alone = self.scores[0][place].iter().map(|score| score.nmse).collect();
                let error = 100.0 * error / quantile(alone, 0.5);
                let word = |gain: f64, words: [&'static str; 2]| words[usize::from(gain < 0.0)];
                let [is_error, is_density] =
                    [word(error, ["smaller", "larger"]), word(density, ["larger", "smaller"])];
                format!(
                    "with {n} steps the error is {is_error} by {:.1} % (smaller in {n_error} of {of} \
                     splits) and the density {is_density} by {:.3} nats a step (larger in \
                     {n_density} of {of})",
                    error.abs(),
                    density.abs()
                )
            });
            let _ = writeln!(text, "- {name}: {}.", told.collect::<Vec<_>>().join("; "));
        }
        text
    }
}

/// The outputs of each step with their covariance, and the log evidence of what was learnt from.
type Predicted = (Vec<(Vector3<f64>, Matrix3<f64>)>, f64);

/// Steps to learn from and others, with outputs of mean 0 and variance 1 in the former.
struct Split {
    x: Mat<f64>,
    outputs: [Vec<f64>; 3],
    x_star: Mat<f64>,
    observed: Vec<Vector3<f64>>,
    /// Of the steps learnt from, in m, m and rad.
    sd: Vector3<f64>,
    /// Of the others, over those.
    variance: Vector3<f64>,
}

impl Split {
    fn new(train: &[StepObservation], test: &[StepObservation]) -> Self {
        let inputs = |steps: &[StepObservation]| {
            Mat::from_fn(steps.len(), 2, |i, d| {
                let input = &steps[i].input;
                if d == 0 { input.p() } else { input.beta() }
            })
        };
        let moments = |values: &dyn Fn(usize) -> Vector3<f64>, n: usize| {
            let mean = (0..n).map(values).sum::<Vector3<f64>>() / n as f64;
            let off = |i: usize| (values(i) - mean).map(|off| off * off);
            (mean, (0..n).map(off).sum::<Vector3<f64>>() / n as f64)
        };
        let (mean, variance) = moments(&|i| train[i].outputs, train.len());
        let sd = variance.map(f64::sqrt);
        let scaled = |step: &StepObservation| (step.outputs - mean).component_div(&sd);
        let observed: Vec<Vector3<f64>> = test.iter().map(scaled).collect();
        let (_, variance) = moments(&|i| observed[i], observed.len());
        let outputs = [0, 1, 2].map(|k| train.iter().map(|step| scaled(step)[k]).collect());
        Self { x: inputs(train), outputs, x_star: inputs(test), observed, sd, variance }
    }

    fn score(&self, kind: Kind) -> Result<Score> {
        let (predicted, log_evidence) = match kind {
            Kind::Alone => self.alone()?,
            Kind::Together | Kind::TogetherWithNoise => self.together(kind)?,
        };
        let n = self.observed.len() as f64;
        let log_unit: f64 = self.sd.iter().map(|sd| sd.ln()).sum();
        let (mut squares, mut density) = (Vector3::zeros(), 0.0);
        for (observed, (mean, covariance)) in self.observed.iter().zip(&predicted) {
            let off: Vector3<f64> = observed - mean;
            squares += off.map(|off| off * off);
            let root = covariance.cholesky().context("a covariance is positive")?;
            let log_size: f64 = root.l().diagonal().iter().map(|x| x.ln()).sum();
            let normal = 1.5 * std::f64::consts::TAU.ln();
            density += 0.5 * off.dot(&root.solve(&off)) + log_size + normal + log_unit;
        }
        let n_learnt = self.x.nrows() as f64;
        Ok(Score {
            nmse: (squares / n).component_div(&self.variance).mean(),
            nlpd: density / n,
            log_evidence: log_evidence / n_learnt - log_unit,
        })
    }

    fn alone(&self) -> Result<Predicted> {
        let mut predicted = vec![(Vector3::zeros(), Matrix3::zeros()); self.observed.len()];
        let mut log_evidence = 0.0;
        for (k, y) in self.outputs.iter().enumerate() {
            let builder = Gp::builder(SquaredExponential::unit(2)?);
            let gp = builder.mean(Mean::Fixed(0.0)).fit(&self.x, y)?;
            let (mean, variance) = gp.predict_observation(self.x_star.as_ref())?;
            for (i, (at, spread)) in predicted.iter_mut().enumerate() {
                (at[k], spread[(k, k)]) = (mean[i], variance[i]);
            }
            log_evidence += gp.log_marginal_likelihood();
        }
        Ok((predicted, log_evidence))
    }

    fn together(&self, kind: Kind) -> Result<Predicted> {
        let known = |output: &Vec<f64>| output.iter().map(|value| Some(*value)).collect();
        let outputs: Vec<Vec<Option<f64>>> = self.outputs.iter().map(known).collect();
        let (x, y) = Coregionalization::stack(&self.x, &outputs)?;
        let gp = builder(kind)?.fit(&x, &y)?;
        let rows: Vec<usize> = (0..self.x_star.nrows()).collect();
        let of = |i: &usize| {
            let entry = |k: usize, d: usize| if d == 2 { k as f64 } else { self.x_star[(*i, d)] };
            let joint = gp.predict_joint(Mat::from_fn(OUTPUTS.len(), 3, entry).as_ref())?;
            let covariance = joint.covariance();
            let spread = Matrix3::from_fn(|a, b| {
                covariance[(a, b)] + if a == b { gp.noise_variance() } else { 0.0 }
            });
            Ok((Vector3::from_column_slice(joint.mean()), spread))
        };
        let predicted = rows.par_iter().map(of).collect::<Result<_>>()?;
        Ok((predicted, gp.log_marginal_likelihood()))
    }
}

fn builder(kind: Kind) -> Result<GpBuilder> {
    let outputs = || Coregionalization::new(OUTPUTS.len()).active(&[2]);
    let smooth = SquaredExponential::unit(2)?.active(&[0, 1]) * outputs();
    let kernel: Box<dyn Kernel> = match kind {
        Kind::TogetherWithNoise => {
            let noisy = smooth + White::new(1.0).active(&[0, 1]) * outputs();
            Box::new(noisy)
        }
        Kind::Alone | Kind::Together => {
            let own = Coregionalization::independent(OUTPUTS.len()).active(&[2]);
            let noisy = smooth + White::new(1.0) * own;
            Box::new(noisy)
        }
    };
    Ok(Gp::builder(kernel)
        .mean(Mean::Fixed(0.0))
        .fix("squared_exponential.signal_variance", 1.0)
        .fix("white.variance", 1.0)
        .fix("noise_variance", LEAST_NOISE))
}

const HEAD: &str = "
## Outputs that share, on the one-step pushes

Δx, Δy and Δθ of (p, β), each by an exact Gaussian process of its own, or all by one (a squared exponential
times a learnt covariance of the outputs, `gp_core::Coregionalization`), with noise of each output's own or noise
that goes together.

```text
cargo xtask real-comparison --data DIR --only shared-outputs
```

";
