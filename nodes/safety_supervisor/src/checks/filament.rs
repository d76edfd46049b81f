//! P6, P7: the encoder against the length the motor was told to push.
//!
//! Both are reduced to their forward way through a play, the backlash of drive gear and tube: retractions and
//! their way back count as strokes forward, jitter at rest does not count at all. Over a sliding window of the
//! motor's way the share that the encoder has not seen is slip. A stroke that slips is as long again on the motor's side,
//! and so is the play at its beginning: at the limit both lose the same share of short strokes, which would else be found
//! to slip more than long ones.

use crate::params::FilamentParams;

/// Marks kept over the window.
const MARKS: usize = 16;

/// Forward way of a position with play.
#[derive(Debug, Clone, Copy, Default)]
struct Way {
    held_m: Option<f64>,
    forward_m: f64,
}

impl Way {
    fn follow(&mut self, position_m: f64, play_m: f64) {
        let held_m = self.held_m.unwrap_or(position_m);
        self.forward_m += (position_m - held_m).max(0.0);
        self.held_m = Some(if position_m > held_m { position_m } else { held_m.min(position_m + play_m) });
    }
}

/// Watches slip and run-out.
#[derive(Debug, Clone)]
pub struct FilamentCheck {
    params: FilamentParams,
    motor: Way,
    encoder: Way,
    marks: [Option<(f64, f64)>; MARKS],
}

impl FilamentCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: FilamentParams) -> Self {
        Self { params, motor: Way::default(), encoder: Way::default(), marks: [None; MARKS] }
    }

    /// Takes the encoder's position.
    pub fn on_encoder(&mut self, position_m: f64) {
        self.encoder.follow(position_m, self.params.play_m);
    }

    /// Takes the motor's position.
    pub fn on_motor(&mut self, position_m: f64) {
        self.motor.follow(position_m, self.params.play_m / (1.0 - self.params.slip_max));
        let spacing_m = self.params.window_m / (MARKS - 1) as f64;
        let newest_m = self.marks[MARKS - 1].map(|(motor_m, _)| motor_m);
        if self.encoder.held_m.is_some()
            && newest_m.is_none_or(|newest_m| self.motor.forward_m - newest_m >= spacing_m)
        {
            self.marks.rotate_left(1);
            self.marks[MARKS - 1] = Some((self.motor.forward_m, self.encoder.forward_m));
        }
    }

    /// Slip over the window `[-]`, `None` until the motor has gone that far.
    #[must_use]
    pub fn slip(&self) -> Option<f64> {
        let (motor_m, encoder_m) = self.marks[0]?;
        let pushed_m = self.motor.forward_m - motor_m;
        Some(1.0 - (self.encoder.forward_m - encoder_m) / pushed_m)
    }

    /// Whether more was lost than allowed.
    #[must_use]
    pub fn tripped(&self) -> bool {
        self.slip().is_some_and(|slip| slip > self.params.slip_max)
    }

    /// Forgets the way so far: after a resume or a gap of either stream.
    pub fn reset(&mut self) {
        *self = Self::new(self.params);
    }
}
