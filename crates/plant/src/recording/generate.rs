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
    /// Pushes left out because the object tipped over or the motion could not be followed: name and reason.
    pub not_made: Vec<(String, String)>,
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
/// The folder appears when it is whole, after the truth: there is no set without its truth. A push in which
/// the object tips over, or whose motion cannot be followed, is left out and told, up to a tenth of them.
///
/// # Errors
/// An error of the settings; `Push` with the name of a push that could not be simulated, if they are more
/// than a tenth; `Output` if a file cannot be written.
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
        let push = match push {
            Err(PlantError::Push { name, source }) if source.is_of_the_motion() => {
                after_push(set.plan.len());
                return Ok(Err(PlantError::Push { name, source }));
            }
            push => push?,
        };
        writer.write(&push.recording, &pushes_folder)?;
        after_push(set.plan.len());
        let SimulatedPush { plan, variation, start, trajectory, recording } = push;
        let place = [start.position.x, start.position.y, start.angle];
        let table_friction = trajectory.table_friction();
        let sealed =
            SealedPush { recording: recording.name, plan, place, variation, table_friction };
        Ok(Ok((sealed, trajectory.duration())))
    });
    let (mut made, mut failed) = (Vec::new(), Vec::new());
    for push in written.collect::<Result<Vec<_>, PlantError>>()? {
        match push {
            Ok(push) => made.push(push),
            Err(error) => failed.push(error),
        }
    }
    let not_made = left_out(failed, set.plan.len())?;
    let (pushes, durations): (Vec<_>, Vec<f64>) = made.into_iter().unzip();
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
        not_made,
        rig_time: durations.iter().sum(),
    };
    let truth = SealedTruth::new(settings, &set, pushes).to_text()?;
    out.sealed_truth.write(truth + &out.comment)?;
    out.folder.finish(part)?;
    Ok(report)
}

/// Names and reasons of pushes that could not be made, of so many.
///
/// # Errors
/// The first of them, if they are more than a tenth.
fn left_out(failed: Vec<PlantError>, n: usize) -> Result<Vec<(String, String)>, PlantError> {
    let are_few = MOST_LEFT_OUT * failed.len() <= n;
    let told = failed.into_iter().map(|error| match error {
        PlantError::Push { name, source } if are_few => Ok((name, source.to_string())),
        error => Err(error),
    });
    told.collect()
}

/// One push in so many may be left out.
const MOST_LEFT_OUT: usize = 10;

fn writer(name: &str) -> Result<&'static dyn RecordingWriter, PlantError> {
    let found = all_writers().iter().find(|writer| writer.id() == name);
    found.copied().ok_or_else(|| PlantError::UnknownFormat {
        name: name.to_owned(),
        allowed: all_writers().iter().map(|writer| writer.id()).collect::<Vec<_>>().join(", "),
    })
}

#[cfg(test)]
mod tests {
    use super::{PlantError, left_out};

    #[test]
    fn few_pushes_that_cannot_be_made_are_named_and_many_are_an_error() {
        let failed = |n: usize| {
            let source = || PlantError::NotConverged { time: 0.5, step: 1e-5, why: "it tips" };
            let push = |k| PlantError::Push { name: format!("push-{k}"), source: source().into() };
            (0..n).map(push).collect::<Vec<_>>()
        };
        assert_eq!(left_out(Vec::new(), 0).unwrap(), Vec::new());
        let told = left_out(failed(2), 20).unwrap();
        assert_eq!(told[1].0, "push-1");
        assert!(told[1].1.contains("it tips"), "{told:?}");
        let many = left_out(failed(2), 19).unwrap_err();
        assert!(matches!(many, PlantError::Push { name, .. } if name == "push-0"));
    }
}
