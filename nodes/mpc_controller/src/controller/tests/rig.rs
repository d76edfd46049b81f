//! A controller in a loop with a printer that does as it is told.

use super::*;

pub(super) const FEED_M_S: f64 = 1.8e-3;
/// Steady nozzle at a block of 226 degC, full fan, 4.8 mm³/s (model book 1.3: 16.7 K at 210 degC).
pub(super) const NOZZLE_K: f64 = 482.5;

pub(super) fn status(stamp_s: f64, wanted_m: f64, trims: Trims) -> PrinterStatus {
    PrinterStatus {
        motor_position_m: FEED_M_S * stamp_s,
        wanted_position_m: wanted_m,
        target_width_m: Some(4.8e-4),
        hotend_target: Celsius(226.0),
        hotend_sliced_target: Celsius(226.0),
        trims,
        advance_s: 0.0,
        ..crate::advance::tests::status(stamp_s, FEED_M_S)
    }
}

pub(super) fn estimate(stamp_s: f64) -> Estimate {
    Estimate {
        stamp: Seconds(stamp_s),
        nozzle: Kelvin(NOZZLE_K),
        flow_m_s: FEED_M_S,
        slip: 0.01,
        gain: 1.0,
        reference_feed_m_s: FEED_M_S,
        encoder_alive: true,
        width_alive: true,
    }
}

/// A print at constant speed in steps of 50 ms; what is sent comes into force at once.
pub(super) struct Rig {
    pub(super) controller: Controller,
    pub(super) step: u32,
    pub(super) wanted_m: f64,
    pub(super) in_force: Trims,
    pub(super) duty: f64,
    /// What passes the encoder `[m/s]`; the estimated flow without it.
    pub(super) filament_m_s: Option<f64>,
    /// The host executes the laws that its moves were sent with.
    pub(super) executes: bool,
    delivered_m: f64,
}

impl Rig {
    pub(super) fn new(level: Level) -> Self {
        Self::of(controller(level))
    }

    pub(super) fn of(controller: Controller) -> Self {
        Self {
            controller,
            step: 0,
            wanted_m: 0.0,
            in_force: Trims::NEUTRAL,
            duty: 0.5,
            filament_m_s: None,
            executes: false,
            delivered_m: 0.0,
        }
    }

    pub(super) fn now_s(&self) -> f64 {
        f64::from(self.step) * 0.05
    }

    /// Runs so many steps and returns all commands' trims.
    pub(super) fn run(&mut self, steps: u32, shape: impl Fn(Estimate) -> Estimate) -> Vec<Trims> {
        let mut sent = Vec::new();
        for _ in 0..steps {
            self.step += 1;
            self.wanted_m += FEED_M_S * 0.05 * self.in_force.flow * self.in_force.speed;
            let now_s = self.now_s();
            let advance_s = self.in_force.advance_s.filter(|_| self.executes).unwrap_or(0.0);
            let status = PrinterStatus { advance_s, ..status(now_s, self.wanted_m, self.in_force) };
            self.controller.on_event(Event::Printer(PrinterStatus { hotend_duty: self.duty, ..status }));
            let estimate = shape(estimate(now_s));
            if estimate.encoder_alive {
                self.deliver(self.filament_m_s.unwrap_or(estimate.flow_m_s));
            }
            if let Some(command) = self.controller.on_event(Event::Estimate(estimate)) {
                self.in_force = command.trims;
                sent.push(command.trims);
            }
            if self.step.is_multiple_of(5) {
                self.controller.on_event(Event::Tick { now: Seconds(now_s) });
            }
        }
        sent
    }

    /// Two samples of the encoder in the step that ends now.
    fn deliver(&mut self, filament_m_s: f64) {
        for ago_s in [0.025, 0.0] {
            self.delivered_m += filament_m_s * 0.025;
            let stamp = Seconds(self.now_s() - ago_s);
            self.controller.on_event(Event::Encoder { stamp, position_m: self.delivered_m });
        }
    }
}
