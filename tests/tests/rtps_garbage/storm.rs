//! Datagrams of one kind, and what became of the graph.

use crate::graph::{Graph, Said, root};
use crate::judge::{Judged, Record};
use crate::observer::{Observer, Seen, is_neutral};
use crate::report::whole_limit_s;
use fdm_loop_msgs::{PrinterState, SafetyState};
use models::units::Seconds;
use std::collections::BTreeMap;
use std::process::{Child, Command, Stdio};

/// Wait for a graph that is whole, beyond the limit of the report: by how much it was missed is worth knowing `[s]`.
const PATIENCE_S: f64 = 20.0;
/// So long a graph stays whole to be called whole `[s]`.
const LASTS_S: f64 = 1.0;
/// A node is heard that has beaten within this time `[s]`: C4.
const HEARD_S: f64 = 0.5;
/// Time between two looks at the memory of the processes `[s]`.
const LOOK_S: f64 = 0.05;
/// Datagrams a second at most.
const RATE: &str = "5000";
/// The nodes that are started again.
pub(crate) const NODES: [&str; 9] = [
    "bag_recorder",
    "camera",
    "defect_classifier",
    "filament_encoder",
    "imu",
    "mpc_controller",
    "safety_supervisor",
    "state_estimator",
    "thermistor",
];

/// Who is hit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Targets {
    /// Every port of every process, and the groups.
    Everyone,
    /// The nodes that are started again, each by its own ports.
    Replaceable,
    /// The same, each of them by every datagram.
    EachReplaceable,
}

/// One kind of datagram of `tests/rtps_fuzz.py`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Kind {
    pub(crate) name: &'static str,
    pub(crate) count: u32,
    pub(crate) targets: Targets,
    /// It may end processes: memory is asked for, or the middleware's counters overflow.
    pub(crate) deadly: bool,
}

/// What one kind did.
#[derive(Debug)]
pub(crate) struct Storm {
    pub(crate) kind: Kind,
    /// What the sender says of itself.
    pub(crate) sent: u64,
    pub(crate) took_s: f64,
    /// Ports of processes that it was sent to.
    pub(crate) ports: usize,
    /// Ends of processes by node.
    pub(crate) deaths: BTreeMap<String, u32>,
    /// Largest resident memory by node `[KiB]`.
    pub(crate) peaks: BTreeMap<String, u64>,
    /// From the last datagram until all is whole for good.
    pub(crate) whole_s: Option<f64>,
    /// What was not as it should be when it was looked at last.
    pub(crate) lacking: String,
    /// Paused or switched off, and why: S7, where a stream was away for too long.
    pub(crate) tripped: Option<(u8, String)>,
    /// First and last state of the storm and what followed it, on the graph's clock.
    pub(crate) span_s: (f64, f64),
    pub(crate) judged: Judged,
}

/// What is known of the graph.
struct Look {
    hearts: BTreeMap<String, Seconds>,
    mode: u8,
    corrected: bool,
    printing: bool,
    whole_since: Option<Seconds>,
}

impl Storm {
    /// Sends all and looks on until the graph is whole again.
    pub(crate) async fn run(
        kind: Kind,
        observer: &mut Observer,
        graph: &mut Graph,
        record: &mut Record,
    ) -> Self {
        println!("{}: {} datagrams to {:?}", kind.name, kind.count, kind.targets);
        let mut storm = Self {
            kind,
            sent: 0,
            took_s: 0.0,
            ports: 0,
            deaths: BTreeMap::new(),
            peaks: BTreeMap::new(),
            whole_s: None,
            lacking: String::new(),
            tripped: None,
            span_s: (record.newest_s(), 0.0),
            judged: Judged::default(),
        };
        let mut look = Look {
            hearts: BTreeMap::new(),
            mode: SafetyState::MODE_ACT,
            corrected: true,
            printing: true,
            whole_since: None,
        };
        let mut sender = Some(sender(&kind));
        let (mut ended, mut looked, mut asked) = (observer.now(), Seconds(0.0), Seconds(0.0));
        loop {
            let seen = observer.next(graph, record).await;
            let now = observer.now();
            storm.take(&seen, &mut look, now);
            if (now - looked).0 > LOOK_S {
                looked = now;
                storm.look_at_memory(graph);
                if let Some(child) = &mut sender
                    && child.try_wait().unwrap().is_some()
                {
                    storm.take_words(sender.take().unwrap());
                    (ended, look.whole_since) = (now, None);
                }
            }
            if sender.is_some() {
                continue;
            }
            if look.mode >= SafetyState::MODE_PAUSED && look.all_heard(now) && (now - asked).0 > LASTS_S {
                asked = now;
                println!("  a person is asked for: {}", observer.ask(look.mode).await);
            }
            let lacking = look.lacking(now);
            if lacking != storm.lacking {
                println!("  {:.2} s after the last: {lacking}", (now - ended).0);
                storm.lacking = lacking;
            }
            storm.whole_s = look.whole_since(now).map(|since| (since - ended).0);
            if storm.whole_s.is_some() || (now - ended).0 > whole_limit_s() + PATIENCE_S {
                storm.span_s.1 = record.newest_s();
                return storm;
            }
        }
    }

