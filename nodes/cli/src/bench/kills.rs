//! Kills at random moments: what a recorder has acknowledged is in the recovered bag; what a loss of power would cost.

use super::load::Told;
use super::proc;
use super::{Benchmark, RecorderArgs};
use crate::report::bag::Bag;
use crate::report::scan::{Ended, Raw, Visitor, scan};
use anyhow::{Context, bail, ensure};
use rand::{Rng, SeedableRng};
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Earliest and latest moment of a kill `[s]`: several files, syncs and compactions lie in between.
const MOMENTS_S: (f64, f64) = (0.1, 4.0);
/// What a loss of power may cost `[s]`.
const POWER_S: f64 = 1.0;
/// Counts a bag with an independent reader.
const READER: &str = "import sys
from rosbags.rosbag2 import Reader
with Reader(sys.argv[1]) as reader:
    print(sum(1 for _ in reader.messages()), reader.message_count)";

/// What became of one bag.
#[derive(Default)]
struct Outcome {
    acknowledged: u64,
    lost: u64,
    unequal: u64,
    power_s: f64,
    /// The kill came before there was a file.
    early: u64,
}

#[allow(clippy::cast_precision_loss, reason = "counts of messages")]
pub(super) fn run(args: &RecorderArgs, kills: u32) -> anyhow::Result<Vec<Benchmark>> {
    let folder = match &args.keep {
        Some(folder) => folder.clone(),
        None => proc::scratch("kills")?,
    };
    std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    let python = args.python.is_file().then_some(args.python.as_path());
    let mut random = rand::rngs::StdRng::seed_from_u64(args.seed);
    let mut sum = Outcome::default();
    for number in 0..kills {
        let moment = Duration::from_secs_f64(random.random_range(MOMENTS_S.0..MOMENTS_S.1));
        let one = once(&folder.join(format!("kill_{number}")), moment, number % 2 == 0, python)
            .with_context(|| format!("kill {number}, after {:.3} s", moment.as_secs_f64()))?;
        sum.acknowledged += one.acknowledged;
        sum.lost += one.lost;
        sum.unequal += one.unequal;
        sum.early += one.early;
        sum.power_s = sum.power_s.max(one.power_s);
    }
    if args.keep.is_none() {
        _ = std::fs::remove_dir_all(&folder);
    }
    let mut all = vec![
        Benchmark::new("kills", "-", f64::from(kills)),
        Benchmark::new("kills before there was a file", "-", sum.early as f64),
        Benchmark::new("messages acknowledged", "-", sum.acknowledged as f64),
        Benchmark::new("acknowledged messages lost", "-", sum.lost as f64).target(0.0),
        Benchmark::new("longest time lost with the power (sync simulated)", "s", sum.power_s).target(POWER_S),
    ];
    if python.is_some() {
        let unequal = Benchmark::new("bags that rosbags counts otherwise", "-", sum.unequal as f64);
        all.push(unequal.target(0.0));
    } else {
        crate::output::note(&format!("{} is missing: not read by rosbags (--python)", args.python.display()));
    }
    Ok(all)
}

/// Records until the kill, recovers, counts.
fn once(bag: &Path, moment: Duration, split: bool, python: Option<&Path>) -> anyhow::Result<Outcome> {
    let told = killed(bag, moment, split)?;
    if Bag::find(bag).is_err() {
        let told = told.imu + told.frames;
        ensure!(told == 0, "{told} messages were acknowledged, and there is no file");
        return Ok(Outcome { early: 1, ..Outcome::default() });
    }
    // Without splits: one file, and the bytes of it that were on disk.
    let power_s = if split { 0.0 } else { power_loss_s(bag, &told)? };
    let recovered = super::super::bag::recover::messages(bag)?;
    let count = count(bag)?;
    ensure!(recovered == count.total, "recovered {recovered}, read {}", count.total);
    let missing = |wanted: u64, topic: &str| wanted.saturating_sub(count.whole_to(topic));
    let lost = missing(told.imu, "data_raw") + missing(told.frames, "compressed");
    let unequal = python.map_or(Ok(false), |python| differs(python, bag, count.total))?;
    Ok(Outcome { acknowledged: told.imu + told.frames, lost, unequal: u64::from(unequal), power_s, early: 0 })
}

