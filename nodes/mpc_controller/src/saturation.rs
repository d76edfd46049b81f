//! K5: an actuator at its stop for long. What stands there cannot correct any more, whatever the plan says.

use crate::params::RawHealth;
use crate::qp::{Move, input};

/// Moves, and the heater.
const ACTUATORS: usize = input::COUNT + 1;

/// How long each actuator has stood at its stop, less how long it has not since `[s]`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Saturation {
    params: RawHealth,
    low: Move,
    high: Move,
    stood_s: [f64; ACTUATORS],
}

impl Saturation {
    pub(crate) fn new(params: RawHealth, low: Move, high: Move) -> Self {
        Self { params, low, high, stood_s: [0.0; ACTUATORS] }
    }

    pub(crate) fn clear(&mut self) {
        self.stood_s = [0.0; ACTUATORS];
    }

    /// Whether the heater gives all it can.
    pub(crate) fn is_heater_at_stop(&self, duty: f64) -> bool {
        duty >= self.params.duty_stop
    }

    /// A period `dt_s` with this move in force and this duty of the heater.
    pub(crate) fn on_period(&mut self, dt_s: f64, held: &Move, duty: f64) {
        let at_stop: [bool; ACTUATORS] = std::array::from_fn(|index| match held.get(index) {
            Some(value) => {
                let (low, high) = (self.low[index], self.high[index]);
                let near = self.params.margin * (high - low);
                // a way without room is switched off: who rests at its end is not at a stop
                (low < -near && value - low <= near) || (high > near && high - value <= near)
            }
            None => self.is_heater_at_stop(duty),
        });
        for (stood_s, at_stop) in self.stood_s.iter_mut().zip(at_stop) {
            let change_s = if at_stop { dt_s } else { -dt_s };
            *stood_s = (*stood_s + change_s).clamp(0.0, self.params.saturated_s + dt_s);
        }
    }

    /// Longest of all `[s]`.
    pub(crate) fn longest_s(&self) -> f64 {
        self.stood_s.iter().fold(0.0, |most, stood_s| most.max(*stood_s))
    }

    pub(crate) fn is_long(&self) -> bool {
        self.longest_s() >= self.params.saturated_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn watched() -> Saturation {
        let params =
            RawHealth { soften: true, late_max: 3, saturated_s: 28.0, duty_stop: 0.99, margin: 1e-3 };
        Saturation::new(params, [-0.25, -0.3, 0.0], [0.25, 0.15, 0.0])
    }

    fn told_at(held: Move, duty: impl Fn(u32) -> f64) -> Option<f64> {
        let mut saturation = watched();
        (1..480)
            .find(|step| {
                saturation.on_period(0.25, &held, duty(*step));
                saturation.is_long()
            })
            .map(|step| f64::from(step) * 0.25)
    }

    #[test]
    fn each_actuator_tells_after_its_time_and_one_without_room_never() {
        assert_eq!(told_at([0.0; 3], |_| 1.0), Some(28.0));
        assert_eq!(told_at([0.25, 0.0, 0.0], |_| 0.5), Some(28.0));
        assert_eq!(told_at([0.0, -0.2999, 0.0], |_| 0.5), Some(28.0));
        assert_eq!(told_at([0.2, 0.1, 0.0], |_| 0.5), None);
        // at the stop half of the time
        assert_eq!(told_at([0.0; 3], |step| f64::from(step % 2)), None);
    }

    /// Never faster than the slicer: its speed is where the path rests. Slower is still a stop.
    #[test]
    fn a_way_without_room_is_no_stop_and_the_other_one_is() {
        let params = watched().params;
        for (low, high) in [(-0.3, 0.0), (0.0, 0.15)] {
            let mut saturation = Saturation::new(params, [-0.25, low, 0.0], [0.25, high, 0.0]);
            (0..480).for_each(|_| saturation.on_period(0.25, &[0.0; 3], 0.5));
            assert!(saturation.longest_s().abs() < f64::EPSILON, "{low} to {high}");
            (0..480).for_each(|_| saturation.on_period(0.25, &[0.0, low + high, 0.0], 0.5));
            assert!(saturation.is_long(), "{low} to {high}");
        }
    }

    #[test]
    fn once_off_its_stop_it_heals() {
        let mut saturation = watched();
        (0..2000).for_each(|_| saturation.on_period(0.25, &[0.0; 3], 1.0));
        saturation.on_period(0.25, &[0.0; 3], 0.5);
        saturation.on_period(0.25, &[0.0; 3], 0.5);
        assert!(!saturation.is_long());
    }
}
