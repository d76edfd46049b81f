//! What a job yields: timed moves and the actions between them.

use super::trapezoid::{PathState, Trapezoid};
use crate::units::{Celsius, Seconds};
use serde::Serialize;

/// What a move does with tool and filament.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MoveKind {
    /// The tool moves, the filament rests.
    Travel,
    /// The tool moves in the layer and filament advances: a road is laid.
    Deposit,
    /// Filament alone moves back.
    Retract,
    /// Filament advances while the tool rests or only rises: a retraction is undone, or pressure built.
    Prime,
    /// The tool moves while filament moves back.
    Wipe,
}

/// What a road is for, as the slicer says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Default)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Not stated.
    #[default]
    Unknown,
    /// Start and end code of the printer's owner.
    Custom,
    /// Skirt, brim, raft border.
    Skirt,
    /// Visible wall.
    ExternalPerimeter,
    /// Wall behind the visible one.
    Perimeter,
    /// Wall over air.
    Overhang,
    /// Sparse infill.
    Infill,
    /// Dense infill, top and bottom skin.
    Solid,
    /// Top skin.
    TopSolid,
    /// Strand over a gap.
    Bridge,
    /// Narrow gap between walls.
    GapFill,
    /// Support and its interface.
    Support,
    /// Ironing of the top.
    Ironing,
    /// Purge tower.
    Tower,
}

/// One timed straight move.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Segment {
    /// Line of the file, from 1.
    pub line: u64,
    /// Layer from 0; `None` before the first.
    pub layer: Option<u32>,
    /// Start in machine coordinates `[m]`.
    pub start_m: [f64; 3],
    /// End in machine coordinates `[m]`.
    pub end_m: [f64; 3],
    /// Way of the tool `[m]`; 0 where only filament moves.
    pub length_m: f64,
    /// Filament pushed `[m]`, negative in a retraction.
    pub filament_m: f64,
    /// What the move does.
    pub kind: MoveKind,
    /// What the road is for.
    pub role: Role,
    /// Chord of an arc or a spline.
    pub arc: bool,
    /// Width of the stadium with the commanded volume per length `[m]`:
    /// `w = A/h + h(1 - pi/4)`, `A = e pi d^2 / (4 l)`. Only where a road is laid and its height is known.
    pub target_width_m: Option<f64>,
    /// Width as the slicer's comment states it `[m]`.
    pub stated_width_m: Option<f64>,
    /// Height of the road `[m]`.
    pub layer_height_m: Option<f64>,
    /// Speed over the path variable, see [`Segment::path_m`].
    pub profile: Trapezoid,
}

impl Segment {
    /// The path variable's range `[m]`: way of the tool, or |filament| where the tool rests.
    #[must_use]
    pub fn path_m(&self) -> f64 {
        if self.length_m > 0.0 { self.length_m } else { self.filament_m.abs() }
    }

    /// Filament per path variable `[-]`, signed: `feed_m_s = speed_m_s * filament_per_path()`.
    #[must_use]
    pub fn filament_per_path(&self) -> f64 {
        self.filament_m / self.path_m()
    }

    /// Tool position and path state at `time` since the start of the move.
    #[must_use]
    pub fn at(&self, time: Seconds) -> ([f64; 3], PathState) {
        let state = self.profile.at(time);
        let share = (state.distance_m / self.path_m()).clamp(0.0, 1.0);
        let point = |axis: usize| self.start_m[axis] + (self.end_m[axis] - self.start_m[axis]) * share;
        ([point(0), point(1), point(2)], state)
    }
}

/// What happens between moves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// Hot end set-point; 0 degC is off.
    HotendTarget {
        /// Set-point.
        target: Celsius,
        /// The job waits until it is reached.
        wait: bool,
    },
    /// Bed set-point; 0 degC is off.
    BedTarget {
        /// Set-point.
        target: Celsius,
        /// The job waits until it is reached.
        wait: bool,
    },
    /// Part fan `[0, 1]`.
    Fan(f64),
    /// Axes X, Y, Z to be homed; the tool is at their zero afterwards.
    Home([bool; 3]),
    /// Nothing for this long.
    Dwell(Seconds),
    /// Pressure advance `[s]`.
    Advance(Seconds),
    /// Another tool.
    Tool(u32),
    /// Wait for a person: `M0`, `M1`, `M25`, `M226`, `M600`, `PAUSE`.
    Pause,
    /// A layer begins.
    LayerChange {
        /// Index from 0.
        layer: u32,
        /// Height of its top over the bed where known `[m]`.
        z_m: Option<f64>,
    },
    /// Path speed factor `[-]` (`M220`); the planned profile does not contain it.
    SpeedFactor(f64),
    /// Filament factor `[-]` (`M221`); `filament_m` does not contain it.
    FlowFactor(f64),
    /// Emergency stop in the file (`M112`).
    Stop,
    /// The file has ended.
    End,
}

impl Action {
    /// Whether the machine stands still for it; the others happen between two moves in flight.
    #[must_use]
    pub fn stops(&self) -> bool {
        match self {
            Self::HotendTarget { wait, .. } | Self::BedTarget { wait, .. } => *wait,
            Self::Home(_) | Self::Dwell(_) | Self::Tool(_) | Self::Pause | Self::Stop | Self::End => true,
            Self::Fan(_)
            | Self::Advance(_)
            | Self::LayerChange { .. }
            | Self::SpeedFactor(_)
            | Self::FlowFactor(_) => false,
        }
    }
}

/// One step of a job.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum Step {
    /// A timed move.
    Move(Segment),
    /// An action and its line, from 1.
    Action(Action, u64),
}
