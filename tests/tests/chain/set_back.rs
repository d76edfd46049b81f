//! Simulated time goes back, as where a bag is played again: who looks at moves and frames has seen nothing then.

use crate::fleet::{self, Fleet};
use fdm_loop_msgs::{
    AdvancePrediction, CompressedImage, DefectReport, Header, Heartbeat, MotionSegment, PrinterState,
};
use models::units::Seconds;
use runtime::{Args, ClockDriver, Node, Publisher, Subscription, topics};
use std::collections::BTreeSet;
use std::time::Duration;

/// Longest wait for anything.
const PATIENCE: Duration = Duration::from_secs(30);
/// Real time between two samples.
const PAUSE: Duration = Duration::from_millis(40);
/// Who is looked at.
const NODES: [&str; 2] = ["advance_predictor", "defect_classifier"];
/// A picture by its first bytes and by nothing else: each is told as one that cannot be judged, and counted.
const BROKEN: [u8; 4] = [0xff, 0xd8, 0xff, 0xe0];

#[test]
fn who_looks_at_moves_and_frames_begins_anew() {
    const TEST: &str = "set_back::who_looks_at_moves_and_frames_begins_anew";
    if let Some(alone) = system_tests::run_in_own_domain(TEST, 1).unwrap() {
        assert!(alone.success(), "it failed in its own domain, see above");
        return;
    }
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    executor.block_on(async {
        let started = NODES.map(|node| (node, fleet::start_with(node, &["-p", "use_sim_time:=true"])));
        let mut fleet = Fleet::of(started.into());
        let mut print = Print::join();
        print.goes_on_until(|told| told.frame >= 3 && told.advance_known).await;
        // What both know by now is of a print that has not begun yet.
        print.goes_back_by(crate::BACK_S).await;
        let first = print.first_words().await;
        assert_eq!(first.frame, 1, "frames are counted from the start");
        assert!(!first.advance_known, "no road has been laid yet");
        print.goes_on_until(|told| told.frame >= 3 && told.advance_known).await;
        fleet.end();
    });
}

/// What was told last.
#[derive(Default, Clone, Copy)]
struct Told {
    /// Number of the frame.
    frame: u64,
    /// The pressure advance is known.
    advance_known: bool,
}

/// A printer that prints, its camera and its clock.
struct Print {
    now_s: f64,
    moves: u64,
    clock: ClockDriver,
    state: Publisher<PrinterState>,
    motion: Publisher<MotionSegment>,
    frames: Publisher<CompressedImage>,
    beats: Subscription<Heartbeat>,
    defects: Subscription<DefectReport>,
    predictions: Subscription<AdvancePrediction>,
    _node: Node,
}

impl Print {
    fn join() -> Self {
        let parameters = vec![("use_sim_time".to_owned(), "true".to_owned())];
        let mut node = Node::start_with("peer", Args { parameters, ..Args::default() }).unwrap();
        Self {
            now_s: crate::BEGIN_S,
            moves: 0,
            clock: node.drive_clock().unwrap(),
            state: node.publish_on(&topics::PRINTER_STATE).unwrap(),
            motion: node.publish_on(&topics::PRINTER_MOTION).unwrap(),
            frames: node.publish_on(&topics::CAMERA_IMAGE).unwrap(),
            beats: node.subscribe(&topics::HEARTBEAT).unwrap(),
            defects: node.subscribe(&topics::DEFECTS).unwrap(),
            predictions: node.subscribe(&topics::ADVANCE_PREDICTION).unwrap(),
            _node: node,
        }
    }

    /// State and frame of now, and a move of 10 mm that begins now.
    fn sample(&mut self, kind: u8) {
        let header = Header::at(self.now_s);
        self.state.send(PrinterState {
            header: header.clone(),
            phase: PrinterState::PHASE_PRINTING,
            hotend_target_degc: 215.0,
            hotend_sliced_target_degc: 215.0,
            ..PrinterState::default()
        });
        self.moves += 1;
        let lays = kind == MotionSegment::KIND_DEPOSIT;
        self.motion.send(MotionSegment {
            header: header.clone(),
            sequence: self.moves,
            kind,
            end_m: [0.01, 0.0, 0.0],
            length_m: 0.01,
            cruise_speed_m_s: 0.05,
            cruise_s: 0.2,
            filament_m: if lays { 3e-4 } else { 0.0 },
            target_width_known: lays,
            target_width_m: 4e-4,
            target_height_known: lays,
            target_height_m: 2e-4,
            ..MotionSegment::default()
        });
        self.frames.send(CompressedImage { header, data: BROKEN.to_vec(), ..CompressedImage::default() });
    }

    /// Roads are laid until that is told.
    async fn goes_on_until(&mut self, reached: impl Fn(Told) -> bool) {
        let goes_on = async {
            let mut told = Told::default();
            while !reached(told) {
                self.now_s += 0.02;
                self.clock.set(Seconds(self.now_s));
                self.sample(MotionSegment::KIND_DEPOSIT);
                tokio::time::sleep(PAUSE).await;
                while let Some(report) = self.defects.try_recv() {
                    told.frame = report.message.frame;
                }
                while let Some(prediction) = self.predictions.try_recv() {
                    told.advance_known = prediction.message.advance_known;
                }
            }
        };
        tokio::time::timeout(PATIENCE, goes_on).await.expect("frames and roads are told of");
    }

    /// Time goes back at once; returns when both know.
    async fn goes_back_by(&mut self, back_s: f64) {
        self.now_s -= back_s;
        self.clock.set(Seconds(self.now_s));
        let stamp = Header::at(self.now_s).stamp;
        let told = async {
            let mut missing = BTreeSet::from(NODES);
            while !missing.is_empty() {
                let beat = self.beats.recv().await.message;
                missing.retain(|node| !(beat.node.ends_with(node) && beat.header.stamp == stamp));
            }
        };
        tokio::time::timeout(PATIENCE, told).await.expect("both know the time");
    }

    /// What is told first of a time up to now, where nothing is laid.
    async fn first_words(&mut self) -> Told {
        let words = async {
            let (mut frame, mut advance_known) = (None, None);
            loop {
                self.sample(MotionSegment::KIND_TRAVEL);
                tokio::time::sleep(PAUSE).await;
                let is_now =
                    |header: &Header| header.stamp.seconds().is_some_and(|at| at <= self.now_s + 1e-6);
                while let Some(report) = self.defects.try_recv() {
                    if is_now(&report.message.header) {
                        frame.get_or_insert(report.message.frame);
                    }
                }
                while let Some(prediction) = self.predictions.try_recv() {
                    if is_now(&prediction.message.header) {
                        advance_known.get_or_insert(prediction.message.advance_known);
                    }
                }
                if let (Some(frame), Some(advance_known)) = (frame, advance_known) {
                    return Told { frame, advance_known };
                }
                self.now_s += 0.02;
                self.clock.set(Seconds(self.now_s));
            }
        };
        tokio::time::timeout(PATIENCE, words).await.expect("both speak again")
    }
}
