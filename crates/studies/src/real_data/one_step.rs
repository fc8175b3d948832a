//! One-step pushes: the errors of every model over random splits, and how honest its intervals are.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use dataset::{ObjectChoice, TableMapping};
use models::{
    Analytical, CharacteristicLength, GpPushModel, Hybrid, OUTPUTS, StepObservation, StepSelection,
    learn_options,
};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use serde_json::{Map, Value, json};

use super::Section;
use super::row::{Reference, Row};
use crate::held_out::{HeldOut, LEVELS, Scores, quantile, shuffled};

const NOMINAL_PUSHER_FRICTION: f64 = 0.30;
/// Training steps, with the error to expect where it is known.
const GP_POINTS: [(usize, Reference); 5] = [
    (20, Reference::Expected(0.116)),
    (50, Reference::Expected(0.062)),
    (100, Reference::Expected(0.052)),
    (200, Reference::Expected(0.046)),
    (500, Reference::Expected(0.038)),
];
const HYBRID_POINTS: [(usize, Reference); 5] = [
    (10, Reference::Expected(0.070)),
    (20, Reference::None),
    (50, Reference::Expected(0.056)),
    (100, Reference::None),
    (500, Reference::Expected(0.038)),
];
/// Steps set apart for training; every model of a split is tested on all the others.
const N_TRAIN: usize = 500;

/// The scores of one split.
struct Split {
    nominal_nmse: f64,
    fitted: Scores,
    mu_p: f64,
    c: f64,
    gp: Vec<Scores>,
    hybrid: Vec<Scores>,
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

/// The steps of the one-step table, read as the preset `mit-table` says.
fn read(path: &Path) -> Result<Vec<StepObservation>> {
    let mapping = TableMapping::mit_table()?;
    let table = mapping.read_table(path)?;
    let radius = mapping.pusher.radius;
    let objects = ObjectChoice::Fixed(Box::new(mapping.object));
    let found = StepSelection::default()
        .observations(&table, &objects, radius)
        .with_context(|| format!("cannot use {}", path.display()))?;
    if !found.excluded.rows.is_empty() {
        println!("{}: excluded {}", path.display(), found.excluded);
    }
    Ok(found.steps)
}

fn score(steps: &[StepObservation], seed: u64, split: u64) -> Result<Split> {
    let shuffled = shuffled(steps, seed, split);
    let (train, test) = shuffled.split_at(N_TRAIN);
    let test = HeldOut::new(test);
    let options = learn_options();
    let nominal = Analytical::nominal(NOMINAL_PUSHER_FRICTION)?;
    let fitted = nominal.fit(train)?.model;
    let gp = |&(n, _): &(usize, Reference)| {
        let model = GpPushModel::learn(&train[..n], &options);
        test.scores(&model.with_context(|| format!("GP, split {split}, {n} points"))?.0)
    };
    let hybrid = |&(n, _): &(usize, Reference)| {
        let base = nominal.fit(&train[..n])?.model;
        let model = Hybrid::learn(base, &train[..n], &options);
        test.scores(&model.with_context(|| format!("hybrid, split {split}, {n} points"))?.0)
    };
    Ok(Split {
        nominal_nmse: test.nmse(&nominal)?,
        fitted: test.scores(&fitted)?,
        mu_p: fitted.pusher_friction().value,
        c: fitted.characteristic_length(&steps[0].input),
        gp: GP_POINTS.iter().map(gp).collect::<Result<_>>()?,
        hybrid: HYBRID_POINTS.iter().map(hybrid).collect::<Result<_>>()?,
    })
}

fn summary(splits: &[Split]) -> Section {
    let median_of =
        |value: &dyn Fn(&Split) -> f64| quantile(splits.iter().map(value).collect(), 0.5);
    let nominal = median_of(&|split| split.nominal_nmse);
    let fitted = median_of(&|split| split.fitted.nmse());
    let (mu_p, c) = (median_of(&|split| split.mu_p), median_of(&|split| split.c));
    let rows = vec![
        Row::new("analytical, nominal: NMSE", nominal, Reference::Expected(0.074)),
        Row::new("analytical, fitted: NMSE", fitted, Reference::Expected(0.062)),
        Row::new("analytical, fitted: pusher friction", mu_p, Reference::Expected(0.231)),
        Row::new("analytical, fitted: c in m", c, Reference::Expected(0.0350)),
    ];
    let mut section = Section { json: Map::new(), rows };
    let mut insert = |key: &str, value: Value| section.json.insert(key.to_owned(), value);
    insert("analytical_nominal_nmse", nominal.into());
    insert("analytical_fitted_nmse", fitted.into());
    insert("analytical_fitted", json!({ "mu_p": mu_p, "c_m": c }));
    insert("coverage_levels", json!(LEVELS));
    curve(&mut section, "GP", "gp", &GP_POINTS, splits, |split| &split.gp);
    curve(&mut section, "hybrid", "hybrid", &HYBRID_POINTS, splits, |split| &split.hybrid);
    section
}

/// Adds the medians over the splits of all scores of a learnt model, by number of training steps.
fn curve(
    section: &mut Section,
    title: &str,
    key: &str,
    points: &[(usize, Reference)],
    splits: &[Split],
    scores: fn(&Split) -> &[Scores],
) {
    let mut json = [Map::new(), Map::new(), Map::new()];
    for (i, &(n, reference)) in points.iter().enumerate() {
        let median = |value: &dyn Fn(&Scores) -> f64| {
            quantile(splits.iter().map(|split| value(&scores(split)[i])).collect(), 0.5)
        };
        let nmse = median(&Scores::nmse);
        let by_output = |value: &dyn Fn(usize) -> Value| {
            Value::from_iter(OUTPUTS.iter().enumerate().map(|(k, name)| (*name, value(k))))
        };
        let coverage = by_output(&|k| {
            json!([0, 1, 2].map(|level| median(&|scores| scores.0[k].coverage[level])))
        });
        let nlpd = by_output(&|k| median(&|scores| scores.0[k].nlpd).into());
        for (json, value) in json.iter_mut().zip([nmse.into(), coverage, nlpd]) {
            json.insert(n.to_string(), value);
        }
        let covered = |level: usize| median(&|scores| scores.mean(|output| output.coverage[level]));
        section.rows.push(Row::new(format!("{title}, {n} points: NMSE"), nmse, reference));
        for (level, share) in LEVELS.iter().enumerate() {
            let name = format!("{title}, {n} points: share in {:.0} %", 100.0 * share);
            section.rows.push(Row::new(name, covered(level), Reference::None));
        }
        let density = median(&|scores| scores.mean(|output| output.nlpd));
        let name = format!("{title}, {n} points: NLPD in nats");
        section.rows.push(Row::new(name, density, Reference::None));
    }
    for (name, json) in ["nmse", "coverage", "nlpd"].iter().zip(json) {
        section.json.insert(format!("{key}_{name}"), json.into());
    }
}
