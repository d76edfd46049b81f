//! From `main` to a running node and back.

use crate::args::{Args, ArgsError, LogLevel};
use crate::bounds;
use crate::error::{RuntimeError, chain};
use crate::installed;
use crate::lifecycle;
use crate::logging;
use crate::node::Node;
use crate::shutdown;
use std::error::Error;
use std::io::Write;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code where the person who started the node has to change something.
const USAGE: u8 = 2;
/// Exit code of every other failure.
const FAILURE: u8 = 1;

/// Runs a node until it ends: starts it from the arguments of this process on a single-threaded executor and hands it
/// to `main`, once a configuration. Exit code 0 after an orderly end, 2 for arguments and parameters that were refused,
/// 1 otherwise.
///
/// `main` loads and opens what it needs, waits for [`Node::activated`], works until [`Node::shutdown`], and returns after
/// its last word.
pub fn run<F, R, E>(name: &str, main: F) -> ExitCode
where
    F: Fn(Node) -> R,
    R: Future<Output = Result<(), E>>,
    E: Error + 'static,
{
    // A shell may wrap a refused parameter in an error of its own: the node remembers it.
    let refused = Arc::new(AtomicBool::new(false));
    let code = match start(name, main, &refused) {
        Ok(()) if bounds::left_the_crowd() => ExitCode::from(bounds::DRIVEN_OUT),
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let usage = refused.load(Ordering::Relaxed)
                || error.is::<ArgsError>()
                || error.downcast_ref::<RuntimeError>().is_some_and(RuntimeError::is_usage);
            // Arguments may be what is wrong: logging starts with what can be had.
            logging::start(&Args::default(), name);
            tracing::error!("{name}: {}", chain(error.as_ref()));
            ExitCode::from(if usage { USAGE } else { FAILURE })
        }
    };
    logging::write_last_lines();
    code
}

/// What `--help` says.
fn usage(name: &str) -> String {
    format!(
        "usage: {name} [--ros-args ARGUMENTS]\n\n\
         A node of fdm_loop. ARGUMENTS as of every ROS 2 node: -r FROM:=TO, -p NAME:=VALUE, --params-file FILE,\n\
         --log-level LEVEL. Its parameters, each with unit, range and meaning: config/{name}.param.yaml, or\n\
         `ros2 param describe` while it runs. What it does: nodes/README.md.\n"
    )
}

/// Starts the node and runs the shell to its end.
fn start<F, R, E>(name: &str, main: F, refused: &Arc<AtomicBool>) -> Result<(), Box<dyn Error>>
where
    F: Fn(Node) -> R,
    R: Future<Output = Result<(), E>>,
    E: Error + 'static,
{
    shutdown::end_while_starting()?;
    bounds::set()?;
    let mut args = installed::complete(Args::from_env()?, name);
    if args.rest.iter().any(|word| word == "--help" || word == "-h") {
        return Ok(std::io::stdout().lock().write_all(usage(name).as_bytes())?);
    }
    if args.log_levels.is_empty() && std::env::var_os("RUST_LOG").is_none() {
        // As `rclcpp` has it.
        args.log_levels.push((None, LogLevel::Info));
    }
    if let Some(word) = args.rest.first() {
        return Err(ArgsError::NotTaken(word.clone()).into());
    }
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    executor.block_on(async {
        let mut node = Node::start_with(name, args)?;
        node.remember_refusals(Arc::clone(refused));
        let (orders, autostart) = node.manage()?;
        // The node's tasks end when the executor runs again, and the middleware after them.
        let middleware = node.middleware();
        let ended = lifecycle::drive(&node, main, orders, autostart).await;
        drop(node);
        tokio::task::yield_now().await;
        drop(middleware);
        ended
    })
}
