//! The verdict in numbers: motion and force before and after, what is left, and what to do next.

use ::report::Section;
use diagnosis::{Diagnosis, Grade};

use super::super::measure::{Measure, title};
use super::charts::numbers;

/// An error that is so many times its floor is not all noise.
const LEFT: f64 = 1.25;

pub(super) fn card(found: &Diagnosis, mut section: Section) -> Section {
    let (mut rows, mut left) = (Vec::new(), Vec::new());
    for (name, unit, [before, after], floor) in numbers(&found.error) {
        let measure = Measure::of(unit);
        let times = floor.filter(|floor| *floor > 0.0).map(|floor| after / floor);
        rows.push(vec![
            measure.label(title(name)),
            measure.number(before),
            measure.number(after),
            floor.map_or_else(|| "unknown".to_owned(), |floor| measure.number(floor)),
            times.map_or_else(|| "–".to_owned(), |times| format!("{times:.1}")),
        ]);
        if let Some(times) = times.filter(|times| *times >= LEFT) {
            left.push(format!("{} ({times:.1} times its floor)", title(name)));
        }
    }
    if !rows.is_empty() {
        let head = ["error of a step, RMS", "before", "after", "noise floor", "after over floor"];
        section = section.table(&head, rows);
    }
    let untold = found.effects.iter().filter(|one| one.grade == Grade::NotTestable);
    let untold: Vec<&str> = untold.map(|one| one.id.as_str()).collect();
    let mut lines = Vec::new();
    if !left.is_empty() {
        lines.push(format!("Still wrong: {}.", left.join(", ")));
    }
    if !untold.is_empty() {
        lines.push(format!("These pushes cannot tell: {}; why, below.", untold.join(", ")));
    }
    lines.extend(found.next.iter().map(|command| format!("Next: {command}")));
    if lines.is_empty() { section } else { section.list(lines) }
}
