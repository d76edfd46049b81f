//! Time on the page: stamps of the nodes' clock, from the first one of the bag on.

use fdm_loop_msgs::Header;

/// A stamp further back than this behind the newest is no late message `[s]`.
const BACK_S: f64 = 30.0;
/// A stamp further ahead is no silence `[s]`.
const AHEAD_S: f64 = 600.0;
/// So many strange stamps in a row: the clock itself has jumped, as when a second print went into the same bag.
const JUMP: u32 = 50;

/// Maps stamps to seconds from the start.
#[derive(Debug, Default)]
pub(crate) struct Timeline {
    /// What is taken off a stamp.
    zero_s: Option<f64>,
    /// The newest place on the axis.
    pub(crate) newest_s: f64,
    in_a_row: u32,
    /// Stamps that do not fit to the others.
    pub(crate) strange: u64,
    /// Places on the axis at which the clock jumped.
    pub(crate) jumps: Vec<f64>,
}

impl Timeline {
    /// Place of a header's stamp on the axis; `None` where it does not fit.
    pub(crate) fn at(&mut self, header: &Header) -> Option<f64> {
        let Some(stamp_s) = header.stamp.seconds() else {
            self.strange += 1;
            return None;
        };
        let zero_s = *self.zero_s.get_or_insert(stamp_s);
        let at = stamp_s - zero_s;
        if (self.newest_s - BACK_S..=self.newest_s + AHEAD_S).contains(&at) {
            self.in_a_row = 0;
            self.newest_s = self.newest_s.max(at);
            return (at >= 0.0).then_some(at);
        }
        self.strange += 1;
        self.in_a_row += 1;
        if self.in_a_row < JUMP {
            return None;
        }
        self.in_a_row = 0;
        if self.jumps.len() < 100 {
            self.jumps.push(self.newest_s);
        }
        self.zero_s = Some(stamp_s - self.newest_s);
        Some(self.newest_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(time: &mut Timeline, stamp_s: f64) -> Option<f64> {
        time.at(&Header::at(stamp_s))
    }

    #[test]
    fn the_first_stamp_is_zero_and_one_wild_stamp_changes_nothing() {
        let mut time = Timeline::default();
        assert_eq!(at(&mut time, 100.0), Some(0.0));
        assert_eq!(at(&mut time, 1e9), None);
        assert_eq!(at(&mut time, 101.5), Some(1.5));
        assert_eq!(at(&mut time, 101.0), Some(1.0));
        assert_eq!((time.strange, time.newest_s), (1, 1.5));
    }

    #[test]
    fn a_second_print_in_the_same_bag_follows_the_first() {
        let mut time = Timeline::default();
        for step in 0..100 {
            at(&mut time, f64::from(step));
        }
        let after: Vec<_> = (0..100).map(|step| at(&mut time, f64::from(step) * 0.1)).collect();
        assert_eq!(after.iter().flatten().count(), 51);
        assert_eq!(time.jumps, [99.0]);
        assert!(time.newest_s < 110.0);
    }
}
