//! Whether the supervisor is heard: without it the printer goes on at the slicer's own values, and nobody is told of it.

use models::units::Seconds;

/// Silence that is told `[s]` of real time, and of the printer's own: twice the period of `safety/state`, which runs on the
/// printer's clock. Beside `--speed 0.1`, or on a host that does not keep up, a real second is no silence.
const SILENT_S: f64 = 1.0;

/// What to tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Change {
    /// It is not heard any more.
    Lost,
    /// It is heard again.
    Back,
}

impl Change {
    /// For people.
    pub(super) fn text(self) -> &'static str {
        match self {
            Self::Lost => {
                "safety_supervisor is silent or not active: the printer is at the slicer's own values, nobody watches the \
                 heaters; `fdm estop` still works"
            }
            Self::Back => "safety_supervisor watches the printer again",
        }
    }
}

/// When it was heard last.
#[derive(Debug, Default)]
pub(super) struct Guard {
    /// Real time, and the printer's.
    heard: Option<(Seconds, f64)>,
    lost: bool,
    /// What a person told the printer itself while it did not answer.
    pub(super) past: Option<String>,
}

impl Guard {
    /// Its state came in, or it did not: `printer_s` is the printer's own time.
    pub(super) fn look(&mut self, now: Seconds, printer_s: f64, came: bool) -> Option<Change> {
        let (heard, printer_then_s) = *self.heard.get_or_insert((now, printer_s));
        if came {
            self.heard = Some((now, printer_s));
            return std::mem::replace(&mut self.lost, false).then_some(Change::Back);
        }
        let silent = (now - heard).0 > SILENT_S && printer_s - printer_then_s > SILENT_S;
        if silent && !self.lost {
            self.lost = true;
            return Some(Change::Lost);
        }
        None
    }

    /// Whether nobody watches the printer.
    pub(super) fn is_lost(&self) -> bool {
        self.lost
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_silent_supervisor_is_told_once_and_told_again_when_it_is_back() {
        let mut guard = Guard::default();
        assert_eq!(guard.look(Seconds(5.0), 100.0, false), None, "it may come yet");
        assert_eq!(guard.look(Seconds(5.4), 100.4, true), None);
        assert_eq!(guard.look(Seconds(6.4), 101.4, false), None);
        assert_eq!(guard.look(Seconds(6.45), 101.45, false), Some(Change::Lost));
        assert!(guard.is_lost());
        assert_eq!(guard.look(Seconds(9.0), 104.0, false), None);
        assert_eq!(guard.look(Seconds(9.1), 104.1, true), Some(Change::Back));
        assert!(!guard.is_lost());
        assert_eq!(guard.look(Seconds(20.0), 115.0, false), Some(Change::Lost));
    }

    /// One that has never been heard watches nothing either.
    #[test]
    fn a_supervisor_that_never_came_is_told_too() {
        let mut guard = Guard::default();
        assert_eq!(guard.look(Seconds(5.0), 0.0, false), None);
        assert_eq!(guard.look(Seconds(6.1), 1.1, false), Some(Change::Lost));
    }

    /// Its state comes twice a second of the printer's time.
    #[test]
    fn a_slow_or_a_fast_printer_is_no_silence() {
        let mut guard = Guard::default();
        guard.look(Seconds(0.0), 0.0, true);
        assert_eq!(guard.look(Seconds(5.0), 0.5, false), None, "--speed 0.1");
        guard.look(Seconds(5.0), 0.5, true);
        assert_eq!(guard.look(Seconds(5.5), 10.5, false), None, "--speed 20");
    }
}
