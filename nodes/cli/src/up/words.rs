//! Modes and happenings in words.

use super::fleet::Happening;

/// Name of a mode for people.
#[must_use]
pub fn mode_name(mode: u8) -> &'static str {
    const NAMES: [&str; 8] = ["init", "observe", "advise", "act", "degraded", "paused", "safe_off", "estop"];
    NAMES.get(usize::from(mode)).copied().unwrap_or("unknown")
}

/// Name of a job's phase for people.
#[must_use]
pub fn phase_name(phase: u8) -> &'static str {
    const NAMES: [&str; 6] = ["idle", "preparing", "printing", "paused", "done", "failed"];
    NAMES.get(usize::from(phase)).copied().unwrap_or("unknown")
}

/// A happening for people.
#[must_use]
pub fn text(happening: &Happening) -> String {
    match happening {
        Happening::Ended { name, how } => format!("{name} ended ({how}); it is started again"),
        Happening::Restarted { name, pid } => format!("{name} runs again as process {pid}"),
        Happening::GivenUp { name } => format!("{name} ended and stays down: see its log"),
        Happening::Silent { name } => format!("{name} is silent: its heart stands still"),
        Happening::HeardAgain { name } => format!("{name} is heard again"),
    }
}
