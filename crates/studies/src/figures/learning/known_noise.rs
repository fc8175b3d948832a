//! Figure M.5: what sparse processes take for noise, where the noise is known.

use anyhow::{Context, Result};
use gp_core::{Gp, LearnOptions, Posterior, SquaredExponential};
use gp_sparse::{Approximation, Placement, PseudoInputs, SparseGp, SparseOptions, SparseSettings};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use report::{Axis, Color, Figure, Guide, LegendPlace, Panel, Table};

use crate::figures::inputs::{Inputs, SEED};
use crate::figures::quartiles::Quartiles;
use crate::figures::sketch::Sketch;
use crate::held_out::{LEVEL_95, Score};
use fixtures::surface::{NOISE_SD, surface};

const COUNTS: [usize; 6] = [5, 10, 20, 35, 50, 80];
const QUICK_COUNTS: [usize; 3] = [5, 20, 50];
const DRAWS: (u64, u64) = (4, 2);
const ROWS: (usize, usize) = (500, 200);
const TESTED: usize = 1000;
const KINDS: [(&str, &str, Approximation, Color); 3] = [
    ("FITC (SPGP)", "fitc", Approximation::Fitc, Color::VERMILION),
    ("power EP, α = ½", "power_ep", Approximation::PowerEp { alpha: 0.5 }, Color::ORANGE),
    ("VFE", "vfe", Approximation::Vfe, Color::SKY),
];

/// What a process has learnt: standard deviation of the noise, and scores of unseen rows.
#[derive(Clone, Copy)]
struct Learnt {
    noise_sd: f64,
    score: Score,
}

/// One draw of the data.
struct Draw {
    exact: Learnt,
    /// By approximation, by number of pseudo-inputs.
    sparse: [Vec<Learnt>; 3],
}

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let quick = inputs.quick();
    let (n_draws, n_rows) = if quick { (DRAWS.1, ROWS.1) } else { (DRAWS.0, ROWS.0) };
    let counts = if quick { &QUICK_COUNTS[..] } else { &COUNTS[..] };
    let learn = |draw: u64| learn(draw, n_rows, counts).with_context(|| format!("draw {draw}"));
    let draws: Vec<Draw> = (0..n_draws).into_par_iter().map(learn).collect::<Result<_>>()?;
    let curves = Curves::of(counts, &draws);
    let [fitc, _, vfe] = &curves.sparse;
    let covered = fitc[1].median();
    let worst =
        (0..counts.len()).fold(0, |worst, i| if covered[i] < covered[worst] { i } else { worst });
    let of = |[noise, inside, _]: &[Quartiles; 3]| {
        (noise.median()[worst], 100.0 * inside.median()[worst])
    };
    let ((fitc_noise, fitc_inside), (vfe_noise, vfe_inside)) = (of(fitc), of(vfe));
    let caption = format!(
        "Learnt standard deviation of the noise, share of {TESTED} unseen rows inside the 95 % intervals \
         and their negative log density, of sparse processes learnt from {n_rows} rows of a surface like \
         the turn of a pushed slider, whose noise has a standard deviation of {NOISE_SD}; medians and \
         quartiles of {n_draws} draws. With {} pseudo-inputs FITC takes {fitc_noise:.4} for the noise and \
         covers {fitc_inside:.1} %, the least of its shares; VFE there {vfe_noise:.4} and \
         {vfe_inside:.1} %.",
        counts[worst],
    );
    let alt = "Three panels over the number of pseudo-inputs, each with a curve for FITC, power EP and \
               VFE and a level for the exact process: noise, share inside, and density.";
    Ok(Sketch::new(curves.figure(), curves.table(), &caption, alt))
}

