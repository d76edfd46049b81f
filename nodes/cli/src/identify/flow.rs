//! The pressure lag out of what was fed and how wide the road became: model book 1.2, `x = c F(u) + K_lin u`.
//!
//! A steady width shows the filament's section alone. How it is reached after a step of the flow shows how much filament
//! is held compressed at each flow: `x(u) = X (u/u_r)^n + K_lin u`. The force itself is not seen: the compliance is that
//! which goes with the melt of the material's file.

use super::gains::Gains;
use super::heat::HeatFit;
use super::least_squares::{Fit, Problem};
use super::params::IdentifyParams;
use super::record::{At, Recorded};
use models::bead::stadium;
use models::extruder::{Extruder, Pressure, StaticLaw};
use models::material::Material;
use models::melt::{GAS_CONSTANT_J_MOL_K, Melt, melt_temperature};
use models::units::{Kelvin, Seconds};
use nalgebra::{DMatrix, DVector};

mod cells;
use cells::{Cell, Seen};

/// Places in the vector of parameters: logarithms of ratios to the nominal printer, the index less the material's, the
/// logarithm of the activation energy over the material's, then the gain less one at each knot.
const COMPRESSION: usize = 0;
const LINEAR_LAG: usize = 1;
pub(super) const FLOW_INDEX: usize = 2;
const ACTIVATION: usize = 3;
const GAIN: usize = 4;

/// The problem.
pub(super) struct Flow<'a> {
    params: &'a IdentifyParams,
    extruder: Extruder,
    material: Material,
    ambient_k: f64,
    cells: Vec<Cell>,
    seen: Vec<Seen>,
    knots: usize,
    nominal: Nominal,
}

/// What the files say of the held filament.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nominal {
    /// Temperature at which it is said: what the learned hot end makes of the nozzle's mean while roads were laid `[K]`.
    /// Thermistor and heater alone leave it uncertain by some kelvin; the lag is that of the print whatever it was.
    pub(super) at_k: f64,
    /// Speed at which the compression is told `[m/s]`.
    pub(super) speed_m_s: f64,
    /// Compression by the force at that speed `[m]`.
    pub(super) compression_m: f64,
}

/// Its answer.
#[derive(Debug, Clone)]
pub(super) struct FlowFit {
    pub(super) gains: Gains,
    pub(super) fit: Fit,
    pub(super) nominal: Nominal,
    pub(super) extruder: Extruder,
    pub(super) material: Material,
    /// Speeds of filament at which lags are told `[m/s]`.
    pub(super) speeds_m_s: [f64; 3],
    /// Lag at the speeds of the file `[s]`, and the covariance.
    pub(super) lags_s: [f64; 3],
    pub(super) lags_covariance: DMatrix<f64>,
    /// Filament held compressed at the speeds of the file `[m]`, and the covariance.
    pub(super) held_m: [f64; 3],
    pub(super) held_covariance: DMatrix<f64>,
    /// Noise of a width `[m]`.
    pub(super) sigma_m: f64,
    pub(super) widths: usize,
    /// What left the nozzle so far `[m3]`.
    pub(super) volume_m3: Vec<At>,
}

impl<'a> Flow<'a> {
    pub(super) fn new(
        recorded: &Recorded,
        heat: &HeatFit,
        (extruder, material): (Extruder, &Material),
        params: &'a IdentifyParams,
    ) -> Self {
        let (cells, knots) = cells::cells(recorded, heat, &params.fit);
        let seen = cells::seen(recorded, &cells, &params.fit);
        let hot: Vec<f64> =
            cells.iter().filter(|cell| cell.road.is_some()).map(|cell| cell.nozzle_k).collect();
        #[allow(clippy::cast_precision_loss, reason = "a count of cells")]
        let at_k =
            if hot.is_empty() { material.nozzle_temp_k } else { hot.iter().sum::<f64>() / hot.len() as f64 };
        let nominal = Nominal::new(&extruder, material, at_k, params.fit.lag_speeds_m_s[1]);
        Self {
            params,
            extruder,
            material: material.clone(),
            ambient_k: heat.ambient_k,
            cells,
            seen,
            knots,
            nominal,
        }
    }

    /// What left the nozzle so far by the law of the files, against time.
    pub(super) fn by_files(&self) -> Option<Vec<At>> {
        self.simulate(&DVector::zeros(GAIN)).map(|(_, volume_m3)| volume_m3)
    }

