//! The whole loop in one process and virtual time: the simulated printer and every brain, wired as over DDS.

mod ahead;
mod supervision;
mod traffic;

use super::bagging::Bagging;
use super::consistency::Consistency;
use super::foresight::Foresight;
use super::relay::Relay;
use super::report::{Detection, Extremes, FilePause};
use super::sight::{Sight, SightFigures};
use super::trimmed::Trimmed;
use super::width_trace::WidthTrace;
use crate::config::Setup;
use models::command::Trims;
use models::status::JobPhase;
use models::units::Seconds;
use mpc_controller::Controller;
use printer_sim::pace::Pace;
use printer_sim::{JobSource, Output, Scenario, Simulator};
use safety_supervisor::params::Stales;
use safety_supervisor::{Cause, Operator, SafetyState, Supervisor};
use state_estimator::Estimator;

/// Step of the simulation `[s]`.
const STEP_S: f64 = 1e-3;
/// Period of the supervisor's permit `[s]`: faults.md, 50 Hz.
const PERMIT_PERIOD_S: f64 = 0.02;
/// Session ids: one process, so any two different ones do.
pub(super) const CONTROLLER_SESSION: u64 = 1;
const SUPERVISOR_SESSION: u64 = 2;

/// Everything that runs.
pub struct Printing {
    simulator: Simulator,
    estimator: Estimator,
    controller: Controller,
    supervisor: Supervisor,
    /// Ages at which the supervisor takes no stamp any more.
    stale: Stales,
    relay: Option<Relay>,
    bagging: Option<Bagging>,
    /// The supervisor's state as it was last said.
    pub safety: Option<SafetyState>,
    estimate_pace: Pace,
    control_pace: Pace,
    permit_pace: Pace,
    sight: Option<Sight>,
    /// The advance predictor.
    pub foresight: Foresight,
    encoder_quantum_m: f64,
    /// Estimation error against stated uncertainty.
    pub consistency: Consistency,
    /// Width error along slicer time.
    pub width: WidthTrace,
    /// Mean NIS by channel so far.
    pub nis_mean: [Option<f64>; state_estimator::CHANNELS],
    /// What the loop noticed.
    pub noticed: Vec<Detection>,
    /// Session of the newest permit that the printer has taken.
    pub obeyed: Option<u64>,
    /// Pauses that the file itself asked for.
    pub file_pauses: Vec<FilePause>,
    /// How much of the time corrections were more than small.
    pub trimmed: Trimmed,
    /// Largest corrections so far.
    pub extremes: Extremes,
    /// Scores when the feed error starts to count as settled, and with a slow host.
    pub settled: [Option<printer_sim::score::Integrals>; 2],
    /// Slicer time of the first onset `[s]`.
    pub onset_path_s: Option<f64>,
    paused_since: Option<Seconds>,
    /// How long a trim of a coming move holds, as its message says.
    schedule_validity: Seconds,
    /// Trims of coming moves so far, where no bag counts them.
    scheduled: u64,
    /// Phase of the job as the printer said it last.
    told_phase: Option<JobPhase>,
}

/// A pause that lasts this long waits for a person, who does not exist here `[s]`.
const PAUSED_FOR_GOOD_S: f64 = 10.0;

/// From here on after the onset the feed error counts as settled `[s]`.
const SETTLE_S: [f64; 2] = [2.0, 8.0];

impl Printing {
    /// A cold printer with a job.
    ///
    /// # Errors
    /// What the brains refuse of their parameters.
    pub fn new(setup: &Setup, job: JobSource, scenario: &Scenario, seed: u64) -> anyhow::Result<Self> {
        let nominal = (&setup.printer.hotend, &setup.printer.extruder);
        let controller = setup.controller.in_virtual_time();
        Ok(Self {
            simulator: Simulator::new(setup.simulated.clone(), job, scenario, seed)?,
            estimator: Estimator::new(setup.estimator, nominal, &setup.material),
            controller: Controller::new(controller, nominal, &setup.material, CONTROLLER_SESSION)?,
            supervisor: Supervisor::new(setup.supervisor, SUPERVISOR_SESSION, None),
            stale: setup.supervisor.stale,
            relay: None,
            bagging: None,
            safety: None,
            estimate_pace: Pace::new(setup.estimator.period_s),
            control_pace: Pace::new(setup.controller.period_s),
            permit_pace: Pace::new(PERMIT_PERIOD_S),
            sight: setup.sight.as_ref().map(Sight::new).transpose()?,
            foresight: Foresight::new(setup.foresight.as_ref()),
            encoder_quantum_m: setup.simulated.simulator.sensors.encoder_quantum_m,
            consistency: Consistency::default(),
            width: WidthTrace::default(),
            nis_mean: [None; state_estimator::CHANNELS],
            noticed: Vec::new(),
            obeyed: None,
            file_pauses: Vec::new(),
            trimmed: Trimmed::default(),
            extremes: Extremes::default(),
            settled: [None; 2],
            onset_path_s: None,
            paused_since: None,
            schedule_validity: Seconds(setup.controller.advance.schedule_validity_s),
            scheduled: 0,
            told_phase: None,
        })
    }

