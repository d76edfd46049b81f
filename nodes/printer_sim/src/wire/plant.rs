//! The process in time: drives, drops, layers, sensor.

use super::params::Params;
use super::surface::Surface;
use crate::sensors::Noise;
use models::units::Seconds;
use models::wire::melting::wire_volume_m3;
use rand::{Rng, SeedableRng, rngs::StdRng};
use std::collections::VecDeque;

/// Commanded speeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Speeds {
    /// Wire `[m/s]`, 0 or more.
    pub wire_m_s: f64,
    /// Head along the wall `[m/s]`, above 0.
    pub head_m_s: f64,
}

/// What the height sensor tells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeightSample {
    /// When it was measured.
    pub stamp: Seconds,
    /// Layer that was measured, from 1.
    pub layer: u32,
    /// Place along the wall `[m]`.
    pub position_m: f64,
    /// Height of the wall above the base plate `[m]`.
    pub height_m: f64,
}

/// What the head does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// Lays drops from the start to the end of the wall.
    Laying,
    /// Goes on without wire until the sensor has seen the end.
    Overrun,
    /// Goes back to the start.
    Returning,
}

/// Random streams, each of its own, so that more noise of one kind leaves the others as they were.
#[derive(Debug, Clone)]
struct Chance {
    volume: Noise,
    place: Noise,
    sensor: Noise,
    features: StdRng,
}

/// The simulated process.
#[derive(Debug, Clone)]
pub struct WirePlant {
    params: Params,
    chance: Chance,
    surface: Surface,
    now: Seconds,
    phase: Phase,
    layer: u32,
    head_m: f64,
    drop_start_m: f64,
    fed_m: f64,
    speeds: Speeds,
    return_left_s: f64,
    sample_left_s: f64,
    on_the_way: VecDeque<HeightSample>,
    /// Dips and bumps come in layers up to this one.
    last_features: u32,
}

impl WirePlant {
    /// A base plate before the first drop; the seed makes all scatter, noise, dips and bumps.
    #[must_use]
    pub fn new(params: Params, seed: u64) -> Self {
        // Streams far from those of the printer, which count from 0.
        let stream = |number: u64| Noise::new(seed, 1000 + number);
        let mut plant = Self {
            params,
            chance: Chance {
                volume: stream(0),
                place: stream(1),
                sensor: stream(2),
                features: StdRng::seed_from_u64(seed.wrapping_add(1003)),
            },
            surface: Surface::flat(params.wall_length_m, params.cell_m),
            now: Seconds(0.0),
            phase: Phase::Laying,
            layer: 1,
            head_m: 0.0,
            drop_start_m: 0.0,
            fed_m: 0.0,
            speeds: Speeds { wire_m_s: 0.0, head_m_s: 0.0 },
            return_left_s: 0.0,
            sample_left_s: 0.0,
            on_the_way: VecDeque::new(),
            last_features: u32::MAX,
        };
        plant.add_features();
        plant
    }

    /// Dips and bumps in the first `layers` alone: what is left of them afterwards shows the loop's own motion.
    /// Call it before the first step.
    pub fn features_until(&mut self, layers: u32) {
        self.last_features = layers;
    }

    /// Time of the process.
    #[must_use]
    pub fn now(&self) -> Seconds {
        self.now
    }

    /// Layer that is laid, from 1.
    #[must_use]
    pub fn layer(&self) -> u32 {
        self.layer
    }

    /// Place of the head along the wall while it lays drops `[m]`; none on its other ways.
    #[must_use]
    pub fn laying_at_m(&self) -> Option<f64> {
        (self.phase == Phase::Laying).then_some(self.head_m)
    }

    /// The true surface, for reports and tests alone.
    #[must_use]
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// Advances by `dt` (a few hundredths of a second); true when a layer is laid and measured, before
    /// the way back and the next layer's dips and bumps.
    pub fn step(&mut self, dt: Seconds, command: Speeds) -> bool {
        self.now = self.now + dt;
        match self.phase {
            Phase::Laying => self.lay(dt, command),
            Phase::Overrun => return self.overrun(dt, command),
            Phase::Returning => {
                self.return_left_s -= dt.0;
                if self.return_left_s <= 0.0 {
                    self.next_layer();
                }
            }
        }
        false
    }

