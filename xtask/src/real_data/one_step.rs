//! One-step pushes: the errors of every model over random splits.

use std::{path::Path, sync::Arc};

use anyhow::{Context, Result, ensure};
use gp_core::{LearnOptions, scores::nmse};
use models::{
    Analytical, CharacteristicLength, GpPushModel, Hybrid, Noise, OUTPUTS, PushModel, StepInput,
    StepObservation,
};
use nalgebra::Vector3;
use planar::mit_object;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use serde_json::{Map, json};

use super::Section;
use super::row::{Reference, Row};

const NOMINAL_PUSHER_FRICTION: f64 = 0.30;
/// Of the rig's tip, in m.
const PUSHER_RADIUS: f64 = 0.00475;
/// 20 mm/s for 0.2 s.
const DISTANCE: f64 = 0.004;
/// The face at −x of the square.
const PUSHED_EDGE: usize = 1;
const GP_POINTS: [(usize, f64); 5] =
    [(20, 0.116), (50, 0.062), (100, 0.052), (200, 0.046), (500, 0.038)];
const HYBRID_POINTS: [(usize, f64); 3] = [(10, 0.070), (50, 0.056), (500, 0.038)];
/// Steps set apart for training; every model of a split is tested on all the others.
const N_TRAIN: usize = 500;

/// The scores of one split.
struct Split {
    nominal: f64,
    fitted: f64,
    mu_p: f64,
    c: f64,
    gp: Vec<f64>,
    hybrid: Vec<f64>,
}

pub(super) fn run(path: &Path, n_splits: u64, seed: u64) -> Result<Section> {
    let steps = read(path)?;
    ensure!(
        steps.len() > 2 * N_TRAIN,
        "{}: {} steps are too few for {N_TRAIN} to train on and more to test on",
        path.display(),
        steps.len()
    );
    ensure!(n_splits > 0, "--splits must be at least 1");
    let splits: Result<Vec<Split>> =
        (0..n_splits).into_par_iter().map(|split| score(&steps, seed, split)).collect();
    let all = Analytical::nominal(NOMINAL_PUSHER_FRICTION)?.fit(&steps)?;
    let mut section = summary(&splits?);
    if let CharacteristicLength::Given(c) = all.model.length() {
        let mu_p = all.model.pusher_friction();
        section.json.insert(
            "analytical_fitted_on_all".to_owned(),
            json!({
                "mu_p": mu_p.value, "mu_p_se": mu_p.se, "c_m": c.value, "c_se_m": c.se,
                "correlation": all.correlation, "iterations": all.iterations, "steps": steps.len(),
            }),
        );
    }
    Ok(section)
}

/// Reads the one-step table: c is p of the face at −x, φ is β, and Δy has the other sign.
fn read(path: &Path) -> Result<Vec<StepObservation>> {
    let object = mit_object("rect1")?;
    let shape = Arc::new(object.shape);
    let context = || format!("cannot read {}", path.display());
    let mut reader = csv::Reader::from_path(path).with_context(context)?;
    let expected = ["c", "phi_rad", "dx_c_m", "dy_c_m_sign_flipped", "dtheta_rad"];
    let header = reader.headers().with_context(context)?;
    ensure!(*header == expected[..], "{}:1: columns must be {expected:?}", path.display());
    let step = |(i, row): (usize, csv::Result<[f64; 5]>)| {
        let line = || format!("{}:{}", path.display(), i + 2);
        let [c, phi, dx, dy_flipped, dtheta] = row.with_context(line)?;
        let input = StepInput::on_edge(shape.clone(), PUSHER_RADIUS, PUSHED_EDGE, c, phi, DISTANCE)
            .with_context(line)?;
        Ok(StepObservation { input, outputs: Vector3::new(dx, -dy_flipped, dtheta) })
    };
    reader.deserialize().enumerate().map(step).collect()
}

