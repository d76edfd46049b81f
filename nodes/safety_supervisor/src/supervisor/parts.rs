//! What the supervisor is made of beside its modes: ages of streams and checks.

use crate::attention::Attention;
use crate::cause::{Cause, Reaction};
use crate::checks::bad_values::Burst;
use crate::checks::defect::DefectCheck;
use crate::checks::detached::DetachedCheck;
use crate::checks::drift::DriftCheck;
use crate::checks::filament::FilamentCheck;
use crate::checks::frozen::FrozenCheck;
use crate::checks::hearts::HeartsCheck;
use crate::checks::heater::HeaterCheck;
use crate::checks::impulse::ImpulseCheck;
use crate::checks::jump::JumpCheck;
use crate::checks::noise::NoiseCheck;
use crate::checks::oscillation::OscillationCheck;
use crate::checks::pace::Pace;
use crate::checks::part_fan::PartFanCheck;
use crate::checks::range::RangeCheck;
use crate::checks::rising::RisingCheck;
use crate::checks::run_out::RunOutCheck;
use crate::checks::shift::ShiftCheck;
use crate::checks::stale::StaleCheck;
use crate::checks::stop_input::StopInputCheck;
use crate::checks::unjudged::UnjudgedCheck;
use crate::checks::unseen::UnseenCheck;
use crate::checks::work::WorkCheck;
use crate::event::{Defect, Stream, Worker};
use crate::params::{Params, Streams};
use models::units::Seconds;

/// What warms a hot end that is off: the bed below `[K/s]`. And a bed that is off: its chamber.
const HOTEND_DRIFT_K_S: f64 = 0.05;
const BED_DRIFT_K_S: f64 = 0.01;

/// Ages of the streams.
#[derive(Debug, Clone)]
pub(super) struct Ages {
    pub(super) hotend: StaleCheck,
    pub(super) bed: StaleCheck,
    pub(super) encoder: StaleCheck,
    pub(super) printer: StaleCheck,
    pub(super) command: StaleCheck,
    pub(super) estimate: StaleCheck,
    pub(super) imu: StaleCheck,
    pub(super) vision: StaleCheck,
    pub(super) hearts: HeartsCheck,
    pub(super) work: WorkCheck,
}

impl Ages {
    pub(super) fn new(params: &Params) -> Self {
        let stale = &params.stale;
        Self {
            hotend: StaleCheck::new(stale.hotend),
            bed: StaleCheck::new(stale.bed),
            encoder: StaleCheck::new(stale.encoder),
            printer: StaleCheck::new(stale.printer),
            command: StaleCheck::new(stale.command),
            estimate: StaleCheck::new(stale.estimate),
            imu: StaleCheck::new(stale.imu),
            vision: StaleCheck::new(stale.vision),
            hearts: HeartsCheck::new(stale.hang_s),
            work: WorkCheck::new(stale.work_s),
        }
    }

    /// A heart was heard.
    pub(super) fn beat(&mut self, now: Seconds, worker: Worker, work: u64) {
        self.hearts.beat(worker);
        self.work.beat(now, worker, work);
    }

    pub(super) fn of(&self, stream: Stream) -> &StaleCheck {
        match stream {
            Stream::Hotend => &self.hotend,
            Stream::Bed => &self.bed,
            Stream::Encoder => &self.encoder,
            Stream::Printer => &self.printer,
            Stream::Command => &self.command,
            Stream::Estimate => &self.estimate,
            Stream::Imu => &self.imu,
            Stream::Vision => &self.vision,
        }
    }

    /// The silence of the first process behind a cause that hangs, and what is allowed `[s]`.
    pub(super) fn hang_s(&self, cause: Cause) -> Option<(f64, f64)> {
        let workers: &[Worker] = match cause {
            Cause::StaleEncoder => &[Worker::Encoder],
            Cause::StaleEstimate => &[Worker::Estimator],
            Cause::StaleCommand => &[Worker::Controller],
            Cause::StaleVision => &[Worker::Camera, Worker::Judge],
            _ => &[],
        };
        workers.iter().find_map(|worker| self.hearts.hang_s(*worker))
    }

    /// The age of the stream behind a cause.
    pub(super) fn of_cause(&self, cause: Cause) -> Option<&StaleCheck> {
        Some(match cause {
            Cause::StaleHotend => &self.hotend,
            Cause::StaleBed => &self.bed,
            Cause::StaleEncoder => &self.encoder,
            Cause::StalePrinter => &self.printer,
            Cause::StaleCommand => &self.command,
            Cause::StaleEstimate => &self.estimate,
            Cause::StaleImu => &self.imu,
            Cause::StaleVision => &self.vision,
            _ => return None,
        })
    }

    /// What the silence behind a cause calls for: that of its stream, or else of the process that fills it. One that never
    /// filled it is not missed: it may have been started for something else, and have gone.
    pub(super) fn called_for(&self, now: Seconds, cause: Cause) -> Option<Reaction> {
        let age = self.of_cause(cause)?;
        let hangs = || self.hang_s(cause).filter(|_| age.is_seen());
        age.reaction(now).or_else(|| hangs().map(|_| Reaction::Degrade))
    }

    fn of_mut(&mut self, stream: Stream) -> &mut StaleCheck {
        match stream {
            Stream::Hotend => &mut self.hotend,
            Stream::Bed => &mut self.bed,
            Stream::Encoder => &mut self.encoder,
            Stream::Printer => &mut self.printer,
            Stream::Command => &mut self.command,
            Stream::Estimate => &mut self.estimate,
            Stream::Imu => &mut self.imu,
            Stream::Vision => &mut self.vision,
        }
    }

