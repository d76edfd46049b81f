//! A wall of metal wire: its height as measured, and as it really is where it was simulated.

use super::super::series::Series;
use fdm_loop_msgs::{LayerHeight, SimWire};

/// Heights over time.
#[derive(Debug, Default)]
pub(crate) struct Wall {
    pub(crate) measured_mm: Series,
    pub(crate) height_mm: Series,
    pub(crate) layer_rms_mm: Series,
    /// Highest number of a layer that was measured.
    highest: Option<u32>,
    /// Newest truth, for its sums.
    pub(crate) last: Option<SimWire>,
}

impl Wall {
    /// Takes a measured height in.
    pub(crate) fn measured(&mut self, at: f64, height: &LayerHeight) {
        self.measured_mm.add(at, height.height_m * 1e3);
        self.highest = self.highest.max(Some(height.layer));
    }

    /// Layers that are complete, or that were begun where only measurements tell; `None` where there is no wall.
    pub(crate) fn layers(&self) -> Option<u64> {
        let complete = self.last.as_ref().map(|truth| u64::from(truth.layers_complete));
        complete.or(self.highest.map(|layer| u64::from(layer) + 1))
    }

    /// Takes the truth in.
    pub(crate) fn truth(&mut self, at: f64, truth: &SimWire) {
        self.height_mm.add(at, truth.height_m * 1e3);
        if truth.layers_complete > 0 {
            self.layer_rms_mm.add(at, truth.layer_rms_m * 1e3);
        }
        self.last = Some(truth.clone());
    }
}
