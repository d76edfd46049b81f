//! What was laid when: a frame tells of the road of its exposure, which is not always the one of its arrival.

use crate::advance::Driven;
use crate::params::RawClog;
use models::bead::ROUND_SIDES;
use models::status::PrinterStatus;
use std::collections::VecDeque;

/// Statuses kept to meet a frame: 2 s at 50 Hz.
const KEPT: usize = 100;
/// Share by which the path is slower or faster at the next status where a ramp has begun until then `[-]`.
const RAMP: f64 = 0.02;

/// The road at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Road {
    /// Width that the slicer asked for `[m]`.
    pub(crate) target_m: f64,
    /// Height `[m]`, where it is known.
    pub(crate) height_m: Option<f64>,
    /// The slicer's feed of filament `[m/s]`.
    pub(crate) feed_m_s: f64,
    /// Filament that had passed the encoder beyond it `[m]`.
    pub(crate) excess_m: f64,
    /// What the drive held for a nozzle that has narrowed.
    pub(crate) driven: Driven,
    /// How long path, width and deposition have been as they are `[s]`.
    pub(crate) steady_s: f64,
    /// Mean of the slicer's feed over the time until it that was asked for `[m/s]`.
    pub(crate) mean_feed_m_s: f64,
    /// The next status is of the same at the same speed: else the ramp to a corner or to the road's end has begun, as far as
    /// anybody knows.
    pub(crate) goes_on: bool,
}

impl Road {
    /// What its section is off by, over what its width is `[-]`, 1 or more: of `w = A / h + h (1 - pi/4)` the round sides stay. 0 of a
    /// road that is no wider than they are.
    pub(crate) fn section(&self) -> f64 {
        let flat = self.height_m.map_or(1.0, |height_m| 1.0 - height_m * ROUND_SIDES / self.target_m);
        if flat > 0.0 { flat.recip() } else { 0.0 }
    }

    /// Whether it is fed, as it has been on the mean, and goes on: a short corner leaves nothing in a melt that is slower.
    pub(crate) fn is_settled(&self, settings: &RawClog) -> bool {
        let off_m_s = (self.mean_feed_m_s - self.feed_m_s).abs();
        self.feed_m_s > 0.0
            && self.goes_on
            && self.steady_s >= settings.steady_s
            && off_m_s <= settings.settled * self.feed_m_s
    }
}

/// A status, and since when it is as it is.
#[derive(Debug, Clone, Copy)]
struct Laid {
    stamp_s: f64,
    planned_speed_m_s: f64,
    feed_m_s: f64,
    target_m: Option<f64>,
    height_m: Option<f64>,
    excess_m: f64,
    driven: Driven,
    since_s: f64,
}

/// The roads of the last moments, newest last.
#[derive(Debug, Clone)]
pub(crate) struct Roads(VecDeque<Laid>);

impl Roads {
    /// Nothing was laid yet.
    pub(crate) fn new() -> Self {
        Self(VecDeque::with_capacity(KEPT))
    }

    /// Takes a status in, newer than all before, and the excess until then, and what the drive holds. A relative change of path speed or width beyond
    /// `spread` is one.
    pub(crate) fn on_status(
        &mut self,
        status: &PrinterStatus,
        (excess_m, driven): (f64, Driven),
        spread: f64,
    ) {
        let mut laid = Laid {
            stamp_s: status.stamp.0,
            planned_speed_m_s: status.planned_speed_m_s,
            feed_m_s: status.planned_feed_m_s,
            target_m: status.target_width_m.filter(|_| status.depositing),
            height_m: status.layer_height_m,
            excess_m,
            driven,
            since_s: status.stamp.0,
        };
        let before = self.0.back().filter(|before| !laid.differs_from(before, spread));
        laid.since_s = before.map_or(laid.stamp_s, |before| before.since_s);
        if self.0.len() == KEPT {
            self.0.pop_front();
        }
        self.0.push_back(laid);
    }

    /// The road that was laid at `exposed_s`, and the mean feed over `mean_s` until then; `None` where none was, or nobody knows
    /// any more.
    pub(crate) fn at(&self, exposed_s: f64, mean_s: f64) -> Option<Road> {
        let later = self.0.partition_point(|laid| laid.stamp_s <= exposed_s);
        let laid = self.0[later.checked_sub(1)?];
        Some(Road {
            target_m: laid.target_m?,
            height_m: laid.height_m,
            feed_m_s: laid.feed_m_s,
            excess_m: laid.excess_m,
            driven: laid.driven,
            steady_s: exposed_s - laid.since_s,
            mean_feed_m_s: self.mean_feed_m_s((exposed_s - mean_s, later)),
            goes_on: self.0.get(later).is_none_or(|next| next.continues(&laid)),
        })
    }

    /// Mean feed of the statuses before the `later`-th from `from_s` on, of the last of them at least `[m/s]`.
    fn mean_feed_m_s(&self, (from_s, later): (f64, usize)) -> f64 {
        let first = self.0.partition_point(|laid| laid.stamp_s <= from_s).min(later - 1);
        let feeds = self.0.range(first..later).map(|laid| laid.feed_m_s);
        feeds.sum::<f64>() / f64::from(u32::try_from(later - first).unwrap_or(u32::MAX))
    }
}

impl Laid {
    /// Whether nothing began between the one before and this.
    fn continues(&self, before: &Self) -> bool {
        let ramp_m_s = (self.planned_speed_m_s - before.planned_speed_m_s).abs();
        self.since_s <= before.since_s && ramp_m_s <= RAMP * before.planned_speed_m_s
    }

