//! The page that the trials are told on.

use std::collections::BTreeSet;

use super::case::FIRST_REPORTED_SEED;
use super::confusion::confusion;
use super::detectable::detectable;
use super::oracle::{Oracle, SetupSizes};
use super::power::Power;
use super::record::{Outcome, Record};
use super::row::{Row, Standing};
use super::rows::rows;

/// Everything that the page tells.
pub(super) struct Page<'a> {
    pub(super) seed: u64,
    pub(super) n_planned: usize,
    /// Trials whose sizes are out of range, and why.
    pub(super) impossible: &'a [(String, String)],
    pub(super) records: &'a [Record],
    pub(super) oracle: &'a Oracle,
}

/// Lines of a list before it is cut short.
const MOST_LINES: usize = 40;

/// Correlation from which effects are told as alike.
const ALIKE: f64 = 0.9;

const INTRODUCTION: &str = "\
# How often the diagnosis is right

Recording sets of the simulator `plant`, with a truth that is sealed in another folder: the diagnosis
gets recordings, manifest and model alone, and a separate scorer opens the truth afterwards. The
simulator shares no formula with the models. Every trial is a process of its own; a crash, an error
and a time-out count as wrong.

**Sizes** come from the simulator alone. The same pushes are simulated with and without the effect;
the differences of poses and forces are whitened with the noise that the simulator's settings state
(of the sensors, and of what scatters from push to push and between sessions) and cleared of what other
frictions and another spread of the pressure would do. *Detectable* is the size that a test at 0.01/23 finds nine
times in ten on three quarters of the pushes. *Nameable* is the largest of that, of the size that
changes a number of a step by 0.3 of its noise, and of twice what a manifest leaves open: smaller
effects are significant, and by design not named. Multiples are of the nameable size, typical sizes
those of `plant`.

A square is pushed, and a triangle, an ellipse and an L as well where nothing is hidden and on rough rigs: the
simulator's profile `rough` and those of four published surfaces, with 120 pushes or 400. There sizes are
typical ones.

**Right** is the hidden effect's name, or a group of at most three of which all are documented look-alikes of
it. On the thesis' ellipsoid `limit-surface-shape` is right beside anything. `inertia` is never wrong: the
simulated rig has it in every set, and fast pushes show it. Friction, pressure, place of contact and zero
of the force sensor scatter from push to push and, in most sets, from session to session, and a rough table
rubs more in one place than in another: what the pushes of a set share for that reason, as the mean friction
where they took place, is no hidden effect, and right where it is named and the intervals (1.22 times as wide,
for there may be three) hold it. What rough rigs have in every set is never wrong there: an
uneven support and what follows from it, friction that differs over the table, corners that are worn, a gap
before the contact, a height of the push, friction of the tip and a zero of the force sensor that change; on
the surfaces friction that falls, on rubber a grain and a rate. Outside the catalogue these say the same:
`pusher-compliance` of a tip that flexes, `support-friction`, `rate-dependent-friction` and `support-stiction`
of a film of liquid, `edge-rounding` of a chipped corner, `table-tilt` of a cable.

**Narrow** pushes are 15 mm long, at one place of the table, against one edge of an object that lies one way, at
one speed and within 10° of the normal; with and without force, four times the nameable size. What is hidden
there is *confounded* where a documented look-alike of some size leaves so little of it that the likelier of the
two would be the wrong one more often than once in twenty.

