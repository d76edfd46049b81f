//! The node processes of one graph: started, signalled, limited, tended as `fdm up` does, ended.

use super::shim::Shim;
use crate::config::ConfigDir;
use crate::faults::catalogue::Bench;
use crate::up::UpArgs;
use crate::up::fleet::{Fleet, Happening, Recipe};
use crate::up::hearing::Hearing;
use crate::up::recipes::Plan;
use anyhow::Context;
use models::units::Seconds;
use rustix::process::{Pid, Resource, Rlimit, Signal, kill_process, prlimit};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// The node that ends last: it records the others' last words.
const LAST: &str = "bag_recorder";
/// Numbers the graphs of this process.
static STARTED: AtomicU32 = AtomicU32::new(0);

/// What graphs are started with.
pub(super) struct Setting {
    /// Parameter files.
    pub(super) config: ConfigDir,
    /// What is printed.
    pub(super) gcode: PathBuf,
    /// What is printed for a soak.
    pub(super) long_gcode: PathBuf,
}

/// The processes of one graph; none outlives this value.
pub(super) struct Graph {
    /// One fleet a node: they are started one by one.
    fleets: Vec<Fleet>,
    hearing: Hearing,
    folder: PathBuf,
    plan: Plan,
    /// The graph's disk and wall clock, where they are in our hand.
    pub(super) shim: Option<Shim>,
}

impl Graph {
    /// Prepares a graph of which nothing runs yet, and how its nodes are started.
    pub(super) fn prepare(setting: &Setting, seed: u64, bench: Bench) -> anyhow::Result<(Self, Vec<Recipe>)> {
        let number = STARTED.fetch_add(1, Ordering::Relaxed);
        let folder = std::env::temp_dir().join(format!("fdm_faults_{}_{number}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
        let gcode = if bench == Bench::Long { &setting.long_gcode } else { &setting.gcode };
        let args = UpArgs { host_clock: bench == Bench::HostClock, ..arguments(gcode, &folder, seed) };
        let material = crate::job::GcodeFile::read(&args.gcode, &setting.config.motion()?, None)?.material();
        let plan = Plan::new(&args, &setting.config, &material, "mpc")?;
        plan.check()?;
        let mut recipes = plan.recipes()?;
        let shim = if bench == Bench::Shimmed { Some(Shim::build(&folder)?) } else { None };
        if let Some(shim) = &shim {
            // The printer's firmware has a clock of its own.
            let ours = recipes.iter_mut().filter(|recipe| recipe.replaceable);
            ours.for_each(|recipe| shim.wrap(recipe));
        }
        Ok((Self { fleets: Vec::new(), hearing: Hearing::default(), folder, plan, shim }, recipes))
    }

    /// Refuses parameters that no node takes and programs that are not there, before anything is called a miss.
    pub(super) fn check(setting: &Setting) -> anyhow::Result<()> {
        for gcode in [&setting.gcode, &setting.long_gcode] {
            let material = crate::job::GcodeFile::read(gcode, &setting.config.motion()?, None)?.material();
            // Nothing is written there, nor looked for in the folder that a person happens to be in.
            let nowhere = std::env::temp_dir().join(format!("fdm_faults_{}_check", std::process::id()));
            let plan = Plan::new(&arguments(gcode, &nowhere, 1), &setting.config, &material, "mpc")?;
            plan.check()?;
            _ = plan.processes()?;
        }
        Ok(())
    }

    /// Starts a node.
    pub(super) fn launch(&mut self, recipe: Recipe) -> anyhow::Result<()> {
        let name = recipe.name;
        let fleet = Fleet::start(vec![recipe], &self.plan.logs()).with_context(|| name.to_owned())?;
        self.fleets.push(fleet);
        Ok(())
    }

    /// Looks after every process and every heart.
    pub(super) fn tend(&mut self, now: Seconds) -> Vec<Happening> {
        let mut happenings: Vec<Happening> =
            self.fleets.iter_mut().flat_map(|fleet| fleet.tend(now)).collect();
        for happening in &happenings {
            if let Some(name) = happening.ended() {
                self.hearing.forget(name);
            }
        }
        happenings.extend(self.hearing.look(now));
        happenings
    }

    /// A heart beats.
    pub(super) fn beat(&mut self, now: Seconds, name: &str, session: u64) -> Option<Happening> {
        self.hearing.beat(now, name, session)
    }

    /// Every node that was started, whether it runs or not.
    pub(super) fn started(&self) -> impl Iterator<Item = &'static str> {
        self.fleets.iter().flat_map(Fleet::names)
    }

    /// Processes by node.
    pub(super) fn pids(&self) -> BTreeMap<&'static str, Pid> {
        let pids = self.fleets.iter().flat_map(Fleet::pids);
        pids.filter_map(|(name, pid)| Some((name, Pid::from_raw(i32::try_from(pid).ok()?)?))).collect()
    }

