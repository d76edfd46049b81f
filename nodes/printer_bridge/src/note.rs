//! What is worth a line in the print's log.

use crate::firmware::Firmware;
use models::status::JobPhase;

/// How much a person has to care.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// Told for the record.
    Info,
    /// Works with restrictions.
    Warn,
    /// Does not work.
    Error,
}

/// A decision or a find.
#[derive(Debug, Clone, PartialEq)]
pub enum Note {
    /// The line is open.
    Connected,
    /// The line was lost, or cannot be opened.
    Lost {
        /// Why, for people.
        reason: String,
    },
    /// Nothing was heard for longer than allowed: no state is sent.
    Stale {
        /// Time since the last line `[s]`.
        age_s: f64,
    },
    /// Lines come again.
    Fresh,
    /// The firmware has said what it is and can.
    Found(Firmware),
    /// A report names no such sensor: its topic stays without values.
    SensorMissing(Sensor),
    /// The firmware has started, also without having been asked.
    Started,
    /// The firmware has stopped itself.
    Halted {
        /// Its words.
        text: String,
    },
    /// An error that the firmware survives.
    FirmwareError {
        /// Its words.
        text: String,
    },
    /// The firmware wants a line again; the bridge sends no line twice.
    Resend,
    /// The job stands elsewhere.
    Job {
        /// Before; `None` for not known.
        before: Option<JobPhase>,
        /// Now.
        after: Option<JobPhase>,
    },
    /// The run-out switch sees no filament.
    OutOfFilament,
}

/// Sensors of a temperature report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Sensor {
    /// Thermistor of the hot end.
    Hotend,
    /// Thermistor of the bed.
    Bed,
}

impl Note {
    /// How much a person has to care.
    #[must_use]
    pub fn severity(&self) -> Severity {
        match self {
            Self::Lost { .. } | Self::Halted { .. } | Self::Job { after: Some(JobPhase::Failed), .. } => {
                Severity::Error
            }
            Self::Found(firmware) if firmware.protection_is_off() => Severity::Error,
            Self::Stale { .. }
            | Self::SensorMissing(_)
            | Self::Started
            | Self::FirmwareError { .. }
            | Self::Resend
            | Self::OutOfFilament => Severity::Warn,
            Self::Connected | Self::Fresh | Self::Found(_) | Self::Job { .. } => Severity::Info,
        }
    }
}