    /// Fits from `start` on, or from the nominal printer.
    pub(super) fn fit(&self, start: Option<&Fit>) -> Option<FlowFit> {
        if self.seen.is_empty() {
            return None;
        }
        let residuals = |parameters: &DVector<f64>| self.residuals(parameters);
        let fitting = &self.params.fit;
        let problem = Problem {
            residuals: &residuals,
            data: self.seen.len(),
            steps: fitting.steps,
            tolerance: fitting.tolerance,
        };
        let start = start.map_or_else(|| DVector::zeros(GAIN + self.knots), |fit| fit.parameters.clone());
        let fit = problem.solve(start)?;
        let (lags_s, slopes) = self.lags(&fit.parameters);
        let (held_m, held_slopes) = self.held(&fit.parameters);
        let (_, volume_m3) = self.simulate(&fit.parameters)?;
        let stated: f64 = self.seen.iter().map(|seen| seen.sigma_m.powi(2)).sum();
        #[allow(clippy::cast_precision_loss, reason = "a count of widths")]
        let sigma_m = (stated / self.seen.len() as f64 * fit.variance).sqrt();
        Some(FlowFit {
            gains: self.gains(&fit)?,
            speeds_m_s: self.params.fit.lag_speeds_m_s,
            nominal: self.nominal,
            extruder: self.extruder,
            material: self.material.clone(),
            lags_s,
            lags_covariance: &slopes * &fit.covariance * slopes.transpose(),
            held_m,
            held_covariance: &held_slopes * &fit.covariance * held_slopes.transpose(),
            sigma_m,
            widths: self.seen.len(),
            volume_m3,
            fit,
        })
    }

    fn gains(&self, fit: &Fit) -> Option<Gains> {
        let covariance = fit.covariance.view((GAIN, GAIN), (self.knots, self.knots)).into_owned();
        #[allow(clippy::cast_precision_loss, reason = "a count of knots")]
        let place = |cell: &Cell| (cell.end_s, cell.knot as f64 + cell.share);
        Some(Gains {
            places: self.cells.iter().map(place).collect(),
            whitener: covariance.cholesky()?.l().try_inverse()?,
        })
    }

    /// `K(u) = n X/u_r (u/u_r)^(n-1) + K_lin` and its slopes to the parameters.
    fn lags(&self, parameters: &DVector<f64>) -> ([f64; 3], DMatrix<f64>) {
        let (compression_m, linear_s, index) = self.law(parameters);
        let reference = self.nominal.speed_m_s;
        let speeds = self.params.fit.lag_speeds_m_s;
        let mut slopes = DMatrix::zeros(3, parameters.len());
        let lags = std::array::from_fn(|row| {
            let ratio = speeds[row] / reference;
            let held_s = index * compression_m / reference * ratio.powf(index - 1.0);
            slopes[(row, COMPRESSION)] = held_s;
            slopes[(row, LINEAR_LAG)] = linear_s;
            slopes[(row, FLOW_INDEX)] = held_s * (1.0 / index + ratio.ln());
            held_s + linear_s
        });
        (lags, slopes)
    }

    /// `x(u) = X (u/u_r)^n + K_lin u` and its slopes to the parameters.
    fn held(&self, parameters: &DVector<f64>) -> ([f64; 3], DMatrix<f64>) {
        let (compression_m, linear_s, index) = self.law(parameters);
        let mut slopes = DMatrix::zeros(3, parameters.len());
        let speeds = self.params.fit.lag_speeds_m_s;
        let held = std::array::from_fn(|row| {
            let ratio = speeds[row] / self.nominal.speed_m_s;
            let (sheared_m, linear_m) = (compression_m * ratio.powf(index), linear_s * speeds[row]);
            slopes[(row, COMPRESSION)] = sheared_m;
            slopes[(row, LINEAR_LAG)] = linear_m;
            slopes[(row, FLOW_INDEX)] = sheared_m * ratio.ln();
            sheared_m + linear_m
        });
        (held, slopes)
    }

    /// Compression at the reference `[m]`, linear lag `[s]`, index `[-]`.
    fn law(&self, parameters: &DVector<f64>) -> (f64, f64, f64) {
        (
            self.nominal.compression_m * parameters[COMPRESSION].exp(),
            self.extruder.linear_lag_s * parameters[LINEAR_LAG].exp(),
            self.material.flow_index + parameters[FLOW_INDEX],
        )
    }

