//! Figure M.7: one model of several shapes, and what it knows of another.

use std::path::PathBuf;

use anyhow::{Context, Result};
use gp_core::LearnOptions;
use models::{
    Analytical, GpPushModel, PushModel, StepFeatures, StepObservation, Training, learn_options,
};
use plant::{Design, GenerateSettings, PushedObject, generate};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use report::{Axis, Color, Figure, LegendPlace, Panel, Points, Table};

use super::steps::Steps;
use crate::figures::inputs::{Inputs, SEED};
use crate::figures::sketch::Sketch;
use crate::held_out::{HeldOut, quantile, shuffled};
use fixtures::made_once::{key, made_once};
use fixtures::workspace_root;
use fixtures::{quiet_rig, rig};

/// Objects to learn from, and the last one to be asked about alone.
const OBJECTS: [&str; 4] = ["rect1", "ellip2", "tri1", "hex"];
const N_LEARNT: usize = 3;
/// Where the sets are kept, below `target/`.
const FOLDER: &str = "shapes";
const N_PUSHES: (usize, usize) = (60, 24);
const SPLITS: (u64, u64) = (5, 2);
/// Training steps of each shape; no more than half of what there are.
const MOST_TRAINING: usize = 100;
const MOST_TESTED: usize = 300;

/// A model and what it learns from.
struct Kind {
    label: &'static str,
    color: Color,
    /// None for physics alone.
    features: Option<StepFeatures>,
    /// Whether it learns from each shape by itself.
    is_alone: bool,
}

const PLAIN: StepFeatures = StepFeatures { contact: false, speed: false, normal: false };
const KINDS: [Kind; 5] = [
    Kind { label: "analytical, nominal", color: Color::INK, features: None, is_alone: false },
    Kind {
        label: "each shape by itself",
        color: Color::GREEN,
        features: Some(PLAIN),
        is_alone: true,
    },
    Kind { label: "together, (p, β)", color: Color::BLUE, features: Some(PLAIN), is_alone: false },
    Kind {
        label: "together, with the normal",
        color: Color::ORANGE,
        features: Some(StepFeatures { normal: true, ..PLAIN }),
        is_alone: false,
    },
    Kind {
        label: "together, contact and curvature",
        color: Color::VERMILION,
        features: Some(StepFeatures { contact: true, ..PLAIN }),
        is_alone: false,
    },
];

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let quick = inputs.quick();
    let n_splits = if quick { SPLITS.1 } else { SPLITS.0 };
    let open = |set: &PathBuf| Steps::of(&Inputs::open(set, quick)?);
    let data = sets(quick)?.iter().map(open).collect::<Result<Vec<_>>>()?;
    let errors: Vec<Vec<[f64; 4]>> = (0..n_splits)
        .into_par_iter()
        .map(|split| errors(&data, split).with_context(|| format!("split {split}")))
        .collect::<Result<_>>()?;
    let median = |kind: usize, object: usize| {
        quantile(errors.iter().map(|split| split[kind][object]).collect(), 0.5)
    };
    let medians: Vec<[f64; 4]> =
        (0..KINDS.len()).map(|kind| [0, 1, 2, 3].map(|object| median(kind, object))).collect();
    let mean = |kind: usize| medians[kind][..N_LEARNT].iter().sum::<f64>() / N_LEARNT as f64;
    let caption = format!(
        "Squared error over the variance of the outputs, mean of the three, on unseen steps of each object \
         (MIT names), simulated; medians of {n_splits} random splits. Gaussian processes learn from {} \
         steps of each of the first three objects, together or each by itself; of the hexagon none has \
         seen a push. Mean over the three: (p, β) {:.3}, with the contact normal in the body's frame \
         {:.3}, with the contact as its lever and depth about the centroid and the outline's curvature \
         {:.3}, each by itself {:.3}. Of the models that learn, only that of contact and curvature can be \
         asked about the hexagon: {:.3}, where the analytical model with its nominal friction has {:.3}.",
        n_training(&data),
        mean(2),
        mean(3),
        mean(4),
        mean(1),
        medians[4][N_LEARNT],
        medians[0][N_LEARNT],
    );
    let alt = "A panel with four objects side by side and a point for the error of each model.";
    Ok(Sketch::new(figure(&medians), table(&medians), &caption, alt))
}

/// The recording sets of the objects, simulated once; few pushes for a first look are quiet, as the fixtures are.
fn sets(quick: bool) -> Result<Vec<PathBuf>> {
    let n_pushes = if quick { N_PUSHES.1 } else { N_PUSHES.0 };
    let settings = OBJECTS.map(|name| GenerateSettings {
        name: format!("{name}, simulated"),
        object: PushedObject::Mit { name: name.to_owned() },
        design: Design { n_pushes, ..Design::default() },
        ..if quick { quiet_rig() } else { rig() }
    });
    let folder = workspace_root().join("target").join(format!("{FOLDER}-{n_pushes}"));
    made_once(&folder, &key(&settings)?, |own| {
        for (settings, name) in settings.iter().zip(OBJECTS) {
            generate(settings, &own.join(name))?;
        }
        Ok(())
    })?;
    Ok(OBJECTS.iter().map(|name| folder.join(name)).collect())
}

