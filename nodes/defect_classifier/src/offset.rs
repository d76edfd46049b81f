//! Where what was laid before lies, beside where it was laid as commanded: lost steps show as an offset.
//!
//! The camera rides on the tool: after a layer shift new roads appear where they are commanded, and all that was laid
//! before appears shifted. So the predicted outline of the old part is moved over the picture: the likelihood of an
//! offset `d` is that of the picture's part and bed being where the outline, moved by `d`, has them. What lies under
//! or beside newer roads does not count: they hide it. Only the outer outline is used, not the lines inside, which
//! look alike every road's width. Evidence is added over frames and forgotten over seconds.

mod footprint;
mod fresh;
mod looks;
mod params;
#[cfg(test)]
mod tests;
mod view;

pub use params::{OffsetParams, RawOffset};

use crate::camera::Camera;
use crate::path::{PathHistory, Road};
use crate::surroundings::REDUCTION;
use footprint::Footprint;
use fresh::Fresh;
use looks::Class;
use models::units::Seconds;
use opencv::core::Mat;
use view::OldView;

/// Parts of one in which ratios are counted: whole numbers add up four to eight at a time.
const FINENESS: f64 = 64.0;

/// Where the old part lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Offset {
    /// Beside where it was laid, bed x and y `[m]`.
    pub offset_m: [f64; 2],
    /// Standard deviation of it, the worse axis `[m]`.
    pub sigma_m: f64,
}

/// Gathers evidence over frames. Knows no clock.
#[derive(Debug, Clone)]
pub struct OffsetFinder {
    params: OffsetParams,
    footprint: Footprint,
    /// Roads in the footprint end here: start of the last one's move.
    marked_until_s: f64,
    /// Log likelihood per offset, `side` to a row, from negative to positive x and y.
    evidence: Vec<f64>,
    /// Looks of the roads of the layer under way.
    fresh_looks: Class,
    /// Steps from the middle to the end of the range.
    reach: i32,
    last: Option<Seconds>,
}

impl OffsetFinder {
    /// Nothing laid, nothing seen.
    #[must_use]
    pub fn new(params: OffsetParams, camera: &Camera) -> Self {
        let cell_m = camera.scale_m * REDUCTION;
        let reach = whole((params.range_m / params.step_m).round()).max(1);
        let side = usize::try_from(2 * reach + 1).unwrap_or(1);
        Self {
            params,
            footprint: Footprint::new(params.bed_low_m, params.bed_high_m, cell_m),
            marked_until_s: f64::NEG_INFINITY,
            evidence: vec![0.0; side * side],
            fresh_looks: Class::default(),
            reach,
            last: None,
        }
    }

    /// Forgets what was seen, not what was laid: after a pause, or when axes were homed.
    pub fn forget(&mut self) {
        self.evidence.fill(0.0);
        self.fresh_looks = Class::default();
        self.last = None;
    }

    /// Takes a usable frame; the offset as far as it is known by now.
    ///
    /// # Errors
    /// A picture operation that failed.
    pub fn on_frame(
        &mut self,
        grey: &Mat,
        (path, exposed): (&PathHistory, Seconds),
        (camera, tool_m): (&Camera, [f64; 2]),
    ) -> Result<Option<Offset>, opencv::Error> {
        self.fade(exposed);
        let Some(&newest) = path.roads(exposed).next_back() else { return Ok(self.offset()) };
        let is_old = |road: &Road| road.layer != newest.layer || exposed.0 - road.start.0 > self.params.old_s;
        let mut fresh = Fresh::empty(camera)?;
        let mut marked_until_s = self.marked_until_s;
        for road in path.roads(exposed) {
            if is_old(road) {
                if road.start.0 > self.marked_until_s {
                    self.footprint.mark(road, road.length_m);
                    marked_until_s = marked_until_s.max(road.start.0);
                }
                continue;
            }
            let end = road.point_m(path.laid_m(road, exposed));
            fresh.draw((road, end), (camera, tool_m), &self.params)?;
        }
        self.marked_until_s = marked_until_s;
        let level = (newest.top_m, self.params.depth_m);
        let mut view = OldView::new((&self.footprint, level), &fresh.hides, (camera, tool_m))?;
        view.leave_out(
            [self.params.gap_m, self.params.fringe_m].map(|way_m| way_m / (camera.scale_m * REDUCTION)),
        )?;
        let looks = view.looks(grey)?;
        fresh.teach(&looks, &mut self.fresh_looks, camera)?;
        if let Some(ratios) = view.ratios(&looks, &self.fresh_looks, (&self.params, camera))? {
            self.weigh(&view, &ratios, camera);
        }
        Ok(self.offset())
    }

