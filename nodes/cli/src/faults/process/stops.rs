//! P13: what a person asks for. The mains relay opens once in the life of a printer.

use super::graph::Spinners;
use super::observer::Seen;
use super::off;
use super::outcome::Observed;
use super::session::Session;
use super::watcher::Watcher;
use fdm_loop_msgs::{ControlCommand, SafetyState, TriggerRequest};
use models::units::Seconds;
use std::collections::BTreeSet;
use std::rc::Rc;

/// Longest wait for an answer `[s]`.
const ANSWER_S: f64 = 2.0;
/// Longest wait for an acknowledgement that is granted, and for the permits that follow `[s]`.
const GRANTED_S: f64 = 5.0;
/// Spinning processes have the machine for so long before anything is measured `[s]`.
const WARM_S: f64 = 1.0;

/// One emergency stop.
struct Stop {
    /// What followed on it.
    watcher: Watcher,
    /// Time until the answer, and whether it was granted.
    answer: Option<(f64, bool)>,
    /// Time until the permit that demands it `[s]`.
    permit: Option<f64>,
}

impl Stop {
    /// Answered, and carried out by the printer.
    fn is_carried_out(&self) -> bool {
        self.answer.is_some() && self.watcher.mains_open.is_some()
    }

    /// And told by the supervisor, as mode and as permit.
    fn is_told(&self) -> bool {
        let told = self.watcher.mode == SafetyState::MODE_ESTOP && self.permit.is_some();
        told && self.is_carried_out()
    }

    fn text(&self) -> String {
        let (mode, open_s) = (self.watcher.mode, self.watcher.mains_open);
        format!("answer {:?}, permit {:?}, mode {mode}, relay open {open_s:?}", self.answer, self.permit)
    }
}

/// Calls the emergency stop and looks on until `done`, or for so long that it is a miss. `beside` sees the same.
async fn stop(
    session: &mut Session,
    mut beside: Option<&mut Watcher>,
    done: fn(&Stop) -> bool,
) -> anyhow::Result<Stop> {
    let mut stop = Stop { watcher: session.watcher(), answer: None, permit: None };
    let hand = Rc::clone(&session.hand);
    let call = hand.estop.call(TriggerRequest::default(), Seconds(ANSWER_S));
    tokio::pin!(call);
    while !done(&stop) && stop.watcher.since(session.observer.now()) <= ANSWER_S {
        tokio::select! {
            answer = &mut call, if stop.answer.is_none() => {
                let granted = answer.is_ok_and(|answer| answer.success);
                stop.answer = Some((stop.watcher.since(session.observer.now()), granted));
            }
            seen = session.next() => {
                let (at, seen) = seen?;
                stop.watcher.take(at, &seen);
                if let Some(beside) = &mut beside {
                    beside.take(at, &seen);
                }
                let at_s = stop.watcher.since(at);
                if at_s > 0.0 && is_permit(&seen, true) {
                    stop.permit.get_or_insert(at_s);
                }
            }
        }
    }
    Ok(stop)
}

/// P13: calls the emergency stop and acknowledges it by turns. The printer's relay opens with the first call, which is the
/// reaction; of all of them the time until the answer and until the permit is measured, each is told as mode and cause, and
/// the printer stays off all along.
pub(super) async fn estops(session: &mut Session, calls: u32, spinning: u32) -> anyhow::Result<Observed> {
    let _spinners = Spinners::start(spinning)?;
    session.until(if spinning > 0 { WARM_S } else { 0.0 }, |_, _| false).await?;
    let (mut answers, mut permits, mut wrong) = (Vec::new(), Vec::new(), Vec::new());
    let mut found_as = BTreeSet::new();
    let mut all = session.watcher();
    for number in 1..=calls {
        let mut one = stop(session, Some(&mut all), Stop::is_told).await?;
        answers.extend(one.answer.map(|(took_s, _)| took_s));
        permits.extend(one.permit);
        found_as.insert(Observed::of(&one.watcher).found_as);
        if !one.is_told() || one.answer.is_none_or(|(_, granted)| !granted) {
            wrong.push(format!("call {number}: {}", one.text()));
        }
        if number == calls {
            off::watch(session, &mut one.watcher).await?;
            wrong.extend(one.watcher.off.miss());
        }
        if !until_acknowledged(session, &mut all).await? {
            wrong.push(format!("call {number}: not acknowledged within {GRANTED_S} s"));
            break;
        }
    }
    if found_as.len() > 1 {
        wrong.push(format!("found as {found_as:?}"));
    }
    wrong.extend(all.off.heated());
    let mut observed = Observed { reaction_s: all.mains_open, wrong, ..Observed::of(&all) };
    observed.measures.insert("answer", answers);
    observed.measures.insert("permit that stops", permits);
    Ok(observed)
}

/// One emergency stop; the reaction is the printer's open relay, behind which it stays off.
pub(super) async fn stop_once(session: &mut Session) -> anyhow::Result<Observed> {
    let mut one = stop(session, None, Stop::is_carried_out).await?;
    off::watch(session, &mut one.watcher).await?;
    let mut observed = Observed { reaction_s: one.watcher.mains_open, ..Observed::of(&one.watcher) };
    if one.answer.is_none_or(|(_, granted)| !granted) {
        observed.wrong.push("the emergency stop was not granted".to_owned());
    }
    observed.wrong.extend(one.watcher.off.miss());
    Ok(observed)
}

/// Asks once for `safety/acknowledge`, and looks on meanwhile; whether it was granted.
pub(super) async fn acknowledge(session: &mut Session, watcher: &mut Watcher) -> anyhow::Result<bool> {
    let hand = Rc::clone(&session.hand);
    let call = hand.acknowledge.call(TriggerRequest::default(), Seconds(ANSWER_S));
    tokio::pin!(call);
    loop {
        tokio::select! {
            answer = &mut call => return Ok(answer.is_ok_and(|answer| answer.success)),
            seen = session.next() => {
                let (at, seen) = seen?;
                watcher.take(at, &seen);
            }
        }
    }
}

/// Acknowledges until it is granted and permits demand no stop any more.
async fn until_acknowledged(session: &mut Session, watcher: &mut Watcher) -> anyhow::Result<bool> {
    let end = session.observer.now() + Seconds(GRANTED_S);
    while !acknowledge(session, watcher).await? {
        if session.observer.now() > end {
            return Ok(false);
        }
    }
    session
        .until(GRANTED_S, |at, seen| {
            watcher.take(at, seen);
            is_permit(seen, false)
        })
        .await
}

/// Whether this is a permit that demands an emergency stop, or one that does not.
fn is_permit(seen: &Seen, stops: bool) -> bool {
    matches!(seen, Seen::Permit(permit) if (permit.request == ControlCommand::REQUEST_EMERGENCY_STOP) == stops)
}
