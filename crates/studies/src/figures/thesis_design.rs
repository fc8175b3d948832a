//! The thesis' whole design of pushes, simulated once and kept below `target/`.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::builder::PossibleValuesParser;
use indicatif::{ProgressBar, ProgressStyle};
use plant::{Design, GenerateSettings, Layout, Profile, SetOutput, generate_each};

use fixtures::made_once::{key, made_once};
use fixtures::rig_of;
use fixtures::workspace_root;

/// The thesis' speeds, in mm/s; each has a recording set of its own.
const SPEEDS_MM_S: [u32; 5] = [20, 50, 100, 200, 400];
/// On the square: 4 edges, 11 places, 9 directions.
const PUSHES_PER_SPEED: u64 = 4 * 11 * 9;
/// The tip rests this long before and after it moves, in s.
const RESTS: [f64; 2] = [0.5, 0.5];
/// Where the sets are kept, below `target/`, with the name of the rig.
const FOLDER: &str = "thesis-design";

/// The recording sets of the design on a rig, the slowest first: kept ones, if settings and sources
/// are still the same and no file is damaged, else new ones.
///
/// # Errors
/// A push that cannot be simulated; files that cannot be read or written.
pub(crate) fn thesis_design(profile: &Profile) -> Result<Vec<PathBuf>> {
    let settings: Vec<_> = SPEEDS_MM_S.iter().map(|&speed| settings(profile, speed)).collect();
    let folder = workspace_root().join("target").join(format!("{FOLDER}-{}", profile.name));
    made_once(&folder, &key(&settings)?, |part| simulate(&settings, profile.name, part))?;
    Ok(SPEEDS_MM_S.iter().map(|&speed| folder.join(set_name(speed))).collect())
}

/// The names of the rigs, for a command line.
pub(crate) fn rigs() -> PossibleValuesParser {
    PossibleValuesParser::new(Profile::all().iter().map(|profile| profile.name))
}

/// The rig of a name.
///
/// # Errors
/// A name that no rig has.
pub(crate) fn named(rig: &str) -> Result<&'static Profile> {
    Profile::named(rig).with_context(|| format!("there is no rig `{rig}`"))
}

fn set_name(speed_mm_s: u32) -> String {
    format!("{speed_mm_s}-mm-s")
}

fn settings(profile: &Profile, speed_mm_s: u32) -> GenerateSettings {
    let speeds = vec![1e-3 * f64::from(speed_mm_s)];
    let rig = rig_of(profile);
    let layout = Layout::Thesis;
    GenerateSettings {
        name: format!("the thesis' design at {speed_mm_s} mm/s, simulated, {}", profile.name),
        design: Design { layout, n_pushes: 0, speeds, rests: RESTS, ..Design::default() },
        seed: rig.seed + u64::from(speed_mm_s),
        ..rig
    }
}

fn simulate(settings: &[GenerateSettings], rig: &str, folder: &Path) -> Result<()> {
    let n_pushes = PUSHES_PER_SPEED * settings.len() as u64;
    eprintln!("simulating the thesis' {n_pushes} pushes once, for target/{FOLDER}-{rig}");
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} pushes, {eta} left")?;
    let bar = ProgressBar::new(n_pushes).with_style(style);
    for (settings, speed) in settings.iter().zip(SPEEDS_MM_S) {
        let out = SetOutput::new(&folder.join(set_name(speed)))?;
        generate_each(settings, out, |_| bar.inc(1))?;
    }
    bar.finish_and_clear();
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{PUSHES_PER_SPEED, Profile, SPEEDS_MM_S, settings};
    use fixtures::made_once::key;

    #[test]
    fn the_key_tells_settings_apart() {
        let all = |rig: &str| {
            let profile = Profile::named(rig).unwrap();
            SPEEDS_MM_S.map(|speed| settings(profile, speed))
        };
        let rough = all("rough");
        assert_eq!(PUSHES_PER_SPEED * rough.len() as u64, 1980);
        assert_eq!(key(&rough).unwrap(), key(&all("rough")).unwrap());
        assert_ne!(key(&rough).unwrap(), key(&rough[1..]).unwrap());
        assert_ne!(key(&rough).unwrap(), key(&all("quiet")).unwrap());
    }
}
