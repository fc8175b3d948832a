//! Drawing in data coordinates: what a mark sees of the panel.

use crate::axis::Scale;
use crate::color::Color;
use crate::font::text_width;
use crate::scene::{Anchor, Image, Ink, Rect, Scene, Shape, Stroke, Text};
use crate::style::SMALL;

/// The data area of a panel; every position is in the units of its axes.
#[derive(Debug)]
pub struct Canvas<'a> {
    pub(crate) scene: &'a mut Scene,
    pub(crate) x: Scale,
    pub(crate) y: Scale,
}

impl Canvas<'_> {
    /// Where a data point lies in the picture, in px from its top left.
    pub fn place(&self, point: [f64; 2]) -> [f64; 2] {
        // A bound far outside the picture keeps clipped shapes within the rasteriser's range.
        [self.x.place(point[0]), self.y.place(point[1])].map(|v| v.clamp(-1e5, 1e5))
    }

    /// The ranges shown of both axes.
    pub fn ranges(&self) -> [(f64, f64); 2] {
        [(self.x.low, self.x.high), (self.y.low, self.y.high)]
    }

    /// Draws an open line through the points.
    pub fn line(&mut self, points: impl IntoIterator<Item = [f64; 2]>, stroke: Stroke) {
        let points = points.into_iter().map(|point| self.place(point)).collect();
        self.scene.path(simplified(thinned(points)), false, None, Some(stroke));
    }

    /// Draws closed rings, filled by the non-zero rule, outlined, or both.
    pub fn area(&mut self, rings: &[Vec<[f64; 2]>], fill: Option<Ink>, stroke: Option<Stroke>) {
        let placed = |ring: &Vec<[f64; 2]>| ring.iter().map(|point| self.place(*point)).collect();
        let rings = rings.iter().map(placed).collect();
        self.scene.shapes.push(Shape::Path { rings, closed: true, fill, stroke });
    }

    /// Draws many separate lines alike.
    pub fn segments(&mut self, segments: &[[[f64; 2]; 2]], stroke: Stroke) {
        let placed = |ends: &[[f64; 2]; 2]| ends.iter().map(|end| self.place(*end)).collect();
        let rings = segments.iter().map(placed).collect();
        self.scene.shapes.push(Shape::Path {
            rings,
            closed: false,
            fill: None,
            stroke: Some(stroke),
        });
    }

    /// Draws a short level line, `half` px to either side of a point.
    pub fn tick(&mut self, at: [f64; 2], half: f64, stroke: Stroke) {
        let [x, y] = self.place(at);
        self.scene.line([x - half, y], [x + half, y], stroke);
    }

    /// Draws discs of a radius in px.
    pub fn dots(&mut self, centers: impl IntoIterator<Item = [f64; 2]>, radius: f64, ink: Ink) {
        let centers = centers.into_iter().map(|center| self.place(center)).collect();
        self.scene.shapes.push(Shape::Dots { centers, radius, ink });
    }

    /// Draws a ring of a radius in px.
    pub fn ring(&mut self, center: [f64; 2], radius: f64, stroke: Stroke) {
        let center = self.place(center);
        self.scene.path(circle(center, radius), true, None, Some(stroke));
    }

    /// Draws an arrow with a filled head of at most 8 px.
    pub fn arrow(&mut self, tail: [f64; 2], tip: [f64; 2], stroke: Stroke) {
        let (tail, tip) = (self.place(tail), self.place(tip));
        push_arrow(self.scene, tail, tip, stroke);
    }

    /// Lets a page show a text over the inside of a ring, which may be a cell of a map.
    pub fn spot(&mut self, ring: &[[f64; 2]], text: &str, cell: &[usize]) {
        let ring = ring.iter().map(|point| self.place(*point)).collect();
        self.scene.shapes.push(Shape::Spot { ring, text: text.to_owned(), cell: cell.to_vec() });
    }

    /// The same over a disc of a radius in px.
    pub fn round_spot(&mut self, center: [f64; 2], radius: f64, text: &str) {
        let ring = circle(self.place(center), radius);
        self.scene.shapes.push(Shape::Spot { ring, text: text.to_owned(), cell: Vec::new() });
    }

    /// Writes text shifted by `offset` (right, up) in px, on a white halo; it is moved so that it
    /// stays inside the panel, and left out if its point lies outside.
    pub fn text(
        &mut self,
        at: [f64; 2],
        offset: [f64; 2],
        anchor: Anchor,
        content: &str,
        color: Color,
    ) {
        let [x, y] = self.place(at);
        let inside = |scale: &Scale, v: f64| (v - scale.start) * (v - scale.end) <= 0.0;
        if !inside(&self.x, x) || !inside(&self.y, y) {
            return;
        }
        let width = text_width(content, SMALL, false);
        let before = match anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => 0.5 * width,
            Anchor::End => width,
        };
        let (left, right) = (self.x.start + before + 3.0, self.x.end - (width - before) - 3.0);
        let (top, bottom) = (self.y.end + SMALL, self.y.start - 4.0);
        let at = [(x + offset[0]).min(right).max(left), (y - offset[1]).min(bottom).max(top)];
        let text = Text::new(at, content, SMALL);
        self.scene.text(Text { anchor, color, halo: true, ..text });
    }

    /// Draws pixels (rows from the top, four bytes each) between two corners.
    pub(crate) fn image(&mut self, low: [f64; 2], high: [f64; 2], size: [usize; 2], rgba: Vec<u8>) {
        let ([left, bottom], [right, top]) = (self.place(low), self.place(high));
        let rect = Rect { x: left, y: top, width: right - left, height: bottom - top };
        let [columns, rows] = size;
        self.scene.shapes.push(Shape::Image(Image { rect, columns, rows, rgba, pixelated: true }));
    }
}

