//! Scene → pixels → PNG.

use tiny_skia::{
    Color as SkiaColor, FillRule, FilterQuality, IntSize, LineCap, LineJoin, Mask, Paint,
    PathBuilder, Pixmap, PixmapPaint, Stroke as SkiaStroke, StrokeDash, Transform,
};

use crate::error::ReportError;
use crate::font::{text_outline, text_width};
use crate::scene::{Anchor, Image, Ink, Rect, Scene, Shape, Stroke, Text};

/// The scene on white as PNG bytes, `scale` pixels a px.
pub(crate) fn to_png(scene: &Scene, scale: f64) -> Result<Vec<u8>, ReportError> {
    let whole = Rect { x: 0.0, y: 0.0, width: scene.width, height: scene.height };
    let mut canvas = Canvas::new(&whole, scale)?;
    canvas.pixels.fill(SkiaColor::WHITE);
    canvas.draw(&scene.shapes)?;
    canvas.pixels.encode_png().map_err(|error| ReportError::Encode(error.to_string()))
}

/// The part of `shapes` inside `rect` on a transparent ground, as an image for the scene.
pub(crate) fn flatten(shapes: &[Shape], rect: Rect, scale: f64) -> Result<Image, ReportError> {
    let mut canvas = Canvas::new(&rect, scale)?;
    canvas.draw(shapes)?;
    let (columns, rows) = (canvas.pixels.width() as usize, canvas.pixels.height() as usize);
    let rgba = canvas.pixels.take_demultiplied();
    let rect = Rect { width: columns as f64 / scale, height: rows as f64 / scale, ..rect };
    Ok(Image { rect, columns, rows, rgba, pixelated: false })
}

/// Raw pixels, not premultiplied, as PNG bytes.
pub(crate) fn encode_png(columns: usize, rows: usize, rgba: &[u8]) -> Result<Vec<u8>, ReportError> {
    pixmap(columns, rows, rgba)?
        .encode_png()
        .map_err(|error| ReportError::Encode(error.to_string()))
}

fn pixmap(columns: usize, rows: usize, rgba: &[u8]) -> Result<Pixmap, ReportError> {
    let refuse = || ReportError::Encode(format!("{columns} × {rows} pixels do not fit a picture"));
    let size = |n: usize| u32::try_from(n).map_err(|_| refuse());
    let size = IntSize::from_wh(size(columns)?, size(rows)?).ok_or_else(refuse)?;
    let premultiplied = rgba
        .as_chunks::<4>()
        .0
        .iter()
        .flat_map(|&[r, g, b, a]| {
            let pixel = tiny_skia::ColorU8::from_rgba(r, g, b, a).premultiply();
            [pixel.red(), pixel.green(), pixel.blue(), pixel.alpha()]
        })
        .collect();
    Pixmap::from_vec(premultiplied, size).ok_or_else(refuse)
}

struct Canvas {
    pixels: Pixmap,
    view: Transform,
    clip: Option<Mask>,
}

impl Canvas {
    fn new(rect: &Rect, scale: f64) -> Result<Self, ReportError> {
        let (width, height) = ((rect.width * scale).ceil(), (rect.height * scale).ceil());
        let pixels = Pixmap::new(width as u32, height as u32).ok_or_else(|| {
            ReportError::Encode(format!("{width} × {height} pixels do not fit a picture"))
        })?;
        let view = Transform::from_scale(scale as f32, scale as f32)
            .pre_translate(-rect.x as f32, -rect.y as f32);
        Ok(Self { pixels, view, clip: None })
    }

    fn draw(&mut self, shapes: &[Shape]) -> Result<(), ReportError> {
        for shape in shapes {
            match shape {
                Shape::Path { rings, closed, fill, stroke } => {
                    self.path(rings, *closed, fill.as_ref(), stroke.as_ref());
                }
                Shape::Dots { centers, radius, ink } => self.dots(centers, *radius, ink),
                Shape::Text(text) => self.text(text),
                Shape::Image(image) => self.image(image)?,
                Shape::Spot { .. } => {}
                Shape::ClipStart(rect) => self.clip(rect),
                Shape::ClipEnd => self.clip = None,
            }
        }
        Ok(())
    }

