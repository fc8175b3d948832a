//! Figure 6.5: where one Gaussian does not do, and a mixture.

use anyhow::{Context, Result, ensure};
use models::{
    GpPushModel, Noise, ProcessKind, PushModel, Slip, SlipMixture, SlipPrediction, StepInput,
    StepObservation, Training, learn_options,
};
use report::{Axis, Color, Figure, LegendPlace, Line, Panel, Points};
use serde_json::json;

use crate::figures::inputs::{Inputs, SEED};
use crate::figures::models::steps::Steps;
use crate::figures::sketch::Sketch;
use crate::held_out::shuffled;

/// Steps that begin this near to a vertex, as a share of the edge.
const NEAR: f64 = 0.15;
const MOST_LEARNT: usize = 600;
const FEWEST_TESTED: usize = 15;
const LEVELS: [f64; 3] = [0.5, 0.9, 0.95];
const MODES: [(Slip, &str, Color); 3] = [
    (Slip::Stick, "sticks", Color::INK),
    (Slip::Left, "slips to smaller p", Color::ORANGE),
    (Slip::Right, "slips to larger p", Color::BLUE),
];

/// A model's scores on some steps.
struct Score {
    name: &'static str,
    nlpd: [f64; 2],
    coverage: [[f64; 3]; 2],
}

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let all = shuffled(&Steps::of(inputs)?.steps, SEED, 0);
    let (train, test) = all.split_at((2 * all.len() / 3).min(MOST_LEARNT));
    let near: Vec<_> = test.iter().filter(|step| is_near(&step.input)).cloned().collect();
    ensure!(!train.is_empty(), "there are steps to learn from");
    if near.len() < FEWEST_TESTED {
        return Err(inputs.lacking("15 held-out steps near a vertex"));
    }
    let mut options = learn_options();
    options.n_starts = 1;
    let gp = Training { process: ProcessKind::Gp, ..options.into() };
    let plain = GpPushModel::train(train, &gp)?.0;
    let noisy = Training { process: ProcessKind::Vhgp, ..gp.clone() };
    let noisy = GpPushModel::train(&train[..train.len().min(200)], &noisy)?.0;
    let mixture = SlipMixture::train(train, &gp)?;
    let parts = [&near[..], test];
    let of_one = |model: &GpPushModel, steps: &[StepObservation]| {
        let said = model.predict(&inputs_of(steps), Noise::Included)?;
        Ok::<_, anyhow::Error>(said.into_iter().map(SlipPrediction::from).collect::<Vec<_>>())
    };
    let of_mixture = |steps: &[StepObservation]| {
        Ok::<_, anyhow::Error>(mixture.ways(&inputs_of(steps), Noise::Included)?)
    };
    let scores = [
        Score::of("gp", parts, |steps| of_one(&plain, steps))?,
        Score::of("vhgp", parts, |steps| of_one(&noisy, steps))?,
        Score::of("mixture", parts, of_mixture)?,
    ];
    let middle = &near[least_certain(&near, &mixture)?];
    let figure = Figure::new(1, 2)
        .panel_size(420.0, 340.0)
        .with(slips(&all))
        .with(densities(middle, &plain, &mixture)?);
    let told: Vec<String> = scores.iter().map(Score::in_words).collect();
    let caption = format!(
        "Left: which way the contact goes along the outline in a step, over place and angle; where \
         colors meet or mix, like steps go different ways, and one Gaussian has to cover both. Right: \
         what a Gaussian process and a mixture over these ways, with learnt probabilities, say of Δy of \
         the step near a vertex whose way is least certain; the line is what happened. On {} held-out \
         steps near a vertex (p below {NEAR} or above {:.2}), and on all {}: {}.",
        near.len(),
        1.0 - NEAR,
        test.len(),
        told.join("; ")
    );
    let alt = "Points colored by the way that the contact slips, and two densities.";
    let numbers: Vec<_> = scores
        .iter()
        .map(|score| {
            json!({
                "model": score.name,
                "nlpd_near_vertex": score.nlpd[0],
                "nlpd_all": score.nlpd[1],
                "levels": LEVELS,
                "coverage_near_vertex": score.coverage[0],
                "coverage_all": score.coverage[1],
            })
        })
        .collect();
    Ok(Sketch::new(figure, serde_json::Value::Array(numbers), &caption, alt))
}

fn is_near(input: &StepInput) -> bool {
    input.p() < NEAR || input.p() > 1.0 - NEAR
}

