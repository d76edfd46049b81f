//! A supervisor that is killed with SIGKILL and started again goes on as a person has asked for, whatever `start_mode` says.
//!
//! The node is a process with its shipped parameters, in act; a peer is its printer and the person, over DDS.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests: a failure is the test's failure")]

#[path = "restart/printer.rs"]
mod printer;

use fdm_loop_msgs::{
    Log, PrintEvent, PrinterState, RosService, SafetyState, SetMode, SetModeRequest, Trigger, TriggerRequest,
};
use models::units::Seconds;
use printer::Printer;
use runtime::{Args, Client, Node, Subscription, topics};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// Longest wait for anything.
const PATIENCE: Duration = Duration::from_secs(30);
/// Set in the process that has a domain of its own.
const ALONE: &str = "FDM_TEST_IN_OWN_DOMAIN";

#[test]
fn what_a_person_asked_for_outlives_a_killed_supervisor() {
    if std::env::var_os(ALONE).is_none() {
        // A node reads the domain from the environment, which a test cannot change in itself. Ports of domains up to 101
        // lie below the ephemeral ones.
        let mut alone = Command::new(std::env::current_exe().unwrap());
        alone.args(["what_a_person_asked_for_outlives_a_killed_supervisor", "--exact", "--nocapture"]);
        let domain = (20 + std::process::id() % 80).to_string();
        let status = alone.env(ALONE, "1").env("ROS_DOMAIN_ID", domain).status().unwrap();
        assert!(status.success(), "it failed in its own domain, see above");
        return;
    }
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    executor.block_on(async {
        let mut supervisor = Supervisor::start();
        let mut peer = Peer::join();
        let first = peer.next_run().await;
        assert_eq!(first.set_mode, SafetyState::MODE_ACT, "its start_mode");

        peer.observe().await;
        let state = peer.after_a_kill(&mut supervisor).await;
        assert_eq!(state.set_mode, SafetyState::MODE_OBSERVE);
        assert_ne!(state.mode, SafetyState::MODE_PAUSED);
        assert_eq!(peer.remembered("observe").await.before, "act");

        peer.pause().await;
        let state = peer.after_a_kill(&mut supervisor).await;
        assert_eq!((state.mode, state.set_mode), (SafetyState::MODE_PAUSED, SafetyState::MODE_OBSERVE));
        assert!(state.cause.starts_with("P13"), "{}", state.cause);

        peer.resume().await;
        std::fs::write(supervisor.record(), r#"{"version":1,"mode":"act","pau"#).unwrap();
        let state = peer.after_a_kill(&mut supervisor).await;
        assert_eq!((state.mode, state.set_mode), (SafetyState::MODE_PAUSED, SafetyState::MODE_OBSERVE));
        assert!(state.cause.starts_with("T5"), "{}", state.cause);
        let why = peer.refused(&supervisor.record()).await;
        assert!(why.contains("line 1 column"), "{why}");
        stopped(&mut supervisor, &mut peer).await;
    });
}

/// P13 is told as what it is from the first state on, by the next run too, and by the one that cannot read of it any more.
async fn stopped(supervisor: &mut Supervisor, peer: &mut Peer) {
    peer.estop().await;
    let line = peer.log_line("emergency stop").await;
    assert_eq!((line.level, line.name.as_str()), (Log::ERROR, "printer.safety_supervisor"), "{line:?}");
    assert!(line.msg.contains("P13: emergency stop by a person. What to do: "), "{line:?}");
    let told = peer.event("estop_granted").await;
    assert_eq!(told.severity, PrintEvent::SEVERITY_ERROR);
    let what = "P13: emergency stop by a person. What to do: ";
    assert!(told.why.starts_with(what), "{}", told.why);
    let state = peer.after_a_kill(supervisor).await;
    assert_eq!(state.mode, SafetyState::MODE_ESTOP);
    let told = peer.remembered("estop").await;
    assert_eq!((told.before.as_str(), told.severity), ("act", PrintEvent::SEVERITY_ERROR));
    assert!(told.why.contains(what), "{}", told.why);

    let latch = supervisor.folder.join("latch.json");
    std::fs::write(&latch, r#"{"estop":true,"cau"#).unwrap();
    let state = peer.after_a_kill(supervisor).await;
    assert_eq!((state.mode, state.latched), (SafetyState::MODE_SAFE_OFF, true));
    let told = peer.remembered("safe_off").await.why;
    assert!(told.contains("T5: the record of a latched mode cannot be read. What to do: "), "{told}");
    let why = peer.refused(&latch).await;
    assert!(why.contains(": EOF while parsing a string at line 1 column 18"), "{why}");
    assert!(why.contains(". What to do: "), "{why}");
}

/// The node with its latch in a folder of its own; neither outlives the test.
struct Supervisor {
    child: Child,
    folder: PathBuf,
}

impl Supervisor {
    fn start() -> Self {
        let folder = std::env::temp_dir().join(format!("fdm_restart_{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        Self { child: start_in(&folder), folder }
    }

    /// SIGKILL, and at once another one.
    fn replace(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
        self.child = start_in(&self.folder);
    }

    fn record(&self) -> PathBuf {
        self.folder.join("latch.standing.json")
    }
}

impl Drop for Supervisor {
    fn drop(&mut self) {
        _ = self.child.kill();
        _ = self.child.wait();
        _ = std::fs::remove_dir_all(&self.folder);
    }
}

fn start_in(folder: &Path) -> Child {
    let latch = format!("latch_file:={:?}", folder.join("latch.json"));
    let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/safety_supervisor.param.yaml");
    let mut command = Command::new(env!("CARGO_BIN_EXE_safety_supervisor"));
    command.arg("--ros-args").arg("--params-file").arg(config).env_remove("RUST_LOG");
    command.args(["-p", "start_mode:=act", "-p", &latch]).stdout(Stdio::null()).spawn().unwrap()
}

/// Printer and person.
struct Peer {
    printer: Printer,
    /// The run whose state was seen last.
    run: u64,
    states: Subscription<SafetyState>,
    events: Subscription<PrintEvent>,
    /// Events that nobody has asked for yet.
    heard: Vec<PrintEvent>,
    log: Subscription<Log>,
    pause: Client<Trigger>,
    estop: Client<Trigger>,
    resume: Client<Trigger>,
    mode: Client<SetMode>,
    _node: Node,
}

impl Peer {
    fn join() -> Self {
        let mut node = Node::start_with("peer", Args::default()).unwrap();
        Self {
            printer: Printer::at(&mut node),
            run: 0,
            states: node.subscribe(&topics::SAFETY_STATE).unwrap(),
            events: node.subscribe(&topics::EVENTS).unwrap(),
            heard: Vec::new(),
            log: node.subscribe(&topics::ROSOUT).unwrap(),
            pause: node.client(&topics::SAFETY_PAUSE).unwrap(),
            estop: node.client(&topics::SAFETY_ESTOP).unwrap(),
            resume: node.client(&topics::SAFETY_RESUME).unwrap(),
            mode: node.client(&topics::SAFETY_SET_MODE).unwrap(),
            _node: node,
        }
    }

    /// SIGKILL, and the first state that the next run tells.
    async fn after_a_kill(&mut self, supervisor: &mut Supervisor) -> SafetyState {
        supervisor.replace();
        self.next_run().await
    }

    async fn next_run(&mut self) -> SafetyState {
        let (states, run) = (&mut self.states, self.run);
        let state = self.printer.during("state of another run", async {
            loop {
                let state = states.recv().await.message;
                if state.session_id != run {
                    return state;
                }
            }
        });
        let state = state.await;
        self.run = state.session_id;
        state
    }

    async fn event(&mut self, what: &str) -> PrintEvent {
        self.event_where(what, |_| true).await
    }

    /// What a run has taken over from the one before it.
    async fn remembered(&mut self, mode: &str) -> PrintEvent {
        self.event_where("remembered", |event| event.after == mode).await
    }

    /// Why a record was refused; that of mode and pause may still be broken when the latch is.
    async fn refused(&mut self, record: &Path) -> String {
        let record = format!("{}: ", record.display());
        self.event_where("record_refused", |event| event.why.starts_with(&record)).await.why
    }

    /// The first that holds, of those that came before it was asked for too: they may come in any order.
    async fn event_where(&mut self, what: &str, holds: impl Fn(&PrintEvent) -> bool) -> PrintEvent {
        let is_it = |event: &PrintEvent| event.what == what && holds(event);
        let (events, heard) = (&mut self.events, &mut self.heard);
        let event = self.printer.during(what, async {
            loop {
                if let Some(place) = heard.iter().position(is_it) {
                    return heard.remove(place);
                }
                heard.push(events.recv().await.message);
            }
        });
        event.await
    }

    /// As a console or `rqt_console` shows it, where nobody listens to `events`.
    async fn log_line(&mut self, text: &str) -> Log {
        let log = &mut self.log;
        let line = self.printer.during(text, async {
            loop {
                let line = log.recv().await.message;
                if line.msg.contains(text) {
                    return line;
                }
            }
        });
        line.await
    }

    async fn observe(&mut self) {
        let observe = SetModeRequest { mode: SetModeRequest::MODE_OBSERVE };
        let answer = self.printer.during("answer", answer(&self.mode, observe)).await;
        assert!(answer.accepted, "{}", answer.message);
    }

    async fn pause(&mut self) {
        let answer = self.printer.during("answer", answer(&self.pause, TriggerRequest::default())).await;
        assert!(answer.success, "{}", answer.message);
        self.printer.phase = PrinterState::PHASE_PAUSED;
    }

    /// No state on the way tells a pause by a person.
    async fn estop(&mut self) {
        let (client, states) = (&self.estop, &mut self.states);
        let stopped = async {
            loop {
                let state = states.recv().await.message;
                let paused = state.mode == SafetyState::MODE_PAUSED && state.cause.starts_with("P13");
                assert!(!paused, "{state:?}");
                if state.mode == SafetyState::MODE_ESTOP {
                    return;
                }
            }
        };
        let both = async { tokio::join!(answer(client, TriggerRequest::default()), stopped).0 };
        let answer = self.printer.during("emergency stop", both).await;
        assert!(answer.success && answer.message.starts_with("mode estop: P13: "), "{}", answer.message);
    }

    /// Granted as soon as the new run has heard its printer.
    async fn resume(&mut self) {
        let granted = async { while !answer(&self.resume, TriggerRequest::default()).await.success {} };
        self.printer.during("resume", granted).await;
        self.printer.phase = PrinterState::PHASE_PRINTING;
    }
}

/// An answer, asked for again until there is one: before both ends are matched a request is lost.
async fn answer<S>(client: &Client<S>, request: S::Request) -> S::Response
where
    S: RosService<Request: Clone>,
{
    loop {
        if let Ok(answer) = client.call(request.clone(), Seconds(2.0)).await {
            return answer;
        }
    }
}
