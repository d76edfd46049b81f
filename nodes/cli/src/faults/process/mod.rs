//! `fdm faults --process`: faults of processes, services, storage, time and load on real processes over DDS, in the
//! domain of the caller.
//!
//! The graph is what `fdm up` starts: the same recipes, the same care for processes that end. Who looks on is one more
//! participant. Real time passes here: DDS and processes have no other.

mod aside;
mod calls;
mod graph;
mod jitter;
mod limits;
mod load;
mod machine;
mod node_fault;
mod observer;
mod off;
mod orders;
mod outcome;
mod session;
mod shim;
mod stops;
mod storage;
mod watcher;

use super::catalogue::{Act, Bench, Bound, Catalogue, FaultSpec, ProcessSpec, Reaction};
use super::figures::{FaultFigures, Figures, TrialFigures};
use super::measure::Measure;
use super::trial::share_of;
use crate::config::ConfigDir;
use crate::output;
use anyhow::{Context, bail};
use graph::{Graph, Setting};
use machine::{BARE, Machine};
use outcome::Observed;
use runtime::topics;
use session::Session;
use std::collections::BTreeMap;

/// Namespace of the printer in these trials.
const NAMESPACE: &str = "/printer";
/// Jobs of these trials among those of the catalogue: one, and a longer one for a soak.
const JOBS: [&str; 2] = ["process", "soak"];
/// Each seed adds a share of this before its fault `[s]`.
const SPREAD_S: f64 = 1.0;

/// A trial of an ID.
struct Due<'a> {
    fault: &'a FaultSpec,
    spec: &'a ProcessSpec,
    runs: Vec<Observed>,
}

/// Where so many processors were busy with something else, what the machine could not keep is excused if it was told.
const FOREIGN_CORES: f64 = 0.2;

/// So is it where a thread that does nothing is woken later than this with one of a thousand: half of what a permit may be `[s]`.
const BARE_LATE_S: f64 = 0.5 * topics::PERMIT_JITTER.0;

/// What is asked for beside the catalogue.
#[derive(Debug, Clone)]
pub struct Wish {
    /// Each decides the moments of the faults.
    pub seeds: Vec<u64>,
    /// How long a soak lasts instead of what the catalogue says `[s]`.
    pub soak_s: Option<f64>,
    /// Bags and logs stay where they are.
    pub keep: bool,
}

impl Wish {
    /// On what a trial runs: a soak whose length is asked for has a graph and a job of its own.
    fn bench(&self, spec: &ProcessSpec) -> Bench {
        match spec.act {
            Act::Soak { .. } if self.soak_s.is_some() => Bench::Long,
            _ => spec.act.bench(),
        }
    }
}

/// Runs all trials of the chosen faults.
///
/// # Errors
/// Files, programs and domains that cannot be used. What fails in a trial is its miss.
pub fn run(
    config: &ConfigDir,
    catalogue: &Catalogue,
    chosen: &[&FaultSpec],
    wish: &Wish,
) -> anyhow::Result<Figures> {
    let [gcode, long_gcode] = JOBS.map(|name| {
        let file = catalogue.jobs.get(name).and_then(|job| job.file.as_ref());
        file.map(|file| config.file(file)).with_context(|| format!("jobs: there is no file for '{name}'"))
    });
    let setting = Setting { config: config.clone(), gcode: gcode?, long_gcode: long_gcode? };
    let mut dues: Vec<Due<'_>> = Vec::new();
    for &fault in chosen {
        dues.extend(fault.process.iter().map(|spec| Due { fault, spec, runs: Vec::new() }));
    }
    if dues.is_empty() {
        let where_else = super::elsewhere(chosen, "without --process");
        bail!("none of these IDs is tried with processes: {where_else}");
    }
    Graph::check(&setting)?;
    // What can share a graph comes first, what ends its print last.
    dues.sort_by_key(|due| (wish.bench(due.spec), due.spec.ends_print()));
    let executor = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    executor.block_on(async {
        session::refuse_second_graph().await?;
        for seed in &wish.seeds {
            one_seed(&setting, &mut dues, *seed, wish).await?;
        }
        anyhow::Ok(())
    })?;
    Ok(figures(chosen, &dues))
}

