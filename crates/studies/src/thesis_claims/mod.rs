//! `cargo xtask thesis-claims`: the thesis' claims on real, rough and quiet pushes, on a page.

mod kept;
mod page;

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::ValueEnum;
use report::{Claim, Verdict};

use crate::figures::inputs::Inputs;
use crate::figures::{named, settled, thesis_design};
use fixtures::workspace_root;

/// Judge the thesis' claims on real, rough and quiet pushes side by side, in docs/.
#[derive(clap::Args)]
pub struct Args {
    /// Folder with the public data sets (`mit-push-table`, `mit-push-raw`)
    #[arg(long, value_name = "DIR")]
    data: PathBuf,
    /// Judge on these pushes anew, and take what was found on others the last time
    #[arg(long, value_delimiter = ',')]
    only: Vec<Pushes>,
    /// Folder for `thesis-claims.md`
    #[arg(short, long, value_name = "DIR", default_value = "docs", alias = "out")]
    output: PathBuf,
}

/// On what the claims are judged, the first that can tell being the one that decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Pushes {
    /// Measured steps
    RealSteps,
    /// Measured pushes
    RealRecordings,
    /// The thesis' design on a rig as rough as real ones
    RoughRig,
    /// The same on a rig that nothing disturbs
    QuietRig,
}

/// The claims on some pushes, by their number.
struct Regime {
    pushes: Pushes,
    claims: Vec<Claim>,
}

/// Judges every claim on all pushes and writes the page.
///
/// # Errors
/// Data that cannot be read; a figure that cannot be drawn; a page that cannot be written.
pub fn run(args: &Args) -> Result<()> {
    let regime = |&pushes: &Pushes| {
        let claims = match args.only.is_empty() || args.only.contains(&pushes) {
            true => pushes.judged(&args.data)?,
            false => kept::read(&pushes.kept())?,
        };
        Ok(Regime { pushes, claims })
    };
    let regimes = Pushes::value_variants().iter().map(regime).collect::<Result<Vec<_>>>()?;
    let path = workspace_root().join(&args.output).join("thesis-claims.md");
    output::write(&path, page::page(&regimes)?)?;
    println!("written: {}", path.display());
    Ok(())
}

impl Pushes {
    fn name(self) -> &'static str {
        match self {
            Self::RealSteps => "real steps",
            Self::RealRecordings => "real recordings",
            Self::RoughRig => "rough rig",
            Self::QuietRig => "quiet rig",
        }
    }

    fn is_real(self) -> bool {
        matches!(self, Self::RealSteps | Self::RealRecordings)
    }

    fn inputs(self, data: &Path) -> Result<Inputs> {
        let rig = |name: &str| Inputs::at_speeds(&thesis_design(named(name)?)?);
        match self {
            Self::RealSteps => Inputs::open(&data.join("mit-push-table/table.csv"), false),
            Self::RealRecordings => Inputs::open(&data.join("mit-push-raw"), false),
            Self::RoughRig => rig("rough"),
            Self::QuietRig => rig("quiet"),
        }
    }

    /// The claims on these pushes, which are kept for the next time.
    fn judged(self, data: &Path) -> Result<Vec<Claim>> {
        let mut claims = settled(&self.inputs(data)?)?;
        claims.sort_by_key(|claim| number(&claim.claim));
        kept::write(&self.kept(), &claims)?;
        println!("judged: {}", self.name());
        Ok(claims)
    }

    /// Where they are kept.
    fn kept(self) -> PathBuf {
        let name = self.name().replace(' ', "-");
        workspace_root().join("target/thesis-claims").join(name).with_extension("json")
    }
}

/// The number with which a claim begins.
fn number(claim: &str) -> u32 {
    claim.split('.').next().and_then(|number| number.parse().ok()).unwrap_or(u32::MAX)
}

/// What became of a claim in the regime that decides, and which that is: the first in which it can be
/// tested.
fn decided<'a>(claims: &[&'a Claim]) -> Option<(usize, &'a Claim)> {
    let testable = |(_, claim): &(usize, &&Claim)| claim.verdict != Verdict::NotTestable;
    claims.iter().enumerate().find(testable).map(|(regime, claim)| (regime, *claim))
}

#[cfg(test)]
mod tests {
    use report::{Claim, Verdict};

    use super::{decided, number};

    fn claim(verdict: Verdict) -> Claim {
        Claim { claim: "3. x".into(), value: String::new(), verdict, reason: String::new() }
    }

    #[test]
    fn real_pushes_decide_where_they_can_tell() {
        use Verdict::{DoesNotHold, Holds, NotTestable};
        let decide = |verdicts: [Verdict; 4]| {
            let claims = verdicts.map(claim);
            let claims: Vec<&Claim> = claims.iter().collect();
            decided(&claims).map(|(regime, claim)| (regime, claim.verdict))
        };
        assert_eq!(decide([DoesNotHold, Holds, Holds, Holds]), Some((0, DoesNotHold)));
        assert_eq!(decide([NotTestable, NotTestable, Holds, DoesNotHold]), Some((2, Holds)));
        assert_eq!(decide([NotTestable; 4]), None);
    }

    #[test]
    fn claims_are_numbered_as_in_the_thesis() {
        assert_eq!([number("15. In the model"), number("x. y")], [15, u32::MAX]);
    }
}
