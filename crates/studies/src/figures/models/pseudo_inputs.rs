//! Figure 5.4: how many pseudo-inputs a sparse process needs.

use anyhow::{Context, Result};
use gp_core::{Posterior, SquaredExponential};
use gp_sparse::{Approximation, Placement, PseudoInputs, SparseGp, SparseOptions, SparseSettings};
use models::{StepObservation, learn_options};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use report::{Axis, Claim, Color, Figure, Guide, LegendPlace, Panel, Table};

use super::rows::{LearntGp, Rows};
use super::steps::Steps;
use crate::figures::claims::judged;
use crate::figures::inputs::{Inputs, SEED};
use crate::figures::quartiles::Quartiles;
use crate::figures::sketch::Sketch;
use crate::held_out::{LEVEL_95, Scores, shuffled};

/// What this figure settles.
pub(crate) const CLAIMS: [&str; 3] = [
    "4. SPGP with pseudo-inputs at the data equals the GP.",
    "6. 50–80 pseudo-inputs suffice.",
    "18. The SPGP matches or beats the GP.",
];
const COUNTS: [usize; 8] = [5, 10, 20, 35, 50, 65, 80, 120];
const QUICK_COUNTS: [usize; 4] = [5, 20, 50, 80];
const SPLITS: (u64, u64) = (6, 2);
const MOST_TRAINING: (usize, usize) = (400, 150);
const MOST_TESTED: usize = 1000;
/// Errors closer than this, relative, are the same.
const SAME: f64 = 0.05;
/// Largest difference that rounding leaves, in predicted standard deviations.
const ROUNDING: f64 = 1e-3;
const KINDS: [(&str, &str, Approximation, Color); 2] = [
    ("SPGP (FITC), as in the thesis", "fitc", Approximation::Fitc, Color::VERMILION),
    ("VFE", "vfe", Approximation::Vfe, Color::SKY),
];

/// The scores of one split.
struct Split {
    exact: Scores,
    /// By approximation, by number of pseudo-inputs.
    sparse: [Vec<Scores>; 2],
    /// Largest difference of mean and standard deviation with pseudo-inputs at the data.
    apart: f64,
}

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let data = Steps::of(inputs)?;
    let quick = inputs.quick();
    let (n_splits, most) =
        if quick { (SPLITS.1, MOST_TRAINING.1) } else { (SPLITS.0, MOST_TRAINING.0) };
    let counts = if quick { &QUICK_COUNTS[..] } else { &COUNTS[..] };
    let n_train = most.min(data.steps.len() / 2);
    let counts: Vec<usize> = counts.iter().copied().filter(|count| 2 * count <= n_train).collect();
    let learn = |split: u64| {
        let steps = shuffled(&data.steps, SEED, split);
        learn(&steps, n_train, &counts).with_context(|| format!("split {split}"))
    };
    let splits: Vec<Split> = (0..n_splits).into_par_iter().map(learn).collect::<Result<_>>()?;
    let curves = Curves::of(&counts, &splits);
    let caption = format!(
        "Error, negative log density (outputs per meter of way) and share inside the 95 % intervals \
         of sparse processes on steps not used for training, means of the three outputs; medians and \
         quartiles of {n_splits} random splits with {n_train} training steps. Pseudo-inputs and \
         hyperparameters are learnt together. Dashed: the exact process from the same steps.",
    );
    let alt = "Three panels over the number of pseudo-inputs: errors, densities and shares inside of two \
               sparse approximations beside the dashed line of the exact process.";
    let apart = splits.iter().map(|split| split.apart).fold(0.0, f64::max);
    Ok(Sketch::new(curves.figure(), curves.table(), &caption, alt)
        .claim(at_the_data(apart, n_train))
        .claim(curves.enough())
        .claim(curves.against_exact()))
}

fn learn(steps: &[StepObservation], n_train: usize, counts: &[usize]) -> Result<Split> {
    let (train, test) = steps.split_at(n_train);
    let (train, test) = (Rows::of(train), Rows::of(&test[..test.len().min(MOST_TESTED)]));
    let exact = train.learn()?;
    let sparse = |approximation: Approximation| {
        let score = |&count: &usize| {
            let learn = |k: usize| sparse(&train, k, approximation, count);
            let processes = [learn(0)?, learn(1)?, learn(2)?];
            test.scores(processes.each_ref().map(|process| process as &dyn Posterior))
                .with_context(|| format!("{approximation:?}, {count} pseudo-inputs"))
        };
        counts.iter().map(score).collect::<Result<Vec<_>>>()
    };
    let apart = (0..3).map(|k| apart(&exact[k], &train, k, &test)).collect::<Result<Vec<_>>>()?;
    Ok(Split {
        sparse: [sparse(KINDS[0].2)?, sparse(KINDS[1].2)?],
        apart: apart.into_iter().fold(0.0, f64::max),
        exact: test.scores(exact.each_ref().map(|exact| &exact.gp as &dyn Posterior))?,
    })
}

