//! The plant: heat, melt, slip, road. System 1 of the model book with System 2's pressure lag, at the caller's step.

use crate::faults::InForce;
use crate::output::Truth;
use crate::params::PlantParams;
use crate::sensors::Noise;
use models::bead::stadium;
use models::extruder::{Melting, Pressure, StaticLaw};
use models::hotend::Thermal;
use models::latent::{LaidBead, adhesion, fill};
use models::material::Material;
use models::melt::Melt;
use models::units::{Kelvin, Seconds};

mod heat;

/// Filament length after which the diameter is drawn anew `[m]`: far below its correlation length.
const DIAMETER_STEP_M: f64 = 1e-3;

/// A road being deposited.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Road {
    /// Width that the slicer asked for `[m]`.
    pub target_width_m: f64,
    /// Layer height `[m]`.
    pub height_m: f64,
}

/// What drive and tool do over one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Push {
    /// Motor speed as filament `[m/s]`; negative in a retraction.
    pub motor_m_s: f64,
    /// Tool speed along its path `[m/s]`.
    pub path_speed_m_s: f64,
    /// The road under the nozzle, if one is deposited.
    pub road: Option<Road>,
}

/// What the firmware switches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs {
    /// Hot end duty `[0, 1]`; zero without mains.
    pub hotend_duty: f64,
    /// Bed duty `[0, 1]`; zero without mains.
    pub bed_duty: f64,
    /// The mains relay feeds the heaters.
    pub mains_on: bool,
    /// Part fan `[0, 1]`.
    pub fan: f64,
}

/// State of the plant.
#[derive(Debug, Clone)]
pub struct Plant {
    params: PlantParams,
    material: Material,
    melt: Melt,
    thermal: Thermal,
    bed: Kelvin,
    bed_sensor: Kelvin,
    fan: f64,
    heater_w: f64,
    pressure: Pressure,
    slip: f64,
    delivered_m: f64,
    outlet_m: f64,
    /// Cross-section of the road under the nozzle, smeared over one nozzle diameter of path `[m2]`.
    section_m2: Option<f64>,
    diameter_offset_m: f64,
    diameter_due_m: f64,
    /// Area of the filament over the nominal one, faults included `[-]`.
    gain: f64,
    /// Share of the melt that leaves through the nozzle `[-]`; the rest leaks.
    kept: f64,
    noise: Noise,
    /// What left since the last step of the heat `[m3]`.
    melted_m3: f64,
}

impl Plant {
    /// Everything at room temperature; `material` is the plant's own, deviation applied.
    #[must_use]
    pub fn new(params: &PlantParams, material: Material, mut noise: Noise) -> Self {
        let ambient = params.ambient();
        let melt = Melt::new(&material, &params.extruder);
        let diameter_offset_m = params.filament.diameter_sigma_m * noise.draw();
        let mut plant = Self {
            params: *params,
            melt,
            material,
            thermal: Thermal::uniform(ambient.0),
            bed: ambient,
            bed_sensor: ambient,
            fan: 0.0,
            heater_w: 0.0,
            pressure: Pressure::RELAXED,
            slip: 0.0,
            delivered_m: 0.0,
            outlet_m: 0.0,
            section_m2: None,
            diameter_offset_m,
            diameter_due_m: DIAMETER_STEP_M,
            gain: 1.0,
            kept: 1.0,
            noise,
            melted_m3: 0.0,
        };
        plant.gain = plant.gain_now(&InForce::NONE);
        plant
    }

    /// Hot end and bed at these temperatures at once.
    pub fn warm_up(&mut self, hotend: Option<Kelvin>, bed: Option<Kelvin>) {
        if let Some(hotend) = hotend {
            self.thermal = Thermal::uniform(hotend.0);
        }
        self.bed = bed.unwrap_or(self.bed);
        self.bed_sensor = self.bed;
    }

    /// Filament and road over one step of `dt`.
    pub fn push(&mut self, motion: Push, faults: &InForce, dt: Seconds) {
        let Push { motor_m_s, path_speed_m_s, road } = motion;
        let force_n = self.pressure.outlet().force_n;
        let params = &self.params;
        let feed_m_s = match motor_m_s {
            _ if faults.run_out => 0.0,
            forward if forward > 0.0 => {
                self.slip = params.slip.slip(force_n, params.extruder.force_max_n, faults.slip);
                (1.0 - self.slip) * forward
            }
            // A retraction strokes unloaded teeth: it does not slip.
            backward => backward,
        };
        self.delivered_m += feed_m_s * dt.0;
        // A leak of share L: dx/dt = v - u/(1-L) with the nozzle's u = law(x). In time t/(1-L) and feed (1-L) v that is
        // the sound nozzle's equation, and the length returned is the whole that left, the leak's share included.
        let kept = 1.0 - faults.leak;
        let law = self.law(faults);
        let out_m = self.pressure.step(&law, kept * feed_m_s, Seconds(dt.0 / kept));
        self.kept = kept;
        self.outlet_m += out_m;
        self.vary_diameter(feed_m_s * dt.0, faults);
        let out_m3 = out_m * self.melt.filament_area_m2() * self.gain;
        self.melted_m3 += out_m3;
        self.lay(kept * out_m3, path_speed_m_s * dt.0, road);
    }

