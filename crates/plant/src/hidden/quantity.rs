//! Units in which the numbers of a hidden effect may be given.

/// What kind of number a parameter is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Without a unit.
    Number,
    /// In m.
    Length,
    /// In rad.
    Angle,
    /// In m/s.
    Speed,
    /// In m/s².
    Acceleration,
    /// In s.
    Time,
    /// In N.
    Force,
    /// In N/m.
    Stiffness,
    /// In m/N.
    Compliance,
    /// In 1/m.
    PerLength,
    /// A whole number, of a vertex.
    Index,
}

impl Quantity {
    /// Endings of a parameter's name, each with its unit's size in SI units; the first is SI.
    #[must_use]
    pub fn suffixes(self) -> &'static [(&'static str, f64)] {
        match self {
            Self::Number | Self::Index => &[("", 1.0)],
            Self::Length => &[("_m", 1.0), ("_mm", 1e-3)],
            Self::Angle => &[("_rad", 1.0), ("_deg", std::f64::consts::PI / 180.0)],
            Self::Speed => &[("_m_s", 1.0), ("_mm_s", 1e-3)],
            Self::Acceleration => &[("_m_s2", 1.0)],
            Self::Time => &[("_s", 1.0), ("_ms", 1e-3)],
            Self::Force => &[("_n", 1.0)],
            Self::Stiffness => &[("_n_per_m", 1.0)],
            Self::Compliance => &[("_m_per_n", 1.0), ("_mm_per_n", 1e-3)],
            Self::PerLength => &[("_per_m", 1.0)],
        }
    }

    /// The unit's symbol.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Number | Self::Index => "1",
            Self::Length => "m",
            Self::Angle => "rad",
            Self::Speed => "m/s",
            Self::Acceleration => "m/s²",
            Self::Time => "s",
            Self::Force => "N",
            Self::Stiffness => "N/m",
            Self::Compliance => "m/N",
            Self::PerLength => "1/m",
        }
    }
}
