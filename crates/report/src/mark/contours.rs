//! Contour lines by marching squares.

use std::collections::BTreeMap;

use super::{Extent, LegendKey, Mark, Swatch, described};
use crate::canvas::Canvas;
use crate::color::Color;
use crate::error::{ReportError, check_finite, check_positive, check_some};
use crate::grid::Grid;
use crate::scene::{Anchor, Stroke};

/// Lines of equal value through the cell centers of a grid.
#[derive(Debug, Clone)]
pub struct Contours {
    grid: Grid,
    levels: Vec<f64>,
    numbered: bool,
    stroke: Stroke,
    label: Option<String>,
}

impl Contours {
    /// Thin dark lines at the levels.
    pub fn new(grid: Grid, levels: &[f64]) -> Self {
        Self {
            grid,
            levels: levels.to_vec(),
            numbered: false,
            stroke: Stroke::new(Color::INK, 1.0),
            label: None,
        }
    }

    /// Writes the level on its longest line.
    #[must_use]
    pub fn numbered(mut self) -> Self {
        self.numbered = true;
        self
    }
}

builders!(Contours: stroke, dashed, label);

impl Mark for Contours {
    fn name(&self) -> String {
        described("contours", self.label.as_ref())
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        self.grid.check(&name)?;
        check_some(&name, self.levels.len())?;
        check_finite(&name, "levels", &self.levels)?;
        check_positive(&name, "width", self.stroke.width)
    }

    fn extent(&self) -> Extent {
        Extent { x: Some(self.grid.x), y: Some(self.grid.y), pad: [false; 4] }
    }

    fn draw(&self, canvas: &mut Canvas<'_>) {
        let grid = self.grid.padded();
        let mut numbers: Vec<([f64; 2], String)> = Vec::new();
        for level in &self.levels {
            let lines = contour(&grid, *level);
            if let Some(longest) = lines.iter().max_by_key(|line| line.len()) {
                let text = format!("{level}").replace('-', "\u{2212}");
                numbers.push((longest[longest.len() / 2], text));
            }
            for line in lines {
                canvas.line(line, self.stroke);
            }
        }
        for (at, text) in numbers.iter().filter(|_| self.numbered) {
            canvas.text(*at, [0.0, -4.0], Anchor::Middle, text, self.stroke.ink.color);
        }
    }

    fn legend(&self) -> Option<LegendKey> {
        LegendKey::new(self.label.as_ref(), Swatch::Line(self.stroke))
    }

    fn needs_linear_axes(&self) -> bool {
        true
    }
}

/// An edge between two neighboring centers, by the lower of the two cells and its direction.
type Edge = (usize, bool);

/// The lines at a level, each through neighboring crossings; closed ones repeat their start.
fn contour(grid: &Grid, level: f64) -> Vec<Vec<[f64; 2]>> {
    let mut links: BTreeMap<Edge, Vec<Edge>> = BTreeMap::new();
    for row in 0..grid.rows.saturating_sub(1) {
        for column in 0..grid.columns.saturating_sub(1) {
            for (a, b) in square(grid, level, row * grid.columns + column) {
                links.entry(a).or_default().push(b);
                links.entry(b).or_default().push(a);
            }
        }
    }
    let ends: Vec<Edge> = links.iter().filter(|(_, to)| to.len() == 1).map(|(e, _)| *e).collect();
    let inner: Vec<Edge> = links.keys().copied().collect();
    let mut lines = Vec::new();
    for start in ends.into_iter().chain(inner) {
        let line = walk(&mut links, start);
        if line.len() > 1 {
            lines.push(line.into_iter().map(|edge| crossing(grid, level, edge)).collect());
        }
    }
    lines
}

/// Follows links from an edge, using each once.
fn walk(links: &mut BTreeMap<Edge, Vec<Edge>>, start: Edge) -> Vec<Edge> {
    let mut line = vec![start];
    let mut here = start;
    while let Some(next) = links.get_mut(&here).and_then(Vec::pop) {
        if let Some(back) = links.get_mut(&next)
            && let Some(i) = back.iter().position(|edge| *edge == here)
        {
            back.swap_remove(i);
        }
        line.push(next);
        here = next;
    }
    line
}

/// The one or two segments through the square above and right of a cell.
fn square(grid: &Grid, level: f64, cell: usize) -> Vec<(Edge, Edge)> {
    let corners = [cell, cell + 1, cell + grid.columns + 1, cell + grid.columns];
    if corners.iter().any(|corner| !grid.is_shown(*corner)) {
        return Vec::new();
    }
    let above = corners.map(|corner| grid.values[corner] > level);
    let edges: [Edge; 4] =
        [(cell, false), (cell + 1, true), (cell + grid.columns, false), (cell, true)];
    let crossed: Vec<usize> = (0..4).filter(|&i| above[i] != above[(i + 1) % 4]).collect();
    match crossed[..] {
        [a, b] => vec![(edges[a], edges[b])],
        [_, _, _, _] => {
            // A saddle: the mean decides which two corners belong together.
            let mean = corners.iter().map(|corner| grid.values[*corner]).sum::<f64>() / 4.0;
            if (mean > level) == above[0] {
                vec![(edges[0], edges[1]), (edges[2], edges[3])]
            } else {
                vec![(edges[3], edges[0]), (edges[1], edges[2])]
            }
        }
        _ => Vec::new(),
    }
}

fn crossing(grid: &Grid, level: f64, (cell, upward): Edge) -> [f64; 2] {
    let other = if upward { cell + grid.columns } else { cell + 1 };
    let (low, high) = (grid.values[cell], grid.values[other]);
    let t = (level - low) / (high - low);
    let (column, row) = ((cell % grid.columns) as f64, (cell / grid.columns) as f64);
    if upward { grid.center(column, row + t) } else { grid.center(column + t, row) }
}

#[cfg(test)]
mod tests {
    use super::contour;
    use crate::grid::Grid;

    #[test]
    fn a_cone_has_one_closed_circle() {
        let cone = Grid::sample((-1.0, 1.0), (-1.0, 1.0), 81, 81, |x, y| x.hypot(y));
        let lines = contour(&cone, 0.6);
        assert_eq!(lines.len(), 1);
        assert_eq!(lines[0].first(), lines[0].last());
        assert!(lines[0].iter().all(|[x, y]| (x.hypot(*y) - 0.6).abs() < 1e-3));
    }

    #[test]
    fn a_saddle_has_two_branches_that_do_not_cross() {
        let saddle = Grid::sample((-1.0, 1.0), (-1.0, 1.0), 40, 40, |x, y| x * y);
        for level in [-0.2, 0.2] {
            let lines = contour(&saddle, level);
            assert_eq!(lines.len(), 2);
            assert!(lines.iter().flatten().all(|[x, y]| (x * y - level).abs() < 2e-3));
        }
    }

    #[test]
    fn masked_cells_are_left_out() {
        let ramp = Grid::sample((0.0, 1.0), (0.0, 1.0), 10, 10, |x, _| x);
        let half = (0..100).map(|i| i >= 50).collect();
        let lines = contour(&ramp.mask(half), 0.33);
        assert!(lines.len() == 1 && lines[0].iter().all(|[_, y]| *y > 0.5));
    }
}
