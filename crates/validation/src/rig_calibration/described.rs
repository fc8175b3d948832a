//! A table of steps in the numbers that are compared.

use anyhow::{Context, Result};
use models::{
    Analytical, CharacteristicLength, GpPushModel, Hybrid, Noise, PushModel, StepInput,
    StepObservation, learn_options,
};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::row::Row;
use super::scatter::{Neighbors, rms};
use super::table::Steps;

/// Training steps of the learning curves, and splits whose median counts.
const COUNTS: [usize; 5] = [20, 50, 100, 200, 500];
const N_SPLITS: u64 = 4;
const MOST_TESTED: usize = 1000;
const SEED: u64 = 7;
/// From m and rad to mm and °.
const UNITS: [(&str, f64); 3] =
    [("Δx / mm", 1e3), ("Δy / mm", 1e3), ("Δθ / °", 180.0 / std::f64::consts::PI)];
/// Distance of p from the middle, and size of β in °, of steps near the middle and far from it.
const P_PARTS: (f64, f64) = (0.2, 0.35);
const BETA_PARTS: (f64, f64) = (25.0, 50.0);

/// A table's numbers, by name.
pub(super) struct Described(Vec<(String, f64)>);

impl Described {
    /// - `quick`: without the learning curves.
    ///
    /// # Errors
    /// A model that cannot be fitted to these steps.
    pub(super) fn of(data: &Steps, quick: bool) -> Result<Self> {
        let steps = &data.steps;
        let near = Neighbors::of(steps, data.pushes.as_deref());
        let mut found = Vec::new();
        let mut add = |name: &str, value: f64| found.push((name.to_owned(), value));
        let (scatter, elsewhere) = (near.scatter(steps), near.scatter_elsewhere(steps));
        for (k, (unit, scale)) in UNITS.iter().enumerate() {
            add(&format!("scatter of like steps, {unit}"), scale * scatter[k]);
        }
        for (k, (unit, scale)) in UNITS.iter().enumerate() {
            add(&format!("the same in different runs, {unit}"), scale * elsewhere[k]);
        }
        let away = |step: &StepObservation| (step.input.p() - 0.5).abs();
        let steep = |step: &StepObservation| step.input.beta().abs().to_degrees();
        let (inner, outer) = P_PARTS;
        let growth = near.growth(steps, |own| away(own) > outer, |own| away(own) < inner);
        add("growth of the scatter towards the corners", growth);
        let (inner, outer) = BETA_PARTS;
        let growth = near.growth(steps, |own| steep(own) > outer, |own| steep(own) < inner);
        add("growth of the scatter with |β|", growth);
        let nominal = Analytical::nominal(data.friction)?;
        let fit = nominal.fit(steps)?.model;
        let errors = errors(&fit, steps)?;
        let mut sizes: Vec<f64> = errors.iter().map(Vector3::norm).collect();
        sizes.sort_by(f64::total_cmp);
        let squares = |part: &[f64]| part.iter().map(|size| size * size).sum::<f64>();
        let at = |share: f64| (share * sizes.len() as f64) as usize;
        add("99 % over 50 % quantile of the errors", sizes[at(0.99)] / sizes[at(0.5)]);
        add("share of the worst 1 %", squares(&sizes[at(0.99)..]) / squares(&sizes));
        add("correlation of errors along a push", near.correlation(&errors));
        if let CharacteristicLength::Given(length) = fit.length() {
            let uniform = nominal.characteristic_length(&steps[0].input);
            add("fitted c over that of uniform pressure", length.value / uniform);
        }
        add("fitted friction of the pusher", fit.pusher_friction().value);
        if !quick {
            for (name, value) in learned(&nominal, steps)? {
                add(&name, value);
            }
        }
        Ok(Self(found))
    }
}

