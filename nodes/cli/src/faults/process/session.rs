//! A graph that prints, and who looks on.

use super::graph::{Graph, Setting};
use super::observer::{Hand, Observer, Seen};
use super::watcher::Watcher;
use crate::faults::catalogue::Bench;
use crate::up::fleet::Happening;
use crate::up::recipes::NODES;
use anyhow::{Context, bail};
use fdm_loop_msgs::SafetyState;
use models::units::Seconds;
use std::collections::{BTreeMap, VecDeque};
use std::rc::Rc;

/// How often processes are looked after `[s]`: as `fdm up` does.
const TEND_S: f64 = 0.05;
/// Longest time from the start to a closed loop on a warm printer `[s]`.
const START_S: f64 = 45.0;
/// Longest wait for a graph that is whole, later `[s]`.
const PATIENCE_S: f64 = 30.0;
/// Longest orderly end of the nodes, and then of the recorder `[s]`: every node promises 2 s.
const END_S: f64 = 3.0;
/// How long a graph is listened for before the first one starts `[s]`.
const LISTEN_S: f64 = 1.0;

/// A graph and its observer.
pub(super) struct Session {
    /// The processes.
    pub(super) graph: Graph,
    /// Who sees.
    pub(super) observer: Observer,
    /// Who asks; shared, so that it can wait for an answer while the others are looked after.
    pub(super) hand: Rc<Hand>,
    pending: VecDeque<(Seconds, Seen)>,
    tended: Seconds,
    /// Newest run of each node that was heard.
    hearts: BTreeMap<String, u64>,
    /// The graph's clock.
    stamp_s: f64,
    /// Nodes whose process ended since it was asked for last.
    ended: Vec<&'static str>,
}

impl Session {
    /// A session in which nothing runs yet.
    pub(super) fn around(graph: Graph) -> anyhow::Result<Self> {
        let mut observer = Observer::join()?;
        let (tended, hand) = (observer.now(), Rc::new(observer.hand()?));
        let (pending, hearts, ended) = (VecDeque::new(), BTreeMap::new(), Vec::new());
        Ok(Self { graph, observer, hand, pending, tended, hearts, stamp_s: 0.0, ended })
    }

    /// Starts all nodes and waits for the closed loop.
    pub(super) async fn start(setting: &Setting, seed: u64, bench: Bench) -> anyhow::Result<Self> {
        let (graph, recipes) = Graph::prepare(setting, seed, bench)?;
        let mut session = Self::around(graph)?;
        for recipe in recipes {
            session.graph.launch(recipe)?;
        }
        session.await_whole(START_S).await.context("the graph does not start")?;
        Ok(session)
    }

    /// What comes next, at most 10 ms later.
    pub(super) async fn next(&mut self) -> anyhow::Result<(Seconds, Seen)> {
        if let Some(seen) = self.pending.pop_front() {
            return Ok(seen);
        }
        if self.observer.interrupted() {
            bail!("interrupted");
        }
        if self.observer.is_deaf() {
            bail!("the observer hears nothing any more: the machine has too much to do");
        }
        let (at, seen) = self.observer.next().await?;
        let now = self.observer.now();
        if (now - self.tended).0 >= TEND_S {
            self.tended = now;
            let happenings = self.graph.tend(now);
            self.ended.extend(happenings.iter().filter_map(Happening::ended));
            self.pending.extend(happenings.into_iter().map(|happening| (now, Seen::Happened(happening))));
        }
        match &seen {
            Seen::Heart(name, run) => {
                self.hearts.insert(name.clone(), *run);
                let happening = self.graph.beat(at, name, *run);
                self.pending.extend(happening.map(|happening| (now, Seen::Happened(happening))));
            }
            Seen::Clock(stamp_s) => self.stamp_s = *stamp_s,
            _ => {}
        }
        Ok((at, seen))
    }

    /// Looks on until `done`, or until so long has passed; whether it was done.
    pub(super) async fn until(
        &mut self,
        limit_s: f64,
        mut done: impl FnMut(Seconds, &Seen) -> bool,
    ) -> anyhow::Result<bool> {
        let end = self.observer.now() + Seconds(limit_s);
        loop {
            let (at, seen) = self.next().await?;
            if done(at, &seen) {
                return Ok(true);
            }
            if self.observer.now() > end {
                return Ok(false);
            }
        }
    }

