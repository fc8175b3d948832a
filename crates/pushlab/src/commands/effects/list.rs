//! `pushlab effects list`: every effect in a line.

use std::fmt::Write as _;

use anyhow::Result;
use plant::effect_kinds;
use serde::Serialize;

use crate::origin::Origin;
use crate::terminal::{TITLE, Terminal};

/// List the effects: first those of the catalogue, then those that only `generate` knows
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {}

const EXAMPLES: &str = "\
Examples:
  pushlab effects list
  pushlab effects list --json";

#[derive(Serialize)]
struct Effects<'a> {
    effects: &'a [Listed],
}

#[derive(Serialize)]
struct Listed {
    id: &'static str,
    about: &'static str,
    /// Whether a model can carry it.
    in_catalogue: bool,
}

pub(crate) fn run(_args: &Args, terminal: &Terminal) -> Result<()> {
    let listed: Vec<_> = effect_kinds()
        .into_iter()
        .map(|kind| Listed { id: kind.id, about: kind.about, in_catalogue: kind.in_catalogue })
        .collect();
    let width = listed.iter().map(|effect| effect.id.len()).max().unwrap_or_default();
    let mut text = String::new();
    for (in_catalogue, title) in [
        (true, "in the catalogue: a model can carry them, `generate` can hide them"),
        (false, "in no catalogue: `generate` can hide them"),
    ] {
        let _ = writeln!(text, "{TITLE}{title}{TITLE:#}");
        for Listed { id, about, .. } in listed.iter().filter(|e| e.in_catalogue == in_catalogue) {
            let _ = writeln!(text, "  {id:width$}  {about}");
        }
    }
    terminal.finish(&Origin::new("effects list"), &Effects { effects: &listed }, text)
}
