//! Quality Q_k of a layer and each of its terms ([QC] (18), model book 1.6), from what was seen and estimated of it.

use models::bead::stadium;
use models::hotend::{Hotend, Inputs};
use models::latent::{Cooling, LaidBead, adhesion, fill};
use models::material::Material;
use models::params::{ParamError, in_range};
use models::printer::Printer;
use models::quality::{Observed, Quality, Terms};
use models::status::PrinterStatus;
use models::units::{Kelvin, Seconds};
use serde::Deserialize;

/// Settings of the quality figure. Built only from a valid [`RawLayer`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawLayer")]
pub struct LayerParams(RawLayer);

/// The `layer` block as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawLayer {
    /// Time between two figures of a layer under way `[s]`.
    pub period_s: f64,
    /// Offset that counts as one error of a feature `[m]`.
    pub offset_unit_m: f64,
    /// Room and incoming filament `[K]`.
    pub ambient_k: f64,
    /// How much colder than the bed's set-point the layer below the road is `[K]`.
    pub below_bed_k: f64,
    /// Flow at which the slicer's set-point is meant `[m3/s]`.
    pub reference_flow_m3_s: f64,
}

impl TryFrom<RawLayer> for LayerParams {
    type Error = ParamError;

    fn try_from(raw: RawLayer) -> Result<Self, ParamError> {
        in_range("layer.period_s", raw.period_s, "s", (0.05, 60.0))?;
        in_range("layer.offset_unit_m", raw.offset_unit_m, "m", (1e-6, 0.1))?;
        in_range("layer.ambient_k", raw.ambient_k, "K", (200.0, 400.0))?;
        in_range("layer.below_bed_k", raw.below_bed_k, "K", (0.0, 100.0))?;
        in_range("layer.reference_flow_m3_s", raw.reference_flow_m3_s, "m3/s", (0.0, 1e-7))?;
        Ok(Self(raw))
    }
}

impl LayerParams {
    /// Room and incoming filament.
    #[must_use]
    pub fn ambient(&self) -> Kelvin {
        Kelvin(self.0.ambient_k)
    }
}

/// Quality of one layer, done or under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LayerFigure {
    /// Time of the figure.
    pub stamp: Seconds,
    /// Layer from 0.
    pub layer: u32,
    /// The layer is done.
    pub complete: bool,
    /// Weighted terms; their total is Q_k.
    pub terms: Terms,
    /// Mean of width over target less one `[-]`.
    pub width_error_rel: f64,
    /// Root mean square of it, with the measurements' own variance taken out `[-]`.
    pub width_rms_rel: f64,
    /// Width measurements in it.
    pub widths: u32,
    /// Frames that could be judged.
    pub frames: u32,
}

/// A width with what was wanted there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenWidth {
    /// Measured `[m]`.
    pub width_m: f64,
    /// Its standard deviation `[m]`.
    pub sigma_m: f64,
    /// Wanted `[m]`.
    pub wanted_m: f64,
    /// Height of the road `[m]`.
    pub height_m: f64,
}

/// Sums over one layer.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Sums {
    widths: u32,
    error_rel: f64,
    error_rel_sq: f64,
    laid_m2: f64,
    wanted_m2: f64,
    frames: u32,
    offsets: f64,
    offset_sq: f64,
    estimates: f64,
    temperature_sq_k2: f64,
    not_bonded_sq: f64,
}

/// What the quality is a quality of.
#[derive(Debug, Clone)]
pub struct Nominal {
    /// The quality functional.
    pub quality: Quality,
    /// The nominal printer.
    pub printer: Printer,
    /// The nominal material.
    pub material: Material,
}

/// Gathers a layer after the other. Knows no clock.
#[derive(Debug, Clone)]
pub struct LayerQuality {
    params: LayerParams,
    nominal: Nominal,
    layer: Option<u32>,
    sums: Sums,
    due: Option<f64>,
}

impl LayerQuality {
    /// Nothing gathered.
    #[must_use]
    pub fn new(params: LayerParams, nominal: Nominal) -> Self {
        Self { params, nominal, layer: None, sums: Sums::default(), due: None }
    }

    /// A width was measured.
    pub fn on_width(&mut self, seen: &SeenWidth) {
        let (error, doubt) = (seen.width_m / seen.wanted_m - 1.0, seen.sigma_m / seen.wanted_m);
        let sums = &mut self.sums;
        sums.widths += 1;
        sums.error_rel += error;
        // Noise alone would look like an uneven road.
        sums.error_rel_sq += error * error - doubt * doubt;
        sums.laid_m2 += stadium::area_m2(seen.width_m, seen.height_m).max(0.0);
        sums.wanted_m2 += stadium::area_m2(seen.wanted_m, seen.height_m);
    }