    /// Starts the ages of streams that must come but have not.
    pub(super) fn expect(&mut self, streams: Streams, now: Seconds) {
        streams.iter().for_each(|stream| self.of_mut(stream).expect(now));
    }

    pub(super) fn all_mut(&mut self) -> [&mut StaleCheck; 8] {
        [
            &mut self.hotend,
            &mut self.bed,
            &mut self.encoder,
            &mut self.printer,
            &mut self.command,
            &mut self.estimate,
            &mut self.imu,
            &mut self.vision,
        ]
    }
}

/// The checks beside ages and commands.
#[derive(Debug, Clone)]
pub(super) struct Checks {
    pub(super) hotend_pace: Pace,
    pub(super) hotend_range: RangeCheck,
    pub(super) bed_range: RangeCheck,
    pub(super) frozen: FrozenCheck,
    pub(super) detached: DetachedCheck,
    pub(super) heater: HeaterCheck,
    pub(super) unjudged: UnjudgedCheck,
    pub(super) rising: RisingCheck,
    pub(super) step: JumpCheck,
    pub(super) noise: NoiseCheck,
    pub(super) drift: DriftCheck,
    pub(super) bed_pace: Pace,
    pub(super) bed_frozen: FrozenCheck,
    pub(super) bed_detached: DetachedCheck,
    pub(super) bed_heater: HeaterCheck,
    pub(super) bed_unjudged: UnjudgedCheck,
    pub(super) bed_rising: RisingCheck,
    pub(super) unseen: UnseenCheck,
    pub(super) part_fan: PartFanCheck,
    pub(super) stop_input: StopInputCheck,
    pub(super) filament: FilamentCheck,
    pub(super) run_out: RunOutCheck,
    pub(super) impulse: ImpulseCheck,
    pub(super) shift: ShiftCheck,
    pub(super) defect: DefectCheck,
    pub(super) bad_values: Burst,
    pub(super) oscillation: OscillationCheck,
    pub(super) attention: Attention,
    /// What carried the confidence when attention rose last.
    pub(super) convicted: Option<Defect>,
    /// Attention for what a person has not looked at, while there is something that one has; and what carried it.
    pub(super) beside: Attention,
    pub(super) convicted_beside: Option<Defect>,
}

impl Checks {
    pub(super) fn new(params: &Params) -> Self {
        Self {
            hotend_pace: Pace::default(),
            hotend_range: RangeCheck::new(params.hotend_range),
            bed_range: RangeCheck::new(params.bed_range),
            frozen: FrozenCheck::new(params.frozen),
            detached: DetachedCheck::new(params.detached),
            heater: HeaterCheck::new(params.heater),
            unjudged: UnjudgedCheck::new(params.stale.hotend_unjudged_s),
            rising: RisingCheck::new(HOTEND_DRIFT_K_S),
            step: JumpCheck::new(params.hotend_step),
            noise: NoiseCheck::new(params.noise),
            drift: DriftCheck::new(params.drift),
            bed_pace: Pace::default(),
            bed_frozen: FrozenCheck::new(params.bed_frozen),
            bed_detached: DetachedCheck::new(params.bed_detached),
            bed_heater: HeaterCheck::new(params.bed_heater),
            bed_unjudged: UnjudgedCheck::new(params.stale.bed_unjudged_s),
            bed_rising: RisingCheck::new(BED_DRIFT_K_S),
            unseen: UnseenCheck::new(params.stale.unseen_s),
            part_fan: PartFanCheck::new(params.part_fan),
            stop_input: StopInputCheck::new(params.stop_input),
            filament: FilamentCheck::new(params.filament),
            run_out: RunOutCheck::new(params.run_out),
            impulse: ImpulseCheck::new(params.impulse),
            shift: ShiftCheck::new(params.shift),
            defect: DefectCheck::new(params.defect),
            bad_values: Burst::new(params.bad_values),
            oscillation: OscillationCheck::new(params.oscillation),
            attention: Attention::new(params.attention),
            convicted: None,
            beside: Attention::new(params.attention),
            convicted_beside: None,
        }
    }

    /// Time in which the supervisor stood still counts for no reading.
    pub(super) fn forgive(&mut self, now: Seconds, gap: Seconds) {
        self.frozen.forgive(now, gap);
        self.bed_frozen.forgive(now, gap);
        self.unjudged.forgive(now, gap);
        self.bed_unjudged.forgive(now, gap);
        self.unseen.forgive(now, gap);
        self.detached.reset();
        self.bed_detached.reset();
    }

    /// The clock was set back: times of before mean nothing any more.
    pub(super) fn set_back(&mut self) {
        self.part_fan.reset();
        self.run_out.reset();
        self.impulse.reset();
        self.defect.reset();
        self.bad_values.forget();
        self.oscillation.reset();
    }

    /// After a trip the filters start anew.
    pub(super) fn forget(&mut self) {
        self.heater.reset();
        self.frozen.reset();
        self.detached.reset();
        self.rising.reset();
        self.bed_rising.reset();
        self.step.reset();
        self.bed_frozen.reset();
        self.bed_detached.reset();
        self.bed_heater.reset();
        self.forget_halt();
    }

    /// After a pause: what hands do at a halted printer, new filament, and usual power and noise of a nozzle that may be
    /// another one count no more.
    pub(super) fn forget_halt(&mut self) {
        self.noise.reset();
        self.drift.reset();
        self.filament.reset();
        self.oscillation.reset();
        self.forget_pictures();
    }

    /// What the camera's judge has said counts no more.
    pub(super) fn forget_pictures(&mut self) {
        self.shift.reset();
        self.defect.reset();
        self.attention.reset();
        self.convicted = None;
        self.beside.reset();
        self.convicted_beside = None;
    }
}
