//! `fdm`: starts, watches, simulates and reports. Every figure the project states is printed by one of its commands.

pub mod advance;
pub mod bag;
pub mod bench;
pub mod classify;
pub mod config;
pub mod doctor;
pub mod faults;
pub mod gcode;
pub mod html;
pub mod identify;
pub mod inject;
pub mod install;
pub mod job;
pub mod kinematics;
pub mod operate;
pub mod options;
pub mod output;
mod participant;
pub mod process;
mod programs;
pub mod replay;
pub mod report;
pub mod sim;
pub mod status;
mod suspension;
pub mod up;
pub mod wire;

use clap::{Parser, Subcommand};
use operate::Ask;
use std::process::ExitCode;

/// Exit code where a print did not come to its end.
const FAILED: u8 = 1;
/// Exit code where the person who called has to change something.
const USAGE: u8 = 2;

#[derive(Debug, Parser)]
#[command(name = "fdm", version, about = "Closed-loop 3D printing: simulate, run, watch, stop")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Start the node processes and print a file on the simulated printer.
    ///
    /// The camera is simulated too, and always on: frames of what was laid are rendered, `camera` checks and
    /// `defect_classifier` judges them and measures the roads. A camera of this machine belongs beside a real printer:
    /// `config/camera.param.yaml` names it (driver: video, mjpeg or folder), `monitor.launch.py` starts it.
    Up(up::UpArgs),
    /// See who is on the graph and what the printer does.
    Status(status::StatusArgs),
    /// Pause the print.
    Pause(operate::AskArgs),
    /// Print on after a pause.
    Resume(operate::AskArgs),
    /// Heaters off, job given up.
    Stop(operate::AskArgs),
    /// Emergency stop.
    Estop(operate::AskArgs),
    /// The cause of a latched stop is seen and gone.
    Acknowledge(operate::AskArgs),
    /// Let through, once, the correction that waits in advise.
    Approve(operate::AskArgs),
    /// What the loop may do: observe, advise or act.
    Mode(operate::ModeArgs),
    /// Let a part of the simulated printer fail while it prints.
    Inject(inject::InjectArgs),
    /// Simulate the whole loop in one process and virtual time.
    Sim(sim::SimArgs),
    /// Run the catalogue of faults in virtual time: reaction times beside their limits.
    Faults(faults::FaultsArgs),
    /// Check this machine and say what to do: packages, DDS, clock, disk, cameras, serial ports.
    Doctor(doctor::DoctorArgs),
    /// Lay out programs, configuration and launch files as `ros2 run` and `ros2 launch` look for them.
    Install(install::InstallArgs),
    /// Make an HTML page out of a bag: plots, events, pictures, layers.
    Report(report::ReportArgs),
    /// Measure: recorder, graph, estimator, controller, simulator, advance predictor.
    Bench(bench::BenchArgs),
    /// What is in a bag.
    Bag(bag::BagArgs),
    /// Record a printer's topics to a bag.
    Record(bag::record::RecordArgs),
    /// Mend a bag after a crash.
    Recover(bag::recover::RecoverArgs),
    /// Publish a bag over DDS.
    Play(bag::play::PlayArgs),
    /// Run the brains over a bag in virtual time, as recorded or with other parameters.
    Replay(replay::ReplayArgs),
    /// Learn a printer from a recorded heat-up and test line, and write its file.
    Identify(identify::IdentifyArgs),
    /// Judge pictures; train the networks that do.
    Classify(classify::ClassifyArgs),
    /// Parse and plan a file: layers, moves, filament, time, oddities.
    Gcode(gcode::GcodeArgs),
    /// Pressure advance: predict, calibrate, train, export.
    Advance(advance::AdvanceArgs),
    /// Metal wire laid drop by drop: plan, correct, simulate.
    Wire(wire::WireArgs),
    /// Errors of a five-axis machine of hybrid layout: tables, map, synthesis.
    Kinematics(kinematics::KinematicsArgs),
}

/// Runs the command line of this process.
#[must_use]
pub fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::Up(args) => up::run(&args),
        Command::Status(args) => status::run(&args),
        Command::Pause(args) => operate::ask(Ask::Pause, &args),
        Command::Resume(args) => operate::ask(Ask::Resume, &args),
        Command::Stop(args) => operate::ask(Ask::Stop, &args),
        Command::Estop(args) => operate::ask(Ask::Estop, &args),
        Command::Acknowledge(args) => operate::ask(Ask::Acknowledge, &args),
        Command::Approve(args) => operate::ask(Ask::Approve, &args),
        Command::Mode(args) => operate::set_mode(&args),
        Command::Inject(args) => inject::run(&args),
        Command::Sim(args) => sim::run(&args),
        Command::Faults(args) => faults::run(&args),
        Command::Doctor(args) => doctor::run(&args),
        Command::Install(args) => install::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Bag(args) => bag::run(&args),
        Command::Record(args) => bag::record::run(&args),
        Command::Recover(args) => bag::recover::run(&args),
        Command::Play(args) => bag::play::run(&args),
        Command::Replay(args) => replay::run(&args),
        Command::Identify(args) => identify::run(&args),
        Command::Classify(args) => classify::run(&args),
        Command::Gcode(args) => gcode::run(&args),
        Command::Advance(args) => advance::run(&args),
        Command::Wire(args) => wire::run(&args),
        Command::Kinematics(args) => kinematics::run(&args),
    };
    let code = match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if output::is_closed_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            output::complain(&error);
            let failed = error.is::<output::Failed>();
            ExitCode::from(if failed { FAILED } else { USAGE })
        }
    };
    runtime::write_last_lines();
    code
}
