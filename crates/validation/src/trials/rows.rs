//! The rows of the table of pass marks.

use diagnosis::{PushScatter, Verdict};

use super::case::Family;
use super::detectable::detectable;
use super::oracle::Oracle;
use super::power::Power;
use super::record::Record;
use super::row::{Mark, Row, median_row, row};
use super::score::{
    Score, finds_origin, holds_what_scatters, intervals, is_effective, is_right,
    names_what_scatters,
};
use super::trial::over_floor;
use super::variant::Variant;

/// Every row.
pub(super) fn rows(records: &[Record], oracle: &Oracle) -> Vec<Row> {
    let mut rows = Vec::from(nothing_hidden(records));
    rows.extend(one_hidden(records));
    rows.extend(others_hidden(records));
    rows.extend(on_rough_rigs(records));
    rows.extend(what_scatters(records));
    rows.extend(numbers(records));
    rows.extend(told_otherwise(records));
    rows.push(told_sizes(records, oracle));
    rows.push(measured_sizes(records));
    rows.push(time(records));
    rows
}

/// Marks of what should not be, and of what always should.
const RARE: (&str, Mark) = ("≤ 5 %", Mark::AtMost(0.05));
const SELDOM: (&str, Mark) = ("≤ 10 %", Mark::AtMost(0.1));
const ALWAYS: (&str, Mark) = ("always", Mark::AtLeast(1.0));

fn of(records: &[Record], family: Family) -> impl Iterator<Item = &Record> + Clone {
    records.iter().filter(move |record| record.family == family)
}

fn is_wrong(record: &Record) -> (String, bool) {
    (line(record), !Score::of(record).wrong.is_empty())
}

fn is_found(record: &Record) -> (String, bool) {
    (line(record), Score::of(record).is_all_found())
}

fn nothing_hidden(records: &[Record]) -> [Row; 4] {
    let wrong = |base: &str, family: Family| {
        let figure = format!("a wrong name where nothing is hidden, {base}");
        row(&figure, RARE, of(records, family).map(is_wrong))
    };
    let verdict = |record: &Record| record.outcome.answer().map(|answer| answer.verdict);
    let nothing = of(records, Family::Nothing);
    let unexplained = nothing.clone().map(|record| {
        let is_unexplained = verdict(record) == Some(Verdict::Unexplained);
        (line(record), is_unexplained || verdict(record).is_none())
    });
    let none = nothing.map(|record| (line(record), verdict(record) == Some(Verdict::NoneFound)));
    [
        wrong("right base", Family::Nothing),
        wrong("the thesis' ellipsoid", Family::Ellipsoid),
        row(
            "something unexplained where nothing is hidden, right base",
            ("≤ 5 % (own mark)", RARE.1),
            unexplained,
        ),
        Row {
            standing: None,
            ..row("no hint either where nothing is hidden, right base", ("no mark", ALWAYS.1), none)
        },
    ]
}

fn one_hidden(records: &[Record]) -> [Row; 5] {
    let single = |times: f64| {
        of(records, Family::Single).filter(move |record| record.multiple == Some(times))
    };
    let nearly_always = ("≥ 97 %", Mark::AtLeast(0.97));
    let wrong = single(2.0).chain(single(4.0)).map(is_wrong);
    [
        row(
            "right class named at 2× the nameable size",
            ("≥ 90 %", Mark::AtLeast(0.9)),
            single(2.0).map(is_found),
        ),
        row("right class named at 4× the nameable size", nearly_always, single(4.0).map(is_found)),
        row("a wrong name beside or instead, at 2× and 4×", SELDOM, wrong),
        row(
            "right class named at typical sizes",
            nearly_always,
            of(records, Family::Typical).map(is_found),
        ),
        row(
            "a wrong name beside or instead, at typical sizes",
            SELDOM,
            of(records, Family::Typical).map(is_wrong),
        ),
    ]
}

