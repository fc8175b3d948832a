//! Tick positions that people like to read, and their labels.

/// Labelled and unlabelled tick positions of one axis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Ticks {
    pub(crate) major: Vec<(f64, String)>,
    pub(crate) minor: Vec<f64>,
}

/// More ticks than this nobody reads; rounding of tiny or huge ranges may ask for them.
const MOST: i64 = 64;

/// Ticks at multiples of 1, 2 or 5 times a power of ten, at most `limit` (but at least 2) wide; a
/// range that is too narrow for numbers between its ends has a tick at each end.
pub(crate) fn linear(low: f64, high: f64, limit: f64) -> Ticks {
    // Halves first: the width of the widest range is no number.
    let raw = 2.0 * ((0.5 * high - 0.5 * low) / limit.max(1.0));
    if !(raw.is_normal() && raw > 4.0 * f64::EPSILON * low.abs().max(high.abs())) {
        return ends(low, high);
    }
    let mut exponent = raw.log10().floor() as i32;
    let lead = raw / 10f64.powi(exponent);
    let factor = match lead {
        lead if lead <= 1.0 + 1e-9 => 1.0,
        lead if lead <= 2.0 + 1e-9 => 2.0,
        lead if lead <= 5.0 + 1e-9 => 5.0,
        _ => {
            exponent += 1;
            1.0
        }
    };
    let step = factor * 10f64.powi(exponent);
    let (first, last) = ((low / step - 1e-6).ceil() as i64, (high / step + 1e-6).floor() as i64);
    if last.saturating_sub(first) >= MOST {
        return ends(low, high);
    }
    let reach = low.abs().max(high.abs());
    // Dividing by the exact power of ten keeps 0.3 from becoming 0.30000000000000004.
    let at = |i: i64| {
        let lead = i as f64 * factor;
        if exponent < 0 { lead / 10f64.powi(-exponent) } else { lead * 10f64.powi(exponent) }
    };
    let major = (first..=last).map(|i| (at(i), label(at(i), exponent, reach))).collect();
    Ticks { major, minor: Vec::new() }
}

/// A tick at each end of a range.
fn ends(low: f64, high: f64) -> Ticks {
    let tick = |value: f64| (value, minus(&format!("{value:e}")));
    Ticks { major: vec![tick(low), tick(high)], minor: Vec::new() }
}

/// Ticks at powers of ten, or at 1, 2 and 5 times them where there are few; 2 to 9 between.
pub(crate) fn logarithmic(low: f64, high: f64, limit: f64) -> Ticks {
    let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
    let inside = |value: &f64| (low * (1.0 - 1e-9)..=high * (1.0 + 1e-9)).contains(value);
    let all = |leads: &[f64], every: i32| -> Vec<f64> {
        (first..=last)
            .filter(|exponent| exponent.rem_euclid(every) == 0)
            .flat_map(|exponent| leads.iter().map(move |lead| scaled(*lead, exponent)))
            .filter(inside)
            .collect()
    };
    let every = (f64::from(last - first) / limit.max(1.0)).ceil().max(1.0) as i32;
    let mut major = all(&[1.0], every);
    for leads in [&[1.0, 2.0, 5.0][..], &[1.0, 3.0], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0]] {
        if major.len() < 3 {
            let finer = all(leads, 1);
            if finer.len() as f64 <= limit.max(2.0) + 1.0 {
                major = finer;
            }
        }
    }
    if major.len() < 2 {
        return linear(low, high, limit);
    }
    let minor = all(&[2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0], 1);
    Ticks { major: major.into_iter().map(|v| (v, logarithmic_label(v))).collect(), minor }
}

fn scaled(lead: f64, exponent: i32) -> f64 {
    if exponent < 0 { lead / 10f64.powi(-exponent) } else { lead * 10f64.powi(exponent) }
}

fn logarithmic_label(value: f64) -> String {
    let exponent = (value.log10() + 1e-9).floor() as i32;
    if (-2..=3).contains(&exponent) {
        return minus(&format!("{:.*}", (-exponent).max(0) as usize, value));
    }
    let lead = (value / 10f64.powi(exponent)).round();
    if lead == 1.0 {
        return format!("10{}", superscript(exponent));
    }
    format!("{lead}×10{}", superscript(exponent))
}

/// A tick value at a resolution of `10^exponent` on an axis that reaches to `reach`.
fn label(value: f64, exponent: i32, reach: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if (1e-3..1e5).contains(&reach) && exponent >= -5 {
        return minus(&format!("{:.*}", (-exponent).max(0) as usize, value));
    }
    let power = (reach.log10() + 1e-9).floor() as i32;
    let decimals = (power - exponent).max(0) as usize;
    let lead = format!("{:.*}", decimals, value / 10f64.powi(power));
    format!("{}×10{}", minus(&lead), superscript(power))
}

