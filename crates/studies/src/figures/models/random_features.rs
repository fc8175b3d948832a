//! Figure 5.5: how many random features an approximate process needs.

use anyhow::{Context, Result};
use gp_core::Posterior;
use gp_rff::{
    FeatureOptions, Form, Hyperparameters, RandomFeatures, RffGp, RffOptions, Sampling, Spectrum,
};
use models::{StepObservation, learn_options};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use report::{Axis, Claim, Color, Figure, LegendPlace, Panel, Table};

use super::rows::{LearntGp, Rows};
use super::steps::Steps;
use crate::figures::claims::judged;
use crate::figures::inputs::{Inputs, SEED};
use crate::figures::quartiles::Quartiles;
use crate::figures::sketch::Sketch;
use crate::held_out::{LEVEL_95, Scores, shuffled};

/// What this figure settles.
pub(crate) const CLAIMS: [&str; 1] = ["7. About 100 random features suffice."];
const COUNTS: [usize; 8] = [10, 20, 30, 50, 70, 100, 140, 200];
const QUICK_COUNTS: [usize; 4] = [20, 50, 100, 200];
/// The claim's number.
const CLAIMED: f64 = 100.0;
const SPLITS: (u64, u64) = (8, 3);
const MOST_TRAINING: (usize, usize) = (400, 150);
const MOST_TESTED: usize = 1000;
/// Errors closer than this, relative, are the same.
const SAME: f64 = 0.05;
const KINDS: [Kind; 5] = [
    Kind {
        label: "cosines, independent, as in the thesis",
        name: "cosines",
        form: Form::Cosines,
        sampling: Sampling::Independent,
        hyperparameters: Hyperparameters::SmallGp,
        color: Color::VERMILION,
    },
    Kind {
        label: "pairs, independent",
        name: "pairs",
        form: Form::Paired,
        sampling: Sampling::Independent,
        hyperparameters: Hyperparameters::SmallGp,
        color: Color::ORANGE,
    },
    Kind {
        label: "pairs, orthogonal",
        name: "pairs_orthogonal",
        form: Form::Paired,
        sampling: Sampling::Orthogonal,
        hyperparameters: Hyperparameters::SmallGp,
        color: Color::GREEN,
    },
    Kind {
        label: "pairs, low discrepancy",
        name: "pairs_low_discrepancy",
        form: Form::Paired,
        sampling: Sampling::LowDiscrepancy,
        hyperparameters: Hyperparameters::SmallGp,
        color: Color::PURPLE,
    },
    Kind {
        label: "the same, own likelihood",
        name: "own_likelihood",
        form: Form::Paired,
        sampling: Sampling::LowDiscrepancy,
        hyperparameters: Hyperparameters::OwnLikelihood,
        color: Color::SKY,
    },
];

/// A way to make features.
struct Kind {
    label: &'static str,
    /// In the table.
    name: &'static str,
    form: Form,
    sampling: Sampling,
    /// Those of the exact process on all rows, as the thesis, or the features' own.
    hyperparameters: Hyperparameters,
    color: Color,
}

/// The scores of one split.
struct Split {
    exact: Scores,
    /// By kind, by number of features.
    features: Vec<Vec<Scores>>,
}

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let data = Steps::of(inputs)?;
    let quick = inputs.quick();
    let (n_splits, most) =
        if quick { (SPLITS.1, MOST_TRAINING.1) } else { (SPLITS.0, MOST_TRAINING.0) };
    let counts = if quick { &QUICK_COUNTS[..] } else { &COUNTS[..] };
    let n_train = most.min(data.steps.len() / 2);
    let learn = |split: u64| {
        let steps = shuffled(&data.steps, SEED, split);
        learn(&steps, n_train, counts, split).with_context(|| format!("split {split}"))
    };
    let splits: Vec<Split> = (0..n_splits).into_par_iter().map(learn).collect::<Result<_>>()?;
    let curves = Curves::of(counts, &splits);
    let caption = format!(
        "Error and share inside the 95 % intervals of Bayesian linear regression on random features, on \
         steps not used for training, means of the three outputs; medians and quartiles of {n_splits} \
         random splits with {n_train} training steps, the features drawn anew in each. Lengthscales, \
         signal and noise are those of the exact process, which the dashed line shows, so that what \
         differs is how closely the features follow its kernel; or the most likely ones of the \
         features themselves (“own likelihood”), which take what these leave over for noise.",
    );
    let alt = "Two panels over the number of random features: errors and shares inside of five kinds of \
               features beside the dashed line of the exact process.";
    Ok(Sketch::new(curves.figure(), curves.table(), &caption, alt).claim(curves.claim()))
}

fn learn(steps: &[StepObservation], n_train: usize, counts: &[usize], seed: u64) -> Result<Split> {
    let (train, test) = steps.split_at(n_train);
    let (train, test) = (Rows::of(train), Rows::of(&test[..test.len().min(MOST_TESTED)]));
    let exact = train.learn()?;
    let of_kind = |kind: &Kind| {
        let score = |&count: &usize| {
            let fit = |k: usize| kind.fit(&exact[k], &train, k, count, seed);
            let processes = [fit(0)?, fit(1)?, fit(2)?];
            test.scores(processes.each_ref().map(|process| process as &dyn Posterior))
                .with_context(|| format!("{}, {count} features", kind.label))
        };
        counts.iter().map(score).collect::<Result<Vec<_>>>()
    };
    Ok(Split {
        features: KINDS.iter().map(of_kind).collect::<Result<_>>()?,
        exact: test.scores(exact.each_ref().map(|exact| &exact.gp as &dyn Posterior))?,
    })
}

