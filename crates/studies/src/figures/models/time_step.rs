//! Figure 5.3: the error against the time step, at each speed.

use anyhow::{Context, Result};
use dataset::{IngestSettings, StepLength, ingest};
use gp_core::LearnOptions;
use models::{GpPushModel, learn_options};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use report::{Axis, Claim, Color, Figure, LegendPlace, Panel, Table, Verdict};

use super::steps::Steps;
use crate::figures::claims::judged;
use crate::figures::inputs::{Inputs, SEED};
use crate::figures::quartiles::Quartiles;
use crate::figures::sketch::Sketch;
use crate::held_out::{HeldOut, Scores, shuffled};

/// What this figure settles.
pub(crate) const CLAIMS: [&str; 1] = [
    "5. At 20 mm/s the error falls up to a time step of about 0.2 s and is flat after; faster pushes \
     want shorter steps.",
];
/// In s; at each speed those of them whose way is within [`WAYS`], in m.
const TIME_STEPS: [f64; 8] = [0.01, 0.02, 0.03, 0.05, 0.1, 0.2, 0.4, 0.8];
const QUICK_TIME_STEPS: [f64; 3] = [0.05, 0.2, 0.4];
const WAYS: [f64; 2] = [0.35e-3, 17e-3];
const SPLITS: (u64, u64) = (6, 2);
const MOST_TRAINING: usize = 200;
const MOST_TESTED: usize = 600;
/// An error at most this much above the lowest, relative, is as good.
const AS_GOOD: f64 = 0.1;
/// What "flat" allows beyond.
const FLAT: f64 = 0.25;
/// What "about 0.2 s" is, in s.
const INFO: [f64; 2] = [0.1, 0.4];

/// The errors at one speed.
struct Curve {
    /// In m/s.
    speed: f64,
    time_steps: Vec<f64>,
    n_training: usize,
    /// Mean of the outputs, and of Δθ alone, which the thesis shows.
    errors: [Quartiles; 2],
}

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    inputs.recordings()?;
    let mut curves = Vec::new();
    for own in std::iter::once(inputs).chain(inputs.faster()) {
        curves.extend(curve(own)?);
    }
    if curves.is_empty() {
        return Err(inputs.lacking("at least 80 steps of one object at several time steps"));
    }
    let counts: Vec<String> = curves.iter().map(|curve| curve.n_training.to_string()).collect();
    let n_splits = n_splits(inputs);
    let caption = format!(
        "Squared error over the variance of the outputs at that time step, of Gaussian processes, on \
         steps not used for training; medians and quartiles of {n_splits} random splits, as many \
         training steps at every time step of a speed ({}). Left the mean of the three outputs, right \
         Δθ alone as in the thesis. Short steps move the object by little more than the noise of the \
         measured poses, through which splines are laid.",
        counts.join(", ")
    );
    let alt = "Two panels of errors over the time step with a curve for each speed of the pusher.";
    Ok(Sketch::new(figure(&curves), table(&curves), &caption, alt).claim(claim(&curves)))
}

fn n_splits(inputs: &Inputs) -> u64 {
    if inputs.quick() { SPLITS.1 } else { SPLITS.0 }
}

/// The curve of the pushes at one speed; none if there are too few steps.
fn curve(inputs: &Inputs) -> Result<Option<Curve>> {
    let time_steps = if inputs.quick() { &QUICK_TIME_STEPS[..] } else { &TIME_STEPS[..] };
    let mut found: Vec<(f64, Steps)> = Vec::new();
    let mut speed = None;
    // The longest first: its rows tell the speed best.
    for &time_step in time_steps.iter().rev() {
        let is_apt = |speed: f64| (WAYS[0]..=WAYS[1]).contains(&(speed * time_step));
        if speed.is_some_and(|speed| !is_apt(speed)) {
            continue;
        }
        let settings =
            IngestSettings { step: StepLength::Time(time_step), ..IngestSettings::default() };
        let (table, _) = ingest(inputs.recordings()?, &settings)?;
        let Some(steps) = Steps::among(inputs, &table)? else { continue };
        if is_apt(*speed.get_or_insert(steps.speed)) {
            found.push((time_step, steps));
        }
    }
    found.reverse();
    let (Some(speed), Some(fewest)) = (speed, found.iter().map(|(_, own)| own.steps.len()).min())
    else {
        return Ok(None);
    };
    let n_training = (fewest / 2).min(MOST_TRAINING);
    let learn = |split: u64| -> Result<Vec<Scores>> {
        let score = |(time_step, own): &(f64, Steps)| {
            score(own, n_training, split)
                .with_context(|| format!("{time_step} s at {speed:.3} m/s, split {split}"))
        };
        found.iter().map(score).collect()
    };
    let splits: Vec<Vec<Scores>> =
        (0..n_splits(inputs)).into_par_iter().map(learn).collect::<Result<_>>()?;
    let n = found.len();
    let errors = [
        Quartiles::of(&splits, n, |split, i| split[i].nmse()),
        Quartiles::of(&splits, n, |split, i| split[i].0[2].nmse),
    ];
    let time_steps = found.into_iter().map(|(time_step, _)| time_step).collect();
    Ok(Some(Curve { speed, time_steps, n_training, errors }))
}

