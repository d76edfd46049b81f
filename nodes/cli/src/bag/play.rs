//! `fdm play`: publishes a bag over DDS, byte by byte as it was recorded.

use crate::output::{self, Failed, Json};
use crate::suspension::Suspension;
use clap::Args;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use tokio::time::timeout;

mod deck;
mod living;
mod progress;
mod reel;
mod roles;

use deck::{Deck, Tally};
use progress::Progress;
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
    /// Play beside a live graph too: its supervisor and controller take the bag for their printer.
    #[arg(long)]
    beside_live: bool,
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

/// Who goes on after a stop is told so within this time.
const AWAKE: Duration = Duration::from_secs(1);

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
    let wait = Duration::from_secs_f64(args.wait);
    let mut deck =
        if args.beside_live { Deck::join(args, reel)? } else { Deck::join_alone(args, reel).await? };
    let mut progress = Progress::new(reel, args.rate, args.times);
    let mut suspended = Suspension::listen();
    let (mut tally, mut remarks) = (Tally::default(), reel.remarks.clone());
    loop {
        let deaf = Arc::clone(&deck.deaf);
        let mut shutdown = deck.shutdown.clone();
        tokio::select! {
            biased;
            () = shutdown.wait() => break,
            () = deaf.notified() => {}
            () = suspended.asked() => {
                Suspension::stand_still()?;
                _ = timeout(AWAKE, deaf.notified()).await;
            }
            () = progress.go(&mut deck, wait) => break,
        }
        if shutdown.is_demanded() {
            break;
        }
        let remark = format!(
            "stopped and continued, or deaf, at {:.3} s of what is played: it goes on there, by another participant",
            progress.place().0
        );
        output::note(&remark);
        remarks.push(remark);
        tally.add(&deck, reel);
        deck = Deck::join(args, reel)?;
    }
    let duration_s = progress.began.map_or(0.0, |began| began.elapsed().as_secs_f64());
    tally.add(&deck, reel);
    // What is on its way arrives before the node goes.
    tokio::time::sleep(Duration::from_millis(200)).await;
    Ok(Figures {
        bag: args.bag.display().to_string(),
        messages: reel.frames.len() as u64,
        published: tally.published,
        dropped: tally.dropped,
        duration_s,
        late_max_s: progress.late_max.as_secs_f64(),
        topics: tally.topics,
        remarks,
    })
}

#[cfg(test)]
mod tests;
