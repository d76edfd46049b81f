//! `fdm up` as a child: what it says of its node processes, signals to them, and nothing left behind.

use rustix::process::{Pid, Signal, kill_process, kill_process_group, test_kill_process};
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::time::{Duration, Instant};
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};

/// Longest orderly end: `fdm` promises 2 s for all nodes, the recorder included; one more for a busy machine.
const END: Duration = Duration::from_secs(3);
/// Pause between two looks at a child that ends.
const LOOK: Duration = Duration::from_millis(20);

/// Root of the repository.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_path_buf()
}

/// A program that was built beside the test.
pub(crate) fn program(name: &str) -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let program = test.parent().and_then(Path::parent).unwrap().join(name);
    assert!(program.is_file(), "{} is missing: cargo build --workspace --bins", program.display());
    program
}

/// Where the graph runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Network {
    /// In a network of its own that has nothing but a `lo` as it comes (C12).
    Own,
    /// In that of the test, which joins the graph itself.
    OfTheTest,
}

/// What `fdm` says of a node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Said {
    /// `<name> runs again as process <pid>`
    RunsAgain(String),
    /// Anything else.
    Other,
}

/// The running graph; none of its processes outlives the test.
pub(crate) struct Graph {
    fdm: Child,
    lines: UnboundedReceiver<String>,
    pids: BTreeMap<String, Pid>,
    prints: bool,
    said: Vec<String>,
    folder: PathBuf,
}

