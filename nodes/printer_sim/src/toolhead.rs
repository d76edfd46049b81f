//! Where the tool really is: commanded position plus steps that the motors lost.

/// What the motors have lost since they were last homed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Toolhead {
    shift_m: [f64; 2],
}

impl Toolhead {
    /// Loses steps at once, x and y `[m]`: from now on the tool is off by this much more.
    pub fn lose_steps(&mut self, lost_m: [f64; 2]) {
        for (shift_m, lost_m) in self.shift_m.iter_mut().zip(lost_m) {
            *shift_m += lost_m;
        }
    }

    /// Axes X, Y, Z find their end stops: nothing else brings lost steps back.
    pub fn home(&mut self, axes: [bool; 3]) {
        for (shift_m, homed) in self.shift_m.iter_mut().zip(axes) {
            if homed {
                *shift_m = 0.0;
            }
        }
    }

    /// How far the tool is off its commanded place, x and y `[m]`.
    #[must_use]
    pub fn shift_m(&self) -> [f64; 2] {
        self.shift_m
    }

    /// Where the tool is when the firmware believes it to be at `commanded_m` `[m]`.
    #[must_use]
    pub fn position_m(&self, [x_m, y_m, z_m]: [f64; 3]) -> [f64; 3] {
        [x_m + self.shift_m[0], y_m + self.shift_m[1], z_m]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn skips_add_up_and_only_homing_of_their_axis_ends_them() {
        let mut tool = Toolhead::default();
        tool.lose_steps([8e-4, 0.0]);
        tool.lose_steps([8e-4, -8e-4]);
        let off = |wanted_m: [f64; 3], tool_m: [f64; 3]| {
            wanted_m.iter().zip(tool_m).map(|(a, b)| (a - b).abs()).sum::<f64>()
        };
        assert!(off([0.1 + 1.6e-3, 0.1 - 8e-4, 0.01], tool.position_m([0.1, 0.1, 0.01])) < 1e-12);
        tool.home([true, false, true]);
        assert!(off([0.1, 0.1 - 8e-4, 0.01], tool.position_m([0.1, 0.1, 0.01])) < 1e-12);
    }
}
