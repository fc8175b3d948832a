//! What a model file says, in the order and the words of people.

use std::fmt;

use effects::Spread;
use models::{
    Analytical, Base, Calibration, CharacteristicLength, Cluster, Estimate, ModelEffect, ModelFile,
    OUTPUTS, Split, Unexplained,
};
use serde::Serialize;

use crate::tool::people::{behind_number, four_digits, short_digests};
use crate::tool::terminal::TITLE;
use crate::tool::unexplained::shares;
use crate::tool::whole_pushes::Told;

/// A model's name, kind and parameters.
#[derive(Serialize)]
pub(crate) struct Parameters {
    pub(crate) name: String,
    pub(crate) kind: &'static str,
    /// Of the kinds with mechanics.
    pub(crate) limit_surface: Option<&'static str>,
    pub(crate) parameters: Vec<Parameter>,
    /// Outputs that were learnt, for the kinds that learn.
    pub(crate) learned: Vec<&'static str>,
    /// The kind of process that learnt them.
    pub(crate) process: Option<&'static str>,
    /// What it sees of a step.
    pub(crate) inputs: Vec<String>,
    /// Of a hybrid: shares of what was learnt in what it says of its training steps.
    pub(crate) unexplained: Option<Unexplained>,
    /// None for a model that was not fitted to a part of a set.
    pub(crate) split: Option<Parts>,
    /// How sure it may be of whole pushes, if that was measured.
    pub(crate) calibration: Option<Calibration>,
}

/// The parts of the recordings that the model was fitted to.
#[derive(Serialize)]
pub(crate) struct Parts {
    /// SHA-256 over the hashes of the recordings.
    set: String,
    seed: u64,
    cluster: Cluster,
    n_fit: usize,
    n_confirm: usize,
}

impl Parts {
    fn of(split: &Split) -> Self {
        let Split { set, seed, cluster, fit, confirm, .. } = split;
        let (n_fit, n_confirm) = (fit.len(), confirm.len());
        Self { set: set.clone(), seed: *seed, cluster: *cluster, n_fit, n_confirm }
    }
}

/// A parameter as the file states it.
#[derive(Serialize)]
pub(crate) struct Parameter {
    pub(crate) name: String,
    /// None where it follows from the object.
    pub(crate) value: Option<f64>,
    /// Standard error; 0 for a value taken as exact.
    pub(crate) se: f64,
    pub(crate) unit: &'static str,
    pub(crate) source: String,
}

impl Parameters {
    pub(crate) fn of(file: &ModelFile) -> Self {
        let (kind, mechanics) = match &file.description.base {
            Base::Analytical(model) => ("analytical", Some(model)),
            Base::Hybrid(model) => ("hybrid", Some(model)),
            Base::Process(process) => (process.id(), None),
            _ => ("unknown", None),
        };
        let limit_surface = mechanics.map(|model| model.surface().name());
        let mut parameters = mechanics.map(analytical).unwrap_or_default();
        parameters.extend(file.description.effects.iter().flat_map(of_effect));
        let weights = file.description.weights.as_ref();
        let beside = weights.and_then(|weights| weights.orthogonal_discrepancy.as_ref());
        let split = file.split.as_ref().map(Parts::of);
        Self {
            name: file.name.clone(),
            kind,
            limit_surface,
            parameters,
            learned: weights.map(|_| OUTPUTS.to_vec()).unwrap_or_default(),
            process: weights.map(|weights| weights.kind().id()),
            inputs: weights.map(|weights| weights.inputs.clone()).unwrap_or_default(),
            unexplained: beside.map(|beside| beside.unexplained),
            split,
            calibration: file.calibration.clone(),
        }
    }
}

fn analytical(model: &Analytical) -> Vec<Parameter> {
    let parameter = |name: &str, estimate: &Estimate, unit| Parameter {
        name: name.to_owned(),
        value: Some(estimate.value),
        se: estimate.se,
        unit,
        source: estimate.source.clone(),
    };
    let length = "characteristic length";
    let mut parameters = vec![
        parameter("pusher friction", model.pusher_friction(), "1"),
        match model.length() {
            CharacteristicLength::Given(estimate) => parameter(length, estimate, "m"),
            CharacteristicLength::UniformPressure => Parameter {
                name: length.to_owned(),
                value: None,
                se: 0.0,
                unit: "m",
                source: "uniform pressure under the object".to_owned(),
            },
        },
    ];
    let units = ["m/m", "m/m", "rad/m"];
    for ((output, unit), variance) in OUTPUTS.iter().zip(units).zip(&model.scatter().diagonal()) {
        if *variance > 0.0 {
            let estimate = Estimate::exact(variance.sqrt(), "fit");
            parameters.push(parameter(&format!("scatter of {output}, sd"), &estimate, unit));
        }
    }
    parameters
}

