//! What is to be played, and when.

use super::PlayArgs;
use super::roles::{INPUTS, OBEYED};
use crate::bag::qos::offered;
use crate::output;
use crate::report::bag::Bag;
use crate::report::scan::{Ended, Raw, Visitor, scan};
use anyhow::bail;
use runtime::qos::{Durability, End};
use runtime::topics;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// What payloads begin with that can be sent: plain CDR, least significant byte first.
const PLAYABLE: [u8; 2] = [0, 1];
/// A topic whose own log times go back further than this tells a clock that jumped back `[ns]`: what is less came over
/// several ways.
const JUMP_NS: u64 = 1_000_000_000;
/// Longest silence that is played `[ns]`: beyond it a time is wrong.
const GAP_NS: u64 = 24 * 3600 * 1_000_000_000;

/// Latest log time that a clock of ROS can tell `[ns]`: it counts in an i64.
const LATEST_NS: u64 = i64::MAX.unsigned_abs();

/// A message of a reel.
pub(super) struct Frame {
    /// Log time `[ns]`.
    pub(super) log_ns: u64,
    /// Time into the play at which it is due, at rate 1 `[ns]`.
    pub(super) at_ns: u64,
    /// Number of the stretch between two jumps of the clock.
    pub(super) stretch: usize,
    pub(super) channel: usize,
    pub(super) payload: Vec<u8>,
}

/// A topic of a reel.
pub(super) struct Channel {
    pub(super) topic: String,
    pub(super) type_name: String,
    pub(super) offered: End,
    /// Newest log time of the stretch that is read `[ns]`.
    newest_ns: Option<u64>,
}

/// What is to be played.
#[derive(Default)]
pub(super) struct Reel {
    pub(super) channels: Vec<Channel>,
    pub(super) frames: Vec<Frame>,
    /// What is not played, and why.
    pub(super) remarks: Vec<String>,
    pub(super) named: Vec<String>,
    pub(super) inputs: bool,
    pub(super) commands: bool,
    pub(super) clock: bool,
    pub(super) stretch: usize,
    /// Messages by topic that are not of the encoding that can be sent.
    pub(super) foreign: BTreeMap<String, u64>,
    /// A message whose time cannot be.
    pub(super) odd: Option<String>,
    /// All topics that have a message.
    pub(super) held: BTreeSet<String>,
}

impl Reel {
    /// Reads a bag as the arguments want it.
    pub(super) fn read(bag: &Path, args: &PlayArgs) -> anyhow::Result<Self> {
        let mut reel = Self {
            named: args.topics.clone(),
            inputs: args.inputs,
            commands: args.commands,
            clock: args.clock,
            ..Self::default()
        };
        for file in Bag::find(bag)?.files {
            match scan(&file, &mut reel)? {
                Ended::Whole(_) => {}
                Ended::Torn(torn) => reel.remarks.push(format!("{} {}", file.display(), torn.how)),
                Ended::NoBag => bail!("{}: no MCAP file", file.display()),
            }
        }
        reel.check_names()?;
        if let Some(odd) = &reel.odd {
            bail!("{}: {odd}", bag.display());
        }
        for (topic, count) in &reel.foreign {
            reel.remarks
                .push(format!("{topic}: {count} messages are not of little-endian CDR and are not played"));
        }
        reel.order();
        reel.remarks.iter().for_each(|remark| output::note(remark));
        if reel.frames.is_empty() {
            bail!("{}: nothing to play", bag.display());
        }
        reel.begin_at(args.start)?;
        Ok(reel)
    }

    /// Refuses a name that no topic of the bag has.
    pub(super) fn check_names(&self) -> anyhow::Result<()> {
        match self.named.iter().find(|name| !self.held.iter().any(|topic| is_named(topic, name))) {
            Some(unknown) => {
                let held: Vec<&str> = self.held.iter().map(String::as_str).collect();
                bail!("--topics {unknown}: the bag has no such topic, but {}", held.join(", "));
            }
            None => Ok(()),
        }
    }

    /// Puts the messages of each stretch in the order of their log times, and the stretches one behind the other.
    pub(super) fn order(&mut self) {
        self.frames.sort_by_key(|frame| (frame.stretch, frame.log_ns));
        let (mut stretch, mut at_ns) = (0, 0);
        // Stretch as it was read, and log time.
        let mut last: Option<(usize, u64)> = None;
        for frame in &mut self.frames {
            let here = (frame.stretch, frame.log_ns);
            let (last_stretch, last_ns) = last.replace(here).unwrap_or(here);
            match frame.log_ns.checked_sub(last_ns) {
                Some(gap_ns) if last_stretch == frame.stretch && gap_ns <= GAP_NS => at_ns += gap_ns,
                // A stretch follows at once on the last message of the one before.
                _ => stretch += 1,
            }
            (frame.stretch, frame.at_ns) = (stretch, at_ns);
        }
        if stretch > 0 {
            self.remarks
                .push(format!("the clock jumped {stretch} times: what follows a jump is played at once"));
        }
    }

