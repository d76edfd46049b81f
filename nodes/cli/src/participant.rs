//! The participant of a command that takes seconds: where it cannot go on, it says so and ends.

use crate::output::{self, Failed};
use runtime::{Args, Node, RuntimeError};
use std::sync::Once;

/// Exit code of a command whose participant hears nothing any more.
const DEAF: i32 = 1;

/// Joins the graph. A process that is stopped and continued loses its middleware: nothing that it would say after it
/// could be relied on.
///
/// # Errors
/// What keeps the participant from starting.
pub(crate) fn join(name: &str, args: Args) -> Result<Node, RuntimeError> {
    outlive_farewells();
    Node::start_or(name, args, || {
        let what =
            "was stopped and continued, or hears nothing through DDS any more: start the command again";
        output::complain(&Failed(what.to_owned()).into());
        runtime::write_last_lines();
        std::process::exit(DEAF);
    })
}

/// The thread of the middleware that may be the last to let a participant go: it then waits for its own end, and panics.
const DISCOVERY: &str = "RustDDS discovery thread";
/// How that panic begins.
const JOINS_ITSELF: &str = "failed to join thread";

/// Keeps this process alive where the middleware panics at a participant's end: by then all is said, and the command has
/// its own code to end with. (The thread stands still until then.)
fn outlive_farewells() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let told = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            let thread = std::thread::current();
            let said = panic.payload().downcast_ref::<String>();
            while is_farewell(thread.name(), said.map(String::as_str)) {
                std::thread::park();
            }
            told(panic);
        }));
    });
}

fn is_farewell(thread: Option<&str>, said: Option<&str>) -> bool {
    thread == Some(DISCOVERY) && said.is_some_and(|said| said.starts_with(JOINS_ITSELF))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    /// What the standard library says where a thread waits for its own end is known for it; any other panic is not.
    #[test]
    fn a_thread_that_waits_for_its_own_end_is_known_by_its_words() {
        let (handle, own) = std::sync::mpsc::channel::<std::thread::JoinHandle<()>>();
        let (tell, told) = std::sync::mpsc::channel();
        let work = move || {
            let own = own.recv().unwrap();
            let panic = catch_unwind(AssertUnwindSafe(|| own.join())).unwrap_err();
            tell.send(panic.downcast_ref::<String>().cloned()).unwrap();
        };
        handle.send(std::thread::spawn(work)).unwrap();
        let said = told.recv().unwrap();
        assert!(is_farewell(Some(DISCOVERY), said.as_deref()), "{said:?}");
        assert!(
            !is_farewell(Some("another"), said.as_deref()) && !is_farewell(Some(DISCOVERY), Some("another"))
        );
        assert!(!is_farewell(None, None));
    }
}
