//! Scene → SVG text.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use crate::error::ReportError;
use crate::font::FAMILIES;
use crate::html::escape;
use crate::raster::encode_png;
use crate::scene::{Anchor, Image, Ink, Rect, Scene, Shape, Stroke, Text};

/// The scene as one SVG element on white, with a title for screen readers and without ids.
pub(crate) fn to_svg(scene: &Scene, title: &str) -> Result<String, ReportError> {
    let (width, height) = (number(scene.width, 10.0), number(scene.height, 10.0));
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"{FAMILIES}\" \
         stroke-linejoin=\"round\" role=\"img\">\n\
         <title>{}</title>\n<path d=\"M0 0h{width}v{height}H0z\" fill=\"#fff\"/>\n",
        escape(title)
    );
    for shape in &scene.shapes {
        match shape {
            Shape::Path { rings, closed, fill, stroke } => {
                push_path(&mut out, rings, *closed, fill.as_ref(), stroke.as_ref());
            }
            Shape::Dots { centers, radius, ink } => push_dots(&mut out, centers, *radius, ink),
            Shape::Text(text) => push_text(&mut out, text),
            Shape::Image(image) => push_image(&mut out, image)?,
            Shape::Spot { ring, text, cell } => push_spot(&mut out, ring, text, cell),
            Shape::ClipStart(rect) => push_clip(&mut out, rect),
            Shape::ClipEnd => out.push_str("</svg>\n"),
        }
    }
    out.push_str("</svg>\n");
    Ok(out)
}

/// A number with `1/grain` resolution and no trailing zeros.
fn number(value: f64, grain: f64) -> String {
    let rounded = (value * grain).round() / grain;
    format!("{}", if rounded == 0.0 { 0.0 } else { rounded })
}

fn fixed(value: f64) -> String {
    number(value, 100.0)
}

/// Path data relative in tenths of a px, rounded so that errors do not add up.
fn path_data(rings: &[Vec<[f64; 2]>], closed: bool) -> String {
    let mut data = String::new();
    let tenths = |v: f64| (v * 10.0).round() as i64;
    for ring in rings {
        let mut last: Option<[i64; 2]> = None;
        for point in ring {
            let now = [tenths(point[0]), tenths(point[1])];
            match last {
                None => push_pair(&mut data, 'M', now),
                Some(before) => push_pair(&mut data, 'l', [now[0] - before[0], now[1] - before[1]]),
            }
            last = Some(now);
        }
        if closed {
            data.push('z');
        }
    }
    data
}

fn push_pair(data: &mut String, command: char, tenths: [i64; 2]) {
    let value = |t: i64| {
        let text = number(t as f64 / 10.0, 10.0);
        match text.strip_prefix("-0.") {
            Some(rest) => format!("-.{rest}"),
            None => text.strip_prefix("0.").map(|rest| format!(".{rest}")).unwrap_or(text),
        }
    };
    let (x, y) = (value(tenths[0]), value(tenths[1]));
    let gap = if y.starts_with('-') { "" } else { " " };
    data.push(command);
    data.push_str(&x);
    data.push_str(gap);
    data.push_str(&y);
}

fn push_path(
    out: &mut String,
    rings: &[Vec<[f64; 2]>],
    closed: bool,
    fill: Option<&Ink>,
    stroke: Option<&Stroke>,
) {
    let _ = write!(out, "<path d=\"{}\"", path_data(rings, closed));
    push_paint(out, "fill", fill);
    if let Some(stroke) = stroke {
        push_paint(out, "stroke", Some(&stroke.ink));
        let _ = write!(out, " stroke-width=\"{}\"", fixed(stroke.width));
        if let Some([on, off]) = stroke.dash {
            let _ = write!(out, " stroke-dasharray=\"{} {}\"", fixed(on), fixed(off));
        }
    }
    out.push_str("/>\n");
}

fn push_paint(out: &mut String, what: &str, ink: Option<&Ink>) {
    let Some(ink) = ink else {
        let _ = write!(out, " {what}=\"none\"");
        return;
    };
    let _ = write!(out, " {what}=\"{}\"", ink.color.hex());
    if ink.opacity < 1.0 {
        let _ = write!(out, " {what}-opacity=\"{}\"", fixed(ink.opacity));
    }
}

