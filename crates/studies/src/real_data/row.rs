//! A number beside the one to expect.

/// Largest relative difference from an expected number: the published ones were computed on a
/// larger draw of the same measurements.
const BAND: f64 = 0.15;

/// A measured number, with what is known about it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    pub name: String,
    pub measured: f64,
    pub reference: Reference,
}

/// What a measured number is held against.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Reference {
    /// It has to lie within the band about this.
    Expected(f64),
    /// It must not be larger.
    AtMost(f64),
    /// It has to be this.
    Exactly(f64),
    /// Published by others with another method: for the reader only.
    Published(f64),
    /// Nothing is known.
    None,
}

impl Row {
    pub(super) fn new(name: impl Into<String>, measured: f64, reference: Reference) -> Self {
        Self { name: name.into(), measured, reference }
    }

    /// What is wrong with the number, if something is.
    pub(super) fn complaint(&self) -> Option<String> {
        let Self { name, measured, reference } = self;
        let within = |expected: f64| (1.0 - BAND..=1.0 + BAND).contains(&(measured / expected));
        match *reference {
            Reference::Expected(expected) if !within(expected) => {
                let percent = 100.0 * BAND;
                Some(format!("{name}: {measured:.4}, expected {expected:.4} ± {percent} %"))
            }
            Reference::AtMost(limit) if measured.is_nan() || *measured > limit => {
                Some(format!("{name}: {measured:.4}, allowed is at most {limit:.4}"))
            }
            Reference::Exactly(expected) if *measured != expected => {
                Some(format!("{name}: {measured:.4}, expected exactly {expected:.4}"))
            }
            _ => None,
        }
    }
}

/// The rows as a text table.
pub(super) fn table(rows: &[Row]) -> String {
    let mut text =
        format!("{:<44} {:>10} {:>18} {:>8}\n", "quantity", "measured", "reference", "ratio");
    for row in rows {
        let (reference, ratio) = match row.reference {
            Reference::Expected(x) => (format!("{x:.4}"), format!("{:.2}", row.measured / x)),
            Reference::Published(x) => {
                (format!("published {x:.2}"), format!("{:.2}", row.measured / x))
            }
            Reference::AtMost(x) => (format!("at most {x:.4}"), format!("{:.2}", row.measured / x)),
            Reference::Exactly(x) => (format!("exactly {x}"), String::new()),
            Reference::None => (String::new(), String::new()),
        };
        let mark = if row.complaint().is_some() { "  <-- out of band" } else { "" };
        text +=
            &format!("{:<44} {:>10.4} {reference:>18} {ratio:>8}{mark}\n", row.name, row.measured);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{Reference, Row, table};

    #[test]
    fn only_numbers_out_of_band_are_complained_about() {
        for (measured, reference, complains) in [
            (1.14, Reference::Expected(1.0), false),
            (0.84, Reference::Expected(1.0), true),
            (f64::NAN, Reference::Expected(1.0), true),
            (9.0, Reference::Published(1.0), false),
            (0.5, Reference::AtMost(0.5), false),
            (0.51, Reference::AtMost(0.5), true),
            (f64::NAN, Reference::AtMost(0.5), true),
            (32.0, Reference::Exactly(32.0), false),
            (31.0, Reference::Exactly(32.0), true),
        ] {
            let row = Row::new("x", measured, reference);
            assert_eq!(row.complaint().is_some(), complains, "{row:?}");
            assert_eq!(table(&[row]).contains("out of band"), complains);
        }
    }
}
