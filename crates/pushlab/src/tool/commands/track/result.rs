//! What `track` tells, for people and for programs.

use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use models::Watched;
use serde::Serialize;

use super::watched_push::{Foreseen, WatchedPush};
use crate::tool::terminal::TITLE;

/// All pushes that were watched.
#[derive(Serialize)]
pub(super) struct Tracked {
    folder: PathBuf,
    /// The model's name.
    model: String,
    /// The share of the way after which ends are foreseen.
    after: f64,
    /// What other pushes showed of how they differ.
    others: Watched,
    with: Ends,
    without: Ends,
    pushes: Vec<Push>,
    /// Of an update; not for programs, as it differs from run to run.
    #[serde(skip)]
    median_update: Duration,
}

/// One push.
#[derive(Serialize)]
struct Push {
    name: String,
    /// Steps that were watched.
    n_steps: usize,
    /// The share of the way that they are.
    share: f64,
    with: Foreseen,
    without: Foreseen,
}

/// How ends were foreseen, of all pushes.
#[derive(Serialize)]
struct Ends {
    /// Root mean square error of the place, in m, and of the angle, in rad.
    rms_error: [f64; 2],
    coverage: Vec<Coverage>,
}

/// How many measured ends a region holds.
#[derive(Serialize)]
struct Coverage {
    level: f64,
    n_within: usize,
    n_ends: usize,
}

const LEVELS: [f64; 3] = [0.5, 0.9, 0.95];

impl Tracked {
    pub(super) fn new(
        folder: &Path,
        model: &str,
        (after, others): (f64, Watched),
        watched: &[WatchedPush],
    ) -> Self {
        let push = |one: &WatchedPush| Push {
            name: one.name.clone(),
            n_steps: one.n_seen,
            share: one.share,
            with: one.with,
            without: one.without,
        };
        let all = || watched.iter().flat_map(|one| one.durations.iter().copied());
        let mut durations: Vec<Duration> = all().collect();
        durations.sort_unstable();
        Self {
            folder: folder.to_owned(),
            model: model.to_owned(),
            after,
            others,
            with: Ends::of(watched.iter().map(|one| &one.with)),
            without: Ends::of(watched.iter().map(|one| &one.without)),
            pushes: watched.iter().map(push).collect(),
            median_update: durations.get(durations.len() / 2).copied().unwrap_or_default(),
        }
    }

    /// The gain in a sentence.
    pub(super) fn told(&self) -> String {
        let [place, turn] = [0, 1].map(|k| {
            let less = 1.0 - self.with.rms_error[k] / self.without.rms_error[k];
            let word = if less < 0.0 { "more" } else { "less" };
            format!("{:.0} % {word}", 100.0 * less.abs())
        });
        format!(
            "After {:.0} % of the way, ends foreseen with what was learnt are {place} off in place and {turn} in \
             angle than without.",
            100.0 * self.after
        )
    }

    /// The same in a table.
    pub(super) fn table(&self) -> ([&'static str; 4], Vec<Vec<String>>) {
        let head =
            ["foreseen", "place off by / mm", "angle off by / °", "regions that hold the end"];
        let row = |name: &str, ends: &Ends| {
            let [place, turn] = ends.rms_error;
            let held = ends.coverage.iter().map(Coverage::to_string).collect::<Vec<_>>();
            vec![
                name.to_owned(),
                format!("{:.2}", 1e3 * place),
                format!("{:.2}", turn.to_degrees()),
                held.join(", "),
            ]
        };
        (head, vec![row("without learning", &self.without), row("with learning", &self.with)])
    }
}

impl Ends {
    fn of<'a>(ends: impl Iterator<Item = &'a Foreseen> + Clone) -> Self {
        let n_ends = ends.clone().count();
        let rms = |k: usize| {
            let squares: f64 = ends.clone().map(|end| end.error[k].powi(2)).sum();
            (squares / n_ends as f64).sqrt()
        };
        let within = |level: f64| {
            let n_within = ends.clone().filter(|end| end.level < level).count();
            Coverage { level, n_within, n_ends }
        };
        Self { rms_error: [rms(0), rms(1)], coverage: LEVELS.map(within).into() }
    }
}

impl fmt::Display for Coverage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.0} %: {} of {}", 100.0 * self.level, self.n_within, self.n_ends)
    }
}

impl fmt::Display for Tracked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Watched { n_pushes, widened, wander, .. } = &self.others;
        let n = self.pushes.len();
        writeln!(f, "{}: {n} pushes watched", self.model)?;
        writeln!(
            f,
            "  what differs from push to push is {widened:.2} times as wide as in the model and stays for \
             {:.0} mm, by {n_pushes} other pushes",
            1e3 * wander.length
        )?;
        writeln!(f, "  ends, foreseen after {:.0} % of the way:", 100.0 * self.after)?;
        for (name, ends) in [("without learning", &self.without), ("with learning", &self.with)] {
            let [place, turn] = ends.rms_error;
            writeln!(
                f,
                "    {name}: {:.2} mm and {:.2}° off (root mean square)",
                1e3 * place,
                turn.to_degrees()
            )?;
            for Coverage { level, n_within, n_ends } in &ends.coverage {
                let level = 100.0 * level;
                writeln!(f, "      {level:.0} % regions hold {n_within} of {n_ends} ends")?;
            }
        }
        let update = 1e3 * self.median_update.as_secs_f64();
        writeln!(f, "  an update takes {update:.2} ms (median)")?;
        writeln!(f, "{TITLE}wrote {}{TITLE:#}", self.folder.display())
    }
}
