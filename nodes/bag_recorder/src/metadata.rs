//! Text of `metadata.yaml` (version 9, Jazzy) and of `counts.json`.

use crate::contents::{Channel, Contents, FileContents};
use std::fmt::{Display, Write};

/// Version of the format: quality of service as YAML in words, `ros_distro`.
const VERSION: u32 = 9;

/// Text of `metadata.yaml`. `active` names the file that is being written: it is not listed, for readers refuse it.
#[must_use]
pub fn metadata_yaml(contents: &Contents, active: Option<&str>) -> String {
    let (start_ns, length_ns) = contents.start_and_length_ns();
    let topics = contents.messages().into_iter().map(|(channel, count)| topic_yaml(channel, count));
    let paths = contents.files().map(|file| format!("    - {}\n", quoted(&file.name)));
    let files = contents.files().map(file_yaml);
    let state = match active {
        Some(name) => format!("recording\n    fdm_loop_active_file: {}", quoted(name)),
        None => "closed".to_owned(),
    };
    format!(
        "rosbag2_bagfile_information:\n  version: {VERSION}\n  storage_identifier: mcap\n  duration:\n    \
         nanoseconds: {length_ns}\n  starting_time:\n    nanoseconds_since_epoch: {start_ns}\n  \
         message_count: {}\n  topics_with_message_count:{}  compression_format: \"\"\n  \
         compression_mode: \"\"\n  relative_file_paths:{}  files:{}  \
         custom_data:\n    fdm_loop_state: {state}\n  ros_distro: jazzy\n",
        contents.total(),
        list(topics),
        list(paths),
        list(files),
    )
}

/// Numbers of one run that stand beside the counts of the bag.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RunCounts {
    /// Messages received.
    pub received: u64,
    /// Messages dropped because the writer did not keep up.
    pub dropped: u64,
    /// Messages that did not arrive: gaps in the publishers' numbers.
    pub missed: u64,
    /// Messages whose log time was raised to keep the order.
    pub raised: u64,
}

/// Text of `counts.json`: messages of each topic in the finished files, and the numbers of the run that wrote it.
#[must_use]
pub fn counts_json(contents: &Contents, active: Option<&str>, run: RunCounts) -> String {
    let mut topics: Vec<(&str, u64)> = Vec::new();
    for (channel, count) in contents.messages() {
        match topics.last_mut() {
            Some((name, sum)) if *name == channel.topic => *sum += count,
            _ => topics.push((&channel.topic, count)),
        }
    }
    let topics = members(topics.into_iter());
    let files = members(contents.files().map(|file| (file.name.as_str(), file.total())));
    let state = if active.is_some() { "recording" } else { "closed" };
    let RunCounts { received, dropped, missed, raised } = run;
    format!(
        "{{\n  \"state\": \"{state}\",\n  \"messages\": {},\n  \"topics\": {topics},\n  \"files\": {files},\n  \
         \"run\": {{\"received\": {received}, \"dropped\": {dropped}, \"missed\": {missed}, \"log_time_raised\": {raised}}}\n}}\n",
        contents.total(),
    )
}

/// Members of a JSON object.
fn members<'a>(pairs: impl Iterator<Item = (&'a str, u64)>) -> String {
    let members: Vec<String> =
        pairs.map(|(name, count)| format!("\n    {}: {count}", quoted(name))).collect();
    if members.is_empty() { "{}".to_owned() } else { format!("{{{}\n  }}", members.join(",")) }
}

/// A YAML list under a key; an empty one needs its brackets.
fn list(items: impl Iterator<Item = String>) -> String {
    let items: String = items.collect();
    if items.is_empty() { " []\n".to_owned() } else { format!("\n{items}") }
}

/// A channel with its count.
fn topic_yaml(channel: &Channel, count: u64) -> String {
    let mut qos = String::new();
    for line in channel.offered_qos.lines() {
        // Writing to a string cannot fail.
        _ = writeln!(qos, "          {line}");
    }
    if qos.is_empty() {
        qos = "          []\n".to_owned();
    }
    let (name, type_name) = (quoted(&channel.topic), quoted(&channel.type_name));
    format!(
        "    - topic_metadata:\n        name: {name}\n        type: {type_name}\n        \
         serialization_format: cdr\n        offered_qos_profiles:\n{qos}        \
         type_description_hash: \"\"\n      message_count: {count}\n"
    )
}

/// A file with its times.
fn file_yaml(file: &FileContents) -> String {
    let (start_ns, length_ns) = file.start_and_length_ns();
    format!(
        "    - path: {}\n      starting_time:\n        nanoseconds_since_epoch: {start_ns}\n      duration:\n        \
         nanoseconds: {length_ns}\n      message_count: {}\n",
        quoted(&file.name),
        file.total()
    )
}

/// A string as both YAML and JSON read it.
fn quoted(text: &str) -> impl Display {
    let mut quoted = String::with_capacity(text.len() + 2);
    quoted.push('"');
    for letter in text.chars() {
        match letter {
            '"' | '\\' => quoted.extend(['\\', letter]),
            // Writing to a string cannot fail.
            _ if letter.is_control() => _ = write!(quoted, "\\u{:04x}", u32::from(letter)),
            _ => quoted.push(letter),
        }
    }
    quoted.push('"');
    quoted
}

#[cfg(test)]
mod tests;