fn learn(draw: u64, n_rows: usize, counts: &[usize]) -> Result<Draw> {
    let (x, y) = surface(n_rows, 2 * draw + SEED);
    let (x_test, y_test) = surface(TESTED, 2 * draw + SEED + 1);
    let learnt = |process: &dyn Posterior, noise_variance: f64| -> Result<Learnt> {
        let (mean, variance) = process.predict_observation(x_test.as_ref())?;
        let score = Score::of(&y_test, &mean, &variance)?;
        Ok(Learnt { noise_sd: noise_variance.sqrt(), score })
    };
    let sparse = |approximation: Approximation| {
        let learn = |&count: &usize| {
            let options = SparseOptions {
                settings: SparseSettings { approximation, ..SparseSettings::default() },
                pseudo_inputs: PseudoInputs::Learnt { count, placement: Placement::default() },
                warm_start_rows: 100,
                ..SparseOptions::default()
            };
            let kernel = SquaredExponential::unit(2)?;
            let (gp, _) = SparseGp::learn(kernel, x.as_ref(), &y, &options)
                .with_context(|| format!("{approximation:?}, {count} pseudo-inputs"))?;
            learnt(&gp, gp.noise_variance())
        };
        counts.iter().map(learn).collect::<Result<Vec<_>>>()
    };
    let options = LearnOptions { n_starts: 2, ..LearnOptions::default() };
    let exact =
        Gp::builder(SquaredExponential::unit(2)?).options(options.clone()).fit(x.as_ref(), &y)?;
    let [fitc, power_ep, vfe] = KINDS.map(|kind| kind.2);
    Ok(Draw {
        exact: learnt(&exact, exact.noise_variance())?,
        sparse: [sparse(fitc)?, sparse(power_ep)?, sparse(vfe)?],
    })
}

/// Noise, share inside 95 % and density over the number of pseudo-inputs.
struct Curves {
    counts: Vec<f64>,
    exact: [Quartiles; 3],
    sparse: [[Quartiles; 3]; 3],
}

impl Curves {
    fn of(counts: &[usize], draws: &[Draw]) -> Self {
        let n = counts.len();
        let of = |learnt: &dyn Fn(&Draw, usize) -> Learnt| {
            let values: [fn(&Learnt) -> f64; 3] = [
                |learnt| learnt.noise_sd,
                |learnt| learnt.score.coverage[LEVEL_95],
                |learnt| learnt.score.nlpd,
            ];
            values.map(|value| Quartiles::of(draws, n, |draw, i| value(&learnt(draw, i))))
        };
        Self {
            counts: counts.iter().map(|&count| count as f64).collect(),
            exact: of(&|draw, _| draw.exact),
            sparse: [0, 1, 2].map(|kind| of(&|draw, i| draw.sparse[kind][i])),
        }
    }

    fn figure(&self) -> Figure {
        let panels = [
            ("learnt noise", "standard deviation", 1.0, Some(NOISE_SD)),
            ("95 % intervals", "share of rows inside / %", 100.0, Some(95.0)),
            ("density", "negative log density / nat", 1.0, None),
        ];
        let mut figure = Figure::new(1, 3).panel_size(320.0, 300.0).one_legend();
        for (which, (title, y, factor, truth)) in panels.into_iter().enumerate() {
            let x = Axis::new("pseudo-inputs").log();
            let mut panel = Panel::new(x, y).title(title).legend(LegendPlace::Below);
            if let Some(truth) = truth {
                panel = panel.with(Guide::horizontal(truth).color(Color::INK).label("true"));
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
            for (what, values) in ["noise_sd", "inside_95", "nlpd"].iter().zip(curves) {
                table = values.columns(table, &format!("{name}_{what}"));
            }
        }
        table
    }
}

#[cfg(test)]
mod tests {
    use super::{Curves, NOISE_SD, Quartiles, learn};

    #[test]
    fn fitc_takes_less_for_noise_than_there_is_and_vfe_does_not() {
        let curves = Curves::of(&[20], &[learn(0, 400, &[20]).unwrap()]);
        let noise = |curves: &[Quartiles; 3]| curves[0].median()[0] / NOISE_SD;
        let [fitc, power_ep, vfe] = curves.sparse.each_ref().map(noise);
        assert!(fitc < 0.75 && fitc < power_ep && power_ep < vfe, "{fitc} {power_ep} {vfe}");
        assert!((vfe - 1.0).abs() < 0.2 && (noise(&curves.exact) - 1.0).abs() < 0.1, "{vfe}");
        let [fitc, _, vfe] = curves.sparse.each_ref().map(|curves| curves[1].median()[0]);
        assert!(fitc < vfe, "{fitc} {vfe}");
    }
}