/// The corners of a 20-gon, which passes for a circle at the size of a symbol.
pub(crate) fn circle(center: [f64; 2], radius: f64) -> Vec<[f64; 2]> {
    let corner = |i: i32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 20.0).sin_cos();
        [center[0] + radius * cos, center[1] + radius * sin]
    };
    (0..20).map(corner).collect()
}

/// An arrow between two points in px; nothing if they coincide.
pub(crate) fn push_arrow(scene: &mut Scene, tail: [f64; 2], tip: [f64; 2], stroke: Stroke) {
    let (dx, dy) = (tip[0] - tail[0], tip[1] - tail[1]);
    let length = dx.hypot(dy);
    if length < 0.05 {
        return;
    }
    let (ux, uy) = (dx / length, dy / length);
    let head = (4.0 + 2.0 * stroke.width).min(8.0).min(0.6 * length);
    let neck = [tip[0] - head * ux, tip[1] - head * uy];
    let half = 0.4 * head;
    scene.line(tail, [tip[0] - 0.8 * head * ux, tip[1] - 0.8 * head * uy], stroke);
    let barb = |side: f64| [neck[0] - side * half * uy, neck[1] + side * half * ux];
    scene.path(vec![tip, barb(1.0), barb(-1.0)], true, Some(stroke.ink), None);
}

/// Of a line that runs in +x only the first, lowest, highest and last point in each half px,
/// which cover the same pixels; any other line as it is.
fn thinned(points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    if points.windows(2).any(|pair| pair[1][0] < pair[0][0]) {
        return points;
    }
    let column = |point: &[f64; 2]| (2.0 * point[0]).floor();
    let mut kept = Vec::new();
    for group in points.chunk_by(|a, b| column(a) == column(b)) {
        let by_height = |a: &usize, b: &usize| group[*a][1].total_cmp(&group[*b][1]);
        let ends = [0, group.len() - 1];
        let extremes = [(0..group.len()).min_by(by_height), (0..group.len()).max_by(by_height)];
        let mut chosen: Vec<usize> =
            ends.into_iter().chain(extremes.into_iter().flatten()).collect();
        chosen.sort_unstable();
        chosen.dedup();
        kept.extend(chosen.into_iter().map(|i| group[i]));
    }
    kept
}

/// The line without the points that move it by less than 0.05 px (Douglas–Peucker).
fn simplified(points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    if points.len() < 3 {
        return points;
    }
    let mut kept = vec![false; points.len()];
    kept[0] = true;
    kept[points.len() - 1] = true;
    let mut open = vec![(0, points.len() - 1)];
    while let Some((first, last)) = open.pop() {
        let farthest = (first + 1..last)
            .map(|i| (i, distance_to_segment(points[i], points[first], points[last])))
            .fold((first, 0.05), |best, next| if next.1 > best.1 { next } else { best });
        if farthest.0 != first {
            kept[farthest.0] = true;
            open.push((first, farthest.0));
            open.push((farthest.0, last));
        }
    }
    points.into_iter().zip(kept).filter_map(|(point, kept)| kept.then_some(point)).collect()
}

fn distance_to_segment(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let (px, py) = (p[0] - a[0], p[1] - a[1]);
    let square = dx * dx + dy * dy;
    let t = if square > 0.0 { ((px * dx + py * dy) / square).clamp(0.0, 1.0) } else { 0.0 };
    (px - t * dx).hypot(py - t * dy)
}

#[cfg(test)]
mod tests {
    use super::{distance_to_segment, simplified, thinned};

    #[test]
    fn thinned_line_keeps_every_peak_and_its_ends() {
        let noisy: Vec<[f64; 2]> = (0..50_000)
            .map(|i| [f64::from(i) * 0.01, (f64::from(i) * 12.9898).sin() * 90.0])
            .collect();
        let thin = thinned(noisy.clone());
        assert!(thin.len() <= 4 * 1001, "{}", thin.len());
        assert_eq!((thin.first(), thin.last()), (noisy.first(), noisy.last()));
        let peak = |line: &[[f64; 2]]| line.iter().map(|p| p[1]).fold(f64::MIN, f64::max);
        for low in [0.0, 123.5, 400.0] {
            let part = |line: &[[f64; 2]]| -> Vec<[f64; 2]> {
                line.iter().filter(|p| (low..low + 0.5).contains(&p[0])).copied().collect()
            };
            assert_eq!(peak(&part(&thin)), peak(&part(&noisy)));
        }
        let back = vec![[1.0, 0.0], [0.9, 5.0], [1.0, 1.0]];
        assert_eq!(thinned(back.clone()), back);
    }

    #[test]
    fn simplified_line_stays_within_its_tolerance_with_far_fewer_points() {
        let sine: Vec<[f64; 2]> = (0..20_000)
            .map(|i| f64::from(i) * 0.02)
            .map(|x| [x, 80.0 * (0.05 * x).sin()])
            .collect();
        let short = simplified(sine.clone());
        assert!(short.len() < 300, "{}", short.len());
        for point in sine {
            let distance = short
                .windows(2)
                .map(|ends| distance_to_segment(point, ends[0], ends[1]))
                .fold(f64::INFINITY, f64::min);
            assert!(distance <= 0.05 + 1e-9);
        }
    }
}
