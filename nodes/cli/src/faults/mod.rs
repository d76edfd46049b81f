//! `fdm faults`: the catalogue of faults, in virtual time or on real processes, reaction times beside their limits.

pub mod catalogue;
pub mod figures;
pub mod meaning;
pub mod measure;
mod miss;
pub mod page;
pub mod process;
pub mod sound;
pub mod text;
pub mod trial;

use crate::config::{Choice, ConfigDir, Setup};
use crate::job::GcodeFile;
use crate::output::{self, Failed, Json};
use crate::sim;
use anyhow::{Context, bail};
use catalogue::{Catalogue, FaultSpec, TrialSpec};
use clap::Args;
use figures::{FaultFigures, Figures, TrialFigures};
use indicatif::ProgressBar;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use trial::{Outcome, Trial};

/// Runs the catalogue of faults on a simulated printer: in virtual time, or with real processes over DDS.
#[derive(Debug, Args)]
pub struct FaultsArgs {
    /// Only these IDs, separated by commas.
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// What needs real processes over DDS, in the domain ROS_DOMAIN_ID and at real time, instead of what does not.
    #[arg(long)]
    process: bool,
    /// Seeds of all noise, or of the moments of the faults: A..B, both included; 1..20, or 1..1 with --process.
    #[arg(long)]
    seeds: Option<String>,
    /// With --process: how long the soak lasts [s]; from half an hour on it has a limit.
    #[arg(long, requires = "process")]
    soak_s: Option<f64>,
    /// With --process: leave bags and logs where they are.
    #[arg(long, requires = "process")]
    keep: bool,
    /// Leave out the trials that render frames: they take seconds each, the others a fraction of one.
    #[arg(long, conflicts_with = "process")]
    no_camera: bool,
    /// Simulated hours of sound prints with nuisances, in which nothing may trip; a hundredth of them with the camera.
    #[arg(long, default_value_t = 0.0)]
    hours: f64,
    /// Folder with the parameter files; the catalogue's prints are found from there, in ../tests/data as in a clone.
    #[arg(long)]
    config: Option<PathBuf>,
    /// Write a page with the figure.
    #[arg(long)]
    html: Option<PathBuf>,
    /// Write the figures to a file, or to standard output with `-`. Times and limit of an ID are those of its trial that
    /// came nearest to its limit; each trial's own stand in `trials`.
    #[arg(long)]
    json: Option<PathBuf>,
}

/// A trial of an ID, ready to run.
struct Prepared<'a> {
    fault: &'a FaultSpec,
    spec: &'a TrialSpec,
    setup: Setup,
    file: GcodeFile,
    warm: bool,
}

/// Runs the command.
///
/// # Errors
/// One line that says what is wrong and where; [`Failed`] where a limit was missed or something tripped without a cause.
pub fn run(args: &FaultsArgs) -> anyhow::Result<()> {
    let seeds = args.seeds.as_deref().unwrap_or(if args.process { "1..1" } else { "1..20" });
    let seeds = crate::process::seeds("--seeds", seeds)?;
    if !(0.0..=1e4).contains(&args.hours) {
        bail!("--hours {}: must be in [0, 10000] h", args.hours);
    }
    if args.process && args.hours > 0.0 {
        bail!("--hours {}: sound prints are simulated, --process is not", args.hours);
    }
    if let Some(soak_s) = args.soak_s.filter(|soak_s| !(1.0..=86_400.0).contains(soak_s)) {
        bail!("--soak-s {soak_s}: must be in [1, 86400] s");
    }
    let json = Json::new(args.json.as_deref());
    json.check()?;
    args.html.as_deref().map_or(Ok(()), |page| output::check_writable("--html", page))?;
    let config = ConfigDir::find(args.config.as_deref())?;
    let catalogue = Catalogue::read(&config.file("faults.yaml"))?;
    let chosen = chosen(&catalogue, &args.only)?;
    if !args.process {
        check_tried(&chosen, args)?;
    }
    let figures = if args.process {
        let wish = process::Wish { seeds, soak_s: args.soak_s, keep: args.keep };
        process::run(&config, &catalogue, &chosen, &wish)?
    } else {
        in_virtual_time(&config, &catalogue, &chosen, (&seeds, args.hours), args.no_camera)?
    };
    if !json.is_stdout() {
        output::line(&text::table(&figures))?;
    }
    json.write(&figures)?;
    if let Some(path) = &args.html {
        std::fs::write(path, page::page(&figures)).with_context(|| path.display().to_string())?;
    }
    judge(&figures)
}

