//! What a person asks of the supervisor: `pause`, `resume`, `stop`, `estop`, `acknowledge`,
//! `approve`, `mode`.

use crate::output;
use crate::participant;
use anyhow::{Context, bail};
use clap::Args;
use fdm_loop_msgs::{RosService, SetModeRequest, Trigger, TriggerRequest};
use models::units::Seconds;
use runtime::CallError;
use runtime::topics::{self, Service};
use std::time::Instant;

/// Longest wait for a supervisor to be found `[s]`; discovery takes up to 0.5 s, on a busy machine longer.
const FOUND_S: f64 = 3.0;
/// Longest wait for its answer `[s]`; it promises 250 ms.
const ANSWERED_S: f64 = 6.0;
/// Wait until the request is sent again `[s]`: one that comes before both ends are matched is lost.
const AGAIN_S: f64 = 1.0;

/// Which printer.
#[derive(Debug, Args)]
pub struct AskArgs {
    /// Namespace of the printer.
    #[arg(long, default_value = "/printer", value_parser = runtime::check_namespace)]
    namespace: String,
}

/// What a person asks of the supervisor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ask {
    /// Pause the job.
    Pause,
    /// End a pause.
    Resume,
    /// Heaters off, job given up.
    Stop,
    /// Emergency stop.
    Estop,
    /// End a latched mode whose cause is gone.
    Acknowledge,
    /// Let through what waits in advise.
    Approve,
}

impl Ask {
    fn service(self) -> &'static Service<Trigger> {
        match self {
            Self::Pause => &topics::SAFETY_PAUSE,
            Self::Resume => &topics::SAFETY_RESUME,
            Self::Stop => &topics::SAFETY_STOP,
            Self::Estop => &topics::SAFETY_ESTOP,
            Self::Acknowledge => &topics::SAFETY_ACKNOWLEDGE,
            Self::Approve => &topics::CONTROL_APPROVE,
        }
    }
}

/// Asks the supervisor and waits for its answer.
///
/// # Errors
/// No supervisor, or one that refuses; exit code 2.
pub fn ask(what: Ask, args: &AskArgs) -> anyhow::Result<()> {
    let name = what.service().name();
    let (answer, times) = insist(what.service(), &TriggerRequest::default(), &args.namespace)?;
    let unconfirmed = || match what {
        Ask::Estop | Ask::Stop => format!("{name} was not confirmed: use the printer's own switch"),
        _ => not_confirmed(name),
    };
    let answer = answer.with_context(unconfirmed)?;
    if !answer.success {
        bail!("the supervisor refused {name}: {}{}", answer.message, doubt(times));
    }
    output::line(&format!("{name}: {}", answer.message))
}

/// Which mode, of which printer.
#[derive(Debug, Args)]
pub struct ModeArgs {
    /// What the loop may do: watch, watch and propose, or correct.
    #[arg(value_enum)]
    mode: Wanted,
    /// Namespace of the printer.
    #[arg(long, default_value = "/printer", value_parser = runtime::check_namespace)]
    namespace: String,
}

/// Modes that a person may ask for.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Wanted {
    Observe,
    Advise,
    Act,
}

/// Asks the supervisor for another mode.
///
/// # Errors
/// No supervisor, or one that refuses; exit code 2.
pub fn set_mode(args: &ModeArgs) -> anyhow::Result<()> {
    let mode = match args.mode {
        Wanted::Observe => SetModeRequest::MODE_OBSERVE,
        Wanted::Advise => SetModeRequest::MODE_ADVISE,
        Wanted::Act => SetModeRequest::MODE_ACT,
    };
    let name = topics::SAFETY_SET_MODE.name();
    let (answer, times) = insist(&topics::SAFETY_SET_MODE, &SetModeRequest { mode }, &args.namespace)?;
    let answer = answer.with_context(|| not_confirmed(name))?;
    if !answer.accepted {
        bail!("the supervisor refused {name}: {}{}", answer.message, doubt(times));
    }
    output::line(&format!("{name}: {}", answer.message))
}

fn not_confirmed(name: &str) -> String {
    format!("{name} was not confirmed: `fdm status` shows what holds; ask again")
}

/// What a refusal of the second request leaves open.
fn doubt(times: u32) -> &'static str {
    if times > 1 {
        " (asked more than once, an earlier one may have been granted: `fdm status` shows what holds)"
    } else {
        ""
    }
}

/// Asks until there is an answer, within limits; and how often it was asked.
fn insist<S: RosService<Request: Clone>>(
    service: &'static Service<S>,
    request: &S::Request,
    namespace: &str,
) -> anyhow::Result<(Result<S::Response, CallError>, u32)> {
    executor()?.block_on(async {
        let mut node = participant::join("fdm", in_namespace(namespace))?;
        let client = node.client(service)?;
        let started = Instant::now();
        let mut times = 0;
        loop {
            let answer = client.call(request.clone(), Seconds(AGAIN_S)).await;
            let limit_s = match &answer {
                Err(CallError::NoServer(_)) => FOUND_S,
                Err(CallError::TimedOut(_)) => ANSWERED_S,
                _ => 0.0,
            };
            times += u32::from(!matches!(answer, Err(CallError::NoServer(_))));
            if started.elapsed().as_secs_f64() >= limit_s {
                return anyhow::Ok((answer, times));
            }
        }
    })
}

pub(crate) fn executor() -> anyhow::Result<tokio::runtime::Runtime> {
    Ok(tokio::runtime::Builder::new_current_thread().enable_all().build()?)
}

pub(crate) fn in_namespace(namespace: &str) -> runtime::Args {
    runtime::Args { namespace: Some(namespace.to_owned()), ..runtime::Args::default() }
}
