//! `cargo xtask samples`: sets of another simulator, before and after the right effect is added.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use dataset::{RecordingSet, ingest};
use diagnosis::{
    DiagnosisError, Fit, FitSettings, NoiseModel, Observations, ParameterFit, Predictions,
    RepeatTolerance, change, fit_with_noise, noise_floor, steady_ingest,
};
use models::{Analytical, Description, PushModel};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;

use fixtures::workspace_root;

/// Seed of the halves.
const SEED: u64 = 7;
/// What every set needs beside the thesis' ellipsoid: they were made on a patch.
const SHAPE: &str = "limit-surface-shape";
/// What the sets hide, by the scenario that their answer names, in the catalogue's words.
const SCENARIOS: [(&str, &[&str]); 5] = [
    ("none", &[]),
    ("anisotropy", &["table-anisotropy"]),
    ("pressure-offset", &["friction-center-offset"]),
    ("inertia", &["inertia"]),
    ("mup+tilt", &["pusher-friction", "table-tilt"]),
];
/// Numbers in the table: name, as people write it with its unit, and that unit in SI.
const NUMBERS: [(&str, &str, f64); 5] = [
    ("dx", "Δx / mm", 1e-3),
    ("dy", "Δy / mm", 1e-3),
    ("dtheta", "Δθ / °", std::f64::consts::PI / 180.0),
    ("force_normal", "normal force / N", 1.0),
    ("force_tangential", "tangential force / N", 1.0),
];

/// Compare sets that hide a known effect with the thesis' model and with the effect added, in docs/.
#[derive(clap::Args)]
pub struct Args {
    /// Folder with the sets and their answers
    #[arg(long, value_name = "DIR")]
    data: PathBuf,
    /// The page to write
    #[arg(short, long, value_name = "FILE", default_value = "docs/samples.md", alias = "out")]
    output: PathBuf,
}

/// The part of an answer that is read.
#[derive(Deserialize)]
struct Answer {
    scenario: String,
}

/// One set.
struct Sample {
    name: String,
    hidden: &'static [&'static str],
    /// Pushes fitted to, and others.
    n_pushes: [usize; 2],
    errors: Vec<Errors>,
    /// Of the last model.
    parameters: Vec<(&'static str, ParameterFit)>,
}

/// Errors in one number on the held-out pushes, in SI units.
struct Errors {
    /// With the thesis' model, with the hidden effects, and with the shape as well; none without a
    /// fit.
    models: [Option<f64>; 3],
    floor: Option<f64>,
}

/// Fits on half of the pushes of each set, and writes the errors on the other half. A set that hides what
/// no list here has is left out, and named.
///
/// # Errors
/// A set or answer that cannot be read; a fit that fails, with the set's name.
pub fn run(args: &Args) -> Result<()> {
    let mut samples = Vec::new();
    for path in answers(&args.data)? {
        match sample(&path).with_context(|| format!("{}", path.display()))? {
            Ok(one) => samples.push(one),
            Err(scenario) => println!("left out: {}: hides {scenario}", path.display()),
        }
    }
    ensure!(!samples.is_empty(), "no set to compare in {}", args.data.display());
    let out = workspace_root().join(&args.output);
    output::write(&out, page(&samples))?;
    println!("written: {}", out.display());
    Ok(())
}

fn answers(dir: &Path) -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(dir).with_context(|| format!("cannot read {}", dir.display()))?;
    let mut found: Vec<_> = entries.map(|entry| Ok(entry?.path())).collect::<Result<_>>()?;
    found.retain(|path| path.to_string_lossy().ends_with(".answer.json"));
    found.sort();
    Ok(found)
}

/// The set of an answer, or the scenario that is not one of [`SCENARIOS`].
fn sample(answer: &Path) -> Result<Result<Sample, String>> {
    let Answer { scenario } = serde_json::from_str(&fs::read_to_string(answer)?)?;
    let known = SCENARIOS.iter().find(|(name, _)| *name == scenario);
    let Some(&(_, hidden)) = known else { return Ok(Err(scenario)) };
    let set = RecordingSet::open(&answer.with_extension("").with_extension(""))?;
    let all = Observations::steady(&ingest(&set, &steady_ingest())?.0, set.manifest())?;
    let [fitted, others] = halves(&all)?;
    let base = Analytical::nominal(set.manifest().pusher.friction)?.describe()?;
    let noise = NoiseModel::learn(&base, &[], &fitted)?;
    let settings = FitSettings::default();
    let fit = |free: &[&str]| fit_with_noise(&fitted, &base, free, &noise, &settings);
    let with_hidden = if hidden.is_empty() { None } else { settled(fit(hidden))? };
    let with_shape = settled(fit(&[hidden, &[SHAPE]].concat()))?;
    let effects = with_shape.iter().flat_map(|fit| &fit.effects);
    let parameters = effects.flat_map(|effect| {
        effect.parameters.iter().map(|parameter| (effect.id, parameter.clone()))
    });
    let fitted_models = [&with_hidden, &with_shape].map(|fit| fit.as_ref().map(|f| &f.description));
    let models = [Some(&base), fitted_models[0], fitted_models[1]];
    Ok(Ok(Sample {
        name: set.dir().file_name().unwrap_or_default().to_string_lossy().into_owned(),
        hidden,
        n_pushes: [fitted.pushes().len(), others.pushes().len()],
        errors: errors(&all, &others, models)?,
        parameters: parameters.collect(),
    }))
}

