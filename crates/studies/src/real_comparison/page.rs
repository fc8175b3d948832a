//! `docs/real-data.md`: the comparison in words and tables.

use std::fmt::Write;

use anyhow::{Context, Result};
use diagnosis::{Comparison, Diagnosis, FloorSource, PushEnds, Spread};

use super::corner::{Corner, Errors, N_EXCHANGES, NUMBERS};
use super::source::{Compared, Fitted};

/// How a section begins.
const HEADING: &str = "\n## ";

/// What a diagnosis claims: what is identified in bold, then what is ambiguous and what is effective.
pub(super) fn claimed(found: &Diagnosis) -> String {
    let identified = found.identified.iter().map(|id| format!("**`{id}`**"));
    let groups = found.ambiguous.iter().map(|group| format!("one of `{}`", group.join("`, `")));
    let effective = found.effective.iter().map(|id| format!("`{id}`"));
    let all: Vec<String> = identified.chain(groups).chain(effective).collect();
    if all.is_empty() { "–".to_owned() } else { all.join(", ") }
}

/// The section about the one-step pushes.
pub(super) fn one_step_text(table: &Compared, corner: &Corner) -> String {
    let mut page = TABLE_HEAD.to_owned();
    page += &errors(table);
    page += &fitted(table.fitted.as_ref());
    page += "\nWhere it fails, with the share of the squared error; the nominal model\n\n";
    page += &findings(&table.nominal);
    page + &corner_text(corner)
}

/// The section about the raw pushes.
pub(super) fn raw_text(raw: &Compared) -> String {
    let mut page = RAW_HEAD.to_owned();
    page += &errors(raw);
    page += &ends(raw.ends.as_ref());
    page += "\nWhere it fails, with the share of the squared error; the nominal model\n\n";
    page + &findings(&raw.nominal)
}

/// The sections of a page, without its head.
pub(super) fn sections(page: &str) -> &str {
    page.find(HEADING).map_or("", |start| &page[start..])
}

/// The page with one section in place of that of the same heading, or at its end if there is none.
///
/// # Errors
/// A section without a heading.
pub(super) fn with(page: &str, section: &str) -> Result<String> {
    let heading = section.trim_start().lines().next().context("a section has a heading")?;
    let Some(start) = page.find(&format!("\n{heading}\n")) else {
        return Ok(format!("{page}{section}"));
    };
    let length = sections(&page[start + 1..]).len();
    Ok(format!("{}{section}{}", &page[..start], &page[page.len() - length..]))
}

pub(super) const HEAD: &str = "\
# The models on real pushes

Where the quasi-static model on an ellipsoid fails on public measurements of others, how much of that no
model could mend, and what models that learn make of the same pushes. This page and its picture are
written by

```text
cargo xtask real-comparison --data DIR
```

with `DIR` the folder of the public data, and every number on it is from that run (`--only` writes some
of its sections anew); the command in each section prints the same comparison (all of it with `--json`).
No row of the data is part of the project. Unless said otherwise, errors are observed less predicted,
root mean squares over steps; ± is a standard error that takes whole pushes for independent. Nominal is
what the presets say: pusher friction 0.25, uniform pressure.

How to get the data: *More than a million ways to be pushed* (Yu, Bauza, Fazeli & Rodriguez, 2016).
";

const TABLE_HEAD: &str = "
## The one-step pushes of the square

3000 pushes of the 90 mm steel square on plywood at 20 mm/s and 0.2 s, each one step of 4 mm.

```text
pushlab models init --preset mit-table -o nominal.toml
pushlab compare mit-push-table/table.csv --preset mit-table --model nominal.toml
```

";

const RAW_HEAD: &str = "
## Raw pushes at 100 mm/s

32 recordings of the same square, in steps of 50 ms, about 5 mm; those whose force zero is lost have no force.

```text
pushlab models init --preset mit-push -o nominal.toml
pushlab compare mit-push-raw --preset mit-push --step 50ms --model nominal.toml
```

";