    /// Looks on for a while.
    pub(super) async fn watch(&mut self, watcher: &mut Watcher, for_s: f64) -> anyhow::Result<()> {
        self.until(for_s, |at, seen| {
            watcher.take(at, seen);
            false
        })
        .await?;
        Ok(())
    }

    /// Waits until the loop is closed and every node is heard.
    pub(super) async fn whole(&mut self) -> anyhow::Result<()> {
        self.await_whole(PATIENCE_S).await
    }

    async fn await_whole(&mut self, patience_s: f64) -> anyhow::Result<()> {
        let mut watcher = self.watcher();
        let end = self.observer.now() + Seconds(patience_s);
        loop {
            let (at, seen) = self.next().await?;
            watcher.take(at, &seen);
            let missing: Vec<&str> = self.unheard();
            if missing.is_empty() && watcher.is_whole_since().is_some() {
                return Ok(());
            }
            if self.observer.now() > end {
                let (mode, cause) = (watcher.mode, &watcher.cause);
                bail!(
                    "not whole after {patience_s} s: mode {mode} ({cause}), corrected {}, not heard: {}",
                    watcher.corrected,
                    missing.join(" ")
                );
            }
        }
    }

    /// Nodes that were started and do not run, or were never heard.
    pub(super) fn unheard(&self) -> Vec<&'static str> {
        let pids = self.graph.pids();
        let beats = |name: &&str| pids.contains_key(name) && self.hearts.contains_key(*name);
        let started = self.graph.started().filter(|name| NODES.contains(name));
        started.filter(|name| !beats(name)).collect()
    }

    /// Nodes whose process has ended since the last call, one for each end.
    pub(super) fn take_ended(&mut self) -> Vec<&'static str> {
        std::mem::take(&mut self.ended)
    }

    /// Newest run of a node.
    pub(super) fn run_of(&self, node: &str) -> Option<u64> {
        self.hearts.get(node).copied()
    }

    /// Looks from now on.
    pub(super) fn watcher(&self) -> Watcher {
        let now = self.observer.now();
        Watcher::new(now, if self.graph.on_host_clock() { now.0 } else { self.stamp_s })
    }

    /// Looks on until the mode `act`: after an acknowledgement nothing is printed any more.
    pub(super) async fn acts(&mut self, watcher: &mut Watcher, limit_s: f64) -> anyhow::Result<bool> {
        self.until(limit_s, |at, seen| {
            watcher.take(at, seen);
            matches!(seen, Seen::Safety(state) if state.mode == SafetyState::MODE_ACT)
        })
        .await
    }

    /// Ends all nodes in order, the recorder last; what did not go well.
    pub(super) async fn end(&mut self) -> anyhow::Result<Vec<String>> {
        for with_recorder in [false, true] {
            self.graph.ask_to_end(with_recorder);
            let end = self.observer.now() + Seconds(END_S);
            // Processes that end now are not started again: nobody tends them.
            while !self.graph.all_ended(with_recorder) && self.observer.now() < end {
                _ = self.observer.next().await?;
            }
        }
        let killed = self.graph.kill_rest();
        let late = killed.iter().map(|name| format!("{name} did not end in {END_S} s"));
        let badly = self.graph.ended_badly().into_iter().filter(|(name, _)| !killed.contains(name));
        Ok(late.chain(badly.map(|(name, how)| format!("{name} ended with {how}"))).collect())
    }
}

/// Refuses to start where another graph runs.
pub(super) async fn refuse_second_graph() -> anyhow::Result<()> {
    let mut observer = Observer::join()?;
    let end = observer.now() + Seconds(LISTEN_S);
    while observer.now() < end {
        if let (_, Seen::Heart(name, _)) = observer.next().await?
            && NODES.contains(&name.as_str())
        {
            bail!("{name} already runs in this domain: stop it, or set another ROS_DOMAIN_ID");
        }
    }
    Ok(())
}