fn minus(text: &str) -> String {
    text.replace('-', "\u{2212}")
}

fn superscript(exponent: i32) -> String {
    let raise = |c| match c {
        '-' => '⁻',
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        _ => '⁹',
    };
    exponent.to_string().chars().map(raise).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::{ProptestConfig, proptest};

    use super::{Ticks, linear, logarithmic};

    fn labels(ticks: &Ticks) -> Vec<&str> {
        ticks.major.iter().map(|(_, label)| label.as_str()).collect()
    }

    #[test]
    fn known_axes_get_the_ticks_a_person_would_draw() {
        assert_eq!(labels(&linear(0.0, 1.0, 5.0)), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(&linear(-0.61, 0.61, 5.0)), ["−0.5", "0", "0.5"]);
        assert_eq!(labels(&linear(0.0, 4e-4, 2.0)), ["0", "2×10⁻⁴", "4×10⁻⁴"]);
        assert_eq!(labels(&linear(0.0, 250.0, 6.0)), ["0", "50", "100", "150", "200", "250"]);
        assert_eq!(labels(&logarithmic(1.0, 1000.0, 6.0)), ["1", "10", "100", "1000"]);
        assert_eq!(labels(&logarithmic(1e-6, 1e-3, 6.0)), ["10⁻⁶", "10⁻⁵", "10⁻⁴", "10⁻³"]);
        assert_eq!(labels(&logarithmic(20.0, 400.0, 6.0)), ["20", "50", "100", "200"]);
    }

    #[test]
    fn ranges_at_the_ends_of_what_numbers_can_be_have_few_ticks() {
        for (low, high) in [
            (0.0, 1e-307),
            (-1e-307, 1e-307),
            (0.0, 5e-324),
            (1e-320, 2e-320),
            (1.0, 1.0 + 1e-15),
            (1e16, 1e16 + 2.0),
            (-1e300, 1e300),
            (-f64::MAX, f64::MAX),
            (0.0, f64::MAX),
        ] {
            let ticks = linear(low, high, 6.0).major;
            assert!((2..=12).contains(&ticks.len()), "{low} {high}: {}", ticks.len());
            for (value, label) in ticks {
                // As in the law of all ranges: powers of ten are rounded.
                let slack = 1e-5 * (0.5 * high - 0.5 * low);
                assert!((low - slack..=high + slack).contains(&value), "{low} {high}: {value}");
                assert!(!label.is_empty() && label.len() < 40, "{low} {high}: {label}");
            }
        }
        for (low, high) in [(5e-324, 1e-307), (1e-307, 2e-307), (1e-300, 1e300), (1e-320, 1.0)] {
            let ticks = logarithmic(low, high, 6.0);
            assert!((2..=12).contains(&ticks.major.len()), "{low} {high}");
            assert!(ticks.minor.len() < 10_000, "{low} {high}");
            for (value, label) in ticks.major {
                assert!(value.is_finite() && label.len() < 40, "{low} {high}: {value} {label}");
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(512))]

        #[test]
        fn linear_ticks_are_few_even_round_inside_and_distinct(
            low in -1e3..1e3f64, width_exponent in -6.0..6.0f64, limit in 3.0..9.0f64,
        ) {
            let high = low + 10f64.powf(width_exponent);
            let ticks = linear(low, high, limit).major;
            let slack = 1e-5 * (high - low);
            assert!(!ticks.is_empty() && ticks.len() as f64 <= limit + 1.0);
            assert!(ticks.iter().all(|(v, _)| (low - slack..=high + slack).contains(v)));
            for pair in ticks.windows(2) {
                let step = pair[1].0 - pair[0].0;
                let lead = step / 10f64.powf((step.log10() + 1e-6).floor());
                assert!([1.0, 2.0, 5.0].iter().any(|nice| (lead - nice).abs() < 1e-3), "{lead}");
                assert!(width_exponent < -2.0 || pair[0].1 != pair[1].1, "{}", pair[0].1);
            }
        }

        #[test]
        fn logarithmic_ticks_lie_inside(low_exponent in -8.0..5.0f64, decades in 0.05..9.0f64) {
            let (low, high) = (10f64.powf(low_exponent), 10f64.powf(low_exponent + decades));
            let ticks = logarithmic(low, high, 6.0);
            assert!(!ticks.major.is_empty() && ticks.major.len() <= 8);
            for value in ticks.major.iter().map(|(v, _)| v).chain(&ticks.minor) {
                assert!(*value >= low * 0.999_99 && *value <= high * 1.000_01);
            }
        }
    }
}