    /// Time passes while the machine stands with its laser off: samples arrive, nothing is laid.
    pub fn wait(&mut self, dt: Seconds) {
        self.now = self.now + dt;
        self.speeds = Speeds { wire_m_s: 0.0, head_m_s: 0.0 };
    }

    /// Next sample that has arrived by now.
    pub fn sample(&mut self) -> Option<HeightSample> {
        let due = self.on_the_way.front()?.stamp.0 + self.params.sensor.delay_s <= self.now.0;
        if due { self.on_the_way.pop_front() } else { None }
    }

    fn lay(&mut self, dt: Seconds, command: Speeds) {
        // Exact answer of a first-order lag to a command that stays for the step.
        let share = -(-dt.0 / self.params.drive_lag_s).exp_m1();
        self.speeds.wire_m_s += share * (command.wire_m_s - self.speeds.wire_m_s);
        self.speeds.head_m_s += share * (command.head_m_s - self.speeds.head_m_s);
        self.head_m += self.speeds.head_m_s * dt.0;
        self.fed_m += self.speeds.wire_m_s * dt.0 * self.params.feed_ratio;
        if self.fed_m >= self.params.drop_length_m {
            self.fed_m -= self.params.drop_length_m;
            self.fall(self.params.drop_length_m);
        }
        self.measure(dt);
        if self.head_m >= self.params.wall_length_m {
            // The laser melts off what hangs at the wire's end.
            let rest_m = std::mem::take(&mut self.fed_m);
            self.fall(rest_m);
            self.phase = Phase::Overrun;
        }
    }

    /// A drop of a length of wire falls where that wire was molten.
    fn fall(&mut self, length_m: f64) {
        let volume = 1.0 + self.params.drop_volume_sigma * self.chance.volume.draw();
        let volume_m3 = wire_volume_m3(self.params.diameter_m, length_m) * volume.max(0.0);
        let scatter_m = self.params.drop_place_sigma_m * self.chance.place.draw();
        let place_m = 0.5 * (self.drop_start_m + self.head_m) + scatter_m;
        self.drop_start_m = self.head_m;
        self.surface.add_area(place_m, self.params.spread_m, volume_m3 / self.params.bead_width_m);
    }

    fn overrun(&mut self, dt: Seconds, command: Speeds) -> bool {
        self.head_m += command.head_m_s * dt.0;
        self.measure(dt);
        if self.head_m >= self.params.wall_length_m + self.params.sensor.trail_m {
            self.phase = Phase::Returning;
            self.return_left_s = self.params.return_s;
            return true;
        }
        false
    }

    fn measure(&mut self, dt: Seconds) {
        let position_m = self.head_m - self.params.sensor.trail_m;
        if !(0.0..self.params.wall_length_m).contains(&position_m) {
            return;
        }
        self.sample_left_s -= dt.0;
        if self.sample_left_s > 0.0 {
            return;
        }
        self.sample_left_s += self.params.sensor.period_s;
        let noise_m = self.params.sensor.sigma_m * self.chance.sensor.draw();
        self.on_the_way.push_back(HeightSample {
            stamp: self.now,
            layer: self.layer,
            position_m,
            height_m: self.surface.height_m(position_m) + noise_m,
        });
    }

    fn next_layer(&mut self) {
        self.layer += 1;
        self.phase = Phase::Laying;
        self.head_m = 0.0;
        self.drop_start_m = 0.0;
        self.sample_left_s = 0.0;
        if self.layer <= self.last_features {
            self.add_features();
        }
    }

    /// Dips and bumps of a layer. They stand there from its start on; the sensor sees them behind the head.
    fn add_features(&mut self) {
        for _ in 0..self.params.features_per_layer {
            let place_m = self.chance.features.random::<f64>() * self.params.wall_length_m;
            let up = if self.chance.features.random::<bool>() { 1.0 } else { -1.0 };
            let height_m = up * self.params.feature_height_m;
            self.surface.add_height(place_m, self.params.feature_length_m, height_m);
        }
    }
}
