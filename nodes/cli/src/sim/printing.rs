//! The whole loop in one process and virtual time: the simulated printer and every brain, wired as over DDS.

use super::consistency::Consistency;
use super::foresight::Foresight;
use super::report::{Detection, Extremes};
use super::sight::{Seen, Sight, SightFigures};
use super::width_trace::WidthTrace;
use crate::config::Setup;
use models::command::{Mode, Trims};
use models::status::JobPhase;
use models::units::{Kelvin, Seconds};
use mpc_controller::Controller;
use printer_sim::sensors::Pace;
use printer_sim::{JobSource, Output, Scenario, Simulator};
use safety_supervisor::{PrinterReport, Supervisor, What};
use state_estimator::{Channel, Estimator, state};

/// Step of the simulation `[s]`.
const STEP_S: f64 = 1e-3;
/// Period of the supervisor's permit `[s]`: faults.md, 50 Hz.
const PERMIT_PERIOD_S: f64 = 0.02;
/// Session ids: one process, so any two different ones do.
const CONTROLLER_SESSION: u64 = 1;
const SUPERVISOR_SESSION: u64 = 2;

/// Everything that runs.
pub struct Printing {
    simulator: Simulator,
    estimator: Estimator,
    controller: Controller,
    supervisor: Supervisor,
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
    /// Largest corrections so far.
    pub extremes: Extremes,
    /// Score when the feed error starts to count as settled.
    pub settled: Option<printer_sim::score::Integrals>,
    /// Slicer time of the first onset `[s]`.
    pub onset_path_s: Option<f64>,
    paused_since: Option<Seconds>,
}

/// A pause that lasts this long waits for a person, who does not exist here `[s]`.
const PAUSED_FOR_GOOD_S: f64 = 10.0;

/// From here on after the onset the feed error counts as settled `[s]`.
const SETTLE_S: f64 = 2.0;

impl Printing {
    /// A cold printer with a job.
    ///
    /// # Errors
    /// What the brains refuse of their parameters.
    pub fn new(setup: &Setup, job: JobSource, scenario: &Scenario, seed: u64) -> anyhow::Result<Self> {
        let nominal = (&setup.printer.hotend, &setup.printer.extruder);
        Ok(Self {
            simulator: Simulator::new(setup.simulated.clone(), job, scenario, seed)?,
            estimator: Estimator::new(setup.estimator, nominal, &setup.material),
            controller: Controller::new(setup.controller, nominal, &setup.material, CONTROLLER_SESSION)?,
            supervisor: Supervisor::new(setup.supervisor, SUPERVISOR_SESSION, None),
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
            extremes: Extremes::default(),
            settled: None,
            onset_path_s: None,
            paused_since: None,
        })
    }

