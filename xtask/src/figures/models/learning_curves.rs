//! Figure 5.7: error and honesty of the models against the number of training steps.

use anyhow::{Context, Result};
use gp_core::LearnOptions;
use models::{Analytical, GpPushModel, Hybrid, ModelError, StepObservation, learn_options};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use report::{Axis, Band, Claim, Color, Figure, Guide, LegendPlace, Line, Panel, Points, Table};

use super::steps::Steps;
use crate::figures::claims::judged;
use crate::figures::inputs::{Inputs, SEED};
use crate::figures::sketch::Sketch;
use crate::held_out::{HeldOut, Scores, quantile, shuffled};

/// What this figure settles.
pub(crate) const CLAIMS: [&str; 1] = [
    "9. With enough data the GP beats the analytical model; the hybrid needs fewer data and both \
     meet.",
];
const COUNTS: [usize; 7] = [10, 20, 35, 60, 100, 200, 500];
const SPLITS: (u64, u64) = (10, 4);
const MOST_STEPS: (usize, usize) = (500, 200);
const MOST_TESTED: usize = 1000;
/// What of the shares in intervals is drawn: that of 95 %.
const LEVEL: usize = 2;

/// The scores of one split, by number of training steps.
struct Curves {
    nominal: f64,
    analytical: Vec<f64>,
    gp: Vec<Scores>,
    hybrid: Vec<Scores>,
}

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let data = Steps::of(inputs)?;
    let choose = |(careful, quick)| if inputs.quick() { quick } else { careful };
    let n_splits = if inputs.quick() { SPLITS.1 } else { SPLITS.0 };
    let most = choose(MOST_STEPS).min(data.steps.len() / 2);
    let counts: Vec<usize> = COUNTS.into_iter().filter(|&count| count <= most).collect();
    let nominal = Analytical::nominal(data.friction)?;
    let splits: Vec<Curves> = (0..n_splits)
        .into_par_iter()
        .map(|split| {
            learn(&nominal, &counts, &shuffled(&data.steps, SEED, split))
                .with_context(|| format!("split {split}"))
        })
        .collect::<Result<_>>()?;
    let curves = Summary::of(&counts, &splits);
    let tested = (data.steps.len() - most).min(MOST_TESTED);
    let caption = format!(
        "Left: squared error over the variance of the outputs, on {tested} steps not used for \
         training; median and quartiles of {n_splits} random splits of steps (not of pushes, whose \
         steps resemble one another). The analytical model is fitted to the same steps; the nominal \
         one knows the pusher's friction and uniform pressure alone, and is the hybrid's base where \
         few steps do not determine more. Right: share of the same steps inside the models' 95 % \
         intervals, mean of the three outputs.",
    );
    let alt = "Two panels over the number of training steps. Left, the errors of Gaussian process, \
               hybrid, fitted and nominal analytical model. Right, the shares inside the intervals \
               of Gaussian process and hybrid, beside a line at 95 %.";
    Ok(Sketch::new(curves.figure(), curves.table(), &caption, alt).claim(curves.claim()))
}

fn learn(nominal: &Analytical, counts: &[usize], steps: &[StepObservation]) -> Result<Curves> {
    let most = counts.last().copied().unwrap_or(0);
    let (train, test) = steps.split_at(most);
    let test = HeldOut::new(&test[..test.len().min(MOST_TESTED)]);
    // Two starts instead of four, since so many models are learned.
    let options = LearnOptions { n_starts: 2, ..learn_options() };
    let mut curves = Curves {
        nominal: test.nmse(nominal)?,
        analytical: Vec::new(),
        gp: Vec::new(),
        hybrid: Vec::new(),
    };
    for &count in counts {
        let train = &train[..count];
        let base = match nominal.fit(train) {
            Ok(fit) => fit.model,
            Err(ModelError::Undetermined { .. }) => nominal.clone(),
            Err(error) => return Err(error.into()),
        };
        curves.analytical.push(test.nmse(&base)?);
        curves.gp.push(test.scores(&GpPushModel::learn(train, &options)?.0)?);
        curves.hybrid.push(test.scores(&Hybrid::learn(base, train, &options)?.0)?);
    }
    Ok(curves)
}

/// Lower quartile, median and upper quartile over the splits, by number of training steps.
struct Quartiles([Vec<f64>; 3]);

impl Quartiles {
    fn of(splits: &[Curves], n: usize, value: impl Fn(&Curves, usize) -> f64) -> Self {
        let at = |share: f64| {
            let over = |i: usize| splits.iter().map(|split| value(split, i)).collect();
            (0..n).map(|i| quantile(over(i), share)).collect()
        };
        Self([at(0.25), at(0.5), at(0.75)])
    }

    fn median(&self) -> &[f64] {
        &self.0[1]
    }
}

