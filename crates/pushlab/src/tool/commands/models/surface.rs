//! `pushlab models surface`: a limit surface from measured loads and motions.

use std::fmt;
use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use dataset::read_wrench_twists;
use mechanics::{WrenchTwist, fit_ellipsoid};
use models::{Analytical, Base, CharacteristicLength, EffectiveSurface, ModelFile, SurfaceKind};
use serde::Serialize;

use crate::tool::destination::{Force, Inputs};
use crate::tool::file_ending;
use crate::tool::origin::{Input, Origin, readable};
use crate::tool::terminal::Terminal;

/// Fit the limit surface of an object to measured loads and motions
///
/// The convex quartic that is nearest to all pairs takes the place of the model's limit surface
/// (effective-quartic). It holds for this object on this table.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Table of pairs (.csv), by shape: columns surface, shape, v_mm_s, fx, fy, tau_over_rho (N), vx, vy,
    /// omega_times_rho (m/s), in the body frame
    #[arg(value_parser = file_ending::csv)]
    pairs: PathBuf,
    /// Shape of the object, as the table names it
    #[arg(long, value_name = "NAME")]
    shape: String,
    /// Model whose limit surface is replaced
    #[arg(long, value_name = "FILE", default_value = "model.toml",
          value_parser = file_ending::model)]
    model: PathBuf,
    /// The model to write, another file than the first; `-` is standard output
    #[arg(short, long, value_name = "FILE",
          value_parser = file_ending::or_standard(file_ending::model))]
    output: PathBuf,
    #[command(flatten)]
    force: Force,
}

const EXAMPLES: &str = "\
Examples:
  pushlab models surface wrench_twist_plywood.csv --shape rect1 --model nominal.toml -o rect1.toml
  pushlab models surface pairs.csv --shape hex -o - --quiet";

/// How near each kind of surface is to the pairs.
#[derive(Serialize)]
struct Fitted {
    output: PathBuf,
    shape: String,
    n_pairs: usize,
    quartic: Errors,
    ellipsoid: Errors,
}

/// Of the load for a motion, in N, root mean square; of the motion for a load, in rad, mean.
#[derive(Serialize)]
struct Errors {
    force: f64,
    motion: f64,
}

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let terminal = terminal.beside([args.output.as_path()])?;
    let inputs = Inputs::default().with([&args.pairs, &args.model]);
    let destination = args.force.file(&args.output, &inputs)?;
    readable(&args.pairs)?;
    readable(&args.model)?;
    let mut origin = Origin::new("models surface")
        .path(&args.pairs)
        .option("shape", Some(&args.shape))
        .paths("model", [&args.model]);
    origin.inputs.extend([Input::file(&args.pairs)?, Input::file(&args.model)?]);
    let mut file = ModelFile::read(&args.model)?;
    let Base::Analytical(base) = &file.description.base else {
        bail!("only an analytical model takes another limit surface; name one with --model");
    };
    let rows = read_wrench_twists(&args.pairs)?;
    let own: Vec<_> = rows.iter().filter(|row| row.shape == args.shape).collect();
    let Some(first) = own.first() else {
        let mut shapes: Vec<&str> = rows.iter().map(|row| row.shape.as_str()).collect();
        shapes.sort_unstable();
        shapes.dedup();
        bail!("{} has no shape {}; it has {}", args.pairs.display(), args.shape, shapes.join(", "));
    };
    let pair = |row: &&dataset::WrenchTwist| WrenchTwist { wrench: row.wrench, twist: row.twist };
    let (pairs, length): (Vec<_>, _) =
        (own.iter().map(pair).collect(), first.characteristic_length);
    let (surface, quartic) = EffectiveSurface::of_pairs(&pairs, length)
        .with_context(|| format!("cannot fit {}", args.shape))?;
    let ellipsoid = fit_ellipsoid(&pairs, length)?;
    let uniform = CharacteristicLength::UniformPressure;
    let base = Analytical::new(base.pusher_friction().clone(), uniform, *base.scatter())?;
    file.description.base = Base::Analytical(base.with_surface(SurfaceKind::Effective(surface))?);
    file.write_to(destination)?;
    let result = Fitted {
        output: args.output.clone(),
        shape: args.shape.clone(),
        n_pairs: pairs.len(),
        quartic: Errors { force: quartic.force_error_rms, motion: quartic.twist_error_mean },
        ellipsoid: Errors { force: ellipsoid.force_error_rms, motion: ellipsoid.twist_error_mean },
    };
    terminal.finish(&origin, &result, &result)
}

impl fmt::Display for Fitted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { output, shape, n_pairs, quartic, ellipsoid } = self;
        writeln!(f, "wrote {}", output.display())?;
        writeln!(f, "  {shape}: {n_pairs} pairs of load and motion")?;
        for (name, errors) in [("convex quartic", quartic), ("ellipsoid", ellipsoid)] {
            let (force, degrees) = (errors.force, errors.motion.to_degrees());
            writeln!(f, "  {name}: load within {force:.3} N (rms), motion within {degrees:.2}°")?;
        }
        Ok(())
    }
}