/// Discs as zero-length strokes with round caps: half the bytes of circle elements.
fn push_dots(out: &mut String, centers: &[[f64; 2]], radius: f64, ink: &Ink) {
    let mut data = String::new();
    if ink.opacity < 1.0 {
        // Within one path overlaps would not darken, so that density would be lost.
        for center in centers {
            let _ = write!(
                out,
                "<circle cx=\"{}\" cy=\"{}\" r=\"{}\"",
                number(center[0], 10.0),
                number(center[1], 10.0),
                fixed(radius)
            );
            push_paint(out, "fill", Some(ink));
            out.push_str("/>\n");
        }
        return;
    }
    for center in centers {
        push_pair(&mut data, 'M', [center[0], center[1]].map(|v| (v * 10.0).round() as i64));
        data.push_str("h0");
    }
    let _ = write!(out, "<path d=\"{data}\" stroke-linecap=\"round\" fill=\"none\"");
    push_paint(out, "stroke", Some(ink));
    let _ = writeln!(out, " stroke-width=\"{}\"/>", fixed(2.0 * radius));
}

fn push_text(out: &mut String, text: &Text) {
    let [x, y] = text.at.map(|v| number(v, 10.0));
    out.push_str("<text");
    if text.upward {
        let _ = write!(out, " transform=\"translate({x} {y})rotate(-90)\"");
    } else {
        let _ = write!(out, " x=\"{x}\" y=\"{y}\"");
    }
    let _ = write!(out, " font-size=\"{}\" fill=\"{}\"", fixed(text.size), text.color.hex());
    match text.anchor {
        Anchor::Start => {}
        Anchor::Middle => out.push_str(" text-anchor=\"middle\""),
        Anchor::End => out.push_str(" text-anchor=\"end\""),
    }
    if text.bold {
        out.push_str(" font-weight=\"bold\"");
    }
    if text.halo {
        out.push_str(" stroke=\"#fff\" stroke-width=\"3\" paint-order=\"stroke\"");
    }
    let _ = writeln!(out, ">{}</text>", escape(&text.content));
}

fn push_image(out: &mut String, image: &Image) -> Result<(), ReportError> {
    let png = encode_png(image.columns, image.rows, &image.rgba)?;
    let Rect { x, y, width, height } = image.rect;
    let crisp = if image.pixelated { " style=\"image-rendering:pixelated\"" } else { "" };
    let _ = writeln!(
        out,
        "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\"{crisp} \
         href=\"data:image/png;base64,{}\"/>",
        fixed(x),
        fixed(y),
        fixed(width),
        fixed(height),
        STANDARD.encode(png)
    );
    Ok(())
}

/// The text is a title, which browsers show by themselves.
fn push_spot(out: &mut String, ring: &[[f64; 2]], text: &str, cell: &[usize]) {
    let data = path_data(&[ring.to_vec()], true);
    let cell: Vec<String> = cell.iter().map(usize::to_string).collect();
    let cell = match cell[..] {
        [] => String::new(),
        _ => format!(" data-cell=\"{}\"", cell.join(".")),
    };
    let _ = writeln!(
        out,
        "<path class=\"spot\"{cell} d=\"{data}\" fill=\"none\" pointer-events=\"all\"><title>{}</title></path>",
        escape(text)
    );
}

/// A nested `svg` clips without needing an id, which must be unique on a whole page.
fn push_clip(out: &mut String, rect: &Rect) {
    let [x, y, width, height] =
        [rect.x, rect.y, rect.width, rect.height].map(|value| number(value, 10.0));
    let _ = writeln!(
        out,
        "<svg x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"{x} {y} {width} {height}\" overflow=\"hidden\">"
    );
}

#[cfg(test)]
mod tests {
    use super::{number, path_data};

    #[test]
    fn path_data_is_relative_short_and_does_not_drift() {
        let data = path_data(&[vec![[1.04, 2.0], [1.26, 1.5], [1.26, 2.5]]], true);
        assert_eq!(data, "M1 2l.3-.5l0 1z");
        let wave: Vec<[f64; 2]> = (0..1000).map(|i| [f64::from(i) * 0.14, 0.0]).collect();
        let drawn = path_data(&[wave], false);
        let end: f64 = drawn[1..]
            .split(['l', 'M'])
            .map(|pair| pair.split(' ').next().and_then(|x| x.parse::<f64>().ok()).unwrap_or(0.0))
            .sum();
        assert!((end - 139.86).abs() < 0.06, "{end}");
    }

    #[test]
    fn numbers_are_short_and_never_minus_zero() {
        assert_eq!(number(-0.001, 100.0), "0");
        assert_eq!(number(12.50, 100.0), "12.5");
    }
}
