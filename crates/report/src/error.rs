//! What can be wrong with a figure or a page.

use std::path::PathBuf;

use thiserror::Error;

/// Why a figure or a page could not be drawn or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A value that is NaN or infinite.
    #[error("{mark}: {field}[{index}] is {value}; remove or mask it before drawing")]
    NotFinite {
        /// The mark's kind and label.
        mark: String,
        /// Which of its inputs.
        field: &'static str,
        /// Position in that input.
        index: usize,
        /// The value found.
        value: f64,
    },
    /// Two inputs that must be equally long are not.
    #[error("{mark}: {field} has {found} values, {expected} are needed")]
    Length {
        /// The mark's kind and label.
        mark: String,
        /// Which of its inputs.
        field: &'static str,
        /// The length it should have.
        expected: usize,
        /// The length it has.
        found: usize,
    },
    /// A mark without anything to draw.
    #[error("{mark} has no data to draw")]
    Empty {
        /// The mark's kind and label.
        mark: String,
    },
    /// A parameter outside its valid range.
    #[error("{mark}: {field} must be {expected}, got {value}")]
    Parameter {
        /// The mark's kind and label.
        mark: String,
        /// The parameter's name.
        field: &'static str,
        /// What is valid, in words.
        expected: &'static str,
        /// The value found.
        value: f64,
    },
    /// A panel without marks.
    #[error("panel {index} (`{title}`) has no marks; add one or leave the panel out")]
    EmptyPanel {
        /// Position in the figure, counted from 0 row by row.
        index: usize,
        /// The panel's title.
        title: String,
    },
    /// A mark that reaches zero or below on a logarithmic axis.
    #[error("{mark} reaches {value} on the logarithmic axis `{axis}`; only positive values fit")]
    NotPositive {
        /// The mark's kind and label.
        mark: String,
        /// The axis label.
        axis: String,
        /// The value found.
        value: f64,
    },
    /// A mark whose meaning needs evenly spaced axes on a logarithmic one.
    #[error("{mark} needs linear axes, but `{axis}` is logarithmic")]
    NeedsLinear {
        /// The mark's kind and label.
        mark: String,
        /// The axis label.
        axis: String,
    },
    /// An axis range that is not increasing and finite.
    #[error("axis `{axis}`: the range {low} to {high} must be finite and increasing")]
    Range {
        /// The axis label.
        axis: String,
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// A figure whose size leaves no room for its panels.
    #[error("panel {index}: {width:.0} × {height:.0} px are left for the data; enlarge the figure")]
    TooSmall {
        /// Position in the figure, counted from 0 row by row.
        index: usize,
        /// Width left, in px.
        width: f64,
        /// Height left, in px.
        height: f64,
    },
    /// More or fewer panels than the figure's grid has cells.
    #[error("{found} panels for a figure of {rows} × {columns}")]
    Panels {
        /// Rows of the figure.
        rows: usize,
        /// Columns of the figure.
        columns: usize,
        /// Panels given.
        found: usize,
    },
    /// A name that does not fit a file name or a link.
    #[error("`{name}` is not a valid name: use letters, digits, `.`, `_` and `-`")]
    Name {
        /// The name given.
        name: String,
    },
    /// The same name twice on one page.
    #[error("`{name}` is on the page twice; links need unique names")]
    Duplicate {
        /// The name given.
        name: String,
    },
    /// A figure's file outside the folder of the page that shows it.
    #[error("{} is not below the page's folder {}", .path.display(), .folder.display())]
    Outside {
        /// The figure's file.
        path: PathBuf,
        /// The page's folder.
        folder: PathBuf,
    },
    /// A figure with files on a page that is to have none.
    #[error("figure `{name}` has files of its own; use a drawing on a page without files")]
    NotAlone {
        /// The figure's name.
        name: String,
    },
    /// The picture could not be encoded as PNG.
    #[error("cannot encode the picture: {0}")]
    Encode(String),
    /// A file that cannot be written.
    #[error(transparent)]
    Output(#[from] output::OutputError),
    /// A folder that cannot be made.
    #[error("cannot write {}", .path.display())]
    Write {
        /// The folder.
        path: PathBuf,
        /// What the system answered.
        source: std::io::Error,
    },
}

pub(crate) fn check_finite(
    mark: &str,
    field: &'static str,
    values: &[f64],
) -> Result<(), ReportError> {
    match values.iter().position(|value| !value.is_finite()) {
        None => Ok(()),
        Some(index) => Err(ReportError::NotFinite {
            mark: mark.to_owned(),
            field,
            index,
            value: values[index],
        }),
    }
}

pub(crate) fn check_length(
    mark: &str,
    field: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), ReportError> {
    if expected == found {
        return Ok(());
    }
    Err(ReportError::Length { mark: mark.to_owned(), field, expected, found })
}

/// Lists that belong together: not empty, equally long and finite.
pub(crate) fn check_columns(
    mark: &str,
    columns: &[(&'static str, &[f64])],
) -> Result<(), ReportError> {
    let n = columns.first().map_or(0, |(_, values)| values.len());
    check_some(mark, n)?;
    for (field, values) in columns {
        check_length(mark, field, n, values.len())?;
    }
    columns.iter().try_for_each(|(field, values)| check_finite(mark, field, values))
}

pub(crate) fn check_some(mark: &str, n: usize) -> Result<(), ReportError> {
    if n > 0 { Ok(()) } else { Err(ReportError::Empty { mark: mark.to_owned() }) }
}

pub(crate) fn check_positive(
    mark: &str,
    field: &'static str,
    value: f64,
) -> Result<(), ReportError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(ReportError::Parameter {
        mark: mark.to_owned(),
        field,
        expected: "positive and finite",
        value,
    })
}