/// A fit; none if it did not converge, which the page tells.
fn settled(fit: Result<Fit, DiagnosisError>) -> Result<Option<Fit>> {
    match fit {
        Ok(fit) => Ok(Some(fit)),
        Err(DiagnosisError::NotConverged { .. }) => Ok(None),
        Err(error) => Err(error.into()),
    }
}

/// The errors of models, the thesis' first, on some pushes, beside the floor of all.
fn errors(
    all: &Observations,
    on: &Observations,
    models: [Option<&Description>; 3],
) -> Result<Vec<Errors>> {
    let predict = |model, on| Predictions::of(model, &[], on);
    let thesis = models[0].context("the thesis' model comes first")?;
    let floor = noise_floor(all, &predict(thesis, all)?, &RepeatTolerance::default())?;
    let before = predict(thesis, on)?;
    let changes = models
        .iter()
        .map(|model| model.map(|model| Ok(change(on, &before, &predict(model, on)?, &floor)?)))
        .map(Option::transpose)
        .collect::<Result<Vec<_>>>()?;
    let of = |name: &str| {
        let after = |model: usize| {
            let found = changes[model].iter().flatten().find(|change| change.name == name);
            found.map(|change| change.after)
        };
        let number = effects::Channels::NAMES.iter().position(|other| *other == name);
        let floor = number.and_then(|number| floor.numbers[number].as_ref());
        Errors { models: [0, 1, 2].map(after), floor: floor.map(|floor| floor.rms) }
    };
    Ok(NUMBERS.iter().map(|(name, ..)| of(name)).collect())
}

/// Two random halves of the pushes.
fn halves(all: &Observations) -> Result<[Observations; 2]> {
    let mut names: Vec<String> = all.pushes().iter().map(ToString::to_string).collect();
    names.shuffle(&mut ChaCha8Rng::seed_from_u64(SEED));
    let (first, second) = names.split_at(names.len() / 2);
    Ok([all.part(first)?, all.part(second)?])
}

const INTRODUCTION: &str = "\
# Sets of another simulator

Recording sets that were made by another simulator, which shares no code with this project, with
answers that tell what they hide; they are no part of this project. Every set is split into random
halves: parameters are fitted on one, errors are those on the other. Made by one command:

```sh
cargo xtask samples --data samples
```

Root mean square errors of a step of 5 mm, predicted from its measured start: with the thesis' model
(an ellipsoid, nominal values), with the hidden effect added and fitted, and with
`limit-surface-shape` as well, since these objects stand on a patch of pads, whose limit surface is no
ellipsoid; beside the noise floor, which is how far repeats of a push differ. `no fit`: the fit did not
converge.
";

fn page(samples: &[Sample]) -> String {
    let rows: String = samples.iter().flat_map(Sample::rows).collect();
    let values: String = samples.iter().flat_map(Sample::values).collect();
    let sizes = samples.iter().map(|sample| {
        let [fitted, others] = sample.n_pushes;
        format!("{} {fitted} and {others}", sample.name)
    });
    let sizes = sizes.collect::<Vec<_>>().join(", ");
    format!(
        "{INTRODUCTION}
| set | hides | number | thesis' model | with it | and the shape | floor |
|---|---|---|---|---|---|---|
{rows}
What was fitted, with the shape, on the first half (pushes of both halves: {sizes}):

| set | effect | parameter | value ± standard error |
|---|---|---|---|
{values}"
    )
}

impl Sample {
    fn rows(&self) -> Vec<String> {
        let hidden = if self.hidden.is_empty() { "nothing".into() } else { self.hidden.join(", ") };
        let row = |(k, (errors, (_, title, unit))): (usize, (&Errors, &(&str, &str, f64)))| {
            let text = |error: Option<f64>, without: &str| {
                error.map_or(without.to_owned(), |error| format!("{:.3}", error / unit))
            };
            let [before, with, shape] = errors.models;
            let (before, shape) = (text(before, "–"), text(shape, "no fit"));
            let with = text(with, if self.hidden.is_empty() { "–" } else { "no fit" });
            let floor = text(errors.floor, "–");
            let (set, hidden) =
                if k == 0 { (self.name.as_str(), hidden.as_str()) } else { ("", "") };
            format!("| {set} | {hidden} | {title} | {before} | {with} | {shape} | {floor} |\n")
        };
        self.errors.iter().zip(&NUMBERS).enumerate().map(row).collect()
    }

    fn values(&self) -> Vec<String> {
        let value = |(effect, fit): &(&str, ParameterFit)| {
            let ParameterFit { name, unit, value, se, .. } = fit;
            let unit = if *unit == "1" { String::new() } else { format!(" {unit}") };
            let value = format!("{value:.4}").replace('-', "−");
            format!("| {} | {effect} | {name} | {value} ± {se:.4}{unit} |\n", self.name)
        };
        self.parameters.iter().map(value).collect()
    }
}
