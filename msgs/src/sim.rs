//! Simulated printer. The definitions in `msg/` and `srv/` are the truth.

use crate::definition::{Definition, RosService, RosType};
use crate::standard::Header;
use serde::{Deserialize, Serialize};

/// What the simulated printer really does (topic sim/truth/state): for tests and reports only.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SimTruth {
    /// stamp [s]: simulated time.
    pub header: Header,
    /// Time along the slicer's own plan `[s]`.
    pub path_time_s: f64,
    /// Heater block `[degC]`.
    pub block_degc: f64,
    /// Melt at the nozzle `[degC]`.
    pub nozzle_degc: f64,
    /// Nozzle temperature that counts as right: the file's set-point less the nominal drop `[degC]`.
    pub reference_degc: f64,
    /// Bed `[degC]`.
    pub bed_degc: f64,
    /// Power of the hot end heater `[W]`.
    pub heater_power_w: f64,
    /// Filament that ought to have passed the drive gear since start `[m]`.
    pub wanted_position_m: f64,
    /// Filament pushed by the motor since start `[m]`.
    pub motor_position_m: f64,
    /// Filament that passed the drive gear since start `[m]`.
    pub delivered_position_m: f64,
    /// Filament that left the nozzle since start `[m]`.
    pub outlet_position_m: f64,
    /// Outlet flow as speed of the actual filament `[m/s]`.
    pub outlet_speed_m_s: f64,
    /// Share of the feed lost in the drive gear.
    pub slip: f64,
    /// Area of the filament over its nominal area.
    pub gain: f64,
    /// A road is deposited.
    pub depositing: bool,
    /// Width of the road `[m]`. Invalid where depositing is false.
    pub width_m: f64,
    /// Width that the slicer asked for `[m]`. Invalid where depositing is false.
    pub target_width_m: f64,
    /// Force on the filament `[N]`.
    pub melt_force_n: f64,
    /// Latent adhesion of the road to what lies below. Invalid where depositing is false.
    pub adhesion: f64,
    /// Latent porosity. Invalid where depositing is false.
    pub porosity: f64,
    /// Offset of the layer in x and y `[m]`.
    pub layer_shift_m: [f64; 2],
    /// A fault has set in.
    pub fault_set_in: bool,
    /// Onset of the first fault, simulated time `[s]`. Invalid where fault_set_in is false.
    pub first_onset_s: f64,
    /// Time in which a road was deposited, since start `[s]`.
    pub deposit_s: f64,
    /// Filament commanded for roads since start: slicer's times flow trim, advance included `[m]`.
    pub deposit_wanted_m: f64,
    /// Filament that passed the gear meanwhile `[m]`.
    pub deposit_delivered_m: f64,
    /// Integral of the squared relative width error over roads since start `[s]`.
    pub width_error_sq_s: f64,
    /// Integral of the quality function Q over roads since start `[s]`.
    pub quality_s: f64,
}

impl RosType for SimTruth {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "SimTruth",
        text: include_str!("../msg/SimTruth.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}

/// What the simulated wire process really is (topic sim/truth/wire): for tests and reports only.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SimWire {
    /// stamp [s]: simulated time.
    pub header: Header,
    /// Layer that is laid, from 0.
    pub layer: u32,
    /// Drops are laid; false on the way back, in a pause, at the end.
    pub depositing: bool,
    /// Place of the head along the wall `[m]`. Range `[0, inf)`.
    pub along_m: f64,
    /// Speed asked of the wire drive, inside what drive and laser can do `[m/s]`. Range `[0, inf)`.
    pub wire_m_s: f64,
    /// Speed asked of the head, inside what it can do `[m/s]`. Range `[0, inf)`.
    pub head_m_s: f64,
    /// Height of the wall above the base plate, mean over its length `[m]`.
    pub height_m: f64,
    /// Layers laid and measured.
    pub layers_complete: u32,
    /// Root mean square of the height error of the last complete layer; 0 before the first `[m]`. Range `[0, inf)`.
    pub layer_rms_m: f64,
    /// The same over all complete layers `[m]`. Range `[0, inf)`.
    pub rms_m: f64,
}

impl RosType for SimWire {
    const DEFINITION: Definition = Definition {
        package: "fdm_loop_msgs",
        name: "SimWire",
        text: include_str!("../msg/SimWire.msg"),
        dependencies: &[&Header::DEFINITION],
    };
}

/// Injects a fault into the simulated printer (service printer_sim/inject_fault): the request.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct InjectFaultRequest {
    /// Part of the printer, as in scenario files.
    pub component: String,
    /// Kind of fault, as in scenario files.
    pub kind: String,
    /// Size of the fault `[as the kind says]`.
    pub size: f64,
    /// Delay from now until it sets in `[s]`. Range `[0, inf)`.
    pub start_s: f64,
    /// How long it lasts; 0 until the end of the print `[s]`. Range `[0, inf)`.
    pub duration_s: f64,
    /// Seed of its random part, which noise, spikes and loose have; 0 leaves it to the seed of the run.
    pub seed: u64,
    /// Time to grow from nothing to full size; 0 at once `[s]`. Range `[0, inf)`.
    pub ramp_s: f64,
}

/// Answer of [`InjectFault`].
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct InjectFaultResponse {
    /// The fault is scheduled.
    pub accepted: bool,
    /// What was scheduled, with size, onset, growth and duration, or the reason of the refusal.
    pub message: String,
}

/// Injects a fault into the simulated printer (service printer_sim/inject_fault).
#[derive(Debug, Clone, Copy)]
pub struct InjectFault;

impl RosService for InjectFault {
    type Request = InjectFaultRequest;
    type Response = InjectFaultResponse;
    const PACKAGE: &'static str = "fdm_loop_msgs";
    const NAME: &'static str = "InjectFault";
    const TEXT: &'static str = include_str!("../srv/InjectFault.srv");
}