    /// Leaves out what lies before, but for the newest word of each latched topic: who joins then hears it too.
    pub(super) fn begin_at(&mut self, start_s: f64) -> anyhow::Result<()> {
        // A cast of a float saturates.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let from_ns = (start_s * 1e9) as u64;
        let Some(first) = self.frames.iter().find(|frame| frame.at_ns >= from_ns) else {
            #[allow(clippy::cast_precision_loss, reason = "a time of a bag")]
            let length_s = self.frames.last().map_or(0, |frame| frame.at_ns) as f64 * 1e-9;
            bail!("--start {start_s} s: must be in [0, {length_s:.3}], what is played of the bag");
        };
        let (log_ns, stretch) = (first.log_ns, first.stretch);
        let mut latched: BTreeMap<usize, Frame> = BTreeMap::new();
        let mut rest = Vec::new();
        for frame in std::mem::take(&mut self.frames) {
            if frame.at_ns >= from_ns {
                rest.push(Frame { at_ns: frame.at_ns - from_ns, ..frame });
            } else if self.channels[frame.channel].offered.durability == Durability::TransientLocal {
                latched.insert(frame.channel, Frame { log_ns, at_ns: 0, stretch, ..frame });
            }
        }
        self.frames = latched.into_values().chain(rest).collect();
        Ok(())
    }

    /// Whether a topic is played.
    pub(super) fn plays(&self, topic: &str) -> bool {
        let ends = |name: &str| is_named(topic, name);
        if topic == topics::CLOCK.name() && self.clock
            || !self.commands && OBEYED.iter().any(|name| ends(name))
        {
            return false;
        }
        // Whatever the namespace, and `/printer` is one.
        let is_input = || INPUTS.iter().any(|part| topic.contains(&format!("/{part}")));
        (self.named.is_empty() || self.named.iter().any(|name| ends(name))) && (!self.inputs || is_input())
    }

    /// Number of a channel; a new one where it is not known yet.
    fn channel(&mut self, raw: &Raw<'_>) -> usize {
        let same = |channel: &Channel| channel.topic == raw.topic && channel.type_name == raw.type_name;
        self.channels.iter().position(same).unwrap_or_else(|| {
            let (topic, type_name) = (raw.topic.to_owned(), raw.type_name.to_owned());
            self.channels.push(Channel {
                topic,
                type_name,
                offered: offered(raw.offered_qos),
                newest_ns: None,
            });
            self.channels.len() - 1
        })
    }
}

/// Whether a name, with its namespace or without, is a topic's.
fn is_named(topic: &str, name: &str) -> bool {
    topic == name || topic.strip_suffix(name).is_some_and(|front| front.ends_with('/'))
}

impl Visitor for Reel {
    fn message(&mut self, raw: &Raw<'_>) {
        if !self.held.contains(raw.topic) {
            self.held.insert(raw.topic.to_owned());
        }
        if !self.plays(raw.topic) {
            return;
        }
        if raw.encoding != "cdr" || !raw.payload.starts_with(&PLAYABLE) {
            *self.foreign.entry(raw.topic.to_owned()).or_default() += 1;
            return;
        }
        if raw.log_ns > LATEST_NS {
            let log_ns = raw.log_ns;
            let text =
                || format!("log time of a message of {}: {log_ns} ns; at most {LATEST_NS} ns", raw.topic);
            self.odd.get_or_insert_with(text);
            return;
        }
        let channel = self.channel(raw);
        if self.channels[channel].newest_ns.is_some_and(|newest| raw.log_ns.saturating_add(JUMP_NS) < newest)
        {
            self.stretch += 1;
            self.channels.iter_mut().for_each(|channel| channel.newest_ns = None);
        }
        let newest = &mut self.channels[channel].newest_ns;
        *newest = (*newest).max(Some(raw.log_ns));
        let (stretch, payload) = (self.stretch, raw.payload.to_vec());
        self.frames.push(Frame { log_ns: raw.log_ns, at_ns: 0, stretch, channel, payload });
    }

    fn note(&mut self, _: &str, _: &BTreeMap<String, String>) {}
}