fn others_hidden(records: &[Record]) -> [Row; 9] {
    let (pairs, outside) = (of(records, Family::Pair), of(records, Family::Outside));
    let is_large = |record: &&Record| record.visibility.is_some_and(|size| size >= LARGE);
    let narrow = of(records, Family::Narrow);
    let claims_one = |record: &Record| {
        let answer = record.outcome.answer();
        (line(record), answer.is_none_or(|answer| !answer.identified.is_empty()))
    };
    [
        row(
            "both of a pair found at 4×",
            ("≥ 85 %", Mark::AtLeast(0.85)),
            pairs.clone().map(is_found),
        ),
        row("extra names beside a pair", SELDOM, pairs.map(is_wrong)),
        row(
            "outside the catalogue, 0.6 of the noise or more: what is left comes most from where it does",
            ("≥ 80 %", Mark::AtLeast(0.8)),
            outside.clone().filter(is_large).map(|record| (line(record), finds_origin(record))),
        ),
        row("outside the catalogue: a wrong name", SELDOM, outside.map(is_wrong)),
        row(
            "narrow design, where a documented look-alike explains what is hidden as well: a single name claimed",
            RARE,
            narrow.clone().filter(|record| !record.alike.is_empty()).map(claims_one),
        ),
        row("narrow design: a wrong name claimed", RARE, narrow.map(is_wrong)),
        row(
            "untestable effects called untestable",
            ("100 %", Mark::AtLeast(1.0)),
            of(records, Family::Untestable).map(as_asked),
        ),
        row(
            "supports, caught tips and heights of the simulator: right class named",
            ("≥ 97 %", Mark::AtLeast(0.97)),
            of(records, Family::Supports).map(is_found),
        ),
        row("the same: a wrong name", RARE, of(records, Family::Supports).map(is_wrong)),
    ]
}

fn on_rough_rigs(records: &[Record]) -> [Row; 5] {
    let (nothing, typical) = (of(records, Family::Rough), of(records, Family::RoughTypical));
    let no_mark = |figure: &str, is: fn(&Record) -> (String, bool)| Row {
        standing: None,
        ..row(figure, ("no mark", ALWAYS.1), typical.clone().map(is))
    };
    let lowers = |record: &Record| Some((line(record), record.fresh? < 1.0));
    [
        row("rough rigs, nothing hidden: a wrong name", RARE, nothing.map(is_wrong)),
        row(
            "rough rigs, typical sizes: a wrong name beside or instead",
            RARE,
            typical.clone().map(is_wrong),
        ),
        no_mark("rough rigs, typical sizes: right class named", is_found),
        no_mark("rough rigs, typical sizes: named, or told to lower the error", |record| {
            (line(record), record.truth.iter().all(|one| is_effective(record, &one.id)))
        }),
        row(
            "what is claimed lowers the error on fresh pushes of the same rig",
            ("≥ 95 %", Mark::AtLeast(0.95)),
            records.iter().filter_map(lowers),
        ),
    ]
}

fn what_scatters(records: &[Record]) -> [Row; 3] {
    let all = of(records, Family::Scattered);
    let told = |record: &Record| {
        let answer = record.outcome.answer();
        let all = answer.map_or(&[][..], |answer| &answer.push_to_push).iter();
        let text = |one: &PushScatter| {
            let PushScatter { effect, sd, low95, high95, share, .. } = one;
            format!("{effect} {sd:.2e} ({low95:.2e} to {high95:.2e}), {:.0} %", 100.0 * share)
        };
        format!("`{}`: {}", record.case, all.map(text).collect::<Vec<_>>().join("; "))
    };
    [
        row(
            "scatter from push to push: the right quantity told to scatter most",
            ("≥ 85 %", Mark::AtLeast(0.85)),
            all.clone().map(|record| (told(record), names_what_scatters(record))),
        ),
        row(
            "its 90 % interval holds the truth",
            ("85–95 %", Mark::Within(0.85, 0.95)),
            all.clone().map(|record| (told(record), holds_what_scatters(record))),
        ),
        row("scatter from push to push: a wrong name", RARE, all.map(is_wrong)),
    ]
}

/// Change of a step's numbers over the noise, from which something is large.
const LARGE: f64 = 0.6;

fn numbers(records: &[Record]) -> [Row; 4] {
    let families = [Family::Single, Family::Typical, Family::Pair];
    let claimed = families.into_iter().flat_map(|family| of(records, family));
    [
        row(
            "95 % intervals that hold the truth",
            ("92–98 %", Mark::Within(0.92, 0.98)),
            claimed.flat_map(intervals),
        ),
        gap_closed(records),
        error_left(records),
        row(
            "a wrong effect added by hand closes at most 20 %",
            ALWAYS,
            of(records, Family::WrongEffect).flat_map(by_hand),
        ),
    ]
}

