//! The legend: where it fits and how it is drawn.

use crate::canvas::{circle, push_arrow};
use crate::color::Color;
use crate::font::text_width;
use crate::mark::{LegendKey, Swatch};
use crate::scene::{Anchor, Ink, Rect, Scene, Shape, Text};
use crate::style::{LEADING, SMALL};

/// Where a panel shows its legend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LegendPlace {
    /// Inside where it hides next to nothing, otherwise below.
    Auto,
    /// Inside, top left.
    TopLeft,
    /// Inside, top right.
    TopRight,
    /// Inside, bottom left.
    BottomLeft,
    /// Inside, bottom right.
    BottomRight,
    /// Right of the panel.
    Outside,
    /// Below the panel, in rows.
    Below,
    /// Nowhere.
    Hidden,
}

const SWATCH: f64 = 24.0;
const PADDING: f64 = 6.0;
const GAP: f64 = 18.0;

/// Width and height of the box around the keys.
pub(crate) fn legend_size(keys: &[LegendKey]) -> [f64; 2] {
    let widest = keys.iter().map(|key| text_width(&key.label, SMALL, false)).fold(0.0, f64::max);
    [widest + SWATCH + 8.0 + 2.0 * PADDING, LEADING * keys.len() as f64 + 2.0 * PADDING - 3.0]
}

/// The legend's box inside `area`; `first` is where the marks' shapes start in the scene.
pub(crate) fn legend_box(
    scene: &Scene,
    first: usize,
    area: &Rect,
    keys: &[LegendKey],
    place: LegendPlace,
) -> Rect {
    let [width, height] = legend_size(keys);
    let (left, right) = (area.x + 5.0, area.right() - width - 5.0);
    let (top, bottom) = (area.y + 5.0, area.bottom() - height - 5.0);
    let at = |x, y| Rect { x, y, width, height };
    match place {
        LegendPlace::TopLeft => at(left, top),
        LegendPlace::TopRight => at(right, top),
        LegendPlace::BottomLeft => at(left, bottom),
        LegendPlace::BottomRight => at(right, bottom),
        LegendPlace::Outside => at(area.right() + 8.0, area.y),
        LegendPlace::Auto | LegendPlace::Below | LegendPlace::Hidden => {
            best_spot(scene, first, area, keys).1
        }
    }
}

/// Whether the best place inside the area hides too much, or is larger than the area.
pub(crate) fn is_crowded(scene: &Scene, first: usize, area: &Rect, keys: &[LegendKey]) -> bool {
    let [width, height] = legend_size(keys);
    let large = width > 0.7 * area.width || height > 0.6 * area.height;
    !keys.is_empty() && (large || best_spot(scene, first, area, keys).0 > 3)
}

/// The corner or edge where the legend hides the least, and how much that is.
fn best_spot(scene: &Scene, first: usize, area: &Rect, keys: &[LegendKey]) -> (usize, Rect) {
    let [width, height] = legend_size(keys);
    let (left, right) = (area.x + 5.0, area.right() - width - 5.0);
    let (top, bottom) = (area.y + 5.0, area.bottom() - height - 5.0);
    let center = 0.5 * (left + right);
    let mut best = (usize::MAX, Rect { x: right, y: top, width, height });
    for (x, y) in [
        (right, top),
        (left, top),
        (left, bottom),
        (right, bottom),
        (center, top),
        (center, bottom),
    ] {
        let spot = Rect { x, y, width, height };
        let hidden = count_inside(&scene.shapes[first..], &spot);
        if hidden < best.0 {
            best = (hidden, spot);
        }
    }
    best
}

/// The keys in rows of at most `width` px, each with its offset from the row's left end.
fn rows(keys: &[LegendKey], width: f64) -> Vec<(f64, Vec<(f64, &LegendKey)>)> {
    let mut rows: Vec<(f64, Vec<(f64, &LegendKey)>)> = Vec::new();
    for key in keys {
        let own = SWATCH + 8.0 + text_width(&key.label, SMALL, false);
        match rows.last_mut() {
            Some((used, row)) if *used + GAP + own <= width => {
                row.push((*used + GAP, key));
                *used += GAP + own;
            }
            _ => rows.push((own, vec![(0.0, key)])),
        }
    }
    rows
}

