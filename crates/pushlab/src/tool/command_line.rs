//! What can be typed: the options that every command has, and the commands.

use std::ffi::OsString;

use anyhow::{Context, Result};
use clap::builder::{PossibleValuesParser, RangedU64ValueParser, TypedValueParser};
use clap::{ColorChoice, CommandFactory, Parser, value_parser};
use dataset::Preset;
use effects::all;

use crate::tool::commands::Command;
use crate::tool::global::Global;
use crate::tool::terminal::Terminal;

/// Turn recordings of robot pushes into tables of steps, and compare models with them.
#[derive(Parser)]
#[command(name = "pushlab", version, max_term_width = 100, after_help = AFTER_HELP)]
pub(crate) struct CommandLine {
    #[command(flatten)]
    pub(crate) global: Global,
    #[command(subcommand)]
    command: Command,
}

const AFTER_HELP: &str = "\
Start with recordings that you have:
  pushlab run pushes -o result    all the way, to a report; or one command after the other:
  pushlab init pushes             write pushes/dataset.toml from what is there
  pushlab ingest pushes -o steps.csv
  pushlab describe steps.csv
or with simulated ones: pushlab generate --hidden surprise -o pushes

Exit codes: 0 done, 1 the input or the computation failed, 2 wrong usage.";

impl CommandLine {
    /// Runs the command.
    ///
    /// # Errors
    /// What the command says.
    pub(crate) fn run(&self, terminal: &Terminal) -> Result<()> {
        if let Some(jobs) = self.global.jobs {
            rayon::ThreadPoolBuilder::new()
                .num_threads(jobs.into())
                .build_global()
                .with_context(|| format!("cannot start {jobs} threads"))?;
        }
        self.command.run(terminal)
    }
}

/// Runs a command within another one, as if these words stood behind `pushlab`.
///
/// # Errors
/// What the parser or the command says.
pub(crate) fn run_typed<W: AsRef<str>>(words: &[W], terminal: &Terminal) -> Result<()> {
    let words = ["pushlab"].into_iter().chain(words.iter().map(AsRef::as_ref));
    CommandLine::try_parse_from(words)?.run(terminal)
}

/// The parser, whose own messages follow `--color` too.
pub(crate) fn command(arguments: &[OsString]) -> clap::Command {
    CommandLine::command().color(color_wanted(arguments))
}

/// Help and errors of the parser come before the arguments are known, so this looks ahead.
fn color_wanted(arguments: &[OsString]) -> ColorChoice {
    let texts: Vec<_> = arguments.iter().filter_map(|argument| argument.to_str()).collect();
    let after = texts.windows(2).find(|pair| pair[0] == "--color").map(|pair| pair[1]);
    let joined = texts.iter().find_map(|text| text.strip_prefix("--color="));
    match after.or(joined) {
        Some("always") => ColorChoice::Always,
        Some("never") => ColorChoice::Never,
        _ => ColorChoice::Auto,
    }
}

/// Reads the name of a preset.
pub(crate) fn preset_parser() -> impl TypedValueParser<Value = Preset> {
    PossibleValuesParser::new(Preset::ALL.map(Preset::name))
        .try_map(|name| Preset::by_name(&name).ok_or("no such preset"))
}

/// Reads the id of an effect that a model can carry.
pub(crate) fn effect_parser() -> PossibleValuesParser {
    PossibleValuesParser::new(all().iter().map(|effect| effect.info().id))
}

/// Reads a seed, as far as TOML can write integers.
pub(crate) fn seed_parser() -> RangedU64ValueParser {
    value_parser!(u64).range(..=i64::MAX as u64)
}

#[cfg(test)]
mod tests {
    use clap::{ColorChoice, CommandFactory};

    use super::{CommandLine, color_wanted};

    #[test]
    fn the_command_line_is_consistent() {
        CommandLine::command().debug_assert();
    }

    #[test]
    fn every_command_has_examples() {
        fn check(command: &clap::Command) {
            let name = command.get_name();
            if command.has_subcommands() {
                command.get_subcommands().for_each(check);
                return;
            }
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            let examples = help.lines().filter(|line| line.starts_with("  pushlab ")).count();
            assert!(examples >= 2, "{name} has {examples} examples");
        }
        CommandLine::command().get_subcommands().for_each(check);
    }

    #[test]
    fn the_last_word_on_colors_is_found_before_parsing() {
        let wanted = |words: &[&str]| {
            color_wanted(&words.iter().map(|word| word.into()).collect::<Vec<_>>())
        };
        assert_eq!(wanted(&["pushlab", "--color", "never", "--help"]), ColorChoice::Never);
        assert_eq!(wanted(&["pushlab", "--help", "--color=always"]), ColorChoice::Always);
        assert_eq!(wanted(&["pushlab", "--help", "--color"]), ColorChoice::Auto);
    }
}