fn sparse(rows: &Rows, k: usize, approximation: Approximation, count: usize) -> Result<SparseGp> {
    let options = SparseOptions {
        settings: SparseSettings { approximation, ..SparseSettings::default() },
        pseudo_inputs: PseudoInputs::Learnt { count, placement: Placement::default() },
        warm_start_rows: 100,
        prior: learn_options().prior,
        ..SparseOptions::default()
    };
    let kernel = SquaredExponential::unit(2)?;
    Ok(SparseGp::learn(kernel, rows.x.as_ref(), &rows.y[k], &options)?.0)
}

/// How far FITC with pseudo-inputs at the data is from the exact process of an output: largest
/// difference of mean or standard deviation of an observation over the latter.
fn apart(exact: &LearntGp, train: &Rows, k: usize, test: &Rows) -> Result<f64> {
    let settings =
        SparseSettings { approximation: Approximation::Fitc, ..SparseSettings::default() };
    let noise_variance = exact.gp.noise_variance();
    let (x, y) = (train.x.as_ref(), &train.y[k]);
    let sparse = SparseGp::fit(exact.kernel.clone(), x, y, x, noise_variance, settings)?;
    let (mean, variance) = sparse.predict_observation(test.x.as_ref())?;
    let (exact_mean, exact_variance) = exact.gp.predict_observation(test.x.as_ref())?;
    let difference = |i: usize| {
        let sd = exact_variance[i].sqrt();
        ((mean[i] - exact_mean[i]).abs() / sd).max((variance[i].sqrt() / sd - 1.0).abs())
    };
    Ok((0..mean.len()).map(difference).fold(0.0, f64::max))
}

/// Curves over the number of pseudo-inputs: error, density and share inside 95 %.
struct Curves {
    counts: Vec<f64>,
    exact: [Quartiles; 3],
    sparse: [[Quartiles; 3]; 2],
}

impl Curves {
    fn of(counts: &[usize], splits: &[Split]) -> Self {
        let n = counts.len();
        let of = |scores: &dyn Fn(&Split, usize) -> Scores| {
            [0, 1, 2].map(|which| {
                Quartiles::of(splits, n, |split, i| match which {
                    0 => scores(split, i).nmse(),
                    1 => scores(split, i).mean(|score| score.nlpd),
                    _ => scores(split, i).mean(|score| score.coverage[LEVEL_95]),
                })
            })
        };
        Self {
            counts: counts.iter().map(|&count| count as f64).collect(),
            exact: of(&|split, _| split.exact),
            sparse: [0, 1].map(|kind| of(&|split, i| split.sparse[kind][i])),
        }
    }

    fn figure(&self) -> Figure {
        let axes = [
            ("error", Axis::new("normalized mean squared error").log(), 1.0),
            ("density", Axis::new("negative log density / nat"), 1.0),
            ("95 % intervals", Axis::new("share of steps inside / %"), 100.0),
        ];
        let mut figure = Figure::new(1, 3).panel_size(320.0, 300.0).one_legend();
        for (which, (title, y, factor)) in axes.into_iter().enumerate() {
            let x = Axis::new("pseudo-inputs").log();
            let mut panel = Panel::new(x, y).title(title).legend(LegendPlace::Below);
            if which == 2 {
                panel = panel.with(Guide::horizontal(95.0));
            }
            let exact = self.exact[which].times(factor);
            panel = exact.draw_level(panel, &self.counts, Color::BLUE, "exact GP");
            for ((label, _, _, color), curves) in KINDS.iter().zip(&self.sparse) {
                panel = curves[which].times(factor).draw(panel, &self.counts, *color, label);
            }
            figure = figure.with(panel);
        }
        figure
    }

    fn table(&self) -> Table {
        let mut table = Table::new().column("n_pseudo_inputs", &self.counts);
        let kinds = KINDS.iter().map(|kind| kind.1).zip(&self.sparse);
        for (name, curves) in std::iter::once(("gp", &self.exact)).chain(kinds) {
            for (what, values) in ["nmse", "nlpd", "inside_95"].iter().zip(curves) {
                table = values.columns(table, &format!("{name}_{what}"));
            }
        }
        table
    }

