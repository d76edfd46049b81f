//! Where a pixel lies on the bed: an orthographic camera that rides on the toolhead and looks straight down.
//!
//! Image x points to bed +X, image y to bed -Y; pixel centres have whole coordinates. The nozzle's tip lies at
//! `centre_px`, so a disc around it shows the head instead of the print.

use models::params::{ParamError, in_range};
use serde::Deserialize;

/// Geometry of the camera. Built only from a valid [`RawCamera`].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "RawCamera")]
pub struct Camera(RawCamera);

/// The `camera` block of `config/defect_classifier.param.yaml` as it is written.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RawCamera {
    /// Image width `[px]`.
    pub width_px: u16,
    /// Image height `[px]`.
    pub height_px: u16,
    /// Length on the bed per pixel `[m]`.
    pub scale_m: f64,
    /// Pixel of the nozzle's tip, column and row `[px]`.
    pub centre_px: [f64; 2],
    /// Radius around the tip that head and its shadow hide `[m]`.
    pub hidden_radius_m: f64,
}

impl std::ops::Deref for Camera {
    type Target = RawCamera;

    fn deref(&self) -> &RawCamera {
        &self.0
    }
}

impl TryFrom<RawCamera> for Camera {
    type Error = ParamError;

    fn try_from(raw: RawCamera) -> Result<Self, ParamError> {
        let (width_px, height_px) = (f64::from(raw.width_px), f64::from(raw.height_px));
        in_range("camera.width_px", width_px, "px", (64.0, 4096.0))?;
        in_range("camera.height_px", height_px, "px", (64.0, 4096.0))?;
        in_range("camera.scale_m", raw.scale_m, "m", (5e-6, 5e-4))?;
        in_range("camera.centre_px", raw.centre_px[0], "px", (0.0, width_px))?;
        in_range("camera.centre_px", raw.centre_px[1], "px", (0.0, height_px))?;
        in_range("camera.hidden_radius_m", raw.hidden_radius_m, "m", (1e-6, 0.1))?;
        Ok(Self(raw))
    }
}

impl Camera {
    /// Pixel of a bed position while the tip is at `tool_m`.
    #[must_use]
    pub fn pixel(&self, tool_m: [f64; 2], bed_m: [f64; 2]) -> [f64; 2] {
        [
            self.centre_px[0] + (bed_m[0] - tool_m[0]) / self.scale_m,
            self.centre_px[1] - (bed_m[1] - tool_m[1]) / self.scale_m,
        ]
    }

    /// Bed position `[m]` of a pixel while the tip is at `tool_m`.
    #[must_use]
    pub fn bed(&self, tool_m: [f64; 2], pixel: [f64; 2]) -> [f64; 2] {
        [
            tool_m[0] + (pixel[0] - self.centre_px[0]) * self.scale_m,
            tool_m[1] - (pixel[1] - self.centre_px[1]) * self.scale_m,
        ]
    }

    /// Whether a pixel is inside the image, `margin_px` from its border, and not hidden by the head.
    #[must_use]
    pub fn sees(&self, pixel: [f64; 2], margin_px: f64) -> bool {
        let inside = |value: f64, size: u16| value >= margin_px && value <= f64::from(size) - 1.0 - margin_px;
        // Asked of each pixel of a picture: squares are cheaper than a root.
        let away_px = [0, 1].map(|axis| pixel[axis] - self.centre_px[axis]);
        let hidden_px = self.hidden_radius_m / self.scale_m;
        inside(pixel[0], self.width_px)
            && inside(pixel[1], self.height_px)
            && away_px[0] * away_px[0] + away_px[1] * away_px[1] >= hidden_px * hidden_px
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use proptest::prelude::*;

    pub(crate) fn camera() -> Camera {
        Camera::try_from(RawCamera {
            width_px: 640,
            height_px: 480,
            scale_m: 3e-5,
            centre_px: [319.5, 239.5],
            hidden_radius_m: 2.5e-3,
        })
        .unwrap()
    }

    #[test]
    fn image_x_is_bed_x_and_image_y_is_bed_y_downwards() {
        let tool_m = [0.1, 0.1];
        let right = camera().pixel(tool_m, [0.103, 0.1]);
        let up = camera().pixel(tool_m, [0.1, 0.103]);
        assert!((right[0] - 419.5).abs() < 1e-6 && (up[1] - 139.5).abs() < 1e-6);
    }

    #[test]
    fn the_head_hides_what_is_near_the_tip() {
        assert!(!camera().sees([319.5 + 83.0, 239.5], 4.0));
        assert!(camera().sees([319.5 + 84.0, 239.5], 4.0));
        assert!(!camera().sees([2.0, 239.5], 4.0) && !camera().sees([320.0, f64::NAN], 4.0));
    }

    proptest! {
        #[test]
        fn a_pixel_and_back_is_the_identity(x in 0.0..0.3_f64, y in 0.0..0.3_f64, u in 0.0..640.0_f64, v in 0.0..480.0_f64) {
            let back = camera().pixel([x, y], camera().bed([x, y], [u, v]));
            prop_assert!((back[0] - u).abs() < 1e-6 && (back[1] - v).abs() < 1e-6);
        }
    }
}
