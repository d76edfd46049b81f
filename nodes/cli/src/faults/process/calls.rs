//! C11: a flood of calls of services.

use super::aside::Aside;
use super::machine::{BARE, bare_timer};
use super::outcome::Observed;
use super::session::Session;
use crate::participant;
use fdm_loop_msgs::{
    DescribeParametersRequest, GetParametersRequest, ListParametersRequest, Parameter, RosService,
    SetModeRequest, SetParametersRequest, TriggerRequest,
};
use models::units::Seconds;
use runtime::{Args, Client, topics};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Longest wait for an answer `[s]`.
const ANSWER_S: f64 = 2.0;
/// Callers of the flood.
const CALLERS: f64 = 8.0;

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
