//! The channels of a log, and their schemas, as many as the limits allow.

use std::{ops::ControlFlow, path::Path};

use crate::error::DatasetError;
use crate::formats::container::{Channel, Container};
use crate::formats::decode::Schema;
use crate::input::limits::{Limit, ReadLimits};

/// A channel with its schema, or why that cannot be read.
pub(crate) struct ParsedChannel<'a> {
    pub(crate) info: &'a Channel,
    pub(crate) schema: Result<Schema, String>,
}

/// Collects the channels of one log.
pub(crate) struct ChannelList<'a> {
    path: &'a Path,
    limits: &'a ReadLimits,
    channels: Vec<Channel>,
    n_bytes: u64,
}

impl<'a> ChannelList<'a> {
    pub(crate) fn new(path: &'a Path, limits: &'a ReadLimits) -> Self {
        Self { path, limits, channels: Vec::new(), n_bytes: 0 }
    }

    /// Adds a channel.
    ///
    /// # Errors
    /// `OverLimit` for too many channels, or too many bytes in their definitions.
    pub(crate) fn push(&mut self, channel: Channel) -> Result<(), DatasetError> {
        let Channel { topic, type_name, message_encoding, schema_encoding, .. } = &channel;
        self.note([topic, type_name, message_encoding, schema_encoding], &channel.schema)?;
        self.channels.push(channel);
        let n = self.channels.len() as u64;
        self.limits.check(self.path, Limit::Channels, || "channels".into(), n)
    }

    /// Counts the bytes of a definition that is kept.
    ///
    /// # Errors
    /// `OverLimit` for too many bytes.
    pub(crate) fn note(&mut self, names: [&str; 4], schema: &[u8]) -> Result<(), DatasetError> {
        let n = names.map(str::len).iter().sum::<usize>() + schema.len();
        self.n_bytes = self.n_bytes.saturating_add(n as u64);
        let what = || "bytes in the definitions of its channels".to_owned();
        self.limits.check(self.path, Limit::SchemaBytes, what, self.n_bytes)
    }

    pub(crate) fn finish(self) -> Vec<Channel> {
        self.channels
    }
}

/// The channels of a log with their schemas.
///
/// # Errors
/// `OverLimit` for definitions with too many fields, and as the container.
pub(crate) fn parse_channels<'a>(
    path: &Path,
    container: &'a dyn Container,
    limits: &ReadLimits,
) -> Result<Vec<ParsedChannel<'a>>, DatasetError> {
    let samples = json_samples(path, container, limits)?;
    let mut n_fields = 0_u64;
    let mut parse = |info: &'a Channel| {
        let Channel { type_name, message_encoding, schema_encoding, schema, .. } = info;
        let encodings = (message_encoding.as_str(), schema_encoding.as_str());
        n_fields = n_fields.saturating_add(Schema::n_fields(encodings, schema));
        let what = || "fields in the definitions of its channels".to_owned();
        limits.check(path, Limit::SchemaFields, what, n_fields)?;
        let sample = samples.binary_search_by_key(&info.id, |(id, _)| *id).ok();
        let sample = sample.and_then(|i| samples[i].1.as_deref());
        let schema = Schema::parse(type_name, encodings, schema, sample, limits);
        Ok(ParsedChannel { info, schema })
    };
    container.channels().iter().map(&mut parse).collect()
}

/// The first message of each JSON channel, in which its fields are seen, by number.
#[expect(clippy::type_complexity, reason = "a table of two columns")]
fn json_samples(
    path: &Path,
    container: &dyn Container,
    limits: &ReadLimits,
) -> Result<Vec<(u32, Option<Vec<u8>>)>, DatasetError> {
    let json = container.channels().iter().filter(|channel| channel.message_encoding == "json");
    let mut samples: Vec<_> = json.map(|channel| (channel.id, None)).collect();
    samples.sort_by_key(|(id, _)| *id);
    samples.dedup_by_key(|(id, _)| *id);
    let ids: Vec<u32> = samples.iter().map(|(id, _)| *id).collect();
    let (mut missing, mut n_bytes) = (ids.len(), 0);
    if missing > 0 {
        container.visit(&|id| ids.binary_search(&id).is_ok(), &mut |message| {
            if let Ok(i) = ids.binary_search(&message.channel)
                && samples[i].1.is_none()
            {
                n_bytes += message.data.len() as u64;
                let what = || "bytes in the first messages of its JSON channels".to_owned();
                limits.check(path, Limit::ChunkBytes, what, n_bytes)?;
                samples[i].1 = Some(message.data.to_vec());
                missing -= 1;
            }
            Ok(if missing == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
        })?;
    }
    Ok(samples)
}
