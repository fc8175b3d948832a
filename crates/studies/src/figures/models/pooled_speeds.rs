//! Figure 5.6: what faster pushes do to the error, pooled with slower ones and by themselves.

use anyhow::Result;
use gp_core::LearnOptions;
use models::{Analytical, GpPushModel, Hybrid, StepObservation, learn_options};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use report::{Axis, Claim, Color, Figure, LegendPlace, Panel, Table};

use super::steps::Steps;
use crate::figures::claims::judged;
use crate::figures::inputs::{Inputs, SEED, STEP_WAY};
use crate::figures::quartiles::Quartiles;
use crate::figures::sketch::Sketch;
use crate::held_out::{HeldOut, shuffled};

/// What this figure settles.
pub(crate) const CLAIMS: [&str; 2] = [
    "8. Pooling speeds helps or is neutral up to 100 mm/s and hurts with 200 and 400.",
    "17. The hybrid gets worse than the GP at 200 and 400 mm/s.",
];
const N_SPLITS: u64 = 6;
/// Training steps that each speed adds to the pool, and those of one speed by itself.
const PER_SPEED: usize = 100;
const ALONE: usize = 200;
const MOST_TESTED: usize = 500;
/// Larger changes of the error, relative, are not neutral.
const NEUTRAL: f64 = 0.05;
/// Up to this speed, in m/s, the thesis calls pushes quasi-static.
const QUASI_STATIC: f64 = 0.11;
const NAMES: [(&str, Color); 4] = [
    ("nominal", Color::INK),
    ("analytical", Color::GREEN),
    ("GP", Color::BLUE),
    ("hybrid", Color::VERMILION),
];

/// Errors of one split, by speed: of the pool up to it, and of the models of [`NAMES`] by itself.
struct Split {
    pooled: Vec<f64>,
    alone: Vec<[f64; 4]>,
}

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let faster = inputs.faster();
    if faster.is_empty() {
        return Err(inputs.lacking("the same pushes at several speeds"));
    }
    let all = std::iter::once(inputs).chain(faster);
    let data = all.map(Steps::of).collect::<Result<Vec<_>>>()?;
    let speeds: Vec<f64> = data.iter().map(|data| data.speed).collect();
    let splits: Vec<Split> =
        (0..N_SPLITS).into_par_iter().map(|split| learn(&data, split)).collect::<Result<_>>()?;
    let n = speeds.len();
    let pooled = Quartiles::of(&splits, n, |split, i| split.pooled[i]);
    let alone = [0, 1, 2, 3].map(|k| Quartiles::of(&splits, n, |split, i| split.alone[i][k]));
    let caption = format!(
        "Steps of {:.0} mm at every speed. Left: error at the slowest speed of a GP that learns from \
         {PER_SPEED} steps of each speed up to the one named. Right: each speed by itself, \
         {ALONE} training steps; where an output is all but noise, the error nears 1. Medians and \
         quartiles of {N_SPLITS} random splits, on steps not used for training.",
        1e3 * STEP_WAY
    );
    let alt = "Two panels over the speed: the error with pooled speeds, and the errors of four \
               models with each speed alone.";
    let mut table = pooled.columns(Table::new().column("speed_m_s", &speeds), "pooled_nmse");
    for ((name, _), quartiles) in NAMES.iter().zip(&alone) {
        table = quartiles.columns(table, &format!("{name}_nmse"));
    }
    let sketch = Sketch::new(figure(&speeds, &pooled, &alone), table, &caption, alt);
    let medians = alone.each_ref().map(|quartiles| quartiles.median());
    Ok(sketch.claim(pooling(&speeds, pooled.median())).claim(by_speed(&speeds, medians)))
}

fn learn(data: &[Steps], split: u64) -> Result<Split> {
    // Two starts instead of four, since so many models are learned.
    let options = LearnOptions { n_starts: 2, ..learn_options() };
    let gp =
        |steps: &[StepObservation]| Ok::<_, anyhow::Error>(GpPushModel::learn(steps, &options)?.0);
    let (mut pool, mut tested_slowly) = (Vec::new(), None);
    let mut result = Split { pooled: Vec::new(), alone: Vec::new() };
    for own in data {
        let steps = shuffled(&own.steps, SEED, split);
        let (train, test) = steps.split_at(ALONE.min(steps.len() / 2));
        let test = HeldOut::new(&test[..test.len().min(MOST_TESTED)]);
        let nominal = Analytical::nominal(own.friction)?;
        let fitted = nominal.fit(train)?.model;
        result.alone.push([
            test.nmse(&nominal)?,
            test.nmse(&fitted)?,
            test.nmse(&gp(train)?)?,
            test.nmse(&Hybrid::learn(fitted, train, &options)?.0)?,
        ]);
        pool.extend_from_slice(&train[..train.len().min(PER_SPEED)]);
        result.pooled.push(tested_slowly.get_or_insert(test).nmse(&gp(&pool)?)?);
    }
    Ok(result)
}

