//! A stop reaches the printer whether there is a supervisor or not: heaters off and an emergency stop are taken from every
//! participant. What counts is the printer's own state: a bridge that only watches hears the demand and sends nothing.

use super::{Ask, absent, executor, in_namespace};
use crate::{output, participant};
use anyhow::bail;
use fdm_loop_msgs::{ControlCommand, Header, PrintEvent, PrinterState, TriggerRequest, TriggerResponse};
use models::command::{Mode, Permit, Request, Trims};
use models::status::JobPhase;
use models::units::Seconds;
use runtime::{CallError, Clock, Node, Patience, Publisher, RuntimeError, Subscription, topics, wire};
use std::pin::pin;
use std::time::Duration;
use tokio::time::{Instant, interval, sleep, timeout_at};

/// Until the printer is told as well: who is there has been discovered in 0.5 s and promises an answer within 250 ms.
const AT_ONCE: Patience = Patience { found: Seconds(0.7), again: Seconds(0.3), answered: Seconds(1.0) };
/// The supervisor is asked beside that: on a busy machine it takes longer to be found, and to answer.
const BESIDE: Patience = Patience { found: Seconds(3.0), again: Seconds(0.3), answered: Seconds(5.0) };
/// The printer is told until it confirms, or has so long to confirm what the supervisor tells it: a permit that the network
/// loses is followed by others, and a printer on a serial line is heard once a second.
const TELL: Duration = Duration::from_secs(3);
/// Between two of them: the supervisor's own period.
const EVERY: Duration = Duration::from_millis(20);
/// How long each one counts `[s]`, no longer than any printer takes.
const VALIDITY: Seconds = Seconds(0.25);

/// A message leaves in this time, and is repeated where it was lost: its writer ends with the command.
const LEAVES: Duration = Duration::from_millis(150);

/// Who says on `events` that a print was stopped past the supervisor, and how it is called.
const WHO: &str = "fdm";
const WHAT: &str = "stopped_past_the_supervisor";

/// What was confirmed, and by whom.
enum Outcome {
    /// By the supervisor; and whether the printer did as well, else what it says.
    Answered(TriggerResponse, Result<(), String>),
    Printer,
    /// By nobody: why the supervisor did not, and what the printer says.
    Nobody(CallError, String),
}

/// Asks the supervisor; where it does not answer at once, tells the printer itself. In either case the printer's state has
/// to show it.
///
/// # Errors
/// A supervisor that refuses; a printer that does not confirm.
pub(super) fn ask(what: Ask, request: Request, namespace: &str) -> anyhow::Result<()> {
    let name = what.service().name();
    let outcome = executor()?.block_on(async {
        let mut node = participant::join("fdm", in_namespace(namespace))?;
        let supervisor = node.client(what.service())?;
        let mut printer = Printer::open(&mut node, request)?;
        let (answer, _) = supervisor.insist(TriggerRequest::default(), AT_ONCE).await;
        if let Ok(answer) = answer {
            return anyhow::Ok(printer.after(answer).await);
        }
        output::note("the supervisor does not answer: the printer is told itself");
        let answer = {
            let mut told = pin!(printer.tell());
            let mut asked = pin!(supervisor.insist(TriggerRequest::default(), BESIDE));
            tokio::select! {
                told = &mut told => match told {
                    Ok(()) => return Ok(Outcome::Printer),
                    Err(state) => asked.await.0.map_err(|error| (error, state)),
                },
                (answer, _) = &mut asked => match answer {
                    Ok(answer) => Ok(answer),
                    Err(error) => match told.await {
                        Ok(()) => return Ok(Outcome::Printer),
                        Err(state) => Err((error, state)),
                    },
                },
            }
        };
        Ok(match answer {
            Ok(answer) => printer.after(answer).await,
            Err((error, state)) => Outcome::Nobody(error, state),
        })
    })?;
    match outcome {
        Outcome::Answered(answer, _) if !answer.success => {
            bail!("the supervisor refused {name}: {}", answer.message)
        }
        Outcome::Answered(answer, Ok(())) => {
            output::line(&format!("{name}: {}; the printer confirms: {}", answer.message, confirmed(request)))
        }
        Outcome::Answered(answer, Err(state)) => {
            bail!("{name}: {}", unconfirmed(&answer.message, "use the printer's own switch", &state))
        }
        Outcome::Printer => output::line(&format!(
            "{name}: the supervisor does not answer: told the printer itself, which confirms: {}",
            confirmed(request)
        )),
        Outcome::Nobody(error, state) => {
            let hint = absent(&Err::<(), _>(error), namespace);
            bail!(
                "{name} was not confirmed: use the printer's own switch (told the printer itself, {state}){hint}"
            )
        }
    }
}

