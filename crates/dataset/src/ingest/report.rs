//! What became of every recording and push, and what the set covers.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use serde::{Deserialize, Serialize};

use crate::curves::noise::median;
use crate::ingest::first_contact::FirstContact;
use crate::ingest::force_zero::ForceZero;
use crate::ingest::push::Exclusion;
use crate::ingest::repair::RepairKind;
use crate::ingest::settings::IngestSettings;
use crate::manifest::part::Part;
use crate::remark::{Remark, StreamRole};
use crate::table::coverage::Coverage;

/// The report of an ingest; [`IngestReport::to_text`] is for people, serde for programs.
///
/// Read again, it is what [`merge_each`](crate::merge_each) takes, and has no summary: that follows from the rows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct IngestReport {
    /// Version of this report's form.
    pub schema: String,
    /// The tool and its version.
    pub tool: String,
    /// Title of the set.
    pub name: String,
    /// Which part of the set was read, if not all of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<Part>,
    /// The preset that stood in for a manifest, if any.
    pub preset: Option<String>,
    /// What lies beside the recordings and was not read, and what `sessions.csv` does not say.
    pub remarks: Vec<Remark>,
    /// How recordings became rows.
    pub settings: IngestSettings,
    /// Findings over the set.
    #[serde(skip_deserializing)]
    pub summary: Summary,
    /// One entry a recording, in the order of their names.
    pub recordings: Vec<RecordingReport>,
}

/// Findings over the set.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Summary {
    /// Pushes with rows.
    pub pushes_used: usize,
    /// Pushes and recordings excluded, by reason.
    pub excluded: BTreeMap<String, usize>,
    /// Rows of the table.
    pub rows: usize,
    /// Steps lost because a stream had a gap at their start or end.
    pub steps_lost_in_gaps: u32,
    /// Pushes whose contact ends while the pusher goes on.
    pub contacts_lost: usize,
    /// Rate of each stream over the recordings, in Hz.
    pub rates_hz: BTreeMap<StreamRole, Spread>,
    /// Repairs over all recordings, by stream.
    pub repairs: BTreeMap<StreamRole, BTreeMap<RepairKind, u32>>,
    /// Recordings whose force zero was found.
    pub tared: usize,
    /// Recordings whose force zero is not known, by reason.
    pub untared: BTreeMap<String, usize>,
    /// Pushes that leave more than half of μ·m·g on the sensor at rest: a zero that is lost, or a
    /// pusher that still presses.
    pub force_left_at_rest: usize,
    /// Support friction times weight, μ·m·g, as the manifest states them.
    pub nominal_force_n: Option<Spread>,
    /// Steady force of the tared pushes.
    pub steady_force_n: Option<Spread>,
    /// Steady force as recorded of untared pushes that leave less than a tenth of μ·m·g on the
    /// sensor at rest, so that their zero cannot be far off.
    pub steady_force_untared_n: Option<Spread>,
    /// Noise of the object's resting samples, position per axis.
    pub resting_position_sd_m: Option<Spread>,
    /// Noise of the object's resting samples, yaw.
    pub resting_angle_sd_rad: Option<Spread>,
    /// Largest tilt of the object.
    pub max_tilt_rad: f64,
    /// Where the rows lie.
    pub coverage: Coverage,
}

/// Median and range of a quantity over recordings or pushes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Smallest.
    pub low: f64,
    /// Median.
    pub median: f64,
    /// Largest.
    pub high: f64,
    /// How many values.
    pub n: usize,
}

impl Spread {
    pub(crate) fn of(values: &[f64]) -> Option<Self> {
        Some(Self {
            low: values.iter().copied().reduce(f64::min)?,
            median: median(values)?,
            high: values.iter().copied().reduce(f64::max)?,
            n: values.len(),
        })
    }
}

/// One recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordingReport {
    /// Its name.
    pub name: String,
    /// Where it was read from.
    pub path: PathBuf,
    /// SHA-256 of its bytes; empty if it could not be read.
    pub sha256: String,
    /// Measuring session, where one is known.
    pub session: Option<String>,
    /// Support friction times weight of its object, μ·m·g, as the manifest states them; none where it does not.
    pub nominal_force_n: Option<f64>,
    /// Why the whole recording was excluded.
    pub excluded: Option<Exclusion>,
    /// What reading it had to replace, skip or warn about.
    pub remarks: Vec<Remark>,
    /// Its streams.
    pub streams: Vec<StreamReport>,
    /// What is known of the force's zero.
    pub force_zero: ForceZero,
    /// Times at which the force rose far from the object: no contacts.
    pub unconfirmed_contacts: usize,
    /// Times without a sample of pusher and object, from the last before to the first after, at which the log
    /// is cut, in s.
    pub pauses_s: Vec<[f64; 2]>,
    /// How often the outline passes under the tip, or is carried past it: no pushes.
    pub passes: usize,
    /// Noise of the object's samples at rest.
    pub resting_noise: Option<RestingNoise>,
    /// Its pushes.
    pub pushes: Vec<PushReport>,
}

