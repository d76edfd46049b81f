//! Time to lay, to render and to compress, on a planned print whose roads are as wide as the file says, and some of
//! the frames: `cargo run --release -p printer_sim --no-default-features --example render_time -- FOLDER [GCODE] [SEED]`.

#![allow(clippy::print_stdout, reason = "an example prints")]
#![allow(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "counts of frames and steps are small"
)]

mod support;

use models::gcode::Header;
use models::motion::{Job, MotionParams, MoveKind, Segment, Step};
use models::units::Seconds;
use printer_sim::camera::{Camera, CameraParams, Frame, Look, Moment, Renderer, Rig, View};
use std::io::Cursor;
use std::path::Path;
use std::time::{Duration, Instant};

const FILE: &str = "../../tests/data/gcode/prusa_cube_pla_marlin_relE.gcode";
/// Step of the simulation `[s]`.
const STEP_S: f64 = 1e-3;
/// Frames that are kept, over the whole print.
const KEPT: usize = 12;

fn main() -> Result<(), support::Failure> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().unwrap_or_else(|| "frames".to_owned());
    let file = arguments
        .next()
        .unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join(FILE).to_string_lossy().into_owned());
    let seed: u64 = arguments.next().map_or(Ok(1), |text| text.parse())?;
    std::fs::create_dir_all(&folder)?;
    let params = support::camera()?;
    let segments = plan(&file)?;
    let print_s: f64 = segments.iter().map(|segment| segment.profile.duration().0).sum();

    let idle = CameraParams { period_s: 60.0, ..params.clone() };
    let (laying, rig) = run(&segments, &idle, seed, |_, _| ());
    let mut jpeg_bytes = 0;
    let (all, _) = run(&segments, &params, seed, |_, bytes| jpeg_bytes += bytes);
    let frames = print_s / params.period_s;
    let per_frame_ms = |time: Duration| time.as_secs_f64() * 1e3 / frames;
    println!(
        "{print_s:.0} s of print, {frames:.0} frames of {:.0} kB: {:.2} ms a frame, {:.2} ms of it to lay; \
         height field {:.1} MB, {} pieces refused",
        jpeg_bytes as f64 / frames / 1e3,
        per_frame_ms(all),
        per_frame_ms(laying),
        rig.deposit().bytes() as f64 / 1e6,
        rig.deposit().refused(),
    );
    let times = stages(&rig, &segments, &params, seed)?;
    println!("on the finished print, best of 20: render {:.2} ms, JPEG {:.2} ms", times[0], times[1]);

    let kept = show(&segments, &params, seed, print_s);
    std::fs::write(Path::new(&folder).join("print.png"), support::png(&support::sheet(&kept, 3)))?;
    for (number, frame) in kept.iter().enumerate() {
        std::fs::write(Path::new(&folder).join(format!("frame_{number:02}.png")), support::png(frame))?;
    }
    Ok(())
}

fn plan(file: &str) -> Result<Vec<Segment>, support::Failure> {
    let bytes = std::fs::read(file)?;
    let motion: MotionParams = support::block("printers/ender3_motion.yaml", "printer_motion")?;
    let ends = motion.read.header_bytes.min(bytes.len());
    let header = Header::scan(&bytes[..ends], &bytes[bytes.len() - ends..]);
    let moves = Job::new(Cursor::new(bytes), &header, &motion).filter_map(|step| match step {
        Step::Move(segment) => Some(segment),
        Step::Action(..) => None,
    });
    Ok(moves.collect())
}

/// Lays and photographs the whole print; the time without what `each` frame is used for.
fn run(
    segments: &[Segment],
    params: &CameraParams,
    seed: u64,
    mut each: impl FnMut(Seconds, usize),
) -> (Duration, Rig) {
    let mut rig = Rig::new(params, seed);
    let moments = moments(segments);
    let begun = Instant::now();
    for moment in &moments {
        rig.observe(moment);
        while let Some(shot) = rig.ready(moment.now) {
            each(shot.exposed, shot.jpeg.len());
        }
    }
    (begun.elapsed(), rig)
}

fn moments(segments: &[Segment]) -> Vec<Moment> {
    let mut moments = Vec::new();
    let mut now_s = 0.0;
    for segment in segments {
        let duration_s = segment.profile.duration().0;
        let steps = (duration_s / STEP_S).ceil().max(1.0);
        for step in 1..=steps as usize {
            let into_s = duration_s * step as f64 / steps;
            let (tool_m, state) = segment.at(Seconds(into_s));
            let length_m = segment.length_m.max(1e-12);
            let along = [0, 1].map(|axis| (segment.end_m[axis] - segment.start_m[axis]) / length_m);
            let laid = segment.kind == MoveKind::Deposit;
            moments.push(Moment {
                now: Seconds(now_s + into_s),
                tool_m,
                velocity_m_s: along.map(|along| along * state.speed_m_s),
                road_m: segment.target_width_m.zip(segment.layer_height_m).filter(|_| laid),
                loose_m3: 0.0,
            });
        }
        now_s += duration_s;
    }
    moments
}

fn stages(
    rig: &Rig,
    segments: &[Segment],
    params: &CameraParams,
    seed: u64,
) -> Result<[f64; 2], support::Failure> {
    let mut renderer = Renderer::new(params.geometry, Look::draw(params.ranges(params.style), seed));
    let last = segments.iter().rev().find(|segment| segment.kind == MoveKind::Deposit).ok_or("no road")?;
    let view = View { tool_m: last.end_m, velocity_m_s: [0.03, 0.04] };
    let mut best = [f64::INFINITY; 2];
    for _ in 0..20 {
        let begun = Instant::now();
        let frame = renderer.render(rig.deposit(), &view);
        best[0] = best[0].min(begun.elapsed().as_secs_f64() * 1e3);
        let begun = Instant::now();
        _ = frame.jpeg(renderer.look().jpeg_quality)?;
        best[1] = best[1].min(begun.elapsed().as_secs_f64() * 1e3);
    }
    Ok(best)
}

/// Frames of moments of the print, rendered anew and not compressed.
fn show(segments: &[Segment], params: &CameraParams, seed: u64, print_s: f64) -> Vec<Frame> {
    let idle = CameraParams { period_s: 60.0, ..params.clone() };
    let mut rig = Rig::new(&idle, seed);
    let mut renderer = Renderer::new(params.geometry, Look::draw(params.ranges(params.style), seed));
    let mut kept = Vec::new();
    for moment in moments(segments) {
        rig.observe(&moment);
        // Denser at the start: the first layers are where the bed is seen.
        let share = (kept.len() as f64 + 1.0) / KEPT as f64;
        if kept.len() < KEPT && moment.now.0 > print_s * share * share && moment.road_m.is_some() {
            let view = View { tool_m: moment.tool_m, velocity_m_s: moment.velocity_m_s };
            kept.push(renderer.render(rig.deposit(), &view));
        }
    }
    kept
}