    fn path(
        &mut self,
        rings: &[Vec<[f64; 2]>],
        closed: bool,
        fill: Option<&Ink>,
        stroke: Option<&Stroke>,
    ) {
        let mut builder = PathBuilder::new();
        for ring in rings {
            for (i, point) in ring.iter().enumerate() {
                let (x, y) = (point[0] as f32, point[1] as f32);
                if i == 0 { builder.move_to(x, y) } else { builder.line_to(x, y) }
            }
            if closed {
                builder.close();
            }
        }
        let Some(path) = builder.finish() else { return };
        let clip = self.clip.as_ref();
        if let Some(ink) = fill {
            self.pixels.fill_path(&path, &paint(ink), FillRule::Winding, self.view, clip);
        }
        if let Some(stroke) = stroke {
            let style = skia_stroke(stroke);
            self.pixels.stroke_path(&path, &paint(&stroke.ink), &style, self.view, clip);
        }
    }

    fn dots(&mut self, centers: &[[f64; 2]], radius: f64, ink: &Ink) {
        let paint = paint(ink);
        for center in centers {
            let (x, y) = (center[0] as f32, center[1] as f32);
            if let Some(disc) = PathBuilder::from_circle(x, y, radius as f32) {
                let clip = self.clip.as_ref();
                self.pixels.fill_path(&disc, &paint, FillRule::Winding, self.view, clip);
            }
        }
    }

    fn text(&mut self, text: &Text) {
        let Some(outline) = text_outline(&text.content, text.size, text.bold) else { return };
        let width = text_width(&text.content, text.size, text.bold) as f32;
        let shift = match text.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -0.5 * width,
            Anchor::End => -width,
        };
        let turn = if text.upward { -90.0 } else { 0.0 };
        let view = self
            .view
            .pre_translate(text.at[0] as f32, text.at[1] as f32)
            .pre_rotate(turn)
            .pre_translate(shift, 0.0);
        let clip = self.clip.as_ref();
        if text.halo {
            let white = Ink::from(crate::color::Color::WHITE);
            let style = skia_stroke(&Stroke::new(white, 3.0));
            self.pixels.stroke_path(&outline, &paint(&white), &style, view, clip);
        }
        let ink = Ink::from(text.color);
        self.pixels.fill_path(&outline, &paint(&ink), FillRule::Winding, view, clip);
    }

    fn image(&mut self, image: &Image) -> Result<(), ReportError> {
        let source = pixmap(image.columns, image.rows, &image.rgba)?;
        let scale_x = image.rect.width as f32 / image.columns as f32;
        let scale_y = image.rect.height as f32 / image.rows as f32;
        let view = self
            .view
            .pre_translate(image.rect.x as f32, image.rect.y as f32)
            .pre_scale(scale_x, scale_y);
        let quality =
            if image.pixelated { FilterQuality::Nearest } else { FilterQuality::Bilinear };
        let style = PixmapPaint { quality, ..PixmapPaint::default() };
        self.pixels.draw_pixmap(0, 0, source.as_ref(), &style, view, self.clip.as_ref());
        Ok(())
    }

    fn clip(&mut self, rect: &Rect) {
        let (width, height) = (self.pixels.width(), self.pixels.height());
        let area = tiny_skia::Rect::from_xywh(
            rect.x as f32,
            rect.y as f32,
            rect.width as f32,
            rect.height as f32,
        );
        self.clip = area.and_then(|area| {
            let mut mask = Mask::new(width, height)?;
            let path = PathBuilder::from_rect(area);
            mask.fill_path(&path, FillRule::Winding, true, self.view);
            Some(mask)
        });
    }
}

fn paint(ink: &Ink) -> Paint<'static> {
    let mut paint = Paint::default();
    let alpha = (255.0 * ink.opacity.clamp(0.0, 1.0)).round() as u8;
    paint.set_color_rgba8(ink.color.r, ink.color.g, ink.color.b, alpha);
    paint
}

fn skia_stroke(stroke: &Stroke) -> SkiaStroke {
    SkiaStroke {
        width: stroke.width as f32,
        line_join: LineJoin::Round,
        line_cap: LineCap::Butt,
        dash: stroke.dash.and_then(|dash| StrokeDash::new(dash.map(|v| v as f32).to_vec(), 0.0)),
        ..SkiaStroke::default()
    }
}
