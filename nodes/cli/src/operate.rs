//! What a person asks of the supervisor: `pause`, `resume`, `stop`, `estop`, `acknowledge`,
//! `approve`, `mode`.

use crate::output;
use crate::participant;
use crate::up::words::phase_name;
use anyhow::{Context, bail};
use clap::Args;
use fdm_loop_msgs::{PrinterState, RosService, SetModeRequest, Trigger, TriggerRequest, TriggerResponse};
use models::command::Request;
use models::units::Seconds;
use runtime::topics::{self, Service};
use runtime::{CallError, Patience};

pub(crate) mod stop;

/// Longest wait for a supervisor to be found `[s]`; discovery takes up to 0.5 s, on a busy machine longer.
const FOUND_S: f64 = 3.0;
/// Longest wait for its answer `[s]`; it promises 250 ms.
const ANSWERED_S: f64 = 6.0;
/// Wait until the request is sent again `[s]`, where it may be granted twice: beyond the promise, or a loaded machine has
/// each granted twice.
const AGAIN_S: f64 = 0.3;
/// The same where the second would be refused, for the first was granted.
const ONCE_S: f64 = 1.0;

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

    /// What the printer takes from everybody, so that it is not lost with the supervisor.
    fn of_everybody(self) -> Option<Request> {
        match self {
            Self::Stop => Some(Request::HeatersOff),
            Self::Estop => Some(Request::EmergencyStop),
            Self::Pause | Self::Resume | Self::Acknowledge | Self::Approve => None,
        }
    }

    /// Wait until it is asked again `[s]`.
    fn again_s(self) -> f64 {
        match self {
            Self::Pause | Self::Stop | Self::Estop => AGAIN_S,
            Self::Resume | Self::Acknowledge | Self::Approve => ONCE_S,
        }
    }
}

/// Asks the supervisor and waits for its answer; a stop goes to the printer itself where there is none.
///
/// # Errors
/// No supervisor, or one that refuses; a stop or a pause that the printer does not confirm; exit code 2.
pub fn ask(what: Ask, args: &AskArgs) -> anyhow::Result<()> {
    if let Some(request) = what.of_everybody() {
        return stop::ask(what, request, &args.namespace);
    }
    let name = what.service().name();
    let (answer, times, shown) = executor()?.block_on(request(what, &args.namespace))?;
    let hint = absent(&answer, &args.namespace);
    let answer = answer.with_context(|| not_confirmed(name, &hint))?;
    if !answer.success {
        bail!("the supervisor refused {name}: {}{}", answer.message, doubt(times));
    }
    output::line(&format!("{name}: {}", granted(&answer.message, shown)?))
}

/// Asks the supervisor; of a pause that it grants, what the printer shows is awaited as well: one that hangs, or a bridge that
/// only watches, prints on.
async fn request(
    what: Ask,
    namespace: &str,
) -> anyhow::Result<(Result<TriggerResponse, CallError>, usize, Option<Shown>)> {
    let mut node = participant::join("fdm", in_namespace(namespace))?;
    let mut states = node.subscribe(&topics::PRINTER_STATE)?;
    let client = node.client(what.service())?;
    let (answer, times) = client.insist(TriggerRequest::default(), patience(what.again_s())).await;
    let shown = match &answer {
        Ok(answer) if answer.success && what == Ask::Pause => {
            Some(stop::shows(&mut states, |state| !stop::moves(state)).await)
        }
        _ => None,
    };
    Ok((answer, times, shown))
}

/// What the printer shows of it; else what it says.
type Shown = Result<PrinterState, String>;

/// What is told of a request that the supervisor has granted.
///
/// # Errors
/// A printer that does not show it.
fn granted(answer: &str, shown: Option<Shown>) -> anyhow::Result<String> {
    // Beside a simulation at a tenth of real time it may be 7 s until a host that reports seldom shows it.
    const INSTEAD: &str = "where `fdm status` does not show it paused by now, pause it at the printer";
    match shown {
        None => Ok(answer.to_owned()),
        Some(Ok(state)) => Ok(format!("{answer}; the printer confirms: {}", phase_name(state.phase))),
        Some(Err(state)) => bail!("{}", stop::unconfirmed(answer, INSTEAD, &state)),
    }
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
    let (answer, times) =
        insist(&topics::SAFETY_SET_MODE, &SetModeRequest { mode }, &args.namespace, AGAIN_S)?;
    let hint = absent(&answer, &args.namespace);
    let answer = answer.with_context(|| not_confirmed(name, &hint))?;
    if !answer.accepted {
        bail!("the supervisor refused {name}: {}{}", answer.message, doubt(times));
    }
    output::line(&format!("{name}: {}", answer.message))
}

fn not_confirmed(name: &str, hint: &str) -> String {
    format!("{name} was not confirmed: `fdm status` shows what holds{hint}")
}

