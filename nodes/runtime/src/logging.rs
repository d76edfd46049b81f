//! Log lines to standard error and to `/rosout`. Whoever reads standard error may stop doing so: a thread of its own writes
//! there, and lines that it cannot take are dropped and counted. No node waits for a terminal or a pipe.

use crate::args::{Args, LogLevel};
use crate::clock::monotonic;
use fdm_loop_msgs::Log;
use models::units::Seconds;
use std::fmt::Write;
use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};
use std::time::Duration;
use tokio::sync::mpsc::{Receiver, Sender, channel};
use tracing::field::{Field, Visit};
use tracing::{Event, Level, Subscriber};
use tracing_appender::non_blocking::{ErrorCounter, NonBlockingBuilder, WorkerGuard};
use tracing_subscriber::filter::EnvFilter;
use tracing_subscriber::layer::{Context, Layer, SubscriberExt};
use tracing_subscriber::util::SubscriberInitExt;

/// Filter where neither `RUST_LOG` nor `--log-level` says otherwise; see [`MIDDLEWARE`].
const DEFAULT_LEVEL: &str = "warn";
/// The middleware's own levels, whatever level is asked for all loggers. RustDDS reports every port that nobody listens
/// on (`udp_sender`), and on a `lo` without multicast every message to its own readers (`writer`), every number that we
/// acknowledge beyond the last (`rtps_reader_proxy`) and every multicast group that it cannot join or leave (`udp_listener`); at the end of a process, every endpoint that goes after the
/// event loop (`pubsub`). `RUST_LOG` replaces all of it.
const MIDDLEWARE: &str = "rustdds=warn,ros2_client=warn,rustdds::network::udp_sender=error,\
                          rustdds::network::udp_listener=off,rustdds::rtps::writer=error,rustdds::rtps::rtps_reader_proxy=error,\
                          rustdds::dds::pubsub=off,\
                          ros2_client::distributions=error,ros2_client::service::wrappers=error";
/// Lines of the middleware a second; more are counted in `/diagnostics` and left out. RustDDS writes one for each
/// datagram that it cannot read: whoever sends garbage would fill the disk (X1).
const MIDDLEWARE_LINES_1_S: u64 = 20;
/// Lines that wait for `/rosout`; more are dropped (they are on standard error all the same).
const WAITING_LINES: usize = 256;
/// Lines that wait for standard error; more are dropped.
const WAITING_FOR_STDERR: usize = 4096;
/// Longest time that a process that is about to end leaves for its last lines.
const LAST_LINES: Duration = Duration::from_millis(200);

/// Logger of the node of this process, as `rclcpp` names it: `printer.thermistor`.
static LOGGER: OnceLock<String> = OnceLock::new();

/// The thread that writes to standard error; gone once its last lines are written.
static WRITER: Mutex<Option<WorkerGuard>> = Mutex::new(None);

/// Lines that standard error did not take.
static DROPPED: OnceLock<ErrorCounter> = OnceLock::new();

/// The end that feeds `/rosout`, once a node is there to publish.
static ROSOUT: OnceLock<Sender<Log>> = OnceLock::new();

/// The filter in force: `RUST_LOG`, else `--log-level`, else the default.
fn filter(args: &Args, node: &str) -> EnvFilter {
    if std::env::var_os("RUST_LOG").is_some() && args.log_levels.is_empty() {
        return EnvFilter::from_default_env();
    }
    EnvFilter::new(directives(&args.log_levels, node))
}

/// Filter directives of the levels asked for, in order: a later one wins.
fn directives(levels: &[(Option<String>, LogLevel)], node: &str) -> String {
    let mut all = format!("{DEFAULT_LEVEL},{MIDDLEWARE}");
    for (logger, level) in levels {
        let level = level.directive();
        // Writing to a string cannot fail.
        _ = match logger {
            Some(logger) if !is_of(node, logger) => write!(all, ",{}={level}", logger.replace('.', "::")),
            _ => write!(all, ",{level}"),
        };
    }
    all
}

