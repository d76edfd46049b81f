//! `fdm doctor`: whether this machine can run the graph, and what to do where it cannot.

mod devices;
mod finding;
mod graph;
mod machine;
mod netlink;
mod network;
mod parameters;
mod printer;
mod software;

use crate::output::{self, Failed, Json};
use clap::Args;
use finding::{Finding, Level};
use machine::Machine;
use std::path::PathBuf;

/// Checks this machine and says what to do.
#[derive(Debug, Args)]
pub struct DoctorArgs {
    /// Write the findings to a file; without one, or with `-`, to standard output.
    #[arg(long, num_args = 0..=1, default_missing_value = "-")]
    pub json: Option<PathBuf>,
    /// Folder that bags are recorded into.
    #[arg(long, default_value = "bags")]
    pub bags: PathBuf,
    /// Folder with the parameter files.
    #[arg(long)]
    pub config: Option<PathBuf>,
    /// One of the two processes that try to talk to each other.
    #[arg(long, hide = true)]
    pub talk: Option<String>,
}

/// What was found, for programs.
#[derive(Debug, serde::Serialize)]
struct Report<'a> {
    checks: &'a [Finding],
    ok: usize,
    warnings: usize,
    failures: usize,
}

/// Runs the command.
///
/// # Errors
/// [`Failed`] where a check failed.
pub fn run(args: &DoctorArgs) -> anyhow::Result<()> {
    if let Some(role) = &args.talk {
        return graph::talk(role);
    }
    let json = Json::new(args.json.as_deref());
    json.check()?;
    let findings = findings(args);
    let count = |level| findings.iter().filter(|finding| finding.level == level).count();
    let (ok, warnings, failures) = (count(Level::Ok), count(Level::Warn), count(Level::Fail));
    if !json.is_stdout() {
        let lines: Vec<String> = findings.iter().map(Finding::to_string).collect();
        output::line(&lines.join("\n"))?;
        output::line(&format!("{ok} ok, {warnings} to warn of, {failures} failed"))?;
    }
    json.write(&Report { checks: &findings, ok, warnings, failures })?;
    if failures > 0 {
        Err(Failed(format!("{failures} check(s) failed: see what to do above")).into())
    } else {
        Ok(())
    }
}

fn findings(args: &DoctorArgs) -> Vec<Finding> {
    let here = Machine::here();
    let mut findings = vec![
        software::system(&here),
        software::nodes(),
        software::build_tools(),
        parameters::config(args.config.as_deref()),
        software::processors(&here),
        software::memory(&here),
        software::disk(&args.bags),
    ];
    findings.extend(software::clock(&here));
    findings.extend(network::environment());
    findings.extend(network::interfaces());
    findings.push(network::participants(&here));
    findings.push(graph::pair());
    findings.push(devices::cameras(&here));
    findings.push(devices::serial_ports(&here));
    findings.push(printer::bridge(&here, args.config.as_deref()));
    findings
}
