//! What leaves the simulator: what a real printer would show, and the truth.

use crate::imu::Batch;
use crate::score::Integrals;
use models::motion::Segment;
use models::status::PrinterStatus;
use models::units::{Celsius, Seconds};

/// One thing that a real printer, its firmware or a sensor at it would show.
#[derive(Debug, Clone, PartialEq)]
pub enum Output {
    /// Temperature report of the firmware.
    Temperatures {
        /// When the converter sampled.
        stamp: Seconds,
        /// Hot end block, as read.
        hotend: Celsius,
        /// Bed, as read.
        bed: Celsius,
    },
    /// Count of the filament encoder.
    Encoder {
        /// When it was read.
        stamp: Seconds,
        /// Counts since start.
        counts: i64,
    },
    /// Width of the road as a camera would measure it; a stand-in until frames are rendered.
    Width {
        /// When the frame was exposed; it arrives later.
        exposed: Seconds,
        /// Measured width `[m]`.
        width_m: f64,
        /// Its stated standard deviation `[m]`.
        sigma_m: f64,
    },
    /// Samples of the inertial unit since its last batch.
    Imu(Box<Batch>),
    /// A frame of the camera.
    Frame {
        /// When it was exposed; it arrives later.
        exposed: Seconds,
        /// Frames exposed before it; a gap is a frame that was lost.
        sequence: u64,
        /// The picture, grey.
        jpeg: Vec<u8>,
    },
    /// State of printer and job.
    Status(Box<PrinterStatus>),
    /// A move begins at `start`.
    Motion {
        /// Time of its first instant.
        start: Seconds,
        /// The move.
        segment: Box<Segment>,
    },
    /// A move has become known; it begins later.
    Coming {
        /// When.
        stamp: Seconds,
        /// Its number, counted from the start of the print.
        sequence: u64,
        /// The move.
        segment: Box<Segment>,
    },
    /// Something that a person at the printer would note.
    Note {
        /// When.
        stamp: Seconds,
        /// What, in one line.
        text: String,
    },
}

/// What is really so. No node but reports and tests may read it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Truth {
    /// Time of the simulation `[s]`.
    pub stamp_s: f64,
    /// Time along the slicer's plan `[s]`.
    pub path_time_s: f64,
    /// Heater block `[K]`.
    pub block_k: f64,
    /// Nozzle `[K]`.
    pub nozzle_k: f64,
    /// Thermistor bead `[K]`.
    pub sensor_k: f64,
    /// Bed `[K]`.
    pub bed_k: f64,
    /// Heater power `[W]`.
    pub heater_w: f64,
    /// Filament that ought to have passed the gear `[m]`.
    pub wanted_m: f64,
    /// Filament that passed the gear `[m]`.
    pub delivered_m: f64,
    /// Filament that left the hot end, a leak's share included, in lengths of the actual filament `[m]`.
    pub outlet_m: f64,
    /// Speed of `outlet_m` `[m/s]`: the road gets this times the gain times the nominal area.
    pub outlet_m_s: f64,
    /// Slip of the gear `[-]`; meaningful while filament is pushed.
    pub slip: f64,
    /// Volume into the road over that of the nominal filament: area gain `(d / d_nominal)^2` times the share of the
    /// melt that a leak leaves to the nozzle `[-]`.
    pub gain: f64,
    /// Force on the filament `[N]`.
    pub force_n: f64,
    /// A road is deposited; not while the part is detached, since then nothing lands on it.
    pub depositing: bool,
    /// Width of the road `[m]`; zero while none is deposited.
    pub width_m: f64,
    /// Width that the slicer asked for `[m]`; zero while none is deposited.
    pub target_width_m: f64,
    /// Adhesion of the road to what lies below `[-]`; zero while none is deposited.
    pub adhesion: f64,
    /// Missing share of the road's volume `[-]`.
    pub porosity: f64,
    /// Speed of the tool along its path `[m/s]`.
    pub path_speed_m_s: f64,
    /// Layer from 1; zero before the first.
    pub layer: u32,
    /// Nozzle temperature that counts as right `[K]`.
    pub reference_k: f64,
    /// How far the tool is off its commanded place in x and y `[m]`: lost steps, until the axis is homed.
    pub layer_shift_m: [f64; 2],
    /// The part has come off the bed: what is extruded hangs about instead of landing on it.
    pub detached: bool,
    /// Score of the print so far.
    pub integrals: Integrals,
}