/// What to look at where no supervisor is there.
fn absent<T>(answer: &Result<T, CallError>, namespace: &str) -> String {
    match answer {
        Err(CallError::NoServer(_)) => format!(
            "; no supervisor of {namespace} is there: is `fdm up` running, with the same ROS_DOMAIN_ID and --namespace? One that hangs \
             is not heard either: `fdm estop` and `fdm stop` tell the printer itself"
        ),
        // What a server of another form answers is not understood.
        Err(_) => format!("; ask again; {}", other_rmw()),
        Ok(_) => String::new(),
    }
}

/// Forms of requests by RMW_IMPLEMENTATION; the first is what any other is taken for.
const FORMS: [&str; 2] = ["rmw_fastrtps_cpp", "rmw_cyclonedds_cpp"];

/// What to look at where somebody who is there does not answer: a request of another form than his he does not understand.
pub(crate) fn other_rmw() -> String {
    forms(std::env::var("RMW_IMPLEMENTATION").ok().as_deref())
}

fn forms(chosen: Option<&str>) -> String {
    let (own, other) = if chosen == Some(FORMS[1]) { (FORMS[1], FORMS[0]) } else { (FORMS[0], FORMS[1]) };
    format!(
        "the server is on the graph: it hangs, or was started with another RMW_IMPLEMENTATION than this shell, whose \
         requests have the form of {own}; then: export RMW_IMPLEMENTATION={other}"
    )
}

/// What a refusal of the second request leaves open.
fn doubt(times: usize) -> &'static str {
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
    again_s: f64,
) -> anyhow::Result<(Result<S::Response, CallError>, usize)> {
    executor()?.block_on(async {
        let mut node = participant::join("fdm", in_namespace(namespace))?;
        anyhow::Ok(node.client(service)?.insist(request.clone(), patience(again_s)).await)
    })
}

fn patience(again_s: f64) -> Patience {
    Patience { found: Seconds(FOUND_S), again: Seconds(again_s), answered: Seconds(ANSWERED_S) }
}

pub(crate) fn executor() -> anyhow::Result<tokio::runtime::Runtime> {
    Ok(tokio::runtime::Builder::new_current_thread().enable_all().build()?)
}

pub(crate) fn in_namespace(namespace: &str) -> runtime::Args {
    runtime::Args { namespace: Some(namespace.to_owned()), ..runtime::Args::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_asks_nobody_is_told_where_to_look() {
        let nobody: Result<(), CallError> = Err(CallError::NoServer("/left/safety/estop".to_owned()));
        let told = not_confirmed("safety/pause", &absent(&nobody, "/left"));
        assert!(
            told.contains(
                "no supervisor of /left is there: is `fdm up` running, with the same ROS_DOMAIN_ID"
            ),
            "{told}"
        );
        assert!(told.ends_with("`fdm estop` and `fdm stop` tell the printer itself"), "{told}");
        let silent: Result<(), CallError> = Err(CallError::TimedOut("/left/safety/estop".to_owned()));
        let told = absent(&silent, "/left");
        let service = "/left/safety/estop".to_owned();
        let garbled: Result<(), CallError> = Err(CallError::Failed { service, reason: "read".to_owned() });
        assert_eq!(absent(&garbled, "/left"), told);
        assert!(told.contains("export RMW_IMPLEMENTATION=rmw_"), "{told}");
        for (chosen, own, other) in [(Some(FORMS[1]), FORMS[1], FORMS[0]), (None, FORMS[0], FORMS[1])] {
            let told = forms(chosen);
            assert!(
                told.contains(&format!("the form of {own};")) && told.ends_with(&format!("={other}")),
                "{told}"
            );
        }
        assert_eq!(absent(&Ok(()), "/left"), "");
    }

    /// A pause is none before the printer shows it.
    #[test]
    fn a_pause_is_done_where_the_printer_shows_it() {
        let state = |phase| PrinterState { phase, ..PrinterState::default() };
        let phases = [0, 1, 2, 3, 4, 5].map(|phase| stop::moves(&state(phase)));
        assert_eq!(phases, [false, true, true, false, false, false], "idle to failed");
        let paused = granted("mode paused", Some(Ok(state(PrinterState::PHASE_PAUSED)))).unwrap();
        assert_eq!(paused, "mode paused; the printer confirms: paused");
        let says = "which says: printing, set to 215 and 60 degC, mains on".to_owned();
        let told = granted("mode paused", Some(Err(says))).unwrap_err().to_string();
        assert!(told.starts_with(
            "the supervisor took it (mode paused), but the printer does not confirm within 3 s"
        ));
        assert!(told.contains("pause it at the printer (the printer, which says: printing"), "{told}");
        assert_eq!(granted("mode act", None).unwrap(), "mode act");
    }

    /// A request that is refused the second time is not sent twice because the disk took its time.
    #[test]
    fn what_is_granted_once_is_asked_again_late() {
        for what in [Ask::Resume, Ask::Acknowledge, Ask::Approve] {
            assert!(what.again_s() > Ask::Estop.again_s());
        }
    }
}
