//! Progress of long work: a bar on a terminal, a few plain lines elsewhere.

use std::fmt::Display;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::tool::heard::Heard;

/// Counts finished pieces of work.
pub(crate) enum Progress {
    /// On a terminal.
    Bar(ProgressBar),
    /// In a file or a pipe.
    Lines {
        /// What is done to the pieces.
        what: &'static str,
        /// Finished pieces.
        done: usize,
        /// All pieces.
        total: usize,
    },
    /// To a program.
    Heard {
        /// Who listens.
        heard: Heard,
        /// What is done to the pieces.
        what: &'static str,
        /// Finished pieces.
        done: usize,
        /// All pieces.
        total: usize,
    },
    /// Nobody wants to know.
    Silent,
}

/// Lines for a whole run.
const LINES: usize = 4;
/// Less work than this is done before anyone wonders.
const WORTH_A_LINE: usize = 20;

impl Progress {
    pub(crate) fn new(what: &'static str, total: usize, target: ProgressDrawTarget) -> Self {
        if target.is_hidden() {
            return Self::Lines { what, done: 0, total };
        }
        let style = ProgressStyle::with_template("{msg} {bar:40} {pos} of {len}, {eta} left");
        let bar = ProgressBar::with_draw_target(Some(total as u64), target).with_message(what);
        Self::Bar(match style {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        })
    }

    pub(crate) fn silent() -> Self {
        Self::Silent
    }

    pub(crate) fn heard(heard: Heard, what: &'static str, total: usize) -> Self {
        Self::Heard { heard, what, done: 0, total }
    }

    /// One more piece is done.
    pub(crate) fn advance(&mut self) {
        match self {
            Self::Bar(bar) => bar.inc(1),
            Self::Lines { what, done, total } => {
                *done += 1;
                if is_line(*done, *total) {
                    // Standard error may be closed: then nobody wants to know either.
                    let line = format!("{what} {done} of {total}\n");
                    let _ = std::io::Write::write_all(&mut std::io::stderr(), line.as_bytes());
                }
            }
            Self::Heard { heard, what, done, total } => {
                *done += 1;
                heard.progress(what, *done, *total);
            }
            Self::Silent => {}
        }
    }

    /// Removes the bar.
    pub(crate) fn finish(self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}

/// Tells what long work is at whose pieces nobody can count, on a terminal or to a program alone.
pub(crate) enum Activity {
    /// On a terminal.
    Line(ProgressBar),
    /// To a program.
    Heard(Heard),
    /// Nobody wants to know.
    Silent,
}

/// How often its clock is drawn.
const TICK: Duration = Duration::from_millis(200);

impl Activity {
    pub(crate) fn new(target: ProgressDrawTarget) -> Self {
        if target.is_hidden() {
            return Self::silent();
        }
        let line = ProgressBar::with_draw_target(None, target);
        let style = ProgressStyle::with_template("{spinner} {elapsed} {wide_msg}");
        let line = style.map_or(line.clone(), |style| line.with_style(style));
        line.enable_steady_tick(TICK);
        Self::Line(line)
    }

    pub(crate) fn silent() -> Self {
        Self::Silent
    }

    /// The work is at this now.
    pub(crate) fn tell(&self, phase: impl Display) {
        match self {
            Self::Line(line) => line.set_message(phase.to_string()),
            Self::Heard(heard) => heard.phase(&phase.to_string()),
            Self::Silent => {}
        }
    }

    /// Removes the line.
    pub(crate) fn finish(self) {
        if let Self::Line(line) = self {
            line.finish_and_clear();
        }
    }
}

/// Whether another share of the work is complete.
fn is_line(done: usize, total: usize) -> bool {
    if total < WORTH_A_LINE {
        return false;
    }
    let shares = |done: usize| done * LINES / total;
    shares(done) > shares(done - 1)
}

#[cfg(test)]
mod tests {
    use super::is_line;

    #[test]
    fn a_run_prints_four_lines_and_the_last_at_its_end() {
        let lines = |total| (1..=total).filter(|&done| is_line(done, total)).collect::<Vec<_>>();
        assert_eq!(lines(32), [8, 16, 24, 32]);
        assert_eq!(lines(21), [6, 11, 16, 21]);
        assert!(lines(19).is_empty());
    }
}
