//! Shell of the simulated printer: paces the simulation by wall time, owns `/clock` unless the host's is asked for, passes
//! outputs on.

use crate::convert;
use crate::load::{self, LoadError, Loaded};
use crate::output::Output;
use crate::run_params::ProcessKind;
use crate::simulator::{Simulator, Unscheduled};
use fdm_loop_msgs::{
    BeadWidth, CompressedImage, ControlCommand, FilamentReport, Header, ImuBatch, InjectFault, MotionSegment,
    MotionTrim, PrintEvent, PrintInfo, PrinterState, SimTruth, TemperatureReport,
};
use models::command::{Permit, Scheduled};
use models::units::Seconds;
use runtime::{
    Asked, Diagnostics, Frames, Node, Publisher, Reason, Received, Refused, Server, Sessions, Subscription,
    topics, wire,
};
use time::TimeBase;

mod alone;
pub(crate) mod darkroom;
mod injection;
mod time;
mod wall;

/// Step of the plant `[s]`.
const STEP_S: f64 = 1e-3;
/// Simulated time between two looks at the permits `[s]`.
const LOOK_PERIOD_S: f64 = 0.01;
/// Steps between two looks.
const STEPS_PER_LOOK: u32 = 10;
/// Looks between two readings of `/clock`, and between two messages of truth: 50 Hz, the rate of the fastest timer on the
/// graph. Each reading wakes every process.
const LOOKS_PER_CLOCK: u32 = 2;

/// Everything that the printer says.
struct Outlets {
    temperatures: Publisher<TemperatureReport>,
    filament: Publisher<FilamentReport>,
    width: Publisher<BeadWidth>,
    imu: Publisher<ImuBatch>,
    frames: Publisher<CompressedImage>,
    state: Publisher<PrinterState>,
    motion: Publisher<MotionSegment>,
    coming: Publisher<MotionSegment>,
    truth: Publisher<SimTruth>,
    events: Publisher<PrintEvent>,
    // Latched: kept alive for late joiners.
    info: Publisher<PrintInfo>,
}

/// The printer and its connections.
struct Shell {
    simulator: Simulator,
    time: TimeBase,
    outlets: Outlets,
    frames: Option<Frames>,
    refused: Refused,
    refused_schedule: Refused,
    sessions: Sessions,
    diagnostics: Diagnostics,
    name: String,
    quantum_m: f64,
    segments: u64,
    looks: u32,
}

/// Runs until a signal ends it; the printer stays on the graph after its job has ended.
///
/// # Errors
/// What is refused of parameters and files, or an endpoint that cannot be made.
pub async fn run(node: Node) -> Result<(), LoadError> {
    node.check_parameters(load::check)?;
    match load::process(node.raw_parameters())? {
        ProcessKind::Fdm => extrude(node).await,
        ProcessKind::Wire => wall::run(node).await,
    }
}

async fn extrude(mut node: Node) -> Result<(), LoadError> {
    let Loaded { simulator, info, speed, host_clock, quantum_m, allow_fault_injection } =
        load::load(node.raw_parameters())?;
    let mut permits = node.subscribe(&topics::SAFETY_COMMAND)?;
    let mut schedule = node.subscribe(&topics::SAFETY_SCHEDULE)?;
    let mut faults = if allow_fault_injection { Some(node.serve(&topics::INJECT_FAULT)?) } else { None };
    let time = TimeBase::of(&mut node, host_clock)?;
    let outlets = Outlets::new(&mut node)?;
    let frames = node.raw_parameters().optional("frames")?;
    let frames = frames.map(|params| node.frames(params)).transpose()?;
    let work = node.work();
    let mut shell = Shell {
        simulator,
        time,
        outlets,
        frames,
        refused: Refused::new(node.diagnostics(), topics::SAFETY_COMMAND.name()),
        refused_schedule: Refused::new(node.diagnostics(), topics::SAFETY_SCHEDULE.name()),
        sessions: Sessions::default(),
        diagnostics: node.diagnostics(),
        name: node.name(),
        quantum_m,
        segments: 0,
        looks: 0,
    };
    node.activated().await;
    shell.outlets.info.send(info);
    shell.time.begin(shell.simulator.now());
    if let Some(frames) = &shell.frames {
        frames.tell(shell.now());
    }
    let mut pace = shell.time.pace(LOOK_PERIOD_S, speed);
    loop {
        tokio::select! {
            _ = pace.tick() => {
                shell.take_permits(&mut permits);
                shell.take_schedule(&mut schedule);
                shell.advance();
                work.done();
            }
            asked = next_fault(&mut faults) => shell.inject(faults.as_ref(), &asked),
            () = node.shutdown() => return Ok(()),
        }
    }
}

/// A permit whose stamp is of now, with what is left of its validity. A supervisor is who sends its permits, not who knows
/// its session.
fn permit(now: Seconds, received: &Received<ControlCommand>, sessions: &Sessions) -> Result<Permit, Reason> {
    let message = &received.message;
    let permit = wire::permit_from_wire(message).map_err(|error| Reason::from(&error))?;
    let session = sessions.of(received.publisher, permit.session);
    let age = of_now(now, &message.header)?;
    Permit { session, ..permit }.arrived(age).ok_or(Reason::Stale)
}

/// A trim of a coming move whose stamp is of now.
fn scheduled(
    now: Seconds,
    received: &Received<MotionTrim>,
    sessions: &Sessions,
) -> Result<Scheduled, Reason> {
    let message = &received.message;
    let scheduled = wire::schedule_from_wire(message).map_err(|error| Reason::from(&error))?;
    let session = sessions.of(received.publisher, scheduled.session);
    of_now(now, &message.header).map(|_| Scheduled { session, ..scheduled })
}

