//! `fdm up`: every node its own process, a print from start to end, an orderly stop, figures at the end.

mod bring_up;
mod ears;
pub mod ended;
pub(crate) mod ending;
mod failure;
pub mod fleet;
mod guard;
pub mod hearing;
pub mod recipes;
mod records;
mod reports;
pub mod summary;
pub mod watch;
pub mod words;

use crate::bag::recover;
use crate::config::ConfigDir;
use crate::job::GcodeFile;
use crate::output::{self, Failed, Json};
use crate::sim::fitted::EXTRAS;
use crate::sim::{ADVANCES, level};
use anyhow::{Context, bail};
use clap::Args;
use ended::Ended;
use fleet::Fleet;
use recipes::Plan;
use std::path::{Path, PathBuf};
use summary::Print;

/// Starts the node processes and prints a file on the simulated printer, over DDS.
#[derive(Debug, Args)]
pub struct UpArgs {
    /// File to print.
    #[arg(long)]
    pub gcode: PathBuf,
    /// Folder with the parameter files.
    #[arg(long)]
    pub config: Option<PathBuf>,
    /// Folder of the bag; a new one under bags/ by default. With several control levels, `-<level>` is added.
    #[arg(long)]
    pub bag: Option<PathBuf>,
    /// Simulated over wall time.
    #[arg(long, default_value_t = 1.0)]
    pub speed: f64,
    /// Run on the host's clock, as beside a real printer, instead of /clock; at --speed 1 alone.
    #[arg(long)]
    pub host_clock: bool,
    /// Control levels, one print each: off, encoder, mpc.
    #[arg(long, default_value = "mpc", value_delimiter = ',')]
    pub control: Vec<String>,
    /// Mode of the supervisor: observe, advise or act.
    #[arg(long, default_value = "act", value_parser = ["observe", "advise", "act"])]
    pub mode: String,
    /// Host profile: native or serial.
    #[arg(long, default_value = "native", value_parser = ["native", "serial"])]
    pub host: String,
    /// Source of the pressure advance: none, file (`M900`), material (a constant), planned (preview: the melt's law
    /// attached to coming moves) or predicted, which starts the node `advance_predictor` as well.
    #[arg(long, default_value = "planned", value_parser = ADVANCES)]
    pub advance: String,
    /// Scenario of config/scenarios, or a path to one.
    #[arg(long, default_value = "nominal")]
    pub scenario: String,
    /// PLA, PETG or ABS with its set-points, instead of the file's own.
    #[arg(long)]
    pub material: Option<String>,
    /// Print only the first layers.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub layers: Option<u32>,
    /// Start with hot end and bed at the file's set-points.
    #[arg(long)]
    pub warm: bool,
    /// Sensors that are fitted besides, separated by commas: nozzle.
    #[arg(long, value_delimiter = ',', value_parser = EXTRAS)]
    pub with: Vec<String>,
    /// Seed of all noise.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Namespace of the printer.
    #[arg(long, default_value = "/printer", value_parser = runtime::check_namespace)]
    pub namespace: String,
    /// Serve printer_sim/inject_fault.
    #[arg(long)]
    pub allow_fault_injection: bool,
    /// Print the processes that would be started, as JSON, and start none.
    #[arg(long)]
    pub dry_run: bool,
    /// Keep the graph running after the print has ended, until Ctrl-C.
    #[arg(long)]
    pub stay: bool,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    pub json: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// One line that says what is wrong and where.
pub fn run(args: &UpArgs) -> anyhow::Result<()> {
    for name in &args.control {
        level(name)?;
    }
    if !(0.1..=20.0).contains(&args.speed) {
        bail!("--speed {}: must be in [0.1, 20]; `fdm sim` is faster", args.speed);
    }
    if args.host_clock && (args.speed - 1.0).abs() > f64::EPSILON {
        bail!("--speed {} beside --host-clock: must be 1, the host's clock goes no faster", args.speed);
    }
    let config = ConfigDir::find(args.config.as_deref())?;
    let mut file = GcodeFile::read(&args.gcode, &config.motion()?, args.layers)?;
    let material = args.material.clone().unwrap_or_else(|| file.material());
    config.check_material(&material)?;
    config.scenario(&args.scenario)?;
    let json = Json::new(args.json.as_deref());
    json.check()?;
    let plans = plans(args, &config, &material)?;
    if args.dry_run {
        let processes: Vec<_> = plans.iter().map(Plan::processes).collect::<anyhow::Result<_>>()?;
        return output::line(&serde_json::to_string_pretty(&processes)?);
    }
    file.tell(&args.gcode, &config.motion()?);
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let mut prints = Vec::new();
    for plan in &plans {
        let (print, ended) = executor.block_on(one(plan, json.is_stdout()))?;
        prints.push(print);
        // With `--stay` it is Ctrl-C that ends each but a lost one.
        if ended == Ended::Interrupted || plan.stay && ended != Ended::Lost {
            break;
        }
    }
    if !json.is_stdout() {
        output::line(&summary::table(&prints))?;
    }
    match &prints[..] {
        [only] => json.write(only)?,
        several => json.write(&serde_json::json!({ "prints": several }))?,
    }
    match prints.iter().find(|print| matches!(print.ended, Ended::Failed | Ended::Lost)) {
        Some(print) => Err(failed(print).into()),
        None => Ok(()),
    }
}

/// A print that did not come to its end: nothing was wrong with the command.
fn failed(print: &Print) -> Failed {
    let (control, bag) = (&print.control, &print.bag);
    let how = if print.ended == Ended::Lost { "was lost" } else { "failed" };
    let why = print.cause.as_ref().map_or(String::new(), |cause| format!(": {cause}"));
    Failed(format!("the print with control {control} {how}{why}; `fdm report {bag}` shows what happened"))
}

/// All prints, checked before the first one starts.
fn plans(args: &UpArgs, config: &ConfigDir, material: &str) -> anyhow::Result<Vec<Plan>> {
    let mut plans: Vec<Plan> = Vec::new();
    for (nth, control) in args.control.iter().enumerate() {
        // Not by the names of their bags: these tell the second, which may be the next one by now.
        if args.control[..nth].contains(control) {
            bail!("--control {}: the same level twice would write one bag", args.control.join(","));
        }
        let plan = Plan::new(args, config, material, control)?;
        plan.check()?;
        // A program that is missing is told before the graph is joined.
        plan.processes()?;
        plans.push(plan);
    }
    Ok(plans)
}

/// One print from the start of the processes to their end.
async fn one(plan: &Plan, quiet: bool) -> anyhow::Result<(Print, Ended)> {
    let mut watch = watch::Watch::start(plan, quiet)?;
    watch.refuse_second_graph().await?;
    let mut fleet =
        Fleet::start_held(plan.recipes()?, &plan.logs()).context("a node could not be started")?;
    let pids = fleet.pids();
    if !quiet {
        let list: Vec<String> = pids.iter().map(|(name, pid)| format!("{name} {pid}")).collect();
        output::note(&format!("{} node processes: {}", pids.len(), list.join(", ")));
    }
    let up = bring_up::bring_up(&mut watch, &mut fleet, &plan.logs()).await;
    let ended = match up {
        Ok(true) => watch.follow(&mut fleet).await,
        Ok(false) | Err(_) => Ended::Interrupted,
    };
    watch.stop(&mut fleet).await;
    close(&plan.bag);
    up?;
    let print = Print::new(plan, &pids, &watch, ended);
    Ok((print, ended))
}

/// What a recorder that was ended by force has left becomes a bag that every reader opens.
pub(crate) fn close(bag: &Path) {
    match recover::leftover(bag) {
        Ok(None) => {}
        Ok(Some(messages)) => {
            output::note(&format!("{}: {messages} messages recovered after a kill", bag.display()));
        }
        Err(error) => output::note(&format!("the bag is not closed: {error:#}")),
    }
}

/// A folder that is not there yet, so that no bag is ever overwritten.
///
/// # Errors
/// A folder that is there and not empty; what is there and no folder.
pub fn check_new_bag(bag: &Path) -> anyhow::Result<()> {
    if std::fs::symlink_metadata(bag).is_ok() && !bag.is_dir() {
        bail!("--bag {}: is there and no folder; a bag is a folder, made new for each print", bag.display());
    }
    if bag.exists() && std::fs::read_dir(bag).is_ok_and(|mut entries| entries.next().is_some()) {
        bail!("--bag {}: the folder is there and not empty", bag.display());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file, a device or a link that leads nowhere: told before eleven processes are started.
    #[test]
    fn a_bag_takes_the_place_of_nothing() {
        let folder = std::env::temp_dir().join(format!("fdm_new_bag_{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(folder.join("empty")).unwrap();
        std::fs::create_dir_all(folder.join("used/inner")).unwrap();
        std::fs::write(folder.join("file"), "x").unwrap();
        std::os::unix::fs::symlink(folder.join("nowhere"), folder.join("link")).unwrap();
        for fine in ["empty", "new", "new/deeper"] {
            check_new_bag(&folder.join(fine)).unwrap();
        }
        for refused in ["file", "link", "used", "/dev/null"] {
            let error = check_new_bag(&folder.join(refused)).unwrap_err().to_string();
            assert!(error.starts_with("--bag ") && error.contains(refused), "{error}");
        }
        std::fs::remove_dir_all(folder).unwrap();
    }
}
