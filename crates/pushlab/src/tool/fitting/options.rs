//! Options of a fit.

use anyhow::{Result, bail};
use diagnosis::SupportPointsFit;
use effects::{Effect, SupportPoints};
use models::ModelFile;

use crate::tool::wrong_usage::WrongUsage;

/// What is known of the points on which an object rests, and what is written.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct FitOptions {
    /// For support-points: how many there are, 3 to 6; 4 where it is not said
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(3..=6))]
    points: Option<u8>,
    /// For support-points: they share the weight so that the object does not tip, with the center of friction
    /// at its center of mass, as statics have it where the push is low
    #[arg(long)]
    by_statics: bool,
    /// Write the nuisances, too: what the manifest claims of friction, tip, tracked frame and clocks, as it
    /// fits these pushes best within its tolerance
    #[arg(long)]
    nuisances: bool,
}

impl FitOptions {
    /// Refuses what is not for a fit of these effects to a model; of none for a command that fits nothing.
    ///
    /// # Errors
    /// Options that are given and have no use.
    pub(crate) fn check(&self, fitted: &[&str], model: &ModelFile) -> Result<()> {
        let id = SupportPoints.info().id;
        let is_about_points = self.points.is_some() || self.by_statics;
        if is_about_points && !fitted.contains(&id) {
            bail!(WrongUsage("--points and --by-statics are for fits of support-points"));
        }
        if self.points.is_some() && model.description.effects.iter().any(|known| known.id == id) {
            bail!(WrongUsage(
                "the model has support points, from which a fit goes on; leave --points out, or start \
                 from a model without them"
            ));
        }
        if self.nuisances && fitted.is_empty() {
            bail!(WrongUsage("--nuisances is for fits; give --fit SET"));
        }
        Ok(())
    }

    pub(super) fn support_points(&self) -> SupportPointsFit {
        let n = self.points.map_or(SupportPointsFit::default().n, usize::from);
        SupportPointsFit { n, by_statics: self.by_statics }
    }

    pub(super) fn writes_nuisances(&self) -> bool {
        self.nuisances
    }

    /// As words of a command line.
    pub(crate) fn words(&self) -> Vec<String> {
        let n = self.points.iter().flat_map(|n| ["--points".to_owned(), n.to_string()]);
        let flags = [(self.by_statics, "--by-statics"), (self.nuisances, "--nuisances")];
        let flags = flags.into_iter().filter(|(is_given, _)| *is_given);
        n.chain(flags.map(|(_, flag)| flag.to_owned())).collect()
    }
}