    /// Advances by one step; false once the job has ended.
    pub fn step(&mut self) -> bool {
        self.simulator.step(Seconds(STEP_S));
        let now = self.simulator.now();
        while let Some(output) = self.simulator.poll() {
            self.pass_on(now, output);
        }
        if self.estimate_pace.due(now) {
            self.estimate(now);
        }
        if self.control_pace.due(now)
            && let Some(command) = self.controller.on_event(mpc_controller::Event::Tick { now })
        {
            self.supervisor.on_event(now, safety_supervisor::Event::Command(command));
        }
        if self.permit_pace.due(now) {
            self.permit(now);
        }
        self.observe();
        !matches!(self.simulator.phase(), JobPhase::Done | JobPhase::Failed)
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

    fn pass_on(&mut self, now: Seconds, output: Output) {
        use safety_supervisor::Event as Safety;
        match output {
            Output::Temperatures { stamp, hotend, bed } => {
                self.estimator.on_event(state_estimator::Event::Hotend { stamp, temp: hotend });
                self.supervisor.on_event(now, Safety::Hotend { stamp, temp: hotend });
                self.supervisor.on_event(now, Safety::Bed { stamp, temp: bed });
            }
            Output::Encoder { stamp, counts } => {
                #[allow(clippy::cast_precision_loss, reason = "counts of a print are far below 2^52")]
                let position_m = counts as f64 * self.encoder_quantum_m;
                self.estimator.on_event(state_estimator::Event::Encoder { stamp, position_m });
                self.controller.on_event(mpc_controller::Event::Encoder { stamp, position_m });
                self.supervisor.on_event(now, Safety::Encoder { stamp, position_m });
            }
            Output::Width { exposed, width_m, sigma_m } => {
                self.estimator.on_event(state_estimator::Event::Width { exposed, width_m, sigma_m });
                self.controller.on_event(mpc_controller::Event::Width { exposed, width_m });
            }
            Output::Status(status) => {
                self.note_extremes(&status.trims);
                if let Some(sight) = &mut self.sight {
                    sight.on_status(&status);
                }
                self.estimator.on_event(state_estimator::Event::Printer(*status));
                let told = self.foresight.on_status(&status);
                self.controller.on_event(mpc_controller::Event::Printer(*status));
                self.tell(told);
                self.supervisor.on_event(now, Safety::Printer(report_of(&status)));
            }
            Output::Imu(batch) => {
                let (first, period, samples) = (batch.first, batch.period, batch.samples);
                self.supervisor.on_event(now, Safety::Imu { first, period, samples });
            }
            Output::Frame { exposed, jpeg, .. } => self.see(now, exposed, jpeg),
            Output::Motion { start, segment } => {
                if let Some(sight) = &mut self.sight {
                    sight.on_motion(start, &segment);
                }
                let told = self.foresight.on_motion(start, &segment);
                self.tell(told);
            }
            Output::Note { .. } => {}
        }
    }

    fn tell(&mut self, told: Option<mpc_controller::advance::Prediction>) {
        if let Some(prediction) = told {
            self.controller.on_event(mpc_controller::Event::Prediction(prediction));
        }
    }

    fn see(&mut self, now: Seconds, exposed: Seconds, jpeg: Vec<u8>) {
        let Some(sight) = &mut self.sight else { return };
        for seen in sight.on_frame(exposed, jpeg) {
            match seen {
                Seen::Width { laid, width_m, sigma_m } => {
                    let exposed = laid;
                    self.estimator.on_event(state_estimator::Event::Width { exposed, width_m, sigma_m });
                    self.controller.on_event(mpc_controller::Event::Width { exposed, width_m });
                }
                Seen::Report(report) => {
                    self.supervisor.on_event(now, safety_supervisor::Event::Vision(report));
                }
            }
        }
    }

    /// What the camera's widths were worth, where there is one.
    #[must_use]
    pub fn sight(&self) -> Option<SightFigures> {
        self.sight.as_ref().map(Sight::figures)
    }

    fn estimate(&mut self, now: Seconds) {
        let Some(estimate) = self.estimator.on_event(state_estimator::Event::Tick { now }) else { return };
        self.consistency.add(&estimate, self.simulator.truth());
        self.nis_mean = estimate.nis_mean;
        if let Some(sight) = &mut self.sight {
            sight.on_estimate(&estimate);
        }
        self.supervisor.on_event(now, safety_supervisor::Event::EstimateHeartbeat { stamp: now });
        let for_control = mpc_controller::Estimate {
            stamp: estimate.stamp,
            nozzle: Kelvin(estimate.x[state::NOZZLE]),
            flow_m_s: estimate.x[state::FLOW].max(0.0),
            slip: estimate.x[state::SLIP],
            gain: estimate.x[state::GAIN],
            reference_feed_m_s: estimate.reference_feed_m_s,
            encoder_alive: estimate.alive[Channel::Encoder as usize],
        };
        if let Some(command) = self.controller.on_event(mpc_controller::Event::Estimate(for_control)) {
            self.supervisor.on_event(now, safety_supervisor::Event::Command(command));
        }
    }

    fn permit(&mut self, now: Seconds) {
        let Some(output) = self.supervisor.on_event(now, safety_supervisor::Event::Tick { now }) else {
            return;
        };
        // A refused permit is counted by the dead-man itself.
        let _taken = self.simulator.on_permit(output.permit);
        let onset_s = self.simulator.first_onset().map(|onset| onset.0);
        let cause = output.state.cause.map_or_else(String::new, |cause| cause.id().to_owned());
        for event in &output.events {
            let (fault, action) = match event.what {
                What::Impulse => ("P8".to_owned(), "flagged".to_owned()),
                _ if event.before != event.after && event.after >= Mode::Degraded => {
                    (cause.clone(), format!("{:?}", event.after).to_lowercase())
                }
                _ => continue,
            };
            self.noticed.push(Detection { fault, onset_s, detected_s: now.0, action });
        }
    }

    fn note_extremes(&mut self, trims: &Trims) {
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
            self.foresight.corners.add(truth.stamp_s, truth.path_speed_m_s, error, STEP_S);
        } else {
            self.foresight.corners.pass();
        }
        let Some(onset) = self.simulator.first_onset() else { return };
        self.onset_path_s.get_or_insert(truth.path_time_s);
        if truth.stamp_s >= onset.0 + SETTLE_S {
            self.settled.get_or_insert(truth.integrals);
        }
    }
}

fn report_of(status: &models::status::PrinterStatus) -> PrinterReport {
    PrinterReport {
        stamp: status.stamp,
        phase: status.phase,
        motor_position_m: status.motor_position_m,
        wanted_position_m: status.wanted_position_m,
        hotend_duty: status.hotend_duty,
        bed_duty: status.bed_duty,
        hotend_target: status.hotend_target,
        hotend_sliced_target: status.hotend_sliced_target,
        bed_target: status.bed_target,
        fan: status.fan,
        trims: status.trims,
        path_speed_m_s: status.path_speed_m_s,
        filament_present: status.filament_present,
        homed: status.homed,
        mains_on: status.mains_on,
    }
}