fn score(own: &Steps, n_training: usize, split: u64) -> Result<Scores> {
    let steps = shuffled(&own.steps, SEED, split);
    let (train, test) = steps.split_at(n_training);
    // One start, from which the prior keeps the process in bounds: many models are learned.
    let options = LearnOptions { n_starts: 1, ..learn_options() };
    let (model, _) = GpPushModel::learn(train, &options)?;
    HeldOut::new(&test[..test.len().min(MOST_TESTED)]).scores(&model)
}

fn figure(curves: &[Curve]) -> Figure {
    let mut figure = Figure::new(1, 2).panel_size(420.0, 320.0).one_legend();
    for (which, title) in ["mean of the outputs", "Δθ"].iter().enumerate() {
        let y = Axis::new("normalized mean squared error").log();
        let mut panel =
            Panel::new(Axis::new("time step / s").log(), y).title(title).legend(LegendPlace::Below);
        for (k, curve) in curves.iter().enumerate() {
            let label = format!("{} mm/s", curve.speed_mm_s());
            panel = curve.errors[which].draw(panel, &curve.time_steps, Color::cycle(k), &label);
        }
        figure = figure.with(panel);
    }
    figure
}

/// A row for each speed and time step.
fn table(curves: &[Curve]) -> Table {
    let all = |value: &dyn Fn(&Curve, usize) -> f64| {
        let of = |curve: &Curve| (0..curve.time_steps.len()).map(|i| value(curve, i)).collect();
        curves.iter().flat_map::<Vec<f64>, _>(of).collect::<Vec<f64>>()
    };
    let mut table = Table::new()
        .column("speed_m_s", &all(&|curve, _| curve.speed))
        .column("time_step_s", &all(&|curve, i| curve.time_steps[i]))
        .column("training_steps", &all(&|curve, _| curve.n_training as f64));
    for (which, name) in ["nmse", "nmse_dtheta"].iter().enumerate() {
        for part in 0..3 {
            let named = |curve: &Curve| curve.errors[which].named(name)[part].0.clone();
            let values = all(&|curve, i| curve.errors[which].named(name)[part].1[i]);
            table = table.column(&named(&curves[0]), &values);
        }
    }
    table
}

impl Curve {
    /// The speed to two digits: a pusher that starts and stops is a little slower in the mean.
    fn speed_mm_s(&self) -> f64 {
        let speed = 1e3 * self.speed;
        let digit = 10f64.powf(speed.log10().floor() - 1.0);
        (speed / digit).round() * digit
    }

    /// The shortest time step with 95 % of the fall from the shortest one's error to the lowest.
    fn fallen(&self) -> f64 {
        let errors = self.errors[0].median();
        let lowest = errors.iter().copied().fold(f64::INFINITY, f64::min);
        let first = errors.iter().position(|error| error - lowest <= 0.05 * (errors[0] - lowest));
        first.map_or(f64::NAN, |i| self.time_steps[i])
    }

    /// The shortest time step whose median error is as good as the lowest.
    fn shortest(&self) -> f64 {
        let errors = self.errors[0].median();
        let lowest = errors.iter().copied().fold(f64::INFINITY, f64::min);
        let first = errors.iter().position(|error| *error <= (1.0 + AS_GOOD) * lowest);
        first.map_or(f64::NAN, |i| self.time_steps[i])
    }

