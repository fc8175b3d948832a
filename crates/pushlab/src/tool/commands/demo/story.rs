//! The commands of the demo, one after the other.

use std::path::Path;

use anyhow::{Context, Result};
use diagnosis::{Diagnosis, ErrorFall, Verdict};
use serde::{Deserialize, Serialize};

use crate::tool::command_line::run_typed;
use crate::tool::diagnosis_file::lowers_the_error;
use crate::tool::origin::Origin;
use crate::tool::terminal::{TITLE, Terminal};

/// What is told, and where.
pub(super) struct Story<'a> {
    pub(super) folder: &'a Path,
    pub(super) seed: u64,
    pub(super) hidden: &'a str,
    pub(super) n_pushes: u32,
    pub(super) rig: &'a str,
    pub(super) terminal: &'a Terminal,
}

/// The end of the story, for programs.
#[derive(Serialize)]
struct End {
    seed: u64,
    hidden: Vec<HiddenEffect>,
    verdict: Verdict,
    identified: Vec<String>,
    ambiguous: Vec<Vec<String>>,
    error: ErrorFall,
    report: String,
}

/// The sealed truth, as far as it is told.
#[derive(Deserialize)]
struct Truth {
    hidden: Vec<HiddenEffect>,
}

/// What was hidden; SI units.
#[derive(Serialize, Deserialize)]
struct HiddenEffect {
    id: String,
    values: toml::Table,
}

impl Story<'_> {
    pub(super) fn tell(&self) -> Result<()> {
        let (seed, n_pushes) = (self.seed.to_string(), self.n_pushes.to_string());
        let [set, model, answer] = ["pushes", "model.toml", "diagnosis.json"].map(|n| self.path(n));
        let [better, page] = ["better.toml", "report.html"].map(|name| self.path(name));
        self.say(
            "A simulated rig pushes a square. Something is hidden in it; no command below is told.",
        );
        let hidden = ["--hidden", self.hidden, "-n", &n_pushes, "--rig", self.rig, "--seed", &seed];
        self.run(&[&["generate"], &hidden[..], &["-o", &set]].concat())?;
        self.say(
            "The model to begin with: the thesis' push, with what the rig's builder believes.",
        );
        self.run(&["models", "init", &set, "-o", &model])?;
        self.say("How wrong is it, and where?");
        self.run(&["compare", &set, "--model", &model])?;
        self.say("Which effect is missing?");
        self.run(&["diagnose", &set, "--model", &model, "-o", &answer])?;
        let text = std::fs::read_to_string(&answer);
        let text = text.with_context(|| format!("cannot read {answer}"))?;
        let found: Diagnosis =
            serde_json::from_str(&text).with_context(|| format!("cannot read {answer}"))?;
        let mut report = vec!["report", &set, "--model", &model];
        if lowers_the_error(&found) {
            self.say("Add what lowers the error, and look at it on held-out pushes.");
            self.run(&["add", "--all", "--from", &answer, "--model", &model, "-o", &better])?;
            self.run(&["compare", &set, "--model", &better, "--against", &model])?;
            report.extend(["--model", &better]);
        } else {
            self.say("Nothing lowers the error for sure, so nothing is added.");
        }
        self.say("All of it on one page.");
        report.extend(["--from", &answer, "-o", &page]);
        self.run(&report)?;
        self.end(found, page)
    }

    /// Opens the truth.
    fn end(&self, found: Diagnosis, report: String) -> Result<()> {
        let path = self.path("pushes.truth.toml");
        let text = std::fs::read_to_string(&path).with_context(|| format!("cannot read {path}"))?;
        let truth: Truth = toml::from_str(&text).with_context(|| format!("cannot read {path}"))?;
        let hidden: Vec<String> = truth.hidden.iter().map(HiddenEffect::text).collect();
        let text = format!(
            "\n{TITLE}The truth, sealed until now: {}{TITLE:#}\n\
             {} limit-surface-shape, or another effect of the support, may be named beside it.\n\
             The page: {report}\nThe same again: pushlab demo --rig {} --seed {} -o FOLDER\n",
            hidden.join("; "),
            self.stands(),
            self.rig,
            self.seed
        );
        let Diagnosis { verdict, identified, ambiguous, error, .. } = found;
        let (seed, hidden) = (self.seed, truth.hidden);
        let end = End { seed, hidden, verdict, identified, ambiguous, error, report };
        self.terminal.finish(&Origin::new("demo").option("seed", [self.seed]), &end, text)
    }

    /// On what the object stands besides what is hidden.
    fn stands(&self) -> &'static str {
        match self.rig {
            "quiet" => {
                "The object stands on its whole face, of which an ellipsoidal limit surface is an \
                 approximation:"
            }
            _ => {
                "The object stands on few spots that change from place to place, its friction varies, \
                 and the tip is caught at one vertex, as on real rigs:"
            }
        }
    }

    /// Prints a command as one would type it, and runs it.
    fn run(&self, words: &[&str]) -> Result<()> {
        let typed = shlex::try_join(words.iter().copied())?;
        let inner = self.terminal.within();
        inner.print_for_people(&format!("\n$ pushlab {typed}\n"))?;
        run_typed(words, &inner)
    }

    fn say(&self, text: &str) {
        // What the story says is no result: programs do not want it.
        let _ = self.terminal.within().print_for_people(&format!("\n{TITLE}{text}{TITLE:#}\n"));
    }

    fn path(&self, name: &str) -> String {
        self.folder.join(name).display().to_string()
    }
}

impl HiddenEffect {
    /// As `table-tilt: x = 0.2, y = 0`.
    fn text(&self) -> String {
        let values = self.values.iter().map(|(name, value)| format!("{name} = {value}"));
        let values: Vec<String> = values.collect();
        if values.is_empty() {
            self.id.clone()
        } else {
            format!("{}: {}", self.id, values.join(", "))
        }
    }
}
