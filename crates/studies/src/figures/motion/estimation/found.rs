//! How well filters followed pushes, as panels, in words, in rows and in numbers.

use report::{Axis, Color, Guide, Panel, Points};
use serde_json::json;

use super::filters::{FILTERS, Followed};
use super::task::Task;

/// The level of the regions.
const LEVEL: f64 = 0.9;
const MM: f64 = 1e3;

/// One filter on one task with one model.
pub(super) struct Found {
    /// The model, the task, the filter.
    pub(super) name: (&'static str, Task, &'static str),
    pub(super) n_pushes: usize,
    /// Of place in m² and of angle in rad², summed over steps.
    squares: [f64; 2],
    n_within: usize,
    n_steps: usize,
    log_evidence: f64,
}

impl Found {
    pub(super) fn new(name: (&'static str, Task, &'static str), followed: &[Followed]) -> Self {
        let (squares, n_within) = ([0.0; 2], 0);
        let mut found =
            Self { name, n_pushes: 0, squares, n_within, n_steps: 0, log_evidence: 0.0 };
        found.add(followed);
        found
    }

    pub(super) fn add(&mut self, followed: &[Followed]) {
        for push in followed {
            self.n_pushes += 1;
            self.log_evidence += push.log_evidence;
            for [place, turn, level] in &push.off {
                self.squares[0] += place * place;
                self.squares[1] += turn * turn;
                self.n_within += usize::from(*level <= LEVEL);
                self.n_steps += 1;
            }
        }
    }

    fn rms(&self, k: usize) -> f64 {
        (self.squares[k] / self.n_steps as f64).sqrt()
    }

    pub(super) fn place_mm(&self) -> f64 {
        MM * self.rms(0)
    }

    pub(super) fn angle_deg(&self) -> f64 {
        self.rms(1).to_degrees()
    }

    pub(super) fn share(&self) -> f64 {
        self.n_within as f64 / self.n_steps as f64
    }

    /// Evidence that can be compared: densities of measured poses.
    fn evidence(&self) -> Option<f64> {
        let (_, task, filter) = self.name;
        (task == Task::Capture && filter != "none").then_some(self.log_evidence)
    }

    /// Error and coverage, with motion capture and, of pushes that have it, with force.
    pub(super) fn panels(all: &[Self]) -> Vec<Panel> {
        let names: Vec<(f64, &str)> =
            SHORT.iter().enumerate().map(|(k, name)| (k as f64, *name)).collect();
        let axis = || Axis::new("filter").names(&names).range(-0.5, SHORT.len() as f64 - 0.5);
        let points = |panel: Panel, task: Task, value: &dyn Fn(&Self) -> f64| {
            [("gp", Color::BLUE), ("analytical", Color::GREEN)].into_iter().fold(
                panel,
                |panel, (model, color)| {
                    let own = all.iter().filter(|one| one.name.0 == model && one.name.1 == task);
                    let places: Vec<[f64; 2]> =
                        own.enumerate().map(|(k, one)| [k as f64, value(one)]).collect();
                    panel.with(Points::at(&places).color(color).radius(4.0).label(model))
                },
            )
        };
        let error = |task: Task| {
            let (title, label, value): (_, _, fn(&Self) -> f64) = match task {
                Task::Capture => ("motion capture", "error of the place / mm", Self::place_mm),
                Task::Force => ("force alone", "error of the angle / °", Self::angle_deg),
            };
            let own = all.iter().filter(|one| one.name.1 == task);
            let y = Axis::new(label).range(0.0, 1.1 * own.map(value).fold(0.0, f64::max));
            points(Panel::new(axis(), y).title(title), task, &value)
        };
        let coverage = |task: Task| {
            let y = Axis::new("share within 90 % regions").range(0.0, 1.0);
            points(Panel::new(axis(), y).with(Guide::horizontal(LEVEL)), task, &Self::share)
        };
        let is_met = |task: &Task| all.iter().any(|one| one.name.1 == *task);
        let met = Task::ALL.into_iter().filter(is_met);
        met.flat_map(|task| [error(task), coverage(task)]).collect()
    }

    pub(super) fn in_words(&self) -> String {
        let (model, task, filter) = self.name;
        let evidence = self.evidence().map_or(String::new(), |value| format!(", {value:.0}"));
        let (place, angle) = (self.place_mm(), self.angle_deg());
        let share = 100.0 * self.share();
        format!("{model}, {}, {filter} {place:.2}, {angle:.2}, {share:.0} %{evidence}", task.id())
    }

    /// The rows of the page: one of each filter and model, with both tasks.
    #[cfg(test)]
    pub(super) fn table(all: &[Self]) -> Vec<String> {
        let mut rows = Vec::new();
        for model in ["gp", "analytical"] {
            for filter in &FILTERS {
                let of = |task: Task| all.iter().find(|one| one.name == (model, task, filter.name));
                let (Some(capture), Some(force)) = (of(Task::Capture), of(Task::Force)) else {
                    continue;
                };
                let numbers = |one: &Self| {
                    let share = 100.0 * one.share();
                    format!("{:.2} | {:.2} | {share:.0} %", one.place_mm(), one.angle_deg())
                };
                let evidence = capture.evidence().map(|value| format!("{value:.0}"));
                let evidence = evidence.map_or("–".to_owned(), |text| text.replace('-', "−"));
                let (one, other) = (numbers(capture), numbers(force));
                let name = if model == "gp" { "process" } else { "mechanics" };
                rows.push(format!("| {}, {name} | {one} | {evidence} | {other} |", filter.name));
            }
        }
        rows
    }

    pub(super) fn numbers(&self) -> serde_json::Value {
        let (model, task, filter) = self.name;
        json!({
            "model": model,
            "task": task.id(),
            "filter": filter,
            "n_pushes": self.n_pushes,
            "n_steps": self.n_steps,
            "place_error_rms_mm": self.place_mm(),
            "angle_error_rms_deg": self.angle_deg(),
            "share_within_90": self.share(),
            "log_evidence_nats": self.evidence(),
        })
    }
}

/// The filters on an axis.
const SHORT: [&str; FILTERS.len()] =
    ["none", "P", "thesis", "A", "RB", "E", "U", "GH", "U, s", "U, a"];
