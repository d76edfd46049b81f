//! What the network may cost a process: so much memory, and then its life, which is given back to it.
//!
//! RustDDS 0.15.1 makes room for what a fragment says its sample is, 4 GiB at a time, without asking who sent it (X1).
//! So each node bounds its own data. An allocation beyond that fails, which ends the process at once, and who started
//! it starts it again. Such an end, and that of a node that hears nothing any more, is none of its own making: it
//! leaves with [`DRIVEN_OUT`], a panic leaves as it always did.

use crate::args::ArgsError;
use crate::error::RuntimeError;
use crate::logging;
use rustix::process::{Resource, Rlimit, Signal, setrlimit};
use std::sync::Arc;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// Name of the environment variable with the memory that a node may use for its data `[MiB]`, 64 at least.
pub const MEMORY_LIMIT: &str = "FDM_MEMORY_MIB";
/// What a node may use where nothing is said `[MiB]`: those that hold pictures use 75, the others 25 to 45.
const MEMORY_MIB: u64 = 256;
/// No node starts with less `[MiB]`.
const MEMORY_MIN_MIB: u64 = 64;

/// Exit code of a process that the network has driven out: its memory was used up, or it had gone deaf. "Temporary
/// failure" of `sysexits.h`: it is to be started again, however often that happens.
pub const DRIVEN_OUT: u8 = 75;

/// Set in the environment of a process that is started again when it ends. Who is not stays where it is too crowded.
pub const STARTED_AGAIN: &str = "FDM_STARTED_AGAIN";

/// Whether this process has left a domain with too many participants.
static LEFT: AtomicBool = AtomicBool::new(false);

/// Whether this process leaves now: once, and if it comes back.
pub(crate) fn leave_the_crowd() -> bool {
    std::env::var_os(STARTED_AGAIN).is_some() && !LEFT.swap(true, Ordering::SeqCst)
}

/// Whether an orderly end was that of a process which left the crowd.
pub(crate) fn left_the_crowd() -> bool {
    LEFT.load(Ordering::SeqCst)
}

/// Whether an abort would be the network's doing. An allocation that is refused aborts without a word; a panic says so
/// first.
static NOT_OURS: LazyLock<Arc<AtomicBool>> = LazyLock::new(|| Arc::new(AtomicBool::new(true)));

/// Bounds the data of this process, and tells its own crashes from ends that come from outside.
///
/// # Errors
/// [`ArgsError::Environment`] for a value that cannot be used.
pub(crate) fn set() -> Result<(), RuntimeError> {
    let bytes = memory_mib(std::env::var(MEMORY_LIMIT).ok())? << 20;
    let system = |what| move |source: std::io::Error| RuntimeError::System { what, source };
    // Not the address space: threads reserve far more of it than they use.
    setrlimit(Resource::Data, Rlimit { current: Some(bytes), maximum: Some(bytes) })
        .map_err(|error| system("cannot bound the memory")(error.into()))?;
    let aborts = Signal::ABORT.as_raw();
    signal_hook::flag::register_conditional_shutdown(aborts, DRIVEN_OUT.into(), Arc::clone(&NOT_OURS))
        .map_err(system("cannot tell an abort"))?;
    let told = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        NOT_OURS.store(false, Ordering::SeqCst);
        told(panic);
        let said = panic.payload().downcast_ref::<String>();
        if is_middleware(std::thread::current().name(), said.map(String::as_str)) {
            end_deaf();
        }
    }));
    Ok(())
}

/// Whether a thread of RustDDS 0.15.1 has panicked: overflow checks end its event loop by an acknowledgement of the last
/// number there is (X1), and what is left of the process would be deaf until the self loop notices. Not a participant's end,
/// which its discovery thread may wait for in vain.
fn is_middleware(thread: Option<&str>, said: Option<&str>) -> bool {
    thread.is_some_and(|name| name.starts_with("RustDDS"))
        && !said.is_some_and(|said| said.starts_with("failed to join thread"))
}

/// Ends a process that hears nothing any more. Nothing is tidied up: what would do that may be what hangs.
pub(crate) fn end_deaf() -> ! {
    logging::write_last_lines();
    NOT_OURS.store(true, Ordering::SeqCst);
    std::process::abort()
}

fn memory_mib(told: Option<String>) -> Result<u64, ArgsError> {
    let Some(value) = told.filter(|value| !value.is_empty()) else { return Ok(MEMORY_MIB) };
    match value.parse() {
        Ok(mib) if (MEMORY_MIN_MIB..=1 << 20).contains(&mib) => Ok(mib),
        _ => {
            Err(ArgsError::Environment { name: MEMORY_LIMIT, value, rule: "a whole number in [64, 1048576]" })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_of_the_middleware_is_told_from_others_and_from_its_farewell() {
        let event_loop = Some("RustDDS Participant 12 event loop");
        assert!(is_middleware(event_loop, Some("attempt to add with overflow")));
        assert!(is_middleware(event_loop, None), "a text that was known when it was compiled");
        assert!(!is_middleware(
            Some("RustDDS discovery thread"),
            Some("failed to join thread: Resource deadlock avoided")
        ));
        assert!(!is_middleware(Some("thermistor"), None) && !is_middleware(None, None));
    }

    #[test]
    fn a_limit_is_a_number_of_mebibytes_that_a_node_can_live_in() {
        let told = |text: &str| memory_mib(Some(text.to_owned()));
        assert_eq!(memory_mib(None).unwrap(), MEMORY_MIB);
        assert_eq!(told("").unwrap(), MEMORY_MIB);
        assert_eq!(told("64").unwrap(), 64);
        for wrong in ["63", "-1", "1e3", "256M", "1048577"] {
            assert!(told(wrong).is_err(), "{wrong}");
        }
    }
}
