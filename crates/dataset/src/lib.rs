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

pub use error::DatasetError;
pub use format::{Inspection, LogFormat, StreamInfo, all_formats, format_by_id};
pub use recording::{PoseStream, Recording, WrenchStream};
pub use remark::{Remark, RemarkKind, StreamRole};
pub use settings::{ColumnMap, Quantity, StreamSettings, Streams, TimeSource, WrenchFrame};
pub use transform::{AxisSigns, Transform};
