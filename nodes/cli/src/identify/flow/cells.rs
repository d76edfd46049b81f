//! The print in pieces from one count of the filament to the next, and the widths that can be compared.

use crate::identify::heat::HeatFit;
use crate::identify::params::Fitting;
use crate::identify::record::{At, Recorded};
use crate::identify::series;

/// From one count of the filament to the next.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    pub(super) end_s: f64,
    pub(super) dt_s: f64,
    pub(super) fed_m: f64,
    /// Way of the tool `[m]`.
    pub(super) path_m: f64,
    pub(super) nozzle_k: f64,
    /// Width and height that were asked for, where a road is laid `[m]`.
    pub(super) road: Option<(f64, f64)>,
    /// Knot of the gain at or before the filament that is fed.
    pub(super) knot: usize,
    /// Way to the next one, in shares of their distance.
    pub(super) share: f64,
}

/// A width that is compared.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    /// Cell that ends at or before the exposure.
    pub(super) cell: usize,
    /// Way to the end of the next one, in shares.
    pub(super) share: f64,
    pub(super) width_m: f64,
    pub(super) height_m: f64,
    pub(super) sigma_m: f64,
}

/// All cells from the first filament on, and the number of knots of the gain.
pub(super) fn cells(recorded: &Recorded, heat: &HeatFit, fit: &Fitting) -> (Vec<Cell>, usize) {
    let fed = thinned(&recorded.fed_m(), fit.cell_s);
    let knot_m = fit.gain_knot_m;
    let speeds: Vec<At> = recorded.states.iter().map(|state| (state.stamp.0, state.path_speed_m_s)).collect();
    let origin_m = fed.first().map_or(0.0, |first| first.1);
    let still = fed.windows(2).take_while(|pair| pair[1].1 <= origin_m).count();
    let (mut cells, mut knots) = (Vec::new(), 2);
    for pair in fed[still.min(fed.len())..].windows(2) {
        let ((from_s, from_m), (end_s, to_m)) = (pair[0], pair[1]);
        let middle_s = 0.5 * (from_s + end_s);
        // A state holds what was so up to its stamp.
        let state = recorded.states.partition_point(|state| state.stamp.0 < middle_s);
        let state = recorded.states.get(state);
        let place = ((from_m - origin_m) / knot_m).max(0.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 or more, and few")]
        let knot = place.floor() as usize;
        knots = knots.max(knot + 2);
        cells.push(Cell {
            end_s,
            dt_s: end_s - from_s,
            fed_m: to_m - from_m,
            path_m: series::at(&speeds, middle_s) * (end_s - from_s),
            nozzle_k: series::at(&heat.nozzle_k, middle_s),
            road: state
                .filter(|state| state.depositing)
                .and_then(|state| Some((state.target_width_m?, state.layer_height_m?))),
            knot,
            share: place.fract(),
        });
    }
    (cells, knots)
}

/// Counts no closer together than this.
fn thinned(fed_m: &[At], apart_s: f64) -> Vec<At> {
    let mut kept: Vec<At> = Vec::new();
    for count in fed_m {
        // Stamps are rounded: half a microsecond early is not early.
        if kept.last().is_none_or(|last| count.0 - last.0 >= apart_s - 5e-7) {
            kept.push(*count);
        }
    }
    kept
}

/// The widths of roads that were laid for a while, at a speed that did not change around the exposure.
pub(super) fn seen(recorded: &Recorded, cells: &[Cell], fit: &Fitting) -> Vec<Seen> {
    let mut seen = Vec::new();
    for width in &recorded.widths {
        let next = cells.partition_point(|cell| cell.end_s <= width.at_s);
        let Some((before, after)) =
            next.checked_sub(1).and_then(|at| Some((cells.get(at)?, cells.get(next)?)))
        else {
            continue;
        };
        let long = cells[..=next].iter().rev().take_while(|cell| cell.end_s > width.at_s - fit.road_s);
        let laid = long.clone().all(|cell| cell.road.is_some());
        let from = recorded.states.partition_point(|state| state.stamp.0 < width.at_s - fit.calm_s);
        let around =
            recorded.states[from..].iter().take_while(|state| state.stamp.0 <= width.at_s + fit.calm_s);
        let (low, high) = around.fold((f64::INFINITY, 0.0_f64), |(low, high), state| {
            (low.min(state.path_speed_m_s), high.max(state.path_speed_m_s))
        });
        let calm = high > 0.0 && high - low <= fit.calm_rel * high;
        if let (true, true, Some((_, height_m))) = (laid, calm, after.road) {
            seen.push(Seen {
                cell: next - 1,
                share: (width.at_s - before.end_s) / after.dt_s,
                width_m: width.width_m,
                height_m,
                sigma_m: width.sigma_m,
            });
        }
    }
    seen
}
