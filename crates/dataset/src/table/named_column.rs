//! A column of a caller's own.

/// A column by its name, with a value of each row.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedColumn {
    /// With the unit, as in `dx_m`.
    pub name: String,
    /// One a row.
    pub cells: Cells,
}

/// The values of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    /// Words; an empty one says nothing.
    Text(Vec<String>),
    /// Numbers that count.
    Integer(Vec<u32>),
    /// Numbers; none where there is no value.
    Real(Vec<Option<f64>>),
}

impl Cells {
    /// How many rows there are.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Text(cells) => cells.len(),
            Self::Integer(cells) => cells.len(),
            Self::Real(cells) => cells.len(),
        }
    }

    /// Whether there is no row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// A cell of a text file.
    pub(crate) fn text(&self, row: usize) -> String {
        match self {
            Self::Text(cells) => cells[row].clone(),
            Self::Integer(cells) => cells[row].to_string(),
            Self::Real(cells) => cells[row].map_or_else(String::new, |value| value.to_string()),
        }
    }
}
