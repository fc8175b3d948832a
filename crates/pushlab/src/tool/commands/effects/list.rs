//! `pushlab effects list`: every effect in a line.

use std::fmt::Write as _;

use anyhow::Result;
use effects::{EffectInfo, tested};
use plant::{EffectKind, effect_kinds};
use serde::Serialize;

use crate::tool::origin::Origin;
use crate::tool::terminal::{TITLE, Terminal};

/// List the effects: those of the catalogue, which `diagnose` tests for or which are fitted when asked
/// for, then those that only `generate` knows
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
    /// Whether `diagnose` tests for it.
    is_tested: bool,
}

impl Listed {
    fn all() -> Vec<Self> {
        let is_tested = |id: &str| tested().iter().any(|effect| effect.info().id == id);
        let hidden: Vec<Self> = effect_kinds()
            .into_iter()
            .map(|EffectKind { id, about, in_catalogue, .. }| Self {
                id,
                about,
                in_catalogue: *in_catalogue,
                is_tested: is_tested(id),
            })
            .collect();
        let is_new = |about: &&EffectInfo| hidden.iter().all(|listed| listed.id != about.id);
        let fitted = effects::all().iter().map(|effect| effect.info()).filter(is_new);
        let fitted: Vec<Self> = fitted
            .map(|EffectInfo { id, title: about, .. }| Self {
                id,
                about,
                in_catalogue: true,
                is_tested: false,
            })
            .collect();
        hidden.into_iter().chain(fitted).collect()
    }
}

pub(crate) fn run(_args: &Args, terminal: &Terminal) -> Result<()> {
    let listed = Listed::all();
    let width = listed.iter().map(|effect| effect.id.len()).max().unwrap_or_default();
    let mut text = String::new();
    for (kind, title) in [
        (
            (true, true),
            "a model can carry them, `diagnose` tests for them, `generate` can hide them",
        ),
        ((true, false), "a model can carry them: `pushlab add EFFECT --fit SET`"),
        ((false, false), "in no catalogue: `generate` can hide them"),
    ] {
        let _ = writeln!(text, "{TITLE}{title}{TITLE:#}");
        for Listed { id, about, .. } in
            listed.iter().filter(|e| (e.in_catalogue, e.is_tested) == kind)
        {
            let _ = writeln!(text, "  {id:width$}  {about}");
        }
    }
    terminal.finish(&Origin::new("effects list"), &Effects { effects: &listed }, text)
}