    /// Median errors of FITC over the exact process's, by number of pseudo-inputs.
    fn ratios(&self, kind: usize) -> Vec<f64> {
        let pairs = self.sparse[kind][0].median().iter().zip(self.exact[0].median());
        pairs.map(|(sparse, exact)| sparse / exact).collect()
    }

    fn enough(&self) -> Claim {
        let ratios = self.ratios(0);
        let fewest = |kind: usize| {
            let ratios = self.ratios(kind);
            let first = ratios.iter().position(|ratio| *ratio < 1.0 + SAME);
            first.map_or("none".to_owned(), |i| self.counts[i].to_string())
        };
        let value = format!(
            "error over the exact GP's {}; the fewest within 5 % of it: {} (VFE: {})",
            list(&self.counts, &ratios),
            fewest(0),
            fewest(1)
        );
        let mut claimed = (0..ratios.len()).filter(|&i| (50.0..=80.0).contains(&self.counts[i]));
        let holds = claimed.clone().count() > 0 && claimed.all(|i| ratios[i] < 1.0 + SAME);
        let reason = "FITC with every number from 50 to 80 within 5 % of the exact process's error, \
                      medians; whether fewer suffice is told by the value";
        judged(CLAIMS[1], value, holds, reason)
    }

    fn against_exact(&self) -> Claim {
        let last = self.counts.len() - 1;
        let [ratio, vfe] = [0, 1].map(|kind| self.ratios(kind)[last]);
        let [density, vfe_density] =
            [0, 1].map(|kind| self.sparse[kind][1].median()[last] - self.exact[1].median()[last]);
        let value = format!(
            "with {} pseudo-inputs the error is {ratio:.3} times the GP's (VFE {vfe:.3}), the negative \
             log density {density:+.3} nats above (VFE {vfe_density:+.3})",
            self.counts[last]
        );
        let reason = "FITC with the most pseudo-inputs drawn: error at most 5 % above the exact \
                      process's, and density at most 0.05 nats worse, medians, on the same steps";
        judged(CLAIMS[2], value, ratio < 1.0 + SAME && density < SAME, reason)
    }
}

fn at_the_data(apart: f64, n_train: usize) -> Claim {
    let value = format!(
        "largest difference of mean or standard deviation at unseen steps: {apart:.1e} standard \
         deviations of an observation ({n_train} pseudo-inputs, the GP's hyperparameters)"
    );
    let reason = "the same to a thousandth of a standard deviation: the covariance of the pseudo-inputs \
                  is regularised by 1e-8 of its diagonal";
    judged(CLAIMS[0], value, apart < ROUNDING, reason)
}

fn list(counts: &[f64], ratios: &[f64]) -> String {
    let items = counts.iter().zip(ratios).map(|(count, ratio)| format!("{ratio:.2} ({count})"));
    items.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use report::Verdict;

    use super::{Curves, Quartiles, at_the_data};

    /// Curves with these errors and densities of FITC where the exact process has 1 and 0.
    fn curves(errors: [f64; 4], densities: [f64; 4]) -> Curves {
        let level = |value: f64| Quartiles::of(&[()], 4, |(), _| value);
        let curve = |values: [f64; 4]| Quartiles::of(&[()], 4, |(), i| values[i]);
        let exact = [level(1.0), level(0.0), level(0.95)];
        let sparse = [curve(errors), curve(densities), level(0.95)];
        Curves { counts: vec![20.0, 50.0, 80.0, 120.0], sparse: [sparse, exact.clone()], exact }
    }

    #[test]
    fn enough_is_within_five_percent_from_fifty_to_eighty() {
        let verdict = |errors| curves(errors, [0.0; 4]).enough().verdict;
        assert_eq!(verdict([2.0, 1.04, 1.01, 1.2]), Verdict::Holds);
        assert_eq!(verdict([1.0, 1.06, 1.01, 1.0]), Verdict::DoesNotHold);
        assert!(curves([1.2, 1.2, 1.2, 1.2], [0.0; 4]).enough().value.contains("none (VFE: 20)"));
    }

    #[test]
    fn a_match_is_in_error_and_density() {
        let verdict = |error, density| {
            curves([2.0, 2.0, 2.0, error], [1.0, 1.0, 1.0, density]).against_exact().verdict
        };
        assert_eq!(verdict(0.9, 0.0), Verdict::Holds);
        assert_eq!(verdict(0.9, 0.2), Verdict::DoesNotHold);
        assert_eq!(verdict(1.1, 0.0), Verdict::DoesNotHold);
        assert_eq!(at_the_data(1e-2, 9).verdict, Verdict::DoesNotHold);
    }
}
