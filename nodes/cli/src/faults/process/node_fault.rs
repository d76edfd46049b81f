//! C1, C2, C4: a node dies or hangs; it is seen, made harmless and replaced.

use super::observer::Seen;
use super::outcome::Observed;
use super::session::Session;
use super::watcher::Watcher;
use crate::faults::catalogue::{Act, ProcessSpec, Reaction};
use crate::up::fleet::Happening;
use anyhow::bail;
use models::units::Seconds;
use rustix::process::Signal;

/// Longest wait for a graph that is whole again `[s]`.
const PATIENCE_S: f64 = 12.0;
/// Longest wait for an acknowledgement that is granted `[s]`: the first temperature may not be there yet.
const ACKNOWLEDGE_S: f64 = 5.0;
/// What was acknowledged stays off: looked at for ten turns of the heaters' loop `[s]`.
const AFTER_S: f64 = 1.0;

/// What becomes of one node, in seconds from the fault.
#[derive(Debug, Default)]
struct Times {
    /// It is told that the process has ended or hangs.
    told: Option<f64>,
    /// The process is there again: started again, or continued.
    back: Option<f64>,
    /// The first heartbeat of its next run.
    beats: Option<f64>,
    /// Mode `act`, and corrections in force.
    whole: Option<f64>,
}

/// One fault of one node.
struct Trial<'a> {
    node: &'a str,
    /// SIGCONT comes then `[s]`; the process is killed where there is none.
    continued_s: Option<f64>,
    /// Run of the node before the fault.
    run: Option<u64>,
    times: Times,
    watcher: Watcher,
}

/// Kills or stops the process and looks on until all is whole again, or off for good.
pub(super) async fn run(
    session: &mut Session,
    spec: &ProcessSpec,
    reaction: Reaction,
) -> anyhow::Result<Observed> {
    let (node, continued_s) = match &spec.act {
        Act::Kill(node) => (node.as_str(), None),
        Act::Stop { node, for_s } => (node.as_str(), Some(*for_s)),
        _ => bail!("nothing that is done to a node"),
    };
    let mut trial = Trial {
        node,
        continued_s,
        run: session.run_of(node),
        times: Times::default(),
        watcher: session.watcher(),
    };
    session.graph.signal(node, if continued_s.is_some() { Signal::STOP } else { Signal::KILL })?;
    trial.look_on(session).await?;
    let mut observed = trial.observed(spec, reaction);
    if reaction == Reaction::SafeOff && trial.watcher.safe_off.is_some() {
        acknowledge(session, &mut trial.watcher, &mut observed).await?;
    }
    observed.wrong.extend(trial.watcher.off.miss());
    Ok(observed)
}

impl Trial<'_> {
    async fn look_on(&mut self, session: &mut Session) -> anyhow::Result<()> {
        loop {
            let (at, seen) = session.next().await?;
            self.take(at, &seen);
            let now_s = self.watcher.since(session.observer.now());
            if self.times.back.is_none() && self.continued_s.is_some_and(|at_s| now_s >= at_s) {
                session.graph.signal(self.node, Signal::CONT)?;
                self.times.back = Some(now_s);
            }
            let over = self.watcher.off.is_over() && self.times.beats.is_some();
            if over || self.times.whole.is_some() || now_s > self.times.back.unwrap_or(0.0) + PATIENCE_S {
                return Ok(());
            }
        }
    }

    fn take(&mut self, at: Seconds, seen: &Seen) {
        let at_s = self.watcher.since(at);
        if at_s <= 0.0 {
            return;
        }
        self.watcher.take(at, seen);
        match seen {
            Seen::Heart(name, run) if name == self.node && Some(*run) != self.run => {
                self.times.beats.get_or_insert(at_s);
            }
            Seen::Happened(Happening::Ended { name, .. } | Happening::Silent { name })
                if *name == self.node =>
            {
                self.times.told.get_or_insert(at_s);
            }
            Seen::Happened(Happening::Restarted { name, .. }) if *name == self.node => {
                self.times.back.get_or_insert(at_s);
            }
            _ => {}
        }
        // The permit is nobody's before the supervisor says so: what it said last is of its former run.
        if let (Some(since), Some(beats)) = (self.watcher.is_whole_since(), self.times.beats) {
            self.times.whole.get_or_insert(since.max(beats));
        }
    }

    fn observed(&self, spec: &ProcessSpec, reaction: Reaction) -> Observed {
        let (times, watcher) = (&self.times, &self.watcher);
        let reaction_s = match reaction {
            Reaction::Baseline => watcher.neutral,
            Reaction::Paused => watcher.paused,
            Reaction::SafeOff => watcher.safe_off,
            Reaction::None => None,
            _ => watcher.acted,
        };
        // A process that was killed is one from its end on, one that was stopped until it goes on.
        let over = if self.continued_s.is_some() { times.back } else { Some(0.0) };
        let recovered_s = times.whole.zip(over).map(|(whole, over)| whole - over);
        // A process that is replaced before anybody had to miss it changes nothing.
        let missed = self.continued_s.is_some() || watcher.acted.is_some();
        let mut observed = Observed { told_s: times.told, reaction_s, recovered_s, ..Observed::of(watcher) };
        observed.neutral_s = spec.neutral_s.filter(|_| missed).map(|_| watcher.neutral);
        let named = [
            ("told_s", times.told),
            ("acted_s", watcher.acted),
            ("neutral_s", watcher.neutral),
            ("back_s", times.back),
            ("beats_s", times.beats),
            ("paused_s", watcher.paused),
            ("safe_off_s", watcher.safe_off),
        ];
        let named = named.into_iter().filter_map(|(name, time)| Some((name, time?)));
        observed.figures.extend(named);
        if times.beats.is_none() {
            observed.wrong.push(format!("{} does not beat again", self.node));
        }
        observed
    }
}

/// A person acknowledges what was switched off: the mode returns, heat and job do not.
async fn acknowledge(
    session: &mut Session,
    watcher: &mut Watcher,
    observed: &mut Observed,
) -> anyhow::Result<()> {
    let begin = session.observer.now();
    while !super::stops::acknowledge(session, watcher).await? {
        if (session.observer.now() - begin).0 > ACKNOWLEDGE_S {
            observed.wrong.push(format!("not acknowledged within {ACKNOWLEDGE_S} s"));
            return Ok(());
        }
    }
    if !session.acts(watcher, ACKNOWLEDGE_S).await? {
        observed.wrong.push("the mode does not return".to_owned());
    }
    observed.figures.insert("acknowledged_s", (session.observer.now() - begin).0);
    session.watch(watcher, AFTER_S).await
}