struct Summary {
    counts: Vec<f64>,
    nominal: Quartiles,
    analytical: Quartiles,
    gp: Quartiles,
    hybrid: Quartiles,
    gp_share: Quartiles,
    hybrid_share: Quartiles,
}

impl Summary {
    fn of(counts: &[usize], splits: &[Curves]) -> Self {
        let n = counts.len();
        let share =
            |scores: &Scores| scores.coverage.iter().map(|output| output[LEVEL]).sum::<f64>() / 3.0;
        Self {
            counts: counts.iter().map(|&count| count as f64).collect(),
            nominal: Quartiles::of(splits, n, |split, _| split.nominal),
            analytical: Quartiles::of(splits, n, |split, i| split.analytical[i]),
            gp: Quartiles::of(splits, n, |split, i| split.gp[i].nmse),
            hybrid: Quartiles::of(splits, n, |split, i| split.hybrid[i].nmse),
            gp_share: Quartiles::of(splits, n, |split, i| share(&split.gp[i])),
            hybrid_share: Quartiles::of(splits, n, |split, i| share(&split.hybrid[i])),
        }
    }

    fn figure(&self) -> Figure {
        let x = || Axis::new("training steps").log();
        let curve = |panel: Panel, quartiles: &Quartiles, color: Color, label: &str| {
            let Quartiles([low, median, high]) = quartiles;
            panel
                .with(Band::new(&self.counts, low, high).color(color))
                .with(Line::new(&self.counts, median).color(color).label(label))
                .with(Points::new(&self.counts, median).color(color).radius(3.0))
        };
        let nominal = Line::new(&self.counts, self.nominal.median());
        let errors = Panel::new(x(), Axis::new("normalized mean squared error").log())
            .title("error")
            .legend(LegendPlace::Below)
            .with(nominal.color(Color::INK).dashed().label("nominal"));
        let errors = curve(errors, &self.analytical, Color::GREEN, "analytical");
        let errors = curve(errors, &self.gp, Color::BLUE, "GP");
        let errors = curve(errors, &self.hybrid, Color::VERMILION, "hybrid");
        let shares = Panel::new(x(), "share of steps inside / %")
            .title("95 % intervals")
            .legend(LegendPlace::Below)
            .with(Guide::horizontal(95.0).color(Color::INK).dashed().label("claimed"));
        let percent = |Quartiles(shares): &Quartiles| {
            Quartiles(shares.each_ref().map(|share| share.iter().map(|s| 100.0 * s).collect()))
        };
        let shares = curve(shares, &percent(&self.gp_share), Color::BLUE, "GP");
        let shares = curve(shares, &percent(&self.hybrid_share), Color::VERMILION, "hybrid");
        Figure::new(1, 2).panel_size(420.0, 320.0).with(errors).with(shares)
    }

    fn table(&self) -> Table {
        let mut table = Table::new().column("training_steps", &self.counts);
        for (name, quartiles) in [
            ("nominal_nmse", &self.nominal),
            ("analytical_nmse", &self.analytical),
            ("gp_nmse", &self.gp),
            ("hybrid_nmse", &self.hybrid),
            ("gp_share_in_95", &self.gp_share),
            ("hybrid_share_in_95", &self.hybrid_share),
        ] {
            for (part, values) in ["lower", "median", "upper"].iter().zip(&quartiles.0) {
                table = table.column(&format!("{name}_{part}"), values);
            }
        }
        table
    }

    fn claim(&self) -> Claim {
        let last = self.counts.len() - 1;
        let (gp, hybrid) = (self.gp.median(), self.hybrid.median());
        let analytical = self.analytical.median()[last];
        let few: Vec<usize> = (0..=last).filter(|&i| self.counts[i] <= 60.0).collect();
        let ratios: Vec<String> =
            few.iter().map(|&i| format!("{:.2}", hybrid[i] / gp[i])).collect();
        let counts: Vec<String> = few.iter().map(|&i| self.counts[i].to_string()).collect();
        let value = format!(
            "with {} steps: GP {:.4}, hybrid {:.4}, analytical {analytical:.4} (nominal {:.4}); \
             hybrid over GP {} with {} steps",
            self.counts[last],
            gp[last],
            hybrid[last],
            self.nominal.median()[last],
            ratios.join(", "),
            counts.join(", ")
        );
        let meets = (hybrid[last] / gp[last] - 1.0).abs() < 0.1;
        let holds = gp[last] < analytical && few.iter().all(|&i| hybrid[i] < gp[i]) && meets;
        let reason = "medians over the splits: the GP below the fitted analytical model at the most \
                      steps, the hybrid below the GP at up to 60, and both within 10 % at the most";
        judged(CLAIMS[0], value, holds, reason)
    }
}