fn inputs_of(steps: &[StepObservation]) -> Vec<StepInput> {
    steps.iter().map(|step| step.input.clone()).collect()
}

impl Score {
    /// On steps near a vertex, and on all.
    fn of(
        name: &'static str,
        parts: [&[StepObservation]; 2],
        predict: impl Fn(&[StepObservation]) -> Result<Vec<SlipPrediction>>,
    ) -> Result<Self> {
        let (mut nlpd, mut coverage) = ([0.0; 2], [[0.0; 3]; 2]);
        for (part, steps) in parts.into_iter().enumerate() {
            let said = predict(steps)?;
            let n = steps.len() as f64;
            for (said, step) in said.iter().zip(steps) {
                nlpd[part] -= said.log_density(&step.outputs) / n;
                for output in 0..3 {
                    let below = said.probability_below(output, step.outputs[output]);
                    for (share, level) in coverage[part].iter_mut().zip(LEVELS) {
                        *share += f64::from((2.0 * below - 1.0).abs() <= level) / (3.0 * n);
                    }
                }
            }
        }
        Ok(Self { name, nlpd, coverage })
    }

    fn in_words(&self) -> String {
        let percent =
            |shares: [f64; 3]| shares.map(|share| format!("{:.0}", 100.0 * share)).join(", ");
        format!(
            "{} NLPD {:.2} and {:.2}, within 50, 90 and 95 % intervals {} and {} %",
            self.name,
            self.nlpd[0],
            self.nlpd[1],
            percent(self.coverage[0]),
            percent(self.coverage[1])
        )
    }
}

fn slips(steps: &[StepObservation]) -> Panel {
    let panel = Panel::new(Axis::new("p"), Axis::new("β / °"))
        .title("what the contact does")
        .legend(LegendPlace::Below);
    MODES.iter().fold(panel, |panel, (way, label, color)| {
        let own: Vec<[f64; 2]> = steps
            .iter()
            .filter(|step| Slip::of(step) == *way)
            .map(|step| [step.input.p(), step.input.beta().to_degrees()])
            .collect();
        if own.is_empty() {
            return panel;
        }
        panel.with(Points::at(&own).color(*color).radius(1.8).label(label))
    })
}

/// The step whose way is least certain by the mixture.
fn least_certain(near: &[StepObservation], mixture: &SlipMixture) -> Result<usize> {
    let said = mixture.ways(&inputs_of(near), Noise::Included)?;
    let surest =
        |said: &SlipPrediction| said.modes.iter().map(|(_, share, _)| *share).fold(0.0, f64::max);
    let order = (0..near.len()).min_by(|a, b| surest(&said[*a]).total_cmp(&surest(&said[*b])));
    order.context("there are steps near a vertex")
}

fn densities(step: &StepObservation, plain: &GpPushModel, mixture: &SlipMixture) -> Result<Panel> {
    const N: usize = 201;
    let input = std::slice::from_ref(&step.input);
    let one = SlipPrediction::from(plain.predict(input, Noise::Included)?[0]);
    let many = mixture.ways(input, Noise::Included)?.remove(0);
    let [wide, other] = [one.moments(), many.moments()];
    let sd = wide.covariance[(1, 1)].sqrt().max(other.covariance[(1, 1)].sqrt());
    let (low, high) =
        (wide.mean.y.min(other.mean.y) - 4.0 * sd, wide.mean.y.max(other.mean.y) + 4.0 * sd);
    let edge = |k: usize| low + (high - low) * k as f64 / N as f64;
    let x: Vec<f64> = (0..N).map(|k| 1e3 * 0.5 * (edge(k) + edge(k + 1))).collect();
    let density = |said: &SlipPrediction| -> Vec<f64> {
        let mass = |k| said.probability_below(1, edge(k + 1)) - said.probability_below(1, edge(k));
        (0..N).map(|k| 1e-3 * mass(k) / (edge(k + 1) - edge(k))).collect()
    };
    let title = format!("p = {:.2}, β = {:.0}°", step.input.p(), step.input.beta().to_degrees());
    Ok(Panel::new(Axis::new("Δy / mm"), Axis::new("density in 1/mm"))
        .title(&title)
        .legend(LegendPlace::Below)
        .with(Line::new(&x, &density(&one)).color(Color::BLUE).label("Gaussian process"))
        .with(Line::new(&x, &density(&many)).color(Color::VERMILION).label("mixture"))
        .with(report::Guide::vertical(1e3 * step.outputs.y)))
}
