#![doc = include_str!("../README.md")]

// From the ground up: what comes first knows nothing of what comes after it.
mod error;
mod remark;

mod curves;

mod input;

mod recording;

mod formats;

mod writers;

mod table;

mod manifest;

mod suspicions;

mod ingest;

#[cfg(doctest)]
mod pages;

pub use error::DatasetError;
pub use formats::end_points::{is_end_points, read_end_points};
pub use formats::format::{Inspection, LogFormat, StreamInfo};
pub use formats::list::{all_formats, format_by_id};
pub use input::limits::{Limit, ReadLimits};
pub use input::map::{open_regular, read_text};
pub use recording::name::recording_name;
pub use recording::settings::{
    ColumnMap, Quantity, StreamSettings, Streams, TimeSource, WrenchFrame,
};
pub use recording::transform::{AxisSigns, Transform};
pub use recording::whole_push::{EndPoints, WholePush, WholePushes};
pub use recording::{PoseStream, Recording, WrenchStream};
pub use remark::{Remark, RemarkKind, StreamRole};

pub use curves::sample::quantile;
pub use curves::smoothing::{Smoother, smooth};
pub use curves::spline::{CubicSpline, EndCondition};
pub use ingest::first_contact::FirstContact;
pub use ingest::force_zero::{ForceZero, UntaredReason};
pub use ingest::merge::merge_each;
pub use ingest::push::Exclusion;
pub use ingest::repair::RepairKind;
pub use ingest::report::{
    IngestReport, PushReport, RecordingReport, RestingNoise, Spread, StreamInPush, StreamReport,
    Summary,
};
pub use ingest::settings::{ContactSettings, Curve, IngestSettings, RestSettings, StepLength};
pub use ingest::table_mapping::TableMapping;
pub use ingest::{ingest, ingest_each, provenance};
pub use manifest::init::{draft_manifest, find_recordings, init, unread_recordings};
pub use manifest::object::{ObjectChoice, ObjectSpec};
pub use manifest::object_support::ObjectSupport;
pub use manifest::part::Part;
pub use manifest::preset::Preset;
pub use manifest::recording_set::RecordingSet;
pub use manifest::session::Session;
pub use manifest::{MANIFEST_NAME, Manifest, PusherSpec, RecordingsSpec, SupportSpec};
pub use suspicions::{CHECKS, Check, SUSPECTED_RECORDINGS, Suspicion, suspicions};
pub use table::column::{Column, columns};
pub use table::columns_file::write_columns;
pub use table::coverage::{Coverage, Histogram};
pub use table::flags::Flags;
pub use table::named_column::{Cells, NamedColumn};
pub use table::step::{ContactForce, Phase, StepForce, StepRow};
pub use table::wrench_twist::{WrenchTwist, read_wrench_twists};
pub use table::writer::TableWriter;
pub use table::{Provenance, Table};
pub use writers::list::all_writers;
pub use writers::writer::RecordingWriter;
