//! Firmware of the heaters: set-points in force, controllers, duties.

use crate::params::PlantParams;
use models::heater::Pid;
use models::units::Celsius;

/// Firmware of the heaters: set-points in force, controllers, duties.
pub(crate) struct Heaters {
    hotend: Pid,
    bed: Pid,
    pub(crate) hotend_target: Celsius,
    pub(crate) bed_target: Celsius,
    pub(crate) hotend_duty: f64,
    pub(crate) bed_duty: f64,
    /// What the firmware reads of the hot end.
    pub(crate) hotend_reading: Celsius,
}

impl Heaters {
    /// Both off.
    pub(crate) fn new(plant: &PlantParams) -> Self {
        Self {
            hotend: Pid::new(plant.heater, plant.hotend.heater_power_w),
            bed: Pid::new(plant.bed_heater, plant.bed.heater_power_w),
            hotend_target: Celsius(0.0),
            bed_target: Celsius(0.0),
            hotend_duty: 0.0,
            bed_duty: 0.0,
            hotend_reading: Celsius(0.0),
        }
    }

    /// One period of the firmware's loops; a set-point of zero switches off.
    pub(crate) fn update(&mut self, plant: &PlantParams, hotend: Celsius, bed: Celsius) {
        let duty = |pid: &mut Pid, target: Celsius, read: Celsius, power_w: f64| {
            if target.0 > 0.0 {
                pid.update(target.into(), read.into()).map_or(0.0, |watt| watt / power_w)
            } else {
                pid.reset();
                0.0
            }
        };
        self.hotend_reading = hotend;
        self.hotend_duty = duty(&mut self.hotend, self.hotend_target, hotend, plant.hotend.heater_power_w);
        self.bed_duty = duty(&mut self.bed, self.bed_target, bed, plant.bed.heater_power_w);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::tests::load;

    #[derive(serde::Deserialize)]
    struct PlantFile {
        plant: PlantParams,
    }

    /// A heater whose thermistor tells nothing is off; one that reads too cold is not.
    #[test]
    fn a_reading_that_is_none_switches_off() {
        let PlantFile { plant } = load("plants/ender3.yaml");
        let mut heaters = Heaters::new(&plant);
        (heaters.hotend_target, heaters.bed_target) = (Celsius(210.0), Celsius(60.0));
        for (reading, on) in [(20.0, true), (f64::NAN, false)] {
            heaters.update(&plant, Celsius(reading), Celsius(reading));
            assert_eq!((heaters.hotend_duty > 0.0, heaters.bed_duty > 0.0), (on, on), "{reading}");
        }
    }
}
