//! Writes labelled frames as JPEG, and all of them on one sheet, for people to look at:
//! `cargo run --release -p printer_sim --example synthesize -- FOLDER [COUNT] [training|test]`.

#![allow(clippy::print_stdout, reason = "an example prints")]
#![allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, reason = "a picture is small")]

mod support;

use printer_sim::camera::{Class, Style, synthesize};
use std::path::Path;

fn main() -> Result<(), support::Failure> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().unwrap_or_else(|| "frames".to_owned());
    let count: u64 = arguments.next().map_or(Ok(3), |text| text.parse())?;
    let style = if arguments.next().as_deref() == Some("test") { Style::Test } else { Style::Training };
    let params = support::camera()?;
    std::fs::create_dir_all(&folder)?;
    let mut frames = Vec::new();
    let begun = std::time::Instant::now();
    for class in Class::ALL {
        for seed in 0..count {
            let example = synthesize(&params, style, class, seed);
            let name = format!("{class:?}_{seed}.jpg").to_lowercase();
            std::fs::write(Path::new(&folder).join(name), example.frame.jpeg(example.jpeg_quality)?)?;
            frames.push(example.frame);
        }
    }
    println!(
        "{} frames, {:.1} ms each",
        frames.len(),
        begun.elapsed().as_secs_f64() * 1e3 / frames.len() as f64
    );
    let sheet = support::sheet(&frames, usize::try_from(count)?);
    std::fs::write(Path::new(&folder).join("sheet.png"), support::png(&sheet))?;
    Ok(())
}
