//! `fdm sim --bag`, `fdm play` and `fdm record`, and signals to their process groups.

use crate::process::{Bag, Domain, program, root};
use rustix::process::{Pid, Signal, kill_process_group, test_kill_process_group};
use serde_json::Value;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Runs to the end; standard output.
fn done(command: &mut Command) -> Vec<u8> {
    let output = command.current_dir(root()).output().unwrap();
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// Records a print of one layer in virtual time.
pub(crate) fn simulate(bag: &Bag) {
    let print = ["sim", "tests/data/gcode/prusa_cube_pla_marlin_relE.gcode", "--layers", "1", "--bag"];
    done(Command::new(program("fdm")).args(print).arg(bag.path()));
}

/// Plays a bag, commands and permits too; what is told of it.
pub(crate) fn play(bag: &Bag, domain: Domain) -> Value {
    let how = ["--rate", "20", "--commands", "--wait", "5", "--json", "-"];
    let told = done(domain.command(&program("fdm")).arg("play").arg(bag.path()).args(how));
    serde_json::from_slice(&told).unwrap()
}

/// Plays a bag, or tries to; code and what is told on standard error.
pub(crate) fn tried(bag: &Bag, domain: Domain, how: &[&str]) -> (Option<i32>, String) {
    let mut command = domain.command(&program("fdm"));
    let output = command.current_dir(root()).arg("play").arg(bag.path()).args(how).output().unwrap();
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// A command of `fdm` with a process group of its own, as a shell gives it one.
pub(crate) struct Group(Option<Child>);

impl Group {
    /// Plays a bag, commands and permits too, at a pace.
    pub(crate) fn play(bag: &Bag, domain: Domain, rate: &str) -> Self {
        let how = ["--rate", rate, "--commands", "--wait", "5", "--json", "-"];
        Self::start(domain.command(&program("fdm")).arg("play").arg(bag.path()).args(how))
    }

    /// Plays a bag with its clock, at a rate, from so many seconds on, so often.
    pub(crate) fn clock(bag: &Bag, domain: Domain, (rate, start_s, times): (f64, f64, u32)) -> Self {
        let [rate, start, times] = [rate.to_string(), start_s.to_string(), times.to_string()];
        let how = ["--clock", "--rate", &rate, "--start", &start, "--times", &times, "--json", "-"];
        Self::start(domain.command(&program("fdm")).arg("play").arg(bag.path()).args(how))
    }

    /// Records all.
    pub(crate) fn record(bag: &Bag, domain: Domain) -> Self {
        Self::start(domain.command(&program("fdm")).args(["record", "--all", "--bag"]).arg(bag.path()))
    }

    fn start(command: &mut Command) -> Self {
        let child = command.current_dir(root()).stdin(Stdio::null()).stdout(Stdio::piped());
        Self(Some(child.process_group(0).spawn().unwrap()))
    }

    fn pid(&self) -> Pid {
        Pid::from_child(self.0.as_ref().unwrap())
    }

    /// What a terminal sends.
    pub(crate) fn signal(&self, signal: Signal) {
        kill_process_group(self.pid(), signal).unwrap();
    }

    /// Whether the process has taken a signal for its own affair.
    pub(crate) fn listens_to(&self, signal: Signal) -> bool {
        let status =
            std::fs::read_to_string(format!("/proc/{}/status", self.pid().as_raw_nonzero())).unwrap();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
        u64::from_str_radix(caught.trim(), 16).unwrap() >> (signal.as_raw() - 1) & 1 == 1
    }

    /// Waits until the process stands still, as after Ctrl-Z.
    pub(crate) fn stands_still(&self) {
        let status = format!("/proc/{}/status", self.pid().as_raw_nonzero());
        until(|| std::fs::read_to_string(&status).unwrap().contains("State:\tT"));
    }

    /// Waits for its end; the code, what it wrote, and that nothing of its group is left.
    pub(crate) fn ended(mut self) -> (Option<i32>, Vec<u8>) {
        let group = self.pid();
        let output = self.0.take().unwrap().wait_with_output().unwrap();
        assert!(test_kill_process_group(group).is_err(), "a process of the group is left");
        (output.status.code(), output.stdout)
    }
}

/// A test that fails leaves nothing behind that plays or records.
impl Drop for Group {
    fn drop(&mut self) {
        if let Some(mut child) = self.0.take() {
            _ = kill_process_group(Pid::from_child(&child), Signal::KILL);
            _ = child.wait();
        }
    }
}

/// Waits for something that happens in the end; a test that waits in vain fails here.
pub(crate) fn until(happened: impl Fn() -> bool) {
    let begin = Instant::now();
    while !happened() {
        assert!(begin.elapsed() < Duration::from_secs(60), "nothing happens");
        std::thread::sleep(Duration::from_millis(20));
    }
}