/// Whether a logger is the node's own or one above it.
fn is_of(node: &str, logger: &str) -> bool {
    node.strip_prefix(logger).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// Logger of a node, by its name with its namespace.
pub(crate) fn logger(qualified: &str) -> String {
    qualified.trim_start_matches('/').replace('/', ".")
}

/// Starts logging; a second call in the same process changes nothing.
pub(crate) fn start(args: &Args, node: &str) {
    _ = LOGGER.set(logger(node));
    let (writer, guard) =
        NonBlockingBuilder::default().buffered_lines_limit(WAITING_FOR_STDERR).finish(std::io::stderr());
    let dropped = writer.error_counter();
    let console =
        tracing_subscriber::fmt::layer().with_writer(writer).with_ansi(std::io::stderr().is_terminal());
    let started = tracing_subscriber::registry()
        .with(filter(args, &logger(node)))
        .with(Throttle)
        .with((!args.no_stdout_logs).then_some(console))
        .with((!args.no_rosout_logs).then_some(Rosout))
        .try_init();
    if started.is_ok() {
        _ = DROPPED.set(dropped);
        *WRITER.lock().unwrap_or_else(PoisonError::into_inner) = Some(guard);
    }
}

/// Waits until the lines so far are written, 0.2 s at most; nothing is written after it. For a process that is about to end.
pub fn write_last_lines() {
    let guard = WRITER.lock().unwrap_or_else(PoisonError::into_inner).take();
    let (done, waiting) = std::sync::mpsc::channel::<()>();
    // A thread of its own: where nobody reads, letting go of the writer takes a second.
    _ = std::thread::Builder::new().spawn(move || {
        drop(guard);
        drop(done);
    });
    _ = waiting.recv_timeout(LAST_LINES);
}

/// Lines that were left out so far: of the middleware beyond its budget, and what standard error did not take.
pub(crate) fn lines_left_out() -> u64 {
    let dropped = DROPPED.get().map_or(0, ErrorCounter::dropped_lines);
    BUDGET.left_out.load(Ordering::Relaxed).saturating_add(u64::try_from(dropped).unwrap_or(u64::MAX))
}

/// Whether a line comes from the middleware, directly or by way of the `log` crate.
fn is_of_middleware(target: &str) -> bool {
    target.starts_with("rustdds") || target.starts_with("ros2_client") || target == "log"
}

/// What the middleware may write.
static BUDGET: Budget = Budget::new();

/// So many lines in each second.
struct Budget {
    second: AtomicU64,
    written: AtomicU64,
    left_out: AtomicU64,
}

impl Budget {
    const fn new() -> Self {
        Self { second: AtomicU64::new(0), written: AtomicU64::new(0), left_out: AtomicU64::new(0) }
    }

    /// Whether there is room for one more line; threads that meet at the end of a second may write one each too many.
    fn takes(&self, now: Seconds) -> bool {
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "seconds since the host's start"
        )]
        let second = now.0 as u64;
        if self.second.swap(second, Ordering::Relaxed) != second {
            self.written.store(0, Ordering::Relaxed);
        }
        let fits = self.written.fetch_add(1, Ordering::Relaxed) < MIDDLEWARE_LINES_1_S;
        self.left_out.fetch_add(u64::from(!fits), Ordering::Relaxed);
        fits
    }
}

/// Keeps the middleware from writing more than its budget.
struct Throttle;

impl<S: Subscriber> Layer<S> for Throttle {
    fn event_enabled(&self, event: &Event<'_>, _: Context<'_, S>) -> bool {
        !is_of_middleware(event.metadata().target()) || BUDGET.takes(monotonic())
    }
}

/// The lines to be published; `None` where another node of this process has them.
pub(crate) fn rosout_lines() -> Option<Receiver<Log>> {
    let (sender, receiver) = channel(WAITING_LINES);
    ROSOUT.set(sender).ok().map(|()| receiver)
}

/// Passes lines on to `/rosout`.
struct Rosout;

impl<S: Subscriber> Layer<S> for Rosout {
    fn on_event(&self, event: &Event<'_>, _: Context<'_, S>) {
        let metadata = event.metadata();
        let target = metadata.target();
        // A line about sending a line would never end.
        if is_of_middleware(target) {
            return;
        }
        let Some(sender) = ROSOUT.get() else { return };
        let mut text = Text::default();
        event.record(&mut text);
        let line = Log {
            level: level_number(*metadata.level()),
            name: LOGGER.get().map_or(target, String::as_str).to_owned(),
            msg: text.0,
            // Where in the node's code: modules, for there is no name of a function.
            function: target.to_owned(),
            file: metadata.file().unwrap_or_default().to_owned(),
            line: metadata.line().unwrap_or_default(),
            ..Log::default()
        };
        // Full: the line is on standard error.
        _ = sender.try_send(line);
    }
}

/// Level as `rcl_interfaces/Log` has it.
fn level_number(level: Level) -> u8 {
    match level {
        Level::ERROR => Log::ERROR,
        Level::WARN => Log::WARN,
        Level::INFO => Log::INFO,
        Level::DEBUG | Level::TRACE => Log::DEBUG,
    }
}

/// Message and fields of an event in one line.
#[derive(Default)]
struct Text(String);

impl Visit for Text {
    fn record_debug(&mut self, field: &Field, value: &dyn std::fmt::Debug) {
        let gap = if self.0.is_empty() { "" } else { " " };
        // Writing to a string cannot fail.
        _ = match field.name() {
            "message" => write!(self.0, "{gap}{value:?}"),
            name => write!(self.0, "{gap}{name}={value:?}"),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// X1: a datagram that cannot be read is a line; a million of them are twenty lines a second and a number.
    #[test]
    fn the_middleware_fills_no_disk() {
        let budget = Budget::new();
        let written = |from: u32| {
            (from..from + 1000).filter(|i| budget.takes(Seconds(7.0 + 1e-3 * f64::from(*i)))).count()
        };
        assert_eq!(written(0), 20);
        assert_eq!(written(1000), 20);
        assert_eq!(budget.left_out.load(Ordering::Relaxed), 2 * 980);
    }

    #[test]
    fn a_level_for_all_leaves_the_middleware_quiet() {
        let all = directives(&[(None, LogLevel::Debug), (Some("thermistor".into()), LogLevel::Error)], "");
        assert!(all.ends_with(",debug,thermistor=error"), "{all}");
        assert!(all.contains("rustdds=warn"), "{all}");
        assert!(all.parse::<EnvFilter>().is_ok());
    }

    /// `--log-level printer.thermistor:=debug`, as `rclcpp` names loggers, and what stands above it.
    #[test]
    fn the_nodes_own_logger_is_the_whole_node() {
        let node = logger("/printer/thermistor");
        for (wanted, all) in
            [("printer.thermistor", true), ("printer", true), ("print", false), ("rcl", false)]
        {
            let text = directives(&[(Some(wanted.into()), LogLevel::Debug)], &node);
            assert_eq!(text.ends_with(",debug"), all, "{text}");
        }
    }
}
