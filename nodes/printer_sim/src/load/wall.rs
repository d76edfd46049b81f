//! From the node's parameters to a wire machine.

use super::{LoadError, bare_info};
use crate::wire::{Machine, MachineParams, WireRun};
use fdm_loop_msgs::PrintInfo;
use runtime::params::{ParamFileError, Parameters};

/// A wire machine ready to run.
pub struct LoadedWall {
    /// The machine.
    pub machine: Machine,
    /// What is built.
    pub info: PrintInfo,
    /// Simulated over wall time `[-]`.
    pub speed: f64,
}

/// Parameters of the machine and of the run.
///
/// # Errors
/// File, line, field, value and range of what is refused.
pub fn machine_params(parameters: &Parameters) -> Result<(MachineParams, WireRun), ParamFileError> {
    let run: WireRun = parameters.block("run")?;
    let params = MachineParams {
        plant: parameters.block("wire_plant")?,
        process: parameters.block("wire_process")?,
        settings: parameters.block("wire_machine")?,
        dead_man: parameters.block("dead_man")?,
        limits: parameters.block("limits")?,
        layers: run.layers,
    };
    Ok((params, run))
}

/// Reads everything that the parameters name.
///
/// # Errors
/// [`LoadError`], one line.
pub fn load(parameters: &Parameters) -> Result<LoadedWall, LoadError> {
    let (params, run) = machine_params(parameters)?;
    Ok(LoadedWall {
        machine: Machine::new(params, run.seed),
        info: bare_info("wire-wall", run.seed, &run.config_file, parameters)?,
        speed: run.speed,
    })
}
