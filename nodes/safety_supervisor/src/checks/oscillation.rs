//! K7: a limit cycle of the corrections, by the turns of what the controller sends.
//!
//! A turn is a change of direction after a way larger than a deadband, wherever the middle of the swing lies: noise
//! below the deadband and a correction that settles have none, a limit cycle has two a period.

use models::command::Trims;
use models::units::Seconds;

use crate::checks::bad_values::Burst;
use crate::params::OscillationParams;

/// Turns of one value.
#[derive(Debug, Clone)]
struct Swing {
    deadband: f64,
    /// Farthest value in the direction of the way, and that direction; 0 before there is one.
    farthest: Option<(f64, f64)>,
    turns: Burst,
}

impl Swing {
    fn new(deadband: f64, params: &OscillationParams) -> Self {
        Self { deadband, farthest: None, turns: Burst::new(params.turns) }
    }

    fn on_value(&mut self, now: Seconds, value: f64) {
        let Some((farthest, direction)) = self.farthest else {
            self.farthest = Some((value, 0.0));
            return;
        };
        let way = value - farthest;
        if way * direction > 0.0 {
            self.farthest = Some((value, direction));
        } else if way.abs() > self.deadband {
            if direction != 0.0 {
                self.turns.note(now);
            }
            self.farthest = Some((value, way.signum()));
        }
    }
}

/// Watches flow, speed and set-point of the commands.
#[derive(Debug, Clone)]
pub struct OscillationCheck {
    params: OscillationParams,
    swings: [Swing; 3],
}

impl OscillationCheck {
    /// A check that has seen nothing.
    #[must_use]
    pub fn new(params: OscillationParams) -> Self {
        let swings = [params.flow, params.speed, params.setpoint_k].map(|band| Swing::new(band, &params));
        Self { params, swings }
    }

    /// Takes corrections received at `now`; ones that are not finite are judged elsewhere.
    pub fn on_trims(&mut self, now: Seconds, trims: &Trims) {
        let values = [trims.flow, trims.speed, trims.setpoint_offset_k];
        for (swing, value) in self.swings.iter_mut().zip(values).filter(|(_, value)| value.is_finite()) {
            swing.on_value(now, value);
        }
    }

    /// Corrections are not carried out: turns so far stay known, but the way back is none.
    pub fn rest(&mut self) {
        self.swings.iter_mut().for_each(|swing| swing.farthest = None);
    }

    /// Whether one of them has turned too often.
    #[must_use]
    pub fn tripped(&self, now: Seconds) -> bool {
        self.swings.iter().any(|swing| swing.turns.tripped(now))
    }

    /// Forgets every turn.
    pub fn reset(&mut self) {
        *self = Self::new(self.params);
    }
}
