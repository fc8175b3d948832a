//! Figure M.11: a pushed object followed by rare and poor motion capture, or by the force alone.

mod filters;
mod found;
mod task;

use anyhow::{Context, Result};
use models::{PushModel, RecordedPush, RollOutSettings, StepCorrelation, StepErrors};
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};
use report::Figure;

use self::filters::{FILTERS, Filter, Followed};
use self::found::Found;
use self::task::{Task, Tasks};
use super::ends::recorded_settings;
use super::pushes::turns;
use super::trained::{Learnt, learn};
use crate::figures::inputs::{Inputs, SEED};
use crate::figures::sketch::Sketch;

const N_PARTICLES: usize = 500;
/// The motion that filters have: learnt, and of mechanics.
const MODELS: [&str; 2] = ["analytical", "gp"];

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let found = found(inputs, &MODELS, &FILTERS.iter().collect::<Vec<_>>())?;
    let panels = Found::panels(&found);
    let figure = Figure::new(panels.len().div_ceil(2), 2).panel_size(420.0, 260.0).one_legend();
    let figure = panels.into_iter().fold(figure, Figure::with);
    let told: Vec<String> = found.iter().map(Found::in_words).collect();
    let n_of = |task: Task| {
        found.iter().find(|found| found.name.1 == task).map_or(0, |found| found.n_pushes)
    };
    let (n, n_felt) = (n_of(Task::Capture), n_of(Task::Force));
    let unfelt = match n - n_felt {
        0 => String::new(),
        n => format!(" ({n} of the pushes have no force whose zero is known and are left out)"),
    };
    let caption = format!(
        "{n} held-out pushes, followed step by step. Above: a pose after every third step, as motion capture \
         that is a hundred times as noisy as the recordings' would report it (2 mm and 2.3°). Below: no \
         camera, the contact force alone, of an object that was laid down turned by 5.7°{unfelt}. Each filter has \
         the process learnt from other pushes as its motion, or the fitted mechanics, whose steps share errors \
         as other pushes showed. Left: root mean square error over all steps; right: steps whose measured \
         pose is within the filter's 90 % region. Place in mm, angle in degrees, share within, and with motion \
         capture the log evidence in nats: {}.",
        told.join("; ")
    );
    let alt = "Errors and shares within 90 % regions of ten filters, with motion capture and with force alone.";
    let data: Vec<_> = found.iter().map(Found::numbers).collect();
    Ok(Sketch::new(figure, serde_json::Value::Array(data), &caption, alt))
}

/// Filters on every task with models of these names, over all turns of the pushes.
fn found(inputs: &Inputs, models: &[&str], filters: &[&Filter]) -> Result<Vec<Found>> {
    let pushes = inputs.whole_pushes()?;
    let setting = inputs.setting()?;
    let tasks = Tasks::of(inputs.table()?, setting.friction);
    let mut all: Vec<Found> = Vec::new();
    for turn in turns(&pushes) {
        for learnt in learn(&setting, &turn, models)? {
            let Learnt { trained, correlation } = learnt;
            let table = trained.model.as_processes().map(|model| model.tabulated()).transpose()?;
            let model: &dyn PushModel = match &table {
                Some((table, _)) => table,
                None => trained.model.as_ref(),
            };
            for task in Task::ALL {
                let own = of_turn(model, &correlation, (&tasks, task), filters, &turn.test)?;
                for (filter, followed) in filters.iter().zip(own) {
                    if followed.is_empty() {
                        continue;
                    }
                    let name = (trained.name, task, filter.name);
                    let known = all.iter_mut().find(|found| found.name == name);
                    match known {
                        Some(found) => found.add(&followed),
                        None => all.push(Found::new(name, &followed)),
                    }
                }
            }
        }
    }
    Ok(all)
}

