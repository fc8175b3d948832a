//! A file of messages: what every container of logs hands over.

use std::ops::ControlFlow;

use crate::{error::DatasetError, remark::Remark};

/// A channel of a log: one topic from one publisher.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Channel {
    pub(crate) id: u32,
    pub(crate) topic: String,
    pub(crate) type_name: String,
    pub(crate) message_encoding: String,
    pub(crate) schema_encoding: String,
    pub(crate) schema: Vec<u8>,
    /// Messages, as far as the log tells.
    pub(crate) count: u64,
}

/// A message of a log.
pub(crate) struct Message<'a> {
    pub(crate) channel: u32,
    /// Time of logging, in ns.
    pub(crate) log_time: i64,
    pub(crate) data: &'a [u8],
    /// Byte in the file at which the message, or the chunk that holds it, begins.
    pub(crate) byte: u64,
}

/// Takes messages until it breaks, or until a limit is reached.
pub(crate) type Sink<'s> = dyn FnMut(&Message<'_>) -> Result<ControlFlow<()>, DatasetError> + 's;

/// A file of messages.
pub(crate) trait Container {
    /// The channels, by number.
    fn channels(&self) -> &[Channel];

    /// What was wrong with the file before any message was read.
    fn remarks(&self) -> &[Remark];

    /// Hands over the messages of the channels that are `wanted`, in the order of the file, and
    /// returns what had to be left out.
    ///
    /// # Errors
    /// `OverLimit`, and what the sink returns.
    fn visit(
        &self,
        wanted: &dyn Fn(u32) -> bool,
        sink: &mut Sink<'_>,
    ) -> Result<Vec<Remark>, DatasetError>;
}
