//! `fdm sim`: the whole loop in one process and virtual time.

pub mod bagging;
mod choices;
pub mod consistency;
pub mod corners;
pub mod fitted;
pub mod foresight;
pub mod group;
pub mod message;
pub mod printing;
pub mod relay;
pub mod report;
pub mod sight;
mod task;
pub mod text;
mod trimmed;
pub mod width_trace;

use crate::config::{Choice, ConfigDir};
use crate::job::GcodeFile;
use crate::options::distinct;
use crate::output::{self, Json};
use crate::process;
use anyhow::bail;
use choices::name_of;
pub use choices::{advance, level};
use clap::Args;
use fdm_loop_msgs::PrintInfo;
use fitted::{EXTRAS, HOSTS, SENSORS, fitted};
use group::{Comparison, Group};
use printer_sim::scenario::Entry;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use task::{Names, Task};
use width_trace::WidthTrace;

/// Simulates a print in virtual time; every figure is a simulated one.
///
/// A print that the loop pauses or that fails is a result as any other: the exit code is 0, the table and `ended` in the
/// JSON say how it ended.
#[derive(Debug, Args)]
#[command(allow_negative_numbers = true)]
pub struct SimArgs {
    /// File to print.
    gcode: PathBuf,
    /// Scenario of config/scenarios, or a path to one.
    #[arg(long, default_value = "nominal")]
    scenario: String,
    /// Control levels, separated by commas: off, encoder, mpc.
    #[arg(long, default_value = "mpc", value_delimiter = ',')]
    control: Vec<String>,
    /// Host profile: native, serial, moonraker or octoprint.
    #[arg(long, default_value = "native", value_parser = HOSTS)]
    host: String,
    /// PLA, PETG or ABS with its set-points, instead of the file's own.
    #[arg(long)]
    material: Option<String>,
    /// Seed of all noise.
    #[arg(long, default_value_t = 1, conflicts_with = "seeds")]
    seed: u64,
    /// Several seeds: A..B, both included.
    #[arg(long)]
    seeds: Option<String>,
    /// Print only the first layers.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    layers: Option<u32>,
    /// Folder with the parameter files.
    #[arg(long)]
    config: Option<PathBuf>,
    /// Render the camera's frames and judge them, sample accelerations; else a stand-in gives the road's width.
    #[arg(long)]
    camera: bool,
    /// Source of the pressure advance: none, file (`M900`), material (a constant), planned (preview: the melt's law
    /// attached to coming moves) or predicted (the advance predictor).
    #[arg(long, default_value = "planned", value_parser = ADVANCES)]
    advance: String,
    /// Sensors that are not fitted, separated by commas: encoder, width, tachometer.
    #[arg(long, value_delimiter = ',', value_parser = SENSORS)]
    without: Vec<String>,
    /// Sensors that are fitted besides, separated by commas: nozzle.
    #[arg(long, value_delimiter = ',', value_parser = EXTRAS)]
    with: Vec<String>,
    /// Moves that the firmware knows ahead of the current one; else the printer's own look-ahead.
    #[arg(long, value_parser = clap::value_parser!(u32).range(2..=10_000))]
    buffer: Option<u32>,
    /// Write all that is said to a new bag, which `fdm replay` plays to the bit; one control level, one seed.
    #[arg(long, conflicts_with = "seeds")]
    bag: Option<PathBuf>,
    /// Write the figures to a file, or to standard output with `-`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// Sources of the pressure advance.
pub const ADVANCES: [&str; 5] = ["none", "file", "material", "planned", "predicted"];

/// Runs the command.
///
/// # Errors
/// One line that says what is wrong and where.
pub fn run(args: &SimArgs) -> anyhow::Result<()> {
    let seeds = seeds(args)?;
    Json::new(args.json.as_deref()).check()?;
    check_lists(args)?;
    let levels = args.control.iter().map(|name| level(name)).collect::<anyhow::Result<Vec<_>>>()?;
    let config = ConfigDir::find(args.config.as_deref())?;
    let file = GcodeFile::read_telling(&args.gcode, &config.motion()?, args.layers)?;
    let scenario = config.scenario(&args.scenario)?;
    if !args.camera && scenario.faults.iter().any(Entry::shows_in_frames_alone) {
        output::note(&format!(
            "--scenario {}: only the camera sees what goes wrong: add --camera",
            args.scenario
        ));
    }
    let material = args.material.clone().unwrap_or_else(|| file.material());
    if let (Some(bag), true) = (&args.bag, levels.len() > 1) {
        bail!("--bag {}: one control level, not {}", bag.display(), args.control.join(","));
    }
    let mut groups = Vec::new();
    let mut fault_free: BTreeMap<u64, WidthTrace> = BTreeMap::new();
    let progress = output::bar((levels.len() * seeds.len()) as u64, "runs");
    let choice = Choice {
        host: args.host.clone(),
        advance: advance(&args.advance)?,
        camera: args.camera,
        overrides: fitted(&args.without, &args.with),
        ..Choice::of(material, levels[0])
    };
    let mut setup = config.load(&choice)?;
    if let Some(moves) = args.buffer {
        setup.motion = setup.motion.with_buffer(moves as usize);
        // What is planned is not known farther ahead either.
        let executor = &mut setup.simulated.simulator.executor;
        executor.plan_moves = executor.plan_moves.min(moves as usize);
        executor.serial_buffer_moves = executor.serial_buffer_moves.min(moves as usize);
    }
    let file = if args.material.is_some() { file.with_set_points(&setup) } else { file };
    let names = Names {
        scenario: args.scenario.clone(),
        host: args.host.clone(),
        advance: args.advance.clone(),
        buffer: args.buffer,
        without: args.without.clone(),
        with: args.with.clone(),
    };
    let bag = args.bag.as_deref().map(|bag| new_bag(bag, (&config, &choice), &names, &file)).transpose()?;
    let mut task = Task { setup, file, scenario, names, bag };
    for level in levels {
        task.setup.controller = task.setup.controller.with_level(level);
        fault_free.clear();
        let mut runs = Vec::new();
        for &seed in &seeds {
            runs.push(task.one(level, seed, &mut fault_free)?);
            progress.inc(1);
        }
        groups.push(Group::of(name_of(level).to_owned(), runs));
    }
    progress.finish_and_clear();
    publish(args, groups)
}

/// Refuses lists that name something twice.
fn check_lists(args: &SimArgs) -> anyhow::Result<()> {
    let lists = [("--control", &args.control), ("--without", &args.without), ("--with", &args.with)];
    lists.into_iter().try_for_each(|(option, names)| distinct(option, names))
}

/// Refuses a bag that is there, and says what is going to be printed.
fn new_bag(
    bag: &Path,
    (config, choice): (&ConfigDir, &Choice),
    names: &Names,
    file: &GcodeFile,
) -> anyhow::Result<(PathBuf, PrintInfo)> {
    crate::up::check_new_bag(bag)?;
    let text = format!("{}{}", config.texts(choice)?, names.text());
    let info = PrintInfo {
        print_id: bag.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
        gcode_file: file.name(),
        config_sha256: runtime::params::sha256_hex(text.as_bytes()),
        config: text,
        build: runtime::build().to_owned(),
        scenario: names.scenario.clone(),
        ..PrintInfo::default()
    };
    Ok((bag.to_path_buf(), info))
}

fn publish(args: &SimArgs, groups: Vec<Group>) -> anyhow::Result<()> {
    let json = Json::new(args.json.as_deref());
    if !json.is_stdout() {
        output::line(&text::table(&groups))?;
    }
    match (&groups[..], args.seeds.is_none()) {
        ([only], true) => json.write(&only.runs[0]),
        _ => json.write(&Comparison { results: groups }),
    }
}

fn seeds(args: &SimArgs) -> anyhow::Result<Vec<u64>> {
    let range = args.seeds.as_deref();
    range.map_or_else(|| Ok(vec![args.seed]), |range| process::seeds("--seeds", range))
}
