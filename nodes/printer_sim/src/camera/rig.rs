//! The camera on the printer: gathers what is laid, opens the shutter once a period, hands frames out late.

use super::deposit::{Bead, Deposit};
use super::look::Look;
use super::params::CameraParams;
use super::render::{Renderer, View};
use super::strands::Tangle;
use crate::pace::Pace;
use models::units::Seconds;
use std::collections::VecDeque;

/// A way below this is rest `[m]`.
const REST_M: f64 = 1e-9;

/// What printer and plant did over one step of the simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// End of the step.
    pub now: Seconds,
    /// Where the tool really is then, bed frame `[m]`.
    pub tool_m: [f64; 3],
    /// Its velocity `[m/s]`.
    pub velocity_m_s: [f64; 2],
    /// Width and layer height of the road that was laid `[m]`.
    pub road_m: Option<(f64, f64)>,
    /// What left the nozzle and found nothing to land on `[m3]`.
    pub loose_m3: f64,
}

/// A frame on its way out of the camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Shot {
    /// Middle of the exposure.
    pub exposed: Seconds,
    /// Frames since the start, this one excluded.
    pub sequence: u64,
    /// The picture, baseline JPEG of one grey component.
    pub jpeg: Vec<u8>,
}

/// What looks at the print: [`Rig`], or one at work elsewhere.
pub trait Camera: Send {
    /// Takes one step of the simulation, of a millisecond or so, in.
    fn observe(&mut self, moment: &Moment);
    /// The next frame that has arrived by now.
    fn ready(&mut self, now: Seconds) -> Option<Shot>;
}

/// A straight piece of road that is still growing.
#[derive(Debug, Clone, Copy)]
struct Run {
    from_m: [f64; 2],
    to_m: [f64; 2],
    top_m: f64,
    height_m: f64,
    /// Width integrated over the way `[m2]`.
    width_m2: f64,
    way_m: f64,
}

/// Camera, height field and what is on its way between them.
pub struct Rig {
    period: Pace,
    delay_s: f64,
    piece_m: f64,
    deposit: Deposit,
    renderer: Renderer,
    tangle: Tangle,
    tool_m: Option<[f64; 3]>,
    run: Option<Run>,
    sequence: u64,
    failed: u64,
    waiting: VecDeque<Shot>,
}

impl Rig {
    /// A camera over an empty bed; `seed` draws light, filament, bed and lens from the style's ranges.
    #[must_use]
    pub fn new(params: &CameraParams, seed: u64) -> Self {
        let look = Look::draw(params.ranges(params.style), seed);
        Self {
            period: Pace::dithered(params.period_s, params.dither),
            delay_s: params.delay_s,
            piece_m: params.field.piece_m,
            deposit: Deposit::new(params.field, params.geometry.scale_m()),
            renderer: Renderer::new(params.geometry, look),
            tangle: Tangle::new(params.field.strand_m, seed),
            tool_m: None,
            run: None,
            sequence: 0,
            failed: 0,
            waiting: VecDeque::new(),
        }
    }

    /// Joins steps that go straight on, so that a road is stamped once a few steps and not every step.
    fn extend(&mut self, from_m: [f64; 3], to_m: [f64; 3], (width_m, height_m): (f64, f64)) {
        let step = [to_m[0] - from_m[0], to_m[1] - from_m[1]];
        let way_m = step[0].hypot(step[1]);
        if way_m < REST_M {
            return;
        }
        // Half a cell aside bends no picture.
        let aside_m = self.deposit.cell_m() / 2.0;
        if self.run.is_some_and(|run| !run.goes_on(step, to_m[2], height_m, aside_m)) {
            self.finish();
        }
        let start_m = [from_m[0], from_m[1]];
        let fresh =
            Run { from_m: start_m, to_m: start_m, top_m: to_m[2], height_m, width_m2: 0.0, way_m: 0.0 };
        let run = self.run.get_or_insert(fresh);
        run.to_m = [to_m[0], to_m[1]];
        run.way_m += way_m;
        run.width_m2 += way_m * width_m;
        if run.way_m >= self.piece_m {
            self.finish();
        }
    }

    fn finish(&mut self) {
        if let Some(run) = self.run.take() {
            let bead = Bead { top_m: run.top_m, width_m: run.width_m2 / run.way_m, height_m: run.height_m };
            self.deposit.lay(run.from_m, run.to_m, bead);
        }
    }

    fn shoot(&mut self, moment: &Moment) {
        let view = View { tool_m: moment.tool_m, velocity_m_s: moment.velocity_m_s };
        let frame = self.renderer.render(&self.deposit, &view);
        match frame.jpeg(self.renderer.look().jpeg_quality) {
            Ok(jpeg) => {
                self.waiting.push_back(Shot { exposed: moment.now, sequence: self.sequence, jpeg });
            }
            Err(_) => self.failed += 1,
        }
        self.sequence += 1;
    }

    /// What lies on the bed.
    #[must_use]
    pub fn deposit(&self) -> &Deposit {
        &self.deposit
    }

    /// The camera.
    #[must_use]
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// Frames that could not be compressed; their numbers are missing in the sequence.
    #[must_use]
    pub fn failed(&self) -> u64 {
        self.failed
    }
}

impl Camera for Rig {
    fn observe(&mut self, moment: &Moment) {
        let from_m = self.tool_m.replace(moment.tool_m).unwrap_or(moment.tool_m);
        match moment.road_m {
            Some(road_m) => self.extend(from_m, moment.tool_m, road_m),
            None => self.finish(),
        }
        if moment.loose_m3 > 0.0 {
            self.tangle.grow(&mut self.deposit, moment.tool_m, moment.loose_m3);
        }
        if self.period.due(moment.now) {
            self.finish();
            self.shoot(moment);
        }
    }

    fn ready(&mut self, now: Seconds) -> Option<Shot> {
        let arrives_s = self.waiting.front()?.exposed.0 + self.delay_s;
        if now.0 + 1e-6 >= arrives_s { self.waiting.pop_front() } else { None }
    }
}

impl Run {
    /// Whether a step continues this straight piece of the same layer.
    fn goes_on(&self, step: [f64; 2], top_m: f64, height_m: f64, aside_m: f64) -> bool {
        let along = [self.to_m[0] - self.from_m[0], self.to_m[1] - self.from_m[1]];
        let length_m = along[0].hypot(along[1]);
        let ahead = along[0] * step[0] + along[1] * step[1];
        let aside = (along[0] * step[1] - along[1] * step[0]).abs();
        ahead >= 0.0
            && aside <= aside_m * length_m
            && (top_m - self.top_m).abs() < REST_M
            && (height_m - self.height_m).abs() < REST_M
    }
}
