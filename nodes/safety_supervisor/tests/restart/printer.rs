//! The printer that the supervisor is told of.

use crate::PATIENCE;
use fdm_loop_msgs::{Header, PrinterState, Temperature};
use models::units::Seconds;
use runtime::{Node, Publisher, Timer, topics};
use std::pin::pin;

/// A cold printer that says that it prints: no heater is on, so that none is judged.
pub(crate) struct Printer {
    pub(crate) phase: u8,
    states: Publisher<PrinterState>,
    hotend: Publisher<Temperature>,
    ticks: Timer,
}

impl Printer {
    /// One that prints.
    pub(crate) fn at(node: &mut Node) -> Self {
        Self {
            phase: PrinterState::PHASE_PRINTING,
            states: node.publish_on(&topics::PRINTER_STATE).unwrap(),
            hotend: node.publish_on(&topics::HOTEND_TEMPERATURE).unwrap(),
            ticks: node.timer(Seconds(0.05)),
        }
    }

    /// Goes on until there is `what`.
    pub(crate) async fn during<V>(&mut self, what: &str, awaited: impl Future<Output = V>) -> V {
        let mut awaited = pin!(tokio::time::timeout(PATIENCE, awaited));
        loop {
            tokio::select! {
                value = &mut awaited => return value.unwrap_or_else(|_| panic!("no {what}")),
                now = self.ticks.next() => self.tell(now),
            }
        }
    }

    fn tell(&self, now: Seconds) {
        let header = Header::at(now.0);
        let temperature = Temperature { header: header.clone(), temperature: 25.0, ..Temperature::default() };
        self.hotend.send(temperature);
        self.states.send(PrinterState {
            header,
            phase: self.phase,
            flow_factor: 1.0,
            speed_factor: 1.0,
            homed: true,
            mains_on: true,
            ..PrinterState::default()
        });
    }
}
