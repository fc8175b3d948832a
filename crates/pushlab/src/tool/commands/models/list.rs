//! `pushlab models list`: the kinds of models.

use std::fmt::Write as _;

use anyhow::Result;
use models::model_kinds;
use serde::Serialize;

use crate::tool::origin::Origin;
use crate::tool::terminal::{TITLE, Terminal};

/// List the kinds of models
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {}

const EXAMPLES: &str = "\
Examples:
  pushlab models list
  pushlab models list --json";

#[derive(Serialize)]
struct Kinds<'a> {
    kinds: &'a [Kind],
}

#[derive(Serialize)]
struct Kind {
    id: &'static str,
    about: &'static str,
}

pub(crate) fn run(_args: &Args, terminal: &Terminal) -> Result<()> {
    let kinds: Vec<_> =
        model_kinds().iter().map(|kind| Kind { id: kind.id, about: kind.about }).collect();
    let width = kinds.iter().map(|kind| kind.id.len()).max().unwrap_or_default();
    let mut text = String::new();
    for Kind { id, about } in &kinds {
        let _ = writeln!(text, "{TITLE}{id:width$}{TITLE:#}  {about}");
    }
    terminal.finish(&Origin::new("models list"), &Kinds { kinds: &kinds }, text)
}
