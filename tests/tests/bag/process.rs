//! Processes and folders that do not outlive their test.

use crate::{Counts, counts};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Lines};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

/// Variable that makes this program a publisher.
pub(crate) const ROLE: &str = "FDM_TEST_PUBLISHER";

/// A DDS domain that no other test process uses at the same time (ports of domains up to 101 lie below the ephemeral
/// ones).
#[derive(Clone, Copy)]
pub(crate) struct Domain(u32);

impl Domain {
    pub(crate) fn new(test: u32) -> Self {
        Self(20 + (std::process::id() * 3 + test) % 80)
    }

    /// A command in this domain.
    pub(crate) fn command(self, program: &Path) -> Command {
        let mut command = Command::new(program);
        command.env("ROS_DOMAIN_ID", self.0.to_string()).env_remove("RUST_LOG");
        command
    }
}

/// A process that is killed with its test.
struct Process(Child);

impl Drop for Process {
    fn drop(&mut self) {
        _ = self.0.kill();
        _ = self.0.wait();
    }
}

/// The folder of a bag.
pub(crate) struct Bag {
    name: String,
    path: PathBuf,
}

/// A program of this build.
pub(crate) fn program(name: &str) -> PathBuf {
    let test = std::env::current_exe().unwrap();
    let program = test.parent().unwrap().parent().unwrap().join(name);
    assert!(
        program.exists(),
        "{} is missing: build it first with cargo build --workspace --bins",
        program.display()
    );
    program
}

/// Root of the repository.
pub(crate) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_path_buf()
}

impl Bag {
    pub(crate) fn new(test: &str) -> Self {
        let name = format!("bag_test_{test}_{}", std::process::id());
        let path = std::env::temp_dir().join(&name);
        _ = std::fs::remove_dir_all(&path);
        Self { name, path }
    }

    /// Name of a finished file.
    pub(crate) fn file(&self, number: u32) -> String {
        format!("{}_{number}.mcap", self.name)
    }

    /// What the recorder reported of the bag.
    pub(crate) fn reported(&self) -> Value {
        let text = std::fs::read_to_string(self.path.join("counts.json")).unwrap();
        serde_json::from_str(&text).unwrap()
    }

    /// Its folder.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Bytes of the first file while it is written.
    pub(crate) fn active_bytes(&self) -> u64 {
        self.active_bytes_of(0)
    }

    /// Bytes of a file while it is written.
    pub(crate) fn active_bytes_of(&self, number: u32) -> u64 {
        let file = self.path.join(format!("{}.active", self.file(number)));
        std::fs::metadata(file).map_or(0, |found| found.len())
    }

    /// Log times in a finished file `[ns]`.
    pub(crate) fn log_times(&self, number: u32) -> Vec<u64> {
        let bytes = std::fs::read(self.path.join(self.file(number))).unwrap();
        mcap::MessageStream::new(&bytes).unwrap().map(|message| message.unwrap().log_time).collect()
    }

    /// Payloads of the finished files by topic, in their order.
    pub(crate) fn payloads(&self) -> BTreeMap<String, Vec<Vec<u8>>> {
        let mut payloads = BTreeMap::<_, Vec<_>>::new();
        for number in 0.. {
            let Ok(bytes) = std::fs::read(self.path.join(self.file(number))) else { return payloads };
            for message in mcap::MessageStream::new(&bytes).unwrap() {
                let message = message.unwrap();
                let topic = message.channel.topic.clone();
                payloads.entry(topic).or_default().push(message.data.into_owned());
            }
        }
        payloads
    }

    /// What the Python readers find.
    pub(crate) fn read(&self) -> Value {
        count(&[self.path.as_os_str()])
    }

    /// Whole records in the file that a killed recorder left.
    pub(crate) fn held_by_active(&self, number: u32) -> Counts {
        self.held_by(&self.path.join(format!("{}.active", self.file(number))))
    }

    /// Whole records in a file that was cut off, up to the first that is not.
    pub(crate) fn held_by(&self, file: &Path) -> Counts {
        counts(&count(&["--active".as_ref(), file.as_os_str()]))
    }
}

impl Drop for Bag {
    fn drop(&mut self) {
        _ = std::fs::remove_dir_all(&self.path);
    }
}

