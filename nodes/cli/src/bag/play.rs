//! `fdm play`: publishes a bag over DDS, byte by byte as it was recorded.

use crate::output::{self, Json};
use crate::report::bag::Bag;
use crate::report::scan::{Raw, Visitor, scan_what_is_there};
use anyhow::bail;
use clap::Args;
use models::units::Seconds;
use runtime::qos::{Durability, End, Reliability};
use runtime::{Args as NodeArgs, ClockDriver, Node, RawPublisher, topics};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;
use tokio::time::{Instant, sleep_until};

mod roles;

use roles::{INPUTS, OBEYED};

/// Publishes the messages of a bag on its topics.
#[derive(Debug, Args)]
pub struct PlayArgs {
    /// Folder of the bag, or one .mcap or .mcap.active file.
    bag: PathBuf,
    /// Publish /clock from the log times, for nodes with use_sim_time.
    #[arg(long)]
    clock: bool,
    /// Time of the bag over wall time.
    #[arg(long, default_value_t = 1.0)]
    rate: f64,
    /// Play these topics alone, as the bag names them or without namespace; separated by commas.
    #[arg(long, value_delimiter = ',')]
    topics: Vec<String>,
    /// Play only what printer and sensors say, for brains that run.
    #[arg(long, conflicts_with = "topics")]
    inputs: bool,
    /// Play commands and permits too: a printer that listens obeys them.
    #[arg(long)]
    commands: bool,
    /// Begin so far into the bag `[s]`.
    #[arg(long, default_value_t = 0.0)]
    start: f64,
    /// Play it so often; /clock jumps back in between.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    times: u32,
    /// Wait so long for subscribers before the first message `[s]`.
    #[arg(long, default_value_t = 1.0)]
    wait: f64,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// Simulated time between two readings of /clock `[ns]`.
const CLOCK_NS: u64 = 10_000_000;
/// Depth of a topic whose quality of service the bag does not say.
const DEPTH: usize = 10;

/// What is told of a play.
#[derive(Debug, Default, Serialize)]
struct Figures {
    bag: String,
    messages: u64,
    published: u64,
    dropped: u64,
    duration_s: f64,
    /// How late the latest message was `[s]`.
    late_max_s: f64,
    topics: BTreeMap<String, u64>,
}

/// Runs the command.
///
/// # Errors
/// One line that says what is wrong and where.
pub fn run(args: &PlayArgs) -> anyhow::Result<()> {
    crate::options::in_range("--rate", args.rate, "-", (0.01, 100.0))?;
    crate::options::in_range("--start", args.start, "s", (0.0, 1e9))?;
    crate::options::in_range("--wait", args.wait, "s", (0.0, 60.0))?;
    let json = Json::new(args.json.as_deref());
    json.check()?;
    let reel = Reel::read(&args.bag, args)?;
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let figures = executor.block_on(play(args, &reel))?;
    if !json.is_stdout() {
        let Figures { bag, published, dropped, duration_s, late_max_s, .. } = &figures;
        output::line(&format!(
            "{bag}: {published} messages in {duration_s:.1} s, {dropped} dropped, {late_max_s:.3} s late at most"
        ))?;
    }
    json.write(&figures)
}

/// A message of a reel: log time, number of its channel, where its bytes lie.
struct Frame {
    log_ns: u64,
    channel: usize,
    payload: Vec<u8>,
}

struct Channel {
    topic: String,
    type_name: String,
    offered: End,
}

/// What is to be played.
#[derive(Default)]
struct Reel {
    channels: Vec<Channel>,
    frames: Vec<Frame>,
    named: Vec<String>,
    inputs: bool,
    commands: bool,
    clock: bool,
}

impl Reel {
    fn read(bag: &Path, args: &PlayArgs) -> anyhow::Result<Self> {
        let mut reel = Self {
            named: args.topics.clone(),
            inputs: args.inputs,
            commands: args.commands,
            clock: args.clock,
            ..Self::default()
        };
        for file in Bag::find(bag)?.files {
            scan_what_is_there(&file, &mut reel)?;
        }
        let start_ns = reel.frames.first().map_or(0, |frame| frame.log_ns);
        // A cast of a float saturates.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let from_ns = start_ns.saturating_add((args.start * 1e9) as u64);
        reel.begin_at(from_ns);
        if reel.frames.is_empty() {
            bail!("{}: nothing to play", bag.display());
        }
        Ok(reel)
    }

    /// Leaves out what lies before, but for the newest word of each latched topic: who joins then hears it too.
    fn begin_at(&mut self, from_ns: u64) {
        let mut latched: BTreeMap<usize, Frame> = BTreeMap::new();
        let mut rest = Vec::new();
        for frame in std::mem::take(&mut self.frames) {
            if frame.log_ns >= from_ns {
                rest.push(frame);
            } else if self.channels[frame.channel].offered.durability == Durability::TransientLocal {
                latched.insert(frame.channel, Frame { log_ns: from_ns, ..frame });
            }
        }
        if !rest.is_empty() {
            self.frames = latched.into_values().chain(rest).collect();
        }
    }