**A mark** *holds* if all of the 95 % interval (Wilson's) of the share keeps it, is *refuted* if none of
it does, and is *open* otherwise: not refuted, and not shown by so few trials. A median keeps its mark if
more than half of the values do, by the interval of that share. That something is always so no number of
trials shows; one exception refutes it.
";

impl Page<'_> {
    pub(super) fn text(&self) -> String {
        let rows = rows(self.records, self.oracle);
        let table: String = rows.iter().map(line).collect();
        let mut text = format!(
            "{INTRODUCTION}
```sh
cargo xtask diagnosis-trials --seed {}
```

{}

| figure | mark | measured (95 % interval) | |
|---|---|---|---|
{table}
",
            self.seed,
            self.run(),
        );
        text += &self.answers();
        text += &self.powers();
        text += &self.sizes();
        text += &failures(&rows);
        text += &self.left_out();
        text
    }

    fn run(&self) -> String {
        let kind = if self.seed < FIRST_REPORTED_SEED { "of development" } else { "reported" };
        let hours = self.records.iter().map(|record| record.seconds).sum::<f64>() / 3600.0;
        format!(
            "Seeds from {} on ({kind}). {} trials of a plan of {}, of which `--families` and \
             `--first` take a part and `--resume` goes on; the diagnoses alone took {hours:.1} hours.",
            self.seed,
            self.records.len(),
            self.n_planned,
        )
    }

    /// What was told of what was hidden.
    fn answers(&self) -> String {
        let mut text = "\n## What was told of what was hidden\n\nOf sizes of twice the nameable \
                        one and more.\n\n| hidden | told (times) |\n|---|---|\n"
            .to_owned();
        for (hidden, answers) in confusion(self.records) {
            let told: Vec<_> = answers.iter().map(|(told, n)| format!("{told} ({n})")).collect();
            text += &format!("| {hidden} | {} |\n", told.join("; "));
        }
        text
    }

    fn powers(&self) -> String {
        const MULTIPLES: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
        let mut text = "\n## Found by size\n\nShare found at multiples of the nameable size, and \
                        the multiple from which nine in ten are.\n\n\
                        | effect | 0.5× | 1× | 2× | 4× | nine in ten from |\n|---|---|---|---|---|---|\n"
            .to_owned();
        let known = effects::tested().iter().map(|effect| Some(effect.info().id));
        for id in std::iter::once(None).chain(known) {
            let power = Power::of(self.records, id);
            if power.0.is_empty() {
                continue;
            }
            let shares = MULTIPLES.map(|times| {
                let share = power.at(times);
                share
                    .value()
                    .map_or("–".to_owned(), |_| format!("{} of {}", share.hits, share.of))
            });
            let from = power.nine_in_ten().map_or("none".to_owned(), |size| format!("{size:.2}×"));
            text += &format!("| {} | {} | {from} |\n", id.unwrap_or("all"), shares.join(" | "));
        }
        text
    }

    /// The oracle's sizes, and what the tool told of them.
    fn sizes(&self) -> String {
        let setups: Vec<_> = self.oracle.setups().collect();
        let mut text = "\n## Sizes\n\nNameable ones, as shares of the typical size of `plant`, by what is pushed and \
                        measured; first what the noise, simulated again, is of what it should be.\n\n| effect |"
            .to_owned();
        setups.iter().for_each(|(name, _)| text += &format!(" {name} |"));
        text += &format!("\n|---|{}\n| *noise* |", "---|".repeat(setups.len()));
        setups.iter().for_each(|(_, found)| text += &format!(" *{:.2}* |", found.whitened_rms));
        text += "\n";
        let ids: BTreeSet<&String> = setups.iter().flat_map(|one| one.1.effects.keys()).collect();
        for id in ids {
            let size = |(_, found): &(&String, &SetupSizes)| {
                let known = found.effects.get(id);
                known.map_or(" – |".to_owned(), |sizes| format!(" {:.3} |", sizes.nameable()))
            };
            let of_setups: String = setups.iter().map(size).collect();
            text += &format!("| {id} |{of_setups}\n");
        }
        for (name, found) in &setups {
            let alike = found.correlations.iter().filter(|(.., one)| one.abs() >= ALIKE);
            let alike = alike.map(|(one, other, rho)| format!("{one} and {other} ({rho:.2})"));
            let alike = alike.collect::<Vec<_>>().join(", ");
            if !alike.is_empty() {
                text += &format!("\nAlike in {name}, at their typical proportions: {alike}.\n");
            }
        }
        text += "\nSmallest detectable sizes where nothing is hidden, medians; of sets of one session beside the oracle\n\
                 of sessions that are alike, for what its pushes share is in them:\n\n\
                 | effect | told | oracle | ratio |\n|---|---|---|---|\n";
        for one in detectable(self.records, self.oracle) {
            let ratio = one.told / one.oracle;
            text += &format!("| {} | {:.3} | {:.3} | {ratio:.2} |\n", one.id, one.told, one.oracle);
        }
        text
    }

    fn left_out(&self) -> String {
        let mut text = String::new();
        if !self.impossible.is_empty() {
            text += "\n## Not run\n\nSizes out of the effect's range.\n\n";
            text += &list(self.impossible.iter().map(|(case, why)| format!("`{case}`: {why}")));
        }
        let failed = self.records.iter().filter_map(|record| match &record.outcome {
            Outcome::Failed(why) => Some(format!("`{}`: {why}", record.case)),
            Outcome::Answer(_) => None,
        });
        let failed: Vec<String> = failed.collect();
        if !failed.is_empty() {
            text += "\n## Without an answer\n\n";
            text += &list(failed.into_iter());
        }
        text
    }
}