/// The numbers of simulated tables, in the median, beside those of a real one.
pub(super) fn rows(simulated: &[Described], measured: Option<&Described>) -> Vec<Row> {
    let Some(first) = simulated.first() else { return Vec::new() };
    let names = first.0.iter().enumerate();
    let row = |(index, (name, _)): (usize, &(String, f64))| {
        let values = simulated.iter().map(|own| own.0[index].1).collect();
        Row::new(name.clone(), median(values), measured.map(|own| own.0[index].1))
    };
    names.map(row).collect()
}

/// The middle one, or the mean of both middle ones.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    if n == 0 { f64::NAN } else { 0.5 * (values[(n - 1) / 2] + values[n / 2]) }
}

/// Errors of a model, each output's over its standard deviation.
fn errors(model: &dyn PushModel, steps: &[StepObservation]) -> Result<Vec<Vector3<f64>>> {
    let inputs: Vec<StepInput> = steps.iter().map(|step| step.input.clone()).collect();
    let mean = steps.iter().map(|step| step.outputs).sum::<Vector3<f64>>() / steps.len() as f64;
    let size = rms(steps.iter().map(|step| step.outputs - mean));
    let predicted = model.predict(&inputs, Noise::Excluded)?;
    let error = |(step, own): (&StepObservation, &models::StepPrediction)| {
        (step.outputs - own.mean).component_div(&size)
    };
    Ok(steps.iter().zip(&predicted).map(error).collect())
}

/// Mean over the outputs of squared error over variance.
fn nmse(model: &dyn PushModel, steps: &[StepObservation]) -> Result<f64> {
    let errors = errors(model, steps)?;
    Ok(errors.iter().map(Vector3::norm_squared).sum::<f64>() / (3 * errors.len()) as f64)
}

/// Errors of the fitted analytical model and of the GPs, and the ratio of physics to GP.
fn learned(nominal: &Analytical, steps: &[StepObservation]) -> Result<Vec<(String, f64)>> {
    let most = COUNTS[COUNTS.len() - 1];
    let options = learn_options();
    let splits = (0..N_SPLITS).into_par_iter().map(|split| {
        let mut rng = ChaCha8Rng::seed_from_u64(SEED);
        rng.set_stream(split);
        let mut steps = steps.to_vec();
        steps.shuffle(&mut rng);
        let parts = steps.split_at_checked(most).filter(|(_, test)| !test.is_empty());
        let (train, test) = parts.context("more than 500 steps are needed")?;
        let test = &test[..test.len().min(MOST_TESTED)];
        let mut values = vec![nmse(&nominal.fit(train)?.model, test)?];
        for count in COUNTS {
            let train = &train[..count];
            let base = nominal.fit(train)?.model;
            values.push(nmse(&GpPushModel::learn(train, &options)?.0, test)?);
            values.push(nmse(&Hybrid::learn(base, train, &options)?.0, test)?);
        }
        Ok(values)
    });
    let splits = splits.collect::<Result<Vec<Vec<f64>>>>()?;
    let at = |index: usize| median(splits.iter().map(|values| values[index]).collect());
    let mut found = vec![("error, analytical, fitted".to_owned(), at(0))];
    for (i, count) in COUNTS.iter().enumerate() {
        let (gp, hybrid) = (at(1 + 2 * i), at(2 + 2 * i));
        found.push((format!("error, GP with {count} steps"), gp));
        found.push((format!("error, hybrid with {count} steps"), hybrid));
        found.push((format!("ratio of physics to GP with {count} steps"), at(0) / gp));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::{Described, median, rows};

    #[test]
    fn medians_stand_beside_the_measured_number() {
        assert_eq!(median(vec![3.0, 1.0, 2.0, 10.0]), 2.5);
        let of = |value: f64| Described(vec![("x".into(), value)]);
        let rows = rows(&[of(1.0), of(4.0), of(2.0)], Some(&of(1.9)));
        assert_eq!((rows[0].simulated, rows[0].real), (2.0, Some(1.9)));
    }
}
