//! `cargo xtask rig-calibration`: a simulated rig beside what was measured on real ones.

mod described;
mod put_back;
mod repeats;
mod row;
mod scatter;
mod table;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::builder::PossibleValuesParser;
use plant::{Nominal, Profile, Scatter, Sensors, Truth};
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use described::Described;
use row::{Row, text};

/// Put a simulated rig beside what was measured on real ones
#[derive(clap::Args)]
pub struct Args {
    /// Folder of the real measurements, with `mit-push-table`; without it, published numbers alone
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Profile that simulates the table of steps
    #[arg(long, value_name = "NAME", default_value = "rough",
          value_parser = PossibleValuesParser::new(Profile::all().iter().map(|own| own.name)))]
    rig: String,
    /// Numbers of `[truth]`, `[scatter]` and `[sensors]` to try instead of every profile's
    #[arg(long, value_name = "FILE")]
    with: Option<PathBuf>,
    /// Seeds of the simulated rigs; the median over them is shown
    #[arg(long, value_name = "SEED", value_delimiter = ',', default_values_t = [201, 202, 203])]
    seeds: Vec<u64>,
    /// Repeats of one push on each surface; 0 for none
    #[arg(long, value_name = "N", default_value_t = 300)]
    repeats: usize,
    /// Leave out the table of steps
    #[arg(long)]
    repeats_alone: bool,
    /// Leave out the learning curves
    #[arg(long)]
    quick: bool,
    /// Write a page with the whole table here, such as docs/rig-calibration.md
    #[arg(short, long, value_name = "FILE", requires = "data",
          conflicts_with_all = ["with", "repeats_alone", "quick"])]
    output: Option<PathBuf>,
}

const PAGE: &str = "\
# How near a rough rig is to real ones

Numbers of the simulated rig `RIG`, and of the published surfaces (REPEATS repeats of a push on each), beside what
was measured: the public table of one-step pushes *MIT square, 20 mm/s, 0.2 s*, and the scatter of 2000 repeats
of a push of 150 mm that its collectors published. Simulated numbers are medians over seeds SEEDS.
**REACHED.** Made by

```sh
cargo xtask rig-calibration --data DIR -o docs/rig-calibration.md
```

";

/// A rig with all that a profile says of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Rig {
    #[serde(skip)]
    nominal: Nominal,
    truth: Truth,
    scatter: Scatter,
    sensors: Sensors,
}

/// Simulates, compares and prints.
///
/// # Errors
/// Files that cannot be read; a push that cannot be simulated; a model that cannot be learned.
pub fn run(args: &Args) -> Result<()> {
    let measured = match &args.data {
        Some(data) if !args.repeats_alone => measured(data, args.quick)?,
        _ => None,
    };
    if args.output.is_some() && measured.is_none() {
        bail!(
            "a page needs the measured steps: name the folder that has mit-push-table with --data"
        );
    }
    let seeds = if args.repeats_alone { &[] } else { &args.seeds[..] };
    let rig = Rig::of(&args.rig, args.with.as_deref())?;
    let simulated = seeds.iter().map(|&seed| {
        let steps = table::simulated(&rig, seed)?;
        Described::of(&steps, args.quick).with_context(|| format!("seed {seed}"))
    });
    let simulated = simulated.collect::<Result<Vec<_>>>()?;
    let mut rows = described::rows(&simulated, measured.as_ref());
    if args.repeats > 0 {
        rows.extend(repeats::rows(args.with.as_deref(), &args.seeds, args.repeats)?);
    }
    let reached = rows.iter().filter_map(Row::is_within);
    let (n_reached, n) = reached.fold((0, 0), |(yes, all), own| (yes + usize::from(own), all + 1));
    let table = text(&rows);
    let reached = format!("{n_reached} of {n} within a factor of {}", row::ALLOWED);
    println!("{table}{reached}");
    if let Some(path) = &args.output {
        let seeds = args.seeds.iter().map(u64::to_string).collect::<Vec<_>>().join(", ");
        let page = PAGE
            .replace("RIG", &args.rig)
            .replace("SEEDS", &seeds)
            .replace("REPEATS", &args.repeats.to_string())
            .replace("REACHED", &reached);
        output::write(path, page + &table)?;
    }
    Ok(())
}

/// The real table of steps, where the folder has it.
fn measured(data: &Path, quick: bool) -> Result<Option<Described>> {
    let folder = data.join("mit-push-table");
    if !folder.exists() {
        eprintln!("left out: {} is not there", folder.display());
        return Ok(None);
    }
    Ok(Some(Described::of(&table::measured(&folder)?, quick)?))
}

impl Rig {
    /// A profile's rig, with the numbers of a file instead of its own.
    fn of(name: &str, with: Option<&Path>) -> Result<Self> {
        let profile = Profile::named(name).with_context(|| format!("there is no rig `{name}`"))?;
        let nominal = profile.nominal();
        let (truth, scatter, sensors) =
            (profile.truth(&nominal), profile.scatter(), profile.sensors());
        let rig = Self { nominal, truth, scatter, sensors };
        let Some(path) = with else { return Ok(rig) };
        let context = || format!("cannot read {}", path.display());
        let text = fs::read_to_string(path).with_context(context)?;
        let mut merged = Table::try_from(&rig)?;
        merge(&mut merged, text.parse().with_context(context)?);
        let mut changed: Self = merged.try_into().with_context(context)?;
        changed.nominal = nominal;
        if changed == rig {
            bail!("{} changes nothing", path.display());
        }
        Ok(changed)
    }
}

/// Puts the values of one table into another; tables within are merged, too.
fn merge(into: &mut Table, from: Table) {
    for (key, value) in from {
        match (into.get_mut(&key), value) {
            (Some(Value::Table(below)), Value::Table(values)) => merge(below, values),
            (_, value) => drop(into.insert(key, value)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Rig;

    #[test]
    fn a_file_changes_single_numbers_and_names_what_it_does_not_know() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("try.toml");
        let with = |text: &str| {
            std::fs::write(&path, text).unwrap();
            Rig::of("rough", Some(&path))
        };
        let plain = Rig::of("rough", None).unwrap();
        let changed = with("[truth.underside]\nhollow = 0.001\n").unwrap();
        assert_eq!(changed.truth.underside.hollow, 0.001);
        assert_eq!(changed.scatter, plain.scatter);
        assert!(format!("{:#}", with("[truth]\nx = 1\n").unwrap_err()).contains("`x`"));
        assert!(with("").unwrap_err().to_string().contains("changes nothing"));
    }
}