    /// Law of the melt that leaves now: by what is held, at the temperature that goes with so much flow.
    fn law(&self, faults: &InForce) -> StaticLaw {
        let melting = Melting {
            melt: &self.melt,
            extruder: &self.params.extruder,
            nozzle: self.nozzle(),
            filament: self.air(faults),
            clog: faults.clog,
            area_m2: self.melt.filament_area_m2() * self.gain / (1.0 - faults.leak),
        };
        melting.law_holding(self.pressure.compression_m(), self.pressure.outlet().speed_m_s)
    }

    /// The nozzle's flat spreads the melt over about its own diameter: `dA/ds = (q/v - A)/D`.
    fn lay(&mut self, laid_m3: f64, path_m: f64, road: Option<Road>) {
        let Some(road) = road else {
            self.section_m2 = None;
            return;
        };
        let spread_m = 2.0 * self.params.extruder.nozzle_radius_m;
        let before_m2 =
            self.section_m2.unwrap_or_else(|| stadium::area_m2(road.target_width_m, road.height_m));
        let kept = (-path_m / spread_m).exp();
        // Exact for a constant section q/v over the step; finite where the tool rests.
        let share = if path_m > 1e-12 { (1.0 - kept) / path_m } else { 1.0 / spread_m };
        self.section_m2 = Some(before_m2 * kept + laid_m3 * share);
    }

    fn vary_diameter(&mut self, fed_m: f64, faults: &InForce) {
        self.diameter_due_m -= fed_m;
        if self.diameter_due_m <= 0.0 {
            self.diameter_due_m += DIAMETER_STEP_M;
            let normal = self.noise.draw();
            self.diameter_offset_m =
                self.params.filament.deviation_after_m(self.diameter_offset_m, DIAMETER_STEP_M, normal);
        }
        self.gain = self.gain_now(faults);
    }

    fn gain_now(&self, faults: &InForce) -> f64 {
        let diameter_m = (self.params.filament.diameter_m + self.diameter_offset_m) * faults.diameter;
        (diameter_m / self.params.extruder.filament_diameter_m).powi(2)
    }

    /// Nozzle.
    #[must_use]
    pub fn nozzle(&self) -> Kelvin {
        Kelvin(self.thermal.nozzle_k)
    }

    /// Thermistor bead of the hot end.
    #[must_use]
    pub fn sensor(&self) -> Kelvin {
        Kelvin(self.thermal.sensor_k)
    }

    /// Bed.
    #[must_use]
    pub fn bed(&self) -> Kelvin {
        self.bed
    }

    /// Thermistor bead of the bed.
    #[must_use]
    pub fn bed_sensor(&self) -> Kelvin {
        self.bed_sensor
    }

    /// Filament that passed the gear since start `[m]`.
    #[must_use]
    pub fn delivered_m(&self) -> f64 {
        self.delivered_m
    }

    /// Width of the road now `[m]`.
    fn width_m(&self, road: &Road) -> f64 {
        self.section_m2.map_or(0.0, |section_m2| stadium::width_of_area_m(section_m2, road.height_m))
    }

    /// Bond and porosity of the road now: `(adhesion, porosity)`.
    fn latent(&self, road: &Road, below_bed_k: f64) -> (f64, f64) {
        let bead = LaidBead {
            nozzle_k: self.thermal.nozzle_k,
            below_k: self.bed.0 - below_bed_k,
            ambient_k: self.params.ambient_temp_k,
            height_m: road.height_m,
            width_m: road.target_width_m,
            fan: self.fan,
        };
        let bond_s = self.params.cooling.bond_time_s(&self.material, &bead);
        let wanted_m2 = stadium::area_m2(road.target_width_m, road.height_m);
        let porosity = fill(self.section_m2.unwrap_or(wanted_m2), wanted_m2).porosity;
        (adhesion(bond_s, self.material.adhesion_time_s), porosity)
    }

    /// The truth of plant and road; the caller adds what the plant does not know.
    #[must_use]
    pub fn truth(&self, road: Option<Road>, below_bed_k: f64) -> Truth {
        let outlet = self.pressure.outlet();
        let (adhesion, porosity) = road.map_or((0.0, 0.0), |road| self.latent(&road, below_bed_k));
        Truth {
            block_k: self.thermal.block_k,
            nozzle_k: self.thermal.nozzle_k,
            sensor_k: self.thermal.sensor_k,
            bed_k: self.bed.0,
            heater_w: self.heater_w,
            delivered_m: self.delivered_m,
            outlet_m: self.outlet_m,
            outlet_m_s: outlet.speed_m_s / self.kept,
            slip: self.slip,
            gain: self.gain * self.kept,
            force_n: outlet.force_n,
            depositing: road.is_some(),
            width_m: road.map_or(0.0, |road| self.width_m(&road)),
            target_width_m: road.map_or(0.0, |road| road.target_width_m),
            adhesion,
            porosity,
            ..Truth::default()
        }
    }
}
