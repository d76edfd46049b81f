//! Where a pixel lies on the bed.

use models::params::{ParamError, in_range};

/// Image size and scale of an orthographic camera that looks straight down. Built by [`Geometry::new`] alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geometry {
    width_px: usize,
    height_px: usize,
    scale_m: f64,
    working_distance_m: f64,
}

impl Geometry {
    /// An image of `size_px` (width, height), `scale_m` metres a pixel, with the lens `working_distance_m` above.
    ///
    /// # Errors
    /// [`ParamError`] outside 64 to 4096 pixels, 5 to 500 um, 5 mm to 1 m.
    #[allow(clippy::cast_precision_loss, reason = "sizes are far below 2^52")]
    pub fn new(size_px: (usize, usize), scale_m: f64, working_distance_m: f64) -> Result<Self, ParamError> {
        in_range("camera.width_px", size_px.0 as f64, "px", (64.0, 4096.0))?;
        in_range("camera.height_px", size_px.1 as f64, "px", (64.0, 4096.0))?;
        Ok(Self {
            width_px: size_px.0,
            height_px: size_px.1,
            scale_m: in_range("camera.scale_m", scale_m, "m", (5e-6, 5e-4))?,
            working_distance_m: in_range("camera.working_distance_m", working_distance_m, "m", (5e-3, 1.0))?,
        })
    }

    /// Image width `[px]`.
    #[must_use]
    pub fn width_px(&self) -> usize {
        self.width_px
    }

    /// Image height `[px]`.
    #[must_use]
    pub fn height_px(&self) -> usize {
        self.height_px
    }

    /// Length on the bed per pixel, and side of a cell of the height field `[m]`.
    #[must_use]
    pub fn scale_m(&self) -> f64 {
        self.scale_m
    }

    /// From lens to nozzle tip `[m]`.
    #[must_use]
    pub fn working_distance_m(&self) -> f64 {
        self.working_distance_m
    }

    /// Principal point, where the nozzle's tip lies: the image's centre `[px]`, pixel centres being whole.
    #[must_use]
    #[allow(clippy::cast_precision_loss, reason = "sizes are far below 2^52")]
    pub fn principal_px(&self) -> [f64; 2] {
        [(self.width_px as f64 - 1.0) / 2.0, (self.height_px as f64 - 1.0) / 2.0]
    }

    /// Focal length in pixels, as `CameraInfo.k` wants it: `fx = fy = working_distance / scale`.
    #[must_use]
    pub fn focal_px(&self) -> f64 {
        self.working_distance_m / self.scale_m
    }

    /// Bed position `[m]` of a pixel while the tool is at `tool_m`.
    #[must_use]
    pub fn bed_from_pixel(&self, tool_m: [f64; 2], pixel: [f64; 2]) -> [f64; 2] {
        let [cx, cy] = self.principal_px();
        [tool_m[0] + (pixel[0] - cx) * self.scale_m, tool_m[1] - (pixel[1] - cy) * self.scale_m]
    }

    /// Pixel of a bed position while the tool is at `tool_m`.
    #[must_use]
    pub fn pixel_from_bed(&self, tool_m: [f64; 2], bed_m: [f64; 2]) -> [f64; 2] {
        let [cx, cy] = self.principal_px();
        [cx + (bed_m[0] - tool_m[0]) / self.scale_m, cy - (bed_m[1] - tool_m[1]) / self.scale_m]
    }
}
