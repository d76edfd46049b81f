//! The brain: takes events, yields a permit on every tick, and at once on a person's request and on a command.

mod beside;
mod brains;
mod evidence;
mod grace;
mod observe;
mod operate;
mod parts;
mod schedule;
mod stall;
mod standing;
mod thermal;
mod work;

use models::command::{Limits, Mode, Permit, Request, Trims};
use models::status::JobPhase;
use models::units::{Celsius, Seconds};

use crate::cause::Cause;
use crate::checks::part_fan;
use crate::envelope::{Envelope, Verdict};
use crate::event::{Decision, Event, Evidence, Output, PrinterReport, SafetyState, Stream, What};
use crate::modes::{Latch, Modes, Standing};
use crate::params::Params;
use crate::schedule::Schedule;
use beside::Told;
use brains::Brains;
use grace::Grace;
use parts::{Ages, Checks};

/// Guards one printer. Knows no clock and no middleware.
#[derive(Debug, Clone)]
pub struct Supervisor {
    params: Params,
    limits: Limits,
    session: u64,
    sequence: u64,
    modes: Modes,
    ages: Ages,
    checks: Checks,
    brains: Brains,
    envelope: Envelope,
    /// The newest command was of a publisher that is not in force.
    stranger: bool,
    schedule: Schedule,
    /// Trims of coming moves sent on so far.
    scheduled: u64,
    hotend: Option<Celsius>,
    printer: Option<PrinterReport>,
    printer_failed: bool,
    /// When the printer was told last to give its job up.
    told_off: Option<Seconds>,
    /// What the camera may say again, since a person has looked at it.
    grace: Option<Grace>,
    paused_alone_since: Option<Seconds>,
    /// A person has let the job go on, and the printer has not yet.
    takes_up: bool,
    /// What a person has let through, and of which controller's run.
    approved: Option<(u64, Trims)>,
    allowed: Trims,
    /// The tick's step of the trims, until a command has taken it again: where it began, and for how long it counts.
    step: Option<(Trims, Seconds)>,
    ramp: Option<(Seconds, Trims)>,
    /// Since when corrections have been free to come back; `None` while they are taken back.
    returning_since: Option<Seconds>,
    /// What a former run left behind.
    left: Standing,
    started: Option<Seconds>,
    last_tick: Option<Seconds>,
    last_stall: Option<Seconds>,
    /// The cause in force, and the number it rested on when it was found.
    found: Option<(Cause, Option<Evidence>)>,
    told: Told,
    decisions: Vec<Decision>,
}

impl Supervisor {
    /// Has seen nothing. `session` is a random id of this run; `restored` the latch that a former run left behind.
    #[must_use]
    pub fn new(params: Params, session: u64, restored: Option<Latch>) -> Self {
        Self {
            limits: params.limits,
            session,
            sequence: 0,
            modes: Modes::new(params.modes, params.start_mode.into(), restored),
            ages: Ages::new(&params),
            checks: Checks::new(&params),
            brains: Brains::default(),
            envelope: Envelope::new(params.envelope, params.limits),
            stranger: false,
            schedule: Schedule::new(params.envelope.schedule, params.limits),
            scheduled: 0,
            hotend: None,
            printer: None,
            printer_failed: false,
            told_off: None,
            grace: None,
            paused_alone_since: None,
            takes_up: false,
            approved: None,
            allowed: Trims::NEUTRAL,
            step: None,
            ramp: None,
            returning_since: None,
            left: Standing::default(),
            started: None,
            last_tick: None,
            last_stall: None,
            found: None,
            told: [false; Cause::COUNT],
            decisions: Vec::new(),
            params,
        }
    }

    /// Takes one event received at `now`. A tick yields the permit to publish; so does a person's request, at once, and
    /// the first command after a tick. What was decided beside is told with the next tick or request.
    /// Without a time no age can be told: there is no permit then, and the printer's dead-man takes over.
    pub fn on_event(&mut self, now: Seconds, event: Event) -> Option<Output> {
        let timeless = !now.0.is_finite() || matches!(event, Event::Tick { now } if !now.0.is_finite());
        let now = match event {
            Event::Operator(_) if timeless => self.last_tick.unwrap_or_default(),
            _ if timeless => return None,
            _ => now,
        };
        match event {
            Event::Tick { now } => return Some(self.on_tick(now)),
            Event::Operator(request) => {
                self.on_operator(now, request);
                return Some(self.output(now));
            }
            Event::Command(command) => {
                return self.on_command(now, command).then(|| self.answer(now)).flatten();
            }
            Event::RivalPermit => self.envelope.note_foreign_permit(now),
            Event::RivalSample => self.envelope.note_rival_sample(now),
            Event::Refused { .. } => self.checks.bad_values.note(now),
            Event::Beat { worker, work } => self.ages.beat(now, worker, work),
            Event::Look => self.ages.hearts.look(),
            Event::Imu { first, period, samples } => self.on_imu(now, (first, period), &samples),
            Event::Vision(report) => self.on_vision(now, &report),
            Event::Hotend { stamp, temp } => self.on_hotend(now, stamp, temp),
            Event::Bed { stamp, temp } => self.on_bed(now, stamp, temp),
            Event::Encoder { stamp, position_m } => self.on_encoder(now, stamp, position_m),
            Event::Printer(report) => self.on_printer(now, report),
            Event::EstimateHeartbeat { .. } => self.ages.estimate.note(now),
            Event::EstimateHealth(health) => self.brains.estimate = health,
            // Of a stranger nothing is believed, what it says of its health neither.
            Event::ControlHealth(_) if self.stranger => {}
            Event::ControlHealth(health) => self.brains.control = health,
        }
        None
    }

