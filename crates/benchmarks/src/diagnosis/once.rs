//! One timed diagnosis, and the memory that its process took.

use std::time::Instant;

use anyhow::{Context, Result};
use diagnosis::{DiagnoseSettings, NoiseModel, ScreenSettings, diagnose, screen};
use models::{Analytical, PushModel};
use serde::{Deserialize, Serialize};

use super::copies::copies;

/// What was measured.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Once {
    /// Of the screen with the noise that it needs, in s.
    screen_seconds: f64,
    /// Of the whole diagnosis, in s.
    diagnosis_seconds: f64,
    /// Largest resident memory of the process, in MB.
    pub(super) peak_memory_mb: f64,
    /// What was found, for people.
    pub(super) verdict: String,
}

impl Once {
    pub(super) fn screen(&self) -> f64 {
        self.screen_seconds
    }

    pub(super) fn diagnosis(&self) -> f64 {
        self.diagnosis_seconds
    }
}

/// Times a screen and a diagnosis of so many pushes and prints them as JSON.
///
/// # Errors
/// Pushes that cannot be made; a diagnosis that fails.
pub(crate) fn once(n_pushes: usize) -> Result<()> {
    let (observations, friction) = copies(n_pushes)?;
    let nominal = Analytical::nominal(friction)?.describe()?;
    let start = Instant::now();
    let noise = NoiseModel::learn(&nominal, &[], &observations)?;
    screen(&nominal, &[], &observations, &noise, &ScreenSettings::default())?;
    let screen_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let found = diagnose(&observations, &nominal, &DiagnoseSettings::default())?.diagnosis;
    let diagnosis_seconds = start.elapsed().as_secs_f64();
    let verdict = format!("{:?} {}", found.verdict, found.identified.join(", "));
    let peak_memory_mb = peak_memory_mb()?;
    let once = Once { screen_seconds, diagnosis_seconds, peak_memory_mb, verdict };
    println!("{}", serde_json::to_string(&once)?);
    Ok(())
}

/// As Linux counts it.
pub(crate) fn peak_memory_mb() -> Result<f64> {
    let path = "/proc/self/status";
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {path}"))?;
    let kilobytes = peak(&text).with_context(|| format!("no peak of memory in {path}"))?;
    Ok(kilobytes * 1024.0 / 1e6)
}

/// The largest resident memory, in units of 1024 bytes.
fn peak(status: &str) -> Option<f64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix("kB")?.trim().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::peak;

    #[test]
    fn the_peak_is_read_from_the_system_s_words() {
        assert_eq!(peak("VmPeak:\t 9 kB\nVmHWM:\t  21504 kB\nVmRSS:\t 3 kB\n"), Some(21504.0));
        assert_eq!(peak("VmRSS:\t 3 kB\n"), None);
    }
}
