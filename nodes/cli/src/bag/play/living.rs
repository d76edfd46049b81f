//! Who lives on the topics that are to be played: a recorded reading beside a live one is a lie to whoever listens.

use super::PlayArgs;
use super::reel::Reel;
use anyhow::bail;
use runtime::{Node, topics};
use std::collections::BTreeSet;
use std::time::Duration;
use tokio::time::Instant;

/// Time to hear of a graph that runs: discovery takes 0.5 s.
const LISTEN: Duration = Duration::from_millis(1500);
/// Between two looks.
const LOOK: Duration = Duration::from_millis(50);

/// What every node says, or several at a time, each for itself: nobody takes one's word for another's.
const SHARED: [&str; 8] = [
    topics::HEARTBEAT.name(),
    topics::EVENTS.name(),
    topics::DIAGNOSTICS.name(),
    topics::ROSOUT.name(),
    topics::PARAMETER_EVENTS.name(),
    topics::TF.name(),
    topics::TF_STATIC.name(),
    "transition_event",
];

/// Refuses to play into a graph that runs. Ends sooner where the play is to end.
///
/// # Errors
/// A topic that somebody publishes, and what to do.
pub(super) async fn refuse(node: &mut Node, args: &PlayArgs, reel: &Reel) -> anyhow::Result<()> {
    // Real time: under --clock nobody makes another yet.
    let mut looks = tokio::time::interval(LOOK);
    let played = played(args, reel);
    let begun = Instant::now();
    while begun.elapsed() < LISTEN {
        tokio::select! {
            _ = looks.tick() => {}
            () = node.shutdown() => return Ok(()),
        }
        if let Some(topic) = played.intersection(&node.published_topics()).next() {
            bail!("{}", told(topic));
        }
    }
    Ok(())
}

/// Topics that belong to one publisher.
fn played(args: &PlayArgs, reel: &Reel) -> BTreeSet<String> {
    let is_shared = |topic: &str| {
        SHARED.iter().any(|shared| {
            topic == *shared || topic.strip_suffix(shared).is_some_and(|front| front.ends_with('/'))
        })
    };
    let clock = args.clock.then(|| topics::CLOCK.name().to_owned());
    let own = reel.channels.iter().map(|channel| channel.topic.clone()).filter(|topic| !is_shared(topic));
    own.chain(clock).collect()
}

fn told(topic: &str) -> String {
    format!(
        "{topic} is published already in this ROS_DOMAIN_ID: a live graph would take the bag for its own printer, and \
         may pause or switch off. Stop it, or play under another ROS_DOMAIN_ID; --inputs or --topics play a part of \
         the bag, --beside-live all of it"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::scan::{Raw, Visitor};
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: PlayArgs,
    }

    /// A recorder beside it has a heart and a log too; a printer's state is one printer's, and so is the clock.
    #[test]
    fn what_every_node_says_is_nobody_s_own() {
        let mut reel = Reel::default();
        for topic in [
            "/printer/heartbeat",
            "/printer/events",
            "/rosout",
            "/diagnostics",
            "/printer/imu/transition_event",
            "/printer/printer/state",
            "/printer/sensors/hotend/temperature",
        ] {
            let (type_name, encoding, offered_qos) = ("std_msgs/msg/Empty", "cdr", "");
            reel.message(&Raw { topic, type_name, encoding, offered_qos, log_ns: 1, payload: &[0, 1, 0, 0] });
        }
        let own = |words: &[&str]| played(&Line::parse_from([&["play", "bag"], words].concat()).args, &reel);
        let topics = ["/printer/printer/state", "/printer/sensors/hotend/temperature"].map(str::to_owned);
        assert_eq!(own(&[]), topics.clone().into());
        let with_clock = topics.into_iter().chain(["/clock".to_owned()]).collect();
        assert_eq!(own(&["--clock"]), with_clock);
    }
}
