//! MCAP, the default of rosbag2 since Iron.

use std::{collections::BTreeMap, io, path::Path, sync::Arc};

use mcap::records::Record;

use super::{BagMessage, Channel, DamagedBag, Wanted, mcap_records::Records};
use crate::bag::{BagError, TopicInfo};

/// The messages of a file in the order in which they stand there.
pub(super) struct McapFile {
    records: Records,
    wanted: Wanted,
    schemas: BTreeMap<u16, (String, String, Vec<u8>)>,
    /// Channels by number; `None` for those that nobody wants.
    channels: BTreeMap<u16, Option<Arc<Channel>>>,
}

impl McapFile {
    pub(super) fn open(path: &Path, wanted: Wanted) -> Result<Self, BagError> {
        let records = Records::open(path).map_err(|source| io_error(path, source))?;
        Ok(Self { records, wanted, schemas: BTreeMap::new(), channels: BTreeMap::new() })
    }

    /// How many attachments were passed over so far.
    pub(super) fn num_attachments(&self) -> usize {
        self.records.num_attachments
    }

    pub(super) fn next_message(&mut self) -> Option<Result<BagMessage, DamagedBag>> {
        loop {
            let record = match self.records.next_record()? {
                Ok(record) => record,
                Err(damage) => return Some(Err(damage)),
            };
            match record {
                Record::Schema { header, data } => {
                    self.schemas.insert(header.id, (header.name, header.encoding, data.into_owned()));
                }
                Record::Channel(channel) => {
                    let found = self.wanted.has(&channel.topic).then(|| {
                        let schema = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                        Arc::new(Channel {
                            topic: channel.topic,
                            type_name: schema.0,
                            message_encoding: channel.message_encoding,
                            schema_encoding: schema.1,
                            schema: schema.2,
                            metadata: channel.metadata,
                        })
                    });
                    self.channels.entry(channel.id).or_insert(found);
                }
                Record::Message { header, data } => {
                    let Some(Some(channel)) = self.channels.get(&header.channel_id) else { continue };
                    return Some(Ok(BagMessage {
                        channel: channel.clone(),
                        sequence: header.sequence,
                        log_nanos: header.log_time,
                        publish_nanos: header.publish_time,
                        data: data.into_owned(),
                    }));
                }
                _ => {}
            }
        }
    }
}

/// The topics with their counts: from the summary, or from the whole file if there is none.
pub(super) fn topics(path: &Path) -> Result<Vec<TopicInfo>, BagError> {
    let mut records = Records::open(path).map_err(|source| io_error(path, source))?;
    let mut counted = Counted::default();
    if records.go_to_summary().is_ok_and(|has_summary| has_summary) {
        while let Some(Ok(record)) = records.next_record() {
            counted.take(&record);
        }
        if counted.has_statistics && !counted.channels.is_empty() {
            return Ok(counted.channels.into_values().collect());
        }
    }
    scan(path)
}

/// Reads the whole file, for files that were cut off or have no summary. Damage ends it: what comes before counts.
fn scan(path: &Path) -> Result<Vec<TopicInfo>, BagError> {
    let mut records = Records::open(path).map_err(|source| io_error(path, source))?;
    let mut counted = Counted::default();
    let mut first_error = None;
    while let Some(next) = records.next_record() {
        match next {
            Ok(record) => counted.take(&record),
            Err(error) => first_error = first_error.or(Some(error)),
        }
    }
    match first_error {
        Some(error) if counted.channels.is_empty() => Err(BagError::NotMcap {
            path: path.to_path_buf(),
            reason: format!("{}: {}", error.place, error.reason),
        }),
        _ => Ok(counted.channels.into_values().collect()),
    }
}

/// What is known of the channels so far.
#[derive(Default)]
struct Counted {
    types: BTreeMap<u16, String>,
    channels: BTreeMap<u16, TopicInfo>,
    has_statistics: bool,
}

impl Counted {
    fn take(&mut self, record: &Record<'_>) {
        match record {
            Record::Schema { header, .. } => {
                self.types.insert(header.id, header.name.clone());
            }
            Record::Channel(channel) => {
                self.channels.entry(channel.id).or_insert_with(|| TopicInfo {
                    topic: channel.topic.clone(),
                    type_name: self.types.get(&channel.schema_id).cloned().unwrap_or_default(),
                    message_encoding: channel.message_encoding.clone(),
                    num_messages: 0,
                });
            }
            Record::Message { header, .. } => {
                if let Some(info) = self.channels.get_mut(&header.channel_id) {
                    info.num_messages += 1;
                }
            }
            Record::Statistics(statistics) => {
                // Some writers count the messages of the whole file only.
                let is_by_channel = !statistics.channel_message_counts.is_empty();
                self.has_statistics = is_by_channel || statistics.message_count == 0;
                if !self.has_statistics {
                    return;
                }
                for (id, info) in &mut self.channels {
                    info.num_messages = statistics.channel_message_counts.get(id).copied().unwrap_or(0);
                }
            }
            _ => {}
        }
    }
}

fn io_error(path: &Path, source: io::Error) -> BagError {
    BagError::Io { path: path.to_path_buf(), action: "read it", source }
}
