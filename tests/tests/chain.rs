//! A temperature of the hot end goes through estimator, controller and supervisor without waiting for any timer.
//!
//! The nodes are processes and speak over DDS; simulated time stands still while the sample is under way, so that no timer
//! can tick.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "helpers of tests: a failure is the test's failure"
)]

#[allow(dead_code, reason = "what another test needs of it")]
#[path = "refusals/fleet.rs"]
mod fleet;
#[path = "chain/set_back.rs"]
mod set_back;

use fdm_loop_msgs::{
    ControlCommand, FilamentMotion, Header, Heartbeat, PrinterState, SafetyState, StateEstimate, Temperature,
    Time,
};
use fleet::Fleet;
use models::units::Seconds;
use runtime::{Args, ClockDriver, Node, Publisher, Subscription, topics};
use std::collections::BTreeSet;
use std::time::Duration;

/// Longest wait for anything.
const PATIENCE: Duration = Duration::from_secs(30);
/// Longest time for which a message is under way.
const UNDER_WAY: Duration = Duration::from_millis(500);
/// Nodes of the chain.
const CHAIN: [&str; 3] = ["state_estimator", "mpc_controller", "safety_supervisor"];
/// Steps of time `[s]`: at each the supervisor ticks, but not the estimator, whose timer waits for 50 ms after a turn.
const STEP_S: f64 = 0.024;
/// Simulated time at the start `[s]`: it can go back from here.
const BEGIN_S: f64 = 61.0;
/// It goes back by so much `[s]`: who waited until it is there again would wait longer than this test.
const BACK_S: f64 = 40.0;

#[test]
fn a_temperature_is_answered_while_time_stands_still() {
    if let Some(alone) =
        system_tests::run_in_own_domain("a_temperature_is_answered_while_time_stands_still", 0).unwrap()
    {
        assert!(alone.success(), "it failed in its own domain, see above");
        return;
    }
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    executor.block_on(async {
        let arguments = ["-p", "use_sim_time:=true"];
        let acting = ["-p", "start_mode:=act"];
        let started = CHAIN.map(|node| {
            let more = if node == "safety_supervisor" { &acting[..] } else { &[] };
            (node, fleet::start_with(node, &[&arguments[..], more].concat()))
        });
        let mut fleet = Fleet::of(started.into());
        let mut peer = Peer::join();
        peer.work_until_corrections_flow().await;
        peer.chain_answers_at_once().await;
        // As where a bag is played again: estimator and controller begin anew, the supervisor lets corrections flow again.
        peer.now_s -= BACK_S;
        peer.work_until_corrections_flow().await;
        peer.chain_answers_at_once().await;
        fleet.end();
    });
}

/// Sensors, printer and clock of the chain, and what it says.
struct Peer {
    now_s: f64,
    clock: ClockDriver,
    hotend: Publisher<Temperature>,
    bed: Publisher<Temperature>,
    filament: Publisher<FilamentMotion>,
    printer: Publisher<PrinterState>,
    beats: Subscription<Heartbeat>,
    estimates: Subscription<StateEstimate>,
    commands: Subscription<ControlCommand>,
    permits: Subscription<ControlCommand>,
    modes: Subscription<SafetyState>,
    _node: Node,
}

impl Peer {
    fn join() -> Self {
        let parameters = vec![("use_sim_time".to_owned(), "true".to_owned())];
        let mut node = Node::start_with("peer", Args { parameters, ..Args::default() }).unwrap();
        Self {
            now_s: BEGIN_S,
            clock: node.drive_clock().unwrap(),
            hotend: node.publish_on(&topics::HOTEND_TEMPERATURE).unwrap(),
            bed: node.publish_on(&topics::BED_TEMPERATURE).unwrap(),
            filament: node.publish_on(&topics::FILAMENT_MOTION).unwrap(),
            printer: node.publish_on(&topics::PRINTER_STATE).unwrap(),
            beats: node.subscribe(&topics::HEARTBEAT).unwrap(),
            estimates: node.subscribe(&topics::ESTIMATE).unwrap(),
            commands: node.subscribe(&topics::CONTROL_COMMAND).unwrap(),
            permits: node.subscribe(&topics::SAFETY_COMMAND).unwrap(),
            modes: node.subscribe(&topics::SAFETY_STATE).unwrap(),
            _node: node,
        }
    }

    fn stamp(&self) -> Time {
        Header::at(self.now_s).stamp
    }

    /// A state of the printer, a position of the filament and the temperatures, all of now.
    fn sample(&self) {
        let header = Header::at(self.now_s);
        self.printer.send(PrinterState {
            header: header.clone(),
            flow_factor: 1.0,
            speed_factor: 1.0,
            homed: true,
            mains_on: true,
            ..PrinterState::default()
        });
        self.filament.send(FilamentMotion { header: header.clone(), ..FilamentMotion::default() });
        let temperature = Temperature { header, temperature: 25.0, ..Temperature::default() };
        self.bed.send(temperature.clone());
        self.hotend.send(temperature);
    }

    /// Time passes at half its pace until the supervisor carries out what the controller wishes.
    async fn work_until_corrections_flow(&mut self) {
        let act = async {
            let mut acts = 0;
            while acts < 3 {
                self.now_s += 0.02;
                self.clock.set(Seconds(self.now_s));
                self.sample();
                tokio::time::sleep(Duration::from_millis(40)).await;
                while let Some(state) = self.modes.try_recv() {
                    // Of before time went back.
                    if state.message.header.stamp.seconds().is_some_and(|at_s| at_s > self.now_s + 1e-6) {
                        continue;
                    }
                    acts = if state.message.mode == ControlCommand::MODE_ACT { acts + 1 } else { 0 };
                }
            }
        };
        tokio::time::timeout(PATIENCE, act).await.expect("the supervisor acts");
    }

    /// Time goes on at once to `now_s`, and stands still there; returns when all know and nothing is under way.
    async fn stand_still_at(&mut self, now_s: f64) {
        self.now_s = now_s;
        self.clock.set(Seconds(now_s));
        let stamp = self.stamp();
        let told = async {
            let mut missing = BTreeSet::from(CHAIN);
            while !missing.is_empty() {
                let beat = self.beats.recv().await.message;
                missing.retain(|node| !(beat.node.ends_with(node) && beat.header.stamp == stamp));
            }
        };
        tokio::time::timeout(PATIENCE, told).await.expect("all nodes know the time");
        tokio::time::sleep(UNDER_WAY).await;
        while self.estimates.try_recv().is_some() {}
        while self.commands.try_recv().is_some() {}
        while self.permits.try_recv().is_some() {}
    }

    /// A temperature is answered, in each of two steps.
    async fn chain_answers_at_once(&mut self) {
        // The first step brings the timers in step with the samples.
        for round in 0..3 {
            self.stand_still_at(self.now_s + STEP_S).await;
            self.sample();
            if round == 0 {
                tokio::time::sleep(UNDER_WAY).await;
            } else {
                self.chain_answers().await;
            }
        }
    }

    async fn chain_answers(&mut self) {
        let now = self.stamp();
        let estimate = tokio::time::timeout(PATIENCE, self.estimates.recv()).await.expect("an estimate");
        assert_eq!(estimate.message.header.stamp, now);
        let command = tokio::time::timeout(PATIENCE, self.commands.recv()).await.expect("a command");
        assert_eq!(command.message.header.stamp, now);
        let permit = tokio::time::timeout(PATIENCE, self.permits.recv()).await.expect("a permit");
        assert_eq!(permit.message.header.stamp, now);
    }
}