/// The same sets told or asked otherwise.
fn told_otherwise(records: &[Record]) -> Vec<Row> {
    let wrong = Variant::WRONG.into_iter().filter_map(|variant| {
        let effect = variant.effect()?;
        let figure = format!("{}: the verdict gains {effect} alone", variant.name());
        let wrong = of(records, Family::WrongNominal).filter(|record| record.about != effect);
        Some(row(&figure, ALWAYS, wrong.filter_map(|record| gains(record, variant))))
    });
    let mut rows: Vec<Row> = wrong.collect();
    rows.extend(Variant::SAME.map(|variant| {
        let same = of(records, Family::Robust).filter_map(|record| is_same(record, variant));
        let mark = ("≥ 90 % (own mark)", Mark::AtLeast(0.9));
        row(&format!("the same verdict with {}", variant.name()), mark, same)
    }));
    let shuffled = of(records, Family::Robust).filter_map(claims_shuffled);
    rows.push(row("shuffled control: an effect is claimed", RARE, shuffled));
    rows
}

fn line(record: &Record) -> String {
    format!("`{}`: {}", record.case, record.outcome.text())
}

fn as_asked(record: &Record) -> (String, bool) {
    (line(record), is_right(record))
}

/// Errors over the floor before and after, where the model under test misses something.
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

fn gains(record: &Record, variant: Variant) -> Option<(String, bool)> {
    let outcome = record.variants.get(&variant)?;
    let pair = record.outcome.answer().zip(outcome.answer());
    let gains = pair.is_some_and(|(right, wrong)| {
        let mut expected = right.claimed();
        expected.extend(variant.effect());
        // What the rig has in every set is no gain.
        let differ = expected.symmetric_difference(&wrong.claimed()).copied().collect::<Vec<_>>();
        differ.iter().all(|id| *id == super::score::ALWAYS)
    });
    Some((format!("{}; with the wrong one {}", line(record), outcome.text()), gains))
}

fn is_same(record: &Record, variant: Variant) -> Option<(String, bool)> {
    let outcome = record.variants.get(&variant)?;
    let pair = record.outcome.answer().zip(outcome.answer());
    let same = pair.is_some_and(|(one, other)| one.verdict() == other.verdict());
    Some((format!("{}; then {}", line(record), outcome.text()), same))
}

fn claims_shuffled(record: &Record) -> Option<(String, bool)> {
    let outcome = record.variants.get(&Variant::Shuffled)?;
    let claims = outcome
        .answer()
        .is_none_or(|answer| answer.verdict().iter().any(|id| *id != super::score::ALWAYS));
    Some((format!("{}; shuffled {}", line(record), outcome.text()), claims))
}

fn told_sizes(records: &[Record], oracle: &Oracle) -> Row {
    let near = |one: &super::detectable::Detectable| {
        let ratio = one.told / one.oracle;
        let line = format!("{}: told {:.2} of the oracle's", one.id, ratio);
        (line, (0.8..=1.25).contains(&ratio))
    };
    let found = detectable(records, oracle);
    let mark = ("every effect", ALWAYS.1);
    row("told smallest detectable size within 1.25× of the oracle's", mark, found.iter().map(near))
}

fn measured_sizes(records: &[Record]) -> Row {
    let known = effects::tested().iter().map(|effect| effect.info().id);
    let near = known.filter_map(|id| {
        let power = Power::of(records, Some(id));
        // Where the share grows is not known without trials below and above.
        if [1.0, 2.0].iter().any(|multiple| power.at(*multiple).of == 0) {
            return None;
        }
        let size = power.nine_in_ten();
        let line = match size {
            Some(size) => format!("{id}: nine in ten at {size:.2} of the nameable size"),
            None => format!("{id}: not nine in ten at any size"),
        };
        Some((line, size.is_some_and(|size| size <= 1.5)))
    });
    let mark = ("every effect", ALWAYS.1);
    row("nine in ten found from 1.5× the nameable size on", mark, near)
}

fn time(records: &[Record]) -> Row {
    // Narrow pushes are short.
    let is_timed =
        |record: &&Record| record.outcome.answer().is_some() && record.family != Family::Narrow;
    let times = records.iter().filter(is_timed);
    let times = times.map(|record| (format!("`{}`", record.case), record.seconds)).collect();
    let what = ("time of a diagnosis on one core, in s, median", "≤ 5 on two", Mark::AtMost(10.0));
    median_row(what, times)
}