fn score(steps: &[StepObservation], seed: u64, split: u64) -> Result<Split> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(split);
    let mut shuffled = steps.to_vec();
    shuffled.shuffle(&mut rng);
    let (train, test) = shuffled.split_at(N_TRAIN);
    let test = Test::new(test);
    let options = LearnOptions::default();
    let nominal = Analytical::nominal(NOMINAL_PUSHER_FRICTION)?;
    let fitted = nominal.fit(train)?.model;
    let gp = |&(n, _): &(usize, f64)| {
        let model = GpPushModel::learn(&train[..n], &options);
        test.nmse(&model.with_context(|| format!("GP, split {split}, {n} points"))?.0)
    };
    let hybrid = |&(n, _): &(usize, f64)| {
        let base = nominal.fit(&train[..n])?.model;
        let model = Hybrid::learn(base, &train[..n], &options);
        test.nmse(&model.with_context(|| format!("hybrid, split {split}, {n} points"))?.0)
    };
    Ok(Split {
        nominal: test.nmse(&nominal)?,
        fitted: test.nmse(&fitted)?,
        mu_p: fitted.pusher_friction().value,
        c: fitted.characteristic_length(&steps[0].input),
        gp: GP_POINTS.iter().map(gp).collect::<Result<_>>()?,
        hybrid: HYBRID_POINTS.iter().map(hybrid).collect::<Result<_>>()?,
    })
}

/// The held-out steps.
struct Test {
    inputs: Vec<StepInput>,
    outputs: [Vec<f64>; 3],
}

impl Test {
    fn new(steps: &[StepObservation]) -> Self {
        let output = |k: usize| steps.iter().map(|step| step.outputs[k]).collect();
        Self {
            inputs: steps.iter().map(|step| step.input.clone()).collect(),
            outputs: [output(0), output(1), output(2)],
        }
    }

    /// Mean over the outputs of squared error over variance.
    fn nmse(&self, model: &dyn PushModel) -> Result<f64> {
        let predictions = model.predict(&self.inputs, Noise::Excluded)?;
        let mut sum = 0.0;
        for (k, observed) in self.outputs.iter().enumerate() {
            let mean: Vec<f64> = predictions.iter().map(|prediction| prediction.mean[k]).collect();
            sum += nmse(observed, &mean)?;
        }
        Ok(sum / OUTPUTS.len() as f64)
    }
}

fn summary(splits: &[Split]) -> Section {
    let median_of = |value: &dyn Fn(&Split) -> f64| median(splits.iter().map(value).collect());
    let nominal = median_of(&|split| split.nominal);
    let fitted = median_of(&|split| split.fitted);
    let (mu_p, c) = (median_of(&|split| split.mu_p), median_of(&|split| split.c));
    let mut rows = vec![
        Row::new("analytical, nominal: NMSE", nominal, Reference::Expected(0.074)),
        Row::new("analytical, fitted: NMSE", fitted, Reference::Expected(0.062)),
        Row::new("analytical, fitted: pusher friction", mu_p, Reference::Expected(0.231)),
        Row::new("analytical, fitted: c in m", c, Reference::Expected(0.0350)),
    ];
    let mut curve = |name: &str, points: &[(usize, f64)], scores: fn(&Split) -> &[f64]| {
        let mut curve = Map::new();
        for (k, (n, expected)) in points.iter().enumerate() {
            let nmse = median_of(&|split| scores(split)[k]);
            curve.insert(n.to_string(), nmse.into());
            let name = format!("{name}, {n} points: NMSE");
            rows.push(Row::new(name, nmse, Reference::Expected(*expected)));
        }
        curve
    };
    let gp = curve("GP", &GP_POINTS, |split| &split.gp);
    let hybrid = curve("hybrid", &HYBRID_POINTS, |split| &split.hybrid);
    let mut json = Map::new();
    json.insert("analytical_nominal_nmse".to_owned(), nominal.into());
    json.insert("analytical_fitted_nmse".to_owned(), fitted.into());
    json.insert("analytical_fitted".to_owned(), json!({ "mu_p": mu_p, "c_m": c }));
    json.insert("gp_nmse".to_owned(), gp.into());
    json.insert("hybrid_nmse".to_owned(), hybrid.into());
    Section { json, rows }
}

/// The middle value, or the mean of the two middle ones; NaN of nothing.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    match values.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => values[n / 2],
        n => 0.5 * (values[n / 2 - 1] + values[n / 2]),
    }
}

#[cfg(test)]
mod tests {
    use super::median;

    #[test]
    fn the_median_is_the_middle() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), 2.5);
    }
}
