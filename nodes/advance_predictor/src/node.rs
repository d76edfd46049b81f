//! The shell.

use runtime::{Node, RuntimeError};

/// Runs the node to its end.
///
/// # Errors
/// [`RuntimeError`] where it cannot start.
pub async fn run(mut node: Node) -> Result<(), RuntimeError> {
    node.shutdown().await;
    Ok(())
}
