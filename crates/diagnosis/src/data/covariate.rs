//! What a residual may depend on, and its bins.

use serde::{Deserialize, Serialize};

/// Something that a residual may depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Covariate {
    /// Place of the contact along its edge, 0 to 1.
    P,
    /// Angle of the push from the edge's inward normal, in rad.
    Beta,
    /// Speed of the pusher, in m/s.
    Speed,
    /// Yaw of the object in the world, in rad.
    Orientation,
    /// Direction of the pusher's motion in the world, in rad.
    Direction,
    /// Place of the object on the table along x, in m.
    TableX,
    /// Place of the object on the table along y, in m.
    TableY,
    /// Place of the push in the order of the set, 0 to 1.
    Time,
    /// The edge touched.
    Edge,
}

/// Cells of a covariate: the lower ends, and the upper end of the last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<f64>", into = "Vec<f64>")]
pub(crate) struct Bins(Vec<f64>);

impl Covariate {
    /// Every covariate.
    pub const ALL: [Self; 9] = [
        Self::P,
        Self::Beta,
        Self::Speed,
        Self::Orientation,
        Self::Direction,
        Self::TableX,
        Self::TableY,
        Self::Time,
        Self::Edge,
    ];

    /// The pairs over which a residual is mapped.
    pub const PAIRS: [[Self; 2]; 7] = [
        [Self::P, Self::Beta],
        [Self::P, Self::Edge],
        [Self::Beta, Self::Edge],
        [Self::P, Self::Speed],
        [Self::Beta, Self::Speed],
        [Self::Orientation, Self::Direction],
        [Self::TableX, Self::TableY],
    ];

    /// Name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::P => "p",
            Self::Beta => "β",
            Self::Speed => "speed",
            Self::Orientation => "orientation",
            Self::Direction => "direction",
            Self::TableX => "table x",
            Self::TableY => "table y",
            Self::Time => "order of the pushes",
            Self::Edge => "edge",
        }
    }

    /// SI unit; `1` for none.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Beta | Self::Orientation | Self::Direction => "rad",
            Self::Speed => "m/s",
            Self::TableX | Self::TableY => "m",
            Self::P | Self::Time | Self::Edge => "1",
        }
    }

    /// Whether its last cell is next to its first.
    pub(crate) fn is_periodic(self) -> bool {
        matches!(self, Self::Orientation | Self::Direction)
    }

    /// Cells of equal width where the range is known beforehand, of equal numbers of steps else.
    pub(crate) fn bins(self, values: &[f64]) -> Bins {
        use std::f64::consts::{FRAC_PI_2, PI};
        match self {
            Self::P | Self::Time => Bins::equal(0.0, 1.0, 5),
            Self::Beta => Bins::equal(-FRAC_PI_2, FRAC_PI_2, 12),
            Self::Orientation | Self::Direction => Bins::equal(-PI, PI, 12),
            Self::Edge => {
                let last = values.iter().fold(0.0_f64, |last, value| last.max(*value)) as usize;
                Bins::equal(-0.5, last as f64 + 0.5, last + 1)
            }
            Self::Speed => Bins::levels(values).unwrap_or_else(|| Bins::quantiles(values, 6)),
            Self::TableX | Self::TableY => Bins::quantiles(values, 6),
        }
    }
}

impl TryFrom<Vec<f64>> for Bins {
    type Error = &'static str;

    fn try_from(bounds: Vec<f64>) -> Result<Self, Self::Error> {
        match bounds.is_empty() || bounds.windows(2).any(|pair| pair[0] >= pair[1]) {
            true => Err("bounds of cells have to increase"),
            false => Ok(Self(bounds)),
        }
    }
}

impl From<Bins> for Vec<f64> {
    fn from(bins: Bins) -> Self {
        bins.0
    }
}

impl Bins {
    fn equal(low: f64, high: f64, n: usize) -> Self {
        Self((0..=n).map(|k| low + (high - low) * k as f64 / n as f64).collect())
    }

    /// A cell for each level at which values stand together, if there are few of them.
    fn levels(values: &[f64]) -> Option<Self> {
        /// Values of one level differ by less than this factor.
        const SAME: f64 = 1.15;
        const MOST: usize = 12;
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let (mut first, mut last) = (*sorted.first()?, *sorted.first()?);
        let mut bounds = vec![first];
        for value in &sorted {
            if *value > SAME * first {
                bounds.push(0.5 * (last + value));
                first = *value;
            }
            last = *value;
        }
        bounds.push(last);
        bounds.dedup();
        (bounds.len() <= MOST + 1).then_some(Self(bounds))
    }

    fn quantiles(values: &[f64], n: usize) -> Self {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let at = |k: usize| sorted[(k * (sorted.len() - 1)) / n];
        let mut bounds: Vec<f64> = (0..=n).map(at).collect();
        bounds.dedup();
        Self(bounds)
    }

    pub(crate) fn n_cells(&self) -> usize {
        (self.0.len() - 1).max(1)
    }

    /// The ends of a cell.
    pub(crate) fn ends(&self, cell: usize) -> [f64; 2] {
        [self.0[cell], self.0[(cell + 1).min(self.0.len() - 1)]]
    }

    /// The cell of a value; those beyond the ends belong to the first and last.
    pub(crate) fn cell(&self, value: f64) -> usize {
        let above = self.0.iter().take_while(|bound| **bound <= value).count();
        above.saturating_sub(1).min(self.n_cells() - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::Covariate;

    #[test]
    fn every_value_has_a_cell_that_holds_it() {
        let values: Vec<f64> = (0..40).map(|k| (f64::from(k) * 0.7).sin().powi(3)).collect();
        for covariate in [Covariate::Beta, Covariate::TableX, Covariate::Orientation] {
            let bins = covariate.bins(&values);
            for value in &values {
                let [low, high] = bins.ends(bins.cell(*value));
                assert!(low <= *value && *value <= high, "{covariate:?} {value}");
            }
        }
        let bins = Covariate::Edge.bins(&[0.0, 3.0, 1.0]);
        assert_eq!([0.0, 1.0, 3.0].map(|edge| bins.cell(edge)), [0, 1, 3]);
        let few = Covariate::Speed.bins(&[0.0199, 0.1, 0.0201, 0.4, 0.101]);
        assert_eq!([0.02, 0.1, 0.4].map(|speed| few.cell(speed)), [0, 1, 2]);
        let one = Covariate::Speed.bins(&[0.02; 9]);
        assert_eq!((one.n_cells(), one.cell(0.02), one.ends(0)), (1, 0, [0.02, 0.02]));
    }
}
