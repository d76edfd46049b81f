//! Parameters of the camera: the `camera` block of `config/printer_sim.param.yaml`.

use super::geometry::Geometry;
use models::params::{ParamError, in_range};
use rand::Rng;
use serde::Deserialize;

/// Whose ranges a camera is drawn from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Style {
    /// For frames that a classifier is trained with.
    Training,
    /// For simulated prints, and for judging a classifier.
    Test,
}

/// Surface of a bed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TextureKind {
    /// Coarse powder coat: textured PEI.
    Grain,
    /// Fine lines one way: brushed or ground.
    Brushed,
    /// Crossed threads: carbon or glass cloth.
    Weave,
    /// Smooth with smears: glass with glue.
    Smears,
    /// Small dots on a smooth ground: perforated or ceramic coated glass.
    Dots,
}

/// A range to draw from; both ends may be equal.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(from = "[f64; 2]")]
pub struct Span {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl From<[f64; 2]> for Span {
    fn from([low, high]: [f64; 2]) -> Self {
        Self { low, high }
    }
}

impl Span {
    /// A value from the range, evenly spread.
    pub fn draw(&self, rng: &mut impl Rng) -> f64 {
        self.low + (self.high - self.low) * rng.random::<f64>()
    }

    fn check(
        &self,
        name: &'static str,
        unit: &'static str,
        (low, high): (f64, f64),
    ) -> Result<(), ParamError> {
        in_range(name, self.low, unit, (low, high))?;
        in_range(name, self.high, unit, (self.low, high)).map(|_| ())
    }
}

/// Ranges that a camera and its surroundings are drawn from.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "unit, range and meaning stand beside each value in the file")]
pub struct StyleRanges {
    pub light_elevation_rad: Span,
    pub fill_share: Span,
    pub ambient_share: Span,
    pub diffuse_wrap: Span,
    pub gloss: Span,
    pub gloss_log2: Span,
    pub occlusion: Span,
    pub filament_grey: Span,
    pub filament_grain: Span,
    pub bed_grey: Span,
    pub bed_texture: Span,
    pub bed_kinds: Vec<TextureKind>,
    pub exposure_gain: Span,
    pub vignette: Span,
    pub noise_grey: Span,
    pub noise_share: Span,
    pub blur_px: Span,
    pub exposure_s: Span,
    pub jpeg_quality: Span,
    pub nozzle_radius_m: Span,
    pub nozzle_grey: Span,
}

impl StyleRanges {
    fn check(&self) -> Result<(), ParamError> {
        let share = (0.0, 1.0);
        self.light_elevation_rad.check("light_elevation_rad", "rad", (0.05, 1.57))?;
        self.fill_share.check("fill_share", "-", share)?;
        self.ambient_share.check("ambient_share", "-", share)?;
        self.diffuse_wrap.check("diffuse_wrap", "-", (0.0, 0.9))?;
        self.gloss.check("gloss", "-", (0.0, 4.0))?;
        self.gloss_log2.check("gloss_log2", "-", (2.0, 6.0))?;
        self.occlusion.check("occlusion", "-", (0.0, 4.0))?;
        self.filament_grey.check("filament_grey", "-", share)?;
        self.filament_grain.check("filament_grain", "-", share)?;
        self.bed_grey.check("bed_grey", "-", share)?;
        self.bed_texture.check("bed_texture", "-", share)?;
        self.exposure_gain.check("exposure_gain", "-", (0.1, 4.0))?;
        self.vignette.check("vignette", "-", share)?;
        self.noise_grey.check("noise_grey", "-", (0.0, 0.2))?;
        self.noise_share.check("noise_share", "-", (0.0, 0.5))?;
        self.blur_px.check("blur_px", "px", (0.3, 2.0))?;
        self.exposure_s.check("exposure_s", "s", (0.0, 0.05))?;
        self.jpeg_quality.check("jpeg_quality", "-", (1.0, 100.0))?;
        self.nozzle_radius_m.check("nozzle_radius_m", "m", (2e-4, 1e-2))?;
        self.nozzle_grey.check("nozzle_grey", "-", share)?;
        #[allow(clippy::cast_precision_loss, reason = "a handful")]
        in_range("bed_kinds", self.bed_kinds.len() as f64, "entries", (1.0, 64.0))?;
        Ok(())
    }
}

/// How roads become a height field.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "unit, range and meaning stand beside each value in the file")]
pub struct FieldParams {
    pub tiles_max: usize,
    pub overlap_share: f64,
    pub ridge_share: f64,
    pub squish_from: f64,
    pub squish_full: f64,
    pub strand_m: f64,
    pub piece_m: f64,
}

/// The camera. Built only from a valid [`RawCamera`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "RawCamera")]
pub struct CameraParams {
    /// The simulated printer renders frames.
    pub enabled: bool,
    /// Time between exposures `[s]`.
    pub period_s: f64,
    /// Most by which an exposure comes sooner or later `[-]`, of the period.
    pub dither: f64,
    /// From exposure to the frame's arrival `[s]`.
    pub delay_s: f64,
    /// Image size and scale.
    pub geometry: Geometry,
    /// Ranges of simulated prints.
    pub style: Style,
    /// Height field.
    pub field: FieldParams,
    /// Ranges of [`Style::Training`].
    pub training: StyleRanges,
    /// Ranges of [`Style::Test`].
    pub test: StyleRanges,
}

/// The `camera` block as it is written.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs, reason = "unit, range and meaning stand beside each value in the file")]
pub struct RawCamera {
    pub enabled: bool,
    pub period_s: f64,
    pub dither: f64,
    pub delay_s: f64,
    pub width_px: usize,
    pub height_px: usize,
    pub scale_m: f64,
    pub working_distance_m: f64,
    pub style: Style,
    pub field: FieldParams,
    pub training: StyleRanges,
    pub test: StyleRanges,
}

impl TryFrom<RawCamera> for CameraParams {
    type Error = ParamError;
    fn try_from(raw: RawCamera) -> Result<Self, ParamError> {
        raw.training.check()?;
        raw.test.check()?;
        let field = raw.field;
        #[allow(clippy::cast_precision_loss, reason = "far below 2^52")]
        in_range("tiles_max", field.tiles_max as f64, "-", (64.0, 65_536.0))?;
        in_range("overlap_share", field.overlap_share, "-", (0.0, 1.0))?;
        in_range("ridge_share", field.ridge_share, "-", (0.0, 1.0))?;
        in_range("squish_from", field.squish_from, "-", (1.0, 10.0))?;
        in_range("squish_full", field.squish_full, "-", (field.squish_from + 0.1, 20.0))?;
        in_range("strand_m", field.strand_m, "m", (5e-5, 2e-3))?;
        in_range("piece_m", field.piece_m, "m", (1e-5, 2e-3))?;
        Ok(Self {
            enabled: raw.enabled,
            period_s: in_range("period_s", raw.period_s, "s", (0.01, 60.0))?,
            dither: in_range("dither", raw.dither, "-", (0.0, 0.5))?,
            delay_s: in_range("delay_s", raw.delay_s, "s", (0.0, 10.0))?,
            geometry: Geometry::new((raw.width_px, raw.height_px), raw.scale_m, raw.working_distance_m)?,
            style: raw.style,
            field,
            training: raw.training,
            test: raw.test,
        })
    }
}

impl CameraParams {
    /// Ranges of a style.
    #[must_use]
    pub fn ranges(&self, style: Style) -> &StyleRanges {
        match style {
            Style::Training => &self.training,
            Style::Test => &self.test,
        }
    }
}
