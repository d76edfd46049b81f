//! `fdm up` as a child: what it says of its node processes, and nothing left behind.

use rustix::process::{Pid, Signal, kill_process, test_kill_process};
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, ExitStatus, Stdio};
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};

/// Root of the repository.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_path_buf()
}

/// What `fdm` says of a node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Said {
    /// `<name> ended (...)`
    Ended(String),
    /// Anything else.
    Other,
}

/// The running graph; none of its processes outlives the test.
pub(crate) struct Graph {
    fdm: Child,
    lines: UnboundedReceiver<String>,
    pids: BTreeMap<String, Pid>,
    folder: PathBuf,
}

impl Graph {
    /// Starts a long print at real time with a printer that is warm.
    pub(crate) fn start() -> Self {
        let test = std::env::current_exe().unwrap();
        let program = test.parent().and_then(Path::parent).unwrap().join("fdm");
        assert!(program.is_file(), "{} is missing: cargo build --workspace --bins", program.display());
        let folder = std::env::temp_dir().join(format!("fdm_rtps_garbage_{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        let mut fdm = Command::new(program)
            .current_dir(root())
            .args(["up", "--gcode", "tests/data/gcode/prusa_cube_pla_marlin_relE.gcode", "--control", "mpc"])
            .args(["--warm", "--stay", "--bag"])
            .arg(folder.join("bag"))
            .env_remove("RUST_LOG")
            // What an allocation that fails has to say for itself would take the time that its end is measured by.
            .env_remove("RUST_BACKTRACE")
            // An observer that aborts leaves nothing behind.
            .env(runtime::STOP_WITH_PARENT, std::process::id().to_string())
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = follow(fdm.stderr.take().unwrap());
        Self { fdm, lines, pids: BTreeMap::new(), folder }
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

    /// Ctrl-C.
    pub(crate) fn interrupt(&self) {
        kill_process(Pid::from_child(&self.fdm), Signal::INT).unwrap();
    }

    /// How `fdm` ended, once it has.
    pub(crate) fn ended(&mut self) -> Option<ExitStatus> {
        self.fdm.try_wait().unwrap()
    }

    /// Nodes whose newest process still exists.
    pub(crate) fn alive(&self) -> Vec<&String> {
        self.pids.iter().filter(|(_, pid)| test_kill_process(**pid).is_ok()).map(|(name, _)| name).collect()
    }

    fn take(&mut self, line: &str) -> Said {
        println!("  fdm: {line}");
        if let Some((_, list)) = line.split_once(" node processes: ") {
            self.pids = list.split(", ").filter_map(|entry| entry.split_once(' ')).map(process).collect();
            return Said::Other;
        }
        let Some((name, what)) = line.split_once(' ') else { return Said::Other };
        if let Some(pid) = what.strip_prefix("runs again as process ") {
            self.pids.extend([process((name, pid))]);
        }
        if what.starts_with("ended (") { Said::Ended(name.to_owned()) } else { Said::Other }
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
