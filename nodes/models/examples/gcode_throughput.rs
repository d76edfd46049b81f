//! Parses and plans a synthetic stream made of one file's body over and over; prints MB/s and peak memory.
//!
//! `cargo run --release -p models --example gcode_throughput -- config/printers/ender3_motion.yaml FILE [MB]`
#![allow(
    clippy::print_stdout,
    clippy::expect_used,
    reason = "an example prints and stops at the first failure"
)]

use models::gcode::{Header, survey::survey};
use models::motion::MotionParams;
use std::collections::HashMap;
use std::io::{self, BufRead, Read};
use std::time::Instant;

/// The same bytes again and again until `left` are given out.
struct Repeat {
    body: Vec<u8>,
    at: usize,
    left: usize,
}

impl Read for Repeat {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let available = self.fill_buf()?;
        let count = available.len().min(out.len());
        out[..count].copy_from_slice(&available[..count]);
        self.consume(count);
        Ok(count)
    }
}

impl BufRead for Repeat {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.at == self.body.len() {
            self.at = 0;
        }
        let end = self.body.len().min(self.at + self.left);
        Ok(&self.body[self.at..end])
    }

    fn consume(&mut self, count: usize) {
        self.at += count;
        self.left -= count;
    }
}

fn peak_kib() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.split_whitespace().next()?.parse().ok()
}

fn main() {
    let mut args = std::env::args().skip(1);
    let params = std::fs::read_to_string(args.next().expect("parameter file")).expect("parameter file");
    type Tree = HashMap<String, HashMap<String, HashMap<String, MotionParams>>>;
    let mut tree: Tree = serde_saphyr::from_str(&params).expect("parameters");
    let params = tree
        .remove("/**")
        .and_then(|mut node| node.remove("ros__parameters"))
        .and_then(|mut block| block.remove("printer_motion"))
        .expect("block printer_motion");
    let body = std::fs::read(args.next().expect("G-code file")).expect("G-code file");
    let megabytes: usize = args.next().map_or(200, |text| text.parse().expect("size in MB"));
    let header = Header::scan(&body, &body);
    let before_kib = peak_kib();
    let start = Instant::now();
    let survey = survey(Repeat { body, at: 0, left: megabytes * 1_000_000 }, &header, &params);
    let wall_s = start.elapsed().as_secs_f64();
    println!(
        "{megabytes} MB in {wall_s:.3} s: {:.1} MB/s, {} moves",
        megabytes as f64 / wall_s,
        survey.moves
    );
    println!("peak memory before {before_kib:?} KiB, after {:?} KiB", peak_kib());
    println!(
        "layers {} arcs {} filament {:.3} mm (stated {:?}) time {:.2} s (stated {:?}) dialect {}",
        survey.layers,
        survey.arcs,
        survey.filament_mm,
        survey.stated_filament_mm,
        survey.print_time_s,
        survey.stated_time_s,
        survey.dialect
    );
    println!("warnings {}", survey.warnings_total);
}