    /// Whether a stream has been heard of.
    #[must_use]
    pub fn is_seen(&self, stream: Stream) -> bool {
        self.ages.of(stream).is_seen()
    }

    /// True where the command was taken, as it came or clamped.
    fn on_command(&mut self, now: Seconds, command: models::command::Command) -> bool {
        let before = self.modes.mode();
        let verdict = self.envelope.on_command(now, command);
        let bound = self.envelope.bound();
        self.stranger = matches!(verdict, Verdict::Refused(_)) && bound != Some(command.session);
        // What is not carried out swings nothing.
        if before != Mode::Act || self.is_held(now) {
            self.checks.oscillation.rest();
        } else if !matches!(verdict, Verdict::Refused(_)) {
            self.checks.oscillation.on_trims(now, &command.trims);
        }
        let (what, why) = match verdict {
            Verdict::Taken => {
                self.ages.command.note(now);
                return true;
            }
            Verdict::Clamped => {
                self.ages.command.note(now);
                (What::CommandClamped, "outside of range or slew")
            }
            Verdict::Refused(refusal) => {
                if refusal == models::command::Refusal::NotFinite {
                    self.checks.bad_values.note(now);
                }
                (What::CommandRefused(refusal), refusal.text())
            }
        };
        let decision = Decision { what, why, cause: None, before, after: before };
        // Of a flood each kind is told once a tick; how many there were the counters say.
        if !self.decisions.contains(&decision) {
            self.decisions.push(decision);
        }
        what == What::CommandClamped
    }

    fn on_tick(&mut self, now: Seconds) -> Output {
        self.begin(now);
        let dt_s = self.last_tick.map_or(0.0, |last| now.0 - last.0);
        if !(0.0..self.params.modes.stall_s).contains(&dt_s) {
            self.on_stall(now, Seconds(dt_s));
        }
        self.fall_to_observe();
        let before = self.modes.mode();
        self.flag(now, before);
        self.initialise(now);
        let raised = self.raised(now);
        let job_runs = self.printer.is_some_and(|printer| {
            matches!(printer.phase, JobPhase::Preparing | JobPhase::Printing | JobPhase::Paused)
        });
        if self.modes.update(now, &raised, job_runs) {
            let after = self.modes.mode();
            let what = if before == after { What::CauseChanged } else { What::ModeChanged };
            self.find(now);
            let why = self.found.map_or("the cause is gone", |(cause, _)| cause.text());
            self.decisions.push(Decision { what, why, cause: self.found, before, after });
        }
        self.tell_beside(now, &raised);
        let paused_for = self.modes.paused_for();
        if self.modes.try_resume(now, self.readiness()) {
            self.resumed(now, paused_for);
            let after = self.modes.mode();
            let what = What::ModeChanged;
            self.decisions.push(Decision { what, why: "resumed", cause: None, before, after });
        }
        self.printer_failed = false;
        if self.modes.request(now) >= Request::HeatersOff {
            self.told_off = Some(now);
        }
        self.move_trims(now, Seconds(dt_s));
        self.last_tick = Some(now);
        self.output(now)
    }

    /// Tells what is worth a look and changes no mode.
    fn flag(&mut self, now: Seconds, mode: Mode) {
        let mut tell = |what: What, why: &'static str| {
            self.decisions.push(Decision { what, why, cause: None, before: mode, after: mode });
        };
        if self.checks.impulse.take() {
            tell(What::Impulse, "a knock or lost steps: the camera tells which");
        }
        if self.checks.part_fan.take(now) {
            tell(What::PartFanSlow, part_fan::SLOW);
        }
    }

    fn output(&mut self, now: Seconds) -> Output {
        if self.modes.mode() >= Mode::SafeOff {
            self.allowed = Trims::NEUTRAL;
        }
        let events = std::mem::take(&mut self.decisions);
        Output { permit: self.permit(now), state: self.state(), events }
    }

    fn permit(&mut self, now: Seconds) -> Permit {
        self.sequence += 1;
        Permit {
            session: self.session,
            sequence: self.sequence,
            validity: Seconds(self.params.permit_validity_s),
            mode: self.modes.mode(),
            request: self.modes.request(now),
            trims: self.allowed,
        }
    }

    fn state(&self) -> SafetyState {
        let mode = self.modes.mode();
        let cause = self.modes.cause().or(self.brains.fallen().filter(|_| mode == Mode::Observe));
        SafetyState {
            mode,
            set_mode: self.modes.set_mode(),
            cause,
            evidence: cause.and_then(|cause| self.evidence_of(cause)),
            since: self.modes.since(),
            what_to_do: cause.map_or("", Cause::what_to_do),
            attention: self.checks.attention.level(),
            refused_values: self.checks.bad_values.total(),
            refused_commands: self.envelope.refused(),
            clamped_commands: self.envelope.clamped(),
            scheduled: self.scheduled,
            refused_schedule: self.schedule.refused(),
            clamped_schedule: self.schedule.clamped(),
            impulses: self.checks.impulse.total(),
            part_fan_slow: self.last_tick.is_some_and(|now| self.checks.part_fan.is_slow(now)),
            hotend_excess_w: self.checks.heater.excess_w(),
            bed_excess_w: self.checks.bed_heater.excess_w(),
            drift_k: self.checks.drift.residual_k(),
            slip: self.checks.filament.slip(),
        }
    }
}