fn figure(speeds: &[f64], pooled: &Quartiles, alone: &[Quartiles; 4]) -> Figure {
    let speeds: Vec<f64> = speeds.iter().map(|speed| 1e3 * speed).collect();
    let panel = |x: &str, title: &str| {
        let y = Axis::new("normalized mean squared error").log();
        Panel::new(Axis::new(x).log(), y).title(title).legend(LegendPlace::Below)
    };
    let together = panel("fastest speed in the pool / (mm/s)", "speeds pooled");
    let together = pooled.draw(together, &speeds, Color::BLUE, "GP, at the slowest speed");
    let apart = panel("speed / (mm/s)", "each speed by itself");
    let apart = NAMES
        .iter()
        .zip(alone)
        .fold(apart, |panel, ((name, color), values)| values.draw(panel, &speeds, *color, name));
    Figure::new(1, 2).panel_size(420.0, 320.0).with(together).with(apart)
}

fn pooling(speeds: &[f64], pooled: &[f64]) -> Claim {
    let slow = speeds.iter().filter(|speed| **speed < QUASI_STATIC).count();
    let is_neutral = |i: usize| pooled[i] < (1.0 + NEUTRAL) * pooled[0];
    let hurts = |i: usize| pooled[i] > (1.0 + NEUTRAL) * pooled[slow.max(1) - 1];
    let holds = (0..slow).all(is_neutral) && (slow..speeds.len()).all(hurts);
    let value = format!("error at the slowest speed: {}", list(speeds, pooled));
    let reason = "up to 100 mm/s within 5 % of the slowest speed's alone or below it, above more \
                  than 5 % over that of the pool up to 100 mm/s; medians";
    judged(CLAIMS[0], value, holds, reason)
}

fn by_speed(speeds: &[f64], [_, analytical, gp, hybrid]: [&[f64]; 4]) -> Claim {
    let fast = (0..speeds.len()).filter(|&i| speeds[i] > QUASI_STATIC);
    let holds = fast.clone().count() > 0 && fast.clone().all(|i| hybrid[i] > gp[i]);
    let ratios: Vec<f64> = hybrid.iter().zip(gp).map(|(hybrid, gp)| hybrid / gp).collect();
    let value = format!(
        "hybrid over GP {}; fitted analytical model {}",
        list(speeds, &ratios),
        list(speeds, analytical)
    );
    let reason = "the hybrid's error above the GP's at every speed above 100 mm/s, 200 training \
                  steps of that speed; medians";
    judged(CLAIMS[1], value, holds, reason)
}

fn list(speeds: &[f64], values: &[f64]) -> String {
    let items = speeds.iter().zip(values);
    let items = items.map(|(speed, value)| format!("{value:.4} ({:.0} mm/s)", 1e3 * speed));
    items.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use plant::{Design, GenerateSettings, generate};
    use report::Verdict;

    use super::{CLAIMS, by_speed, draw, pooling};
    use crate::figures::inputs::Inputs;

    const SPEEDS: [f64; 5] = [0.02, 0.05, 0.1, 0.2, 0.4];

    #[test]
    fn sets_at_two_speeds_settle_both_claims_and_one_set_none() {
        let folder = tempfile::tempdir().unwrap();
        let sets = [0.02, 0.3].map(|speed| {
            let set = folder.path().join(format!("{speed}"));
            let design = Design { n_pushes: 16, speeds: vec![speed], ..Design::default() };
            generate(&GenerateSettings { design, ..GenerateSettings::default() }, &set).unwrap();
            set
        });
        let claims = draw(&Inputs::at_speeds(&sets).unwrap()).unwrap().claims;
        assert_eq!(claims.iter().map(|claim| claim.claim.as_str()).collect::<Vec<_>>(), CLAIMS);
        assert!(claims.iter().all(|claim| claim.verdict != Verdict::NotTestable));
        let error = draw(&Inputs::at_speeds(&sets[..1]).unwrap()).err().unwrap();
        assert!(error.to_string().contains("several speeds"), "{error}");
    }

    #[test]
    fn pooling_is_judged_on_both_sides_of_the_quasi_static_speeds() {
        let verdict = |errors: [f64; 5]| pooling(&SPEEDS, &errors).verdict;
        assert_eq!(verdict([1.0, 0.9, 0.8, 1.2, 2.0]), Verdict::Holds);
        assert_eq!(verdict([1.0, 0.9, 1.2, 1.4, 2.0]), Verdict::DoesNotHold);
        assert_eq!(verdict([1.0, 0.9, 0.8, 0.7, 2.0]), Verdict::DoesNotHold);
    }

    #[test]
    fn the_hybrid_is_judged_at_the_fast_speeds_alone() {
        let verdict = |hybrid: [f64; 5]| {
            let other = [1.0; 5];
            by_speed(&SPEEDS, [&other, &other, &other, &hybrid]).verdict
        };
        assert_eq!(verdict([0.5, 0.5, 0.5, 1.1, 1.2]), Verdict::Holds);
        assert_eq!(verdict([2.0, 2.0, 2.0, 0.9, 1.2]), Verdict::DoesNotHold);
    }
}