/// Runs the load until the kill; returns what it told last.
fn killed(bag: &Path, moment: Duration, split: bool) -> anyhow::Result<Told> {
    let mut command = Command::new(std::env::current_exe()?);
    command.args(["bench", "load", "--into", "recorder", "--seconds", "60", "--tell", "--bag"]).arg(bag);
    if split {
        command.arg("--split");
    }
    let mut child = command.stdout(Stdio::piped()).spawn()?;
    let Some(pipe) = child.stdout.take() else { bail!("no pipe") };
    let reader = std::thread::spawn(move || {
        let told = |line: String| serde_json::from_str::<Told>(&line).ok();
        // The last line may be torn: what it would have told does not count as told.
        BufReader::new(pipe).lines().map_while(Result::ok).filter_map(told).last()
    });
    let begin = Instant::now();
    while begin.elapsed() < moment && child.try_wait()?.is_none() {
        std::thread::sleep(Duration::from_micros(200));
    }
    child.kill()?;
    child.wait()?;
    Ok(reader.join().ok().flatten().unwrap_or_default())
}

/// Log time that would be lost had the power gone: the file ends where its last sync did.
fn power_loss_s(bag: &Path, told: &Told) -> anyhow::Result<f64> {
    let twin = PathBuf::from(format!("{}_power", bag.display()));
    std::fs::create_dir_all(&twin)?;
    for entry in std::fs::read_dir(bag)? {
        let path = entry?.path();
        let name = path.file_name().map(PathBuf::from).unwrap_or_default();
        if name.extension().is_some_and(|ending| ending == "active") {
            std::fs::copy(&path, twin.join(&name))?;
            let file = std::fs::OpenOptions::new().write(true).open(twin.join(&name))?;
            file.set_len(told.synced_bytes)?;
        }
    }
    let newest_s = if Bag::find(&twin).is_ok() {
        super::super::bag::recover::messages(&twin)?;
        count(&twin)?.newest_s
    } else {
        0.0
    };
    std::fs::remove_dir_all(&twin)?;
    Ok(told.newest_s - newest_s)
}

fn differs(python: &Path, bag: &Path, messages: u64) -> anyhow::Result<bool> {
    let output = Command::new(python).args(["-c", READER]).arg(bag).output()?;
    ensure!(output.status.success(), "rosbags: {}", String::from_utf8_lossy(&output.stderr));
    let wanted = format!("{messages} {messages}");
    Ok(String::from_utf8_lossy(&output.stdout).trim() != wanted)
}

/// Messages of a bag.
#[derive(Default)]
struct Count {
    total: u64,
    topics: BTreeMap<String, u64>,
    newest_s: f64,
}

impl Count {
    /// Messages of the topic with this ending.
    fn whole_to(&self, ending: &str) -> u64 {
        self.topics.iter().filter(|(topic, _)| topic.ends_with(ending)).map(|(_, count)| count).sum()
    }
}

impl Visitor for Count {
    fn message(&mut self, raw: &Raw<'_>) {
        self.total += 1;
        *self.topics.entry(raw.topic.to_owned()).or_default() += 1;
        #[allow(clippy::cast_precision_loss, reason = "seconds of a benchmark")]
        let at_s = raw.log_ns as f64 * 1e-9;
        self.newest_s = self.newest_s.max(at_s);
    }

    fn note(&mut self, _: &str, _: &BTreeMap<String, String>) {}
}

fn count(bag: &Path) -> anyhow::Result<Count> {
    let mut count = Count::default();
    for file in Bag::find(bag)?.files {
        match scan(&file, &mut count)? {
            Ended::Whole(_) => {}
            ended => bail!("{}: {ended:?}", file.display()),
        }
    }
    Ok(count)
}
