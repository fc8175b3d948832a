//! The end of a run: what was found, where it is, and what to do next.

use std::fmt;
use std::path::PathBuf;

use diagnosis::{Diagnosis, ErrorFall, Verdict};
use serde::Serialize;

use super::Args;
use super::chain::{Chain, DIAGNOSIS, PAGE, Past};
use crate::tool::commands::diagnose::write_error;
use crate::tool::people::lines;
use crate::tool::step_kind::StepKind;
use crate::tool::terminal::TITLE;

/// The result of a run.
#[derive(Serialize)]
pub(super) struct Ran {
    phases: Vec<Past>,
    verdict: Verdict,
    sentence: String,
    identified: Vec<String>,
    ambiguous: Vec<Vec<String>>,
    effective: Vec<String>,
    error: ErrorFall,
    /// What the step is that it is of.
    step: StepKind,
    /// The model to go on with.
    model: PathBuf,
    report: PathBuf,
    /// A command, as one types it.
    next: String,
    #[serde(skip)]
    why: &'static str,
}

/// Width of a line of running text.
const WIDTH: usize = 96;

impl Ran {
    pub(super) fn of(args: &Args, chain: Chain, found: Diagnosis, model: &str) -> Self {
        let model = chain.path(model);
        let (diagnosis, report) = (chain.path(DIAGNOSIS), chain.path(PAGE));
        let [set, output] = [&args.folder, &args.output].map(|path| path.display().to_string());
        let [model_text, diagnosis] = [&model, &diagnosis].map(|path| path.display().to_string());
        let (words, why): (&[&str], _) = match found.verdict {
            Verdict::Identified | Verdict::Effective => (
                &["simulate", &set, "--model", &model_text, "-o", &format!("{output}-motion")],
                "whole pushes by the better model, with how sure that is",
            ),
            Verdict::Ambiguous => {
                (&["suggest", "--from", &diagnosis], "pushes that tell apart what it could be")
            }
            Verdict::Unexplained => (
                &["train", &set, "--kind", "hybrid", "--model", &model_text, "-o", "hybrid.toml"],
                "learns what no effect explains",
            ),
            Verdict::NoneFound | Verdict::Inconclusive => (
                &["check", &set, "--model", &model_text],
                "what these pushes can show, and what not",
            ),
        };
        let words = ["pushlab"].iter().chain(words).copied();
        let next =
            shlex::try_join(words.clone()).unwrap_or_else(|_| words.collect::<Vec<_>>().join(" "));
        let Diagnosis { verdict, sentence, identified, ambiguous, effective, error, .. } = found;
        let (phases, step) = (chain.past, chain.step);
        Self {
            phases,
            verdict,
            sentence,
            identified,
            ambiguous,
            effective,
            error,
            step,
            model,
            report,
            next,
            why,
        }
    }

    fn verdict_text(&self) -> &'static str {
        match self.verdict {
            Verdict::Identified => "identified",
            Verdict::Ambiguous => "ambiguous",
            Verdict::Effective => "effective",
            Verdict::Unexplained => "unexplained",
            Verdict::NoneFound => "none found",
            Verdict::Inconclusive => "inconclusive",
        }
    }
}

impl fmt::Display for Ran {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for line in lines(&self.sentence, WIDTH) {
            writeln!(f, "{TITLE}{line}{TITLE:#}")?;
        }
        write_error(f, &self.error, self.step)?;
        writeln!(f, "{TITLE}verdict{TITLE:#}  {}", self.verdict_text())?;
        writeln!(f, "{TITLE}model{TITLE:#}    {}", self.model.display())?;
        writeln!(f, "{TITLE}report{TITLE:#}   {}", self.report.display())?;
        writeln!(f, "{TITLE}next{TITLE:#}     {}\n         {}", self.next, self.why)
    }
}
