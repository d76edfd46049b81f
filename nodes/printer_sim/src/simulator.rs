//! The simulated printer as a whole: job, drive, plant, firmware's heaters, sensors, dead-man.

use crate::camera::Camera;
use crate::drive::Drive;
use crate::executor::{Coming, Executor, Motion, Sliced, Surroundings};
use crate::fan::PartFan;
use crate::faults::{Fault, InForce as FaultsInForce};
use crate::heaters::Heaters;
use crate::imu::Imu;
use crate::job::Preheat;
use crate::output::{Output, Truth};
use crate::pace::Pace;
use crate::params::Params;
use crate::plant::{Inputs, Plant, Push, Road};
use crate::scenario::{Entry, Scenario};
use crate::score::Score;
use crate::sensors::{Noise, Thermometer, WidthGauge};
use crate::toolhead::Toolhead;
use elapsed::Elapsed;
use link::Link;
use models::command::{
    AdvanceHandover, DeadMan, InForce, Mode, Permit, Refusal, Request, ScheduleGate, Trims,
};
use models::motion::{MoveKind, Step};
use models::params::ParamError;
use models::status::JobPhase;
use models::units::{Kelvin, Seconds};
use schedule::Roads;
use sense::Lines;
use std::collections::VecDeque;

mod camera;
mod elapsed;
mod faults;
mod link;
mod obey;
mod schedule;
mod sense;
mod status;
#[cfg(test)]
pub(crate) mod tests;
mod truth;

pub use schedule::Unscheduled;

/// What is to be printed.
pub struct JobSource {
    /// The planned steps of the file.
    pub steps: Box<dyn Iterator<Item = Step> + Send>,
    /// Filament that the steps push, retractions not subtracted `[m]`: the base of `filament_share`.
    pub filament_m: f64,
    /// First set-points of the file.
    pub preheat: Preheat,
}

/// Beats of everything that happens slower than a step.
struct Paces {
    thermal: Pace,
    heaters: Pace,
    temperature: Pace,
    encoder: Pace,
    width: Pace,
    status: Pace,
}

/// A printer with everything in it.
pub struct Simulator {
    params: Params,
    now: Seconds,
    elapsed: Elapsed,
    executor: Executor,
    filament_m: f64,
    drive: Drive,
    plant: Plant,
    heaters: Heaters,
    part_fan: PartFan,
    dead_man: DeadMan,
    entries: Vec<Entry>,
    faults: Vec<Fault>,
    faults_in_force: FaultsInForce,
    lines: Lines,
    hotend_sensor: Thermometer,
    bed_sensor: Thermometer,
    nozzle_sensor: Option<Thermometer>,
    width_gauge: WidthGauge,
    paces: Paces,
    mains_on: bool,
    given_up: bool,
    done_noted: bool,
    in_force: InForce,
    motion: Motion,
    toolhead: Toolhead,
    imu: Option<Imu>,
    camera: Option<Box<dyn Camera>>,
    advance_s: f64,
    handover: AdvanceHandover,
    roads: Roads,
    schedule_gate: ScheduleGate,
    scheduled: bool,
    /// Filament that is held without an advance that pushed it, as the newest move under way has it `[m]`.
    carried_m: f64,
    link: Option<Link>,
    /// Sum of the duty since the last status of a slow host, and the number of its steps.
    duty: (f64, f64),
    score: Score,
    truth: Truth,
    outputs: VecDeque<Output>,
}

impl Simulator {
    /// A cold printer with a job; `seed` drives all noise.
    ///
    /// # Errors
    /// [`ParamError`] where the plant's deviation makes no material of the given one.
    pub fn new(params: Params, job: JobSource, scenario: &Scenario, seed: u64) -> Result<Self, ParamError> {
        let (plant, host, sensors) = (&params.plant, &params.simulator, params.simulator.sensors);
        let material = plant.material_deviation.apply(&params.material)?;
        let off = Sliced { advance_s: host.firmware.advance_s, ..Sliced::OFF };
        let thermometer =
            |stream| Thermometer::new(sensors.temperature_sigma_k, Noise::new(seed, stream), plant.ambient());
        Ok(Self {
            now: Seconds(0.0),
            elapsed: Elapsed::default(),
            executor: Executor::new(host.executor, job.steps, off),
            filament_m: job.filament_m,
            duty: (0.0, 0.0),
            drive: Drive::new(host.drive, host.executor.host),
            plant: Plant::new(plant, material, Noise::new(seed, 4)),
            heaters: Heaters::new(plant),
            part_fan: PartFan::new(host.firmware.part_fan),
            dead_man: DeadMan::new(params.dead_man, params.limits),
            entries: scenario.faults.clone(),
            faults: Vec::new(),
            faults_in_force: FaultsInForce::NONE,
            lines: Lines::default(),
            hotend_sensor: thermometer(1),
            bed_sensor: thermometer(2),
            nozzle_sensor: sensors.nozzle_sensor.then(|| thermometer(8)),
            width_gauge: WidthGauge::new(&sensors, Noise::new(seed, 3)),
            paces: Paces {
                thermal: Pace::new(host.firmware.thermal_period_s),
                heaters: Pace::new(params.plant.heater.period().0),
                temperature: Pace::new(sensors.temperature_period_s),
                encoder: Pace::new(sensors.encoder_period_s),
                width: Pace::dithered(sensors.width_period_s, sensors.width_dither),
                status: Pace::new(host.firmware.status_period_s),
            },
            mains_on: true,
            given_up: false,
            done_noted: false,
            in_force: InForce {
                trims: Trims::NEUTRAL,
                request: Request::Run,
                mode: Mode::Init,
                lapsed: true,
            },
            motion: Motion::default(),
            toolhead: Toolhead::default(),
            imu: host.imu.fitted().then(|| {
                let noises = (Noise::new(seed, 5), Noise::new(seed, 6));
                Imu::new(host.imu, (plant.structure, plant.impact), noises)
            }),
            camera: camera::of(&params.camera, seed),
            advance_s: host.firmware.advance_s,
            handover: AdvanceHandover::new(host.firmware.advance_s),
            roads: Roads::NONE,
            schedule_gate: ScheduleGate::new(Seconds(host.executor.schedule_validity_max_s)),
            scheduled: false,
            carried_m: 0.0,
            link: host.firmware.effect_s.map(|effect_s| Link::new(effect_s, Noise::new(seed, 7))),
            score: Score::new(params.quality),
            truth: Truth::default(),
            outputs: VecDeque::new(),
            params,
        })
    }

