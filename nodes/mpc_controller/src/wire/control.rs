//! The profile as a loop: heights and states in, a command per tick out.

use super::{Answer, HeightController, Measured, Params, Refusals, WireTrims};
use crate::input::{Refused as Counted, is_valid};
use models::command::{Command, Trims};
use models::params::{ParamError, in_range};
use models::status::{JobPhase, PrinterStatus};
use models::units::Seconds;
use models::wire::{Law, Limits};
use serde::Deserialize;

/// Which level this is: the other ones have parameters of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WireLevel {
    /// Feed and head speed from layer heights.
    Wire,
}

/// The loop. Built only from valid [`RawLoop`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawLoop")]
pub struct LoopParams(RawLoop);

impl std::ops::Deref for LoopParams {
    type Target = RawLoop;
    fn deref(&self) -> &RawLoop {
        &self.0
    }
}

/// `config/wire/mpc_controller.param.yaml` as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawLoop {
    /// Must be `wire`.
    pub control: WireLevel,
    /// Time between two commands `[s]`.
    pub period_s: f64,
    /// Validity of a command `[s]`.
    pub validity_s: f64,
    /// An older state of the machine is not acted on `[s]`.
    pub status_age_limit_s: f64,
    /// A height that arrives later is refused `[s]`.
    pub height_age_limit_s: f64,
}

impl TryFrom<RawLoop> for LoopParams {
    type Error = ParamError;

    fn try_from(raw: RawLoop) -> Result<Self, ParamError> {
        in_range("period_s", raw.period_s, "s", (0.05, 1.0))?;
        // A command counts until the next one comes.
        in_range("validity_s", raw.validity_s, "s", (raw.period_s.max(0.1), 5.0))?;
        in_range("status_age_limit_s", raw.status_age_limit_s, "s", (0.05, 2.0))?;
        in_range("height_age_limit_s", raw.height_age_limit_s, "s", (0.1, 60.0))?;
        Ok(Self(raw))
    }
}

/// What the loop reacts to.
#[derive(Debug, Clone, PartialEq)]
pub enum WireEvent {
    /// A measured height.
    Height(Measured),
    /// State of the machine.
    Printer(Box<PrinterStatus>),
    /// The period has passed.
    Tick {
        /// The node's time.
        now: Seconds,
    },
}

/// What was done and seen, for diagnostics.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WireReport {
    /// Ticks with a correction.
    pub corrected: u64,
    /// Of these, corrections that a limit has cut.
    pub limited: u64,
    /// Ticks while drops are laid with nothing measured below, or too long ago.
    pub unmeasured: u64,
    /// Ticks without a command, since the state was too old.
    pub starved: u64,
    /// Heights that were refused.
    pub heights: Refusals,
    /// States that were refused.
    pub printer: Counted,
    /// Flow of the last command `[-]`.
    pub flow: f64,
}

/// The loop's brain. Knows no clock and no middleware.
#[derive(Debug, Clone)]
pub struct WireControl {
    params: LoopParams,
    law: Law,
    controller: HeightController,
    session: u64,
    sequence: u64,
    status: Option<PrinterStatus>,
    report: WireReport,
}

impl WireControl {
    /// A loop that has seen nothing. `session` tells this run's commands from another's.
    ///
    /// # Errors
    /// [`ParamError::OutOfRange`] for a gain outside (0, 2).
    pub fn new(
        params: LoopParams,
        profile: Params,
        (law, limits): (Law, Limits),
        session: u64,
    ) -> Result<Self, ParamError> {
        Ok(Self {
            controller: HeightController::new(profile, law, limits)?,
            params,
            law,
            session,
            sequence: 0,
            status: None,
            report: WireReport::default(),
        })
    }

    /// What was done and seen so far.
    #[must_use]
    pub fn report(&self) -> WireReport {
        WireReport { heights: self.controller.refusals(), ..self.report }
    }

    /// Takes one event in; a tick yields a command while the machine is heard.
    pub fn on_event(&mut self, event: WireEvent) -> Option<Command> {
        match event {
            // A refused height is counted in the controller.
            WireEvent::Height(measured) => _ = self.controller.on_height(measured),
            WireEvent::Printer(status) => self.take_status(*status),
            WireEvent::Tick { now } => return self.tick(now),
        }
        None
    }

    fn take_status(&mut self, status: PrinterStatus) {
        if !(is_valid(&status) && status.position_m.iter().all(|place_m| place_m.is_finite())) {
            self.report.printer.invalid += 1;
        } else if self.status.is_some_and(|before| status.stamp <= before.stamp) {
            self.report.printer.late += 1;
        } else {
            self.status = Some(status);
        }
    }

    fn tick(&mut self, now: Seconds) -> Option<Command> {
        let limit_s = self.params.status_age_limit_s;
        let Some(status) = self.status.filter(|status| (now - status.stamp).0 <= limit_s) else {
            self.report.starved += 1;
            return None;
        };
        let trims = self.trims(now, &status);
        self.report.flow = trims.flow;
        self.sequence += 1;
        Some(Command {
            session: self.session,
            sequence: self.sequence,
            validity: Seconds(self.params.validity_s),
            trims,
        })
    }

    fn trims(&mut self, now: Seconds, status: &PrinterStatus) -> Trims {
        let laying = status.phase == JobPhase::Printing && status.depositing;
        // Layers count from 0 in a state, from 1 here.
        let Some(layer) = status.layer.filter(|_| laying).and_then(|layer| layer.checked_add(1)) else {
            return Trims::NEUTRAL;
        };
        let answer = self.controller.answer(now, layer, status.position_m[0]);
        match answer {
            Answer::Correct(WireTrims { limited, .. }) => {
                self.report.corrected += 1;
                self.report.limited += u64::from(limited);
            }
            Answer::Unmeasured | Answer::Stale => self.report.unmeasured += 1,
        }
        let trims = answer.trims().trims();
        // A quotient's rounding must not leave the range of sections that the supervisor lets through.
        Trims { flow: trims.flow.clamp(self.law.ratio_low, self.law.ratio_high), ..trims }
    }
}

#[cfg(test)]
mod tests;
