//! Faults that the plant can show, and what is in force at a moment.

use models::units::Seconds;
use serde::{Deserialize, Serialize};

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
    /// Thermistor: the reading stays where it was; size unused.
    Stuck,
    /// Thermistor: added to the reading `[K]`, -300..300.
    Bias,
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
    /// Factor on the heater's power `[-]`.
    pub heater_gain: f64,
    /// The heater's switch conducts whatever the duty.
    pub heater_stuck_on: bool,
    /// Factor on the part fan's flow `[-]`.
    pub fan_gain: f64,
    /// Fault of the thermistor circuit.
    pub thermistor: Thermistor,
    /// Added to the reading `[K]`.
    pub reading_bias_k: f64,
    /// Added to the air temperature `[K]`.
    pub ambient_offset_k: f64,
    /// The part has come off the bed: what is extruded does not land on it.
    pub detached: bool,
}

/// State of the thermistor circuit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Thermistor {
    /// Reads the block.
    Sound,
    /// Open circuit.
    Open,
    /// Short circuit.
    Short,
    /// Hangs beside the block; share of the coupling left `[-]`.
    Detached(f64),
    /// Repeats its last reading.
    Stuck,
}

impl InForce {
    /// Nothing wrong.
    pub const NONE: Self = Self {
        slip: 0.0,
        clog: 1.0,
        leak: 0.0,
        diameter: 1.0,
        run_out: false,
        heater_gain: 1.0,
        heater_stuck_on: false,
        fan_gain: 1.0,
        thermistor: Thermistor::Sound,
        reading_bias_k: 0.0,
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
            (Component::Extruder, Kind::Clog) => self.clog *= towards(fault.size),
            // Each takes its share of what the others leave.
            (Component::Extruder, Kind::Leak) => {
                self.leak = 1.0 - (1.0 - self.leak) * (1.0 - share * fault.size);
            }
            (Component::Filament, Kind::Diameter) => self.diameter *= 1.0 + share * fault.size,
            (Component::Filament, Kind::RunOut) => self.run_out = true,
            (Component::HotendHeater, Kind::Gain) => self.heater_gain *= towards(fault.size),
            (Component::HotendHeater, Kind::StuckOn) => self.heater_stuck_on = true,
            (Component::Fan, Kind::Gain) => self.fan_gain *= towards(fault.size),
            (Component::HotendThermistor, Kind::Open) => self.thermistor = Thermistor::Open,
            (Component::HotendThermistor, Kind::Short) => self.thermistor = Thermistor::Short,
            (Component::HotendThermistor, Kind::Detached) => {
                self.thermistor = Thermistor::Detached(fault.size)
            }
            (Component::HotendThermistor, Kind::Stuck) => self.thermistor = Thermistor::Stuck,
            (Component::HotendThermistor, Kind::Bias) => self.reading_bias_k += share * fault.size,
            (Component::Ambient, Kind::Draught) => self.ambient_offset_k += share * fault.size,
            (Component::Part, Kind::Detached) => self.detached = true,
            // What happens in one moment is in `toolhead`; scenario and service refuse every other pair.
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slip(ramp_s: f64, duration_s: Option<f64>) -> Fault {
        Fault {
            component: Component::Extruder,
            kind: Kind::Slip,
            size: 0.1,
            ramp: Seconds(ramp_s),
            duration: duration_s.map(Seconds),
            onset: Seconds(10.0),
        }
    }

    #[test]
    fn a_step_is_whole_from_its_onset_and_gone_after_its_duration() {
        let at = |now_s: f64| InForce::at(Seconds(now_s), &[slip(0.0, Some(5.0))]).slip;
        assert_eq!(
            [at(9.999), at(10.0), at(14.999), at(15.0)].map(|slip| slip > 0.0),
            [false, true, true, false]
        );
    }

    #[test]
    fn a_ramp_grows_linearly_and_stays() {
        let at = |now_s: f64| InForce::at(Seconds(now_s), &[slip(4.0, None)]).slip;
        assert!((at(11.0) - 0.025).abs() < 1e-12);
        assert!((at(99.0) - 0.1).abs() < 1e-12);
    }

    #[test]
    fn two_slips_add_up() {
        let both = InForce::at(Seconds(20.0), &[slip(0.0, None), slip(0.0, None)]);
        assert!((both.slip - 0.2).abs() < 1e-12);
    }
}