    /// Whether a topic is played.
    fn plays(&self, topic: &str) -> bool {
        let ends =
            |name: &str| topic == name || topic.strip_suffix(name).is_some_and(|front| front.ends_with('/'));
        if topic == topics::CLOCK.name() && self.clock
            || !self.commands && OBEYED.iter().any(|name| ends(name))
        {
            return false;
        }
        // Whatever the namespace, and `/printer` is one.
        let is_input = || INPUTS.iter().any(|part| topic.contains(&format!("/{part}")));
        (self.named.is_empty() || self.named.iter().any(|name| ends(name))) && (!self.inputs || is_input())
    }
}

/// The quality of service as bags write it.
fn offered(text: &str) -> End {
    let value =
        |key: &str| text.lines().find_map(|line| line.trim().trim_start_matches("- ").strip_prefix(key));
    let says = |key: &str, word: &str| value(key).is_some_and(|value| value.trim() == word);
    End {
        reliability: if says("reliability:", "best_effort") {
            Reliability::BestEffort
        } else {
            Reliability::Reliable
        },
        durability: if says("durability:", "transient_local") {
            Durability::TransientLocal
        } else {
            Durability::Volatile
        },
        depth: value("depth:").and_then(|depth| depth.trim().parse().ok()).unwrap_or(DEPTH).clamp(1, 1000),
    }
}

impl Visitor for Reel {
    fn message(&mut self, raw: &Raw<'_>) {
        if raw.encoding != "cdr" || !self.plays(raw.topic) {
            return;
        }
        let same = |channel: &Channel| channel.topic == raw.topic && channel.type_name == raw.type_name;
        let channel = self.channels.iter().position(same).unwrap_or_else(|| {
            let (topic, type_name) = (raw.topic.to_owned(), raw.type_name.to_owned());
            self.channels.push(Channel { topic, type_name, offered: offered(raw.offered_qos) });
            self.channels.len() - 1
        });
        self.frames.push(Frame { log_ns: raw.log_ns, channel, payload: raw.payload.to_vec() });
    }

    fn note(&mut self, _: &str, _: &BTreeMap<String, String>) {}
}

async fn play(args: &PlayArgs, reel: &Reel) -> anyhow::Result<Figures> {
    let use_sim_time = ("use_sim_time".to_owned(), args.clock.to_string());
    let node_args = NodeArgs { parameters: vec![use_sim_time], ..NodeArgs::default() };
    let mut node = Node::start_with("fdm_play", node_args)?;
    let publishers: Vec<RawPublisher> = reel
        .channels
        .iter()
        .map(|channel| node.publish_raw(&channel.topic, &channel.type_name, channel.offered))
        .collect::<Result<_, _>>()?;
    let mut driver = args.clock.then(|| node.drive_clock()).transpose()?;
    let mut shutdown = node.shutdown_handle();
    tokio::time::sleep(Duration::from_secs_f64(args.wait)).await;
    let begin = Instant::now();
    let mut late_max = Duration::ZERO;
    for _ in 0..args.times {
        tokio::select! {
            late = once(args.rate, reel, &publishers, driver.as_mut()) => late_max = late_max.max(late),
            () = shutdown.wait() => break,
        }
    }
    let mut figures = Figures {
        bag: args.bag.display().to_string(),
        messages: reel.frames.len() as u64,
        duration_s: begin.elapsed().as_secs_f64(),
        late_max_s: late_max.as_secs_f64(),
        ..Figures::default()
    };
    for (channel, publisher) in reel.channels.iter().zip(&publishers) {
        figures.published += publisher.sent();
        figures.dropped += publisher.dropped();
        *figures.topics.entry(channel.topic.clone()).or_default() += publisher.sent();
    }
    // What is on its way arrives before the node goes.
    tokio::time::sleep(Duration::from_millis(200)).await;
    Ok(figures)
}

/// Plays the reel once, and tells how late the latest message was.
async fn once(
    rate: f64,
    reel: &Reel,
    publishers: &[RawPublisher],
    mut driver: Option<&mut ClockDriver>,
) -> Duration {
    let begin = Instant::now();
    let first_ns = reel.frames.first().map_or(0, |frame| frame.log_ns);
    let at = |log_ns: u64| {
        let after_ns = log_ns.saturating_sub(first_ns);
        #[allow(clippy::cast_precision_loss, reason = "a time of a bag")]
        let after_s = after_ns as f64 * 1e-9 / rate;
        begin + Duration::from_secs_f64(after_s)
    };
    let mut late_max = Duration::ZERO;
    let mut clock_ns = first_ns;
    for frame in &reel.frames {
        if let Some(driver) = &mut driver {
            while clock_ns <= frame.log_ns {
                sleep_until(at(clock_ns)).await;
                driver.set(seconds(clock_ns));
                clock_ns += CLOCK_NS;
            }
        }
        sleep_until(at(frame.log_ns)).await;
        late_max = late_max.max(at(frame.log_ns).elapsed());
        publishers[frame.channel].send(&frame.payload);
    }
    late_max
}

#[allow(clippy::cast_precision_loss, reason = "a time of a bag")]
fn seconds(ns: u64) -> Seconds {
    Seconds(ns as f64 * 1e-9)
}

#[cfg(test)]
mod tests;
