//! The service `inject_fault`: what was asked for is scheduled or refused, answered, logged and told on `events`.

use super::Shell;
use crate::convert;
use fdm_loop_msgs::{InjectFault, InjectFaultResponse};
use runtime::{Asked, Server};

impl Shell {
    pub(super) fn inject(&mut self, faults: Option<&Server<InjectFault>>, asked: &Asked<InjectFault>) {
        let Some(server) = faults else { return };
        let now = self.simulator.now();
        let answer = match convert::fault(now, &asked.request) {
            Ok(entry) => {
                self.simulator.inject(entry);
                self.diagnostics.add("faults_injected", 1);
                self.outlets.events.send(convert::injected(&self.name, self.now(), &entry));
                tracing::info!("injected: {entry}");
                InjectFaultResponse { accepted: true, message: entry.to_string() }
            }
            Err(error) => {
                tracing::warn!("a fault was not injected: {error}");
                InjectFaultResponse { accepted: false, message: error.to_string() }
            }
        };
        server.answer(asked, answer);
    }
}
