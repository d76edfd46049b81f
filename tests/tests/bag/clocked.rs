//! A bag that is played with its clock, heard by somebody who lives by it.

use crate::process::{Bag, Domain};
use crate::{played, read_by_all};
use rustix::process::Signal;

/// Time of the bag over wall time.
const RATE: f64 = 20.0;
/// The end of the bag that is played `[s]`: 5 s at that rate.
const LENGTH_S: f64 = 100.0;
/// How often.
const TIMES: u32 = 4;
/// Two readings of the clock lie so far apart at most `[ns]`, a lost one or two included.
const STEP_NS: u64 = 100_000_000;

/// Beside somebody who publishes simulated time `fdm record` follows it without being asked: its log times are of the print,
/// a jump back begins a file. It takes no bag of another clock for its own.
#[test]
fn fdm_record_follows_a_clock_that_is_published() {
    let (print, bag, domain) = (Bag::new("clocked"), Bag::new("follows"), Domain::new(7));
    played::simulate(&print);
    let (begin_ns, end_ns) = ends(&print.log_times(0));
    let begin_s = seconds(end_ns - begin_ns) - LENGTH_S;
    assert!(begin_s > 1.0, "the print is too short");
    let play = played::Group::clock(&print, domain, (RATE, begin_s, TIMES));
    // Its own look for others is over, and it tells the time.
    std::thread::sleep(std::time::Duration::from_secs(3));
    let record = played::Group::record(&bag, domain);
    played::until(|| bag.active_bytes_of(1) > 20_000);
    record.signal(Signal::INT);
    assert_eq!(record.ended().0, Some(0));
    let read = read_by_all(&bag);
    assert_eq!(read["mcap"]["note"]["clock"], "simulated");

    // Time of the print alone, whatever was heard; it went on up to the end, and then anew from where the play begins.
    let from_ns = end_ns - nanoseconds(LENGTH_S);
    let files = [0, 1].map(|number| ends(&bag.log_times(number)));
    for (first_ns, last_ns) in files {
        assert!(
            from_ns - STEP_NS <= first_ns && last_ns <= end_ns + STEP_NS,
            "{files:?}: {from_ns}..{end_ns}"
        );
    }
    assert!(end_ns - files[0].1 < nanoseconds(1.0), "not played to its end: {files:?}, {end_ns}");
    assert!(files[1].0 - from_ns < nanoseconds(1.0), "not from its begin: {files:?}, {from_ns}");
    clock_of(&bag, (from_ns, end_ns));

    let (code, told) = play.ended();
    let told: serde_json::Value = serde_json::from_slice(&told).unwrap();
    assert_eq!((code, &told["dropped"]), (Some(0), &0.into()), "{told}");
    // At its rate, or later on a busy host; never sooner.
    let (lasts_s, wanted_s) = (told["duration_s"].as_f64().unwrap(), LENGTH_S * f64::from(TIMES) / RATE);
    assert!(
        (0.98 * wanted_s..1.5 * wanted_s + 2.0).contains(&lasts_s),
        "{lasts_s} s for {wanted_s} s: {told}"
    );

    let refused = played::Group::record(&bag, domain);
    assert_eq!(refused.ended().0, Some(2), "times of this machine beside those of the print");
}

/// What `/clock` told: steps of 10 ms, a lost one here and there, within the print; one jump back.
fn clock_of(bag: &Bag, (from_ns, end_ns): (u64, u64)) {
    let readings: Vec<u64> = bag.payloads()["/clock"].iter().map(|bytes| reading(bytes)).collect();
    assert!(readings.len() > 1000, "{} readings", readings.len());
    let within = |at: &&u64| !(from_ns..=end_ns).contains(*at);
    assert_eq!(readings.iter().find(within), None, "in {from_ns}..{end_ns}");
    let back: Vec<_> = readings.windows(2).filter(|pair| pair[1] < pair[0]).collect();
    assert_eq!(back.len(), 1, "{back:?}");
    let far: Vec<_> = readings.windows(2).filter(|pair| pair[1] > pair[0] + STEP_NS).collect();
    assert!(far.len() * 100 < readings.len(), "{far:?}");
}

/// A time in CDR behind its four bytes of header.
fn reading(bytes: &[u8]) -> u64 {
    let word = |at: usize| u64::from(u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()));
    word(4) * 1_000_000_000 + word(8)
}

fn ends(times_ns: &[u64]) -> (u64, u64) {
    (*times_ns.iter().min().unwrap(), *times_ns.iter().max().unwrap())
}

#[allow(clippy::cast_precision_loss, reason = "a time of a print")]
fn seconds(ns: u64) -> f64 {
    ns as f64 * 1e-9
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a time of a print")]
fn nanoseconds(s: f64) -> u64 {
    (s * 1e9).round() as u64
}
