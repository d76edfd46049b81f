//! The brain: takes events, yields a permit on every tick and at once on a person's request.

mod observe;
mod operate;

use models::command::{Limits, Mode, Permit, Trims};
use models::status::JobPhase;
use models::units::{Celsius, Seconds};

use crate::attention::Attention;
use crate::cause::Cause;
use crate::checks::bad_values::Burst;
use crate::checks::detached::DetachedCheck;
use crate::checks::filament::FilamentCheck;
use crate::checks::frozen::FrozenCheck;
use crate::checks::heater::HeaterCheck;
use crate::checks::range::RangeCheck;
use crate::checks::run_out::RunOutCheck;
use crate::checks::stale::StaleCheck;
use crate::envelope::{Envelope, Verdict};
use crate::event::{Decision, Event, Output, PrinterReport, SafetyState, Stream, What};
use crate::modes::{Latch, Modes};
use crate::params::Params;

/// Ages of the streams.
#[derive(Debug, Clone)]
struct Ages {
    hotend: StaleCheck,
    bed: StaleCheck,
    encoder: StaleCheck,
    printer: StaleCheck,
    command: StaleCheck,
    estimate: StaleCheck,
}

impl Ages {
    fn all_mut(&mut self) -> [&mut StaleCheck; 6] {
        [
            &mut self.hotend,
            &mut self.bed,
            &mut self.encoder,
            &mut self.printer,
            &mut self.command,
            &mut self.estimate,
        ]
    }
}

/// The checks beside ages and commands.
#[derive(Debug, Clone)]
struct Checks {
    hotend_range: RangeCheck,
    bed_range: RangeCheck,
    frozen: FrozenCheck,
    detached: DetachedCheck,
    heater: HeaterCheck,
    filament: FilamentCheck,
    run_out: RunOutCheck,
    bad_values: Burst,
    attention: Attention,
}

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
    envelope: Envelope,
    hotend: Option<Celsius>,
    printer: Option<PrinterReport>,
    printer_failed: bool,
    paused_alone_since: Option<Seconds>,
    approved: Option<Trims>,
    allowed: Trims,
    ramp: Option<(Seconds, Trims)>,
    started: Option<Seconds>,
    last_tick: Option<Seconds>,
    last_stall: Option<Seconds>,
    decisions: Vec<Decision>,
}

impl Supervisor {
    /// A supervisor that has seen nothing. `session` is a random id of this run; `restored` is the latch that a
    /// former run left behind.
    #[must_use]
    pub fn new(params: Params, session: u64, restored: Option<Latch>) -> Self {
        let stale = &params.stale;
        Self {
            limits: params.limits,
            session,
            sequence: 0,
            modes: Modes::new(params.modes, params.start_mode.into(), restored),
            ages: Ages {
                hotend: StaleCheck::new(stale.hotend),
                bed: StaleCheck::new(stale.bed),
                encoder: StaleCheck::new(stale.encoder),
                printer: StaleCheck::new(stale.printer),
                command: StaleCheck::new(stale.command),
                estimate: StaleCheck::new(stale.estimate),
            },
            checks: Checks {
                hotend_range: RangeCheck::new(params.hotend_range),
                bed_range: RangeCheck::new(params.bed_range),
                frozen: FrozenCheck::new(params.frozen),
                detached: DetachedCheck::new(params.detached),
                heater: HeaterCheck::new(params.heater),
                filament: FilamentCheck::new(params.filament),
                run_out: RunOutCheck::new(params.run_out),
                bad_values: Burst::new(params.bad_values),
                attention: Attention::new(params.attention),
            },
            envelope: Envelope::new(params.envelope, params.limits),
            hotend: None,
            printer: None,
            printer_failed: false,
            paused_alone_since: None,
            approved: None,
            allowed: Trims::NEUTRAL,
            ramp: None,
            started: None,
            last_tick: None,
            last_stall: None,
            decisions: Vec::new(),
            params,
        }
    }

    /// Takes one event received at `now`. A tick yields the permit to publish; so does a person's request, at once.
    pub fn on_event(&mut self, now: Seconds, event: Event) -> Option<Output> {
        match event {
            Event::Tick { now } => return Some(self.on_tick(now)),
            Event::Operator(request) => {
                self.on_operator(now, request);
                return Some(self.output(now));
            }
            Event::Command(command) => self.on_command(now, command),
            Event::Refused { .. } => self.checks.bad_values.note(now),
            Event::Confidence { confidence } => self.on_confidence(now, confidence),
            Event::Hotend { stamp, temp } => self.on_hotend(now, stamp, temp),
            Event::Bed { temp, .. } => self.on_bed(now, temp),
            Event::Encoder { position_m, .. } => self.on_encoder(now, position_m),
            Event::Printer(report) => self.on_printer(now, report),
            Event::EstimateHeartbeat { .. } => self.ages.estimate.note(now),
        }
        None
    }

    /// The latched mode, to be kept across restarts.
    #[must_use]
    pub fn latch(&self) -> Option<Latch> {
        self.modes.latch()
    }

