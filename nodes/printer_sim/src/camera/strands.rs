//! Filament that is no road: tangles, strings, blobs.

use super::deposit::Deposit;
use rand::{Rng, SeedableRng, rngs::StdRng};
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::{FRAC_PI_4, PI, TAU};

/// Length of a straight piece of strand, in its diameters.
const PIECE: f64 = 0.25;
/// Memory of the curvature along the strand, in its diameters.
const MEMORY: f64 = 12.0;
/// Spread of the curvature, in its inverse diameters: loops of a few millimetres.
const CURVATURE: f64 = 0.22;
/// How far a strand strays from the nozzle before it is drawn back, in its diameters.
const LEASH: f64 = 9.0;
/// Highest that a thin string is drawn over what lies below it `[m]`.
const HAIR_M: f64 = 1.2e-4;
/// Steepest rise of a strand over what it crosses `[-]`.
const CLIMB: f64 = 0.35;
/// Highest that a tangle piles up above the nozzle's tip, in its diameters.
const PILE: f64 = 4.0;

/// Loose filament that leaves the nozzle without finding the part: a curve whose curvature is an AR(1) process along
/// it, drawn after the nozzle as by a leash. It grows with the extruded volume alone.
#[derive(Debug, Clone)]
pub struct Tangle {
    diameter_m: f64,
    at_m: Option<[f64; 2]>,
    heading_rad: f64,
    curvature: f64,
    lift: f64,
    top_m: Option<f64>,
    owed_m3: f64,
    rng: StdRng,
}

impl Tangle {
    /// A strand of `diameter_m` that has not begun.
    #[must_use]
    pub fn new(diameter_m: f64, seed: u64) -> Self {
        let mut rng = StdRng::seed_from_u64(seed ^ 0x7a61);
        let heading_rad = rng.random_range(0.0..TAU);
        Self {
            diameter_m,
            at_m: None,
            heading_rad,
            curvature: 0.0,
            lift: 0.3,
            top_m: None,
            owed_m3: 0.0,
            rng,
        }
    }

    /// Grows by `volume_m3` while the nozzle is at `tool_m`.
    pub fn grow(&mut self, deposit: &mut Deposit, tool_m: [f64; 3], volume_m3: f64) {
        self.owed_m3 += volume_m3.max(0.0);
        let piece_m = PIECE * self.diameter_m;
        let piece_m3 = piece_m * FRAC_PI_4 * self.diameter_m.powi(2);
        while self.owed_m3 >= piece_m3 {
            self.owed_m3 -= piece_m3;
            self.piece(deposit, tool_m, piece_m);
        }
    }

    fn piece(&mut self, deposit: &mut Deposit, tool_m: [f64; 3], piece_m: f64) {
        let from_m = self.at_m.unwrap_or([tool_m[0], tool_m[1]]);
        let kept = (-PIECE / MEMORY).exp();
        let spread = CURVATURE * (1.0 - kept * kept).sqrt();
        self.curvature = kept * self.curvature + spread * self.normal();
        self.lift = (kept * self.lift + (1.0 - kept * kept).sqrt() * 0.5 * self.normal()).clamp(-1.0, 3.0);
        let away_m = [tool_m[0] - from_m[0], tool_m[1] - from_m[1]];
        let stray = away_m[0].hypot(away_m[1]) / self.diameter_m;
        let mut turn = self.curvature * PIECE;
        if stray > LEASH {
            let back = (away_m[1].atan2(away_m[0]) - self.heading_rad + PI).rem_euclid(TAU) - PI;
            turn += back * ((stray - LEASH) / LEASH).min(1.0) * 0.4;
        }
        self.heading_rad += turn;
        let to_m = self.ahead_m(from_m, piece_m);
        // Beyond its own round end: a strand does not climb on itself.
        let ahead_m = self.ahead_m(to_m, 0.6 * self.diameter_m);
        let ground_m = deposit.height_m(ahead_m);
        let lifted_m = ground_m + self.diameter_m * (0.6 + 0.4 * self.lift.max(0.0));
        let wanted_m = lifted_m.min(tool_m[2] + PILE * self.diameter_m);
        let last_m = self.top_m.unwrap_or(wanted_m);
        let top_m = wanted_m.clamp(last_m - CLIMB * piece_m, last_m + CLIMB * piece_m);
        self.top_m = Some(top_m);
        deposit.drop_strand(from_m, to_m, (self.diameter_m, top_m));
        self.at_m = Some(to_m);
    }

    fn ahead_m(&self, from_m: [f64; 2], way_m: f64) -> [f64; 2] {
        [from_m[0] + way_m * self.heading_rad.cos(), from_m[1] + way_m * self.heading_rad.sin()]
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.rng)
    }
}

/// A thin string that oozed on a travel: from above it is nearly straight, its sag shows only in its height.
pub fn string(
    deposit: &mut Deposit,
    (from_m, to_m): ([f64; 2], [f64; 2]),
    (diameter_m, top_m): (f64, f64),
    rng: &mut impl Rng,
) {
    let length_m = (to_m[0] - from_m[0]).hypot(to_m[1] - from_m[1]);
    let bow_m = length_m * rng.random_range(-0.08..0.08);
    let across = [-(to_m[1] - from_m[1]) / length_m.max(1e-9), (to_m[0] - from_m[0]) / length_m.max(1e-9)];
    let thins = rng.random_range(0.0..0.5);
    let mut last_m = from_m;
    for step in 1..=24 {
        let share = f64::from(step) / 24.0;
        let arch = 4.0 * share * (1.0 - share);
        let at_m = [0, 1]
            .map(|axis| from_m[axis] + share * (to_m[axis] - from_m[axis]) + arch * bow_m * across[axis]);
        // Thin hair casts no shadow to speak of: it is drawn near to what lies below it.
        let ground_m = deposit.height_m(at_m);
        let sagged_m = (top_m - 0.03 * arch * length_m).clamp(ground_m + 0.5 * diameter_m, ground_m + HAIR_M);
        deposit.drop_strand(last_m, at_m, (diameter_m * (1.0 - thins * arch), sagged_m));
        last_m = at_m;
    }
}

/// A blob of `diameter_m` that stands `height_m` over what is there.
pub fn blob(deposit: &mut Deposit, at_m: [f64; 2], (diameter_m, height_m): (f64, f64), rng: &mut impl Rng) {
    let ground_m = deposit.height_m(at_m);
    for _ in 0..3 {
        let to_m = at_m.map(|at_m| at_m + rng.random_range(-0.25..0.25) * diameter_m);
        let size_m = diameter_m * rng.random_range(0.6..1.0);
        deposit.drop_strand(to_m, at_m, (size_m, ground_m + height_m.min(size_m / 2.0)));
    }
}
