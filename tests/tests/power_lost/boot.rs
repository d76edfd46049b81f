//! The next boot: supervisor, thermistor and a printer that would begin its file anew, with the files as they were left.

use fdm_loop_msgs::{ControlCommand, PrinterState, SafetyState};
use runtime::{Args, Node, topics};
use std::process::{Child, Command};
use std::time::Duration;

/// Longest wait for the supervisor's first words and for the printer to obey them: both are debug binaries that find each
/// other first.
const PATIENCE: Duration = Duration::from_secs(30);
/// Longest time from the first permit that was heard, which demands the stop, until the printer has obeyed, on the graph's
/// clock `[s]`: it may hear the supervisor a little later than the witness does, and heats until then.
const OBEYED_S: f64 = 1.0;
/// How long it has to stay off then: a supervisor that had forgotten would act, and the printer heat, within a second.
const WATCHED: Duration = Duration::from_secs(5);

/// A process that does not outlive the test.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        _ = self.0.kill();
        _ = self.0.wait();
    }
}

/// What was seen since the boot.
#[derive(Debug, Default)]
struct Seen {
    permits: u32,
    told: Option<SafetyState>,
    /// Stamp of the first permit `[s]`.
    demanded_s: Option<f64>,
    /// The printer obeys: its mains relay is open.
    off: bool,
    /// First state that shows it, behind the first permit `[s]`.
    obeyed_s: Option<f64>,
    states_off: u32,
}

impl Seen {
    /// No permit, from the first one on, lets anything heat or go on.
    fn permit(&mut self, permit: &ControlCommand) {
        let asked = (permit.mode, permit.request);
        let stop = (ControlCommand::MODE_ESTOP, ControlCommand::REQUEST_EMERGENCY_STOP);
        assert_eq!(asked, stop, "permit {} after the boot", self.permits);
        self.permits += 1;
        self.demanded_s = self.demanded_s.or(permit.header.stamp.seconds());
    }

    fn state(&mut self, state: &SafetyState) {
        assert_eq!((state.mode, state.latched), (SafetyState::MODE_ESTOP, true), "{state:?}");
        assert!(state.cause.starts_with("P13"), "{state:?}");
        assert!(!state.what_to_do.is_empty(), "{state:?}");
        self.told = Some(state.clone());
    }

    /// It is off soon, and stays off: no heater is ordered, nothing is printed.
    fn printer(&mut self, state: &PrinterState) {
        self.off |= !state.mains_on;
        let waited_s = self.demanded_s.zip(state.header.stamp.seconds()).map(|(from_s, to_s)| to_s - from_s);
        if self.off {
            self.obeyed_s = self.obeyed_s.or(waited_s);
        }
        if self.off || waited_s.is_some_and(|waited_s| waited_s > OBEYED_S) {
            let heat = (state.mains_on, state.hotend_duty, state.bed_duty);
            assert_eq!(heat, (false, 0.0, 0.0), "{state:?}");
            assert_eq!(state.phase, PrinterState::PHASE_FAILED, "{state:?}");
            self.states_off += 1;
        }
    }
}

/// Starts them again and looks on: the latch of before holds, and nobody has to ask for it.
pub(crate) async fn stays_off(commands: [Command; 3]) {
    let mut node = Node::start_with("witness", Args::default()).unwrap();
    let mut permits = node.subscribe(&topics::SAFETY_COMMAND).unwrap();
    let mut safety = node.subscribe(&topics::SAFETY_STATE).unwrap();
    let mut printer = node.subscribe(&topics::PRINTER_STATE).unwrap();
    let _processes = commands.map(|mut command| Process(command.spawn().unwrap()));
    let mut seen = Seen::default();
    let mut end = tokio::time::Instant::now() + PATIENCE;
    loop {
        let off = seen.off;
        tokio::select! {
            permit = permits.recv() => seen.permit(&permit.message),
            state = safety.recv() => seen.state(&state.message),
            state = printer.recv() => seen.printer(&state.message),
            () = tokio::time::sleep_until(end) => break,
        }
        if seen.off && !off {
            end = tokio::time::Instant::now() + WATCHED;
        }
    }
    let (permits, states) = (seen.permits, seen.states_off);
    println!("{permits} permits, {states} states of a printer that is off after {:?} s", seen.obeyed_s);
    assert!(seen.off, "the printer is never switched off: {seen:?}");
    assert!(seen.told.is_some(), "the supervisor tells no state");
    // 50 Hz each, of which a busy machine may keep back half.
    assert!(seen.permits > 125 && seen.states_off > 125, "{seen:?}");
}