impl RecordingReport {
    /// Whether its pushes have ends and no streams.
    pub(crate) fn is_of_ends(&self) -> bool {
        self.streams.is_empty()
    }

    /// Of a recording before anything of it is read.
    pub(crate) fn unread(name: &str, path: &Path) -> Self {
        Self {
            name: name.to_owned(),
            path: path.into(),
            sha256: String::new(),
            session: None,
            nominal_force_n: None,
            excluded: None,
            remarks: Vec::new(),
            streams: Vec::new(),
            force_zero: ForceZero::NoForce,
            unconfirmed_contacts: 0,
            pauses_s: Vec::new(),
            passes: 0,
            resting_noise: None,
            pushes: Vec::new(),
        }
    }
}

/// Noise of samples at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RestingNoise {
    /// Per axis, in m.
    pub position_sd_m: f64,
    /// In rad.
    pub angle_sd_rad: f64,
    /// How many samples it rests on.
    pub n_samples: usize,
}

/// One stream of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StreamReport {
    /// Which.
    pub stream: StreamRole,
    /// Topic, file or data set.
    pub source: String,
    /// Samples in the log.
    pub samples_read: usize,
    /// Samples after repair.
    pub samples_used: usize,
    /// Samples that the span would hold at the rate of the set's fastest recording; known once the
    /// whole set is read.
    pub samples_due: Option<usize>,
    /// One over the median spacing.
    pub rate_hz: Option<f64>,
    /// First and last stamp on the recording's clock.
    pub span_s: [f64; 2],
    /// Longest time between samples.
    pub longest_gap_s: f64,
    /// Whether backward stamps were made monotone in the order of rows; else they were sorted.
    pub kept_row_order: bool,
    /// Farthest step back of a stamp.
    pub largest_step_back_s: f64,
    /// Longest jump, 0 if there is none.
    pub largest_jump_m: f64,
    /// Largest tilt; 0 for forces.
    pub max_tilt_rad: f64,
    /// Repairs and findings over the whole stream.
    pub repairs: BTreeMap<RepairKind, u32>,
}

/// One push.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PushReport {
    /// 0-based number within the recording.
    pub push: u32,
    /// Why it was excluded; none if it was used.
    pub excluded: Option<Exclusion>,
    /// Rows in the table.
    pub rows: usize,
    /// Steps lost because a stream had a gap at their start or end.
    pub steps_lost_in_gaps: u32,
    /// First contact, on the recording's clock.
    pub contact_start_s: f64,
    /// Last contact.
    pub contact_end_s: f64,
    /// When the object came to rest.
    pub rest_s: f64,
    /// Whether contact was there from the first common sample on.
    pub starts_in_contact: bool,
    /// Whether the contact ends while the pusher goes on.
    pub contact_lost: bool,
    /// Where the push begins; none where a stream has no samples then.
    pub first_contact: Option<FirstContact>,
    /// The streams between first contact and rest.
    pub streams: Vec<StreamInPush>,
    /// Median magnitude of the force in the middle half of the contact; none if untared.
    pub steady_force_n: Option<f64>,
    /// Largest magnitude of the force in contact; none if untared.
    pub peak_force_n: Option<f64>,
    /// Median magnitude of the force as recorded, no zero subtracted, in the middle half of the
    /// contact.
    pub recorded_force_n: Option<f64>,
    /// Magnitude of the mean force as recorded after the object came to rest.
    pub resting_force_n: Option<f64>,
    /// Noise of the object's samples in contact, which includes jitter of their stamps.
    pub moving_noise: Option<RestingNoise>,
}

/// One stream during a push.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StreamInPush {
    /// Which.
    pub stream: StreamRole,
    /// Samples.
    pub samples: usize,
    /// Longest time without a sample.
    pub longest_gap_s: f64,
    /// Repairs and findings.
    pub repairs: BTreeMap<RepairKind, u32>,
}
