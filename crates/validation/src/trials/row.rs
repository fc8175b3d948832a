//! One row of the table of pass marks.

use super::wilson::Share;

/// A figure that the diagnosis is held to.
pub(super) struct Row {
    pub(super) figure: String,
    pub(super) mark: &'static str,
    pub(super) measured: String,
    /// None where nothing was measured, or nothing is asked.
    pub(super) standing: Option<Standing>,
    /// What spoke against it, a line each.
    pub(super) failed: Vec<String>,
}

/// How a figure stands to its mark, by its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Standing {
    /// All of the interval keeps it.
    Holds,
    /// Some of the interval keeps it.
    Open,
    /// None of it does.
    Refuted,
}

impl Standing {
    pub(super) fn text(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::Open => "open (not refuted)",
            Self::Refuted => "**refuted**",
        }
    }
}

/// Which side of a mark is right.
#[derive(Clone, Copy)]
pub(super) enum Mark {
    AtLeast(f64),
    AtMost(f64),
    Within(f64, f64),
}

impl Mark {
    /// The least and the most that keep it.
    fn range(self) -> [f64; 2] {
        match self {
            Self::AtLeast(least) => [least, f64::INFINITY],
            Self::AtMost(most) => [f64::NEG_INFINITY, most],
            Self::Within(least, most) => [least, most],
        }
    }

    fn holds(self, value: f64) -> bool {
        let [least, most] = self.range();
        (least..=most).contains(&value)
    }

    /// Of a share, by its interval; none of nothing.
    pub(super) fn standing(self, share: Share) -> Option<Standing> {
        share.value()?;
        let ([low, high], [least, most]) = (share.interval(), self.range());
        Some(if low >= least && high <= most {
            Standing::Holds
        } else if high < least || low > most {
            Standing::Refuted
        } else {
            Standing::Open
        })
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
        standing: mark.standing(share),
        failed: failed.collect(),
    }
}

/// From the median of some values, each with its line for the list; it keeps its mark if more than half
/// of the values do.
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
    let kept = Share::of(values.iter().map(|(_, value)| mark.holds(*value)));
    let failed = values.iter().filter(|(_, value)| !mark.holds(*value));
    let failed = failed.map(|(line, value)| format!("{line}: {value:.2}")).collect();
    Row {
        figure: figure.to_owned(),
        mark: text,
        measured,
        standing: Mark::AtLeast(0.5).standing(kept),
        failed,
    }
}

#[cfg(test)]
mod tests {
    use super::{Mark, Share, Standing, median_row, row};

    #[test]
    fn a_row_lists_what_spoke_against_it() {
        let items = || [("a".to_owned(), true), ("b".to_owned(), false)];
        let found = row("found", ("≥ 97 %", Mark::AtLeast(0.97)), items());
        assert_eq!((found.standing, found.failed), (Some(Standing::Refuted), vec!["b".to_owned()]));
        let wrong = row("wrong", ("≤ 60 %", Mark::AtMost(0.6)), items());
        assert_eq!((wrong.standing, wrong.failed), (Some(Standing::Open), vec!["a".to_owned()]));
        assert_eq!(row("none", ("≥ 90 %", Mark::AtLeast(0.9)), []).standing, None);
    }

    #[test]
    fn a_mark_stands_by_the_interval_and_not_by_the_point() {
        use Standing::{Holds, Open, Refuted};
        let standing = |mark: Mark, hits, of| mark.standing(Share { hits, of }).unwrap();
        let (rare, mostly, within) =
            (Mark::AtMost(0.1), Mark::AtLeast(0.9), Mark::Within(0.92, 0.98));
        // 0 of 4 reaches up to 49 %, 0 of 44 up to 8 %, 4 of 4 down from 51 %.
        assert_eq!(
            [(0, 4), (0, 44), (4, 4)].map(|(k, n)| standing(rare, k, n)),
            [Open, Holds, Refuted]
        );
        let found = [(4, 4), (100, 100), (18, 20), (5, 20)].map(|(k, n)| standing(mostly, k, n));
        assert_eq!(found, [Open, Holds, Open, Refuted]);
        let inside = [(95, 100), (950, 1000), (60, 100)].map(|(k, n)| standing(within, k, n));
        assert_eq!(inside, [Open, Holds, Refuted]);
        // Nothing less than all can show that something is always so; one exception refutes it.
        let always = Mark::AtLeast(1.0);
        assert_eq!([(999, 999), (998, 999)].map(|(k, n)| standing(always, k, n)), [Open, Refuted]);
    }

    #[test]
    fn a_median_is_that_of_the_values() {
        let row = |n: usize| {
            let values = (0..n).map(|i| (i.to_string(), [3.0, 1.0, 2.0][i % 3])).collect();
            median_row(("m", "≤ 1.5", Mark::AtMost(1.5)), values)
        };
        assert!(row(3).measured.starts_with("2.00 (half"), "{}", row(3).measured);
        assert_eq!((row(3).standing, row(3).failed.len()), (Some(Standing::Open), 2));
        assert_eq!((row(300).standing, row(300).failed.len()), (Some(Standing::Refuted), 200));
        assert_eq!(median_row(("m", "≤ 1.5", Mark::AtMost(1.5)), Vec::new()).standing, None);
    }
}
