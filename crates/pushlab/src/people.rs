//! SI units as people like to read them.

/// A number of SI units per unit for people, and that unit.
pub(crate) fn people(unit: &str) -> (f64, &str) {
    match unit {
        "m" => (1e3, "mm"),
        "rad" => (1.0_f64.to_degrees(), "°"),
        "s" => (1e3, "ms"),
        "m/N" => (1e6, "µm/N"),
        "1" => (1.0, ""),
        other => (1.0, other),
    }
}
