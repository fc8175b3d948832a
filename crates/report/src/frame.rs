//! Axes, grid, title and color bar around a panel's data area.

use crate::axis::{Axis, Scale};
use crate::color::ColorScale;
use crate::font::{text_width, wrap};
use crate::scene::{Anchor, Image, Rect, Scene, Shape, Stroke, Text};
use crate::style::{BAR, FRAME, GRID, LEADING, NORMAL, SMALL, TICK, TITLE};
use crate::ticks::{Ticks, linear};

/// Room in px around a data area.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Margins {
    pub(crate) left: f64,
    pub(crate) right: f64,
    pub(crate) top: f64,
    pub(crate) bottom: f64,
}

/// One axis with its range, ready to be drawn along `length` px.
#[derive(Debug)]
pub(crate) struct Ruler<'a> {
    pub(crate) axis: &'a Axis,
    pub(crate) range: (f64, f64),
}

impl Ruler<'_> {
    pub(crate) fn scale(&self, start: f64, end: f64) -> Scale {
        let (low, high) = self.range;
        Scale { low, high, logarithmic: self.axis.logarithmic, start, end }
    }

    /// As many ticks as fit side by side along a level axis.
    pub(crate) fn level_ticks(&self, length: f64) -> Ticks {
        let mut limit = (length / 55.0).clamp(2.0, 8.0);
        loop {
            let ticks = self.axis.ticks(self.range, limit);
            let n = ticks.major.len().max(2) as f64;
            let widest = widest(&ticks);
            let fits = (widest + 10.0) * n <= length + widest;
            if fits || limit <= 2.0 || self.axis.names.is_some() {
                return ticks;
            }
            limit -= 0.5;
        }
    }

    pub(crate) fn upright_ticks(&self, length: f64) -> Ticks {
        self.axis.ticks(self.range, (length / 32.0).clamp(2.0, 8.0))
    }

    /// The lines of each label of a level axis, and whether they are written upward.
    fn level_labels(&self, ticks: &Ticks, length: f64) -> (Vec<Vec<String>>, bool) {
        if self.axis.names.is_none() {
            return (ticks.major.iter().map(|(_, label)| vec![label.clone()]).collect(), false);
        }
        let room = length / ticks.major.len().max(1) as f64 - 6.0;
        let lines: Vec<Vec<String>> =
            ticks.major.iter().map(|(_, label)| wrap(label, SMALL, false, room)).collect();
        let upward = lines.iter().flatten().any(|line| text_width(line, SMALL, false) > room);
        if upward {
            return (ticks.major.iter().map(|(_, label)| vec![label.clone()]).collect(), true);
        }
        (lines, false)
    }

    /// Room below the data area for tick labels alone.
    fn label_depth(&self, ticks: &Ticks, length: f64) -> f64 {
        let (lines, upward) = self.level_labels(ticks, length);
        if upward {
            return widest(ticks) + 4.0;
        }
        let most = lines.iter().map(Vec::len).max().unwrap_or(0);
        14.0 + 14.0 * most.saturating_sub(1) as f64
    }
}

fn widest(ticks: &Ticks) -> f64 {
    ticks.major.iter().map(|(_, label)| text_width(label, SMALL, false)).fold(0.0, f64::max)
}

/// The room that axes and title need about a data area of roughly `size` px.
pub(crate) fn axis_margins(x: &Ruler<'_>, y: &Ruler<'_>, title: &str, size: [f64; 2]) -> Margins {
    let lines = |text: &str, length: f64| {
        LEADING * wrap(text, NORMAL, false, length.max(60.0)).len() as f64
    };
    let level = x.level_ticks(size[0]);
    // The final area differs a little from `size`, and with it possibly the ticks.
    let labels = [0.85, 1.0, 1.15].map(|share| widest(&y.upright_ticks(share * size[1])));
    let label = labels.into_iter().fold(0.0, f64::max);
    Margins {
        left: TICK + 4.0 + label + 6.0 + lines(&y.axis.label, 0.9 * size[1]),
        right: (0.5 * widest(&level)).clamp(8.0, 24.0) + 2.0,
        top: title_height(title, size[0]),
        bottom: TICK + x.label_depth(&level, size[0]) + 5.0 + lines(&x.axis.label, size[0]) + 3.0,
    }
}

pub(crate) fn title_height(title: &str, width: f64) -> f64 {
    let n = wrap(title, TITLE, true, width + 30.0).len();
    if n == 0 { 10.0 } else { LEADING * n as f64 + 10.0 }
}

pub(crate) fn draw_title(scene: &mut Scene, title: &str, area: &Rect, width: f64) {
    let lines = wrap(title, TITLE, true, width + 30.0);
    for (i, line) in lines.iter().rev().enumerate() {
        let at = [area.x, area.y - 9.0 - LEADING * i as f64];
        let text = Text::new(at, line, TITLE);
        scene.text(Text { anchor: Anchor::Start, bold: true, ..text });
    }
}

pub(crate) fn draw_grid(scene: &mut Scene, area: &Rect, x: &Ruler<'_>, y: &Ruler<'_>) {
    let stroke = Stroke::new(GRID, 1.0);
    let scale = x.scale(area.x, area.right());
    for (value, _) in x.level_ticks(area.width).major.iter().filter(|_| x.axis.names.is_none()) {
        let at = scale.place(*value);
        scene.line([at, area.y], [at, area.bottom()], stroke);
    }
    let scale = y.scale(area.bottom(), area.y);
    for (value, _) in y.upright_ticks(area.height).major {
        let at = scale.place(value);
        scene.line([area.x, at], [area.right(), at], stroke);
    }
}

