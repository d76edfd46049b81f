//! Faults that the plant can show, and what is in force at a moment.

use models::units::Seconds;
use serde::{Deserialize, Serialize};

mod feed;
mod sensor;
pub use feed::{Feed, Line};
pub use sensor::{SensorFaults, Thermistor};

/// Least share of a nozzle that faults together leave free, and least share of the melt that they leave it `[-]`: of none
/// there is no law.
const LEFT_MIN: f64 = 0.01;

/// Part of the printer that fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Component {
    /// Drive gear, filament path and nozzle.
    Extruder,
    /// The filament itself.
    Filament,
    /// Hot end heater.
    HotendHeater,
    /// Hot end thermistor.
    HotendThermistor,
    /// Bed heater.
    BedHeater,
    /// Bed thermistor.
    BedThermistor,
    /// Filament encoder; the firmware's own loop reads it too.
    Encoder,
    /// Inertial unit on the tool head.
    Imu,
    /// Camera on the tool head.
    Camera,
    /// Emergency-stop button and door contact, in one circuit.
    StopInput,
    /// Part fan.
    Fan,
    /// Air around the printer.
    Ambient,
    /// Axes of the tool.
    Motion,
    /// What has been printed so far.
    Part,
}

/// How it fails; `size` has the unit stated here.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Extruder: added slip of the drive gear `[-]`, 0..0.95.
    Slip,
    /// Extruder: free area of the nozzle passage, factor `[-]`, 0.05..1.
    Clog,
    /// Extruder: share of the melt that escapes beside the nozzle (a loose nozzle, a gap at the heat break) `[-]`,
    /// 0..0.9. It has passed gear and encoder: no sensor of the filament sees it.
    Leak,
    /// Filament: relative change of the diameter `[-]`, -0.1..0.1.
    Diameter,
    /// Filament: it has ended; size unused.
    RunOut,
    /// Heater: factor on its power `[-]`, 0 (dead) .. 1.
    Gain,
    /// Heater: full power whatever the duty says, until the mains relay opens; size unused. Fan: gain, see `Gain`.
    StuckOn,
    /// Thermistor: circuit open, the firmware reads far too cold; size unused.
    Open,
    /// Thermistor: short circuit, the firmware reads far too hot; size unused.
    Short,
    /// Thermistor: fell out of the block; share of the coupling that is left `[-]`, 0..1. Part: has come off the bed,
    /// nothing lands on it any more; for good, size unused.
    Detached,
    /// Thermistor: the reading stays where it was; size unused. Encoder, imu, camera: the last count, batch or frame again,
    /// with new stamps.
    Stuck,
    /// Encoder, imu, camera: nothing comes; size unused.
    Off,
    /// Thermistor: added to the reading `[K]`, -300..300.
    Bias,
    /// Thermistor: factor on the standard deviation of its noise `[-]`, 1..100.
    Noise,
    /// Thermistor: share of the readings that are off by 30 K either way `[-]`, 0..0.5.
    Spikes,
    /// Thermistor: share of the readings that are taken while its plug is open `[-]`, 0..0.95.
    Loose,
    /// Stop input: the contact opens, a person presses the button or opens the door; size unused.
    Pressed,
    /// Ambient: added to the air temperature `[K]`, -30..30, with 30 % more loss of the block per -10 K.
    Draught,
    /// Motion: steps of the x motor are lost at once; the tool is off by this much from then on `[m]`, -0.05..0.05.
    /// A four-step skip of a 20-tooth GT2 drive is 0.8 mm. Homing the axis ends it, a pause does not.
    LayerShiftX,
    /// Motion: as `LayerShiftX`, in y.
    LayerShiftY,
    /// Motion: something hits the tool head; peak acceleration `[m/s2]`, 0..200. Nothing else comes of it.
    Knock,
}

impl Kind {
    /// It is there or not, whatever its component.
    #[must_use]
    pub fn has_no_size(self) -> bool {
        use Kind::{Off, Open, Pressed, RunOut, Short, Stuck, StuckOn};
        matches!(self, RunOut | StuckOn | Open | Short | Stuck | Off | Pressed)
    }

    /// It differs from seed to seed.
    #[must_use]
    pub fn is_random(self) -> bool {
        matches!(self, Self::Noise | Self::Spikes | Self::Loose)
    }

    /// It happens in one moment: no ramp, no duration.
    #[must_use]
    pub fn at_once(self) -> bool {
        matches!(self, Self::LayerShiftX | Self::LayerShiftY | Self::Knock)
    }
}

/// One fault with its course in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fault {
    /// What fails.
    pub component: Component,
    /// How it fails.
    pub kind: Kind,
    /// How much, unit by kind.
    pub size: f64,
    /// Time to grow from nothing to full size `[s]`; 0 for a step.
    pub ramp: Seconds,
    /// How long it lasts from onset; `None` for good.
    pub duration: Option<Seconds>,
    /// When it set in.
    pub onset: Seconds,
    /// Seed of its random part; `None` for the run's own.
    pub seed: Option<u64>,
}

