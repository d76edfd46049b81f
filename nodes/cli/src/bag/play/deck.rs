//! The participant that plays.

use super::reel::Reel;
use super::{PlayArgs, living};
use runtime::{Args as NodeArgs, ClockDriver, Node, RawPublisher, Shutdown};
use std::collections::BTreeMap;
use std::sync::Arc;
use tokio::sync::Notify;

/// A node that publishes the topics of a reel. It does not end where it hears nothing any more: another one takes its place.
pub(super) struct Deck {
    pub(super) publishers: Vec<RawPublisher>,
    pub(super) driver: Option<ClockDriver>,
    pub(super) shutdown: Shutdown,
    /// What it sends may not arrive any more.
    pub(super) deaf: Arc<Notify>,
    _node: Node,
}

impl Deck {
    /// Joins the graph.
    ///
    /// # Errors
    /// What keeps the participant from starting.
    pub(super) fn join(args: &PlayArgs, reel: &Reel) -> anyhow::Result<Self> {
        let (node, deaf) = start(args)?;
        Self::with(node, deaf, args, reel)
    }

    /// Joins the graph, and plays only where nobody lives there.
    ///
    /// # Errors
    /// As [`Deck::join`]; who lives there.
    pub(super) async fn join_alone(args: &PlayArgs, reel: &Reel) -> anyhow::Result<Self> {
        let (mut node, deaf) = start(args)?;
        living::refuse(&mut node, args, reel).await?;
        Self::with(node, deaf, args, reel)
    }

    fn with(mut node: Node, deaf: Arc<Notify>, args: &PlayArgs, reel: &Reel) -> anyhow::Result<Self> {
        let publishers = reel
            .channels
            .iter()
            .map(|channel| node.publish_raw(&channel.topic, &channel.type_name, channel.offered))
            .collect::<Result<_, _>>()?;
        let driver = args.clock.then(|| node.drive_clock()).transpose()?;
        Ok(Self { publishers, driver, shutdown: node.shutdown_handle(), deaf, _node: node })
    }
}

/// The node, and who is told where what it sends may not arrive any more.
fn start(args: &PlayArgs) -> anyhow::Result<(Node, Arc<Notify>)> {
    let use_sim_time = ("use_sim_time".to_owned(), args.clock.to_string());
    let node_args = NodeArgs { parameters: vec![use_sim_time], ..NodeArgs::default() };
    let deaf = Arc::new(Notify::new());
    let told = Arc::clone(&deaf);
    Ok((Node::start_or("fdm_play", node_args, move || told.notify_one())?, deaf))
}

/// What became of the messages, by all participants one after the other.
#[derive(Debug, Default)]
pub(super) struct Tally {
    pub(super) published: u64,
    pub(super) dropped: u64,
    pub(super) topics: BTreeMap<String, u64>,
}

impl Tally {
    /// Adds what a participant has done; it does nothing more.
    pub(super) fn add(&mut self, deck: &Deck, reel: &Reel) {
        for (channel, publisher) in reel.channels.iter().zip(&deck.publishers) {
            self.published += publisher.sent();
            self.dropped += publisher.dropped();
            *self.topics.entry(channel.topic.clone()).or_default() += publisher.sent();
        }
    }
}
