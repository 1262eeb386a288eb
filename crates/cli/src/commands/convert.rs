//! A bag, or a part of it, as a bag of ROS 2 in MCAP, with all its messages.

use std::{collections::BTreeSet, path::Path};

use anyhow::{Result, anyhow, bail};
use visloc_io::{
    bag::{BagMessages, BagTopics, BagWriter, BagWriterOptions, Channel},
    sequence::SequenceRange,
    sources::{SourceAddress, notes_on_folder},
};

use super::cut::{Cut, Verdict};
use crate::{
    host::host,
    run::{Progress, prepare},
    say,
};

/// Copies the messages of a bag in a range of its images.
pub fn execute(source: &str, range: SequenceRange, out: &Path) -> Result<()> {
    prepare(source)?;
    let path = SourceAddress::parse(source)?.rest();
    let mut messages = BagMessages::open(path)?;
    notes_on_folder(Path::new(path)).iter().for_each(|note| say::note!("{note}"));
    let mut writer = BagWriter::create_with(out, BagTopics::default(), BagWriterOptions::default())?;
    let progress = Progress::new(None);
    let (mut num_messages, mut num_damaged, mut first_damage, mut end) = (0_usize, 0_u64, None, None);
    let mut strange = BTreeSet::new();
    let mut cut = Cut::new(range);
    while !host().is_stopped()
        && let Some(next) = messages.next_message()
    {
        match next {
            Ok(message) => {
                let taken = match cut.judge(message) {
                    Verdict::Take(taken) => taken,
                    Verdict::Wait => continue,
                    Verdict::End => break,
                };
                for message in &taken {
                    writer.write_copy(message)?;
                    strange.extend(strange_to_ros2(&message.channel));
                    num_messages += 1;
                }
                progress.advance();
            }
            Err(damage) if damage.is_recoverable => {
                num_damaged += 1;
                first_damage.get_or_insert(damage);
            }
            Err(damage) => end = Some(damage),
        }
    }
    writer.finish()?;
    progress.clear();
    if num_messages > 0 {
        say::line!("{}: {}", out.display(), say::count(num_messages, "message"));
    }
    strange.iter().for_each(|note| say::note!("{note}"));
    if messages.num_attachments() > 0 {
        say::note!("{} attachments are left out; only messages are copied", messages.num_attachments());
    }
    if let Some(first) = first_damage {
        say::line!(
            "{num_damaged} damaged parts, of which only what can be read is copied, which may be wrong; the first at {}: {}",
            first.origin(),
            first.reason
        );
    }
    match end {
        Some(end) if num_messages == 0 => Err(anyhow!("{}: {}", end.origin(), end.reason)),
        Some(end) => {
            let before = say::before(num_messages, "message", "written");
            Err(anyhow!("{}: {}{before}", end.origin(), end.reason))
        }
        None if host().is_stopped() => Ok(()),
        None if num_messages == 0 && range == SequenceRange::default() => {
            bail!("{source}: it has no messages")
        }
        None => match cut.why_none() {
            Some(why) => bail!("{source}: {why}"),
            None if num_messages == 0 => {
                bail!("{source}: the range that was asked for ends before it begins")
            }
            None => Ok(()),
        },
    }
}

/// What programs of ROS 2 will miss of a topic.
fn strange_to_ros2(channel: &Channel) -> Option<String> {
    let topic = &channel.topic;
    if channel.message_encoding != "cdr" {
        return Some(format!("'{topic}' is copied as it is, in the encoding '{}'", channel.message_encoding));
    }
    let has_definition = !channel.schema.is_empty() || channel.type_name.ends_with("/Empty");
    (!has_definition)
        .then(|| format!("the source has no definition of {}, the type of '{topic}'", channel.type_name))
}