    fn pid(&self, node: &str) -> anyhow::Result<Pid> {
        self.pids().get(node).copied().with_context(|| format!("{node} does not run"))
    }

    /// A signal to the process of a node.
    pub(super) fn signal(&self, node: &str, signal: Signal) -> anyhow::Result<()> {
        kill_process(self.pid(node)?, signal).with_context(|| format!("a signal to {node}"))
    }

    /// A limit of the running process of a node; the next one does not have it.
    pub(super) fn limit(&self, node: &str, resource: Resource, most: u64) -> anyhow::Result<()> {
        let limit = Rlimit { current: Some(most), maximum: Some(most) };
        _ = prlimit(Some(self.pid(node)?), resource, limit).with_context(|| format!("a limit of {node}"))?;
        Ok(())
    }

    /// Resident memory by node `[MiB]`.
    pub(super) fn resident_mib(&self) -> BTreeMap<&'static str, f64> {
        self.pids().into_iter().filter_map(|(name, pid)| Some((name, status_mib(pid, "VmRSS:")?))).collect()
    }

    /// Address space of a node, which its limit is about `[MiB]`; `None` where it does not run.
    pub(super) fn virtual_mib(&self, node: &str) -> Option<f64> {
        status_mib(self.pid(node).ok()?, "VmSize:")
    }

    /// Whether it runs on the host's clock, which is the observer's too.
    pub(super) fn on_host_clock(&self) -> bool {
        self.plan.host_clock
    }

    /// Folder of the bag.
    pub(super) fn bag(&self) -> &Path {
        &self.plan.bag
    }

    /// Asks all to end: first all but the recorder.
    pub(super) fn ask_to_end(&self, with_recorder: bool) {
        self.fleets.iter().for_each(|fleet| fleet.ask_to_end((!with_recorder).then_some(LAST)));
    }

    /// Whether all have ended, or all but the recorder.
    pub(super) fn all_ended(&mut self, with_recorder: bool) -> bool {
        let except = (!with_recorder).then_some(LAST);
        self.fleets.iter_mut().all(|fleet| fleet.all_ended(except))
    }

    /// Ends by force what still runs; its names.
    pub(super) fn kill_rest(&mut self) -> Vec<&'static str> {
        self.fleets.iter_mut().flat_map(|fleet| fleet.kill_rest(None)).collect()
    }

    /// How those ended that did not end well.
    pub(super) fn ended_badly(&mut self) -> Vec<(&'static str, String)> {
        self.fleets.iter_mut().flat_map(Fleet::ended_badly).collect()
    }

    /// Leaves nothing on the disk.
    pub(super) fn remove(&self) {
        _ = std::fs::remove_dir_all(&self.folder);
    }

    /// Where bag and logs are.
    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }
}

/// `fdm up --warm --stay`, in a folder of its own.
fn arguments(gcode: &Path, folder: &Path, seed: u64) -> UpArgs {
    UpArgs {
        gcode: gcode.to_owned(),
        config: None,
        bag: Some(folder.join("bag")),
        speed: 1.0,
        control: vec!["mpc".to_owned()],
        mode: "act".to_owned(),
        host: "native".to_owned(),
        advance: "material".to_owned(),
        scenario: "nominal".to_owned(),
        material: None,
        layers: None,
        warm: true,
        with: Vec::new(),
        seed,
        namespace: super::NAMESPACE.to_owned(),
        allow_fault_injection: false,
        host_clock: false,
        dry_run: false,
        stay: true,
        json: None,
    }
}

/// What the system tells of a process's memory `[MiB]`.
fn status_mib(pid: Pid, field: &str) -> Option<f64> {
    let status = std::fs::read_to_string(format!("/proc/{}/status", pid.as_raw_nonzero())).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(field))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok()? / 1024.0)
}

/// Processes that count until they are dropped, or until who started them has died.
pub(super) struct Spinners(Vec<std::process::Child>);

impl Spinners {
    /// Starts so many.
    pub(super) fn start(count: u32) -> anyhow::Result<Self> {
        let script = format!(
            "while kill -0 {}; do i=0; while [ $i -lt 100000 ]; do i=$((i+1)); done; done",
            std::process::id()
        );
        let mut spinners = Self(Vec::new());
        for _ in 0..count {
            let mut command = std::process::Command::new("/bin/sh");
            command.args(["-c", &script]).stdin(std::process::Stdio::null());
            command.stderr(std::process::Stdio::null());
            spinners.0.push(command.spawn().context("/bin/sh")?);
        }
        Ok(spinners)
    }
}

impl Drop for Spinners {
    fn drop(&mut self) {
        for child in &mut self.0 {
            _ = child.kill();
            _ = child.wait();
        }
    }
}
