//! What a person asks of the supervisor: `pause`, `resume`, `stop`, `estop`, `acknowledge`, `mode`.

use crate::output;
use crate::participant;
use anyhow::{Context, bail};
use clap::Args;
use fdm_loop_msgs::{SetModeRequest, Trigger, TriggerRequest};
use models::units::Seconds;
use runtime::topics::{self, Service};

/// Longest wait for the supervisor's answer `[s]`; it promises 250 ms, discovery takes up to 0.5 s.
const CALL_S: f64 = 3.0;

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
}

impl Ask {
    fn service(self) -> &'static Service<Trigger> {
        match self {
            Self::Pause => &topics::SAFETY_PAUSE,
            Self::Resume => &topics::SAFETY_RESUME,
            Self::Stop => &topics::SAFETY_STOP,
            Self::Estop => &topics::SAFETY_ESTOP,
            Self::Acknowledge => &topics::SAFETY_ACKNOWLEDGE,
        }
    }
}

/// Asks the supervisor and waits for its answer.
///
/// # Errors
/// No supervisor, or one that refuses; exit code 2.
pub fn ask(what: Ask, args: &AskArgs) -> anyhow::Result<()> {
    let name = what.service().name();
    let answer = executor()?.block_on(async {
        let mut node = participant::join("fdm", in_namespace(&args.namespace))?;
        let client = node.client(what.service())?;
        anyhow::Ok(client.call(TriggerRequest::default(), Seconds(CALL_S)).await)
    })?;
    let unconfirmed = || match what {
        Ask::Estop | Ask::Stop => format!("{name} was not confirmed: use the printer's own switch"),
        _ => format!("{name} was not confirmed"),
    };
    let answer = answer.with_context(unconfirmed)?;
    if !answer.success {
        bail!("the supervisor refused {name}: {}", answer.message);
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
    let answer = executor()?.block_on(async {
        let mut node = participant::join("fdm", in_namespace(&args.namespace))?;
        let client = node.client(&topics::SAFETY_SET_MODE)?;
        anyhow::Ok(client.call(SetModeRequest { mode }, Seconds(CALL_S)).await)
    })?;
    let answer = answer.with_context(|| format!("{name} was not confirmed"))?;
    if !answer.accepted {
        bail!("the supervisor refused {name}: {}", answer.message);
    }
    output::line(&format!("{name}: {}", answer.message))
}

pub(crate) fn executor() -> anyhow::Result<tokio::runtime::Runtime> {
    Ok(tokio::runtime::Builder::new_current_thread().enable_all().build()?)
}

pub(crate) fn in_namespace(namespace: &str) -> runtime::Args {
    runtime::Args { namespace: Some(namespace.to_owned()), ..runtime::Args::default() }
}