    /// Brings hot end and bed to these temperatures at once: the printer was in use before.
    pub fn warm_up(&mut self, preheat: &Preheat) {
        let (hotend, bed) = (preheat.hotend.map(Kelvin::from), preheat.bed.map(Kelvin::from));
        self.plant.warm_up(hotend, bed);
        self.hotend_sensor.set(self.plant.sensor());
        self.bed_sensor.set(self.plant.bed());
    }

    /// Takes a permit of the supervisor, or refuses and counts it.
    ///
    /// # Errors
    /// The reason, see [`Refusal`].
    pub fn on_permit(&mut self, permit: Permit) -> Result<(), Refusal> {
        self.dead_man.on_permit(self.now, permit)
    }

    /// Advances by `dt`, at most one millisecond if the figures are to count.
    pub fn step(&mut self, dt: Seconds) {
        self.now = self.elapsed.step(dt);
        let before = std::mem::replace(&mut self.in_force, self.dead_man.in_force(self.now));
        // A person's resume ends the pause that the file itself asked for (`M0`, `M600`) as well.
        if before.request >= Request::Pause && self.in_force.request == Request::Run {
            self.executor.resume();
        }
        if let Some(link) = &mut self.link {
            self.in_force.trims = link.step(self.now, self.in_force.trims);
        }
        self.obey(before.request);
        self.set_in_faults();

        let around = Surroundings {
            trims: self.in_force.trims,
            slowest_attached: self.slowest_attached(),
            hold: self.given_up || self.in_force.request >= Request::Pause,
            hotend: self.hotend_sensor.last(),
            bed: self.bed_sensor.last(),
        };
        let start = self.now - dt;
        let outputs = &mut self.outputs;
        self.motion = self.executor.step(dt, &around, |segment, into| {
            outputs.push_back(Output::Motion { start: start + into, segment: Box::new(*segment) });
        });
        for Coming { sequence, start_s, segment } in self.executor.take_coming() {
            self.outputs.push_back(Output::Coming { stamp: self.now, sequence, start_s, segment });
        }
        self.toolhead.home(self.motion.homing);
        self.feel(dt);
        let trims = self.motion.trims.unwrap_or(self.in_force.trims);
        let sensors = &self.params.simulator.sensors;
        let fitted = sensors.encoder_period_s > 0.0;
        #[allow(clippy::cast_precision_loss, reason = "counts of a print are far below 2^52")]
        let encoder_m = fitted.then(|| self.heard_counts() as f64 * sensors.encoder_quantum_m);
        let goal = self.advance_goal(&trims, dt);
        let motor_m_s = self.drive.step(self.motion.feed, &trims, goal, (encoder_m, dt.0));

        let road = self.road().filter(|_| !self.faults_in_force.detached);
        let push = Push { motor_m_s, path_speed_m_s: self.motion.path_speed_m_s, road };
        self.plant.push(push, &self.faults_in_force, dt);
        if self.paces.thermal.due(self.now) {
            self.heat();
        }
        let outlet_before_m = self.truth.outlet_m;
        self.note_truth(road);
        self.photograph(road, outlet_before_m);
        self.sense(road);
    }

    /// The road that the file wants under the nozzle, if one.
    fn road(&self) -> Option<Road> {
        let segment = self.executor.segment()?;
        if segment.kind != MoveKind::Deposit || self.motion.path_speed_m_s <= 0.0 {
            return None;
        }
        Some(Road { target_width_m: segment.target_width_m?, height_m: segment.layer_height_m? })
    }

    fn heat(&mut self) {
        let dt = Seconds(self.params.simulator.firmware.thermal_period_s);
        let inputs = Inputs {
            hotend_duty: if self.mains_on { self.heaters.hotend_duty } else { 0.0 },
            bed_duty: if self.mains_on { self.heaters.bed_duty } else { 0.0 },
            mains_on: self.mains_on,
            fan: self.fan(),
        };
        self.part_fan.step(inputs.fan * self.faults_in_force.fan_gain, dt);
        self.plant.heat(&inputs, &self.faults_in_force, dt);
    }

    fn note(&mut self, text: &str) {
        self.outputs.push_back(Output::Note { stamp: self.now, text: text.to_owned() });
    }

    /// Where the job stands.
    #[must_use]
    pub fn phase(&self) -> JobPhase {
        let phase = self.executor.phase();
        if self.given_up && phase != JobPhase::Done { JobPhase::Failed } else { phase }
    }

    /// Time of the simulation.
    #[must_use]
    pub fn now(&self) -> Seconds {
        self.now
    }

    /// What the dead-man has the printer do.
    #[must_use]
    pub fn in_force(&self) -> &InForce {
        &self.in_force
    }

    /// The dead-man, for its counters.
    #[must_use]
    pub fn dead_man(&self) -> &DeadMan {
        &self.dead_man
    }
}
