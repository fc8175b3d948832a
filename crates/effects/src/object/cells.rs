//! The cells of a grid over an outline.

use nalgebra::Vector2;
use planar::Shape;

use crate::object::spots::Spot;

/// Rows and columns of the grid.
pub(crate) const SIDE: usize = 5;
/// Places on each side of a cell that are held against the outline.
const PLACES: usize = 12;

/// The cells of a grid over the outline's bounding box, along the axes of its frame: first row at the
/// smallest y, first column at the smallest x. Each is as large as what of it is within the outline,
/// and as a spot bears that share of the area; one without any bears none.
pub(crate) fn cells(shape: &Shape) -> Vec<Spot> {
    let outline = shape.outline(720);
    let corner = |pick: fn(f64, f64) -> f64, start: f64| {
        outline.iter().fold(Vector2::repeat(start), |end: Vector2<f64>, place| {
            Vector2::new(pick(end.x, place.x), pick(end.y, place.y))
        })
    };
    let (low, high) = (corner(f64::min, f64::INFINITY), corner(f64::max, f64::NEG_INFINITY));
    let size = (high - low) / SIDE as f64;
    let within = |row: usize, column: usize| {
        let from = low + size.component_mul(&Vector2::new(column as f64, row as f64));
        let share = |k: usize| (k as f64 + 0.5) / PLACES as f64;
        let place = move |k: usize| {
            from + size.component_mul(&Vector2::new(share(k % PLACES), share(k / PLACES)))
        };
        (0..PLACES * PLACES).map(place).filter(|place| shape.contains(place)).collect::<Vec<_>>()
    };
    let places: Vec<Vec<Vector2<f64>>> =
        (0..SIDE * SIDE).map(|k| within(k / SIDE, k % SIDE)).collect();
    let all: usize = places.iter().map(Vec::len).sum();
    places.iter().map(|places| cell(places, all as f64)).collect()
}

/// Equal places of which there are `all` on the whole area.
fn cell(places: &[Vector2<f64>], all: f64) -> Spot {
    let n = places.len() as f64;
    if places.is_empty() {
        return Spot { place_o: Vector2::zeros(), share: 0.0, radius: f64::MIN_POSITIVE };
    }
    let place_o = places.iter().sum::<Vector2<f64>>() / n;
    let square = places.iter().map(|place| (place - place_o).norm_squared()).sum::<f64>() / n;
    // Of one place alone: its own small square is that far from its middle.
    let least = 1e-6;
    Spot { place_o, share: n / all, radius: square.sqrt().max(least) }
}

#[cfg(test)]
mod tests {
    use super::{SIDE, cells};
    use nalgebra::Vector2;
    use planar::{MIT_NAMES, mit_object};

    #[test]
    fn the_cells_bear_the_area_about_its_centroid() {
        for name in MIT_NAMES {
            let shape = mit_object(name).unwrap().shape;
            let cells = cells(&shape);
            assert_eq!(cells.len(), SIDE * SIDE);
            let total: f64 = cells.iter().map(|cell| cell.share).sum();
            let center: Vector2<f64> = cells.iter().map(|cell| cell.share * cell.place_o).sum();
            assert!((total - 1.0).abs() < 1e-12, "{name}");
            let off = (center - shape.centroid()).norm();
            assert!(off < 8e-3 * shape.bounding_radius(), "{name} {off}");
            let bearing = || cells.iter().filter(|cell| cell.share > 0.0);
            assert!(bearing().count() >= SIDE * SIDE / 2, "{name}");
            // Convex in each cell, up to a corner: the middle of what is within is within.
            let inside = bearing().filter(|cell| shape.contains(&cell.place_o)).count();
            assert!(inside + 2 >= bearing().count(), "{name}");
        }
    }
}
