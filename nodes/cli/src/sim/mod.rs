//! `fdm sim`: the whole loop in one process and virtual time.

pub mod bagging;
mod choices;
pub mod consistency;
pub mod corners;
mod fitted;
pub mod foresight;
pub mod message;
pub mod printing;
pub mod relay;
pub mod report;
pub mod sight;
pub mod text;
mod trimmed;
pub mod width_trace;

use crate::config::{Choice, ConfigDir, Setup};
use crate::job::GcodeFile;
use crate::output::{self, Json};
use anyhow::bail;
use bagging::Bagging;
use choices::name_of;
pub use choices::{advance, level, seed_range};
use clap::Args;
use fdm_loop_msgs::PrintInfo;
use fitted::{HOSTS, SENSORS, without};
use models::status::JobPhase;
use mpc_controller::params::Level;
use printer_sim::Scenario;
use printing::Printing;
use report::{Comparison, Group, Run};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;
use width_trace::WidthTrace;

/// Simulates a print in virtual time; every figure is a simulated one.
#[derive(Debug, Args)]
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

/// What several runs share.
struct Task {
    setup: Setup,
    file: GcodeFile,
    scenario: Scenario,
    names: Names,
    bag: Option<(PathBuf, PrintInfo)>,
}

/// Time for which a width has to be back to count as recovered `[s]`.
const HELD_S: f64 = 5.0;

struct Names {
    scenario: String,
    host: String,
    advance: String,
    buffer: Option<u32>,
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
    let levels = args.control.iter().map(|name| level(name)).collect::<anyhow::Result<Vec<_>>>()?;
    let config = ConfigDir::find(args.config.as_deref())?;
    let file = GcodeFile::read_telling(&args.gcode, &config.motion()?, args.layers)?;
    let scenario = config.scenario(&args.scenario)?;
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
        overrides: without(&args.without),
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

/// Refuses a bag that is there, and says what is going to be printed.
fn new_bag(
    bag: &Path,
    (config, choice): (&ConfigDir, &Choice),
    names: &Names,
    file: &GcodeFile,
) -> anyhow::Result<(PathBuf, PrintInfo)> {
    crate::up::check_new_bag(bag)?;
    let text = config.texts(choice)?;
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

impl Task {
    /// One run; a run with a fault is compared with the same seed's run without.
    fn one(
        &self,
        level: Level,
        seed: u64,
        fault_free: &mut BTreeMap<u64, WidthTrace>,
    ) -> anyhow::Result<Run> {
        let started = Instant::now();
        let (printing, notes) = self.print(&self.scenario, seed, self.bag.as_ref())?;
        let wall_time_s = started.elapsed().as_secs_f64();
        if !self.scenario.faults.is_empty() && !fault_free.contains_key(&seed) {
            fault_free.insert(seed, self.print(&Scenario::default(), seed, None)?.0.width);
        }
        Ok(self.report(&printing, fault_free.get(&seed), (level, seed, wall_time_s, notes)))
    }

    fn print(
        &self,
        scenario: &Scenario,
        seed: u64,
        bag: Option<&(PathBuf, PrintInfo)>,
    ) -> anyhow::Result<(Printing, Option<String>)> {
        let mut printing = Printing::new(&self.setup, self.file.job(&self.setup), scenario, seed)?;
        if let Some((bag, info)) = bag {
            let machine = self.setup.sight.as_ref().map(|sight| sight.params.machine);
            printing = printing.with_bagging(Bagging::create(bag, info, machine)?);
        }
        let mut stuck = None;
        while printing.step() {
            if printing.is_stuck() {
                stuck = Some("paused".to_owned());
                break;
            }
        }
        printing.take_bagging().map(Bagging::finish).transpose()?;
        Ok((printing, stuck))
    }

    fn report(
        &self,
        printing: &Printing,
        fault_free: Option<&WidthTrace>,
        (level, seed, wall_time_s, stuck): (Level, u64, f64, Option<String>),
    ) -> Run {
        let truth = printing.simulator().truth();
        let whole = truth.integrals.since(&Default::default());
        let [settled, late] = printing.settled.map(|at| at.and_then(|at| truth.integrals.since(&at)));
        let channels = ["thermistor", "encoder", "width"];
        let ended = stuck.unwrap_or_else(|| match printing.simulator().phase() {
            JobPhase::Done => "done".to_owned(),
            other => format!("{other:?}").to_lowercase(),
        });
        Run {
            gcode_oddities: self.file.oddities(),
            gcode: self.file.name(),
            material: self.setup.material.name.clone(),
            scenario: self.names.scenario.clone(),
            control: name_of(level).to_owned(),
            host: self.names.host.clone(),
            advance: self.names.advance.clone(),
            buffer: self.names.buffer,
            seed,
            ended,
            print_time_s: truth.stamp_s,
            wall_time_s,
            realtime_factor: truth.stamp_s / wall_time_s,
            quality_mean: whole.map(|figures| figures.quality_mean),
            width_rms_rel: whole.map(|figures| figures.width_rms_rel),
            corner_width_rms_rel: printing.foresight.corners.rms(),
            corner_time_s: printing.foresight.corners.time_s(),
            feed_error_rel: whole.map(|figures| figures.feed_error_rel),
            feed_error_after_2s_rel: settled.map(|figures| figures.feed_error_rel),
            feed_error_after_8s_rel: late.map(|figures| figures.feed_error_rel),
            recovery_time_s: fault_free
                .zip(printing.onset_path_s)
                .and_then(|(fault_free, onset_s)| printing.width.recovery_s(fault_free, onset_s)),
            recovery_5s_s: fault_free
                .zip(printing.onset_path_s)
                .and_then(|(fault_free, onset_s)| printing.width.recovery_for_s(fault_free, onset_s, HELD_S)),
            nis_mean: channels.into_iter().zip(printing.nis_mean).collect(),
            nees_median: printing.consistency.median(),
            coverage: printing.consistency.coverage(),
            trimmed_share: printing.trimmed.shares().map(|shares| shares.0),
            feedback_share: printing.trimmed.shares().map(|shares| shares.1),
            detections: printing.noticed.iter().filter(|found| found.onset_s.is_some()).cloned().collect(),
            false_alarm_list: printing
                .noticed
                .iter()
                .filter(|found| found.onset_s.is_none())
                .cloned()
                .collect(),
            false_alarms: printing.noticed.iter().filter(|found| found.onset_s.is_none()).count(),
            max_command: printing.extremes,
            advance_control: printing.foresight.figures(&printing.controller().report().advance),
            camera: printing.sight(),
        }
    }
}

fn seeds(args: &SimArgs) -> anyhow::Result<Vec<u64>> {
    args.seeds.as_deref().map_or_else(|| Ok(vec![args.seed]), seed_range)
}
