//! `fdm bag info`: every record of a bag is looked at, not its summary alone.

use super::InfoArgs;
use super::qos::offered;
use crate::output::{self, Json};
use crate::report::bag::{Bag, Counts};
use crate::report::scan::{Ended, Raw, Visitor, scan};
use anyhow::bail;
use bag_recorder::file::NOTE;
use runtime::qos::{Durability, Reliability};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// What is told of a bag.
#[derive(Debug, Default, Serialize)]
struct Figures {
    bag: String,
    bytes: u64,
    messages: u64,
    /// First and last log time `[s]`.
    begin_s: Option<f64>,
    end_s: Option<f64>,
    duration_s: f64,
    topics: BTreeMap<String, Topic>,
    files: Vec<File>,
    /// `fdm_loop` record, without the texts of the parameters.
    note: BTreeMap<String, String>,
    /// Every file is closed, and the counts are the recorder's.
    whole: bool,
    /// Messages that could not be read, as far as the files say how many they have.
    lost_messages: u64,
    /// Bytes that could not be read.
    lost_bytes: u64,
    /// What is not as it should be.
    remarks: Vec<String>,
}

#[derive(Debug, Default, Serialize)]
struct Topic {
    #[serde(rename = "type")]
    type_name: String,
    messages: u64,
    reliable: bool,
    latched: bool,
    /// The bag does not say how it was offered.
    #[serde(skip)]
    unknown: bool,
}

#[derive(Debug, Serialize)]
struct File {
    name: String,
    bytes: u64,
    messages: u64,
    state: &'static str,
    /// As those of the bag; `None` where the file does not say how many messages it has.
    lost_messages: Option<u64>,
    lost_bytes: u64,
    /// Places before the file's end that could not be read.
    damages: u64,
}

/// Longest text of a note that is told.
const NOTE_MAX: usize = 120;

#[derive(Default)]
struct Count {
    figures: Figures,
    in_file: u64,
    span_ns: Option<(u64, u64)>,
}

impl Visitor for Count {
    fn message(&mut self, raw: &Raw<'_>) {
        self.in_file += 1;
        let (first, last) = self.span_ns.unwrap_or((raw.log_ns, raw.log_ns));
        self.span_ns = Some((first.min(raw.log_ns), last.max(raw.log_ns)));
        let topics = &mut self.figures.topics;
        if !topics.contains_key(raw.topic) {
            let offered = (!raw.offered_qos.is_empty()).then(|| offered(raw.offered_qos));
            let topic = Topic {
                type_name: raw.type_name.to_owned(),
                messages: 0,
                reliable: offered.is_some_and(|end| end.reliability == Reliability::Reliable),
                latched: offered.is_some_and(|end| end.durability == Durability::TransientLocal),
                unknown: offered.is_none(),
            };
            topics.insert(raw.topic.to_owned(), topic);
        }
        if let Some(topic) = topics.get_mut(raw.topic) {
            topic.messages += 1;
        }
    }

    fn note(&mut self, name: &str, values: &BTreeMap<String, String>) {
        let short = |(_, value): &(&String, &String)| value.len() <= NOTE_MAX && !value.contains('\n');
        if name == NOTE {
            let told = values.iter().filter(short).map(|(key, value)| (key.clone(), value.clone()));
            self.figures.note.extend(told);
        }
    }
}

pub(super) fn run(args: &InfoArgs) -> anyhow::Result<()> {
    let json = Json::new(args.json.as_deref());
    json.check()?;
    let figures = figures(args)?;
    if !json.is_stdout() {
        output::line(&page(&figures))?;
    }
    json.write(&figures)
}

fn figures(args: &InfoArgs) -> anyhow::Result<Figures> {
    let bag = Bag::find(&args.bag)?;
    let mut count = Count::default();
    for file in &bag.files {
        count.in_file = 0;
        let name = file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let (state, torn) = match scan(file, &mut count)? {
            Ended::NoBag if args.bag.is_file() => {
                bail!("{}: no MCAP file; give a .mcap file or the folder of a bag", file.display())
            }
            Ended::NoBag => bail!("{}: no MCAP file", file.display()),
            Ended::Whole(_) => ("closed", None),
            Ended::Torn(torn) => {
                count.figures.remarks.push(format!("{name} {}", torn.how));
                (if name.ends_with(".active") { "active" } else { "torn" }, Some(torn))
            }
        };
        let bytes = std::fs::metadata(file).map_or(0, |found| found.len());
        let (lost_messages, lost_bytes, damages) =
            torn.map_or((Some(0), 0, 0), |torn| (torn.lost_messages, torn.lost_bytes, torn.damages));
        count.figures.messages += count.in_file;
        count.figures.lost_messages += lost_messages.unwrap_or(0);
        count.figures.lost_bytes += lost_bytes;
        let messages = count.in_file;
        count.figures.files.push(File { name, bytes, messages, state, lost_messages, lost_bytes, damages });
    }
    let mut figures = count.figures;
    #[allow(clippy::cast_precision_loss, reason = "times for people")]
    if let Some((first, last)) = count.span_ns {
        (figures.begin_s, figures.end_s) = (Some(first as f64 * 1e-9), Some(last as f64 * 1e-9));
        figures.duration_s = (last - first) as f64 * 1e-9;
    }
    figures.bag = args.bag.display().to_string();
    figures.bytes = bag.bytes();
    if let Some(folder) = folder_of(&args.bag) {
        let folder = folder.display();
        figures.remarks.push(format!("one file of the bag {folder}: `fdm bag info {folder}` tells of all"));
    }
    beside_description(&mut figures, &bag);
    figures.whole = figures.files.iter().all(|file| file.state == "closed")
        && bag.counts.is_none_or(|counts| counts.messages == figures.messages);
    if figures.files.iter().any(|file| file.state != "closed") {
        figures.remarks.push(format!(
            "`fdm recover {}` makes it whole, as far as it can be read, once no recorder writes to it",
            figures.bag
        ));
    }
    Ok(figures)
}

