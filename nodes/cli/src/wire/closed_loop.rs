//! One simulated wall: plant and controller profile in virtual time.

use models::units::Seconds;
use models::wire::Process;
use mpc_controller::wire::{Answer, HeightController, Measured, WireTrims};
use printer_sim::wire::{HeightSample, Params as PlantParams, Speeds, WirePlant};
use serde::Serialize;

/// Step of the simulation `[s]`: a fortieth of a drop's period, a fifteenth of the drives' lag.
const STEP: Seconds = Seconds(0.02);

/// What one wall is built from.
#[derive(Debug, Clone)]
pub struct Wall {
    /// What plan and correction believe.
    pub process: Process,
    /// The controller profile.
    pub controller: mpc_controller::wire::Params,
    /// The simulated process.
    pub plant: PlantParams,
    /// Number of layers, 1 or more.
    pub layers: u32,
    /// Dips and bumps come in layers up to this one.
    pub features_until: u32,
}

/// Height error of one layer against the plan.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Layer {
    /// Root of the mean square over the wall.
    pub rms_mm: f64,
    /// Mean over the wall.
    pub mean_mm: f64,
    /// Root of the mean square about that mean.
    pub roughness_mm: f64,
}

/// One built wall.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Built {
    /// Seed of scatter, noise, dips and bumps.
    pub seed: u64,
    /// Layers in their order.
    pub layers: Vec<Layer>,
    /// Height RMS over all layers.
    pub rms_mm: f64,
    /// Height RMS of the last layer.
    pub last_rms_mm: f64,
    /// As `rms_mm`, about each layer's mean.
    pub roughness_mm: f64,
    /// As `last_rms_mm`, about the layer's mean.
    pub last_roughness_mm: f64,
    /// Share of the time of laying in which a limit held the correction.
    pub limited_share: f64,
    /// Share of the time of laying without a measurement of the layer below.
    pub neutral_share: f64,
    /// Samples of the height sensor.
    pub measured: u64,
    /// Samples that were refused.
    pub refused: u64,
    /// Time of the process.
    pub time_s: f64,
    /// Height error of the last layer along the wall.
    #[serde(skip)]
    pub profile_mm: Vec<f64>,
}

impl Built {
    /// Share of the height samples that were refused.
    #[must_use]
    pub fn refused_share(&self) -> f64 {
        #[allow(clippy::cast_precision_loss, reason = "far below 2^52 samples")]
        let share = self.refused as f64 / self.measured.max(1) as f64;
        share
    }
}

#[derive(Default)]
struct Shares {
    laying: u32,
    limited: u32,
    neutral: u32,
}

impl Wall {
    /// Builds the wall; without a controller at the planned speeds.
    #[must_use]
    pub fn build(&self, closed: bool, seed: u64) -> Built {
        let mut plant = WirePlant::new(self.plant, seed);
        plant.features_until(self.features_until);
        // Unchecked, so that a gain beyond 2 can show what it does.
        let mut controller =
            HeightController::unchecked(self.controller, self.process.law, self.process.limits);
        let (mut shares, mut measured_count) = (Shares::default(), 0);
        let (mut layers, mut profile_mm) = (Vec::new(), Vec::new());
        while plant.layer() <= self.layers {
            while let Some(sample) = plant.sample() {
                measured_count += 1;
                // A refused sample is counted in the controller.
                _ = controller.on_height(measured(&sample));
            }
            let trims = if closed { command(&plant, &controller, &mut shares) } else { WireTrims::NEUTRAL };
            let layer = plant.layer();
            if plant.step(STEP, self.speeds(trims)) {
                profile_mm = self.errors_mm(&plant, layer);
                layers.push(figures(&profile_mm));
            }
        }
        let refused = controller.refusals();
        let share = |count: u32| f64::from(count) / f64::from(shares.laying.max(1));
        let last = layers.last().copied();
        Built {
            seed,
            rms_mm: pooled(&layers, |layer| layer.rms_mm),
            last_rms_mm: last.map_or(0.0, |layer| layer.rms_mm),
            roughness_mm: pooled(&layers, |layer| layer.roughness_mm),
            last_roughness_mm: last.map_or(0.0, |layer| layer.roughness_mm),
            layers,
            limited_share: share(shares.limited),
            neutral_share: share(shares.neutral),
            measured: measured_count,
            refused: refused.not_finite + refused.out_of_range + refused.old_layer,
            time_s: plant.now().0,
            profile_mm,
        }
    }

    fn speeds(&self, trims: WireTrims) -> Speeds {
        let law = &self.process.law;
        Speeds { wire_m_s: law.wire_m_s * trims.wire, head_m_s: law.head_m_s * trims.head }
    }

    fn errors_mm(&self, plant: &WirePlant, layer: u32) -> Vec<f64> {
        let planned_m = f64::from(layer) * self.process.law.height_m;
        plant.surface().heights_m().iter().map(|height_m| 1e3 * (height_m - planned_m)).collect()
    }
}

/// Figures of a layer from its height errors.
fn figures(errors_mm: &[f64]) -> Layer {
    let mean_mm = mean(errors_mm);
    let rms_mm = mean(&errors_mm.iter().map(|error| error * error).collect::<Vec<_>>()).sqrt();
    let about: Vec<f64> = errors_mm.iter().map(|error| (error - mean_mm).powi(2)).collect();
    Layer { rms_mm, mean_mm, roughness_mm: mean(&about).sqrt() }
}

fn measured(sample: &HeightSample) -> Measured {
    let HeightSample { stamp, layer, position_m, height_m } = *sample;
    Measured { stamp, layer, position_m, height_m }
}

fn command(plant: &WirePlant, controller: &HeightController, shares: &mut Shares) -> WireTrims {
    let Some(position_m) = plant.laying_at_m() else { return WireTrims::NEUTRAL };
    let answer = controller.answer(plant.now(), plant.layer(), position_m);
    shares.laying += 1;
    match answer {
        Answer::Correct(trims) => shares.limited += u32::from(trims.limited),
        Answer::Unmeasured | Answer::Stale => shares.neutral += 1,
    }
    answer.trims()
}

/// Root of the mean of squares over the layers.
fn pooled(layers: &[Layer], figure: impl Fn(&Layer) -> f64) -> f64 {
    mean(&layers.iter().map(|layer| figure(layer).powi(2)).collect::<Vec<_>>()).sqrt()
}

/// Mean of some values; 0 of none.
#[must_use]
pub fn mean(values: &[f64]) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "far below 2^52 values")]
    let count = values.len().max(1) as f64;
    values.iter().sum::<f64>() / count
}
