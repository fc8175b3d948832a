//! The rows of the table of pass marks.

use diagnosis::{Status, Verdict};

use super::case::Family;
use super::detectable::detectable;
use super::oracle::Oracle;
use super::power::Power;
use super::record::{Outcome, Record};
use super::score::{Score, intervals};
use super::trial::over_floor;
use super::variant::Variant;
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
enum Mark {
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
fn row(
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

/// Every row.
pub(super) fn rows(records: &[Record], oracle: &Oracle) -> Vec<Row> {
    let of = |family: Family| records.iter().filter(move |record| record.family == family);
    let is_wrong = |record: &Record| (line(record), !Score::of(record).wrong.is_empty());
    let is_found = |record: &Record| (line(record), Score::of(record).is_all_found());
    let single = |times: f64| of(Family::Single).filter(move |one| one.multiple == Some(times));
    let at_most = |text, most| (text, Mark::AtMost(most));
    let at_least = |text, least| (text, Mark::AtLeast(least));
    let wrong_mark = at_most("≤ 5 %", 0.05);
    let large = || of(Family::Outside).filter(|one| one.visibility.is_some_and(|size| size >= 0.6));
    let claims_one = |record: &Record| {
        let answer = record.outcome.answer();
        (line(record), answer.is_none_or(|answer| answer.named.len() == 1))
    };
    let mut rows = vec![
        row(
            "a wrong name where nothing is hidden, right base",
            wrong_mark,
            of(Family::Nothing).map(is_wrong),
        ),
        row(
            "a wrong name where nothing is hidden, the thesis' ellipsoid",
            wrong_mark,
            of(Family::Ellipsoid).map(is_wrong),
        ),
        row(
            "right class named at 2× the nameable size",
            at_least("≥ 90 %", 0.9),
            single(2.0).map(is_found),
        ),
        row(
            "right class named at 4× the nameable size",
            at_least("≥ 97 %", 0.97),
            single(4.0).map(is_found),
        ),
        row(
            "a wrong name beside or instead, at 2× and 4×",
            at_most("≤ 10 %", 0.1),
            single(2.0).chain(single(4.0)).map(is_wrong),
        ),
        row(
            "right class named at typical sizes",
            at_least("≥ 97 %", 0.97),
            of(Family::Typical).map(is_found),
        ),
        row("both of a pair found at 4×", at_least("≥ 85 %", 0.85), of(Family::Pair).map(is_found)),
        row("extra names beside a pair", at_most("≤ 10 %", 0.1), of(Family::Pair).map(is_wrong)),
        row(
            "outside the catalogue, 0.6 of the noise or more: none of these",
            at_least("≥ 80 %", 0.8),
            large().map(is_unexplained),
        ),
        row(
            "outside the catalogue: a wrong name",
            at_most("≤ 10 %", 0.1),
            of(Family::Outside).map(is_wrong),
        ),
        row("narrow design: a single name claimed", wrong_mark, of(Family::Narrow).map(claims_one)),
        row("narrow design: a wrong name claimed", wrong_mark, of(Family::Narrow).map(is_wrong)),
        row(
            "untestable effects called untestable",
            at_least("100 %", 1.0),
            of(Family::Untestable).map(is_untestable),
        ),
        row(
            "95 % intervals that hold the truth",
            ("92–98 %", Mark::Within(0.92, 0.98)),
            of(Family::Single)
                .chain(of(Family::Typical))
                .chain(of(Family::Pair))
                .flat_map(intervals),
        ),
        gap_closed(records),
        error_left(records),
        row(
            "a wrong effect added by hand closes at most 20 %",
            at_least("always", 1.0),
            of(Family::WrongEffect).flat_map(by_hand),
        ),
        row(
            "nominal μp 20 % wrong: the verdict gains pusher-friction alone",
            at_least("always", 1.0),
            of(Family::WrongNominal).map(gains_friction),
        ),
    ];
    rows.extend(Variant::SAME.map(|variant| {
        let same = of(Family::Robust).filter_map(|record| is_same(record, variant));
        row(
            &format!("the same verdict with {}", variant.name()),
            at_least("≥ 90 % (own mark)", 0.9),
            same,
        )
    }));
    let shuffled = of(Family::Robust).filter_map(claims_shuffled);
    rows.push(row(
        "shuffled control: a name that is no friction of the set's",
        wrong_mark,
        shuffled,
    ));
    rows.push(told_sizes(records, oracle));
    rows.push(measured_sizes(records));
    rows.push(time(records));
    rows
}

fn line(record: &Record) -> String {
    format!("`{}`: {}", record.case, record.outcome.text())
}

fn is_unexplained(record: &Record) -> (String, bool) {
    let score = Score::of(record);
    let answer = record.outcome.answer();
    let is = answer.is_some_and(|answer| {
        let unexplained = answer.verdict == Verdict::StructureUnexplained;
        unexplained || (score.wrong.is_empty() && !answer.claimed().is_empty())
    });
    (line(record), is)
}

fn is_untestable(record: &Record) -> (String, bool) {
    let told = record.outcome.answer().and_then(|answer| answer.told(&record.about));
    (line(record), told.is_some_and(|told| told.status == Status::NotTestable))
}

/// Errors over the floor before and after, where the model asked about misses something.
fn errors(record: &Record) -> Option<[f64; 2]> {
    const MISSES: f64 = 1.5;
    let is_asked = matches!(record.family, Family::Single | Family::Typical | Family::Pair);
    let (answer, floor) = (record.outcome.answer().filter(|_| is_asked)?, record.floor?);
    let over = |one: diagnosis::MotionError| {
        Some(over_floor([one.dx_m?, one.dy_m?, one.dtheta_rad?], floor))
    };
    let [before, after] = [over(answer.error.before_si)?, over(answer.error.after_si)?];
    (before >= MISSES).then_some([before, after])
}

fn median_row(
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

fn gap_closed(records: &[Record]) -> Row {
    let closed = |record: &Record| {
        let [before, after] = errors(record)?;
        Some((line(record), (before - after) / (before - 1.0)))
    };
    let what =
        ("gap closed where the error is 1.5 floors or more, median", "≥ 0.85", Mark::AtLeast(0.85));
    median_row(what, records.iter().filter_map(closed).collect())
}

fn error_left(records: &[Record]) -> Row {
    let left = |record: &Record| Some((line(record), errors(record)?[1]));
    let what = ("final error over the floor there, median", "≤ 1.15", Mark::AtMost(1.15));
    median_row(what, records.iter().filter_map(left).collect())
}

fn by_hand(record: &Record) -> Vec<(String, bool)> {
    const MOST: f64 = 0.2;
    let is_large = errors_by_hand(record);
    let closed = record.closed_by_hand.iter().filter(|_| is_large);
    closed
        .map(|(id, closed)| {
            (format!("`{}`: {id} closes {:.0} %", record.case, 100.0 * closed), *closed <= MOST)
        })
        .collect()
}

/// Whether there is a gap to close in the motion.
fn errors_by_hand(record: &Record) -> bool {
    const MISSES: f64 = 1.5;
    let Some((answer, floor)) = record.outcome.answer().zip(record.floor) else { return false };
    let before = answer.error.before_si;
    let before = before.dx_m.zip(before.dy_m).zip(before.dtheta_rad);
    before.is_some_and(|((dx, dy), turn)| over_floor([dx, dy, turn], floor) >= MISSES)
}

fn gains_friction(record: &Record) -> (String, bool) {
    let outcome = record.variants.get(&Variant::WrongNominal);
    let pair = record.outcome.answer().zip(outcome.and_then(Outcome::answer));
    let gains = pair.is_some_and(|(right, wrong)| {
        let mut expected = right.claimed();
        expected.insert("pusher-friction");
        expected == wrong.claimed()
    });
    let with = outcome.map_or("not run".to_owned(), Outcome::text);
    (format!("{}; with the wrong one {with}", line(record)), gains)
}

fn is_same(record: &Record, variant: Variant) -> Option<(String, bool)> {
    let outcome = record.variants.get(&variant)?;
    let pair = record.outcome.answer().zip(outcome.answer());
    let same = pair.is_some_and(|(one, other)| one.claimed() == other.claimed());
    Some((format!("{}; then {}", line(record), outcome.text()), same))
}

fn claims_shuffled(record: &Record) -> Option<(String, bool)> {
    let outcome = record.variants.get(&Variant::Shuffled)?;
    let claims = outcome.answer().is_none_or(|answer| !answer.claimed().is_empty());
    Some((format!("{}; shuffled {}", line(record), outcome.text()), claims))
}

fn told_sizes(records: &[Record], oracle: &Oracle) -> Row {
    let near = |one: &super::detectable::Detectable| {
        let ratio = one.told / one.oracle;
        let line = format!("{}: told {:.2} of the oracle's", one.id, ratio);
        (line, (0.8..=1.25).contains(&ratio))
    };
    let found = detectable(records, oracle);
    let mark = ("every effect", Mark::AtLeast(1.0));
    row("told smallest detectable size within 1.25× of the oracle's", mark, found.iter().map(near))
}

fn measured_sizes(records: &[Record]) -> Row {
    let known = effects::all().iter().map(|effect| effect.about().id);
    let near = known.filter_map(|id| {
        let power = Power::of(records, Some(id));
        if power.0.is_empty() {
            return None;
        }
        let size = power.nine_in_ten();
        let line = match size {
            Some(size) => format!("{id}: nine in ten at {size:.2} of the nameable size"),
            None => format!("{id}: not nine in ten at any size"),
        };
        Some((line, size.is_some_and(|size| size <= 1.5)))
    });
    let mark = ("every effect", Mark::AtLeast(1.0));
    row("nine in ten found from 1.5× the nameable size on", mark, near)
}

fn time(records: &[Record]) -> Row {
    let times = records.iter().filter(|record| record.outcome.answer().is_some());
    let times = times.map(|record| (format!("`{}`", record.case), record.seconds)).collect();
    let what = ("time of a diagnosis on one core, in s, median", "≤ 5 on two", Mark::AtMost(10.0));
    median_row(what, times)
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