    /// Advances by one step; false once the job has ended and the printer has said so.
    pub fn step(&mut self) -> bool {
        self.simulator.step(Seconds(STEP_S));
        let now = self.now();
        while let Some(output) = self.simulator.poll() {
            self.pass_on(now, output);
        }
        let ended = self.has_ended();
        if ended && self.told_phase != Some(self.simulator.phase()) {
            // Nobody would hear the next report.
            self.pass_on(now, Output::Status(Box::new(self.simulator.status())));
        }
        self.deliver_late(now);
        if self.estimate_pace.due(now) {
            self.estimate(now);
        }
        if self.control_pace.due(now)
            && let Some(command) = self.controller.on_event(mpc_controller::Event::Tick { now })
        {
            self.wish(now, command);
        }
        if self.permit_pace.due(now) {
            self.permit(now);
        }
        if let Some(bagging) = &mut self.bagging {
            bagging.truth(now, &self.simulator);
        }
        self.observe();
        !ended
    }

    fn has_ended(&self) -> bool {
        matches!(self.simulator.phase(), JobPhase::Done | JobPhase::Failed)
    }

    /// The same loop with a bag of all that is said. What the brains get went over the wire, so that they can get the same
    /// from the bag.
    #[must_use]
    pub fn with_bagging(mut self, bagging: Bagging) -> Self {
        self.bagging = Some(bagging);
        self
    }

    /// The bag, to close it.
    pub fn take_bagging(&mut self) -> Option<Bagging> {
        self.bagging.take()
    }

    /// Time of the simulation; where a bag is written, without what summing its steps has left.
    fn now(&self) -> Seconds {
        let now = self.simulator.now();
        if self.bagging.is_some() {
            super::bagging::as_stamped(Seconds((now.0 * 1e6).round() / 1e6))
        } else {
            now
        }
    }

    /// The same loop with a relay on the ways of its messages.
    #[must_use]
    pub fn with_relay(mut self, relay: Relay) -> Self {
        self.relay = Some(relay);
        self
    }

    /// The relay, to begin and to end what it does.
    pub fn relay(&mut self) -> Option<&mut Relay> {
        self.relay.as_mut()
    }

    /// A person asks the supervisor, which answers at once.
    pub fn ask(&mut self, request: Operator) {
        let now = self.simulator.now();
        if let Some(output) = self.supervisor.on_event(now, safety_supervisor::Event::Operator(request)) {
            self.say(now, output);
        }
    }

    /// The simulated printer, to do something to it.
    pub fn simulator_mut(&mut self) -> &mut Simulator {
        &mut self.simulator
    }

    /// The controller, for its report.
    #[must_use]
    pub fn controller(&self) -> &Controller {
        &self.controller
    }

    /// The simulated printer, for its truth and its end.
    #[must_use]
    pub fn simulator(&self) -> &Simulator {
        &self.simulator
    }

    /// The print waits for a person.
    #[must_use]
    pub fn is_stuck(&self) -> bool {
        self.paused_since.is_some_and(|since| (self.simulator.now() - since).0 > PAUSED_FOR_GOOD_S)
    }

    /// What the camera's widths were worth, where there is one.
    #[must_use]
    pub fn sight(&self) -> Option<SightFigures> {
        self.sight.as_ref().map(Sight::figures)
    }

    /// Notes a pause that the printer made by itself since its file says so: somebody is to change the filament, say.
    fn adopts_pause(&mut self, now: Seconds, cause: Option<Cause>) -> bool {
        let line = self.simulator.paused_by_line().filter(|_| cause == Some(Cause::PrinterPaused));
        self.file_pauses.extend(line.map(|line| FilePause { line, detected_s: now.0 }));
        line.is_some()
    }

    fn note_extremes(&mut self, trims: &Trims) {
        if self.simulator.truth().depositing {
            let pace = self.simulator.planned_pace();
            self.trimmed.add(trims, self.controller.report().base, pace);
        }
        let most = &mut self.extremes;
        most.flow = most.flow.max((trims.flow - 1.0).abs());
        most.speed = most.speed.max((trims.speed - 1.0).abs());
        most.setpoint_k = most.setpoint_k.max(trims.setpoint_offset_k.abs());
        most.slip = most.slip.max(trims.slip.unwrap_or(0.0).abs());
    }

    fn observe(&mut self) {
        if self.simulator.phase() == JobPhase::Paused {
            self.paused_since.get_or_insert(self.simulator.now());
        } else {
            self.paused_since = None;
        }
        let truth = self.simulator.truth();
        if let Some(sight) = &mut self.sight {
            sight.note_truth(truth);
        }
        if truth.depositing && truth.target_width_m > 0.0 {
            let error = truth.width_m / truth.target_width_m - 1.0;
            self.width.add(truth.path_time_s, error, STEP_S);
            let sliced_m_s = self.simulator.sliced_speed_m_s();
            self.foresight.corners.add(truth.stamp_s, sliced_m_s, error, STEP_S);
        } else {
            self.foresight.corners.pass();
        }
        let Some(onset) = self.simulator.first_onset() else { return };
        self.onset_path_s.get_or_insert(truth.path_time_s);
        for (settled, after_s) in self.settled.iter_mut().zip(SETTLE_S) {
            if truth.stamp_s >= onset.0 + after_s {
                settled.get_or_insert(truth.integrals);
            }
        }
    }
}

#[cfg(test)]
mod tests;