/// Age of a stamp that is of now.
fn of_now(now: Seconds, header: &Header) -> Result<Seconds, Reason> {
    let stamp = wire::stamp_from_wire(header).map_err(|error| Reason::from(&error))?;
    let age = now - stamp;
    runtime::check_age(age.0, crate::PERMIT_STAMP_LIMIT).map(|()| age)
}

async fn next_fault(faults: &mut Option<Server<InjectFault>>) -> Asked<InjectFault> {
    match faults {
        Some(server) => server.next().await,
        None => std::future::pending().await,
    }
}

impl Outlets {
    fn new(node: &mut Node) -> Result<Self, runtime::RuntimeError> {
        Ok(Self {
            temperatures: node.publish_on(&topics::TEMPERATURE_REPORT)?,
            filament: node.publish_on(&topics::FILAMENT_REPORT)?,
            width: node.publish_on(&topics::BEAD_WIDTH)?,
            imu: node.publish_on(&topics::IMU_REPORT)?,
            frames: node.publish_on(&topics::CAMERA_REPORT)?,
            state: node.publish_on(&topics::PRINTER_STATE)?,
            motion: node.publish_on(&topics::PRINTER_MOTION)?,
            coming: node.publish_on(&topics::PRINTER_COMING)?,
            truth: node.publish_on(&topics::SIM_TRUTH)?,
            events: node.publish_on(&topics::EVENTS)?,
            info: node.publish_on(&topics::PRINT_INFO)?,
        })
    }
}

impl Shell {
    /// Time now as stamps have it.
    fn now(&self) -> Seconds {
        self.simulator.now() + self.time.epoch()
    }

    fn take_permits(&mut self, permits: &mut Subscription<ControlCommand>) {
        while let Some(received) = permits.try_recv() {
            if let Err(reason) = self.take_permit(&received) {
                self.refused.count(reason);
            }
        }
    }

    fn take_permit(&mut self, received: &Received<ControlCommand>) -> Result<(), Reason> {
        let permit = permit(self.now(), received, &self.sessions)?;
        self.simulator.on_permit(permit).map_err(|_| Reason::Gate)
    }

    /// Those of the permits that have just been taken.
    fn take_schedule(&mut self, schedule: &mut Subscription<MotionTrim>) {
        while let Some(received) = schedule.try_recv() {
            let taken = scheduled(self.now(), &received, &self.sessions)
                .map(|scheduled| self.simulator.on_scheduled(&scheduled));
            match taken {
                Ok(Ok(())) => self.diagnostics.add("scheduled", 1),
                // Nobody's fault: the first moves after a halt begin as soon as they are known.
                Ok(Err(Unscheduled::Late)) => self.diagnostics.add("scheduled_late", 1),
                Ok(Err(Unscheduled::Refused(_))) => self.refused_schedule.count(Reason::Gate),
                Err(reason) => self.refused_schedule.count(reason),
            }
        }
    }

    fn advance(&mut self) {
        for _ in 0..STEPS_PER_LOOK {
            self.simulator.step(Seconds(STEP_S));
        }
        self.looks += 1;
        let reads = self.looks.is_multiple_of(LOOKS_PER_CLOCK);
        if reads {
            self.time.tell(self.simulator.now());
        }
        while let Some(output) = self.simulator.poll() {
            self.pass_on(output.after(self.time.epoch()));
        }
        if reads {
            self.tell_truth();
            alone::tell(&self.diagnostics, self.simulator.in_force(), self.simulator.status().phase);
        }
    }

    fn tell_truth(&self) {
        let epoch = self.time.epoch();
        let mut truth = *self.simulator.truth();
        truth.stamp_s += epoch.0;
        let first_onset = self.simulator.first_onset().map(|onset| onset + epoch);
        let motor_m = self.simulator.status().motor_position_m;
        self.outlets.truth.send(convert::truth(&truth, motor_m, first_onset));
    }

    fn pass_on(&mut self, output: Output) {
        let outlets = &self.outlets;
        match output {
            Output::Temperatures { stamp, hotend, bed, nozzle } => {
                outlets.temperatures.send(convert::temperatures(stamp, (hotend, bed, nozzle)))
            }
            Output::Encoder { stamp, counts } => {
                outlets.filament.send(convert::filament(stamp, counts, self.quantum_m))
            }
            Output::Width { exposed, width_m, sigma_m } => {
                outlets.width.send(convert::width(exposed, width_m, sigma_m))
            }
            Output::Imu(batch) => outlets.imu.send(convert::imu(*batch)),
            Output::Frame { exposed, jpeg, .. } => outlets.frames.send(convert::frame(exposed, jpeg)),
            Output::Status(status) => {
                let state = wire::status_to_wire(&status);
                if let Some(frames) = &mut self.frames {
                    frames.tool_at(status.stamp, state.position_m);
                }
                outlets.state.send(state)
            }
            Output::Motion { start, segment } => {
                self.segments += 1;
                let path_time_s = self.simulator.truth().path_time_s;
                outlets.motion.send(wire::motion_to_wire(start, path_time_s, self.segments, &segment))
            }
            Output::Coming { stamp, sequence, start_s, segment } => {
                // Numbered as the moves that begin; nobody asks where nothing can be attached.
                let number = sequence.saturating_add(1);
                !self.simulator.schedules()
                    || outlets.coming.send(wire::motion_to_wire(stamp, start_s, number, &segment))
            }
            Output::Note { stamp, text } => {
                tracing::info!("{text}");
                outlets.events.send(convert::note(&self.name, stamp, text))
            }
        };
    }
}
