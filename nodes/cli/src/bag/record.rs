//! `fdm record`: starts the recorder on its own.

use super::shown::Shown;
use crate::config::ConfigDir;
use crate::output;
use crate::participant;
use crate::programs;
use crate::up::recipes::{DEFAULT_NAMESPACE, clock_of};
use anyhow::bail;
use clap::Args;
use models::units::Seconds;
use runtime::topics;
use std::path::{Path, PathBuf};

/// Time to hear of who publishes simulated time `[s]`: discovery takes 0.5 s.
const LISTEN_S: f64 = 1.5;
/// Between two looks for it `[s]`.
const LOOK_S: f64 = 0.05;

/// Records the topics of a printer to a bag until Ctrl-C.
#[derive(Debug, Args)]
pub struct RecordArgs {
    /// Folder of the bag; a new one under bags/ by default. In one that is there a further file begins.
    #[arg(long)]
    bag: Option<PathBuf>,
    /// Record also what is left out by default.
    #[arg(long, conflicts_with = "leave_out")]
    all: bool,
    /// Record these topics alone, as declared (sensors/imu/batch) or resolved (/clock); separated by commas.
    #[arg(long, value_delimiter = ',')]
    topics: Vec<String>,
    /// Leave these topics out instead of the default ones.
    #[arg(long, value_delimiter = ',')]
    leave_out: Vec<String>,
    /// Begin a new file after so much time `[s]`.
    #[arg(long)]
    split_s: Option<f64>,
    /// Begin a new file after so much size `[MiB]`.
    #[arg(long)]
    split_mib: Option<u32>,
    /// Drop the oldest file where the bag grows beyond this `[MiB]`; it has to have room for one file (--split-mib).
    #[arg(long)]
    bag_mib: Option<u32>,
    /// Write nothing until a service asks for it: resume, record or snapshot.
    #[arg(long)]
    paused: bool,
    /// Keep so much in memory while paused, for a snapshot `[s]`.
    #[arg(long)]
    snapshot_s: Option<f64>,
    /// Time from /clock, or of this machine with `=false`. By default /clock counts where somebody publishes it at the start.
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true")]
    use_sim_time: Option<bool>,
    /// Namespace of the printer; beside another one than /printer its own clock counts, as with `fdm up`.
    #[arg(long, default_value = DEFAULT_NAMESPACE, value_parser = runtime::check_namespace)]
    namespace: String,
    /// Name of the node: not the one of the recorder that `fdm up` starts, whose services would answer too.
    #[arg(long, default_value = "fdm_record")]
    name: String,
    /// Folder with the parameter files.
    #[arg(long)]
    config: Option<PathBuf>,
    /// Print the command that would be run, and run none.
    #[arg(long)]
    dry_run: bool,
}

/// Runs the command.
///
/// # Errors
/// One line that says what is wrong and where.
pub fn run(args: &RecordArgs) -> anyhow::Result<()> {
    let config = ConfigDir::find(args.config.as_deref())?;
    let program = programs::there("bag_recorder")?;
    check(args)?;
    let simulated = match args.use_sim_time {
        None => match hear_clock(&args.namespace)? {
            Heard::Clock => Some(true),
            Heard::Nothing => None,
            Heard::Interrupt => return Ok(()),
        },
        given => given,
    };
    let bag = bag_of(args);
    let arguments = arguments(args, simulated, (&config, &bag));
    if args.dry_run {
        return output::line(&format!("{} {}", program.display(), arguments.join(" ")));
    }
    let mut shown = Shown::begin(&bag, &args.namespace, args.paused);
    super::kept::run(&program, &arguments, &mut shown)
}

/// What cannot be recorded so is told before anything is started.
fn check(args: &RecordArgs) -> anyhow::Result<()> {
    let (base, clock) = (args.namespace.trim_end_matches('/'), clock_of(&args.namespace));
    let is = |name: &String, topic: &str| {
        *name == topic
            || *name == format!("{base}/{topic}")
            || topic == topics::CLOCK.name() && *name == clock
    };
    for (option, names) in [("--topics", &args.topics), ("--leave-out", &args.leave_out)] {
        let is_known = |name: &&String| topics::ALL.iter().any(|topic| is(name, topic.name));
        if let Some(unknown) = names.iter().find(|name| !is_known(name)) {
            let all: Vec<&str> = topics::ALL.iter().map(|topic| topic.name).collect();
            bail!("{option} {unknown}: no topic of this system; there are {}", all.join(", "));
        }
    }
    let named = |names: &[String], topic: &str| names.iter().any(|name| is(name, topic));
    let is_left = |topic: &str| {
        !named(&args.leave_out, topic) && (args.topics.is_empty() || named(&args.topics, topic))
    };
    if !topics::ALL.iter().any(|topic| is_left(topic.name)) {
        bail!("--topics, --leave-out: they leave no topic to record");
    }
    for (option, span_s) in [("--split-s", args.split_s), ("--snapshot-s", args.snapshot_s)] {
        if let Some(wrong) = span_s.filter(|span_s| !(span_s.is_finite() && *span_s >= 0.0)) {
            bail!("{option} {wrong} s: must be 0 (none) or more, and finite");
        }
    }
    Ok(())
}

