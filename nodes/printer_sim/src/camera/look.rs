//! One camera with its surroundings: a draw of a style's ranges.

use super::cast::single;
use super::params::{StyleRanges, TextureKind};
use rand::{Rng, SeedableRng, rngs::StdRng};

/// Light, greys, gloss, bed and lens of one camera. Levels are relative to white `[-]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Direction towards the main light, image frame with z to the camera.
    pub(super) light: [f32; 3],
    /// Direction towards the weak light.
    pub(super) fill: [f32; 3],
    pub(super) light_share: f32,
    pub(super) fill_share: f32,
    pub(super) ambient_share: f32,
    pub(super) wrap: f32,
    pub(super) gloss: f32,
    pub(super) gloss_log2: f32,
    pub(super) occlusion: f32,
    pub(super) filament_grey: f32,
    pub(super) filament_grain: f32,
    pub(super) bed_grey: f32,
    pub(super) bed_texture: f32,
    pub(super) bed_kind: TextureKind,
    pub(super) gain: f32,
    pub(super) vignette: f32,
    pub(super) noise_grey: f32,
    pub(super) noise_share: f32,
    pub(super) blur_px: f32,
    pub(super) nozzle_grey: f32,
    /// Exposure time `[s]`.
    pub exposure_s: f64,
    /// JPEG quality `[1, 100]`.
    pub jpeg_quality: u8,
    /// Radius of the disc that the head hides `[m]`.
    pub nozzle_radius_m: f64,
    /// Seed of textures and noise.
    pub(super) seed: u64,
}

impl Look {
    /// The camera that this seed gives; the same seed and ranges give the same camera.
    #[must_use]
    pub fn draw(ranges: &StyleRanges, seed: u64) -> Self {
        let rng = &mut StdRng::seed_from_u64(seed);
        let azimuth = rng.random::<f64>() * std::f64::consts::TAU;
        let fill_azimuth = azimuth + std::f64::consts::PI + rng.random_range(-1.0..1.0);
        let light = towards(azimuth, ranges.light_elevation_rad.draw(rng));
        let fill = towards(fill_azimuth, ranges.light_elevation_rad.draw(rng));
        let mut take = |span: &super::Span| span.draw(rng);
        let fill_share = take(&ranges.fill_share);
        let ambient_share = take(&ranges.ambient_share);
        let wrap = take(&ranges.diffuse_wrap);
        // What flat ground reflects is set to one, so that greys and exposure mean the same under any light.
        let flat = |direction: [f32; 3]| f64::from(direction[2]) * (1.0 - wrap) + wrap;
        let flat_sum = flat(light) + fill_share * flat(fill);
        let lights = (1.0 - ambient_share) / flat_sum;
        Self {
            light,
            fill,
            light_share: single(lights),
            fill_share: single(lights * fill_share),
            ambient_share: single(ambient_share),
            wrap: single(wrap),
            gloss: single(take(&ranges.gloss)),
            gloss_log2: single(take(&ranges.gloss_log2)),
            occlusion: single(take(&ranges.occlusion)),
            filament_grey: single(take(&ranges.filament_grey)),
            filament_grain: single(take(&ranges.filament_grain)),
            bed_grey: single(take(&ranges.bed_grey)),
            bed_texture: single(take(&ranges.bed_texture)),
            gain: single(take(&ranges.exposure_gain)),
            vignette: single(take(&ranges.vignette)),
            noise_grey: single(take(&ranges.noise_grey)),
            noise_share: single(take(&ranges.noise_share)),
            blur_px: single(take(&ranges.blur_px)),
            nozzle_grey: single(take(&ranges.nozzle_grey)),
            exposure_s: take(&ranges.exposure_s),
            jpeg_quality: quality(take(&ranges.jpeg_quality)),
            nozzle_radius_m: take(&ranges.nozzle_radius_m),
            bed_kind: ranges.bed_kinds[rng.random_range(0..ranges.bed_kinds.len())],
            seed,
        }
    }
}

fn towards(azimuth: f64, elevation: f64) -> [f32; 3] {
    let flat = elevation.cos();
    [single(azimuth.cos() * flat), single(azimuth.sin() * flat), single(elevation.sin())]
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked to lie in [1, 100]")]
fn quality(value: f64) -> u8 {
    value.round() as u8
}
