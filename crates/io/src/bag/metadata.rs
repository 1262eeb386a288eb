//! `metadata.yaml` of a rosbag2 folder.

use std::fmt::Write as _;

use crate::bag::TopicInfo;

/// The text of `metadata.yaml` for one file, in the layout of version 5. Times in nanoseconds.
pub(super) fn metadata_yaml(
    file_name: &str,
    start_nanos: i64,
    duration_nanos: i64,
    topics: &[(TopicInfo, String)],
) -> String {
    let num_messages: u64 = topics.iter().map(|(topic, _)| topic.num_messages).sum();
    let mut text = format!(
        "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n  duration:\n    nanoseconds: \
         {duration_nanos}\n  starting_time:\n    nanoseconds_since_epoch: {start_nanos}\n  message_count: \
         {num_messages}\n  topics_with_message_count:\n"
    );
    for (topic, qos) in topics {
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "    - topic_metadata:\n        name: {}\n        type: {}\n        serialization_format: {}\n        \
             offered_qos_profiles: {}\n      message_count: {}\n",
            topic.topic,
            topic.type_name,
            topic.message_encoding,
            quoted(qos),
            topic.num_messages
        );
    }
    let _ = write!(
        text,
        "  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - {file_name}\n  files:\n    \
         - path: {file_name}\n      starting_time:\n        nanoseconds_since_epoch: {start_nanos}\n      duration:\n        \
         nanoseconds: {duration_nanos}\n      message_count: {num_messages}\n"
    );
    text
}

/// A text on one line, as YAML has it in double quotes.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n"))
}
