//! From the node's parameters to a simulator with its job; reads the files that they name.

use crate::node::darkroom::Darkroom;
use crate::params::{Params, PlantParams, SimulatorParams};
use crate::run_params::{Chosen, ProcessKind, RunParams};
use crate::scenario::Scenario;
use crate::simulator::{JobSource, Simulator};
use fdm_loop_msgs::{Header as StampHeader, PrintInfo};
use models::gcode::Header;
use models::material::Material;
use models::motion::MotionParams;
use models::params::ParamError;
use runtime::params::{ParamFileError, Parameters, from_yaml, sha256_hex};
use runtime::{FrameParams, RuntimeError};
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub mod wall;

/// Why the simulated printer cannot start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadError {
    /// Parameters or scenario.
    #[error(transparent)]
    Parameters(#[from] ParamFileError),
    /// The graph.
    #[error(transparent)]
    Runtime(#[from] RuntimeError),
    /// The plant's material.
    #[error("material_deviation: {0}")]
    Material(#[from] ParamError),
    /// A file that the parameters have to name.
    #[error("run.{0} = '': must name a file: -p run.{0}:=FILE")]
    Unnamed(&'static str),
    /// A file that the parameters name.
    #[error("run.{field} = {}", path.display())]
    File {
        /// Parameter that names it.
        field: &'static str,
        /// The file.
        path: PathBuf,
        /// Why it cannot be read.
        source: std::io::Error,
    },
}

/// A simulator ready to run.
pub struct Loaded {
    /// The printer.
    pub simulator: Simulator,
    /// What is printed.
    pub info: PrintInfo,
    /// Simulated over wall time `[-]`.
    pub speed: f64,
    /// Stamps are of the host's clock.
    pub host_clock: bool,
    /// Filament per count of the encoder `[m]`.
    pub quantum_m: f64,
    /// Faults may be injected by service.
    pub allow_fault_injection: bool,
}

/// Which process the parameters ask for.
///
/// # Errors
/// File, line and value of one that is unknown.
pub fn process(parameters: &Parameters) -> Result<ProcessKind, LoadError> {
    Ok(parameters.block::<Chosen>("run")?.process)
}

/// Checks the parameters without the files that they name.
///
/// # Errors
/// File, line, field, value and range of what is refused.
pub fn check(parameters: &Parameters) -> Result<(), ParamFileError> {
    match parameters.block::<Chosen>("run")?.process {
        ProcessKind::Wire => wall::machine_params(parameters).map(drop),
        ProcessKind::Fdm => {
            _ = parameters.block::<RunParams>("run")?;
            _ = parameters.block::<MotionParams>("printer_motion")?;
            _ = parameters.optional::<FrameParams>("frames")?;
            simulator_params(parameters, &parameters.block("material")?).map(drop)
        }
    }
}

/// Reads everything that the parameters name.
///
/// # Errors
/// [`LoadError`], one line.
pub fn load(parameters: &Parameters) -> Result<Loaded, LoadError> {
    let run: RunParams = parameters.block("run")?;
    let material: Material = parameters.block("material")?;
    let motion: MotionParams = parameters.block("printer_motion")?;
    let params = simulator_params(parameters, &material)?;
    let bytes: Arc<[u8]> = read("gcode", &run.gcode)?.into();
    let scenario = match run.scenario.as_os_str().is_empty() {
        true => Scenario::default(),
        false => from_yaml(&run.scenario)?,
    };
    let ends = motion.read.header_bytes.min(bytes.len());
    let header = Header::scan(&bytes[..ends], &bytes[bytes.len() - ends..]);
    let override_by = run.material_set_points.then_some(&material);
    let job = JobSource::from_gcode(&bytes, &header, &motion, params.wishes(run.layers, override_by));
    let quantum_m = params.simulator.sensors.encoder_quantum_m;
    let preheat = job.preheat;
    let camera = params.camera.enabled.then(|| Darkroom::new(&params.camera, run.seed));
    let mut simulator = Simulator::new(params, job, &scenario, run.seed)?;
    if let Some(camera) = camera {
        simulator.fit(Box::new(camera));
    }
    if run.warm {
        simulator.warm_up(&preheat);
    }
    Ok(Loaded {
        simulator,
        info: info(&run, parameters, &bytes)?,
        speed: run.speed,
        host_clock: run.host_clock,
        quantum_m,
        allow_fault_injection: run.allow_fault_injection,
    })
}

/// The simulator's parameters from their blocks.
///
/// # Errors
/// File, line, field, value and range of what is refused.
pub fn simulator_params(parameters: &Parameters, material: &Material) -> Result<Params, ParamFileError> {
    let plant: PlantParams = parameters.block("plant")?;
    let simulator: SimulatorParams = parameters.block("simulator")?;
    Ok(Params {
        nozzle_drop_k: plant.nozzle_drop_k(material, simulator.firmware.reference_flow_m3_s),
        plant,
        material: material.clone(),
        simulator,
        camera: parameters.block("camera")?,
        dead_man: parameters.block("dead_man")?,
        limits: parameters.block("limits")?,
        quality: parameters.block("quality")?,
    })
}

/// Longest G-code file that is printed, as it is held in memory `[byte]`.
const GCODE_BYTES_MAX: u64 = 512 << 20;

fn read(field: &'static str, path: &Path) -> Result<Vec<u8>, LoadError> {
    if path.as_os_str().is_empty() {
        return Err(LoadError::Unnamed(field));
    }
    runtime::input::bytes(path, GCODE_BYTES_MAX).map_err(|source| LoadError::File {
        field,
        path: path.to_path_buf(),
        source,
    })
}

fn info(run: &RunParams, parameters: &Parameters, gcode: &[u8]) -> Result<PrintInfo, LoadError> {
    Ok(PrintInfo {
        gcode_file: run
            .gcode
            .file_name()
            .map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
        gcode_sha256: sha256_hex(gcode),
        scenario: stem(&run.scenario),
        ..bare_info(&stem(&run.gcode), run.seed, &run.config_file, parameters)?
    })
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

/// What is printed, without a file that says how.
fn bare_info(
    name: &str,
    seed: u64,
    config_file: &Path,
    parameters: &Parameters,
) -> Result<PrintInfo, LoadError> {
    let config = match config_file.as_os_str().is_empty() {
        true => parameters.text(),
        false => String::from_utf8_lossy(&read("config_file", config_file)?).into_owned(),
    };
    let started = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    Ok(PrintInfo {
        header: StampHeader::at(0.0),
        print_id: format!("{name}-{}-{seed}", started.as_secs()),
        config_sha256: sha256_hex(config.as_bytes()),
        config,
        build: runtime::build().to_owned(),
        ..PrintInfo::default()
    })
}