    /// Whether a stream has been heard of.
    #[must_use]
    pub fn is_seen(&self, stream: Stream) -> bool {
        match stream {
            Stream::Hotend => &self.ages.hotend,
            Stream::Bed => &self.ages.bed,
            Stream::Encoder => &self.ages.encoder,
            Stream::Printer => &self.ages.printer,
            Stream::Command => &self.ages.command,
            Stream::Estimate => &self.ages.estimate,
        }
        .is_seen()
    }

    fn on_command(&mut self, now: Seconds, command: models::command::Command) {
        let before = self.modes.mode();
        let (what, why) = match self.envelope.on_command(now, command) {
            Verdict::Taken => return self.ages.command.note(now),
            Verdict::Clamped => {
                self.ages.command.note(now);
                (What::CommandClamped, "outside of range or slew")
            }
            Verdict::Refused(refusal) => {
                if refusal == models::command::Refusal::NotFinite {
                    self.checks.bad_values.note(now);
                }
                (What::CommandRefused(refusal), "see the reason")
            }
        };
        self.decisions.push(Decision { what, why, before, after: before });
    }

    /// After a pause or a trip the filters start anew.
    fn forget(&mut self) {
        self.checks.heater.reset();
        self.checks.frozen.reset();
        self.checks.detached.reset();
        self.checks.filament.reset();
        self.checks.attention.reset();
    }

    fn on_tick(&mut self, now: Seconds) -> Output {
        self.started.get_or_insert(now);
        let dt_s = self.last_tick.map_or(0.0, |last| now.0 - last.0);
        if !(0.0..self.params.modes.stall_s).contains(&dt_s) {
            self.on_stall(now, Seconds(dt_s));
        }
        let before = self.modes.mode();
        self.initialise(now);
        let raised = self.raised(now);
        let job_runs = self.printer.is_some_and(|printer| {
            matches!(printer.phase, JobPhase::Preparing | JobPhase::Printing | JobPhase::Paused)
        });
        if self.modes.update(now, &raised, job_runs) {
            let after = self.modes.mode();
            let what = if before == after { What::CauseChanged } else { What::ModeChanged };
            let why = self.modes.cause().map_or("the cause is gone", Cause::text);
            self.decisions.push(Decision { what, why, before, after });
        }
        if self.modes.try_resume(now, self.readiness()) {
            self.forget();
            let after = self.modes.mode();
            self.decisions.push(Decision { what: What::ModeChanged, why: "resumed", before, after });
        }
        self.printer_failed = false;
        self.move_trims(now, Seconds(dt_s));
        self.last_tick = Some(now);
        self.output(now)
    }

    /// The tick came late: what was silent in the meantime was not heard, which says nothing of it.
    fn on_stall(&mut self, now: Seconds, gap: Seconds) {
        // Once in a while: whoever always comes late hears nothing in time, and has to say so.
        let often = self.last_stall.is_some_and(|last| (now - last).0 < self.params.modes.stall_forgiven_s);
        self.last_stall = Some(now);
        if !often {
            for age in self.ages.all_mut() {
                age.forgive(gap);
            }
            self.checks.frozen.reset();
            self.checks.detached.reset();
        }
        self.allowed = Trims::NEUTRAL;
        self.ramp = None;
        self.approved = None;
        self.started = self.started.map(|_| now);
        let mode = self.modes.mode();
        self.decisions.push(Decision {
            what: What::StoodStill,
            why: "the tick came late",
            before: mode,
            after: mode,
        });
    }

    fn initialise(&mut self, now: Seconds) {
        if self.modes.is_initialised() {
            return;
        }
        let waited_s = self.started.map_or(0.0, |started| now.0 - started.0);
        let complete = self.ages.hotend.is_seen() && self.ages.printer.is_seen();
        if complete || waited_s > self.params.modes.startup_s {
            self.ages.hotend.expect(now);
            self.ages.printer.expect(now);
            self.modes.initialise();
        }
    }

    fn output(&mut self, now: Seconds) -> Output {
        self.sequence += 1;
        let mode = self.modes.mode();
        let latched = mode >= Mode::SafeOff;
        if latched {
            self.allowed = Trims::NEUTRAL;
        }
        let cause = self.modes.cause();
        Output {
            permit: Permit {
                session: self.session,
                sequence: self.sequence,
                validity: Seconds(self.params.permit_validity_s),
                mode,
                request: self.modes.request(now),
                trims: self.allowed,
            },
            state: SafetyState {
                mode,
                set_mode: self.modes.set_mode(),
                cause,
                since: self.modes.since(),
                what_to_do: cause.map_or("", Cause::what_to_do),
                attention: self.checks.attention.level(),
                refused_values: self.checks.bad_values.total(),
                refused_commands: self.envelope.refused(),
                clamped_commands: self.envelope.clamped(),
                hotend_excess_w: self.checks.heater.excess_w(),
                slip: self.checks.filament.slip(),
            },
            events: std::mem::take(&mut self.decisions),
        }
    }
}
