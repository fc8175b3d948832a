//! The numbers behind a figure, as CSV or JSON.

use crate::error::{ReportError, check_finite, check_length, check_some};

/// The numbers behind a figure.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Data {
    /// Columns of one length, written as CSV.
    Table(Table),
    /// Anything else, written as JSON.
    Json(serde_json::Value),
}

/// Named columns of one length; names carry units, e.g. `time in s`.
#[derive(Debug, Clone, Default)]
pub struct Table {
    columns: Vec<(String, Column)>,
}

#[derive(Debug, Clone)]
enum Column {
    Numbers(Vec<f64>),
    Names(Vec<String>),
}

impl Table {
    /// A table without columns.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a column of numbers.
    #[must_use]
    pub fn column(mut self, name: &str, values: &[f64]) -> Self {
        self.columns.push((name.to_owned(), Column::Numbers(values.to_vec())));
        self
    }

    /// Adds a column of text.
    #[must_use]
    pub fn names<N: AsRef<str>>(mut self, name: &str, values: &[N]) -> Self {
        let values = values.iter().map(|value| value.as_ref().to_owned()).collect();
        self.columns.push((name.to_owned(), Column::Names(values)));
        self
    }

    /// The table as CSV text (RFC 4180, but with a bare line feed).
    ///
    /// # Errors
    /// No columns, columns that differ in length, or a value that is not finite.
    pub fn to_csv(&self, table: &str) -> Result<String, ReportError> {
        check_some(&format!("table `{table}`"), self.columns.len())?;
        let n_rows = self.columns[0].1.len();
        for (name, column) in &self.columns {
            let what = format!("table `{table}`, column `{name}`");
            check_length(&what, "column", n_rows, column.len())?;
            if let Column::Numbers(values) = column {
                check_finite(&what, "value", values)?;
            }
        }
        let head: Vec<String> = self.columns.iter().map(|(name, _)| quoted(name)).collect();
        let mut out = head.join(",") + "\n";
        for row in 0..n_rows {
            let cells: Vec<String> = self.columns.iter().map(|(_, c)| c.cell(row)).collect();
            out.push_str(&cells.join(","));
            out.push('\n');
        }
        Ok(out)
    }
}

impl Column {
    fn len(&self) -> usize {
        match self {
            Self::Numbers(values) => values.len(),
            Self::Names(values) => values.len(),
        }
    }

    fn cell(&self, row: usize) -> String {
        match self {
            Self::Numbers(values) => serde_json::Value::from(values[row]).to_string(),
            Self::Names(values) => quoted(&values[row]),
        }
    }
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        return format!("\"{}\"", text.replace('"', "\"\""));
    }
    text.to_owned()
}

impl Data {
    pub(crate) fn extension(&self) -> &'static str {
        match self {
            Self::Table(_) => "csv",
            Self::Json(_) => "json",
        }
    }

    pub(crate) fn to_text(&self, name: &str) -> Result<String, ReportError> {
        match self {
            Self::Table(table) => table.to_csv(name),
            Self::Json(value) => Ok(format!("{value:#}\n")),
        }
    }
}

impl From<Table> for Data {
    fn from(table: Table) -> Self {
        Self::Table(table)
    }
}

impl From<serde_json::Value> for Data {
    fn from(value: serde_json::Value) -> Self {
        Self::Json(value)
    }
}

#[cfg(test)]
mod tests {
    use super::Table;
    use crate::error::ReportError;

    #[test]
    fn table_is_quoted_where_needed_and_numbers_read_back() {
        let table = Table::new()
            .names("shape, \"side\"", &["rect1", "a,b"])
            .column("x in m", &[0.1 + 0.2, -1e-20]);
        let csv = table.to_csv("t").expect("the table is sound");
        assert_eq!(
            csv,
            "\"shape, \"\"side\"\"\",x in m\nrect1,0.30000000000000004\n\"a,b\",-1e-20\n"
        );
    }

    #[test]
    fn a_bad_table_is_refused() {
        assert!(matches!(Table::new().to_csv("t"), Err(ReportError::Empty { .. })));
        let uneven = Table::new().column("a", &[1.0]).column("b", &[]);
        assert!(matches!(uneven.to_csv("t"), Err(ReportError::Length { .. })));
        let hole = Table::new().column("a", &[1.0, f64::NAN]);
        assert!(matches!(hole.to_csv("t"), Err(ReportError::NotFinite { index: 1, .. })));
    }
}