fn line(row: &Row) -> String {
    let standing = row.standing.map_or("", Standing::text);
    format!("| {} | {} | {} | {standing} |\n", row.figure, row.mark, row.measured)
}

fn failures(rows: &[Row]) -> String {
    let mut text =
        "\n## What spoke against the marks\n\n`cargo xtask diagnosis-trials --seed S --case NAME` \
                    runs one again and prints its answer.\n"
            .to_owned();
    for row in rows.iter().filter(|row| !row.failed.is_empty()) {
        text += &format!("\n{}:\n\n{}", row.figure, list(row.failed.iter().cloned()));
    }
    text
}

fn list(lines: impl ExactSizeIterator<Item = String>) -> String {
    let n = lines.len();
    let mut text: String = lines.take(MOST_LINES).map(|line| format!("- {line}\n")).collect();
    if n > MOST_LINES {
        text += &format!("- and {} more\n", n - MOST_LINES);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::INTRODUCTION;
    use crate::trials::row::Mark;
    use crate::trials::wilson::Share;
    use fixtures::workspace_root;

    /// The marks of the page in its own words.
    fn mark(text: &str) -> Option<Mark> {
        let percent =
            |text: &str| text.trim_end_matches(" %").parse::<f64>().map(|x| x / 100.0).ok();
        let text = text.split(" (").next()?;
        match text.split_once(' ') {
            Some(("≥", least)) => percent(least).map(Mark::AtLeast),
            Some(("≤", most)) => percent(most).map(Mark::AtMost),
            _ if ["always", "every effect", "100 %"].contains(&text) => Some(Mark::AtLeast(1.0)),
            _ => {
                let (least, most) = text.trim_end_matches(" %").split_once('–')?;
                Some(Mark::Within(percent(least)?, percent(most)?))
            }
        }
    }

    /// From `93 % (86 to 97, n = 96)`.
    fn share(text: &str) -> Option<Share> {
        let (percent, rest) = text.split_once(" % (")?;
        let of: usize = rest.split_once("n = ")?.1.trim_end_matches(')').parse().ok()?;
        let hits = (percent.parse::<f64>().ok()? / 100.0 * of as f64).round() as usize;
        Some(Share { hits, of }).filter(|share| share.text() == text)
    }

    #[test]
    fn what_the_committed_page_concludes_follows_from_its_numbers() {
        let page = std::fs::read_to_string(workspace_root().join(crate::trials::PAGE)).unwrap();
        assert!(page.starts_with(INTRODUCTION), "its introduction is another than the generator's");
        let mut n_judged = 0;
        for line in page.lines().filter(|line| line.starts_with("| ") && line.contains("n = ")) {
            let cells: Vec<&str> = line.trim_matches('|').split(" | ").map(str::trim).collect();
            let (text, measured, said) = (cells[1], cells[2], cells.get(3).copied().unwrap_or(""));
            let Some((mark, share)) = mark(text).zip(share(measured)) else { continue };
            assert_eq!(mark.standing(share).unwrap().text(), said, "{line}");
            n_judged += 1;
        }
        assert!(n_judged >= 20, "{n_judged}");
    }
}