    /// Whether there is a print left to correct.
    pub(crate) fn goes_on(&self) -> bool {
        self.tripped.is_none() && self.whole_s.is_some()
    }

    fn take(&mut self, seen: &Seen, look: &mut Look, now: Seconds) {
        match seen {
            Seen::Printer(state) => {
                look.corrected = !is_neutral(state);
                look.printing = state.phase == PrinterState::PHASE_PRINTING;
            }
            Seen::Safety(state) => {
                look.mode = state.mode;
                if state.mode >= SafetyState::MODE_PAUSED {
                    let worst = self.tripped.as_ref().map_or(0, |(mode, _)| *mode);
                    if state.mode > worst {
                        self.tripped = Some((state.mode, state.cause.clone()));
                    }
                }
            }
            Seen::Heart(name) => _ = look.hearts.insert(name.clone(), now),
            Seen::Said(Said::Ended(name)) => {
                *self.deaths.entry(name.clone()).or_default() += 1;
                look.hearts.remove(name);
            }
            Seen::Said(_) | Seen::Permit(_) | Seen::Tick => {}
        }
    }

    /// Resident memory of every node, from `/proc`.
    fn look_at_memory(&mut self, graph: &Graph) {
        for (name, pid) in graph.pids() {
            let status = std::fs::read_to_string(format!("/proc/{}/status", pid.as_raw_nonzero()));
            let resident = status.ok().and_then(|text| {
                let line = text.lines().find(|line| line.starts_with("VmRSS:"))?.to_owned();
                line.split_whitespace().nth(1)?.parse().ok()
            });
            let peak = self.peaks.entry(name.clone()).or_default();
            *peak = (*peak).max(resident.unwrap_or(0));
        }
    }

    fn take_words(&mut self, sender: Child) {
        let output = sender.wait_with_output().unwrap();
        assert!(output.status.success(), "{}: the sender failed", self.kind.name);
        let words: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        self.sent = words["sent"].as_u64().unwrap();
        self.took_s = words["took_s"].as_f64().unwrap();
        self.ports = words["ports"].as_array().unwrap().len();
        println!("  {words}");
    }
}

impl Look {
    fn is_heard(&self, node: &str, now: Seconds) -> bool {
        self.hearts.get(node).is_some_and(|heard| (now - *heard).0 < HEARD_S)
    }

    fn all_heard(&self, now: Seconds) -> bool {
        NODES.iter().all(|node| self.is_heard(node, now))
    }

    fn lacking(&self, now: Seconds) -> String {
        let mute: Vec<&str> = NODES.into_iter().filter(|node| !self.is_heard(node, now)).collect();
        format!("mode {}, corrected {}, printing {}, mute {mute:?}", self.mode, self.corrected, self.printing)
    }

    /// Since when all is whole, where that lasts. A job that was given up has no corrections to come back.
    fn whole_since(&mut self, now: Seconds) -> Option<Seconds> {
        let acts = self.mode == SafetyState::MODE_ACT && (self.corrected || !self.printing);
        let whole = acts && self.all_heard(now);
        self.whole_since = whole.then(|| self.whole_since.unwrap_or(now));
        self.whole_since.filter(|since| (now - *since).0 > LASTS_S)
    }
}

fn sender(kind: &Kind) -> Child {
    let mut nodes = NODES.to_vec();
    let everyone = kind.targets == Targets::Everyone;
    let test = std::env::current_exe().unwrap();
    if everyone {
        nodes.extend(["printer_sim", "fdm", test.file_name().unwrap().to_str().unwrap()]);
    }
    let domain = std::env::var("ROS_DOMAIN_ID").unwrap_or_else(|_| "0".to_owned());
    let mut command = Command::new("python3");
    command
        .arg(root().join("tests/rtps_fuzz.py"))
        .args(["--kind", kind.name, "--count", &kind.count.to_string(), "--rate", RATE])
        .args(["--domain", &domain, "--nodes", &nodes.join(",")])
        .args(everyone.then_some("--multicast"))
        .args((kind.targets == Targets::EachReplaceable).then_some("--each"))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::inherit());
    command.spawn().unwrap()
}
