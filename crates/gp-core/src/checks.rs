//! Checks of the arguments that come from a user, for this crate and those that build on it.

use std::cmp::Ordering;

use faer::MatRef;

use crate::GpError;

/// Checks that `x` has rows, `n_inputs` columns and finite values only.
///
/// # Errors
/// `Empty`, `ShapeMismatch` or `NotFinite` otherwise.
pub fn check_inputs(
    what: &'static str,
    x: MatRef<'_, f64>,
    n_inputs: usize,
) -> Result<(), GpError> {
    if x.nrows() == 0 || x.ncols() == 0 {
        return Err(GpError::Empty { what });
    }
    check_count("columns of the inputs", n_inputs, x.ncols())?;
    check_finite(what, x)
}

/// Checks that `y` has `n_rows` finite values.
///
/// # Errors
/// `ShapeMismatch` or `NotFinite` otherwise.
pub fn check_outputs(what: &'static str, y: &[f64], n_rows: usize) -> Result<(), GpError> {
    check_count(what, n_rows, y.len())?;
    match y.iter().position(|value| !value.is_finite()) {
        Some(row) => Err(GpError::NotFinite { what, row, column: 0, value: y[row] }),
        None => Ok(()),
    }
}

/// Checks that every entry of a matrix is finite.
///
/// # Errors
/// `NotFinite` otherwise.
pub fn check_finite(what: &'static str, x: MatRef<'_, f64>) -> Result<(), GpError> {
    for (column, values) in x.col_iter().enumerate() {
        if let Some((row, value)) = values.iter().enumerate().find(|(_, value)| !value.is_finite())
        {
            return Err(GpError::NotFinite { what, row, column, value: *value });
        }
    }
    Ok(())
}

/// Checks that two counts agree.
///
/// # Errors
/// `ShapeMismatch` otherwise.
pub fn check_count(what: &'static str, expected: usize, actual: usize) -> Result<(), GpError> {
    if expected == actual { Ok(()) } else { Err(GpError::ShapeMismatch { what, expected, actual }) }
}

/// Checks that a parameter is positive and finite.
///
/// # Errors
/// `NotPositive` otherwise.
pub fn check_positive(name: &str, value: f64) -> Result<(), GpError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(GpError::NotPositive { name: name.to_owned(), value })
    }
}

/// Checks that a variance is finite and not negative.
///
/// # Errors
/// `Negative` otherwise.
pub fn check_not_negative(name: &str, value: f64) -> Result<(), GpError> {
    if value >= 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(GpError::Negative { name: name.to_owned(), value })
    }
}

/// Checks that there is no known noise of rows, or one of each that is finite and not negative.
///
/// # Errors
/// `ShapeMismatch`, `Negative` otherwise.
pub fn check_row_noise(row_noise: &[f64], n_rows: usize) -> Result<(), GpError> {
    if row_noise.is_empty() {
        return Ok(());
    }
    check_count("row noise", n_rows, row_noise.len())?;
    match row_noise.iter().position(|&noise| check_not_negative("", noise).is_err()) {
        Some(row) => check_not_negative(&format!("noise variance of row {row}"), row_noise[row]),
        None => Ok(()),
    }
}

/// Checks that a number lies between two others.
///
/// # Errors
/// `OutOfRange` otherwise.
pub fn check_range(name: &str, value: f64, lowest: f64, highest: f64) -> Result<(), GpError> {
    if value >= lowest && value <= highest {
        Ok(())
    } else {
        Err(GpError::OutOfRange { name: name.to_owned(), value, lowest, highest })
    }
}

/// Checks that no two rows of `x` are equal, in O(D·N·log N).
///
/// # Errors
/// `DuplicateRows` otherwise.
pub fn check_distinct_rows(x: MatRef<'_, f64>) -> Result<(), GpError> {
    let compare = |&a: &usize, &b: &usize| {
        (0..x.ncols())
            .map(|d| x[(a, d)].partial_cmp(&x[(b, d)]).unwrap_or(Ordering::Equal))
            .find(|order| order.is_ne())
            .unwrap_or(Ordering::Equal)
    };
    let mut order: Vec<usize> = (0..x.nrows()).collect();
    order.sort_by(compare);
    match order.windows(2).find(|pair| compare(&pair[0], &pair[1]).is_eq()) {
        Some(pair) => Err(GpError::DuplicateRows { first: pair[0], second: pair[1] }),
        None => Ok(()),
    }
}