impl Kind {
    /// Learns an output.
    fn fit(
        &self,
        exact: &LearntGp,
        rows: &Rows,
        k: usize,
        n_features: usize,
        seed: u64,
    ) -> Result<RffGp> {
        let (form, sampling) = (self.form, self.sampling);
        let options = FeatureOptions { n_features, form, sampling, seed };
        if self.hyperparameters == Hyperparameters::OwnLikelihood {
            let prior = learn_options().prior;
            let features = options;
            let options = RffOptions { features, n_starts: 1, prior, ..RffOptions::default() };
            return Ok(RffGp::learn(rows.x.as_ref(), &rows.y[k], &options)?.0);
        }
        let spectrum = Spectrum::SquaredExponential;
        let features = RandomFeatures::new(spectrum, exact.kernel.lengthscales(), options)?;
        let (signal, noise) = (exact.kernel.signal_variance(), exact.gp.noise_variance());
        Ok(RffGp::fit(features, rows.x.as_ref(), &rows.y[k], signal, noise)?)
    }
}

/// Error, and share inside 95 %, over the number of features.
struct Curves {
    counts: Vec<f64>,
    exact: [Quartiles; 3],
    features: Vec<[Quartiles; 3]>,
}

impl Curves {
    fn of(counts: &[usize], splits: &[Split]) -> Self {
        let n = counts.len();
        let of = |scores: &dyn Fn(&Split, usize) -> Scores| {
            [0, 1, 2].map(|which| {
                Quartiles::of(splits, n, |split, i| match which {
                    0 => scores(split, i).nmse(),
                    1 => scores(split, i).mean(|score| score.coverage[LEVEL_95]),
                    _ => scores(split, i).mean(|score| score.nlpd),
                })
            })
        };
        Self {
            counts: counts.iter().map(|&count| count as f64).collect(),
            exact: of(&|split, _| split.exact),
            features: (0..KINDS.len())
                .map(|kind| of(&|split, i| split.features[kind][i]))
                .collect(),
        }
    }

    fn figure(&self) -> Figure {
        let axes = [
            ("error", Axis::new("normalized mean squared error").log(), 1.0),
            ("95 % intervals", Axis::new("share of steps inside / %"), 100.0),
        ];
        let mut figure = Figure::new(1, 2).panel_size(420.0, 320.0).one_legend();
        for (which, (title, y, factor)) in axes.into_iter().enumerate() {
            let x = Axis::new("random features").log();
            let mut panel = Panel::new(x, y).title(title).legend(LegendPlace::Below);
            let exact = self.exact[which].times(factor);
            panel = exact.draw_level(panel, &self.counts, Color::BLUE, "exact GP");
            for (kind, curves) in KINDS.iter().zip(&self.features) {
                let curve = curves[which].times(factor);
                panel = curve.draw(panel, &self.counts, kind.color, kind.label);
            }
            figure = figure.with(panel);
        }
        figure
    }

    fn table(&self) -> Table {
        let mut table = Table::new().column("n_features", &self.counts);
        let kinds = KINDS.iter().map(|kind| kind.name).zip(&self.features);
        for (name, curves) in std::iter::once(("gp", &self.exact)).chain(kinds) {
            for (what, values) in ["nmse", "inside_95", "nlpd"].iter().zip(curves) {
                table = values.columns(table, &format!("{name}_{what}"));
            }
        }
        table
    }

    /// Median errors over the exact process's, by number of features.
    fn ratios(&self, kind: usize) -> Vec<f64> {
        let pairs = self.features[kind][0].median().iter().zip(self.exact[0].median());
        pairs.map(|(features, exact)| features / exact).collect()
    }

    fn claim(&self) -> Claim {
        let fewest = |kind: usize| {
            let first = self.ratios(kind).iter().position(|ratio| *ratio < 1.0 + SAME);
            first.map_or("none".to_owned(), |i| self.counts[i].to_string())
        };
        let ratios = self.ratios(0);
        let items = self.counts.iter().zip(&ratios);
        let items: Vec<String> = items.map(|(n, ratio)| format!("{ratio:.2} ({n})")).collect();
        let others: Vec<String> = (1..KINDS.len())
            .map(|kind| format!("{}: {}", KINDS[kind].label, fewest(kind)))
            .collect();
        let value = format!(
            "error of the cosines over the exact GP's {}; the fewest within 5 %: {} ({})",
            items.join(", "),
            fewest(0),
            others.join("; ")
        );
        let at = self.counts.iter().position(|count| *count == CLAIMED);
        let holds = at.is_some_and(|i| ratios[i] < 1.0 + SAME);
        let reason = "the thesis' cosines: with 100 of them within 5 % of the exact process's error, \
                      medians";
        judged(CLAIMS[0], value, holds, reason)
    }
}

#[cfg(test)]
mod tests {
    use report::Verdict;

    use super::{Curves, KINDS, Quartiles};

    #[test]
    fn a_hundred_cosines_are_judged_and_nothing_else() {
        let verdict = |at_hundred: f64, others: f64| {
            let counts = vec![50.0, 100.0, 200.0];
            let level = |value: f64| Quartiles::of(&[()], 3, |(), _| value);
            let curve = |error: f64| Quartiles::of(&[()], 3, |(), i| [3.0, error, 1.0][i]);
            let mut features = vec![[curve(others), level(0.9), level(0.0)]; KINDS.len()];
            features[0] = [curve(at_hundred), level(0.9), level(0.0)];
            Curves { counts, exact: [level(1.0), level(0.9), level(0.0)], features }.claim().verdict
        };
        assert_eq!(verdict(1.04, 2.0), Verdict::Holds);
        assert_eq!(verdict(1.06, 1.0), Verdict::DoesNotHold);
    }
}
