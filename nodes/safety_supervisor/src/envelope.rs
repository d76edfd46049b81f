//! K6, C8: commands of the controller: one publisher, rising sequence, age, range and slew; permits: one publisher.

use models::command::{Command, Gate, Limits, Refusal, Trims};
use models::units::Seconds;

use crate::cause::Cause;
use crate::checks::bad_values::Burst;
use crate::params::EnvelopeParams;

/// What became of a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Taken as it came.
    Taken,
    /// Taken, clamped.
    Clamped,
    /// Refused.
    Refused(Refusal),
}

/// Holds the command in force.
#[derive(Debug, Clone)]
pub struct Envelope {
    params: EnvelopeParams,
    limits: Limits,
    gate: Gate<Command>,
    previous: Option<(Seconds, Trims)>,
    outside: Burst,
    /// Newest command of a session that is not the bound one.
    stranger: Option<Seconds>,
    /// The same, once the bound session has spoken after it.
    rival: Option<Seconds>,
    /// Newest permit of somebody else.
    foreign_permit: Option<Seconds>,
    /// Newest sample of somebody else than a stream's owner.
    rival_sample: Option<Seconds>,
}

impl Envelope {
    /// No command yet.
    #[must_use]
    pub fn new(params: EnvelopeParams, limits: Limits) -> Self {
        Self {
            params,
            limits,
            gate: Gate::new(limits.validity_max()),
            previous: None,
            outside: Burst::new(params.outside),
            stranger: None,
            rival: None,
            foreign_permit: None,
            rival_sample: None,
        }
    }

    /// Takes a command received at `now`.
    pub fn on_command(&mut self, now: Seconds, command: Command) -> Verdict {
        let inside = self.limits.clamp(&command.trims);
        let trims = inside.map_or(command.trims, |clamped| clamped.trims);
        let bound = self.bound();
        // The gate sees the broken trims too, and refuses them.
        if let Err(refusal) = self.gate.offer(now, Command { trims, ..command }) {
            if refusal == Refusal::OtherSession {
                self.stranger = Some(now);
            }
            return Verdict::Refused(refusal);
        }
        // A controller that was started again finds its predecessor silent; a second one does not.
        match self.stranger {
            Some(_) if bound == Some(command.session) => self.rival = self.stranger,
            _ => self.stranger = None,
        }
        let fast = self.previous.is_some_and(|(then, before)| {
            let dt = Seconds((now.0 - then.0).max(self.params.period_s));
            self.limits.slew(&before, &trims, dt).changed.any()
        });
        self.previous = Some((now, trims));
        if fast || inside.is_ok_and(|clamped| clamped.changed.any()) {
            self.outside.note(now);
            return Verdict::Clamped;
        }
        Verdict::Taken
    }

    /// The clock was set back: times of before mean nothing any more.
    pub fn set_back(&mut self) {
        (self.previous, self.stranger, self.rival) = (None, None, None);
        (self.foreign_permit, self.rival_sample) = (None, None);
        self.outside.forget();
    }

    /// Corrections of the command in force, inside the range; `None` once it has lapsed.
    #[must_use]
    pub fn wished(&self, now: Seconds) -> Option<Trims> {
        self.gate.in_force(now).map(|command| command.trims)
    }

    /// Session of the newest command that was taken, in force or not.
    #[must_use]
    pub fn bound(&self) -> Option<u64> {
        self.gate.newest().map(|command| command.session)
    }

    /// Session of the command in force.
    #[must_use]
    pub fn session(&self, now: Seconds) -> Option<u64> {
        self.gate.in_force(now).map(|command| command.session)
    }

    /// Something else than a command of the same publisher was outside.
    pub fn note_outside(&mut self, now: Seconds) {
        self.outside.note(now);
    }

    /// Whether too many commands were outside within the span.
    #[must_use]
    pub fn is_outside(&self, now: Seconds) -> bool {
        self.outside.tripped(now)
    }

    /// Whether somebody was heard within the hold time who speaks beside a controller, a supervisor or a stream's owner.
    #[must_use]
    pub fn rivals(&self, now: Seconds) -> [(Cause, bool); 3] {
        let recent =
            |heard: Option<Seconds>| heard.is_some_and(|at| now.0 - at.0 <= self.params.rival_hold_s);
        [
            (Cause::SecondPublisher, recent(self.rival)),
            (Cause::SecondSupervisor, recent(self.foreign_permit)),
            (Cause::SecondSource, recent(self.rival_sample)),
        ]
    }

    /// Somebody else has sent a permit.
    pub fn note_foreign_permit(&mut self, now: Seconds) {
        self.foreign_permit = Some(now);
    }

    /// Somebody else than its owner has published a stream.
    pub fn note_rival_sample(&mut self, now: Seconds) {
        self.rival_sample = Some(now);
    }

    /// Refused commands so far.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.gate.refusals().total()
    }

    /// Clamped commands so far.
    #[must_use]
    pub fn clamped(&self) -> u64 {
        self.outside.total()
    }
}
