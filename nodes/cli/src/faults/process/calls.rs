//! Services: what a person asks for (P13), and a flood of calls (C11).

use super::aside::Aside;
use super::graph::Spinners;
use super::machine::{BARE, bare_timer};
use super::observer::Seen;
use super::outcome::Observed;
use super::session::Session;
use crate::participant;
use fdm_loop_msgs::{
    ControlCommand, DescribeParametersRequest, GetParametersRequest, ListParametersRequest, Parameter,
    PrinterState, RosService, SetModeRequest, SetParametersRequest, TriggerRequest,
};
use models::units::Seconds;
use runtime::{Args, Client, topics};
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Longest wait for an answer `[s]`.
const ANSWER_S: f64 = 2.0;
/// Longest wait for an acknowledgement that is granted, and for the permits that follow `[s]`.
const GRANTED_S: f64 = 5.0;
/// Callers of the flood.
const CALLERS: f64 = 8.0;
/// Spinning processes have the machine for so long before anything is measured `[s]`.
const WARM_S: f64 = 1.0;

/// Asks once for `safety/acknowledge`; whether it was granted.
pub(super) async fn acknowledge(session: &mut Session) -> anyhow::Result<bool> {
    let hand = Rc::clone(&session.hand);
    let call = hand.acknowledge.call(TriggerRequest::default(), Seconds(ANSWER_S));
    tokio::pin!(call);
    loop {
        tokio::select! {
            answer = &mut call => return Ok(answer.is_ok_and(|answer| answer.success)),
            seen = session.next() => { seen?; }
        }
    }
}

/// Whether, before so long, the job is given up and the heaters are off.
pub(super) async fn heaters_off(session: &mut Session, limit_s: f64) -> anyhow::Result<bool> {
    let off = |state: &PrinterState| {
        let heat = [state.hotend_target_degc, state.bed_target_degc, state.hotend_duty, state.bed_duty];
        state.phase == PrinterState::PHASE_FAILED && heat.iter().all(|heat| *heat <= 0.0)
    };
    session.until(limit_s, |_, seen| matches!(seen, Seen::Printer(state) if off(state))).await
}

/// P13: calls the emergency stop and acknowledges it by turns. The printer's relay opens with the first; of all the time
/// until the answer and until the permit that demands it is measured.
pub(super) async fn estops(session: &mut Session, calls: u32, spinning: u32) -> anyhow::Result<Observed> {
    let _spinners = Spinners::start(spinning)?;
    session.until(if spinning > 0 { WARM_S } else { 0.0 }, |_, _| false).await?;
    let (mut answers, mut permits) = (Vec::new(), Vec::new());
    let mut observed = Observed::default();
    let mut watcher = session.watcher();
    for number in 0..calls {
        let begin = session.observer.now();
        let hand = Rc::clone(&session.hand);
        let call = hand.estop.call(TriggerRequest::default(), Seconds(ANSWER_S));
        tokio::pin!(call);
        let (mut answered, mut permitted) = (None, None);
        while answered.is_none() || permitted.is_none() || watcher.mains_open.is_none() {
            tokio::select! {
                answer = &mut call, if answered.is_none() => {
                    answered = Some((session.observer.now() - begin).0);
                    if !answer.is_ok_and(|answer| answer.success) {
                        observed.wrong.push(format!("call {number} was not granted"));
                    }
                }
                seen = session.next() => {
                    let (at, seen) = seen?;
                    watcher.take(at, &seen);
                    if at > begin && is_permit(&seen, true) {
                        permitted.get_or_insert((at - begin).0);
                    }
                }
            }
            if (session.observer.now() - begin).0 > ANSWER_S {
                observed.wrong.push(format!("call {number}: answered {answered:?}, permit {permitted:?}"));
                break;
            }
        }
        answers.extend(answered);
        permits.extend(permitted);
        let granted = until_acknowledged(session).await?;
        if !granted {
            observed.wrong.push(format!("call {number}: not acknowledged within {GRANTED_S} s"));
            break;
        }
    }
    observed.reaction_s = watcher.mains_open;
    observed.measures.insert("answer", answers);
    observed.measures.insert("permit that stops", permits);
    Ok(observed)
}

/// One emergency stop; the reaction is the printer's open relay.
pub(super) async fn stop_once(session: &mut Session) -> anyhow::Result<Observed> {
    let mut watcher = session.watcher();
    let hand = Rc::clone(&session.hand);
    let call = hand.estop.call(TriggerRequest::default(), Seconds(ANSWER_S));
    tokio::pin!(call);
    let mut granted = None;
    while granted.is_none() || watcher.mains_open.is_none() {
        tokio::select! {
            answer = &mut call, if granted.is_none() => granted = Some(answer.is_ok_and(|answer| answer.success)),
            seen = session.next() => {
                let (at, seen) = seen?;
                watcher.take(at, &seen);
            }
        }
        if watcher.since(session.observer.now()) > ANSWER_S {
            break;
        }
    }
    let mut observed = Observed { reaction_s: watcher.mains_open, ..Observed::of(&watcher) };
    if granted != Some(true) {
        observed.wrong.push("the emergency stop was not granted".to_owned());
    }
    Ok(observed)
}