/// The parameters of an effect, named after both.
fn of_effect(effect: &ModelEffect) -> Vec<Parameter> {
    let about = effects::by_id(&effect.id).map(|effect| effect.info()).ok();
    let unit = |name: &str| {
        let known = about?.parameters.iter().find(|parameter| parameter.name == name)?;
        Some(known.unit)
    };
    let parameter = |(name, estimate): (&String, &Estimate)| Parameter {
        name: format!("{} {name}", effect.id),
        value: Some(estimate.value),
        se: estimate.se,
        unit: unit(name).unwrap_or("1"),
        source: estimate.source.clone(),
    };
    // Points and cells that bear nothing are not told.
    let is_something = |one: &(&String, &Estimate)| {
        one.1.value != 0.0 || one.1.se != 0.0 || effect.id != SUPPORT_POINTS
    };
    let mut parameters: Vec<Parameter> =
        effect.parameters.iter().filter(is_something).map(parameter).collect();
    parameters.extend(of_points(effect));
    let spreads = [
        ("push", &effect.per_push),
        ("session", &effect.per_session),
        ("place", &effect.per_place),
    ];
    for (per, spreads) in spreads {
        for (name, spread) in spreads {
            let (words, sd, unit) = match spread {
                Spread::Sd(sd) => ("sd", sd, unit(name).unwrap_or("1")),
                Spread::RelativeSd(sd) => ("relative sd", sd, "1"),
            };
            let (name, source) =
                (format!("{} {name}, {words} per {per}", effect.id), String::new());
            parameters.push(Parameter { name, value: Some(*sd), se: 0.0, unit, source });
        }
    }
    parameters
}

const SUPPORT_POINTS: &str = "support-points";

/// What follows from points that bear the whole weight: their center and their mean distance from it.
fn of_points(effect: &ModelEffect) -> Vec<Parameter> {
    let about = effects::by_id(&effect.id).map(|effect| effect.info()).ok();
    let values = about.and_then(|about| effect.setting().values(about).ok()).unwrap_or_default();
    let points = values.chunks_exact(3);
    let whole: f64 = points.clone().map(|point| point[2]).sum();
    if effect.id != SUPPORT_POINTS || (whole - 1.0).abs() > 1e-6 {
        return Vec::new();
    }
    let mean = |of: &dyn Fn(&[f64]) -> f64| points.clone().map(|p| p[2] / whole * of(p)).sum();
    let (x, y): (f64, f64) = (mean(&|point| point[0]), mean(&|point| point[1]));
    let distance: f64 = mean(&|point| (point[0] - x).hypot(point[1] - y));
    let named =
        [("center of friction x", x), ("center of friction y", y), ("mean distance c", distance)];
    let told = named.map(|(name, value)| Parameter {
        name: format!("{SUPPORT_POINTS} {name}"),
        value: Some(value),
        se: 0.0,
        unit: "m",
        source: "follows from the points".to_owned(),
    });
    told.into()
}

impl fmt::Display for Parameters {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{TITLE}{}{TITLE:#} ({})", self.name, self.kind)?;
        if let Some(surface) = self.limit_surface {
            writeln!(f, "  limit surface: {surface}")?;
        }
        for Parameter { name, value, se, unit, source } in &self.parameters {
            let unit = behind_number(unit);
            let value = match value {
                Some(value) if *se > 0.0 => {
                    format!("{} ± {}{unit}", four_digits(*value), four_digits(*se))
                }
                Some(value) => format!("{}{unit}", four_digits(*value)),
                None => "of the object".to_owned(),
            };
            let source = short_digests(source);
            let source = if source.is_empty() { source } else { format!("  ({source})") };
            writeln!(f, "  {name}: {value}{source}")?;
        }
        if let Some(process) = self.process {
            let (outputs, inputs) = (self.learned.join(", "), self.inputs.join(", "));
            writeln!(f, "  {outputs}: {process} of {inputs}")?;
        }
        if let Some(unexplained) = &self.unexplained {
            writeln!(f, "  share that no physics explains: {}", shares(unexplained))?;
        }
        if let Some(calibration) = &self.calibration {
            writeln!(f, "  of whole pushes: {}", Told(calibration))?;
        }
        if let Some(Parts { set, seed, n_fit, n_confirm, .. }) = &self.split {
            let set = short_digests(set);
            writeln!(f, "  fitted to {n_fit} pushes of recordings with sha256:{set};")?;
            writeln!(f, "  {n_confirm} others are kept to confirm it (seed {seed})")?;
        }
        Ok(())
    }
}
