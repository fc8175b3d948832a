//! Recording sets with a sealed truth.

use std::path::{Path, PathBuf};

use dataset::{RecordingWriter, all_writers};
use output::{Existing, OutputFile, OutputFolder};
use rayon::iter::ParallelIterator;

use crate::recording::pushed_object::{manifest_text, streams_text};
use crate::recording::sealed_truth::{SealedPush, SealedTruth};
use crate::recording::simulate::Set;
use crate::{GenerateSettings, PlantError, SimulatedPush};

const SESSIONS_HEADER: &str = "recording,session,repeat\n";

/// What was made.
#[derive(Clone, Debug, PartialEq)]
pub struct GenerateReport {
    /// The recording set's folder.
    pub set: PathBuf,
    /// The file with the truth, beside it.
    pub sealed_truth: PathBuf,
    /// Number of pushes.
    pub n_pushes: usize,
    /// Pushes of the grid left out because the tip would have begun inside the object.
    pub n_blocked: usize,
    /// Time that all the pushes take on the rig, in s.
    pub rig_time: f64,
}

/// Where a recording set goes, and the truth beside it.
#[derive(Debug)]
pub struct SetOutput {
    folder: OutputFolder,
    sealed_truth: OutputFile,
    comment: String,
}

impl SetOutput {
    /// Takes the places of a new or empty folder and of `OUT.truth.toml` beside it.
    ///
    /// # Errors
    /// `Output` if `out` has no name of its own (as `.`), has files in it or cannot be written, or
    /// if the file for its truth is there.
    pub fn new(out: &Path) -> Result<Self, PlantError> {
        Self::apart_from(&[], out)
    }

    /// The same, and makes sure first that neither is one of the inputs, or lies in one.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn apart_from(inputs: &[PathBuf], out: &Path) -> Result<Self, PlantError> {
        let folder = OutputFolder::apart_from(inputs, out, Existing::Refuse)?;
        let name = out.file_name().unwrap_or_default().to_string_lossy();
        let path = out.with_file_name(format!("{name}.truth.toml"));
        let sealed_truth = OutputFile::apart_from(inputs, &path, Existing::Refuse)?;
        Ok(Self { folder, sealed_truth, comment: String::new() })
    }

    /// The same with lines at the end of the truth, as `# made by …`.
    #[must_use]
    pub fn with_comment(self, comment: String) -> Self {
        Self { comment, ..self }
    }
}

/// Simulates pushes and writes them as a recording set, with the truth sealed in a file beside it.
///
/// `out` gets `dataset.toml`, `sessions.csv` and `pushes/`; the truth goes to `OUT.truth.toml`,
/// which nothing else reads. The same settings give the same bytes on any machine and any number of
/// threads.
///
/// # Errors
/// As [`SetOutput::new`] and [`generate_each`].
pub fn generate(settings: &GenerateSettings, out: &Path) -> Result<GenerateReport, PlantError> {
    generate_each(settings, SetOutput::new(out)?, |_| {})
}

/// As [`generate`], and calls `after_push` after each push, in no certain order, with the number of
/// pushes that the set will have.
///
/// The folder appears when it is whole, after the truth: there is no set without its truth.
///
/// # Errors
/// An error of the settings; `Push` with the name of a push that could not be simulated; `Output`
/// if a file cannot be written.
pub fn generate_each(
    settings: &GenerateSettings,
    out: SetOutput,
    after_push: impl Fn(usize) + Sync,
) -> Result<GenerateReport, PlantError> {
    let writer = writer(&settings.format)?;
    let set = Set::new(settings)?;
    let part = out.folder.begin()?;
    let pushes_folder = part.path().join("pushes");
    let written = set.pushes().map(|push| {
        let push = push?;
        writer.write(&push.recording, &pushes_folder)?;
        after_push(set.plan.len());
        let SimulatedPush { plan, variation, start, trajectory, recording } = push;
        let place = [start.position.x, start.position.y, start.angle];
        let sealed = SealedPush { recording: recording.name, plan, place, variation };
        Ok((sealed, trajectory.duration()))
    });
    let (pushes, durations): (Vec<_>, Vec<f64>) =
        written.collect::<Result<Vec<_>, PlantError>>()?.into_iter().unzip();
    let sessions = pushes.iter().map(|push| {
        format!("{},session-{},{}\n", push.recording, push.plan.session, push.plan.repeat)
    });
    let sessions: String = std::iter::once(SESSIONS_HEADER.to_owned()).chain(sessions).collect();
    part.write("sessions.csv", sessions)?;
    let n_pushes = pushes.len();
    let format = writer.format();
    let manifest = manifest_text(&settings.name, &settings.object, &settings.nominal, format)
        + &streams_text(format, &settings.sensors);
    part.write(dataset::MANIFEST_NAME, manifest)?;
    let report = GenerateReport {
        set: out.folder.path().to_owned(),
        sealed_truth: out.sealed_truth.path().to_owned(),
        n_pushes,
        n_blocked: set.n_blocked,
        rig_time: durations.iter().sum(),
    };
    let truth = SealedTruth::new(settings, &set, pushes).to_text()?;
    out.sealed_truth.write(truth + &out.comment)?;
    out.folder.finish(part)?;
    Ok(report)
}

fn writer(name: &str) -> Result<&'static dyn RecordingWriter, PlantError> {
    let found = all_writers().iter().find(|writer| writer.id() == name);
    found.copied().ok_or_else(|| PlantError::UnknownFormat {
        name: name.to_owned(),
        allowed: all_writers().iter().map(|writer| writer.id()).collect::<Vec<_>>().join(", "),
    })
}