impl Graph {
    /// Starts a long print at real time with a printer that is warm. `fdm` leads a process group of its own.
    pub(crate) fn start(domain: &str, network: Network) -> Self {
        let folder = std::env::temp_dir().join(format!("fdm_process_faults_{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        let fdm = program("fdm");
        let mut fdm = if network == Network::Own { alone(&fdm) } else { Command::new(&fdm) };
        let mut fdm = fdm
            .current_dir(root())
            .process_group(0)
            .args(["up", "--gcode", "tests/data/gcode/prusa_cube_pla_marlin_relE.gcode", "--control", "mpc"])
            .args(["--warm", "--stay", "--bag"])
            .arg(folder.join("bag"))
            .env("ROS_DOMAIN_ID", domain)
            .env_remove("RUST_LOG")
            // A test that aborts leaves nothing behind.
            .env(runtime::STOP_WITH_PARENT, std::process::id().to_string())
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = follow(fdm.stderr.take().unwrap());
        Self { fdm, lines, pids: BTreeMap::new(), prints: false, said: Vec::new(), folder }
    }

    /// Folder of the bag.
    pub(crate) fn bag(&self) -> PathBuf {
        self.folder.join("bag")
    }

    /// The next line of `fdm`. Cancelling loses none.
    pub(crate) async fn next(&mut self) -> Said {
        match self.lines.recv().await {
            Some(line) => self.take(&line),
            None => std::future::pending().await,
        }
    }

    /// Processes that were started and not replaced.
    pub(crate) fn pids(&self) -> &BTreeMap<String, Pid> {
        &self.pids
    }

    /// Reads on until a line says so that has not been asked for before.
    pub(crate) async fn until(&mut self, what: &str) -> String {
        loop {
            if let Some(at) = self.said.iter().position(|line| line.contains(what)) {
                return self.said.drain(..=at).next_back().unwrap();
            }
            self.next().await;
        }
    }

    /// Whether `fdm` has told a progress.
    pub(crate) fn prints(&self) -> bool {
        self.prints
    }

    /// A signal to the newest process of a node.
    pub(crate) fn signal(&self, node: &str, signal: Signal) {
        kill_process(self.pids[node], signal).unwrap();
    }

    /// SIGKILL to `fdm` and every node in the same instant, as when the power is lost; waits until the last one is gone.
    pub(crate) fn lose_power(&mut self) {
        kill_process_group(Pid::from_child(&self.fdm), Signal::KILL).unwrap();
        self.fdm.wait().unwrap();
        let begin = Instant::now();
        while !self.alive().is_empty() {
            assert!(begin.elapsed() < END, "{:?} outlive their power", self.alive());
            std::thread::sleep(LOOK);
        }
    }

    /// How a running node can be started again, as it is and without a wait for who would activate it.
    pub(crate) fn command_of(&self, node: &str) -> Command {
        let line = std::fs::read(format!("/proc/{}/cmdline", self.pids[node].as_raw_nonzero())).unwrap();
        let words = String::from_utf8(line).unwrap();
        let mut words = words.trim_end_matches('\0').split('\0');
        let mut command = Command::new(words.next().unwrap());
        command.args(words).args(["-p", "autostart:=true"]).current_dir(root()).env_remove("RUST_LOG");
        command.env(runtime::STOP_WITH_PARENT, std::process::id().to_string()).stdout(Stdio::null());
        command
    }

    /// Ctrl-C, and this exit code in time: 0, or 1 where the print had failed.
    pub(crate) async fn end(&mut self, code: i32) {
        kill_process(Pid::from_child(&self.fdm), Signal::INT).unwrap();
        let begin = Instant::now();
        let status = loop {
            if let Some(status) = self.fdm.try_wait().unwrap() {
                break status;
            }
            assert!(begin.elapsed() < END, "fdm does not end within {END:?}");
            tokio::time::sleep(LOOK).await;
        };
        assert_eq!(status.code(), Some(code), "{status}");
    }

    /// Nodes whose newest process still exists.
    pub(crate) fn alive(&self) -> Vec<&String> {
        self.pids.iter().filter(|(_, pid)| test_kill_process(**pid).is_ok()).map(|(name, _)| name).collect()
    }

    fn take(&mut self, line: &str) -> Said {
        println!("  fdm: {line}");
        self.said.push(line.to_owned());
        // "12.3 % at 45 s: layer 2, act, ..."
        self.prints |= line.contains(" % at ");
        if let Some((_, list)) = line.split_once(" node processes: ") {
            self.pids = list.split(", ").filter_map(|entry| entry.split_once(' ')).map(process).collect();
            return Said::Other;
        }
        let Some((name, what)) = line.split_once(' ') else { return Said::Other };
        match what.strip_prefix("runs again as process ") {
            Some(pid) => {
                self.pids.extend([process((name, pid))]);
                Said::RunsAgain(name.to_owned())
            }
            None => Said::Other,
        }
    }
}

impl Drop for Graph {
    fn drop(&mut self) {
        // First who would start the others again.
        _ = self.fdm.kill();
        _ = self.fdm.wait();
        while let Ok(line) = self.lines.try_recv() {
            self.take(&line);
        }
        for (name, pid) in &self.pids {
            // A number may have gone to another process meanwhile.
            let executable = std::fs::read_link(format!("/proc/{}/exe", pid.as_raw_nonzero()));
            if executable.is_ok_and(|path| path.file_name().is_some_and(|file| file == name.as_str())) {
                _ = kill_process(*pid, Signal::KILL);
            }
        }
        if std::thread::panicking() {
            println!("bag and logs are kept in {}", self.folder.display());
        } else {
            _ = std::fs::remove_dir_all(&self.folder);
        }
    }
}

/// A program in a network of its own; in that of the test where the system does not let us, and then nothing is shown of
/// C12. It is said past the harness, which keeps what a test prints to itself unless it fails.
fn alone(program: &Path) -> Command {
    const LO: &str = "ip link set lo up && exec \"$0\" \"$@\"";
    let ours = ["-rn", "sh", "-c", LO];
    let works =
        Command::new("unshare").args(ours).arg("true").output().is_ok_and(|done| done.status.success());
    if !works {
        let said = "C12 is not shown: unshare -rn gives no network of its own here, the graph runs in that of the test";
        _ = writeln!(std::io::stderr(), "{said}");
        return Command::new(program);
    }
    let mut command = Command::new("unshare");
    command.args(ours).arg(program);
    command
}

fn process((name, pid): (&str, &str)) -> (String, Pid) {
    (name.to_owned(), pid.trim().parse().ok().and_then(Pid::from_raw).unwrap())
}

/// The lines of a pipe as they come; the thread ends with the pipe.
fn follow(pipe: ChildStderr) -> UnboundedReceiver<String> {
    let (sender, lines) = unbounded_channel();
    std::thread::spawn(move || {
        for line in BufReader::new(pipe).lines().map_while(Result::ok) {
            _ = sender.send(line);
        }
    });
    lines
}
