//! A map of residuals over p and β as a grid of colors.

use diagnosis::{Cell, Comparison, Covariate};
use report::Grid;

const COLUMNS: usize = 5;
const ROWS: usize = 12;
/// Of a row, in degrees.
const ROW: f64 = 180.0 / ROWS as f64;

/// What a map over p and β says of each cell: p to the right, β in degrees upwards; cells with too
/// little data are not shown. None if there is no such map.
pub(crate) fn grid(
    comparison: &Comparison,
    name: &str,
    value: impl Fn(&Cell) -> Option<f64>,
) -> Option<Grid> {
    let over = [Covariate::P, Covariate::Beta];
    let map = comparison.maps.iter().find(|map| map.name == name && map.covariates == over)?;
    let mut values = vec![0.0; COLUMNS * ROWS];
    let mut shown = vec![false; COLUMNS * ROWS];
    for cell in &map.cells {
        let [p, beta] = [0, 1].map(|axis| 0.5 * (cell.ranges[axis][0] + cell.ranges[axis][1]));
        let column = (p * COLUMNS as f64).floor() as usize;
        let row = ((beta.to_degrees() + 90.0) / ROW).floor() as usize;
        if let Some(value) = value(cell)
            && let Some(place) = values.get_mut(row * COLUMNS + column)
        {
            *place = value;
            shown[row * COLUMNS + column] = true;
        }
    }
    Some(Grid::new((0.0, 1.0), (-90.0, 90.0), COLUMNS, ROWS, values).mask(shown))
}

/// The largest size of what is shown.
pub(crate) fn largest(
    comparison: &Comparison,
    names: &[&str],
    value: impl Fn(&Cell) -> Option<f64>,
) -> f64 {
    let over = [Covariate::P, Covariate::Beta];
    let maps = comparison.maps.iter();
    let maps = maps.filter(|map| names.contains(&map.name) && map.covariates == over);
    let values = maps.flat_map(|map| map.cells.iter().filter_map(&value));
    values.map(f64::abs).fold(f64::MIN_POSITIVE, f64::max)
}
