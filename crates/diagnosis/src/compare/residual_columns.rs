//! Every step with what was measured and what a model says of it, for tools of others.

use dataset::{Cells, NamedColumn};
use effects::{Channels, StepInput};

use crate::data::observations::Place;
use crate::{DiagnosisError, Observations, Predictions};

/// A number of a step.
type Number = fn(&StepInput, &Place) -> f64;

/// What was done in a step, SI units: how it begins in frame W, and how the pusher goes on.
const INPUTS: [(&str, Number); 12] = [
    ("p", |_, place| place.p),
    ("beta_rad", |_, place| place.beta),
    ("speed_m_s", |_, place| place.speed),
    ("duration_s", |input, _| input.track.duration()),
    ("since_contact_s", |input, _| input.since_contact),
    ("object_x_m", |input, _| input.pose_wb.position.x),
    ("object_y_m", |input, _| input.pose_wb.position.y),
    ("object_theta_rad", |input, _| input.pose_wb.angle),
    ("pusher_x_m", |input, _| input.track.start().x),
    ("pusher_y_m", |input, _| input.track.start().y),
    ("pusher_end_x_m", |input, _| input.track.end().x),
    ("pusher_end_y_m", |input, _| input.track.end().y),
];
/// Units of the numbers of [`Channels`].
const UNITS: [&str; 7] = ["m", "m", "rad", "N", "N", "m", "m"];

/// The steps of observations as columns, one row a step, in SI units that the names end with (`m2` is m²).
///
/// - What the step is: `recording`, `push`, `step`, `session` and `edge`, counted from 0, and its `flags`.
/// - What was done: where the contact is on the edge (`p`, 0 to 1), the push's angle from the inward normal
///   (`beta_rad`), and in frame W the object's pose at the start and the pusher's center at both ends.
/// - Of each number of [`Channels`] what was `measured` and `predicted`, the `residual` (observed less
///   predicted), and the `variance` that the model itself claims; empty where there is none.
///
/// # Errors
/// `OtherSteps` if the predictions are of other observations.
pub fn residual_columns(
    observations: &Observations,
    predictions: &Predictions,
) -> Result<Vec<NamedColumn>, DiagnosisError> {
    let residuals = predictions.residuals(observations)?;
    let column = |name: &str, cells| NamedColumn { name: name.to_owned(), cells };
    let pushes = || observations.push_of.iter().map(|push| &observations.pushes[*push]);
    let (steps, places) = (|| observations.steps.iter(), || observations.places.iter());
    let mut columns = vec![
        column("recording", Cells::Text(pushes().map(|push| push.recording.clone()).collect())),
        column("push", Cells::Integer(pushes().map(|push| push.push).collect())),
        column("step", Cells::Integer(places().map(|place| place.step).collect())),
        column("session", Cells::Integer(steps().map(|step| step.input.session).collect())),
        column("edge", Cells::Integer(places().map(|place| place.edge).collect())),
        column("flags", Cells::Text(places().map(|place| place.flags.to_string()).collect())),
    ];
    columns.extend(INPUTS.iter().map(|(name, number)| {
        let values = steps().zip(places()).map(|(step, place)| Some(number(&step.input, place)));
        column(name, Cells::Real(values.collect()))
    }));
    for (number, (name, unit)) in Channels::NAMES.iter().zip(UNITS).enumerate() {
        let square = format!("{unit}2");
        let of = |values: &[[Option<f64>; 7]]| {
            Cells::Real(values.iter().map(|values| values[number]).collect())
        };
        let measured: Vec<_> = steps().map(|step| step.observed).collect();
        columns.extend([
            column(&format!("{name}_measured_{unit}"), of(&measured)),
            column(&format!("{name}_predicted_{unit}"), of(predictions.steps())),
            column(&format!("{name}_residual_{unit}"), of(&residuals)),
            column(&format!("{name}_variance_{square}"), of(&predictions.variances)),
        ]);
    }
    Ok(columns)
}

#[cfg(test)]
mod tests {
    use dataset::Cells;

    use super::residual_columns;
    use crate::Predictions;
    use crate::synthetic::recorded;

    #[test]
    fn residuals_are_what_was_measured_less_what_was_predicted() {
        let (observations, model) = recorded(6);
        let predictions = Predictions::of(&model, &[], &observations).unwrap();
        let columns = residual_columns(&observations, &predictions).unwrap();
        let real = |name: &str| {
            let column = columns.iter().find(|column| column.name == name).unwrap();
            let Cells::Real(cells) = &column.cells else { panic!("{name}") };
            cells.clone()
        };
        let [measured, predicted, residual] =
            ["dtheta_measured_rad", "dtheta_predicted_rad", "dtheta_residual_rad"].map(real);
        assert_eq!(measured.len(), observations.n_steps());
        for ((measured, predicted), residual) in measured.iter().zip(&predicted).zip(&residual) {
            let [measured, predicted, residual] =
                [measured, predicted, residual].map(|value| value.unwrap());
            assert!((measured - predicted - residual).abs() < 1e-15);
        }
        assert!(residual.iter().any(|residual| residual.unwrap() != 0.0));
    }
}
