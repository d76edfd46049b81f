//! `fdm play`: publishes a bag over DDS, byte by byte as it was recorded.

use crate::output::{self, Failed, Json};
use clap::Args;
use models::units::Seconds;
use runtime::{Args as NodeArgs, ClockDriver, Node, RawPublisher};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;
use tokio::time::{Instant, sleep_until};

mod reel;
mod roles;

use reel::Reel;

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
    /// What is not played, and why.
    remarks: Vec<String>,
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
    json.write(&figures)?;
    match figures {
        Figures { published: 0, dropped, bag, .. } if dropped > 0 => {
            Err(Failed(format!("{bag}: all {dropped} messages were dropped")).into())
        }
        _ => Ok(()),
    }
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
        remarks: reel.remarks.clone(),
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
    let at = |at_ns: u64| begin + Duration::from_nanos(at_ns).div_f64(rate);
    let mut late_max = Duration::ZERO;
    // Stretch that is played, and the next reading of its clock.
    let mut clock: Option<(usize, u64)> = None;
    for frame in &reel.frames {
        if let Some(driver) = &mut driver {
            let newest = clock.filter(|(stretch, _)| *stretch == frame.stretch);
            let mut clock_ns = newest.map_or(frame.log_ns, |(_, clock_ns)| clock_ns);
            while clock_ns <= frame.log_ns {
                sleep_until(at(frame.at_ns - (frame.log_ns - clock_ns))).await;
                driver.set(seconds(clock_ns));
                clock_ns += CLOCK_NS;
            }
            clock = Some((frame.stretch, clock_ns));
        }
        sleep_until(at(frame.at_ns)).await;
        late_max = late_max.max(at(frame.at_ns).elapsed());
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
