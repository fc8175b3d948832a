//! Quantiles of a sample.

/// The value below which a share of the finite ones lies, by the nearest rank; none if there are
/// none. Of an even number the median is the upper one of the middle two.
pub fn quantile(mut values: Vec<f64>, share: f64) -> Option<f64> {
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    values.get((share * last as f64).round() as usize).copied()
}

#[cfg(test)]
mod tests {
    use super::quantile;

    #[test]
    fn quantiles_are_values_of_the_sample() {
        assert_eq!(quantile(vec![4.0, 1.0, f64::NAN, 3.0, 2.0], 0.5), Some(3.0));
        assert_eq!(quantile(vec![3.0, 1.0, 2.0], 0.5), Some(2.0));
        assert_eq!(quantile((0..=10).map(f64::from).collect(), 0.9), Some(9.0));
        assert_eq!(quantile(vec![f64::INFINITY], 0.5), None);
    }
}