/// Runs a script of tests/readers; standard output.
pub(crate) fn python(script: &str, arguments: &[&std::ffi::OsStr]) -> Vec<u8> {
    let python = root().join("target/venv/bin/python");
    assert!(
        python.exists(),
        "{} is missing: launch_scripts/test.sh makes it, or: python3 -m venv target/venv && \
         target/venv/bin/pip install -r tests/requirements.txt",
        python.display()
    );
    let script = root().join("tests/readers").join(script);
    let output = Command::new(python).arg(script).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// Runs the Python readers.
fn count(arguments: &[&std::ffi::OsStr]) -> Value {
    serde_json::from_slice(&python("count.py", arguments)).unwrap()
}

/// The recorder under test.
pub(crate) struct Recorder(Process);

impl Recorder {
    /// Starts the recorder.
    pub(crate) fn start(bag: &Bag, domain: Domain) -> Self {
        Self::start_by(bag, |program| domain.command(program))
    }

    /// Starts the recorder on a disk that takes no file beyond so many KiB: writing further fails.
    pub(crate) fn start_on_full_disk(bag: &Bag, domain: Domain, kib: u32) -> Self {
        Self::start_by(bag, |program| {
            // A file that is too large would end the process by a signal; a full disk only answers.
            let script = format!("trap '' XFSZ; ulimit -f {kib}; exec \"$0\" \"$@\"");
            let mut command = domain.command(Path::new("bash"));
            command.args(["-c", &script]).arg(program);
            command
        })
    }

    /// Waits until it writes to the bag: it listens then.
    pub(crate) fn listens(&mut self, bag: &Bag) {
        while !bag.path.join("metadata.yaml").is_file() {
            assert_eq!(self.0.0.try_wait().unwrap(), None, "the recorder ended");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn start_by(bag: &Bag, command: impl FnOnce(&Path) -> Command) -> Self {
        let child = command(&program("bag_recorder"))
            .args(["--ros-args", "--params-file"])
            .arg(root().join("config/bag_recorder.param.yaml"))
            .args(["-p", &format!("bag_dir:={}", bag.path.display()), "-p", "sync_period_s:=0.1"])
            .spawn()
            .unwrap();
        Self(Process(child))
    }

    /// SIGTERM: an orderly end within 2 s.
    pub(crate) fn stop(&mut self) {
        let child = &mut self.0.0;
        kill_process(Pid::from_child(child), Signal::TERM).unwrap();
        let begin = Instant::now();
        loop {
            if let Some(status) = child.try_wait().unwrap() {
                assert_eq!(status.code(), Some(0), "{status}");
                return;
            }
            assert!(begin.elapsed() < Duration::from_secs(2), "the recorder does not end within 2 s");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Whether it ended by itself, and not well, before so long.
    pub(crate) fn fails_within(&mut self, longest: Duration) -> bool {
        let begin = Instant::now();
        while begin.elapsed() < longest {
            if let Some(status) = self.0.0.try_wait().unwrap() {
                return status.code().is_some_and(|code| code != 0);
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        false
    }

    /// SIGKILL.
    pub(crate) fn kill(&mut self) {
        self.0.0.kill().unwrap();
        self.0.0.wait().unwrap();
    }
}

/// The process that publishes; it writes a line of counts as JSON per report.
pub(crate) struct Publisher {
    process: Process,
    lines: Lines<BufReader<ChildStdout>>,
}

/// What a line of counts begins with.
pub(crate) const COUNTS: &str = "counts: ";
/// Key among the counts: how often the recorder began anew, from 1.
pub(crate) const LIFE_KEY: &str = "life";

impl Publisher {
    /// Starts this program again in a role.
    pub(crate) fn start(domain: Domain, role: &str) -> Self {
        let mut child = domain
            .command(&std::env::current_exe().unwrap())
            .args(["--ignored", "--exact", "publisher_process", "--nocapture", "--test-threads=1"])
            .env(ROLE, role)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap()).lines();
        Self { process: Process(child), lines }
    }

    /// The next counts.
    fn next(&mut self) -> Counts {
        for line in self.lines.by_ref() {
            let line = line.unwrap();
            if let Some((_, text)) = line.split_once(COUNTS) {
                return serde_json::from_str(text).unwrap();
            }
        }
        panic!("the publisher ended: {:?}", self.process.0.wait())
    }

    /// Role `known`: what was sent, once the recorder has all of it.
    pub(crate) fn sent(mut self) -> Counts {
        self.next()
    }

    /// Role `stream`: what the recorder says it has written, once that is at least `least` messages of each topic in
    /// its life number `life`.
    pub(crate) fn acknowledged(&mut self, life: u64, least: u64) -> Counts {
        loop {
            let mut counts = self.next();
            if counts.remove(LIFE_KEY) == Some(life) && counts.values().all(|count| *count >= least) {
                return counts;
            }
        }
    }
}
