//! A shell in the driver's hands, and where it goes.

use super::super::machine::Outcome;
use super::super::stage::Stage;
use std::error::Error;
use std::pin::Pin;

/// How a shell ended.
pub(super) type End = Result<(), Box<dyn Error>>;

/// What a shell does until it ends.
pub(super) type Work<'a> = Pin<Box<dyn Future<Output = End> + 'a>>;

/// A configured shell.
pub(super) struct Shell<'a> {
    pub(super) work: Work<'a>,
    pub(super) stage: Stage,
}

/// What a configuration came to.
pub(super) enum Configured<'a> {
    Ready(Shell<'a>),
    Ended(End),
    /// The process is to end.
    Interrupted,
}

/// Where the node goes from inactive.
pub(super) enum Next {
    Active(By),
    /// How the step ended that leads there.
    Unconfigured(Outcome),
    End(End),
    /// Parameters changed.
    Anew,
}

/// Who wants a node to be active.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum By {
    Itself,
    Request,
}
