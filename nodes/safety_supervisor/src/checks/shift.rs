//! P8: what was laid lies elsewhere than it was laid.
//!
//! The camera tells by how much, frame by frame. Beyond the limit in many frames in a row it is a layer shift; after an
//! impulse, which lost steps never lack, a few are enough. It is never corrected: the machine does not know where it is.

use models::units::Seconds;

use crate::params::ShiftParams;

/// Watches the offset of what was laid before.
#[derive(Debug, Clone)]
pub struct ShiftCheck {
    params: ShiftParams,
    beyond: u32,
    impulse: bool,
    newest_m: Option<f64>,
}

impl ShiftCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: ShiftParams) -> Self {
        Self { params, beyond: 0, impulse: false, newest_m: None }
    }

    /// Takes the offset in x and y `[m]` of one frame; `None` where the frame does not tell. `impulse`: one was
    /// flagged within [`ShiftCheck::memory`].
    pub fn on_offset(&mut self, offset_m: Option<[f64; 2]>, impulse: bool) {
        self.impulse = impulse;
        let Some([x_m, y_m]) = offset_m else { return };
        let offset_m = x_m.hypot(y_m);
        self.newest_m = Some(offset_m);
        self.beyond = if offset_m > self.limit_m() { self.beyond.saturating_add(1) } else { 0 };
    }

    /// Offset that was seen last `[m]`.
    #[must_use]
    pub fn newest_m(&self) -> Option<f64> {
        self.newest_m
    }

    /// How long an impulse counts as a hint.
    #[must_use]
    pub fn memory(&self) -> Seconds {
        Seconds(self.params.impulse_s)
    }

    /// Offset `[m]` beyond which it counts: what the machine's own kinematics explains is not the print's fault.
    #[must_use]
    pub fn limit_m(&self) -> f64 {
        self.params.offset_max_m + self.params.machine_error_m
    }

    /// Whether it is a layer shift.
    #[must_use]
    pub fn tripped(&self) -> bool {
        self.beyond >= if self.impulse { self.params.frames_after_impulse } else { self.params.frames }
    }

    /// A person has looked: starts anew.
    pub fn reset(&mut self) {
        *self = Self::new(self.params);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(machine_error_m: f64) -> ShiftCheck {
        ShiftCheck::new(ShiftParams {
            offset_max_m: 5e-4,
            machine_error_m,
            frames: 3,
            frames_after_impulse: 2,
            impulse_s: 30.0,
        })
    }

    #[test]
    fn three_frames_in_a_row_trip_two_after_an_impulse() {
        for (impulse, wanted) in [(false, 3), (true, 2)] {
            let mut check = check(0.0);
            for frame in 1..=wanted {
                assert!(!check.tripped(), "frame {frame}");
                check.on_offset(Some([-8e-4, 0.0]), impulse);
            }
            assert!(check.tripped());
            check.reset();
            assert!(!check.tripped(), "a person has looked");
        }
    }

    #[test]
    fn a_frame_that_does_not_tell_counts_neither_way_and_a_sound_one_ends_it() {
        let mut check = check(0.0);
        for offset_m in [Some([8e-4, 0.0]), Some([8e-4, 0.0]), None] {
            check.on_offset(offset_m, false);
        }
        assert!(!check.tripped());
        check.on_offset(Some([0.0, 0.0]), false);
        check.on_offset(Some([8e-4, 0.0]), false);
        assert!(!check.tripped());
    }

    /// 0.8 mm are a shift on a machine that is right to 0.1 mm, and none on one that is right to 0.4 mm.
    #[test]
    fn the_machines_own_error_widens_the_limit() {
        for (machine_error_m, trips) in [(1e-4, true), (4e-4, false)] {
            let mut check = check(machine_error_m);
            (0..3).for_each(|_| check.on_offset(Some([0.0, 8e-4]), false));
            assert_eq!(check.tripped(), trips);
        }
    }
}
