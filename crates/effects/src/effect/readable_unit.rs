//! Units as people read them.

/// Standard gravity, in m/s².
const GRAVITY: f64 = 9.806_65;

/// How many of a unit for people are one of an SI unit, and that unit; an empty one for 1.
///
/// An acceleration along the table, as of a tilt, is told as the small angle at which gravity makes it.
pub fn readable_unit(si: &str) -> (f64, &str) {
    match si {
        "m" => (1e3, "mm"),
        "rad" => (1.0_f64.to_degrees(), "°"),
        "s" => (1e3, "ms"),
        "m/s" => (1e3, "mm/s"),
        "m/s²" => ((1.0 / GRAVITY).to_degrees(), "°"),
        "m/N" => (1e6, "µm/N"),
        "1" => (1.0, ""),
        other => (1.0, other),
    }
}

#[cfg(test)]
mod tests {
    use super::readable_unit;

    #[test]
    fn a_tilt_is_told_as_an_angle() {
        let (per, unit) = readable_unit("m/s²");
        let tilt = 9.806_65 * 2.2_f64.to_radians().sin();
        assert!((per * tilt - 2.2).abs() < 1e-3, "{}", per * tilt);
        assert_eq!(unit, "°");
        assert_eq!(readable_unit("N·m"), (1.0, "N·m"));
    }
}
