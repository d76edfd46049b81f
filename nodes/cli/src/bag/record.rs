//! `fdm record`: starts the recorder in place of this process, on its own.

use crate::config::ConfigDir;
use crate::up::recipes::DEFAULT_NAMESPACE;
use anyhow::{Context, bail};
use clap::Args;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::Command;

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
    /// Time from /clock.
    #[arg(long)]
    use_sim_time: bool,
    /// Namespace of the printer; beside another one than /printer its own clock counts, as with `fdm up`.
    #[arg(long, default_value = DEFAULT_NAMESPACE)]
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

/// Runs the command; it comes back only where the recorder cannot be started.
///
/// # Errors
/// One line that says what is wrong and where.
pub fn run(args: &RecordArgs) -> anyhow::Result<()> {
    let config = ConfigDir::find(args.config.as_deref())?;
    let folder = std::env::current_exe()?.parent().map(PathBuf::from).unwrap_or_default();
    let program = folder.join("bag_recorder");
    if !program.is_file() {
        bail!("{} is missing: build all nodes with `cargo build --release`", program.display());
    }
    let arguments = arguments(args, &config);
    if args.dry_run {
        return crate::output::line(&format!("{} {}", program.display(), arguments.join(" ")));
    }
    // The recorder takes this process over: signals and exit code are its own.
    let error = Command::new(&program).args(arguments).exec();
    Err(error).with_context(|| program.display().to_string())
}

fn arguments(args: &RecordArgs, config: &ConfigDir) -> Vec<String> {
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    let bag =
        args.bag.clone().unwrap_or_else(|| PathBuf::from("bags").join(format!("record-{}", now.as_secs())));
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
        ("use_sim_time", args.use_sim_time.then(|| "true".to_owned())),
    ];
    values.extend(given.into_iter().filter_map(|(name, value)| Some(format!("{name}:={}", value?))));
    let file = config.file("bag_recorder.param.yaml").display().to_string();
    let namespace = format!("__ns:={}", args.namespace);
    let name = format!("__node:={}", args.name);
    let mut arguments: Vec<String> =
        ["--ros-args", "-r", &name, "-r", &namespace, "--params-file", &file].map(str::to_owned).to_vec();
    if args.namespace != DEFAULT_NAMESPACE {
        arguments.extend(["-r".to_owned(), format!("/clock:={}/clock", args.namespace)]);
    }
    arguments.extend(values.into_iter().flat_map(|value| ["-p".to_owned(), value]));
    arguments
}