fn figures(chosen: &[&FaultSpec], dues: &[Due<'_>]) -> Figures {
    let mut by_id: BTreeMap<&str, Vec<_>> = BTreeMap::new();
    for fault in chosen {
        for spec in &fault.process {
            let ours = dues.iter().find(|due| std::ptr::eq(due.spec, spec));
            let summed = ours.map(|due| {
                let figures = outcome::sum_up((&fault.id, spec), reaction(due), &due.runs);
                let told_limit_source = fault.source.filter(|_| spec.told_s.is_some());
                let figures = figures.limited_by(spec.source.or(fault.source));
                TrialFigures { told_limit_source, ..figures }
            });
            by_id.entry(&fault.id).or_default().extend(summed);
        }
    }
    let faults: Vec<FaultFigures> = chosen
        .iter()
        .filter_map(|fault| Some(FaultFigures::of(fault, "process", by_id.remove(fault.id.as_str())?)))
        .collect();
    let false_trips = faults.iter().flat_map(|fault| &fault.trials).map(|trial| trial.false_trips).sum();
    Figures { level: "process", faults, false_trips, ..Figures::default() }
}

fn reaction(due: &Due<'_>) -> Reaction {
    due.spec.reaction.unwrap_or(due.fault.reaction)
}

/// Every trial once.
async fn one_seed(setting: &Setting, dues: &mut [Due<'_>], seed: u64, wish: &Wish) -> anyhow::Result<()> {
    let mut bench = Running { session: None, seed };
    let mut newest: Option<usize> = None;
    for index in 0..dues.len() {
        let due = &mut dues[index];
        if bench.session.is_some() && !bench.serves(wish.bench(due.spec)) {
            let complaints = bench.end(wish.keep, true).await?;
            blame(dues, newest, complaints);
        }
        let due = &mut dues[index];
        let mut observed = match one(setting, &mut bench, due, wish).await {
            Ok(observed) => observed,
            Err(error) if error.to_string() == "interrupted" => return Err(error),
            Err(error) => {
                // Whatever is left of this graph is no bench for the next trial.
                bench.drop_session(true);
                Observed::failed(seed, format!("{error:#}"))
            }
        };
        observed.seed = seed;
        tell(due, &observed);
        due.runs.push(observed);
        newest = Some(index);
        if due.spec.ends_print() {
            // Where no file can be opened any more, the recorder cannot close its bag, and says so.
            let closes_bag = !matches!(due.spec.act, Act::Files { .. });
            let complaints = bench.end(wish.keep, closes_bag).await?;
            blame(dues, newest, complaints);
        }
    }
    let complaints = bench.end(wish.keep, true).await?;
    blame(dues, newest, complaints);
    Ok(())
}

/// What is wrong at the end of a graph is noted with the last trial on it.
fn blame(dues: &mut [Due<'_>], newest: Option<usize>, complaints: Vec<String>) {
    if let Some(run) = newest.and_then(|index| dues[index].runs.last_mut()) {
        run.wrong.extend(complaints);
    }
}

fn tell(due: &Due<'_>, observed: &Observed) {
    let time = |name: &str, time: Option<f64>| time.map(|time_s| format!("{name} {time_s:.2} s"));
    let times = [time("told", observed.told_s), time("reaction", observed.reaction_s)];
    let took = times.into_iter().flatten().collect::<Vec<_>>().join(", ");
    let took = if took.is_empty() { "-" } else { &took };
    let wrong =
        if observed.wrong.is_empty() { String::new() } else { format!("; {}", observed.wrong.join("; ")) };
    output::note(&format!("{} {}, seed {}: {took}{wrong}", due.fault.id, due.spec.name, observed.seed));
}

/// The graph on which the newest trial ran.
struct Running {
    session: Option<(Session, Bench)>,
    seed: u64,
}

impl Running {
    /// Whether a trial can run on it.
    fn serves(&self, wanted: Bench) -> bool {
        self.session.as_ref().is_some_and(|(_, bench)| *bench == wanted)
    }

    /// The graph, started where there is none.
    async fn session(&mut self, setting: &Setting, bench: Bench) -> anyhow::Result<&mut Session> {
        if self.session.is_none() {
            let session = Session::start(setting, self.seed, bench).await?;
            self.session = Some((session, bench));
        }
        match &mut self.session {
            Some((session, _)) => Ok(session),
            None => bail!("no graph"),
        }
    }

    /// Ends the graph in order and looks at its bag, where the recorder can close it; what did not go well.
    async fn end(&mut self, keep: bool, closes_bag: bool) -> anyhow::Result<Vec<String>> {
        let Some((session, _)) = &mut self.session else { return Ok(Vec::new()) };
        let mut complaints = session.end().await?;
        if closes_bag {
            complaints.extend(storage::complaint_of(session.graph.bag()));
        } else {
            complaints.retain(|complaint| !complaint.starts_with(storage::RECORDER));
        }
        self.drop_session(keep || !complaints.is_empty());
        Ok(complaints)
    }

    fn drop_session(&mut self, keep: bool) {
        let Some((session, _)) = self.session.take() else { return };
        if keep {
            output::note(&format!("bag and logs are kept in {}", session.graph.folder().display()));
        } else {
            session.graph.remove();
        }
    }
}

/// One trial.
async fn one(setting: &Setting, bench: &mut Running, due: &Due<'_>, wish: &Wish) -> anyhow::Result<Observed> {
    let (spec, seed) = (due.spec, bench.seed);
    if let Act::Orders { count, gap_s } = spec.act {
        return orders::run(setting, seed, count, gap_s).await;
    }
    let session = bench.session(setting, wish.bench(spec)).await?;
    session.whole().await?;
    session.until(SPREAD_S * share_of(seed), |_, _| false).await?;
    let before = Machine::look(session);
    session.take_ended();
    let mut observed = act(session, due, wish).await?;
    let ended = session.take_ended().into_iter().filter(|node| !spec.may_end(node));
    observed.wrong.extend(ended.map(|node| format!("{node} ended")));
    let foreign = Machine::look(session).foreign_since(&before);
    observed.figures.insert("foreign_cores", foreign);
    // A flood of our own wakes nobody in time either, and excuses nothing; nor do processes that spin for us.
    let bare = observed.measures.get(BARE).filter(|_| matches!(spec.act, Act::Spin { .. }));
    let by_us = matches!(spec.act, Act::Estop { spinning, .. } if spinning > 0);
    observed.excused = foreign > FOREIGN_CORES && !by_us || bare.is_some_and(|late| is_uneven(late));
    Ok(observed)
}

/// Whether the machine itself wakes a thread so late that a permit cannot be in time.
fn is_uneven(bare_late_s: &[f64]) -> bool {
    Measure::of(BARE, bare_late_s.to_vec(), Bound::default())
        .p999_s
        .is_some_and(|late_s| late_s > BARE_LATE_S)
}

/// What a trial does.
async fn act(session: &mut Session, due: &Due<'_>, wish: &Wish) -> anyhow::Result<Observed> {
    let soak_s = |for_s: f64| wish.soak_s.unwrap_or(for_s);
    match &due.spec.act {
        Act::Kill(_) | Act::Stop { .. } => node_fault::run(session, due.spec, reaction(due)).await,
        Act::Calls { rate_hz, for_s } => calls::flood(session, *rate_hz, *for_s).await,
        Act::Estop { calls, spinning } => stops::estops(session, *calls, *spinning).await,
        Act::Spin { processes, for_s } => load::spin(session, *processes, *for_s).await,
        Act::Flood { rate_hz, for_s, growth_mib } => {
            load::flood(session, (*rate_hz, *for_s), *growth_mib).await
        }
        Act::Soak { for_s, slope_mib_h } => load::soak(session, soak_s(*for_s), *slope_mib_h).await,
        Act::Memory { node, for_s } => limits::memory(session, node, *for_s).await,
        Act::Files { for_s } => limits::files(session, *for_s).await,
        Act::StepClock { to_s, each_s } => storage::step_clock(session, reaction(due), (to_s, *each_s)).await,
        Act::SlowDisk { delay_s, for_s } => storage::slow(session, *delay_s, *for_s).await,
        Act::FullDisk { for_s, answer } => storage::full(session, (*for_s, *answer)).await,
        Act::Orders { .. } => bail!("this trial has graphs of its own"),
    }
}