impl Fault {
    /// Share of the full size at `now`, `[0, 1]`.
    fn share(&self, now: Seconds) -> f64 {
        let age_s = (now - self.onset).0;
        let over = self.duration.is_some_and(|duration| age_s >= duration.0);
        if age_s < 0.0 || over {
            0.0
        } else if self.ramp.0 > 0.0 {
            (age_s / self.ramp.0).min(1.0)
        } else {
            1.0
        }
    }
}

/// What the faults together do to the plant at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InForce {
    /// Added slip `[-]`.
    pub slip: f64,
    /// Free share of the nozzle passage `[-]`.
    pub clog: f64,
    /// Share of the melt that escapes beside the nozzle `[-]`.
    pub leak: f64,
    /// Factor on the diameter `[-]`.
    pub diameter: f64,
    /// The filament has ended.
    pub run_out: bool,
    /// Hot end heater.
    pub hotend_heater: HeaterFaults,
    /// Bed heater.
    pub bed_heater: HeaterFaults,
    /// Factor on the part fan's flow and speed `[-]`.
    pub fan_gain: f64,
    /// Hot end thermistor.
    pub hotend_sensor: SensorFaults,
    /// Bed thermistor.
    pub bed_sensor: SensorFaults,
    /// Filament encoder.
    pub encoder: Feed,
    /// Inertial unit.
    pub imu: Feed,
    /// Camera.
    pub camera: Feed,
    /// The stop contact is open.
    pub stop_input: bool,
    /// Added to the air temperature `[K]`.
    pub ambient_offset_k: f64,
    /// The part has come off the bed: what is extruded does not land on it.
    pub detached: bool,
}

/// What is wrong with a heater.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeaterFaults {
    /// Factor on its power `[-]`.
    pub gain: f64,
    /// Its switch conducts whatever the duty.
    pub stuck_on: bool,
}

impl HeaterFaults {
    const NONE: Self = Self { gain: 1.0, stuck_on: false };

    fn overlay(&mut self, kind: Kind, size: f64, share: f64) {
        match kind {
            Kind::Gain => self.gain *= 1.0 + share * (size - 1.0),
            Kind::StuckOn => self.stuck_on = true,
            _ => {}
        }
    }

    /// Power of the rated one `[-]` at this duty; a shorted switch needs only the mains.
    #[must_use]
    pub fn power_share(&self, duty: f64, mains_on: bool) -> f64 {
        self.gain * if self.stuck_on && mains_on { 1.0 } else { duty }
    }
}

impl InForce {
    /// Nothing wrong.
    pub const NONE: Self = Self {
        slip: 0.0,
        clog: 1.0,
        leak: 0.0,
        diameter: 1.0,
        run_out: false,
        hotend_heater: HeaterFaults::NONE,
        bed_heater: HeaterFaults::NONE,
        fan_gain: 1.0,
        hotend_sensor: SensorFaults::NONE,
        bed_sensor: SensorFaults::NONE,
        encoder: Feed::Live,
        imu: Feed::Live,
        camera: Feed::Live,
        stop_input: false,
        ambient_offset_k: 0.0,
        detached: false,
    };

    /// Overlays all faults that are active at `now`.
    #[must_use]
    pub fn at(now: Seconds, faults: &[Fault]) -> Self {
        let mut all = Self::NONE;
        for fault in faults {
            let share = fault.share(now);
            if share > 0.0 {
                all.overlay(fault, share);
            }
        }
        all
    }

    fn overlay(&mut self, fault: &Fault, share: f64) {
        let towards = |size: f64| 1.0 + share * (size - 1.0);
        match (fault.component, fault.kind) {
            (Component::Extruder, Kind::Slip) => self.slip += share * fault.size,
            (Component::Extruder, Kind::Clog) => self.clog = (self.clog * towards(fault.size)).max(LEFT_MIN),
            // Each takes its share of what the others leave.
            (Component::Extruder, Kind::Leak) => {
                let kept = (1.0 - self.leak) * (1.0 - share * fault.size);
                self.leak = 1.0 - kept.max(LEFT_MIN);
            }
            (Component::Filament, Kind::Diameter) => self.diameter *= 1.0 + share * fault.size,
            (Component::Filament, Kind::RunOut) => self.run_out = true,
            (Component::HotendHeater, kind) => self.hotend_heater.overlay(kind, fault.size, share),
            (Component::BedHeater, kind) => self.bed_heater.overlay(kind, fault.size, share),
            (Component::Fan, Kind::Gain) => self.fan_gain *= towards(fault.size),
            (Component::HotendThermistor, kind) => self.hotend_sensor.overlay(kind, fault.size, share),
            (Component::BedThermistor, kind) => self.bed_sensor.overlay(kind, fault.size, share),
            (Component::Encoder, kind) => self.encoder.overlay(kind),
            (Component::Imu, kind) => self.imu.overlay(kind),
            (Component::Camera, kind) => self.camera.overlay(kind),
            (Component::StopInput, Kind::Pressed) => self.stop_input = true,
            (Component::Ambient, Kind::Draught) => self.ambient_offset_k += share * fault.size,
            (Component::Part, Kind::Detached) => self.detached = true,
            // What happens in one moment is in `toolhead`; scenario and service refuse every other pair.
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests;
