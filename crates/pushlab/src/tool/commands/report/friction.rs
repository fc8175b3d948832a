//! Friction over the table, as the models that have it so say.

use ::report::{
    ColorMap, Drawing, Figure, Grid, HeatMap, LegendPlace, Panel, ReportError, Section,
};
use effects::{Effect, FrictionField};
use models::ModelFile;
use nalgebra::Vector2;

use super::{Report, tag};

/// Cells along the longer axis of a map.
const MOST_CELLS: f64 = 80.0;

/// None where no model has a field of friction.
pub(super) fn section(report: &Report) -> Result<Option<Section>, ReportError> {
    let fields: Vec<_> = report.models.iter().map(|model| values(&model.file)).collect();
    let Some([low, high]) = report.footprints.bounds() else { return Ok(None) };
    if fields.iter().all(Option::is_none) {
        return Ok(None);
    }
    let size = high - low;
    let cell = size.max() / MOST_CELLS;
    let [columns, rows] = [size.x, size.y].map(|side| (side / cell).ceil().max(1.0) as usize);
    let (x, y) = ((low.x, high.x), (low.y, high.y));
    let n_pushes = |x, y| report.footprints.n_pushes_over(&Vector2::new(x, y)) as f64;
    let n_pushes = Grid::sample(x, y, columns, rows, n_pushes);
    let is_told: Vec<bool> = n_pushes.values().iter().map(|n| *n > 0.0).collect();
    let mut maps = Vec::new();
    for (index, values) in fields.iter().enumerate() {
        let Some(values) = values else { continue };
        let at = |x, y| 100.0 * FrictionField::log_ratio(values, &Vector2::new(x, y)).exp_m1();
        maps.push((index, Grid::sample(x, y, columns, rows, at)));
    }
    let told = maps.iter().flat_map(|(_, grid)| grid.values().iter().zip(&is_told));
    let reach = told.filter(|(_, is_told)| **is_told).map(|(value, _)| value.abs());
    let reach = reach.fold(1e-9, f64::max);
    let mut drawings = Vec::new();
    for (index, grid) in maps {
        let name = format!("{} {}", tag(index), report.models[index].name);
        let map = HeatMap::new(grid.mask(is_told.clone()), "friction over nominal, less 1, in %");
        let panel = Panel::new("x of the table in m", "y of the table in m")
            .equal_aspect()
            .legend(LegendPlace::Hidden)
            .with(map.map(ColorMap::Diverging).range(-reach, reach));
        let figure = Figure::new(1, 1).panel_size(400.0, 360.0).named(&name).with(panel);
        drawings.push(Drawing::new(&figure, &name)?);
    }
    let text = "How much more, or less, each place of the table rubs than the model's friction of the \
        table. Where no object of this set lay it is blank: there a field of friction says nothing.";
    let section = Section::new("friction", "Friction over the table").text(text);
    Ok(Some(section.drawings(drawings)))
}

/// The values of a model's field, if it has one.
fn values(file: &ModelFile) -> Option<Vec<f64>> {
    let about = FrictionField.info();
    let own = file.description.effects.iter().find(|effect| effect.id == about.id)?;
    own.setting().values(about).ok()
}