/// All that needs no process, and sound prints of so many hours.
fn in_virtual_time(
    config: &ConfigDir,
    catalogue: &Catalogue,
    chosen: &[&FaultSpec],
    (seeds, hours): (&[u64], f64),
    no_camera: bool,
) -> anyhow::Result<Figures> {
    let mut prepared = prepare(config, catalogue, chosen)?;
    prepared.retain(|trial| !(no_camera && trial.spec.camera));
    let progress = output::bar((prepared.len() * seeds.len()) as u64, "runs");
    let outcomes = run_all(&prepared, seeds, &progress)?;
    progress.finish_and_clear();
    let mut by_id: BTreeMap<&str, Vec<TrialFigures>> = BTreeMap::new();
    for (trial, outcomes) in prepared.iter().zip(&outcomes) {
        let figures = TrialFigures::of(&trial.fault.id, trial.spec, reaction(trial), outcomes)
            .limited_by(trial.spec.source.or(trial.fault.source));
        by_id.entry(&trial.fault.id).or_default().push(figures);
    }
    let of = |id: &str, by_id: &mut BTreeMap<&str, Vec<TrialFigures>>| by_id.remove(id).unwrap_or_default();
    let faults: Vec<FaultFigures> =
        chosen.iter().map(|fault| FaultFigures::of(fault, "virtual", of(&fault.id, &mut by_id))).collect();
    let first_seed = seeds.first().copied().unwrap_or(1);
    let prints = catalogue.sound.iter().filter(|print| !(no_camera && print.camera)).cloned();
    let sound = sound::run(config, &prints.collect::<Vec<_>>(), (first_seed, hours))?;
    let early: usize = faults.iter().flat_map(|fault| &fault.trials).map(|trial| trial.false_trips).sum();
    Ok(Figures {
        level: "virtual",
        faults,
        false_trips: early + sound.trips.len(),
        false_trip_list: sound.trips,
        hours: sound.hours,
        camera_hours: sound.camera_hours,
        sound_prints: sound.prints,
        file_pauses: sound.pauses,
    })
}

fn judge(figures: &Figures) -> anyhow::Result<()> {
    if figures.is_sound() {
        return Ok(());
    }
    let missed: Vec<&str> = figures
        .faults
        .iter()
        .filter(|fault| fault.within_limit == Some(false))
        .map(|fault| fault.id.as_str())
        .collect();
    let missed = if missed.is_empty() { "none".to_owned() } else { missed.join(", ") };
    Err(Failed(format!("limits missed: {missed}; false trips: {}", figures.false_trips)).into())
}

fn chosen<'a>(catalogue: &'a Catalogue, only: &[String]) -> anyhow::Result<Vec<&'a FaultSpec>> {
    let only: Vec<&str> = only.iter().map(|id| id.trim()).collect();
    for id in &only {
        if !catalogue.faults.iter().any(|fault| fault.id == **id) {
            let known: Vec<&str> = catalogue.faults.iter().map(|fault| fault.id.as_str()).collect();
            bail!("--only {id}: no such ID; there are {}", known.join(" "));
        }
    }
    let wanted = |fault: &&FaultSpec| only.is_empty() || only.contains(&fault.id.as_str());
    Ok(catalogue.faults.iter().filter(wanted).collect())
}

