//! A recording set goes in, the step table and its report come out, recording by recording and in
//! parallel.

pub(crate) mod collected;
pub(crate) mod contact;
pub(crate) mod first_contact;
pub(crate) mod force_zero;
pub(crate) mod interval;
pub(crate) mod merge;
pub(crate) mod passes;
pub(crate) mod process;
pub(crate) mod push;
pub(crate) mod repair;
pub(crate) mod report;
pub(crate) mod scene;
pub(crate) mod settings;
pub(crate) mod steps;
pub(crate) mod table_mapping;
pub(crate) mod text;
pub(crate) mod track;
pub(crate) mod whole_push;

use std::path::Path;

use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};

use crate::error::DatasetError;
use crate::ingest::collected::Collected;
use crate::ingest::process::{Setup, process, unreadable};
use crate::ingest::report::{IngestReport, RecordingReport, Summary};
use crate::ingest::settings::IngestSettings;
use crate::ingest::whole_push::whole_pushes;
use crate::input::caught::caught;
use crate::manifest::recording_set::RecordingSet;
use crate::table::step::StepRow;
use crate::table::{Provenance, Table};

/// The tool's name and version, as files carry it.
pub(crate) const TOOL: &str = concat!("pushlab ", env!("CARGO_PKG_VERSION"));

/// Name and version of the report's form.
pub(crate) const SCHEMA: &str = "pushlab.ingest-report/1";

/// Recordings in memory at a time, for each thread.
const RECORDINGS_PER_THREAD: usize = 4;

/// Turns a set into a table, with a report of what became of every recording and push.
///
/// # Errors
/// As [`ingest_each`].
pub fn ingest(
    set: &RecordingSet,
    settings: &IngestSettings,
) -> Result<(Table, IngestReport), DatasetError> {
    let mut rows = Vec::new();
    let report = ingest_each(set, settings, |_, mut own| {
        rows.append(&mut own);
        Ok(())
    })?;
    Ok((Table { rows, provenance: provenance(set, &report) }, report))
}

/// Hands the rows of each recording to a sink, in the order of the recordings' names.
///
/// Recordings are read in parallel, a few at a time: memory does not grow with their number, and
/// rows and report do not depend on the number of threads. A recording or push that cannot be used
/// is excluded with its reason in the report. Of a [part](RecordingSet::in_part) the recordings of that part
/// are read; [`merge_each`](crate::merge_each) puts parts together.
///
/// # Errors
/// `Setting` for a setting out of range; `NothingUsable` if no push of a whole set gave rows; what the sink
/// returns.
pub fn ingest_each(
    set: &RecordingSet,
    settings: &IngestSettings,
    mut sink: impl FnMut(&RecordingReport, Vec<StepRow>) -> Result<(), DatasetError>,
) -> Result<IngestReport, DatasetError> {
    settings.validate()?;
    let mut report = IngestReport {
        schema: SCHEMA.to_owned(),
        tool: TOOL.to_owned(),
        name: set.manifest().name.clone(),
        part: set.part(),
        preset: set.preset().map(|preset| preset.name().to_owned()),
        remarks: set.remarks().to_vec(),
        settings: settings.clone(),
        summary: Summary::default(),
        recordings: Vec::with_capacity(set.recordings().len()),
    };
    let mut collected = Collected::default();
    for chunk in set.recordings().chunks(RECORDINGS_PER_THREAD * rayon::current_num_threads()) {
        let done: Vec<_> = chunk.par_iter().map(|path| one_file(set, path, settings)).collect();
        for (rows, mut recording) in done.into_iter().flatten() {
            recording.nominal_force_n = nominal_force(set, &recording.name);
            collected.add(&rows, &recording);
            sink(&recording, rows)?;
            report.recordings.push(recording);
        }
    }
    collected.finish(&mut report);
    // Other parts may have some.
    if report.summary.pushes_used == 0 && set.part().is_none() {
        return Err(report.nothing_usable(set.dir()));
    }
    Ok(report)
}

/// What a table of this ingest carries: tool, settings, and the hash of every source.
#[must_use]
pub fn provenance(set: &RecordingSet, report: &IngestReport) -> Provenance {
    let mut provenance = Provenance::default();
    provenance.push("tool", &report.tool);
    provenance.push("set", &report.name);
    if let Some(preset) = &report.preset {
        provenance.push("preset", preset);
    }
    let settings = serde_json::to_string(&report.settings).unwrap_or_default();
    provenance.push("settings", &settings);
    for recording in report.recordings.iter().filter(|recording| !recording.sha256.is_empty()) {
        let path = recording.path.strip_prefix(set.dir()).unwrap_or(&recording.path);
        let (hash, path) = (&recording.sha256, path.display());
        // One file may hold several.
        let of = match recording.name == set.name_of(&recording.path) {
            true => String::new(),
            false => format!(" ({})", recording.name),
        };
        provenance.push("source", &format!("sha256 {hash} {path}{of}"));
    }
    provenance
}

/// The recordings of one file: of end points it may hold several.
fn one_file(
    set: &RecordingSet,
    path: &Path,
    settings: &IngestSettings,
) -> Vec<(Vec<StepRow>, RecordingReport)> {
    let found = caught(path, || set.format().end_points(path, &set.manifest().limits));
    match found {
        Ok(Some(found)) => whole_pushes(set, path, found, settings),
        Ok(None) => vec![one_recording(set, path, settings)],
        Err(error) => vec![(Vec::new(), unreadable(&set.name_of(path), path, error))],
    }
}

fn one_recording(
    set: &RecordingSet,
    path: &Path,
    settings: &IngestSettings,
) -> (Vec<StepRow>, RecordingReport) {
    let manifest = set.manifest();
    // A format of a user's own may panic as well: one bad recording never takes the set along.
    let result = caught(path, || {
        let recording = set.read(path)?;
        let object = match manifest.object.of(&recording.name) {
            Ok(object) => object,
            Err(error) => return Ok((Vec::new(), unreadable(&recording.name, path, error))),
        };
        let session = set.session(&recording.name).map(|session| session.session.as_str());
        let (limits, pusher_radius) = (&manifest.limits, manifest.pusher.radius);
        let setup = Setup { settings, limits, pusher_radius, session };
        process(&recording, &object, &setup)
    });
    result.unwrap_or_else(|error| (Vec::new(), unreadable(&set.name_of(path), path, error)))
}

/// Support friction times weight of a recording's object, μ·m·g, in N, as the manifest states them.
fn nominal_force(set: &RecordingSet, recording: &str) -> Option<f64> {
    let support = set.manifest().support;
    let object = set.manifest().object.of(recording).ok()?;
    Some(support.friction * object.mass * support.gravity).filter(|force| *force > 0.0)
}

impl IngestReport {
    /// The error of a set of which no push gave rows.
    fn nothing_usable(&self, path: &Path) -> DatasetError {
        let first = self.recordings.iter().find_map(|recording| {
            let pushes = recording.pushes.iter().flat_map(|push| &push.excluded);
            recording.excluded.iter().chain(pushes).next()
        });
        DatasetError::NothingUsable {
            path: path.into(),
            recordings: self.recordings.len(),
            reason: first.map_or_else(|| "no push found".to_owned(), ToString::to_string),
        }
    }
}
