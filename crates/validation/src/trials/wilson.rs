//! Wilson's interval of a share.

/// A share with its 95 % interval by Wilson.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Share {
    pub(super) hits: usize,
    pub(super) of: usize,
}

const Z: f64 = 1.959_963_984_540_054;

impl Share {
    pub(super) fn of(items: impl IntoIterator<Item = bool>) -> Self {
        let mut share = Self { hits: 0, of: 0 };
        for item in items {
            share.hits += usize::from(item);
            share.of += 1;
        }
        share
    }

    /// The share itself; none of nothing.
    pub(super) fn value(&self) -> Option<f64> {
        (self.of > 0).then(|| self.hits as f64 / self.of as f64)
    }

    pub(super) fn interval(&self) -> [f64; 2] {
        let n = self.of.max(1) as f64;
        let share = self.hits as f64 / n;
        let (middle, weight) = (share + 0.5 * Z * Z / n, 1.0 + Z * Z / n);
        let half = Z * (share * (1.0 - share) / n + 0.25 * Z * Z / (n * n)).sqrt();
        // Where all or none are hits its end is exact, which rounding would miss.
        let low = if self.hits == 0 { 0.0 } else { (middle - half) / weight };
        let high = if self.hits >= self.of { 1.0 } else { (middle + half) / weight };
        [low, high]
    }

    /// As `93 % (86 to 97, n = 96)`.
    pub(super) fn text(&self) -> String {
        let Some(value) = self.value() else { return "not run".to_owned() };
        let [low, high] = self.interval().map(|end| 100.0 * end);
        format!("{:.0} % ({low:.0} to {high:.0}, n = {})", 100.0 * value, self.of)
    }
}

#[cfg(test)]
mod tests {
    use super::Share;

    #[test]
    fn the_interval_is_that_of_the_textbook() {
        // Agresti & Coull (1998), The American Statistician 52(2): 0 of 10 gives (0, 0.278).
        let [low, high] = Share { hits: 0, of: 10 }.interval();
        assert!(low == 0.0 && (high - 0.2775).abs() < 1e-3, "{low} {high}");
        assert!((1..200).all(|of| Share { hits: of, of }.interval()[1] == 1.0));
        assert_eq!(Share::of([]).text(), "not run");
    }
}