    fn fade(&mut self, exposed: Seconds) {
        let gap_s = self.last.map_or(0.0, |last| (exposed - last).0.max(0.0));
        self.last = Some(exposed);
        let kept = (-gap_s / self.params.memory_s).exp();
        self.evidence.iter_mut().for_each(|value| *value *= kept);
        self.fresh_looks.fade(kept);
    }

    /// Adds `sum ratio(q) s(q - d) / 2` over the pixels that count: s is 1 where the outline has part, -1 for bed.
    fn weigh(&mut self, view: &OldView, ratios: &[i16], camera: &Camera) {
        let step_px = self.params.step_m / (camera.scale_m * REDUCTION);
        let weight = 0.5 / (self.params.alike * FINENESS);
        let mut place = 0;
        for y in -self.reach..=self.reach {
            for x in -self.reach..=self.reach {
                let moved = [x, -y].map(|steps| whole((f64::from(steps) * step_px).round()));
                self.evidence[place] += weight * view.agreement(ratios, moved);
                place += 1;
            }
        }
    }

    /// Evidence and what is known before any: lost steps are rare.
    fn supported(&self) -> Vec<f64> {
        let side = 2 * self.reach + 1;
        let none = usize::try_from(self.reach * side + self.reach).unwrap_or(0);
        let rare =
            |(place, value): (usize, &f64)| if place == none { *value } else { value - self.params.rarity };
        self.evidence.iter().enumerate().map(rare).collect()
    }

    /// The offset where the frames tell; that lost steps are rare counts for its value, but is no knowledge of it.
    fn offset(&self) -> Option<Offset> {
        let (_, seen_sigma_m) = self.moments(&self.evidence);
        let (offset_m, sigma_m) = self.moments(&self.supported());
        let sigma_m = sigma_m.hypot(self.params.sigma_floor_m);
        let told = seen_sigma_m.max(sigma_m) <= self.params.sigma_max_m;
        told.then_some(Offset { offset_m, sigma_m })
    }

    /// Mean over all offsets, each with its likelihood, and standard deviation of the worse axis `[m]`.
    fn moments(&self, logs: &[f64]) -> ([f64; 2], f64) {
        let best = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let (mut total, mut first, mut second) = (0.0, [0.0; 2], [0.0; 2]);
        let steps = (-self.reach..=self.reach).flat_map(|y| (-self.reach..=self.reach).map(move |x| [x, y]));
        for (log, step) in logs.iter().zip(steps) {
            let share = (log - best).exp();
            total += share;
            for axis in 0..2 {
                let at_m = f64::from(step[axis]) * self.params.step_m;
                first[axis] += share * at_m;
                second[axis] += share * at_m * at_m;
            }
        }
        let mean_m = first.map(|sum| sum / total);
        let variance = [0, 1].map(|axis| (second[axis] / total - mean_m[axis].powi(2)).max(0.0));
        (mean_m, variance[0].max(variance[1]).sqrt())
    }
}

#[expect(clippy::cast_possible_truncation, reason = "small whole numbers; a cast saturates")]
fn whole(value: f64) -> i32 {
    value as i32
}
