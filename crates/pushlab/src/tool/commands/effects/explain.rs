//! `pushlab effects explain`: the physics of one effect.

use anyhow::Result;
use clap::builder::PossibleValuesParser;
use effects::all;
use plant::effect_kinds;

use super::explanation::Explanation;
use crate::tool::origin::Origin;
use crate::tool::terminal::Terminal;

/// Explain an effect: physics, equation, source, parameters, what shows it and what looks like it
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The effect's id, as `pushlab effects list` names it
    #[arg(value_parser = id_parser(), hide_possible_values = true)]
    id: String,
}

const EXAMPLES: &str = "\
Examples:
  pushlab effects explain table-anisotropy
  pushlab effects explain sticky-spot --json";

fn id_parser() -> PossibleValuesParser {
    let carried: Vec<&str> = all().iter().map(|effect| effect.info().id).collect();
    let hidden = effect_kinds().into_iter().map(|kind| kind.id);
    let hidden_alone: Vec<&str> = hidden.filter(|id| !carried.contains(id)).collect();
    PossibleValuesParser::new(carried.into_iter().chain(hidden_alone))
}

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let origin = Origin::new("effects explain").words([args.id.clone()]);
    let explanation = Explanation::of(&args.id)?;
    terminal.finish(&origin, &explanation, &explanation)
}
