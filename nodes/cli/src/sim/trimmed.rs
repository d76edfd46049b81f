//! How much of a print is corrected by more than a little: in all, by feedback about the spool's calibration, and by plan.
//!
//! A trim in force is feedback but for the spool's calibration. What a move is planned at before it begins is none: it follows
//! from the move itself, whatever has been measured of the road since.

use models::command::Trims;

/// A trim of flow or speed beyond this is more than a little `[-]`.
const SMALL: f64 = 0.01;

/// Statuses of deposits, and those with a trim.
#[derive(Debug, Clone, Copy, Default)]
pub struct Trimmed {
    all: f64,
    trimmed: f64,
    fed_back: f64,
    slowed: f64,
}

/// Shares of the time of deposition `[-]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares {
    /// With any trim in force.
    pub trimmed: f64,
    /// With one of feedback.
    pub fed_back: f64,
    /// In moves that are planned slower than the file's.
    pub slowed: f64,
}

impl Trimmed {
    /// A status while a road is laid; the spool's section is `1 + base` of the nominal one, as far as it is calibrated, and
    /// the move is planned at `pace` of the file's speed.
    pub fn add(&mut self, trims: &Trims, base: f64, pace: f64) {
        let one = |is: bool| f64::from(u8::from(is));
        let beyond = |flow: f64| (flow - 1.0).abs() > SMALL || (trims.speed - 1.0).abs() > SMALL;
        self.all += 1.0;
        self.trimmed += one(beyond(trims.flow));
        // The slicer's own values correct nothing, whatever is known of the spool.
        let corrects = (trims.flow, trims.speed) != (1.0, 1.0);
        self.fed_back += one(corrects && beyond(trims.flow * (1.0 + base)));
        self.slowed += one((pace - 1.0).abs() > SMALL);
    }

    /// Shares so far; `None` where nothing was laid.
    #[must_use]
    pub fn shares(&self) -> Option<Shares> {
        (self.all > 0.0).then(|| Shares {
            trimmed: self.trimmed / self.all,
            fed_back: self.fed_back / self.all,
            slowed: self.slowed / self.all,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In observe the spool is calibrated, 4 % too thick, and the slicer's own values are printed.
    #[test]
    fn what_is_not_in_force_is_no_feedback() {
        let mut trimmed = Trimmed::default();
        trimmed.add(&Trims::NEUTRAL, 0.04, 1.0);
        assert_eq!(trimmed.shares(), Some(Shares { trimmed: 0.0, fed_back: 0.0, slowed: 0.0 }));
    }

    /// A spool 4 % too thick, fed 4 % less: no feedback. A move planned slower is none either, a speed trim is.
    #[test]
    fn calibration_and_plan_are_no_feedback() {
        let mut trimmed = Trimmed::default();
        assert_eq!(trimmed.shares(), None);
        for (flow, speed, pace) in
            [(1.0, 1.0, 1.0), (1.0 / 1.04, 1.0, 1.0), (1.0 / 1.04, 1.0, 0.9), (1.0 / 1.04, 0.98, 0.9)]
        {
            let base = if flow < 1.0 { 0.04 } else { 0.0 };
            trimmed.add(&Trims { flow, speed, ..Trims::NEUTRAL }, base, pace);
        }
        assert_eq!(trimmed.shares(), Some(Shares { trimmed: 0.75, fed_back: 0.25, slowed: 0.5 }));
    }
}
