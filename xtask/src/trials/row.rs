//! One row of the table of pass marks.

use super::wilson::Share;

/// A figure that the diagnosis is held to.
pub(super) struct Row {
    pub(super) figure: String,
    pub(super) mark: &'static str,
    pub(super) measured: String,
    /// None where nothing was measured.
    pub(super) holds: Option<bool>,
    /// What did not hold, a line each.
    pub(super) failed: Vec<String>,
}

/// Which side of a mark is right.
#[derive(Clone, Copy)]
pub(super) enum Mark {
    AtLeast(f64),
    AtMost(f64),
    Within(f64, f64),
}

impl Mark {
    fn holds(self, value: f64) -> bool {
        match self {
            Self::AtLeast(least) => value >= least,
            Self::AtMost(most) => value <= most,
            Self::Within(least, most) => (least..=most).contains(&value),
        }
    }
}

/// From a share; `items` are a line for the list and whether it counts.
pub(super) fn row(
    figure: &str,
    (text, mark): (&'static str, Mark),
    items: impl IntoIterator<Item = (String, bool)>,
) -> Row {
    let items: Vec<(String, bool)> = items.into_iter().collect();
    let share = Share::of(items.iter().map(|(_, hit)| *hit));
    // Of errors those that happened are listed, of what should be those that did not.
    let listed = matches!(mark, Mark::AtMost(_));
    let failed = items.into_iter().filter(|(_, hit)| *hit == listed).map(|(line, _)| line);
    Row {
        figure: figure.to_owned(),
        mark: text,
        measured: share.text(),
        holds: share.value().map(|value| mark.holds(value)),
        failed: failed.collect(),
    }
}

/// From the median of some values, each with its line for the list.
pub(super) fn median_row(
    (figure, text, mark): (&str, &'static str, Mark),
    mut values: Vec<(String, f64)>,
) -> Row {
    values.sort_by(|a, b| a.1.total_cmp(&b.1));
    let median = values.get(values.len() / 2).map(|(_, value)| *value);
    let quartile = |k: usize| values[k * (values.len() - 1) / 4].1;
    let measured = median.map_or("not run".to_owned(), |median| {
        let [low, high] = [quartile(1), quartile(3)];
        format!("{median:.2} (half of them {low:.2} to {high:.2}, n = {})", values.len())
    });
    let failed = values.iter().filter(|(_, value)| !mark.holds(*value));
    let failed = failed.map(|(line, value)| format!("{line}: {value:.2}")).collect();
    Row {
        figure: figure.to_owned(),
        mark: text,
        measured,
        holds: median.map(|m| mark.holds(m)),
        failed,
    }
}

#[cfg(test)]
mod tests {
    use super::{Mark, median_row, row};

    #[test]
    fn a_row_lists_what_did_not_hold() {
        let items = || [("a".to_owned(), true), ("b".to_owned(), false)];
        let found = row("found", ("≥ 90 %", Mark::AtLeast(0.9)), items());
        assert_eq!((found.holds, found.failed), (Some(false), vec!["b".to_owned()]));
        let wrong = row("wrong", ("≤ 60 %", Mark::AtMost(0.6)), items());
        assert_eq!((wrong.holds, wrong.failed), (Some(true), vec!["a".to_owned()]));
        assert_eq!(row("none", ("≥ 90 %", Mark::AtLeast(0.9)), []).holds, None);
    }

    #[test]
    fn a_median_is_that_of_the_values() {
        let values = [3.0, 1.0, 2.0].map(|value| (value.to_string(), value)).to_vec();
        let row = median_row(("m", "≤ 1.5", Mark::AtMost(1.5)), values);
        assert!(row.measured.starts_with("2.00 (half"), "{}", row.measured);
        assert_eq!((row.holds, row.failed.len()), (Some(false), 2));
    }
}
