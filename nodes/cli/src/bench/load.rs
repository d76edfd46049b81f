//! The load of the benchmarks: 2000 accelerations and 30 frames of 300 kB a second, to a recorder or over DDS.

use crate::output;
use bag_recorder::folder::Folder;
use bag_recorder::params::{Room, Snapshot, Split};
use bag_recorder::tally::Tally;
use bag_recorder::writer::{Item, Queue, Recorder, Sample, Settings};
use clap::Args;
use fdm_loop_msgs::{CompressedImage, Header, Imu};
use models::units::Seconds;
use rand::{RngCore, SeedableRng};
use runtime::{Args as NodeArgs, Node, topics};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Accelerations a second.
pub(super) const IMU_HZ: f64 = 2000.0;
/// Frames a second.
pub(super) const FRAME_HZ: f64 = 30.0;
/// Size of a frame `[byte]`.
pub(super) const FRAME: usize = 300_000;
/// Real time between two looks at what is due.
const LOOK: Duration = Duration::from_millis(1);

/// A process of the benchmarks.
#[derive(Debug, Args)]
pub(crate) struct LoadArgs {
    /// Into a recorder of this process, or over DDS.
    #[arg(long, value_parser = ["recorder", "dds"])]
    into: String,
    /// Folder of the bag.
    #[arg(long, default_value = "bag")]
    bag: PathBuf,
    #[arg(long)]
    seconds: f64,
    /// As fast as it goes.
    #[arg(long)]
    unpaced: bool,
    /// Tell what is acknowledged, on and on, and split the bag every few seconds where `--split` is given.
    #[arg(long)]
    tell: bool,
    #[arg(long)]
    split: bool,
}

/// What a run took.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub(super) struct Took {
    pub(super) messages: u64,
    pub(super) dropped: u64,
    pub(super) wall_s: f64,
    pub(super) cpu_s: f64,
    /// With compacting the whole bag.
    pub(super) cpu_all_s: f64,
    pub(super) peak_mib: f64,
}

/// What a recorder has acknowledged.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Told {
    pub(super) imu: u64,
    pub(super) frames: u64,
    pub(super) synced_bytes: u64,
    /// Log time of the newest message that was handed over `[s]`.
    pub(super) newest_s: f64,
}

/// An acceleration as a bag stores it.
pub(super) fn imu(at_s: f64) -> Imu {
    Imu { header: Header::at(at_s), ..Imu::default() }
}

/// A frame that does not compress, as pictures do not.
pub(super) fn frame(at_s: f64) -> CompressedImage {
    let mut data = vec![0; FRAME];
    rand::rngs::StdRng::seed_from_u64(1).fill_bytes(&mut data);
    CompressedImage { header: Header::at(at_s), format: "jpeg".to_owned(), data }
}

pub(super) fn run(args: &LoadArgs) -> anyhow::Result<()> {
    if args.into == "dds" {
        return tokio::runtime::Builder::new_current_thread().enable_all().build()?.block_on(over_dds(args));
    }
    let tally = Arc::new(Tally::new(2));
    let recorder = start(args, &tally)?;
    let queue = recorder.queue();
    let begin = Instant::now();
    let mut load = Load::new();
    if args.unpaced {
        load.flood(&queue, args.seconds, begin)
    } else {
        load.pace(&queue, args, &tally, begin)?
    }
    drop(queue);
    let (wall_s, cpu_s) = (begin.elapsed().as_secs_f64(), own_cpu_s());
    recorder.finish()?;
    let took = Took {
        messages: tally.written(),
        dropped: load.dropped,
        wall_s,
        cpu_s,
        cpu_all_s: own_cpu_s(),
        peak_mib: super::proc::peak_mib(std::process::id()).unwrap_or(0.0),
    };
    output::line(&serde_json::to_string(&took)?)
}

fn own_cpu_s() -> f64 {
    super::proc::cpu_s(std::process::id()).unwrap_or(0.0)
}