    fn differs_from(&self, before: &Self, spread: f64) -> bool {
        let changed = |old: f64, new: f64| (new - old).abs() > spread * old.abs().max(new.abs());
        let width = match (before.target_m, self.target_m) {
            (Some(old), Some(new)) => changed(old, new),
            _ => true,
        };
        width || changed(before.planned_speed_m_s, self.planned_speed_m_s)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::advance::tests::status;
    use models::bead::stadium;

    const FEED_M_S: f64 = 1.8e-3;

    /// Statuses at 50 Hz in the second until `now_s`, a corner of one status at `corner_s`.
    pub(crate) fn behind_a_corner(corner_s: f64, now_s: f64) -> Roads {
        let mut roads = Roads::new();
        for step in 0..=50 {
            let stamp_s = now_s - 1.0 + f64::from(step) * 0.02;
            let mut now = status(stamp_s, FEED_M_S);
            let slow = if (stamp_s - corner_s).abs() < 0.01 { 0.4 } else { 1.0 };
            now.planned_speed_m_s *= slow;
            now.planned_feed_m_s *= slow;
            now.target_width_m = Some(4.8e-4);
            roads.on_status(&now, (0.0, Driven::SOUND), 0.35);
        }
        roads
    }

    /// Statuses at 50 Hz over 3 s, a corner at 1.0 s and a wider road from 2.0 s on.
    fn roads() -> Roads {
        let mut roads = Roads::new();
        for step in 0..=150 {
            let stamp_s = f64::from(step) * 0.02;
            let mut now = status(stamp_s, FEED_M_S);
            now.planned_speed_m_s = if step == 50 { 0.02 } else { 0.06 };
            now.target_width_m = Some(if stamp_s < 2.0 { 4.8e-4 } else { 6.0e-4 });
            roads.on_status(&now, (stamp_s, Driven::SOUND), 0.1);
        }
        roads
    }

    #[test]
    fn a_frame_is_of_the_road_of_its_exposure() {
        let roads = roads();
        let road = roads.at(1.9, 0.3).unwrap();
        assert!((road.target_m - 4.8e-4).abs() < 1e-12);
        assert!((road.steady_s - 0.88).abs() < 1e-9, "the wider road came later: {road:?}");
        assert!((road.excess_m - 1.9).abs() < 0.021, "{road:?}");
        let road = roads.at(2.1, 0.3).unwrap();
        assert!((road.target_m - 6.0e-4).abs() < 1e-12);
        assert!((road.steady_s - 0.1).abs() < 1e-9, "{road:?}");
    }

    /// A stadium's round sides stay what they are: of a section that lacks a half, the width lacks less.
    #[test]
    fn a_width_tells_the_section_of_a_stadium() {
        let road = Road { height_m: Some(2e-4), ..roads().at(1.9, 0.3).unwrap() };
        let half_m2 = 0.5 * stadium::area_m2(road.target_m, 2e-4);
        let width = stadium::width_of_area_m(half_m2, 2e-4) / road.target_m - 1.0;
        assert!((road.section() * width + 0.5).abs() < 1e-12, "{width}");
        assert!((Road { height_m: None, ..road }.section() - 1.0).abs() < 1e-15);
        assert!(Road { height_m: Some(3e-3), ..road }.section().abs() < 1e-15, "all of it round");
    }

    #[test]
    fn a_corner_begins_a_road_anew() {
        let road = roads().at(1.25, 0.3).unwrap();
        assert!((road.steady_s - 0.23).abs() < 1e-9, "{road:?}");
    }

    /// The corner of one status in fifteen leaves 4 % of the mean feed, the same road just after a stop far more.
    #[test]
    fn a_short_corner_leaves_a_road_settled() {
        let settings = RawClog { feed_spread: 0.1, ..crate::clog::tests::SETTINGS };
        let mut roads = Roads::new();
        for step in 0..=60 {
            let mut now = status(f64::from(step) * 0.02, FEED_M_S);
            now.planned_speed_m_s = match step {
                30 => 0.02,
                50 => 0.055,
                _ => 0.06,
            };
            now.planned_feed_m_s = FEED_M_S * now.planned_speed_m_s / 0.06;
            now.depositing = step != 0;
            if step < 10 {
                now.planned_feed_m_s = 0.1 * FEED_M_S;
            }
            roads.on_status(&now, (0.0, Driven::SOUND), settings.feed_spread);
        }
        let settled = |at_s: f64| roads.at(at_s, settings.settles_s).unwrap().is_settled(&settings);
        assert!(!settled(0.3), "0.1 s after the slow start");
        assert!(settled(0.55));
        assert!(!settled(0.59), "the ramp to the corner has begun, or may have");
        assert!(!settled(0.61), "in the corner");
        assert!(!settled(0.63), "the road has not begun anew for long enough");
        assert!(settled(0.68));
        assert!(!settled(0.99), "the first of a ramp that is no change yet");
        assert!(settled(1.1));
    }

    #[test]
    fn of_what_is_too_old_nothing_is_known() {
        assert_eq!(roads().at(0.9, 0.3), None);
        assert!(roads().at(1.1, 0.3).is_some());
        assert_eq!(Roads::new().at(0.0, 0.3), None);
    }

    #[test]
    fn a_travel_is_no_road() {
        let mut roads = roads();
        let mut travel = status(3.02, FEED_M_S);
        travel.depositing = false;
        roads.on_status(&travel, (3.02, Driven::SOUND), 0.1);
        assert_eq!(roads.at(3.03, 0.3), None);
        let last = roads.at(3.01, 0.3).unwrap();
        assert!(!last.goes_on && roads.at(2.99, 0.3).unwrap().goes_on, "{last:?}");
    }
}