/// What filters make of some pushes.
fn of_turn(
    model: &dyn PushModel,
    correlation: &StepCorrelation,
    (tasks, task): (&Tasks, Task),
    filters: &[&Filter],
    pushes: &[&RecordedPush],
) -> Result<Vec<Vec<Followed>>> {
    let settings = RollOutSettings {
        n_particles: N_PARTICLES,
        seed: SEED,
        errors: StepErrors::Held(correlation.clone()),
        start_sd: task.start_sd(),
        ..recorded_settings(correlation.gap)
    };
    let by_push: Vec<Vec<Followed>> = pushes
        .par_iter()
        .enumerate()
        .filter_map(|(number, push)| Some((push, tasks.seen(task, push, number)?)))
        .map(|(push, seen)| {
            let follow = |filter: &&Filter| {
                let followed = filter.follow(model, &settings, push, &seen);
                followed.with_context(|| format!("{} on {}", filter.name, push.name))
            };
            filters.iter().map(follow).collect()
        })
        .collect::<Result<_>>()?;
    let of_filter = |k: usize| by_push.iter().map(|push| push[k].clone()).collect();
    Ok((0..filters.len()).map(of_filter).collect())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use dataset::{Flags, Table};
    use fixtures::workspace_root;

    use super::found;
    use super::found::Found;
    use super::task::{Task, Tasks};
    use crate::figures::inputs::Inputs;

    /// Of numbers on the page: the arithmetic of other machines, and the last digit that is written.
    const WITHIN: f64 = 0.05;

    /// Of those that take little time, with the model that does.
    const MODEL: &str = "analytical";
    const TESTED: [&str; 6] = [
        "none",
        "particles",
        "thesis' weights",
        "Rao–Blackwellised",
        "unscented",
        "unscented, smoothed",
    ];

    #[test]
    fn the_page_has_the_numbers_of_a_run_and_filters_keep_what_they_promise() {
        let filters: Vec<_> =
            super::FILTERS.iter().filter(|filter| TESTED.contains(&filter.name)).collect();
        let found = found(&Inputs::fixtures(true).unwrap(), &[MODEL], &filters).unwrap();
        let page = fs::read_to_string(workspace_root().join("docs/estimation.md")).unwrap();
        let table = Found::table(&found);
        assert_eq!(table.len(), TESTED.len());
        for expected in table {
            let (name, _) = expected[2..].split_once('|').unwrap();
            let is_same = |row: &str| {
                let (one, other) = (numbers(row), numbers(&expected));
                let is_near = |(a, b): (&f64, &f64)| (a - b).abs() <= WITHIN * (1.0 + b.abs());
                row.starts_with(&format!("| {name}|"))
                    && one.len() == other.len()
                    && one.iter().zip(&other).all(is_near)
            };
            assert!(page.lines().any(is_same), "the page lacks\n{expected}");
        }
        let of = |task: &str, filter: &str| {
            let is_it = |one: &&Found| one.name.1.id() == task && one.name.2 == filter;
            found.iter().find(is_it).unwrap()
        };
        for filter in ["particles", "Rao–Blackwellised"] {
            assert!(of("capture", filter).place_mm() < of("capture", "none").place_mm());
            assert!(of("force", filter).angle_deg() < 0.5 * of("force", "none").angle_deg());
        }
        // Weights by a particle's own density count it twice.
        let [weighed, plain] =
            ["thesis' weights", "particles"].map(|filter| of("capture", filter).share());
        assert!(weighed < plain - 0.2, "{weighed} {plain}");
        // What comes later tells of what was before.
        let [one, later] = ["unscented", "unscented, smoothed"].map(|filter| of("capture", filter));
        assert!(later.place_mm() < one.place_mm() && later.angle_deg() < one.angle_deg());
    }

    #[test]
    fn a_push_whose_force_has_no_known_zero_is_followed_by_motion_capture_alone() {
        let inputs = Inputs::fixtures(true).unwrap();
        let pushes = inputs.whole_pushes().unwrap();
        let friction = inputs.setting().unwrap().friction;
        let table = inputs.table().unwrap();
        let untared = |name: &str| {
            let rows = table.rows.iter().cloned().map(|mut row| {
                if format!("{}#{}", row.recording, row.push) == name {
                    row.flags |= Flags::UNTARED;
                }
                row
            });
            Table { rows: rows.collect(), provenance: table.provenance.clone() }
        };
        let tasks = Tasks::of(&untared(&pushes[1].name), friction);
        let is_seen = |task: Task, k: usize| tasks.seen(task, &pushes[k], k).is_some();
        assert_eq!([0, 1, 2].map(|k| is_seen(Task::Force, k)), [true, false, true]);
        assert!(is_seen(Task::Capture, 1));
    }

    /// The numbers in the cells of a row.
    fn numbers(row: &str) -> Vec<f64> {
        let words = row.split('|').skip(2).flat_map(str::split_whitespace);
        words.filter_map(|word| word.replace('−', "-").parse().ok()).collect()
    }
}
