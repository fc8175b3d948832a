//! Every kind of model, trained on the same steps.

use anyhow::Result;
use dataset::SupportSpec;
use models::{
    Analytical, Base, Description, GpPushModel, Hybrid, ModelEffect, Noise, ProcessKind, PushModel,
    StepCorrelation, StepObservation, Training, learn_options,
};
use nalgebra::Matrix3;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use report::Color;

use super::pushes::{Turn, steps_of};
use crate::figures::seed::SEED;

/// A model that is rolled out.
pub(crate) struct Trained {
    pub(crate) name: &'static str,
    pub(crate) color: Color,
    pub(crate) model: Box<dyn PushModel>,
}

/// What there is to train: its name, its color, and the most steps that it learns from.
#[derive(Clone, Copy)]
struct Kind {
    name: &'static str,
    color: Color,
    most: usize,
    train: Train,
}

/// Trains a model on steps.
type Train = fn(&Setting, &[StepObservation]) -> Result<Box<dyn PushModel>>;

/// What training needs to be told.
pub(crate) struct Setting {
    pub(crate) friction: f64,
    pub(crate) support: SupportSpec,
    /// Whether a third of the steps will do.
    pub(crate) quick: bool,
}

const KINDS: [Kind; 7] = [
    kind("analytical", Color::GREEN, 1000, |setting, steps| {
        Ok(Box::new(Analytical::nominal(setting.friction)?.fit(steps)?.model))
    }),
    kind("with effects", Color::INK, 1000, with_effects),
    kind("gp", Color::BLUE, 300, |_, steps| process(ProcessKind::Gp, steps)),
    kind("spgp", Color::SKY, 600, |_, steps| process(ProcessKind::Spgp, steps)),
    kind("rff", Color::PURPLE, 1000, |_, steps| process(ProcessKind::Rff, steps)),
    kind("vhgp", Color::ORANGE, 150, |_, steps| process(ProcessKind::Vhgp, steps)),
    kind("hybrid", Color::VERMILION, 300, |setting, steps| {
        let base = Analytical::nominal(setting.friction)?.describe()?;
        Ok(Box::new(Hybrid::train(&base, None, steps, &training(ProcessKind::Gp))?.0))
    }),
];

const fn kind(name: &'static str, color: Color, most: usize, train: Train) -> Kind {
    Kind { name, color, most, train }
}

/// Of the pushes that a model left out, each so many-th is rolled out by it.
const CHECKED: usize = 3;

/// A model, and how the errors of its steps go together in pushes that it has not seen.
pub(crate) struct Learnt {
    pub(crate) trained: Trained,
    pub(crate) correlation: StepCorrelation,
}

/// Learns the models of these names, or all, from the pushes of a turn: their correlations by models of
/// the same kind that each leave out a part of them.
///
/// # Errors
/// What a fit says.
pub(crate) fn learn(setting: &Setting, turn: &Turn<'_>, names: &[&str]) -> Result<Vec<Learnt>> {
    let folds = turn.folds();
    let by_fold: Vec<Vec<Trained>> = folds
        .iter()
        .map(|fold| train(setting, &steps_of(&fold.learn), names))
        .collect::<Result<_>>()?;
    let correlation = |kind: usize| {
        let left_out = folds.iter().zip(&by_fold).flat_map(|(fold, models)| {
            fold.left_out.iter().map(move |push| (models[kind].model.as_ref(), *push))
        });
        StepCorrelation::measure_by(left_out.clone())?.checked(left_out.step_by(CHECKED))
    };
    let all = train(setting, &steps_of(&turn.learn), names)?.into_iter().enumerate();
    all.map(|(kind, trained)| Ok(Learnt { trained, correlation: correlation(kind)? })).collect()
}

/// Trains the models of these names, or all.
///
/// # Errors
/// What a fit says.
fn train(setting: &Setting, steps: &[StepObservation], names: &[&str]) -> Result<Vec<Trained>> {
    let mut steps = steps.to_vec();
    steps.shuffle(&mut ChaCha8Rng::seed_from_u64(SEED));
    let wanted = |kind: &&Kind| names.is_empty() || names.contains(&kind.name);
    let wanted: Vec<&Kind> = KINDS.iter().filter(wanted).collect();
    let train = |kind: &&Kind| {
        let Kind { name, color, most, train } = **kind;
        let most = if setting.quick { most / 3 } else { most };
        Ok(Trained { name, color, model: train(setting, &steps[..most.min(steps.len())])? })
    };
    wanted.par_iter().map(train).collect()
}

/// One start, from which the prior keeps the process in bounds: many models are trained.
fn training(process: ProcessKind) -> Training {
    let mut options = learn_options();
    options.n_starts = 1;
    Training { process, ..options.into() }
}

fn process(kind: ProcessKind, steps: &[StepObservation]) -> Result<Box<dyn PushModel>> {
    Ok(Box::new(GpPushModel::train(steps, &training(kind))?.0))
}

/// The fitted model with the exact patch in place of the ellipsoid, as an effect, and the scatter
/// that is left about it.
fn with_effects(setting: &Setting, steps: &[StepObservation]) -> Result<Box<dyn PushModel>> {
    let fit = Analytical::nominal(setting.friction)?.fit(steps)?.model;
    let about = effects::by_id("limit-surface-shape")?.info();
    let effect: ModelEffect = effects::Setting::new(about, &[1.0]).into();
    let build = |scatter: Matrix3<f64>| {
        let length = models::CharacteristicLength::UniformPressure;
        let base = Analytical::new(fit.pusher_friction().clone(), length, scatter)?;
        let effects = vec![effect.clone()];
        let description = Description { base: Base::Analytical(base), effects, weights: None };
        Ok::<_, anyhow::Error>(description.build_in(setting.support, &[])?)
    };
    let bare = build(Matrix3::zeros())?;
    let inputs: Vec<_> = steps.iter().map(|step| step.input.clone()).collect();
    let said = bare.predict(&inputs, Noise::Excluded)?;
    let mut scatter = Matrix3::zeros();
    for (step, said) in steps.iter().zip(said) {
        let off = (step.outputs - said.mean) / step.input.distance();
        scatter += off * off.transpose() / steps.len() as f64;
    }
    build(scatter)
}
