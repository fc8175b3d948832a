#![doc = include_str!("../README.md")]
#![deny(unsafe_code)]

mod assemble;
mod decode;
mod error;
mod format;
mod formats;
mod frames;
mod layout;
mod log;
mod map;
mod recording;
mod remark;
mod select;
mod settings;
mod transform;

mod column;
mod contact;
mod flags;
mod force_zero;
mod ingest_settings;
mod manifest;
mod noise;
mod object;
mod push;
mod repair;
mod scene;
mod smoothing;
mod spline;
mod step;
mod steps;
mod table;
mod table_csv;
mod track;

pub use error::DatasetError;
pub use format::{Inspection, LogFormat, StreamInfo, all_formats, format_by_id};
pub use recording::{PoseStream, Recording, WrenchStream};
pub use remark::{Remark, RemarkKind, StreamRole};
pub use settings::{ColumnMap, Quantity, StreamSettings, Streams, TimeSource, WrenchFrame};
pub use transform::{AxisSigns, Transform};

pub use column::{Column, columns};
pub use flags::Flags;
pub use force_zero::{ForceZero, UntaredReason};
pub use ingest_settings::{ContactSettings, Curve, IngestSettings, RestSettings, StepLength};
pub use manifest::{MANIFEST_NAME, Manifest, PusherSpec, RecordingsSpec, SupportSpec};
pub use object::{ObjectChoice, ObjectSpec};
pub use push::SetAside;
pub use repair::RepairKind;
pub use smoothing::{Smoother, smooth};
pub use spline::{CubicSpline, EndCondition};
pub use step::{ContactForce, Phase, StepForce, StepRow};
pub use table::{Provenance, Table};