/// Height of a legend below a panel `width` px wide.
pub(crate) fn height_below(keys: &[LegendKey], width: f64) -> f64 {
    LEADING * rows(keys, width).len() as f64 + 6.0
}

/// Draws the keys in rows centered about `x` but ending at `right`, the first below `y`.
pub(crate) fn draw_below(
    scene: &mut Scene,
    [x, y]: [f64; 2],
    right: f64,
    keys: &[LegendKey],
    width: f64,
) {
    for (i, (used, row)) in rows(keys, width).into_iter().enumerate() {
        let middle = y + LEADING * (i as f64 + 0.5);
        let left = (x - 0.5 * used).min(right - used);
        for (offset, key) in row {
            draw_key(scene, key, [left + offset, middle]);
        }
    }
}

/// How many samples of the shapes, about 4 px apart on lines, lie in the box.
fn count_inside(shapes: &[Shape], spot: &Rect) -> usize {
    let inside = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        points.filter(|point| spot.contains(*point)).count()
    };
    let on_line = |ends: &[[f64; 2]]| {
        let [a, b] = [ends[0], ends[ends.len() - 1]];
        let n = (((b[0] - a[0]).hypot(b[1] - a[1]) / 4.0).ceil() as usize).clamp(1, 2000);
        let along = move |i| {
            let t = i as f64 / n as f64;
            [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
        };
        inside(&mut (0..=n).map(along))
    };
    let count = |shape: &Shape| match shape {
        Shape::Path { rings, .. } => {
            rings.iter().flat_map(|ring| ring.windows(2)).map(on_line).sum()
        }
        Shape::Dots { centers, .. } => inside(&mut centers.iter().copied()),
        Shape::Text(text) => {
            let half = 0.5 * text_width(&text.content, text.size, text.bold);
            let middle = match text.anchor {
                Anchor::Start => text.at[0] + half,
                Anchor::Middle => text.at[0],
                Anchor::End => text.at[0] - half,
            };
            8 * on_line(&[[middle - half, text.at[1] - 4.0], [middle + half, text.at[1] - 4.0]])
        }
        _ => 0,
    };
    shapes.iter().map(count).sum()
}

pub(crate) fn draw_legend(scene: &mut Scene, spot: &Rect, keys: &[LegendKey]) {
    scene.rect(spot, Some(Ink::new(Color::WHITE, 0.85)), None);
    for (i, key) in keys.iter().enumerate() {
        let y = spot.y + PADDING + LEADING * (i as f64 + 0.5) - 1.5;
        draw_key(scene, key, [spot.x + PADDING, y]);
    }
}

fn draw_key(scene: &mut Scene, key: &LegendKey, [left, y]: [f64; 2]) {
    draw_swatch(scene, &key.swatch, [left, y]);
    let text = Text::new([left + SWATCH + 8.0, y + 4.3], &key.label, SMALL);
    scene.text(Text { anchor: Anchor::Start, ..text });
}

fn draw_swatch(scene: &mut Scene, swatch: &Swatch, [left, y]: [f64; 2]) {
    let center = [left + 0.5 * SWATCH, y];
    match *swatch {
        Swatch::Line(stroke) => scene.line([left, y], [left + SWATCH, y], stroke),
        Swatch::Disc(ink, radius) => {
            scene.shapes.push(Shape::Dots { centers: vec![center], radius, ink });
        }
        Swatch::Ring(stroke, radius) => {
            scene.path(circle(center, radius), true, None, Some(stroke));
        }
        Swatch::Area(fill, stroke) => {
            let area = Rect { x: left + 2.0, y: y - 5.0, width: SWATCH - 4.0, height: 10.0 };
            scene.rect(&area, fill, stroke);
        }
        Swatch::Arrow(stroke) => push_arrow(scene, [left, y], [left + SWATCH, y], stroke),
    }
}