/// A row for each number.
fn errors(compared: &Compared) -> String {
    let found = &compared.nominal;
    let mut text = format!(
        "{} steps of {} pushes, μp = {}{}.\n\n\
         | | error | floor (95 % interval) | bias | error²/variance |\n|---|---|---|---|---|\n",
        found.n_steps,
        found.n_pushes,
        compared.pusher_friction,
        if found.excluded.is_empty() {
            String::new()
        } else {
            format!("; rows excluded: {}", found.excluded)
        }
    );
    for error in &found.channels {
        let (per, unit) = people(error.unit);
        let floor = error.floor.map_or("–".to_owned(), |floor| {
            let [rms, low, high] = [floor.rms, floor.low95, floor.high95].map(|x| per * x);
            format!("{rms:.3} ({low:.3} to {high:.3})")
        });
        let nmse = error.nmse.map_or("–".to_owned(), |nmse| format!("{nmse:.3}"));
        let [rms, se, bias, bias_se] =
            [error.rms, error.rms_se, error.bias, error.bias_se].map(|x| per * x);
        let _ = writeln!(
            text,
            "| {} / {unit} | {rms:.3} ± {se:.3} | {floor} | {} ± {bias_se:.3} | {nmse} |",
            error.name,
            format!("{bias:+.3}").replace('-', "−"),
        );
    }
    let source = match found.floor.source {
        FloorSource::Repeats => "The floor is the scatter of repeated pushes.",
        FloorSource::Neighbours => {
            "Repeats are not known, so the floor is an estimate:\nhalf the mean square of the \
             difference between the residuals of nearest neighbours."
        }
    };
    let _ = writeln!(text, "\n{source}");
    if !found.not_asked.is_empty() {
        let _ = writeln!(text, "\nWhat these data cannot tell:\n");
    }
    for what in &found.not_asked {
        let _ = writeln!(text, "- {what}");
    }
    text
}

fn fitted(fitted: Option<&Fitted>) -> String {
    let Some(Fitted { comparison, parameters: [friction, length] }) = fitted else {
        return String::new();
    };
    let [value, se] = friction;
    let [c, c_se] = length.map(|x| 1e3 * x);
    let shown: Vec<String> = comparison
        .channels
        .iter()
        .map(|error| {
            let (per, unit) = people(error.unit);
            let nmse = error.nmse.map_or("none".to_owned(), |nmse| format!("{nmse:.3}"));
            let space = if unit == "°" { "" } else { " " };
            let size = format!("{:.3}{space}{unit}", per * error.rms);
            format!("{} {size} (error²/variance {nmse})", error.name)
        })
        .collect();
    format!(
        "\nFitted to every second row, μp = {value:.3} ± {se:.3} and c = {c:.2} ± {c_se:.2} mm. The error \
         on\nthe other half: {}.\n",
        shown.join(", ")
    )
}

fn findings(found: &Comparison) -> String {
    let mut text = String::new();
    for finding in &found.findings {
        let share = 100.0 * finding.share;
        let _ = writeln!(
            text,
            "- {} ({share:.0} %, {} steps of {} pushes)",
            finding.sentence, finding.n_steps, finding.n_pushes
        );
    }
    for gathered in &found.concentrations {
        let _ = writeln!(text, "- {}", gathered.sentence);
    }
    if text.is_empty() {
        let _ = writeln!(text, "- nowhere more than chance, in {} maps", found.maps.len());
    }
    text
}

fn corner_text(corner: &Corner) -> String {
    let (here, mirrored) = (&corner.here, &corner.mirrored);
    let mut text = format!(
        "\n### One corner and its mirror image\n\n\
         ![Root mean square error of the three outputs over p and β](real-data-corner.svg)\n\n\
         The nominal square, its pressure and its friction are symmetric, so a push at 1 − p with −β is\n\
         the mirror image of one at p with β, and the model should err alike on both.\n{}\n\
         By chance is how often steps exchanged at random between the two are as far apart ({N_EXCHANGES} \
         exchanges;\nsure: below 0.05/3, for there are three; that the corner was chosen among others is \
         not counted).\n\n\
         | | p > 0.8 and β > 0.3 rad, {} steps | mirror image, {} steps | ratio of mean squares | by chance |\n\
         |---|---|---|---|---|\n",
        symmetry(corner),
        here.n_steps,
        mirrored.n_steps
    );
    for (k, (_, sign, unit, _)) in NUMBERS.iter().enumerate() {
        let ratio = (here.rms[k] / mirrored.rms[k]).powi(2);
        let _ = writeln!(
            text,
            "| {sign} / {unit}, RMS (median of the size) | {:.2} ({:.2}) | {:.2} ({:.2}) | {ratio:.1} | {:.4} |",
            here.rms[k], here.median[k], mirrored.rms[k], mirrored.median[k], corner.chance[k]
        );
    }
    let shares: Vec<String> = NUMBERS
        .iter()
        .zip(corner.worst_hundredth)
        .map(|((_, sign, _, _), share)| format!("{:.0} % of {sign}'s", 100.0 * share))
        .collect();
    let _ = writeln!(
        text,
        "\nA hundredth of all pushes carries {} squared error.\n{}",
        shares.join(", "),
        few_or_all(here)
    );
    text
}

/// Whether the model errs alike on the corner and its mirror image.
fn symmetry(corner: &Corner) -> String {
    match named(|k| corner.chance[k] < 0.05 / 3.0) {
        Some(names) => format!("It does not, in {names}."),
        None => "Nothing shows that it does not: the differences may be chance.".to_owned(),
    }
}

