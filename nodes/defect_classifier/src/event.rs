//! What comes in and what goes out.

use crate::frame::Unusable;
use crate::fusion::Fused;
use crate::layer::LayerFigure;
use crate::offset::Offset;
use crate::seam::SeamReading;
use crate::width::WidthMeasurement;
use models::motion::Segment;
use models::status::PrinterStatus;
use models::units::{Kelvin, Seconds};

/// What the classifier reacts to.
#[derive(Debug, Clone, PartialEq)]
pub enum Event {
    /// A frame of the camera.
    Frame {
        /// Middle of its exposure.
        exposed: Seconds,
        /// The JPEG file.
        jpeg: Vec<u8>,
    },
    /// A move begins.
    Motion {
        /// When.
        start: Seconds,
        /// When along the slicer's own plan `[s]`.
        path_s: f64,
        /// The move.
        segment: Box<Segment>,
    },
    /// Status of printer and job.
    Printer(Box<PrinterStatus>),
    /// The estimator's newest word.
    Estimate(EstimateReading),
}

/// What the classifier reads of a state estimate.
#[derive(Debug, Clone, PartialEq)]
pub struct EstimateReading {
    /// Time of validity.
    pub stamp: Seconds,
    /// Nozzle temperature.
    pub nozzle: Kelvin,
    /// Windowed sum of normalised innovations squared per channel; 0 where its window is not full.
    pub chi_square: Vec<f64>,
    /// Updates in a window.
    pub window: u32,
}

/// What the classifier says.
#[derive(Debug, Clone, PartialEq)]
pub enum Output {
    /// What a frame shows.
    Defects(Box<Defects>),
    /// A measured width.
    Width(WidthMeasurement),
    /// Quality of a layer.
    Quality(LayerFigure),
    /// A frame with what was found drawn in it.
    Picture {
        /// Middle of its exposure.
        exposed: Seconds,
        /// The JPEG file.
        jpeg: Vec<u8>,
    },
    /// A change worth a line in the print's log.
    Note(Note),
}

/// What one frame shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Defects {
    /// Middle of the exposure.
    pub exposed: Seconds,
    /// Frames judged or refused since start.
    pub frame: u64,
    /// What is to be seen, or why the frame cannot be judged.
    pub judged: Result<Judged, Unusable>,
}

/// What a frame that can be judged shows.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// Softmax, one per class of [`Classifier::classes`](crate::Classifier::classes).
    pub probabilities: Vec<f64>,
    /// All frames and residuals together.
    pub fused: Fused,
    /// Where what was laid before lies, where known.
    pub offset: Option<Offset>,
    /// Seams beside what is usual at their places, where enough were seen for the first time.
    pub seams: Option<SeamReading>,
    /// Share of the strong edges in the picture that no commanded road explains `[0, 1]`.
    pub unexplained: f64,
    /// Place of the defect: column, row, width, height `[px]`, where known.
    pub region_px: Option<[u32; 4]>,
}

/// How much a note matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weight {
    /// For the record.
    Info,
    /// Somebody should look.
    Warn,
}

/// A change.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// When.
    pub stamp: Seconds,
    /// How much it matters.
    pub weight: Weight,
    /// What changed, snake_case.
    pub what: &'static str,
    /// Why, with numbers.
    pub why: String,
    /// Value before.
    pub before: String,
    /// Value after.
    pub after: String,
}