    /// Whether no longer step is much worse than the best one.
    fn is_flat_after(&self) -> bool {
        let errors = self.errors[0].median();
        let lowest = errors.iter().copied().fold(f64::INFINITY, f64::min);
        let longer =
            self.time_steps.iter().zip(errors).filter(|(step, _)| **step > self.shortest());
        longer.into_iter().all(|(_, error)| *error <= (1.0 + FLAT) * lowest)
    }

    fn said(&self) -> String {
        let pairs = self.time_steps.iter().zip(self.errors[0].median());
        let errors: Vec<String> =
            pairs.map(|(step, error)| format!("{error:.4} ({step} s)")).collect();
        format!(
            "{} mm/s: {}, 95 % of the fall by {} s, within 10 % of the lowest from {} s",
            self.speed_mm_s(),
            errors.join(", "),
            self.fallen(),
            self.shortest()
        )
    }
}

fn claim(curves: &[Curve]) -> Claim {
    let value = curves.iter().map(Curve::said).collect::<Vec<_>>().join("; ");
    let [slowest, faster @ ..] = curves else {
        return judged(CLAIMS[0], value, false, "no curve");
    };
    let holds = (INFO[0]..=INFO[1]).contains(&slowest.shortest())
        && slowest.is_flat_after()
        && faster.iter().all(|curve| curve.shortest() < slowest.shortest());
    let reason = "the shortest time step within 10 % of the lowest error is from 0.1 to 0.4 s at the \
                  slowest speed, where no longer one is more than 25 % above the lowest, and shorter \
                  at every faster speed; medians";
    let judged = judged(CLAIMS[0], value, holds, reason);
    if faster.is_empty() {
        let reason = "the pushes have one speed".to_owned();
        return Claim { verdict: Verdict::NotTestable, reason, ..judged };
    }
    judged
}

#[cfg(test)]
mod tests {
    use plant::{Design, GenerateSettings, generate};
    use report::Verdict;

    use super::{Curve, Quartiles, claim, draw};
    use crate::figures::inputs::Inputs;

    fn curve(speed: f64, time_steps: &[f64], errors: &[f64]) -> Curve {
        let error = || Quartiles::of(&[()], errors.len(), |(), i| errors[i]);
        let errors = [error(), error()];
        Curve { speed, time_steps: time_steps.to_vec(), n_training: 100, errors }
    }

    #[test]
    fn the_shortest_good_step_is_what_is_judged() {
        let slow = |errors: &[f64]| curve(0.02, &[0.05, 0.1, 0.2, 0.4], errors);
        let fast = |errors: &[f64]| curve(0.1, &[0.02, 0.05, 0.1, 0.2], errors);
        let verdict = |slow: Curve, fast: Curve| claim(&[slow, fast]).verdict;
        let (falling, early) = ([0.5, 0.2, 0.1, 0.1], [0.3, 0.1, 0.1, 0.1]);
        assert_eq!(verdict(slow(&falling), fast(&early)), Verdict::Holds);
        assert_eq!(verdict(slow(&falling), fast(&[0.5, 0.4, 0.3, 0.1])), Verdict::DoesNotHold);
        assert_eq!(verdict(slow(&[0.1, 0.1, 0.1, 0.1]), fast(&early)), Verdict::DoesNotHold);
        assert_eq!(verdict(slow(&[0.5, 0.2, 0.1, 0.2]), fast(&early)), Verdict::DoesNotHold);
        assert_eq!(claim(&[slow(&falling)]).verdict, Verdict::NotTestable);
    }

    #[test]
    fn time_steps_are_chosen_by_their_way_at_each_speed() {
        let folder = tempfile::tempdir().unwrap();
        let sets = [0.02, 0.1].map(|speed| {
            let set = folder.path().join(format!("{speed}"));
            let design = Design { n_pushes: 24, speeds: vec![speed], ..Design::default() };
            generate(&GenerateSettings { design, ..GenerateSettings::default() }, &set).unwrap();
            set
        });
        let inputs = Inputs::at_speeds(&sets).unwrap();
        let slow = super::curve(&inputs).unwrap().unwrap();
        assert!(slow.time_steps.contains(&0.2) && !slow.time_steps.contains(&0.01));
        let sketch = draw(&inputs).unwrap();
        assert_ne!(sketch.claims[0].verdict, Verdict::NotTestable);
    }
}
