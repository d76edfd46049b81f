//! The participant of a command that takes seconds: where it cannot go on, it says so and ends.

use crate::output::{self, Failed};
use runtime::{Args, Node, RuntimeError};

/// Exit code of a command whose participant hears nothing any more.
const DEAF: i32 = 1;

/// Joins the graph. A process that is stopped and continued loses its middleware: nothing that it would say after it
/// could be relied on.
///
/// # Errors
/// What keeps the participant from starting.
pub(crate) fn join(name: &str, args: Args) -> Result<Node, RuntimeError> {
    Node::start_or(name, args, || {
        let what =
            "was stopped and continued, or hears nothing through DDS any more: start the command again";
        output::complain(&Failed(what.to_owned()).into());
        runtime::write_last_lines();
        std::process::exit(DEAF);
    })
}