/// Whether a few pushes fail or each a little: of normal errors the median of the size is 0.67 of the
/// root mean square.
fn few_or_all(errors: &Errors) -> String {
    let is_few = |k: usize| errors.median[k] < 0.5 * errors.rms[k];
    let rule = "of normal errors it is two thirds";
    match (named(is_few), named(|k| !is_few(k))) {
        (Some(few), None) => format!(
            "In the corner the median of the size is below half of the root mean square in {few} \
             ({rule}):\na few pushes fail, not each a little."
        ),
        (Some(few), Some(all)) => format!(
            "In the corner the median of the size is below half of the root mean square in {few} \
             ({rule}), where\na few pushes fail, not each a little; in {all} it is not."
        ),
        (None, _) => format!(
            "In the corner the median of the size is not below half of the root mean square ({rule}):\n\
             not a few pushes alone fail."
        ),
    }
}

/// The outputs of which something is so.
fn named(is_so: impl Fn(usize) -> bool) -> Option<String> {
    let names: Vec<&str> = (0..3).filter(|&k| is_so(k)).map(|k| NUMBERS[k].1).collect();
    (!names.is_empty()).then(|| names.join(" and "))
}

fn ends(ends: Option<&PushEnds>) -> String {
    let Some(PushEnds { position, angle, n_lost, pushes }) = ends else {
        return String::new();
    };
    let n = pushes.len();
    let line = |Spread { mean, median, p90 }: &Spread, per: f64, unit: &str| {
        let [mean, median, p90] = [mean, median, p90].map(|x| per * x);
        format!(
            "{mean:.2} {unit} on average, {median:.2} {unit} in half, {p90:.2} {unit} in nine of ten"
        )
    };
    format!(
        "\nRolled out from its measured start, the end of a push ({n} of them) is off by\n{},\nand by \
         {};\npushes that lose contact in the model alone: {n_lost}.\n",
        line(position, 1e3, "mm"),
        line(angle, 1.0_f64.to_degrees(), "°"),
    )
}

fn people(unit: &str) -> (f64, &str) {
    match unit {
        "m" => (1e3, "mm"),
        "rad" => (1.0_f64.to_degrees(), "°"),
        other => (1.0, other),
    }
}

#[cfg(test)]
mod tests {
    use super::{Corner, Errors, corner_text, sections, with};

    fn corner(chance: [f64; 3], median: [f64; 3]) -> Corner {
        let errors = |n_steps, rms| Errors { n_steps, rms, median };
        let (here, mirrored) = (errors(80, [0.9, 0.4, 0.8]), errors(70, [0.3, 0.3, 0.4]));
        Corner { here, mirrored, chance, worst_hundredth: [0.3, 0.2, 0.1] }
    }

    #[test]
    fn a_corner_that_differs_by_chance_is_not_told_to_differ() {
        let says = |chance: [f64; 3]| corner_text(&corner(chance, [0.1; 3]));
        assert!(says([0.001, 0.4, 0.01]).contains("It does not, in Δx and Δθ."));
        let text = says([0.02, 0.4, 0.3]);
        assert!(text.contains("Nothing shows that it does not") && !text.contains("It does not,"));
    }

    #[test]
    fn few_pushes_fail_only_where_the_median_says_so() {
        let says = |median: [f64; 3]| corner_text(&corner([0.5; 3], median));
        let few = says([0.2, 0.1, 0.3]);
        assert!(few.contains("in Δx and Δy and Δθ") && few.contains("a few pushes fail"), "{few}");
        let some = says([0.2, 0.3, 0.3]);
        assert!(some.contains("in Δx and Δθ (of") && some.contains("in Δy it is not"), "{some}");
        let all = says([0.6, 0.3, 0.5]);
        assert!(!all.contains("a few pushes fail") && all.contains("not a few pushes"), "{all}");
        assert!(![few, some, all].concat().contains("Nobody"));
    }

    const PAGE: &str = "# Head\n\nWords.\n\n## One\n\nold\n\n### Part\n\nold\n\n## Two\n\ntwo\n";

    #[test]
    fn a_section_takes_the_place_of_its_older_self() {
        let expected = "# Head\n\nWords.\n\n## One\n\nnew\n\n## Two\n\ntwo\n";
        assert_eq!(with(PAGE, "\n## One\n\nnew\n").unwrap(), expected);
        let expected = PAGE.replace("two", "new");
        assert_eq!(with(PAGE, "\n## Two\n\nnew\n").unwrap(), expected);
        assert_eq!(with(PAGE, "\n## Three\n").unwrap(), format!("{PAGE}\n## Three\n"));
        assert!(PAGE.ends_with(sections(PAGE)) && sections(PAGE).starts_with("\n## One"));
    }
}
