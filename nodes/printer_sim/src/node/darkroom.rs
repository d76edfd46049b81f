//! The camera in a thread of its own: a frame takes longer to render than a step of the simulation may take.
//!
//! ```text
//! simulation --moments, in rolls--> Rig in its thread --shots--> simulation, `delay_s` after their exposure
//! ```
//! What comes out does not depend on how fast the thread is: a shot is handed out at its own simulated time, and where it
//! is not developed by then the simulation waits for it.

use crate::camera::{Camera, CameraParams, Moment, Rig, Shot};
use crate::pace::Pace;
use models::units::Seconds;
use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

/// Moments that go to the thread at once.
const ROLL: usize = 64;

/// What the thread is given: moments; where `exposed`, the shutter opens at the last of them.
struct Roll {
    moments: Vec<Moment>,
    exposed: bool,
}

/// A [`Rig`] at work beside the simulation.
pub(crate) struct Darkroom {
    /// The rig's own period, to know which moment it takes a picture at.
    period: Pace,
    delay_s: f64,
    moments: Vec<Moment>,
    /// Exposures whose shots have not been handed out.
    exposures: VecDeque<Seconds>,
    rolls: Sender<Roll>,
    shots: Receiver<Option<Shot>>,
}

impl Darkroom {
    /// A camera over an empty bed, see [`Rig::new`].
    #[must_use]
    pub(crate) fn new(params: &CameraParams, seed: u64) -> Self {
        let rig = Rig::new(params, seed);
        let (rolls, taken) = channel();
        let (given, shots) = channel();
        thread::spawn(move || develop(rig, &taken, &given));
        Self {
            period: Pace::dithered(params.period_s, params.dither),
            delay_s: params.delay_s,
            moments: Vec::with_capacity(ROLL),
            exposures: VecDeque::new(),
            rolls,
            shots,
        }
    }

    /// A thread that has failed takes nothing more: the camera is dark from then on.
    fn send(&mut self, exposed: bool) {
        let moments = std::mem::replace(&mut self.moments, Vec::with_capacity(ROLL));
        _ = self.rolls.send(Roll { moments, exposed });
    }
}

impl Camera for Darkroom {
    fn observe(&mut self, moment: &Moment) {
        self.moments.push(*moment);
        let exposed = self.period.due(moment.now);
        if exposed {
            self.exposures.push_back(moment.now);
        }
        if exposed || self.moments.len() >= ROLL {
            self.send(exposed);
        }
    }

    fn ready(&mut self, now: Seconds) -> Option<Shot> {
        while self.exposures.front().is_some_and(|exposed| now.0 + 1e-6 >= exposed.0 + self.delay_s) {
            self.exposures.pop_front();
            // Nothing comes for a frame that could not be compressed.
            if let Some(shot) = self.shots.recv().ok().flatten() {
                return Some(shot);
            }
        }
        None
    }
}

/// Ends with the simulation.
fn develop(mut rig: Rig, rolls: &Receiver<Roll>, shots: &Sender<Option<Shot>>) {
    for roll in rolls {
        roll.moments.iter().for_each(|moment| rig.observe(moment));
        if roll.exposed && shots.send(rig.ready(Seconds(f64::INFINITY))).is_err() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::tests::params;

    #[test]
    fn a_darkroom_hands_out_what_its_rig_would_at_the_same_times() {
        let params = CameraParams { period_s: 0.5, delay_s: 0.05, ..params() };
        let (mut rig, mut darkroom) = (Rig::new(&params, 1), Darkroom::new(&params, 1));
        let mut shots = 0;
        for step in 1..=2_100 {
            let now = Seconds(f64::from(step) * 1e-3);
            let tool_m = [0.1 + 2e-5 * f64::from(step), 0.1, 2e-4];
            let road_m = Some((4.5e-4, 2e-4));
            let moment = Moment { now, tool_m, velocity_m_s: [0.02, 0.0], road_m, loose_m3: 0.0 };
            rig.observe(&moment);
            darkroom.observe(&moment);
            let (wanted, handed_out) = (rig.ready(now), darkroom.ready(now));
            assert!(wanted == handed_out, "{now:?}: not the same shot");
            shots += u32::from(wanted.is_some());
        }
        assert_eq!(shots, 4);
    }
}