/// Acknowledges until it is granted and permits demand no stop any more.
async fn until_acknowledged(session: &mut Session) -> anyhow::Result<bool> {
    let end = session.observer.now() + Seconds(GRANTED_S);
    while !acknowledge(session).await? {
        if session.observer.now() > end {
            return Ok(false);
        }
    }
    session.until(GRANTED_S, |_, seen| is_permit(seen, false)).await
}

/// Whether this is a permit that demands an emergency stop, or one that does not.
fn is_permit(seen: &Seen, stops: bool) -> bool {
    matches!(seen, Seen::Permit(permit) if (permit.request == ControlCommand::REQUEST_EMERGENCY_STOP) == stops)
}

/// Calls of one caller.
#[derive(Debug, Default)]
struct Tally {
    /// Time until the answer `[s]`.
    answered: Vec<f64>,
    failed: u32,
}

/// C11: eight callers ask for parameters and of the supervisor what it cannot grant or grants without effect.
pub(super) async fn flood(session: &mut Session, rate_hz: f64, for_s: f64) -> anyhow::Result<Observed> {
    let (callers, bare) = (Aside::start(move |stop| call_all(rate_hz, stop)), bare_timer());
    let mut watcher = session.watcher();
    session.watch(&mut watcher, for_s).await?;
    callers.stop();
    bare.stop();
    while !callers.is_finished() {
        _ = session.next().await?;
    }
    let tally = callers.result()?;
    let mut observed = Observed::of(&watcher);
    #[allow(clippy::cast_precision_loss, reason = "thousands")]
    let answered_hz = tally.answered.len() as f64 / for_s;
    // Discovery takes its part of the time.
    if answered_hz < 0.8 * rate_hz {
        observed.wrong.push(format!("{answered_hz:.0} calls a second answered instead of {rate_hz}"));
    }
    observed.figures.insert("answered_hz", answered_hz);
    observed.figures.insert("not_answered", f64::from(tally.failed));
    observed.measures.insert("answer", tally.answered);
    observed.measures.insert("permit late", watcher.jitter.late());
    observed.measures.insert(BARE, bare.result()?);
    Ok(observed)
}

/// Runs the callers in a participant of their own.
fn call_all(rate_hz: f64, stop: &AtomicBool) -> anyhow::Result<Tally> {
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    executor.block_on(async {
        let args = Args { namespace: Some(super::NAMESPACE.to_owned()), ..Args::default() };
        let mut node = participant::join("caller", args)?;
        let period = Duration::from_secs_f64(CALLERS / rate_hz);
        let of = |name: &str| format!("{}/{name}", super::NAMESPACE);
        let get = node.client_of(&of("safety_supervisor"), &topics::GET_PARAMETERS)?;
        let describe = node.client_of(&of("safety_supervisor"), &topics::DESCRIBE_PARAMETERS)?;
        let list = node.client_of(&of("state_estimator"), &topics::LIST_PARAMETERS)?;
        let set = node.client_of(&of("mpc_controller"), &topics::SET_PARAMETERS)?;
        let acknowledge = node.client(&topics::SAFETY_ACKNOWLEDGE)?;
        let resume = node.client(&topics::SAFETY_RESUME)?;
        let approve = node.client(&topics::CONTROL_APPROVE)?;
        let mode = node.client(&topics::SAFETY_SET_MODE)?;
        let names = vec!["permit_validity_s".to_owned()];
        let nothing = Parameter { name: "no_such_parameter".to_owned(), ..Parameter::default() };
        let act = SetModeRequest { mode: SetModeRequest::MODE_ACT };
        let tallies = tokio::join!(
            keep_calling(&get, GetParametersRequest { names: names.clone() }, period, stop),
            keep_calling(&describe, DescribeParametersRequest { names }, period, stop),
            keep_calling(&list, ListParametersRequest::default(), period, stop),
            keep_calling(&set, SetParametersRequest { parameters: vec![nothing] }, period, stop),
            keep_calling(&acknowledge, TriggerRequest::default(), period, stop),
            keep_calling(&resume, TriggerRequest::default(), period, stop),
            keep_calling(&approve, TriggerRequest::default(), period, stop),
            keep_calling(&mode, act, period, stop),
        );
        let mut all = Tally::default();
        let (a, b, c, d, e, f, g, h) = tallies;
        for tally in [a, b, c, d, e, f, g, h] {
            all.answered.extend(tally.answered);
            all.failed += tally.failed;
        }
        Ok(all)
    })
}

/// Calls at a pace until it is told to stop.
async fn keep_calling<S>(
    client: &Client<S>,
    request: S::Request,
    period: Duration,
    stop: &AtomicBool,
) -> Tally
where
    S: RosService<Request: Clone>,
{
    let mut tally = Tally::default();
    let mut pace = tokio::time::interval(period);
    while !stop.load(Ordering::Relaxed) {
        _ = pace.tick().await;
        let begin = tokio::time::Instant::now();
        match client.call(request.clone(), Seconds(ANSWER_S)).await {
            Ok(_) => tally.answered.push(begin.elapsed().as_secs_f64()),
            Err(_) => tally.failed += 1,
        }
    }
    tally
}