/// What the printer's state shows then.
fn confirmed(request: Request) -> &'static str {
    if request == Request::EmergencyStop {
        "heaters off, mains relay open, job given up"
    } else {
        "heaters off, job given up"
    }
}

/// The printer, as who commands it in the supervisor's place.
struct Printer {
    states: Subscription<PrinterState>,
    permits: Publisher<ControlCommand>,
    events: Publisher<PrintEvent>,
    clock: Clock,
    session: u64,
    request: Request,
}

impl Printer {
    fn open(node: &mut Node, request: Request) -> Result<Self, RuntimeError> {
        Ok(Self {
            states: node.subscribe(&topics::PRINTER_STATE)?,
            permits: node.publish_on(&topics::SAFETY_COMMAND)?,
            events: node.publish_on(&topics::EVENTS)?,
            clock: node.clock(),
            session: node.session(),
            request,
        })
    }

    /// Demands it until the printer's state shows it; else what the printer says.
    async fn tell(&mut self) -> Result<(), String> {
        let begin = Instant::now();
        let mut ticks = interval(EVERY);
        let mut newest = self.states.drain_newest();
        for sequence in 1.. {
            ticks.tick().await;
            if let Some(state) = self.states.drain_newest() {
                // Of what was demanded before it: the first one comes after a demand.
                if sequence > 1 && is_safe(&state.message, self.request) {
                    // Once more: who was not matched yet has not heard the first one.
                    let now = state.message.header.stamp.seconds();
                    self.events.send(told(now.map_or_else(|| self.clock.now(), Seconds), self.request));
                    sleep(LEAVES).await;
                    return Ok(());
                }
                newest = Some(state);
            }
            if begin.elapsed() > TELL {
                break;
            }
            // Stamped by the printer's clock, which is simulated or the host's: it refuses what is old by it.
            let stamp = newest.as_ref().and_then(|state| state.message.header.stamp.seconds());
            let now = stamp.map_or_else(|| self.clock.now(), Seconds);
            if sequence == 1 {
                self.events.send(told(now, self.request));
            }
            self.permits.send(wire::permit_to_wire(now, &self.permit(sequence)));
        }
        Err(heard(newest.as_ref().map(|state| &state.message)))
    }

    /// What the supervisor has answered, and whether the printer's state shows it, from now on.
    async fn after(&mut self, answer: TriggerResponse) -> Outcome {
        if !answer.success {
            return Outcome::Answered(answer, Ok(()));
        }
        let shown = shows(&mut self.states, |state| is_safe(state, self.request)).await;
        Outcome::Answered(answer, shown.map(|_| ()))
    }

    fn permit(&self, sequence: u64) -> Permit {
        let mode = if self.request == Request::EmergencyStop { Mode::Estop } else { Mode::SafeOff };
        let (session, request) = (self.session, self.request);
        Permit { session, sequence, validity: VALIDITY, mode, request, trims: Trims::NEUTRAL }
    }
}

/// Waits until the printer's state shows what the supervisor demands of it; else what the printer says.
pub(super) async fn shows(
    states: &mut Subscription<PrinterState>,
    holds: impl Fn(&PrinterState) -> bool,
) -> Result<PrinterState, String> {
    let end = Instant::now() + TELL;
    let mut newest = None;
    _ = states.drain_newest();
    while let Ok(state) = timeout_at(end, states.recv()).await {
        if holds(&state.message) {
            return Ok(state.message);
        }
        newest = Some(state.message);
    }
    Err(heard(newest.as_ref()))
}