pub(crate) fn draw_axes(scene: &mut Scene, area: &Rect, x: &Ruler<'_>, y: &Ruler<'_>) {
    let stroke = Stroke::new(FRAME, 1.0);
    scene.rect(area, None, Some(stroke));
    draw_level_axis(scene, area, x, stroke);
    let (ticks, scale) = (y.upright_ticks(area.height), y.scale(area.bottom(), area.y));
    for (value, label) in &ticks.major {
        let at = scale.place(*value);
        scene.line([area.x, at], [area.x - TICK, at], stroke);
        let text = Text::new([area.x - TICK - 4.0, at + 4.3], label, SMALL);
        scene.text(Text { anchor: Anchor::End, ..text });
    }
    for value in &ticks.minor {
        let at = scale.place(*value);
        scene.line([area.x, at], [area.x - 0.5 * TICK, at], stroke);
    }
    let lines = wrap(&y.axis.label, NORMAL, false, area.height.max(60.0));
    let left = area.x - TICK - 4.0 - widest(&ticks) - 9.0;
    for (i, line) in lines.iter().rev().enumerate() {
        let text = Text::new([left - LEADING * i as f64, area.center()[1]], line, NORMAL);
        scene.text(Text { upward: true, ..text });
    }
}

fn draw_level_axis(scene: &mut Scene, area: &Rect, x: &Ruler<'_>, stroke: Stroke) {
    let (ticks, scale) = (x.level_ticks(area.width), x.scale(area.x, area.right()));
    let (labels, upward) = x.level_labels(&ticks, area.width);
    let foot = area.bottom() + TICK;
    for ((value, _), lines) in ticks.major.iter().zip(labels) {
        let at = scale.place(*value);
        scene.line([at, area.bottom()], [at, foot], stroke);
        for (i, line) in lines.iter().enumerate() {
            let text = Text::new([at, foot + 13.0 + 14.0 * i as f64], line, SMALL);
            scene.text(if upward {
                Text { at: [at + 4.3, foot + 4.0], upward, anchor: Anchor::End, ..text }
            } else {
                text
            });
        }
    }
    for value in &ticks.minor {
        let at = scale.place(*value);
        scene.line([at, area.bottom()], [at, area.bottom() + 0.5 * TICK], stroke);
    }
    let first = foot + x.label_depth(&ticks, area.width) + 17.0;
    let lines = wrap(&x.axis.label, NORMAL, false, area.width.max(60.0));
    for (i, line) in lines.iter().enumerate() {
        scene.text(Text::new([area.center()[0], first + LEADING * i as f64], line, NORMAL));
    }
}

/// The room right of a data area for a color bar of about `height` px.
pub(crate) fn color_bar_width(scale: &ColorScale, height: f64) -> f64 {
    let labels = [0.85, 1.0, 1.15].map(|share| widest(&bar_ticks(scale, share * height)));
    let label = scale.label.as_deref().unwrap_or_default();
    let lines = wrap(label, NORMAL, false, (0.9 * height).max(60.0)).len() as f64;
    let widest = labels.into_iter().fold(0.0, f64::max);
    12.0 + BAR + TICK + 4.0 + widest + 4.0 + LEADING * lines
}

fn bar_ticks(scale: &ColorScale, height: f64) -> Ticks {
    linear(scale.low, scale.high, (height / 32.0).clamp(2.0, 8.0))
}

pub(crate) fn draw_color_bar(scene: &mut Scene, area: &Rect, scale: &ColorScale) {
    const SHADES: usize = 128;
    let bar = Rect { x: area.right() + 12.0, y: area.y, width: BAR, height: area.height };
    let rgba = (0..SHADES)
        .rev()
        .flat_map(|i| {
            let color = scale.map.at((i as f64 + 0.5) / SHADES as f64);
            [color.r, color.g, color.b, 255]
        })
        .collect();
    let image = Image { rect: bar, columns: 1, rows: SHADES, rgba, pixelated: true };
    scene.shapes.push(Shape::Image(image));
    let stroke = Stroke::new(FRAME, 1.0);
    scene.rect(&bar, None, Some(stroke));
    let ticks = bar_ticks(scale, area.height);
    for (value, label) in &ticks.major {
        let t = (value - scale.low) / (scale.high - scale.low);
        let y = bar.bottom() - t * bar.height;
        scene.line([bar.right(), y], [bar.right() + TICK, y], stroke);
        let text = Text::new([bar.right() + TICK + 4.0, y + 4.3], label, SMALL);
        scene.text(Text { anchor: Anchor::Start, ..text });
    }
    let label = scale.label.as_deref().unwrap_or_default();
    let left = bar.right() + TICK + 4.0 + widest(&ticks) + 4.0 + NORMAL;
    for (i, line) in wrap(label, NORMAL, false, area.height.max(60.0)).iter().enumerate() {
        let text = Text::new([left + LEADING * i as f64, area.center()[1]], line, NORMAL);
        scene.text(Text { upward: true, ..text });
    }
}
