//! One axis of a panel and its map from data to px.

use crate::error::ReportError;
use crate::ticks::{Ticks, linear, logarithmic};

/// An axis: label with unit, and optionally a range, a logarithmic scale or named ticks.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    pub(crate) label: String,
    pub(crate) range: Option<(f64, f64)>,
    pub(crate) logarithmic: bool,
    pub(crate) names: Option<Vec<(f64, String)>>,
}

impl Axis {
    /// A linear axis that fits its data; the label carries the unit, e.g. `time in s`.
    pub fn new(label: &str) -> Self {
        Self { label: label.to_owned(), range: None, logarithmic: false, names: None }
    }

    /// Shows exactly the values from `low` to `high`.
    #[must_use]
    pub fn range(mut self, low: f64, high: f64) -> Self {
        self.range = Some((low, high));
        self
    }

    /// Uses a logarithmic scale; the data must be positive.
    #[must_use]
    pub fn log(mut self) -> Self {
        self.logarithmic = true;
        self
    }

    /// Labels these positions and no others, e.g. with the names of categories.
    #[must_use]
    pub fn names<N: AsRef<str>>(mut self, names: &[(f64, N)]) -> Self {
        self.names = Some(names.iter().map(|(at, name)| (*at, name.as_ref().to_owned())).collect());
        self
    }

    /// The range to show for data from `low` to `high`, with room left at the padded ends.
    pub(crate) fn resolve(
        &self,
        data: Option<(f64, f64)>,
        pad: [bool; 2],
    ) -> Result<(f64, f64), ReportError> {
        if let Some((low, high)) = self.range {
            let valid = low < high && low.is_finite() && high.is_finite();
            if !valid || (self.logarithmic && low <= 0.0) {
                return Err(ReportError::Range { axis: self.label.clone(), low, high });
            }
            return Ok((low, high));
        }
        let fallback = if self.logarithmic { (1.0, 10.0) } else { (0.0, 1.0) };
        let (low, high) = data.unwrap_or(fallback);
        let (low, high) = if self.logarithmic { (low.log10(), high.log10()) } else { (low, high) };
        let width = high - low;
        let (low, high) = if width > 1e-12 * low.abs().max(high.abs()) {
            let room = |padded: bool| if padded { 0.04 * width } else { 0.0 };
            (low - room(pad[0]), high + room(pad[1]))
        } else {
            let reach = if low == 0.0 || self.logarithmic { 0.5 } else { 0.1 * low.abs() };
            (low - reach, high + reach)
        };
        let (low, high) =
            if self.logarithmic { (10f64.powf(low), 10f64.powf(high)) } else { (low, high) };
        if low < high && (high - low).is_finite() && (low > 0.0 || !self.logarithmic) {
            return Ok((low, high));
        }
        Err(ReportError::Range { axis: self.label.clone(), low, high })
    }

    pub(crate) fn ticks(&self, range: (f64, f64), limit: f64) -> Ticks {
        if let Some(names) = &self.names {
            let inside = |at: f64| (range.0..=range.1).contains(&at);
            let major = names.iter().filter(|(at, _)| inside(*at)).cloned().collect();
            return Ticks { major, minor: Vec::new() };
        }
        let place = if self.logarithmic { logarithmic } else { linear };
        place(range.0, range.1, limit)
    }
}

impl From<&str> for Axis {
    fn from(label: &str) -> Self {
        Self::new(label)
    }
}

/// Data values from `low` to `high` laid out from `start` to `end`, in px.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scale {
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) logarithmic: bool,
    pub(crate) start: f64,
    pub(crate) end: f64,
}

impl Scale {
    pub(crate) fn place(&self, value: f64) -> f64 {
        let t = if self.logarithmic {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        };
        self.start + t * (self.end - self.start)
    }
}

#[cfg(test)]
mod tests {
    use super::{Axis, Scale};
    use crate::error::ReportError;

    #[test]
    fn range_is_padded_unless_given() {
        let axis = Axis::new("force in N");
        assert_eq!(axis.resolve(Some((0.0, 100.0)), [false, true]).ok(), Some((0.0, 104.0)));
        let fixed = axis.clone().range(-1.0, 1.0);
        assert_eq!(fixed.resolve(Some((0.0, 100.0)), [true; 2]).ok(), Some((-1.0, 1.0)));
        assert_eq!(axis.resolve(Some((2.0, 2.0)), [true; 2]).ok(), Some((1.8, 2.2)));
    }

    #[test]
    fn a_bad_range_is_refused() {
        for axis in [
            Axis::new("x").range(1.0, 1.0),
            Axis::new("x").range(0.0, f64::NAN),
            Axis::new("x").range(0.0, 1.0).log(),
        ] {
            assert!(matches!(axis.resolve(None, [true; 2]), Err(ReportError::Range { .. })));
        }
    }

    #[test]
    fn data_whose_range_is_no_number_are_refused() {
        let axis = Axis::new("x");
        for (axis, low, high) in [
            (axis.clone(), -f64::MAX, f64::MAX),
            (axis.clone(), f64::MAX, f64::MAX),
            (axis.log(), 5e-324, f64::MAX),
        ] {
            let range = axis.resolve(Some((low, high)), [true; 2]);
            assert!(matches!(range, Err(ReportError::Range { .. })), "{low} {high}: {range:?}");
        }
    }

    #[test]
    fn a_decade_is_equally_long_anywhere() {
        let scale = Scale { low: 1.0, high: 100.0, logarithmic: true, start: 10.0, end: 210.0 };
        assert!((scale.place(10.0) - 110.0).abs() < 1e-9);
    }
}
