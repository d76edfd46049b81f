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
        /// Nozzle, as read, where a sensor is fitted.
        nozzle: Option<Celsius>,
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
        /// Its start on the slicer's plan `[s]`.
        start_s: f64,
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

impl Output {
    /// The same with its stamp `epoch` later.
    #[must_use]
    pub fn after(mut self, epoch: Seconds) -> Self {
        let stamp = match &mut self {
            Self::Temperatures { stamp, .. }
            | Self::Encoder { stamp, .. }
            | Self::Coming { stamp, .. }
            | Self::Note { stamp, .. } => stamp,
            Self::Width { exposed, .. } | Self::Frame { exposed, .. } => exposed,
            Self::Imu(batch) => &mut batch.first,
            Self::Status(status) => &mut status.stamp,
            Self::Motion { start, .. } => start,
        };
        *stamp = *stamp + epoch;
        self
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A stamp that is forgotten would be refused as hours old on the host's clock.
    #[test]
    fn what_leaves_is_dated_by_the_epoch_whatever_it_is() {
        let at = Seconds(2.0);
        let batch = crate::imu::Batch {
            first: at,
            first_sequence: 0,
            period: Seconds(1e-3),
            range_m_s2: 160.0,
            samples: vec![[0.0; 3]],
        };
        let all = [
            Output::Temperatures { stamp: at, hotend: Celsius(210.0), bed: Celsius(60.0), nozzle: None },
            Output::Encoder { stamp: at, counts: 1 },
            Output::Width { exposed: at, width_m: 5e-4, sigma_m: 1e-5 },
            Output::Imu(Box::new(batch)),
            Output::Frame { exposed: at, sequence: 0, jpeg: Vec::new() },
            Output::Note { stamp: at, text: String::new() },
        ];
        for output in all {
            let stamp = match output.after(Seconds(1e6)) {
                Output::Temperatures { stamp, .. }
                | Output::Encoder { stamp, .. }
                | Output::Note { stamp, .. } => stamp,
                Output::Width { exposed, .. } | Output::Frame { exposed, .. } => exposed,
                Output::Imu(batch) => batch.first,
                other => unreachable!("{other:?}"),
            };
            assert_eq!(stamp, Seconds(1_000_002.0));
        }
    }
}