    /// Activation energy of the material's file over the gas constant `[K]`.
    fn activation_k(&self) -> f64 {
        self.material.activation_energy_j_mol / GAS_CONSTANT_J_MOL_K
    }

    /// Section of the road at the end of each cell `[m2]`, and what left the nozzle so far.
    fn simulate(&self, parameters: &DVector<f64>) -> Option<(Vec<f64>, Vec<At>)> {
        let (compression_m, linear_s, index) = self.law(parameters);
        if !(0.05..=1.0).contains(&index) {
            return None;
        }
        let scale = compression_m / self.nominal.speed_m_s.powf(index);
        let activation_k = self.activation_k() * parameters[ACTIVATION].exp();
        let area_m2 = self.extruder.filament_area_m2();
        let spread_m = 2.0 * self.extruder.nozzle_radius_m;
        let (mut pressure, mut section_m2, mut left_m3) = (Pressure::RELAXED, None, 0.0);
        let (mut sections, mut volume) = (Vec::with_capacity(self.cells.len()), Vec::new());
        for cell in &self.cells {
            let flow_m3_s = pressure.outlet().speed_m_s * area_m2;
            let filament = Kelvin(self.ambient_k);
            let melt =
                melt_temperature(Kelvin(cell.nozzle_k), filament, flow_m3_s, self.extruder.melting_flow_m3_s);
            let stiffer = (activation_k * (1.0 / melt.0 - 1.0 / self.nominal.at_k)).exp();
            let law = StaticLaw::of_compression(index, scale * stiffer, linear_s);
            let out_m = pressure.step(&law, cell.fed_m / cell.dt_s, Seconds(cell.dt_s));
            // Without knots the section is the nominal one.
            let off = |knot: usize| parameters.get(GAIN + knot).copied().unwrap_or(0.0);
            let gain = 1.0 + off(cell.knot) * (1.0 - cell.share) + off(cell.knot + 1) * cell.share;
            let laid_m3 = out_m * area_m2 * gain;
            left_m3 += laid_m3;
            section_m2 = cell.road.map(|(width_m, height_m)| {
                let before_m2: f64 = section_m2.unwrap_or_else(|| stadium::area_m2(width_m, height_m));
                let kept = (-cell.path_m / spread_m).exp();
                let share = if cell.path_m > 1e-9 { (1.0 - kept) / cell.path_m } else { 1.0 / spread_m };
                before_m2 * kept + laid_m3 * share
            });
            sections.push(section_m2.unwrap_or(f64::NAN));
            volume.push((cell.end_s, left_m3));
        }
        Some((sections, volume))
    }

    fn residuals(&self, parameters: &DVector<f64>) -> Option<DVector<f64>> {
        let (sections_m2, _) = self.simulate(parameters)?;
        let off = |seen: &Seen| {
            let section_m2 =
                sections_m2[seen.cell] * (1.0 - seen.share) + sections_m2[seen.cell + 1] * seen.share;
            (seen.width_m - stadium::width_of_area_m(section_m2, seen.height_m)) / seen.sigma_m
        };
        let prior = self.prior();
        let law = prior.iter().zip(parameters.iter()).map(|(deviation, value)| value / deviation);
        let walk = self.params.prior.gain_walk_rel * self.params.fit.gain_knot_m.sqrt();
        let gains = parameters.as_slice().get(GAIN..)?;
        let steps = gains.windows(2).map(|pair| (pair[1] - pair[0]) / walk);
        let all: Vec<f64> = self.seen.iter().map(off).chain(law).chain(steps).collect();
        Some(DVector::from_vec(all))
    }

    /// Standard deviations of the belief: law, and the gain at the first knot.
    pub(super) fn prior(&self) -> [f64; GAIN + 1] {
        let prior = &self.params.prior;
        [prior.compression_rel, prior.linear_lag_rel, prior.flow_index, prior.activation_rel, prior.gain]
    }
}

impl Nominal {
    pub(super) fn new(extruder: &Extruder, material: &Material, at_k: f64, speed_m_s: f64) -> Self {
        let melt = Melt::new(material, extruder);
        let force_n = melt.force_n(extruder.filament_area_m2() * speed_m_s, Kelvin(at_k));
        Self { at_k, speed_m_s, compression_m: extruder.compliance_m_n * force_n }
    }
}

#[cfg(test)]
mod tests;