fn n_training(data: &[Steps]) -> usize {
    let fewest = data.iter().map(|own| own.steps.len()).min().unwrap_or(0);
    (fewest / 2).min(MOST_TRAINING)
}

/// Errors by kind and object; NaN where a model has not learnt of an outline.
fn errors(data: &[Steps], split: u64) -> Result<Vec<[f64; 4]>> {
    let n = n_training(data);
    let steps: Vec<_> = data.iter().map(|own| shuffled(&own.steps, SEED, split)).collect();
    let test = steps.iter().map(|own| HeldOut::new(&own[n..own.len().min(n + MOST_TESTED)]));
    let test: Vec<HeldOut> = test.collect();
    let train: Vec<&[StepObservation]> = steps[..N_LEARNT].iter().map(|own| &own[..n]).collect();
    let nominal = Analytical::nominal(data[0].friction)?;
    let mut found = Vec::new();
    for kind in &KINDS {
        let mut errors = [f64::NAN; 4];
        match kind.features {
            None => score(&nominal, &test, &mut errors)?,
            Some(features) if kind.is_alone => {
                for (k, own) in train.iter().enumerate() {
                    errors[k] = test[k].nmse(&learn(own, features)?)?;
                }
            }
            Some(features) => {
                let model = learn(&train.concat(), features)?;
                let n_known = if features.contact { OBJECTS.len() } else { N_LEARNT };
                score(&model, &test[..n_known], &mut errors)?;
            }
        }
        found.push(errors);
    }
    Ok(found)
}

fn score(model: &dyn PushModel, test: &[HeldOut], errors: &mut [f64; 4]) -> Result<()> {
    for (error, test) in errors.iter_mut().zip(test) {
        *error = test.nmse(model)?;
    }
    Ok(())
}

fn learn(steps: &[StepObservation], features: StepFeatures) -> Result<GpPushModel> {
    let options = LearnOptions { n_starts: 2, ..learn_options() };
    Ok(GpPushModel::train(steps, &Training { features, ..options.into() })?.0)
}

fn figure(medians: &[[f64; 4]]) -> Figure {
    let places = [0.0, 1.0, 2.0, 3.0];
    let names: Vec<(f64, String)> = places
        .iter()
        .zip(OBJECTS)
        .map(|(at, name)| {
            let is_learnt = (*at as usize) < N_LEARNT;
            (*at, if is_learnt { name.to_owned() } else { format!("{name} (not learnt)") })
        })
        .collect();
    let x = Axis::new("object").range(-0.5, 3.5).names(&names);
    let mut panel =
        Panel::new(x, Axis::new("normalized mean squared error").log()).legend(LegendPlace::Below);
    for (k, (kind, errors)) in KINDS.iter().zip(medians).enumerate() {
        let known = places.iter().zip(errors).filter(|(_, error)| error.is_finite());
        // Side by side, so that equal errors stay apart.
        let points: Vec<[f64; 2]> =
            known.map(|(at, error)| [at + 0.12 * (k as f64 - 2.0), *error]).collect();
        panel = panel.with(Points::at(&points).color(kind.color).radius(4.5).label(kind.label));
    }
    Figure::single(panel)
}

/// A row for each model and object that it can be asked about.
fn table(medians: &[[f64; 4]]) -> Table {
    let (mut models, mut objects, mut values) = (Vec::new(), Vec::new(), Vec::new());
    for (kind, errors) in KINDS.iter().zip(medians) {
        for (object, error) in OBJECTS.iter().zip(errors).filter(|(_, error)| error.is_finite()) {
            models.push(kind.label);
            objects.push(*object);
            values.push(*error);
        }
    }
    Table::new().names("model", &models).names("object", &objects).column("nmse_median", &values)
}

#[cfg(test)]
mod tests {
    use super::{Inputs, Steps, errors, sets};

    #[test]
    fn what_shapes_have_in_common_predicts_better_and_even_a_shape_that_was_not_learnt() {
        let data: Vec<Steps> = sets(true)
            .unwrap()
            .iter()
            .map(|set| Steps::of(&Inputs::open(set, true).unwrap()).unwrap())
            .collect();
        let [_, _, plain, normal, contact] = &errors(&data, 0).unwrap()[..] else { panic!() };
        for (k, contact) in contact[..3].iter().enumerate() {
            assert!(*contact < plain[k] && *contact < 1.2 * normal[k], "{k}: {contact} {plain:?}");
        }
        assert!(plain[3].is_nan() && contact[3] < 0.2, "{contact:?}");
    }
}
