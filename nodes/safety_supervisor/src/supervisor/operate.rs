//! What a person asks for, and which corrections the mode lets through.

use models::command::{Mode, Trims};
use models::status::JobPhase;
use models::units::Seconds;

use super::Supervisor;
use crate::attention::Level;
use crate::cause::{Cause, Reaction};
use crate::checks::frozen::FrozenCheck;
use crate::event::{Decision, Operator, Output, Stream, What};
use crate::modes::{Readiness, Refused};

impl Supervisor {
    pub(super) fn on_operator(&mut self, now: Seconds, request: Operator) {
        let (before, paused_for) = (self.modes.mode(), self.modes.paused_for());
        let set_before = self.modes.set_mode();
        let result = match request {
            Operator::Pause if self.has_ended() => Err("no job runs: nothing to pause".into()),
            Operator::Pause => self.demand(now, Cause::OperatorPause, Reaction::Pause),
            Operator::Stop => self.demand(now, Cause::OperatorStop, Reaction::SafeOff),
            Operator::Estop => self.demand(now, Cause::OperatorEstop, Reaction::Estop),
            Operator::SetMode(mode) => self.set_mode(mode),
            Operator::Resume => self.modes.resume(now, self.readiness()),
            Operator::Acknowledge => self.acknowledge(now),
            Operator::Approve => self.approve(now),
        };
        if request == Operator::Resume && paused_for.is_some() && self.modes.paused_for().is_none() {
            self.resumed(now, paused_for);
            self.takes_up = true;
        }
        let (what, (why, cause)) = match result {
            Ok(()) => (What::Granted(request), self.granted(request)),
            Err(Refused { why, cause }) => (What::Denied(request), (why, cause)),
        };
        let cause = cause.map(|cause| (cause, self.evidence_of(cause).or_else(|| self.evidence(now, cause))));
        // What changes is the set mode, whatever is in force.
        let (before, after) = match request {
            Operator::SetMode(_) => (set_before, self.modes.set_mode()),
            _ => (before, self.modes.mode()),
        };
        self.decisions.push(Decision { what, why, cause, before, after });
    }

    /// What a request that was carried out rests on, or what of it is still to come.
    fn granted(&self, request: Operator) -> (&'static str, Option<Cause>) {
        let (mode, cause) = (self.modes.mode(), self.modes.cause());
        let asked = match request {
            Operator::Pause => Some(Cause::OperatorPause),
            Operator::Stop => Some(Cause::OperatorStop),
            Operator::Estop => Some(Cause::OperatorEstop),
            _ => None,
        };
        match request {
            _ if asked.is_some_and(|asked| cause == Some(asked)) => {
                (asked.map_or(Decision::ON_REQUEST, Cause::text), asked)
            }
            _ if asked.is_some() => ("on request; what was in force before it still is", cause),
            Operator::SetMode(set) if mode == set => (Decision::ON_REQUEST, None),
            Operator::SetMode(_) if mode == Mode::Init => ("it holds as soon as the start is over", None),
            Operator::SetMode(_) => ("it holds as soon as what is in force is over", cause),
            Operator::Resume if self.modes.paused_for().is_some() => {
                ("until the printer is homed and hot again", None)
            }
            Operator::Acknowledge if self.modes.paused_for().is_some() => {
                ("the job waits: `fdm resume`, or `fdm stop`", None)
            }
            _ => (Decision::ON_REQUEST, None),
        }
    }

    /// Whether the job is over. Of a printer that is silent, or idle before its job, a pause holds what comes.
    fn has_ended(&self) -> bool {
        self.printer.is_some_and(|printer| matches!(printer.phase, JobPhase::Done | JobPhase::Failed))
    }

    fn demand(&mut self, now: Seconds, cause: Cause, reaction: Reaction) -> Result<(), Refused> {
        self.modes.demand(now, cause, reaction);
        Ok(())
    }

    fn acknowledge(&mut self, now: Seconds) -> Result<(), Refused> {
        if let Some(missing) = self.unknown(now) {
            return Err(missing.into());
        }
        let waits = self.printer.is_some_and(|printer| {
            matches!(printer.phase, JobPhase::Preparing | JobPhase::Printing | JobPhase::Paused)
        });
        self.modes.acknowledge(now, waits)?;
        self.checks.forget();
        Ok(())
    }