    /// A frame was judged; `offset_m` of what lies below, where known.
    pub fn on_frame(&mut self, offset_m: Option<[f64; 2]>) {
        self.sums.frames += 1;
        if let Some([x_m, y_m]) = offset_m {
            self.sums.offsets += 1.0;
            self.sums.offset_sq += (x_m.powi(2) + y_m.powi(2)) / self.params.0.offset_unit_m.powi(2);
        }
    }

    /// The nozzle was estimated while a road was laid.
    pub fn on_nozzle(&mut self, nozzle: Kelvin, status: &PrinterStatus) {
        let (Some(width_m), Some(height_m)) = (status.target_width_m, status.layer_height_m) else { return };
        let raw = &self.params.0;
        let wanted = reference(&self.nominal.printer.hotend, &self.nominal.material, raw, status);
        let bead = LaidBead {
            nozzle_k: nozzle.0,
            below_k: Kelvin::from(status.bed_target).0 - raw.below_bed_k,
            ambient_k: raw.ambient_k,
            height_m,
            width_m,
            fan: status.fan,
        };
        let cooling: &Cooling = &self.nominal.printer.cooling;
        let bond_s = cooling.bond_time_s(&self.nominal.material, &bead);
        self.sums.estimates += 1.0;
        self.sums.temperature_sq_k2 += (nozzle.0 - wanted.0).powi(2);
        self.sums.not_bonded_sq += (1.0 - adhesion(bond_s, self.nominal.material.adhesion_time_s)).powi(2);
    }

    /// The printer is at this layer: the figure of the one before when it changes, else one a period.
    pub fn on_layer(&mut self, stamp: Seconds, layer: Option<u32>) -> Option<LayerFigure> {
        if layer != self.layer {
            let done = self.layer.map(|done| self.figure(stamp, done, true));
            self.layer = layer;
            self.sums = Sums::default();
            self.due = Some(stamp.0 + self.params.0.period_s);
            return done.filter(|figure| figure.frames > 0 || figure.widths > 0);
        }
        let due = self.due.is_none_or(|due| stamp.0 >= due);
        let layer = self.layer.filter(|_| due)?;
        self.due = Some(stamp.0 + self.params.0.period_s);
        Some(self.figure(stamp, layer, false))
    }

    /// Each term is its mean over the layer; porosity is the layer's whole, (9): `phi = 1 - V_extr / V_layer`.
    fn figure(&self, stamp: Seconds, layer: u32, complete: bool) -> LayerFigure {
        let sums = &self.sums;
        let mean = |sum: f64, count: f64| if count > 0.0 { sum / count } else { 0.0 };
        let widths = f64::from(sums.widths);
        let width_rms_rel = mean(sums.error_rel_sq, widths).max(0.0).sqrt();
        let porosity = if sums.wanted_m2 > 0.0 { fill(sums.laid_m2, sums.wanted_m2).porosity } else { 0.0 };
        let offset = mean(sums.offset_sq, sums.offsets).sqrt();
        // Root mean squares go in, so that each squared term is the mean of squares.
        let terms = self.nominal.quality.terms(&Observed {
            feature_errors: &[offset],
            width_m: 1.0 + width_rms_rel,
            width_wanted_m: 1.0,
            temperature_error_k: mean(sums.temperature_sq_k2, sums.estimates).sqrt(),
            adhesion: 1.0 - mean(sums.not_bonded_sq, sums.estimates).sqrt(),
            porosity,
        });
        LayerFigure {
            stamp,
            layer,
            complete,
            terms,
            width_error_rel: mean(sums.error_rel, widths),
            width_rms_rel,
            widths: sums.widths,
            frames: sums.frames,
        }
    }
}

/// Nozzle temperature that the file's set-point means: the block's less the steady drop at the reference flow.
fn reference(hotend: &Hotend, material: &Material, raw: &RawLayer, status: &PrinterStatus) -> Kelvin {
    let inputs = Inputs {
        heater_w: 0.0,
        fan: material.fan,
        ambient_k: raw.ambient_k,
        filament_k: raw.ambient_k,
        melt_w_k: material.heat_flow_w_k(raw.reference_flow_m3_s),
    };
    let wanted_k = material.nozzle_temp_k;
    let drop_k = hotend.steady(wanted_k, &inputs).block_k - wanted_k;
    // The drop is linear in the nozzle's excess over air.
    let slope = drop_k / (wanted_k - raw.ambient_k);
    Kelvin(raw.ambient_k + (Kelvin::from(status.hotend_sliced_target).0 - raw.ambient_k) / (1.0 + slope))
}