/// Where each of these IDs is shown, which are not here: `tried` names where those with trials are.
fn elsewhere(chosen: &[&FaultSpec], tried: &str) -> String {
    let one = |fault: &&FaultSpec| match (&fault.waiting, &fault.test) {
        (Some(why), _) => format!("{} waits ({why})", fault.id),
        _ if !(fault.trials.is_empty() && fault.process.is_empty()) => format!("{} is, {tried}", fault.id),
        (None, Some(test)) => format!("{} has the test {test}", fault.id),
        (None, None) => format!("{} is not tried", fault.id),
    };
    chosen.iter().map(one).collect::<Vec<_>>().join("; ")
}

/// Refuses a run in virtual time that would try nothing of what is asked for, and tells what a wish leaves out.
fn check_tried(chosen: &[&FaultSpec], args: &FaultsArgs) -> anyhow::Result<()> {
    let named = |of: fn(&FaultSpec) -> bool| {
        let ids: Vec<&str> = chosen.iter().filter(|fault| of(fault)).map(|fault| fault.id.as_str()).collect();
        ids.join(", ")
    };
    let is_tried = |fault: &&FaultSpec| !fault.trials.is_empty();
    if !args.only.is_empty() && args.hours <= 0.0 && !chosen.iter().any(is_tried) {
        bail!("none of these IDs is tried in virtual time: {}", elsewhere(chosen, "with --process"));
    }
    let blind = named(|fault| !fault.trials.is_empty() && fault.trials.iter().all(|trial| trial.camera));
    if !args.no_camera || blind.is_empty() {
        return Ok(());
    }
    if args.only.is_empty() {
        let partly = named(|fault| {
            fault.trials.iter().any(|trial| trial.camera) && !fault.trials.iter().all(|trial| trial.camera)
        });
        output::note(&format!("--no-camera leaves out {blind}, and parts of {partly}"));
        return Ok(());
    }
    bail!(
        "--no-camera leaves nothing of {blind}: every trial of theirs renders frames; leave out the one or the other"
    )
}

fn prepare<'a>(
    config: &ConfigDir,
    catalogue: &'a Catalogue,
    chosen: &[&'a FaultSpec],
) -> anyhow::Result<Vec<Prepared<'a>>> {
    let mut prepared = Vec::new();
    for &fault in chosen {
        for spec in &fault.trials {
            let at = || format!("{}, trial '{}'", fault.id, spec.name);
            let job = &catalogue.jobs[&spec.job];
            let file = job.load(config).with_context(at)?;
            let choice = Choice {
                camera: spec.camera,
                overrides: spec.overrides(),
                ..Choice::of(file.material(), sim::level(&spec.control).with_context(at)?)
            };
            let setup = config.load(&choice).with_context(at)?;
            prepared.push(Prepared { fault, spec, setup, file, warm: job.warm });
        }
    }
    Ok(prepared)
}

fn reaction(trial: &Prepared<'_>) -> catalogue::Reaction {
    trial.spec.reaction.unwrap_or(trial.fault.reaction)
}

/// Every trial with every seed, on all cores; by trial, in the order of the seeds.
fn run_all(
    prepared: &[Prepared<'_>],
    seeds: &[u64],
    progress: &ProgressBar,
) -> anyhow::Result<Vec<Vec<Outcome>>> {
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<(usize, anyhow::Result<Outcome>)>> = Mutex::new(Vec::new());
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(trial) = prepared.get(index / seeds.len()) else { return };
            let Prepared { spec, setup, file, warm, .. } = trial;
            let run = Trial { spec, reaction: reaction(trial), setup, file, warm: *warm };
            let outcome = run.run(seeds[index % seeds.len()]);
            progress.inc(1);
            if let Ok(mut done) = done.lock() {
                done.push((index, outcome));
            }
        }
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| (0..cores).for_each(|_| _ = scope.spawn(work)));
    let mut done = done.into_inner().unwrap_or_default();
    done.sort_by_key(|(index, _)| *index);
    let outcomes = done.into_iter().map(|(_, outcome)| outcome).collect::<anyhow::Result<Vec<_>>>()?;
    Ok(outcomes.chunks(seeds.len()).map(<[Outcome]>::to_vec).collect())
}
