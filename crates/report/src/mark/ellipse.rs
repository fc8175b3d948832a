//! Circles and ellipses in axis units.

use super::{Extent, LegendKey, Mark, Swatch, described};
use crate::canvas::Canvas;
use crate::color::Color;
use crate::error::{ReportError, check_finite, check_positive};
use crate::scene::{Ink, Stroke};

/// An ellipse in axis units, given by its center, semi-axes and turn.
#[derive(Debug, Clone)]
pub struct Ellipse {
    center: [f64; 2],
    semi_axes: [f64; 2],
    angle: f64,
    stroke: Stroke,
    fill: Option<Ink>,
    label: Option<String>,
}

impl Ellipse {
    /// A dark outline; the first semi-axis is turned by `angle` in rad from the x axis.
    pub fn new(center: [f64; 2], semi_axes: [f64; 2], angle: f64) -> Self {
        Self {
            center,
            semi_axes,
            angle,
            stroke: Stroke::new(Color::INK, 1.4),
            fill: None,
            label: None,
        }
    }

    /// A circle.
    pub fn circle(center: [f64; 2], radius: f64) -> Self {
        Self::new(center, [radius; 2], 0.0)
    }

    /// The ellipse at `n_sd` standard deviations of a Gaussian with the covariance
    /// `[xx, xy, yy]`; a negative eigenvalue becomes a refused semi-axis.
    pub fn of_covariance(center: [f64; 2], [xx, xy, yy]: [f64; 3], n_sd: f64) -> Self {
        let (middle, half) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
        let semi = |variance: f64| n_sd * variance.abs().sqrt().copysign(variance);
        Self::new(
            center,
            [semi(middle + half), semi(middle - half)],
            0.5 * (2.0 * xy).atan2(xx - yy),
        )
    }

    fn outline(&self) -> Vec<[f64; 2]> {
        const CORNERS: i32 = 72;
        let (sin, cos) = self.angle.sin_cos();
        let at = |i| {
            let (v, u) = (std::f64::consts::TAU * f64::from(i) / f64::from(CORNERS)).sin_cos();
            let (u, v) = (self.semi_axes[0] * u, self.semi_axes[1] * v);
            [self.center[0] + cos * u - sin * v, self.center[1] + sin * u + cos * v]
        };
        (0..CORNERS).map(at).collect()
    }
}

builders!(Ellipse: stroke, dashed, fill, label);

impl Mark for Ellipse {
    fn name(&self) -> String {
        described("ellipse", self.label.as_ref())
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        check_finite(&name, "center", &self.center)?;
        check_finite(&name, "semi_axes", &self.semi_axes)?;
        check_finite(&name, "angle", &[self.angle])?;
        check_positive(&name, "semi_axes[0]", self.semi_axes[0])?;
        check_positive(&name, "semi_axes[1]", self.semi_axes[1])?;
        check_positive(&name, "width", self.stroke.width)
    }

    fn extent(&self) -> Extent {
        Extent::of(self.outline())
    }

    fn draw(&self, canvas: &mut Canvas<'_>) {
        canvas.area(&[self.outline()], self.fill, Some(self.stroke));
    }

    fn legend(&self) -> Option<LegendKey> {
        LegendKey::new(self.label.as_ref(), Swatch::Area(self.fill, Some(self.stroke)))
    }
}
