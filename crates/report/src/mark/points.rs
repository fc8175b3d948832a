//! A cloud of points, plain or colored by value.

use super::{Extent, LegendKey, Mark, Swatch, described, pairs};
use crate::canvas::Canvas;
use crate::color::{Color, ColorMap, ColorScale};
use crate::error::{ReportError, check_columns, check_finite, check_length, check_positive};
use crate::scene::{Ink, Stroke};

/// Discs at `(x[i], y[i])`.
#[derive(Debug, Clone)]
pub struct Points {
    x: Vec<f64>,
    y: Vec<f64>,
    radius: f64,
    hollow: bool,
    ink: Ink,
    values: Option<Values>,
    label: Option<String>,
}

#[derive(Debug, Clone)]
struct Values {
    values: Vec<f64>,
    map: ColorMap,
    range: Option<(f64, f64)>,
    bar: String,
}

impl Points {
    /// Blue discs of 3 px radius.
    pub fn new(x: &[f64], y: &[f64]) -> Self {
        Self {
            x: x.to_vec(),
            y: y.to_vec(),
            radius: 3.0,
            hollow: false,
            ink: Color::BLUE.into(),
            values: None,
            label: None,
        }
    }

    /// The same at positions given as pairs.
    pub fn at(points: &[[f64; 2]]) -> Self {
        let (x, y): (Vec<_>, Vec<_>) = points.iter().map(|[x, y]| (*x, *y)).unzip();
        Self::new(&x, &y)
    }

    /// Discs of this radius, in px.
    #[must_use]
    pub fn radius(mut self, radius: f64) -> Self {
        self.radius = radius;
        self
    }

    /// Rings instead of discs.
    #[must_use]
    pub fn hollow(mut self) -> Self {
        self.hollow = true;
        self
    }

    /// Colors each point by its value; the color bar shows `label`, which carries the unit.
    #[must_use]
    pub fn values(mut self, values: &[f64], map: ColorMap, label: &str) -> Self {
        let (values, bar) = (values.to_vec(), label.to_owned());
        self.values = Some(Values { values, map, range: None, bar });
        self
    }

    /// The values at the two ends of the color bar; call it after [`Points::values`].
    #[must_use]
    pub fn value_range(mut self, low: f64, high: f64) -> Self {
        if let Some(values) = &mut self.values {
            values.range = Some((low, high));
        }
        self
    }

    fn ring(&self) -> Stroke {
        Stroke::new(self.ink, 1.4)
    }

    /// One batch a color: 64 shades are more than the eye tells apart in a point.
    fn draw_values(&self, canvas: &mut Canvas<'_>, scale: &ColorScale, values: &[f64]) {
        const SHADES: usize = 64;
        let shade = |value: f64| {
            let t = (value - scale.low) / (scale.high - scale.low);
            (t.clamp(0.0, 1.0) * (SHADES - 1) as f64).round() as usize
        };
        let mut batches = vec![Vec::new(); SHADES];
        for (point, value) in pairs(&self.x, &self.y).zip(values) {
            batches[shade(*value)].push(point);
        }
        for (i, batch) in batches.into_iter().enumerate().filter(|(_, batch)| !batch.is_empty()) {
            let color = scale.map.at(i as f64 / (SHADES - 1) as f64);
            canvas.dots(batch, self.radius, Ink { color, ..self.ink });
        }
    }
}

builders!(Points: ink, label);

impl Mark for Points {
    fn name(&self) -> String {
        described("points", self.label.as_ref())
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        check_columns(&name, &[("x", &self.x), ("y", &self.y)])?;
        check_positive(&name, "radius", self.radius)?;
        check_positive(&name, "opacity", self.ink.opacity)?;
        if let Some(Values { values, range, .. }) = &self.values {
            check_length(&name, "values", self.x.len(), values.len())?;
            check_finite(&name, "values", values)?;
            if let Some((low, high)) = range {
                check_finite(&name, "value_range", &[*low, *high])?;
            }
        }
        Ok(())
    }

    fn extent(&self) -> Extent {
        Extent::of(pairs(&self.x, &self.y))
    }

    fn draw(&self, canvas: &mut Canvas<'_>) {
        if let (Some(scale), Some(values)) = (self.color_scale(), &self.values) {
            self.draw_values(canvas, &scale, &values.values);
        } else if self.hollow {
            for point in pairs(&self.x, &self.y) {
                canvas.ring(point, self.radius, self.ring());
            }
        } else {
            canvas.dots(pairs(&self.x, &self.y), self.radius, self.ink);
        }
    }

    fn legend(&self) -> Option<LegendKey> {
        let swatch = if self.hollow {
            Swatch::Ring(self.ring(), self.radius)
        } else {
            Swatch::Disc(
                Ink { opacity: self.ink.opacity.max(0.5), ..self.ink },
                self.radius.max(2.5),
            )
        };
        LegendKey::new(self.label.as_ref(), swatch)
    }

    fn color_scale(&self) -> Option<ColorScale> {
        let Values { values, map, range, bar } = self.values.as_ref()?;
        Some(ColorScale::fit(*map, *range, Some(bar.clone()), values.iter().copied()))
    }
}
