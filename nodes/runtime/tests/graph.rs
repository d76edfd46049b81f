//! Two processes over loopback, and a process that went deaf. Real time passes here: DDS has no other.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::print_stdout,
    reason = "helpers of tests: a failure is the test's failure; the figures are for people"
)]

use runtime::STARTED_AGAIN;
use rustix::process::{Pid, Signal, kill_process};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// A node process that does not outlive its test.
struct Process(Child);

impl Process {
    /// Starts the example `pair` in a role, in a domain of the test's own.
    fn start(role: &str, domain: u32) -> Self {
        Self::telling(role, domain, Stdio::null())
    }

    /// The same with its standard error to a place of one's own.
    fn telling(role: &str, domain: u32, told: Stdio) -> Self {
        Self::begun(Self::command(role, domain).stderr(told))
    }

    fn command(role: &str, domain: u32) -> Command {
        let tests = std::env::current_exe().unwrap();
        let pair: PathBuf = tests.parent().unwrap().parent().unwrap().join("examples/pair");
        let simulated = matches!(role, "pacer" | "sleeper");
        let mut command = Command::new(pair);
        command
            .args(["--ros-args", "-r", &format!("__node:={role}"), "-p", &format!("role:={role}")])
            .args(["-p", &format!("use_sim_time:={simulated}")])
            .env("ROS_DOMAIN_ID", domain.to_string())
            .env_remove("RUST_LOG");
        command
    }

    fn begun(command: &mut Command) -> Self {
        Self(command.spawn().unwrap())
    }

    fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.0), signal).unwrap();
    }

    /// Waits for the end; `None` where it does not come in time.
    fn ended_within(&mut self, limit: Duration) -> Option<ExitStatus> {
        let begin = Instant::now();
        while begin.elapsed() < limit {
            if let Some(status) = self.0.try_wait().unwrap() {
                return Some(status);
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        None
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        _ = self.0.kill();
        _ = self.0.wait();
    }
}

/// A domain that no other test process uses at the same time (ports of domains up to 101 lie below the ephemeral ones).
fn domain(test: u32) -> u32 {
    20 + (std::process::id() * 3 + test) % 80
}

/// Messages (decoded and raw), a latched message for a late joiner and a service cross processes on a plain `lo`, and
/// SIGTERM ends a node with exit code 0 within 2 s.
#[test]
fn messages_latched_state_and_services_cross_processes() {
    let mut talker = Process::start("talker", domain(0));
    let mut listener = Process::start("listener", domain(0));
    let status = listener.ended_within(Duration::from_secs(30)).expect("the listener hears all it waits for");
    assert_eq!(status.code(), Some(0));
    assert!(talker.0.try_wait().unwrap().is_none(), "the talker lives on");
    talker.signal(Signal::TERM);
    let status = talker.ended_within(Duration::from_secs(2)).expect("SIGTERM ends a node within 2 s");
    assert_eq!(status.code(), Some(0));
}

/// A command of a person joins, asks once and leaves: neither its request nor the answer is lost to a match that is still to come.
#[test]
fn who_asks_right_after_it_joined_is_answered_at_the_first_request() {
    let _talker = Process::start("talker", domain(8));
    for number in 0..10 {
        let mut asker = Process::start("asker", domain(8));
        let status = asker.ended_within(Duration::from_secs(30)).expect("it has an answer or none in 5 s");
        assert_eq!(status.code(), Some(0), "asker {number}");
    }
}

/// Until a process is no longer young: before that it is given more time to hear itself (`self_loop/silence.rs`).
const YOUNG: Duration = Duration::from_secs(7);
/// C5 asks for 1 s. Its own test in `self_loop/silence.rs` holds the watchdog to that, pass by pass; here a debug process on
/// a shared machine has to be given the processor for these passes and for its end, and gets as long again.
const DEAF: Duration = Duration::from_secs(2);

/// C4, C5: SIGSTOP and SIGCONT end the middleware's event loops; the process notices and ends.
#[test]
fn a_process_that_went_deaf_ends_itself() {
    let mut talker = Process::start("talker", domain(1));
    let mut listener = Process::start("listener", domain(1));
    assert!(
        listener.ended_within(Duration::from_secs(30)).is_some(),
        "the talker works before it is stopped"
    );
    talker.signal(Signal::STOP);
    assert!(talker.ended_within(YOUNG).is_none());
    talker.signal(Signal::CONT);
    let deaf = Instant::now();
    let status = talker.ended_within(DEAF).expect("a deaf process ends itself in time");
    println!("ended {:.2} s after it went on", deaf.elapsed().as_secs_f64());
    assert_eq!(status.code(), Some(runtime::DRIVEN_OUT.into()), "through no fault of its own");
}

/// X1: a process in a crowd of participants leaves to come back without them, also where it does not come to its end by
/// itself.
#[test]
fn a_process_in_a_crowd_ends_although_it_hangs() {
    let again = |role| Process::begun(Process::command(role, domain(7)).env(STARTED_AGAIN, "1"));
    let (mut talker, mut stubborn) = (again("talker"), again("stubborn"));
    let mut listener = Process::start("listener", domain(7));
    assert!(listener.ended_within(Duration::from_secs(30)).is_some(), "both are in the graph");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/rtps_fuzz.py");
    let crowd = Command::new("python3")
        .arg(script)
        .args(["--kind", "participants", "--count", "1200", "--each", "--nodes", "pair"])
        .args(["--domain", &domain(7).to_string()])
        .stdout(Stdio::null())
        .status();
    assert!(crowd.unwrap().success());
    for process in [&mut talker, &mut stubborn] {
        let status = process.ended_within(Duration::from_secs(10)).expect("it leaves");
        assert_eq!(status.code(), Some(runtime::DRIVEN_OUT.into()), "through no fault of its own");
    }
}

/// A stopped terminal, a pipe that nobody reads: the lines are lost, the node is not held up. Who reads gets them.
#[test]
fn a_node_does_not_wait_for_who_reads_its_lines() {
    let mut unread = Process::telling("chatterer", domain(4), Stdio::piped());
    let status = unread.ended_within(Duration::from_secs(30)).expect("it ends though nobody reads");
    assert_eq!(status.code(), Some(0));
    let mut read = Process::telling("teller", domain(4), Stdio::piped());
    let mut text = String::new();
    read.0.stderr.take().unwrap().read_to_string(&mut text).unwrap();
    assert_eq!(read.ended_within(Duration::from_secs(30)).unwrap().code(), Some(0));
    let told = |line: &str| line.split_once(" line ")?.1.split_once(" of 4000, ")?.0.parse().ok();
    let lines: Vec<u32> = text.lines().filter_map(told).collect();
    assert!(lines.iter().copied().eq(0..4000), "{} lines, each once and in order", lines.len());
}

/// An end that is demanded of a process that has not joined the graph yet is an end in order: launch files and `fdm up`
/// take another exit code for a failure.
#[test]
fn a_node_that_is_interrupted_while_it_starts_ends_well() {
    let turns = std::env::temp_dir().join(format!("fdm_turns_{}", std::process::id()));
    std::fs::create_dir_all(&turns).unwrap();
    // Who takes the turn of the domain keeps the others from joining for 3 s.
    let path = turns.join(format!("fdm_loop_domain_{}.lock", domain(5)));
    let turn = std::fs::File::create(&path).unwrap();
    turn.lock().unwrap();
    let mut talker = Process::begun(Process::command("talker", domain(5)).env("TMPDIR", &turns));
    let files = format!("/proc/{}/fd", talker.0.id());
    let waits = || {
        let files = std::fs::read_dir(&files).unwrap();
        files.flatten().any(|file| std::fs::read_link(file.path()).is_ok_and(|file| file == path))
    };
    let begin = Instant::now();
    while !waits() {
        assert!(begin.elapsed() < Duration::from_secs(10), "it waits for its turn");
        std::thread::sleep(Duration::from_millis(1));
    }
    talker.signal(Signal::INT);
    let ended = talker.ended_within(Duration::from_secs(10)).expect("it ends");
    assert_eq!(ended.code(), Some(0), "{ended}");
    drop(turn);
    std::fs::remove_dir_all(turns).unwrap();
}

/// `/clock` drives the timers of another process, faster than real time.
#[test]
fn simulated_time_drives_the_timers_of_another_process() {
    let mut sleeper = Process::start("sleeper", domain(3));
    let _pacer = Process::start("pacer", domain(3));
    let status = sleeper.ended_within(Duration::from_secs(15)).expect("20 simulated seconds pass in 2");
    assert_eq!(status.code(), Some(0));
}

/// C8: who else tells a time is told as that, and is not believed.
#[test]
fn a_second_clock_is_told_and_does_not_count() {
    let mut sleeper = Process::telling("sleeper", domain(6), Stdio::piped());
    let _owner = Process::start("pacer", domain(6));
    let _second = Process::start("pacer", domain(6));
    let status = sleeper.ended_within(Duration::from_secs(15)).expect("20 simulated seconds pass in 2");
    let mut told = String::new();
    sleeper.0.stderr.take().unwrap().read_to_string(&mut told).unwrap();
    assert_eq!(status.code(), Some(0), "{told}");
    assert_eq!(told.matches("a second publisher of /clock").count(), 1, "{told}");
    assert!(!told.contains("jumped back"), "{told}");
}

/// Wrong arguments and parameters are the user's to mend: exit code 2.
#[test]
fn refused_arguments_and_parameters_end_with_code_2() {
    let mut singer = Process::start("singer", domain(2));
    assert_eq!(singer.ended_within(Duration::from_secs(10)).unwrap().code(), Some(2));
}