/// A recorder with the shipped limits.
fn start(args: &LoadArgs, tally: &Arc<Tally>) -> anyhow::Result<Recorder> {
    let topic = |info: &topics::TopicInfo| bag_recorder::recorded(format!("/printer/{}", info.name), info);
    let settings = Settings {
        topics: vec![topic(&topics::IMU_DATA.info()), topic(&topics::CAMERA_IMAGE.info())],
        tally: Arc::clone(tally),
        note: BTreeMap::new(),
        queue_length: 8192,
        sync_period: Duration::from_millis(500),
        late_max: Seconds(1.0),
        split: Split { span_ns: None, bytes: args.split.then_some(4 << 20) },
        room: Room { bag_bytes: None, free_bytes: 0, keep_severity: 3 },
        snapshot: Snapshot { span_ns: 0, bytes: 1 },
        compact_end: Duration::from_secs(600),
    };
    let name = args.bag.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let folder = Folder::open(Path::new(&args.bag), &name, Arc::clone(tally))?;
    Ok(Recorder::start(folder, settings)?)
}

/// What is sent, and how much of it was.
struct Load {
    imu: Vec<u8>,
    frame: Vec<u8>,
    sent: [u32; 2],
    dropped: u64,
}

impl Load {
    fn new() -> Self {
        let imu = crate::replay::encode(&imu(0.0)).unwrap_or_default();
        let frame = crate::replay::encode(&frame(0.0)).unwrap_or_default();
        Self { imu, frame, sent: [0; 2], dropped: 0 }
    }

    fn offer(&mut self, queue: &Queue, topic: usize, at_s: f64) -> bool {
        let payload = if topic == 0 { self.imu.clone() } else { self.frame.clone() };
        let sequence = self.sent[topic];
        let received = Seconds(at_s);
        let taken =
            queue.offer(Item::Message(Sample { topic, received, publish_ns: None, sequence, payload }));
        self.sent[topic] += u32::from(taken);
        taken
    }

    /// At the sensors' pace; what the queue does not take is lost.
    fn pace(&mut self, queue: &Queue, args: &LoadArgs, tally: &Tally, begin: Instant) -> anyhow::Result<()> {
        let mut due = [0_u32; 2];
        loop {
            let now_s = begin.elapsed().as_secs_f64();
            if now_s >= args.seconds {
                return Ok(());
            }
            for (topic, hz) in [(0, IMU_HZ), (1, FRAME_HZ)] {
                while f64::from(due[topic]) < now_s * hz {
                    due[topic] += 1;
                    if !self.offer(queue, topic, now_s) {
                        self.dropped += 1;
                    }
                }
            }
            if args.tell {
                let written = |topic: usize| tally.topics[topic].written.get();
                let told = Told {
                    imu: written(0),
                    frames: written(1),
                    synced_bytes: tally.synced_bytes.load(Ordering::Relaxed),
                    newest_s: now_s,
                };
                output::line(&serde_json::to_string(&told)?)?;
            }
            std::thread::sleep(LOOK);
        }
    }

    /// Accelerations alone, as fast as the writer takes them.
    fn flood(&mut self, queue: &Queue, seconds: f64, begin: Instant) {
        let mut at_s = 0.0;
        while at_s < seconds {
            at_s = begin.elapsed().as_secs_f64();
            for _ in 0..1000 {
                while !self.offer(queue, 0, at_s) {
                    std::thread::yield_now();
                }
            }
        }
    }
}

/// Publishes the load, and tells how much of it.
async fn over_dds(args: &LoadArgs) -> anyhow::Result<()> {
    let namespace = Some("/printer".to_owned());
    let mut node = Node::start_with("fdm_bench_load", NodeArgs { namespace, ..NodeArgs::default() })?;
    let accelerations = node.publish_on(&topics::IMU_DATA)?;
    let frames = node.publish_on(&topics::CAMERA_IMAGE)?;
    let picture = frame(0.0);
    tokio::time::sleep(Duration::from_secs(2)).await;
    let begin = Instant::now();
    let mut due = [0_u32; 2];
    let mut looks = tokio::time::interval(LOOK);
    while begin.elapsed().as_secs_f64() < args.seconds {
        looks.tick().await;
        let now_s = begin.elapsed().as_secs_f64();
        while f64::from(due[0]) < now_s * IMU_HZ {
            due[0] += 1;
            accelerations.send(imu(node.clock().now().0));
        }
        while f64::from(due[1]) < now_s * FRAME_HZ {
            due[1] += 1;
            frames.send(CompressedImage { header: Header::at(node.clock().now().0), ..picture.clone() });
        }
    }
    tokio::time::sleep(Duration::from_millis(500)).await;
    let took = Took {
        messages: accelerations.sent() + frames.sent(),
        dropped: accelerations.dropped() + frames.dropped(),
        wall_s: begin.elapsed().as_secs_f64(),
        ..Took::default()
    };
    output::line(&serde_json::to_string(&took)?)
}
