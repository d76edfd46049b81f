//! The law of the dead-man, held against what was seen of printer and supervisor: no correction is in force longer than
//! the permit of a correction is valid. A permit of the slicer's own values permits none.

use crate::observer::is_neutral;
use byteorder::LittleEndian;
use fdm_loop_msgs::{ControlCommand, Header, PrinterState};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

const NANOS_PER_S: f64 = 1e9;
/// A permit may be stamped that much later than the state that follows it: both clocks are the printer's, the
/// supervisor's as it was read last `[ns]`.
const AHEAD_NS: i64 = 20_000_000;
/// Without a permit for longer the printer is deaf or the supervisor mute `[s]`.
const SILENCE_S: f64 = 0.25;

/// Stamps of what was seen, on the graph's clock.
#[derive(Debug, Default)]
pub(crate) struct Record {
    /// Whether a correction was in force.
    states: BTreeMap<i64, bool>,
    permits: BTreeSet<i64>,
    /// Those of them that permit a correction.
    corrections: BTreeSet<i64>,
}

/// What was found in a span of time.
#[derive(Debug, Default, Clone, Copy)]
pub(crate) struct Judged {
    pub(crate) states: usize,
    pub(crate) corrected: usize,
    /// Longest time from a permit of a correction to a state with one, no other such permit between them `[s]`.
    pub(crate) oldest_s: f64,
    /// Longest time without a permit `[s]`, and how often there was none for longer than it is valid.
    pub(crate) longest_gap_s: f64,
    pub(crate) gaps: usize,
}

impl Record {
    pub(crate) fn on_state(&mut self, state: &PrinterState) {
        self.states.extend(nanos(&state.header).map(|stamp| (stamp, !is_neutral(state))));
    }

    pub(crate) fn on_permit(&mut self, permit: &ControlCommand) {
        self.permits.extend(nanos(&permit.header));
        self.corrections.extend(nanos(&permit.header).filter(|_| permits_more(permit)));
    }

    /// Stamp of the newest state `[s]`.
    pub(crate) fn newest_s(&self) -> f64 {
        self.states.last_key_value().map_or(0.0, |(stamp, _)| seconds(*stamp))
    }

    /// Adds what the recorder heard; the number of messages. A file that was cut by the end of its recorder counts as far
    /// as it goes.
    pub(crate) fn add_bag(&mut self, folder: &Path) -> usize {
        let files = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
        let mut read = 0;
        for file in files.filter(|path| path.to_string_lossy().contains(".mcap")) {
            let bytes = std::fs::read(&file).unwrap();
            let options = mcap::read::Options::IgnoreEndMagic;
            if bytes.len() < mcap::MAGIC.len() {
                // Its recorder was ended before it had written anything.
                continue;
            }
            assert!(bytes.starts_with(mcap::MAGIC), "{}: no MCAP", file.display());
            let messages = mcap::MessageStream::new_with_options(&bytes, options.into());
            let messages = messages.unwrap_or_else(|error| panic!("{}: {error}", file.display()));
            for message in messages.map_while(Result::ok) {
                let body = message.data.get(4..).unwrap_or_default();
                match message.channel.topic.as_str() {
                    "/printer/printer/state" => {
                        let decoded = cdr_encoding::from_bytes::<PrinterState, LittleEndian>(body);
                        self.on_state(&decoded.unwrap().0);
                    }
                    "/printer/safety/command" => {
                        let decoded = cdr_encoding::from_bytes::<ControlCommand, LittleEndian>(body);
                        self.on_permit(&decoded.unwrap().0);
                    }
                    _ => continue,
                }
                read += 1;
            }
        }
        read
    }

    /// What was seen between two times of the graph's clock.
    pub(crate) fn judge(&self, (from_s, to_s): (f64, f64)) -> Judged {
        let inside = |stamp: i64| (from_s..=to_s).contains(&seconds(stamp));
        let mut judged = Judged::default();
        for (stamp, corrected) in self.states.iter().filter(|(stamp, _)| inside(**stamp)) {
            judged.states += 1;
            if *corrected {
                judged.corrected += 1;
                let newest = self.corrections.range(..=stamp + AHEAD_NS).next_back();
                let age_s = newest.map_or(f64::INFINITY, |permit| seconds(stamp - permit));
                judged.oldest_s = judged.oldest_s.max(age_s);
            }
        }
        let permits: Vec<i64> = self.permits.iter().copied().filter(|stamp| inside(*stamp)).collect();
        for pair in permits.windows(2) {
            let gap_s = seconds(pair[1] - pair[0]);
            judged.longest_gap_s = judged.longest_gap_s.max(gap_s);
            judged.gaps += usize::from(gap_s > SILENCE_S);
        }
        judged
    }
}

/// Whether it permits more than the slicer's own values.
fn permits_more(permit: &ControlCommand) -> bool {
    (permit.flow_factor, permit.speed_factor, permit.nozzle_setpoint_offset_k) != (1.0, 1.0, 0.0)
        || permit.set_advance
        || permit.close_extruder_loop
}

fn nanos(header: &Header) -> Option<i64> {
    header.stamp.seconds().map(|seconds| {
        #[allow(clippy::cast_possible_truncation, reason = "a time of a print")]
        let nanos = (seconds * NANOS_PER_S).round() as i64;
        nanos
    })
}

fn seconds(nanos: i64) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "a time of a print")]
    let nanos = nanos as f64;
    nanos / NANOS_PER_S
}

/// A bag that cannot be read is no proof of anything.
#[test]
#[should_panic(expected = "noise_0.mcap: ")]
fn a_bag_of_noise_is_not_passed_over() {
    let folder = std::env::temp_dir().join(format!("rtps_judge_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("noise_0.mcap"), [7; 1000]).unwrap();
    Record::default().add_bag(&folder);
}

/// A correction that outlives its permit is found: the test can fail.
#[test]
fn a_correction_without_a_permit_is_found() {
    let header = |at_s| Header::at(at_s);
    let corrected = |at_s| PrinterState {
        header: header(at_s),
        flow_factor: 1.05,
        speed_factor: 1.0,
        ..PrinterState::default()
    };
    let permit = |at_s: f64, flow_factor| ControlCommand {
        header: header(at_s),
        flow_factor,
        speed_factor: 1.0,
        ..ControlCommand::default()
    };
    let mut record = Record::default();
    record.on_permit(&permit(10.0, 1.05));
    // Permits of the slicer's own values license nothing.
    (1..10).for_each(|step| record.on_permit(&permit(10.0 + 0.04 * f64::from(step), 1.0)));
    for step in 0..=20 {
        record.on_state(&corrected(10.0 + 0.02 * f64::from(step)));
    }
    let neutral = PrinterState { flow_factor: 1.0, ..corrected(10.5) };
    record.on_state(&neutral);
    record.on_permit(&permit(11.36, 1.0));
    let judged = record.judge((10.0, 12.0));
    assert_eq!((judged.states, judged.corrected, judged.gaps), (22, 21, 1));
    assert!((judged.oldest_s - 0.4).abs() < 1e-6 && (judged.longest_gap_s - 1.0).abs() < 1e-6, "{judged:?}");
    assert_eq!(record.judge((10.45, 10.6)).corrected, 0);
}