    /// What has not been heard but has to be before a cause counts as gone: a restored latch has no history, and whether a
    /// job waits the printer has to say.
    fn unknown(&self, now: Seconds) -> Option<&'static str> {
        let checks = &self.checks;
        let bed = self.modes.latch().is_some_and(|latch| latch.cause.is_of_bed());
        if self.modes.latch().is_none() {
            None
        } else if !self.modes.is_initialised() {
            Some("still starting, nothing has been judged yet: ask again in some seconds")
        } else if self.printer.is_none() || self.ages.printer.reaction(now).is_some() {
            Some("the printer's state is missing: check the link to the printer")
        } else if !(self.has_no_hotend() || checks.hotend_range.is_well()) {
            Some(
                "the hot end temperature is missing or outside of its range: check the thermistor and its node",
            )
        } else if bed && !checks.bed_range.is_well() {
            Some(
                "the bed temperature is missing or outside of its range: check the bed's thermistor and its node",
            )
        } else if !self.has_moved() {
            Some(
                "the reading has stood still since, and what it measures may be hot: check the thermistor; a good one that \
                 rests moves when it is warmed by hand, after a long time without power",
            )
        } else if !self.is_judged() {
            Some("the balance of the heater has just begun and shows no fault yet: ask again in some seconds")
        } else {
            None
        }
    }

    /// Whether what is latched for its heat would show if it were still there.
    fn is_judged(&self) -> bool {
        let latched = self.modes.latch().map(|latch| latch.cause).filter(|cause| cause.is_of_balance());
        latched.is_none_or(|cause| {
            let heater = if cause.is_of_bed() { &self.checks.bed_heater } else { &self.checks.heater };
            heater.is_judging()
        })
    }

    /// Whether a reading that is latched for standing still has moved since.
    fn has_moved(&self) -> bool {
        let moved =
            |frozen: &FrozenCheck| frozen.changed().is_some_and(|changed| changed > self.modes.since());
        match self.modes.latch().map(|latch| latch.cause) {
            Some(Cause::HotendFrozen) => moved(&self.checks.frozen),
            Some(Cause::BedFrozen) => moved(&self.checks.bed_frozen),
            _ => true,
        }
    }

    fn approve(&mut self, now: Seconds) -> Result<(), Refused> {
        if self.modes.mode() != Mode::Advise {
            let why = if self.modes.set_mode() == Mode::Advise {
                "advise is set, and not in force: what is in force has to be over first"
            } else {
                "not in advise: `fdm mode advise` first"
            };
            return Err(Refused { why, cause: self.modes.cause() });
        }
        self.approved = self.envelope.session(now).zip(self.envelope.wished(now));
        self.approved.map(|_| ()).ok_or("no correction waits: the controller wishes none".into())
    }

    /// None is required, none was ever heard of, and none was ever expected because the printer heated.
    fn has_no_hotend(&self) -> bool {
        !self.params.required.has(Stream::Hotend) && !self.ages.hotend.is_seen()
    }

    pub(super) fn readiness(&self) -> Readiness {
        let Some(printer) = self.printer else {
            return Readiness { homed: false, filament: false, hot: false };
        };
        let wanted_c = printer.hotend_sliced_target.0 - self.params.modes.hot_margin_k;
        Readiness {
            homed: printer.homed,
            filament: printer.filament_present != Some(false),
            hot: self.has_no_hotend() || self.hotend.is_some_and(|temp| temp.0 >= wanted_c),
        }
    }

    /// Corrections follow the mode: slewed towards what is wished, or ramped back to the slicer's values.
    pub(super) fn move_trims(&mut self, now: Seconds, dt: Seconds) {
        let session = self.envelope.session(now);
        let advises = self.modes.mode() == Mode::Advise;
        // It ends with the controller's silence: who speaks later, or in its place, has to be approved anew.
        self.approved = self.approved.filter(|(whose, _)| advises && session == Some(*whose));
        self.step = None;
        if let Some(target) = self.target(now) {
            self.ramp = None;
            self.returning_since.get_or_insert(now);
            self.step = Some((self.allowed, dt));
            self.allowed = self.limits.slew(&self.allowed, &target, dt).trims;
        } else {
            self.returning_since = None;
            let (start, from) = *self.ramp.get_or_insert((now, self.allowed));
            self.allowed = from.ramp_to_neutral(now - start, Seconds(self.params.modes.ramp_s));
        }
        self.open_blind_loop(now);
    }

    /// The extruder's loop is not left closed about an encoder that is silent: its motor would push for what is not told.
    fn open_blind_loop(&mut self, now: Seconds) {
        if self.ages.encoder.reaction(now).is_some() {
            self.allowed.slip = None;
        }
    }

    /// A command goes on at once where commands are carried out: the tick's step is taken again, once, towards what is
    /// wished now, so that corrections move no faster for it.
    pub(super) fn answer(&mut self, now: Seconds) -> Option<Output> {
        if self.modes.mode() != Mode::Act {
            return None;
        }
        let target = self.target(now)?;
        let (from, dt) = self.step.take()?;
        self.allowed = self.limits.slew(&from, &target, dt).trims;
        self.open_blind_loop(now);
        Some(Output { permit: self.permit(now), state: self.state(), events: Vec::new() })
    }

    /// Where the trims go to; `None` where they go back to the slicer's values.
    fn target(&self, now: Seconds) -> Option<Trims> {
        match self.modes.mode() {
            Mode::Act if self.is_held(now) => Some(self.allowed),
            Mode::Act => Some(self.envelope.wished(now).unwrap_or(Trims::NEUTRAL)),
            Mode::Advise => Some(self.approved.map_or(Trims::NEUTRAL, |(_, trims)| trims)),
            _ => None,
        }
    }

    /// Raised attention holds corrections. Those just taken back were nothing to hold: an open loop would stay open.
    pub(super) fn is_held(&self, now: Seconds) -> bool {
        let returned =
            self.returning_since.is_some_and(|since| (now - since).0 >= self.params.modes.return_s);
        self.checks.attention.level() == Level::Soft && returned
    }
}
