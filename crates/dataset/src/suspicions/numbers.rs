//! Shares, and numbers as people read them.

/// The share of values that are so; none if there are fewer than ten.
pub(super) fn share(values: impl Iterator<Item = bool>) -> Option<f64> {
    const FEWEST: usize = 10;
    let (mut n, mut n_so) = (0, 0);
    for value in values {
        (n, n_so) = (n + 1, n_so + usize::from(value));
    }
    (n >= FEWEST).then(|| n_so as f64 / n as f64)
}

/// A length in the unit in which it is a number of ordinary size.
pub(super) fn length(meters: f64) -> String {
    match meters.abs() {
        size if size < 1e-4 => format!("{:.2} µm", 1e6 * meters),
        size if size < 1.0 => format!("{:.1} mm", 1e3 * meters),
        size if size < 1e3 => format!("{meters:.1} m"),
        _ => format!("{:.1} km", 1e-3 * meters),
    }
}

/// A speed likewise.
pub(super) fn speed(meters_per_second: f64) -> String {
    length(meters_per_second) + "/s"
}
