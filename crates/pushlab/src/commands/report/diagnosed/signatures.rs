//! What an effect changes beside what a model misses, over place and angle of the push.

use ::report::{Axis, Cells, ColoredCell, Drawing, Figure, Hover, Panel, ReportError};
use anyhow::Result;
use diagnosis::{
    Cell, Comparison, Covariate, Diagnosis, MapSettings, NoiseFloor, Observations, Predictions,
    ResidualMap, compare,
};
use models::Description;

use super::super::measure::{Measure, covariate, title};
use crate::commands::add::diagnosed_effect;

/// Pairs of maps, and what there is to say where one is missing.
pub(in crate::commands::report) struct Signatures {
    pub(super) drawings: Vec<Drawing>,
    pub(super) notes: Vec<String>,
}

const OVER: [Covariate; 2] = [Covariate::P, Covariate::Beta];
const MOTION: [&str; 3] = ["dx", "dy", "dtheta"];
/// Effects that are shown.
const MOST: usize = 4;

impl Signatures {
    /// Of the effects that a diagnosis claims, or holds possible, beside what is left of a model: on
    /// all pushes, for the few that confirm fill few cells.
    ///
    /// # Errors
    /// If the model with an effect cannot predict these pushes.
    pub(in crate::commands::report) fn of(
        found: &Diagnosis,
        model: &Description,
        observations: &Observations,
        floor: &NoiseFloor,
    ) -> Result<Self> {
        let groups = found.ambiguous.iter().flatten();
        let ids: Vec<&String> = found.identified.iter().chain(groups).take(MOST).collect();
        let (mut drawings, mut notes) = (Vec::new(), Vec::new());
        let base = Predictions::of(model, &[], observations)?;
        let comparison = compare(observations, &base, floor, &MapSettings::default())?;
        for id in ids {
            if model.effects.iter().any(|effect| effect.id == *id) {
                notes.push(format!(
                    "{id} is in the page's first model already: its signature would be beside what \
                     that model misses."
                ));
                continue;
            }
            let Ok(effect) = diagnosed_effect(found, id) else {
                notes
                    .push(format!("The diagnosis does not tell the values of {id}: no signature."));
                continue;
            };
            let mut with = model.clone();
            with.effects.push(effect);
            let with = Predictions::of(&with, &[], observations)?;
            let expected = observations.as_predicted(&with);
            let signature = compare(&expected, &base, floor, &MapSettings::default())?;
            let name = strongest(&signature);
            let maps = [&signature, &comparison].map(|one| map(one, name));
            if let [Some(effect), Some(residual)] = maps {
                drawings.extend(pair_of(id, [effect, residual])?);
            } else {
                notes.push(format!(
                    "Too few pushes at each place and angle to draw what {id} changes."
                ));
            }
        }
        Ok(Self { drawings, notes })
    }
}

/// The number of the motion in which the signature stands out most from the floor.
fn strongest(signature: &Comparison) -> &'static str {
    let over = |name: &str| {
        let channel = signature.channels.iter().find(|channel| channel.name == name);
        channel.and_then(|channel| channel.over_floor.or(Some(channel.rms))).unwrap_or_default()
    };
    let largest = MOTION.into_iter().max_by(|a, b| over(a).total_cmp(&over(b)));
    largest.unwrap_or(MOTION[2])
}

fn map<'a>(comparison: &'a Comparison, name: &str) -> Option<&'a ResidualMap> {
    let mut maps = comparison.maps.iter();
    maps.find(|map| map.name == name && map.covariates == OVER && !map.cells.is_empty())
}

/// The map of an effect and of what is missed, with the same colors for the same values.
fn pair_of(id: &str, maps: [&ResidualMap; 2]) -> Result<Vec<Drawing>, ReportError> {
    let measure = Measure::of(maps[0].unit);
    let values = maps.iter().flat_map(|map| &map.cells).map(|cell| cell.mean.abs());
    let reach = (measure.per * values.fold(0.0, f64::max)).max(1e-12);
    let what = title(maps[0].name);
    let [of_effect, of_model] = [format!("{id}: {what}"), format!("the model: {what}")];
    Ok(vec![
        drawing(["effect changes", &of_effect], maps[0], measure, reach)?,
        drawing(["model misses", &of_model], maps[1], measure, reach)?,
    ])
}

fn drawing(
    [heading, caption]: [&str; 2],
    map: &ResidualMap,
    measure: Measure,
    reach: f64,
) -> Result<Drawing, ReportError> {
    let ends = |cell: &Cell, axis: usize| {
        let [from, to] = cell.ranges[axis].map(|end| Measure::of(OVER[axis].unit()).per * end);
        if from < to { [from, to] } else { [from - 1e-3, to + 1e-3] }
    };
    let mut hover = Hover::new();
    let mut cells = Vec::new();
    for cell in &map.cells {
        let (x, y) = (ends(cell, 0), ends(cell, 1));
        let (value, mean) = (measure.per * cell.mean, measure.signed(cell.mean));
        cells.push(ColoredCell { x, y, value });
        let text = format!("{mean}\n{} steps of {} pushes", cell.n_steps, cell.n_pushes);
        hover = hover.cell([x[0], y[0]], [x[1], y[1]], &text);
    }
    let x = Axis::new(covariate(OVER[0])).range(0.0, 1.0);
    let y = Axis::new(covariate(OVER[1])).range(-90.0, 90.0);
    let label = measure.label("mean");
    let panel = Panel::new(x, y)
        .title(heading)
        .with(Cells::new(cells, &label).range(-reach, reach))
        .with(hover);
    Drawing::new(&Figure::new(1, 1).panel_size(310.0, 260.0).with(panel), caption)
}
