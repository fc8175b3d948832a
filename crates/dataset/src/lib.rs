#![doc = include_str!("../README.md")]
#![deny(unsafe_code)]

mod assemble;
mod banded;
mod caught;
mod channel;
mod decode;
mod error;
mod format;
mod formats;
mod frames;
mod lateness;
mod layout;
mod limits;
mod log;
mod map;
mod recording;
mod recording_name;
mod remark;
mod select;
mod settings;
mod transform;
mod unpack;
mod writer;
mod writers;

mod column;
mod contact;
mod coverage;
mod endpoints;
mod first_contact;
mod flags;
mod force_zero;
mod foreign;
mod ingest;
mod ingest_report;
mod ingest_settings;
mod ingest_text;
mod init;
mod manifest;
mod noise;
mod object;
#[cfg(doctest)]
mod pages;
#[cfg(feature = "parquet")]
mod parquet_pages;
#[cfg(feature = "parquet")]
mod parquet_read;
mod preset;
mod process;
mod push;
mod recording_set;
mod repair;
mod scene;
mod session;
mod smoothing;
mod spline;
mod step;
mod steps;
mod table;
mod table_csv;
#[cfg(feature = "parquet")]
mod table_parquet;
mod table_writer;
mod track;
mod unread;

pub use error::DatasetError;
pub use format::{Inspection, LogFormat, StreamInfo, all_formats, format_by_id};
pub use formats::find_files;
pub use limits::{Limit, ReadLimits};
pub use map::{open_regular, read_text};
pub use recording::{PoseStream, Recording, WrenchStream};
pub use recording_name::recording_name;
pub use remark::{Remark, RemarkKind, StreamRole};
pub use settings::{ColumnMap, Quantity, StreamSettings, Streams, TimeSource, WrenchFrame};
pub use transform::{AxisSigns, Transform};

pub use column::{Column, columns};
pub use coverage::{Coverage, Histogram};
pub use endpoints::{EndPoint, WrenchTwist, read_endpoints, read_wrench_twists};
pub use first_contact::FirstContact;
pub use flags::Flags;
pub use force_zero::{ForceZero, UntaredReason};
pub use foreign::TableMapping;
pub use ingest::{ingest, ingest_each, provenance};
pub use ingest_report::{
    IngestReport, PushReport, RecordingReport, RestingNoise, Spread, StreamInPush, StreamReport,
    Summary,
};
pub use ingest_settings::{ContactSettings, Curve, IngestSettings, RestSettings, StepLength};
pub use init::{draft_manifest, find_recordings, init, unread_recordings};
pub use manifest::{MANIFEST_NAME, Manifest, PusherSpec, RecordingsSpec, SupportSpec};
pub use object::{ObjectChoice, ObjectSpec};
pub use preset::Preset;
pub use push::SetAside;
pub use recording_set::RecordingSet;
pub use repair::RepairKind;
pub use session::Session;
pub use smoothing::{Smoother, smooth};
pub use spline::{CubicSpline, EndCondition};
pub use step::{ContactForce, Phase, StepForce, StepRow};
pub use table::{Provenance, Table};
pub use table_writer::TableWriter;
pub use writer::{RecordingWriter, all_writers};
