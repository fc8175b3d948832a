//! Sizes shared by everything that is drawn, in px (1 px = 0.75 pt).

use crate::color::Color;

/// Tick labels, legends and notes: 9 pt.
pub(crate) const SMALL: f64 = 12.0;
/// Axis labels: 9.75 pt.
pub(crate) const NORMAL: f64 = 13.0;
/// Panel titles, bold: 10 pt.
pub(crate) const TITLE: f64 = 13.4;
/// Distance between baselines.
pub(crate) const LEADING: f64 = 17.0;
/// Length of a tick mark.
pub(crate) const TICK: f64 = 4.0;
/// Width of a color bar.
pub(crate) const BAR: f64 = 13.0;
pub(crate) const FRAME: Color = Color::rgb(70, 70, 70);
pub(crate) const GRID: Color = Color::rgb(233, 233, 233);