/// What came first.
enum Heard {
    Clock,
    Nothing,
    Interrupt,
}

/// Listens for a while whether somebody publishes simulated time: stamps would be of it, and times of this machine would fit
/// none of them.
fn hear_clock(namespace: &str) -> anyhow::Result<Heard> {
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let topic = clock_of(namespace);
    let heard = executor.block_on(async {
        let args = runtime::Args { namespace: Some(namespace.to_owned()), ..runtime::Args::default() };
        let mut node = participant::join("fdm_record", args)?;
        let (clock, mut looks) = (node.clock(), node.timer(Seconds(LOOK_S)));
        let begun = clock.now();
        while (clock.now() - begun).0 < LISTEN_S {
            tokio::select! {
                _ = looks.next() => {}
                () = node.shutdown() => return anyhow::Ok(Heard::Interrupt),
            }
            if node.published_topics().contains(&topic) {
                return Ok(Heard::Clock);
            }
        }
        Ok(Heard::Nothing)
    })?;
    if matches!(heard, Heard::Clock) {
        output::note(&format!(
            "{topic} is published: the bag has its times (--use-sim-time=false: those of this machine)"
        ));
    }
    Ok(heard)
}

/// The folder that was named, or a new one.
fn bag_of(args: &RecordArgs) -> PathBuf {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    args.bag.clone().unwrap_or_else(|| PathBuf::from("bags").join(format!("record-{}", now.as_secs())))
}

fn arguments(args: &RecordArgs, simulated: Option<bool>, (config, bag): (&ConfigDir, &Path)) -> Vec<String> {
    // JSON is YAML: whatever a file is called.
    let mut values = vec![format!("bag_dir:={}", serde_json::json!(bag.to_string_lossy()))];
    if args.all || !args.leave_out.is_empty() {
        values.push(format!("leave_out:={}", serde_json::json!(args.leave_out)));
    }
    if !args.topics.is_empty() {
        values.push(format!("topics:={}", serde_json::json!(args.topics)));
    }
    let given = [
        ("split_s", args.split_s.map(|value| format!("{value:?}"))),
        ("split_mib", args.split_mib.map(|value| value.to_string())),
        ("bag_mib", args.bag_mib.map(|value| value.to_string())),
        ("snapshot_s", args.snapshot_s.map(|value| format!("{value:?}"))),
        ("start_paused", args.paused.then(|| "true".to_owned())),
        ("use_sim_time", simulated.map(|value| value.to_string())),
    ];
    values.extend(given.into_iter().filter_map(|(name, value)| Some(format!("{name}:={}", value?))));
    let file = config.file("bag_recorder.param.yaml").display().to_string();
    let namespace = format!("__ns:={}", args.namespace);
    let name = format!("__node:={}", args.name);
    let mut arguments: Vec<String> =
        ["--ros-args", "-r", &name, "-r", &namespace, "--params-file", &file].map(str::to_owned).to_vec();
    if args.namespace != DEFAULT_NAMESPACE {
        arguments.extend(["-r".to_owned(), format!("/clock:={}", clock_of(&args.namespace))]);
    }
    arguments.extend(values.into_iter().flat_map(|value| ["-p".to_owned(), value]));
    arguments
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Words {
        #[command(flatten)]
        args: RecordArgs,
    }

    /// Why these options are refused; nothing where they are taken.
    fn refusal(words: &str) -> String {
        let words = Words::parse_from(std::iter::once("record").chain(words.split_whitespace()));
        check(&words.args).map_or_else(|error| error.to_string(), |()| String::new())
    }

    /// A bag without a topic, and a length of time that is none, are told before a recorder starts.
    #[test]
    fn what_cannot_be_recorded_is_refused() {
        let none = "--topics, --leave-out: they leave no topic to record";
        assert_eq!(refusal("--topics events --leave-out events"), none);
        assert_eq!(refusal("--topics /a/events,/a/clock --leave-out events,/clock --namespace /a"), none);
        assert!(refusal("--topics nix").starts_with("--topics nix: no topic of this system; there are "));
        assert_eq!(refusal("--split-s nan"), "--split-s NaN s: must be 0 (none) or more, and finite");
        assert!(refusal("--snapshot-s=-1").starts_with("--snapshot-s -1 s: "));
        for fine in ["", "--topics events", "--topics /clock --leave-out events", "--split-s 0", "--all"] {
            assert_eq!(refusal(fine), "", "{fine}");
        }
        assert_eq!(refusal("--topics /a/clock --namespace /a"), "");
    }
}