/// Messages of the closed files.
fn closed(figures: &Figures) -> u64 {
    figures.files.iter().filter(|file| file.state == "closed").map(|file| file.messages).sum()
}

/// What stands beside the files and describes them: what cannot be read of it, and where it says otherwise.
fn beside_description(figures: &mut Figures, bag: &Bag) {
    figures.remarks.extend(bag.broken.iter().cloned());
    match (&bag.counts, bag.stated) {
        (Some(counts), _) => compare(figures, counts),
        (None, Some(stated)) if stated != closed(figures) => {
            let closed = closed(figures);
            figures
                .remarks
                .push(format!("metadata.yaml tells of {stated} messages in closed files, not {closed}"));
        }
        _ => {}
    }
}

/// What the recorder's own counts say beside what was found.
fn compare(figures: &mut Figures, counts: &Counts) {
    let closed = closed(figures);
    if counts.messages != closed {
        figures
            .remarks
            .push(format!("the recorder counted {} messages in closed files, not {closed}", counts.messages));
    }
    if counts.run.dropped > 0 {
        let dropped = counts.run.dropped;
        figures.remarks.push(format!("{dropped} messages were dropped: the disk was slow, or nearly full"));
    }
    if counts.run.missed > 0 {
        figures.remarks.push(format!("{} messages did not arrive at the recorder", counts.run.missed));
    }
}

/// The folder of the bag that a file is a part of.
fn folder_of(file: &Path) -> Option<PathBuf> {
    let folder = std::path::absolute(file).ok()?.parent()?.to_path_buf();
    (file.is_file() && folder.join("metadata.yaml").is_file()).then_some(folder)
}

fn page(figures: &Figures) -> String {
    #[allow(clippy::cast_precision_loss, reason = "a size for people")]
    let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    let mut page = format!(
        "{}: {} messages of {} topics, {:.1} s, {:.1} MiB\n",
        figures.bag,
        figures.messages,
        figures.topics.len(),
        figures.duration_s,
        mib(figures.bytes)
    );
    // Writing to a string cannot fail.
    for file in &figures.files {
        let File { name, bytes, messages, state, .. } = file;
        _ = writeln!(page, "  {name:<40} {messages:>10} messages {:>9.1} MiB  {state}", mib(*bytes));
    }
    for (name, topic) in &figures.topics {
        let kind = match topic {
            Topic { unknown: true, .. } => "-",
            Topic { latched: true, .. } => "latched",
            Topic { reliable: true, .. } => "reliable",
            _ => "best effort",
        };
        _ = writeln!(page, "  {name:<48} {:<40} {:>10}  {kind}", topic.type_name, topic.messages);
    }
    for (key, value) in &figures.note {
        _ = writeln!(page, "  {key}: {value}");
    }
    for remark in &figures.remarks {
        _ = writeln!(page, "  ! {remark}");
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Who gives one file of a bag, or what is none, is told of the folder.
    #[test]
    fn a_file_leads_to_its_bag() {
        let folder = std::env::temp_dir().join(format!("fdm_info_{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        let mcap = folder.join("a_0.mcap");
        mcap::Writer::new(std::fs::File::create(&mcap).unwrap()).unwrap().finish().unwrap();
        let told = |bag: &Path| figures(&InfoArgs { bag: bag.to_path_buf(), json: None });
        assert!(told(&mcap).unwrap().remarks.is_empty(), "a file on its own");
        let metadata = "rosbag2_bagfile_information: {version: 9, message_count: 0}";
        std::fs::write(folder.join("metadata.yaml"), metadata).unwrap();
        let remarks = told(&mcap).unwrap().remarks;
        assert!(remarks[0].contains(&format!("`fdm bag info {}`", folder.display())), "{remarks:?}");
        assert!(told(&folder).unwrap().remarks.is_empty(), "the bag itself");
        std::fs::write(folder.join("metadata.yaml"), metadata.replace(": 0", ": 3")).unwrap();
        let remarks = told(&folder).unwrap().remarks;
        assert_eq!(remarks, ["metadata.yaml tells of 3 messages in closed files, not 0"]);
        std::fs::write(folder.join("metadata.yaml"), "[".repeat(200_000)).unwrap();
        let remarks = told(&folder).unwrap().remarks;
        assert!(
            remarks.len() == 1 && remarks[0].starts_with("metadata.yaml cannot be read: "),
            "{remarks:?}"
        );
        let error = told(&folder.join("metadata.yaml")).unwrap_err().to_string();
        assert!(error.ends_with("give a .mcap file or the folder of a bag"), "{error}");
        std::fs::remove_dir_all(folder).unwrap();
    }
}
