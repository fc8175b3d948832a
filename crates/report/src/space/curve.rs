//! Curves in space.

use super::view::View;
use super::{Body, Piece};
use crate::color::Color;
use crate::error::{ReportError, check_finite, check_positive, check_some};
use crate::mark::{LegendKey, Swatch, described};
use crate::scene::{Shape, Stroke};

/// A line through points in axis units.
#[derive(Debug, Clone)]
pub struct Curve {
    points: Vec<[f64; 3]>,
    stroke: Stroke,
    label: Option<String>,
}

impl Curve {
    /// A solid vermilion line, 2 px wide.
    pub fn new(points: &[[f64; 3]]) -> Self {
        let points = points.to_vec();
        Self { points, stroke: Stroke::new(Color::VERMILION, 2.0), label: None }
    }
}

builders!(Curve: stroke, dashed, label);

impl Body for Curve {
    fn name(&self) -> String {
        described("curve", self.label.as_ref())
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        check_some(&name, self.points.len())?;
        check_finite(&name, "points (x, y, z)", self.points.as_flattened())?;
        check_positive(&name, "width", self.stroke.width)
    }

    fn points(&self) -> Vec<[f64; 3]> {
        self.points.clone()
    }

    fn pieces(&self, view: &View) -> Vec<Piece> {
        let mut drawn = 0.0;
        let mut pieces = Vec::new();
        for ends in self.points.windows(2) {
            // A curve on a surface must win against the facets that it lies in.
            let depth = 0.5 * (view.depth(ends[0]) + view.depth(ends[1])) + 0.02;
            let line = [view.place(ends[0]), view.place(ends[1])];
            let length = (line[1][0] - line[0][0]).hypot(line[1][1] - line[0][1]);
            let rings = visible(line, length, drawn, self.stroke.dash);
            drawn += length;
            if !rings.is_empty() {
                let stroke = Some(Stroke { dash: None, ..self.stroke });
                let shapes = vec![Shape::Path { rings, closed: false, fill: None, stroke }];
                pieces.push(Piece { depth, shapes });
            }
        }
        pieces
    }

    fn legend(&self) -> Option<LegendKey> {
        LegendKey::new(self.label.as_ref(), Swatch::Line(self.stroke))
    }
}

/// The parts of a line of `length` px within dashes that run on along the curve, of which `drawn`
/// px lie before this line: as its pieces are drawn apart, none can know the dashes of the last.
fn visible(
    [from, to]: [[f64; 2]; 2],
    length: f64,
    drawn: f64,
    dash: Option<[f64; 2]>,
) -> Vec<Vec<[f64; 2]>> {
    let Some([on, off]) = dash else { return vec![vec![from, to]] };
    if length == 0.0 {
        return Vec::new();
    }
    let at = |s: f64| [0, 1].map(|i| from[i] + (to[i] - from[i]) * s / length);
    let first = (drawn / (on + off)).floor() as u64;
    (first..)
        .map(|k| k as f64 * (on + off) - drawn)
        .take_while(|start| *start < length)
        .map(|start| [start.max(0.0), (start + on).min(length)])
        .filter(|[start, end]| start < end)
        .map(|[start, end]| vec![at(start), at(end)])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::visible;

    #[test]
    fn dashes_run_on_from_one_line_to_the_next() {
        let dash = Some([3.0, 2.0]);
        let whole = visible([[0.0, 0.0], [20.0, 0.0]], 20.0, 0.0, dash);
        let mut parts = Vec::new();
        for k in 0..40 {
            let (start, end) = (0.5 * f64::from(k), 0.5 * f64::from(k + 1));
            parts.extend(visible([[start, 0.0], [end, 0.0]], 0.5, start, dash));
        }
        let length = |lines: &[Vec<[f64; 2]>]| lines.iter().map(|l| l[1][0] - l[0][0]).sum::<f64>();
        assert_eq!(whole.len(), 4);
        assert!((length(&whole) - 12.0).abs() < 1e-12 && (length(&parts) - 12.0).abs() < 1e-12);
        assert!(parts.iter().all(|line| line[1][0] % 5.0 <= 3.0 + 1e-12));
    }
}