/// What is said where the supervisor took it, and the printer shows nothing of it.
pub(super) fn unconfirmed(taken: &str, instead: &str, state: &str) -> String {
    let limit_s = TELL.as_secs_f64();
    format!(
        "the supervisor took it ({taken}), but the printer does not confirm within {limit_s:.0} s: {instead} (the printer, {state})"
    )
}

/// Whether the printer works at a job or is about to.
pub(super) fn moves(state: &PrinterState) -> bool {
    [JobPhase::Preparing, JobPhase::Printing].iter().any(|phase| *phase as u8 == state.phase)
}

/// Whether an event says that a person has stopped the print past a supervisor that does not answer.
pub(crate) fn is_past_the_supervisor(event: &PrintEvent) -> bool {
    event.who == WHO && event.what == WHAT
}

/// Whether that was an emergency stop.
pub(crate) fn is_emergency(event: &PrintEvent) -> bool {
    event.after == confirmed(Request::EmergencyStop)
}

/// What the record keeps of it: no supervisor is there to say why the print ended.
pub(crate) fn told(now: Seconds, request: Request) -> PrintEvent {
    let stop = if request == Request::EmergencyStop {
        "emergency stop by a person"
    } else {
        "a person stops the print"
    };
    PrintEvent {
        header: Header::at(now.0),
        severity: PrintEvent::SEVERITY_ERROR,
        who: WHO.to_owned(),
        what: WHAT.to_owned(),
        why: format!("P13: {stop}; the supervisor does not answer, the printer is told itself"),
        before: String::new(),
        after: confirmed(request).to_owned(),
    }
}

/// Whether the printer's state confirms what was demanded.
fn is_safe(state: &PrinterState, request: Request) -> bool {
    let works = moves(state) || state.phase == JobPhase::Paused as u8;
    let cold = state.hotend_target_degc <= 0.0 && state.bed_target_degc <= 0.0;
    let unpowered = !state.mains_on || (state.hotend_duty <= 0.0 && state.bed_duty <= 0.0);
    let relay = request != Request::EmergencyStop || !state.mains_on;
    !works && cold && unpowered && relay
}

/// What the printer says last, for people.
fn heard(newest: Option<&PrinterState>) -> String {
    newest.map_or_else(|| "of which nothing is heard".to_owned(), says)
}

/// What speaks against it, for people.
fn says(state: &PrinterState) -> String {
    format!(
        "which says: {}, set to {:.0} and {:.0} degC, mains {}",
        crate::up::words::phase_name(state.phase),
        state.hotend_target_degc,
        state.bed_target_degc,
        if state.mains_on { "on" } else { "off" }
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each of them missing is no confirmation.
    #[test]
    fn a_printer_confirms_by_all_that_it_shows() {
        let off =
            PrinterState { phase: PrinterState::PHASE_FAILED, mains_on: false, ..PrinterState::default() };
        for request in [Request::HeatersOff, Request::EmergencyStop] {
            assert!(is_safe(&off, request), "{request:?}");
            for hot in [
                PrinterState { phase: PrinterState::PHASE_PRINTING, ..off.clone() },
                PrinterState { phase: PrinterState::PHASE_PAUSED, ..off.clone() },
                PrinterState { hotend_target_degc: 215.0, ..off.clone() },
                PrinterState { bed_target_degc: 60.0, ..off.clone() },
                PrinterState { mains_on: true, bed_duty: 0.3, ..off.clone() },
            ] {
                assert!(!is_safe(&hot, request), "{request:?}: {hot:?}");
            }
        }
        let fed = PrinterState { mains_on: true, ..off };
        assert!(is_safe(&fed, Request::HeatersOff) && !is_safe(&fed, Request::EmergencyStop));
    }
}
