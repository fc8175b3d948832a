//! A recording set goes in, the step table and its report come out, recording by recording and in
//! parallel.

pub(crate) mod contact;
pub(crate) mod first_contact;
pub(crate) mod force_zero;
pub(crate) mod interval;
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

use std::{collections::BTreeMap, path::Path};

use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};

use crate::ingest::force_zero::ForceZero;
use crate::ingest::process::{Setup, process, unreadable};
use crate::ingest::push::Exclusion;
use crate::ingest::report::{IngestReport, RecordingReport, Spread, Summary};
use crate::ingest::settings::IngestSettings;
use crate::ingest::whole_push::whole_pushes;
use crate::input::caught::caught;
use crate::manifest::recording_set::RecordingSet;
use crate::table::step::StepRow;
use crate::table::{Provenance, Table};
use crate::{error::DatasetError, remark::StreamRole};

/// The tool's name and version, as files carry it.
pub(crate) const TOOL: &str = concat!("pushlab ", env!("CARGO_PKG_VERSION"));

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
/// is excluded with its reason in the report.
///
/// # Errors
/// `Setting` for a setting out of range; `NothingUsable` if no push gave rows; what the sink
/// returns.
pub fn ingest_each(
    set: &RecordingSet,
    settings: &IngestSettings,
    mut sink: impl FnMut(&RecordingReport, Vec<StepRow>) -> Result<(), DatasetError>,
) -> Result<IngestReport, DatasetError> {
    settings.validate()?;
    let mut report = IngestReport {
        schema: "pushlab.ingest-report/1",
        tool: TOOL,
        name: set.manifest().name.clone(),
        preset: set.preset().map(|preset| preset.name()),
        remarks: set.remarks().to_vec(),
        settings: settings.clone(),
        summary: Summary::default(),
        recordings: Vec::with_capacity(set.recordings().len()),
    };
    let mut collected = Collected::default();
    for chunk in set.recordings().chunks(RECORDINGS_PER_THREAD * rayon::current_num_threads()) {
        let done: Vec<_> = chunk.par_iter().map(|path| one_file(set, path, settings)).collect();
        for (rows, recording) in done.into_iter().flatten() {
            collected.add(&mut report.summary, &rows, &recording, set);
            sink(&recording, rows)?;
            report.recordings.push(recording);
        }
    }
    collected.finish(&mut report);
    if report.summary.pushes_used == 0 {
        return Err(nothing_usable(set, &report));
    }
    Ok(report)
}

/// What a table of this ingest carries: tool, settings, and the hash of every source.
#[must_use]
pub fn provenance(set: &RecordingSet, report: &IngestReport) -> Provenance {
    let mut provenance = Provenance::default();
    provenance.push("tool", report.tool);
    provenance.push("set", &report.name);
    if let Some(preset) = report.preset {
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

fn nothing_usable(set: &RecordingSet, report: &IngestReport) -> DatasetError {
    let first = report.recordings.iter().find_map(|recording| {
        let reason =
            recording.excluded.iter().chain(recording.pushes.iter().flat_map(|p| &p.excluded));
        reason.into_iter().next()
    });
    DatasetError::NothingUsable {
        path: set.dir().into(),
        recordings: report.recordings.len(),
        reason: first.map_or_else(|| "no push found".to_owned(), ToString::to_string),
    }
}

/// Values whose medians the summary states.
#[derive(Default)]
struct Collected {
    steady_force: Vec<f64>,
    steady_force_untared: Vec<f64>,
    nominal_force: Vec<f64>,
    rates: BTreeMap<StreamRole, Vec<f64>>,
    resting_position: Vec<f64>,
    resting_angle: Vec<f64>,
}

impl Collected {
    fn add(
        &mut self,
        summary: &mut Summary,
        rows: &[StepRow],
        recording: &RecordingReport,
        set: &RecordingSet,
    ) {
        summary.rows += rows.len();
        for row in rows {
            summary.coverage.add(row);
        }
        let count = |counts: &mut BTreeMap<String, usize>, key: &str| {
            *counts.entry(key.to_owned()).or_default() += 1;
        };
        let excluded = recording.pushes.iter().filter_map(|push| push.excluded.as_ref());
        for reason in recording.excluded.iter().chain(excluded) {
            match reason {
                // Told at once for all of them.
                Exclusion::OtherShape { pushes, .. } => {
                    *summary.excluded.entry(reason.name().to_owned()).or_default() += pushes;
                }
                _ => count(&mut summary.excluded, reason.name()),
            }
        }
        for stream in &recording.streams {
            self.rates.entry(stream.stream).or_default().extend(stream.rate_hz);
            let repairs = summary.repairs.entry(stream.stream).or_default();
            for (kind, n) in &stream.repairs {
                *repairs.entry(*kind).or_default() += n;
            }
            if stream.stream == StreamRole::Object {
                summary.max_tilt_rad = summary.max_tilt_rad.max(stream.max_tilt_rad);
            }
        }
        match &recording.force_zero {
            ForceZero::NoForce => {}
            ForceZero::Tared { .. } => summary.tared += 1,
            ForceZero::Untared { reason } => count(&mut summary.untared, reason.name()),
        }
        let support = set.manifest().support;
        let object = set.manifest().object.of(&recording.name).ok();
        let nominal_force = object
            .map(|object| support.friction * object.mass * support.gravity)
            .filter(|force| *force > 0.0);
        self.nominal_force.extend(nominal_force);
        for push in &recording.pushes {
            summary.contacts_lost += usize::from(push.contact_lost);
            summary.pushes_used += usize::from(push.excluded.is_none());
            summary.steps_lost_in_gaps += push.steps_lost_in_gaps;
            let left =
                push.resting_force_n.zip(nominal_force).map(|(left, nominal)| left / nominal);
            summary.force_left_at_rest += usize::from(left.is_some_and(|left| left > 0.5));
            self.steady_force.extend(push.steady_force_n);
            if push.steady_force_n.is_none() && left.is_some_and(|left| left < 0.1) {
                self.steady_force_untared.extend(push.recorded_force_n);
            }
        }
        if let Some(noise) = recording.resting_noise {
            self.resting_position.push(noise.position_sd_m);
            self.resting_angle.push(noise.angle_sd_rad);
        }
    }

    fn finish(self, report: &mut IngestReport) {
        let summary = &mut report.summary;
        summary.nominal_force_n = Spread::of(&self.nominal_force);
        summary.steady_force_n = Spread::of(&self.steady_force);
        summary.steady_force_untared_n = Spread::of(&self.steady_force_untared);
        summary.resting_position_sd_m = Spread::of(&self.resting_position);
        summary.resting_angle_sd_rad = Spread::of(&self.resting_angle);
        let rates = self.rates.iter().filter_map(|(role, rates)| Some((*role, Spread::of(rates)?)));
        summary.rates_hz = rates.collect();
        for stream in report.recordings.iter_mut().flat_map(|recording| &mut recording.streams) {
            let [first, last] = stream.span_s;
            let rate = summary.rates_hz.get(&stream.stream).map_or(0.0, |rate| rate.high);
            stream.samples_due = Some(1 + ((last - first) * rate).round() as usize);
        }
    }
}
