//! One line of Marlin: what it says, without regard to what was said before.

mod fields;
#[cfg(test)]
mod tests;

pub use fields::Temperatures;

/// Longest line `[bytes]`: the answer to M115 has some 300, a longer one is no line of Marlin.
pub const LINE_MAX: usize = 512;

/// Words of errors after which Marlin has stopped itself and answers nothing before it is started anew.
const FATAL: [&str; 8] =
    ["halted", "kill()", "stopped", "thermal runaway", "heating failed", "mintemp", "maxtemp", "fatal"];

/// A line.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// It begins with `ok`: the firmware takes the next line.
    pub ok: bool,
    /// What else it says.
    pub says: Says,
}

/// What a line says beside `ok`.
#[derive(Debug, Clone, PartialEq)]
pub enum Says {
    /// Nothing.
    Nothing,
    /// Temperatures, targets, duties.
    Temperatures(Temperatures),
    /// Tool position `[m]`, the answer to M114.
    Position([f64; 3]),
    /// `busy:` the firmware lives and takes no line.
    Busy,
    /// `wait`: nothing is to do; every question has been answered or lost.
    Wait,
    /// The firmware has started.
    Start,
    /// An error.
    Error {
        /// The firmware has stopped itself.
        fatal: bool,
        /// Its words.
        text: String,
    },
    /// A demand or a note for hosts.
    Action(Action),
    /// Name of the firmware, from M115.
    Firmware(String),
    /// A capability, from M115.
    Capability {
        /// As Marlin names it.
        name: String,
        /// Whether it is there.
        on: bool,
    },
    /// The firmware wants a line again.
    Resend,
    /// The print from the card.
    Card(Card),
    /// A command that this firmware does not know, as it was sent.
    UnknownCommand(String),
    /// Something else: an echo, a greeting.
    Other,
}

/// Host actions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Action {
    /// The job pauses.
    Pause,
    /// The job goes on.
    Resume,
    /// The job is given up.
    Cancel,
    /// The run-out switch sees no filament.
    OutOfFilament,
    /// Prompts, notifications and what else there is.
    Other,
}

/// The print from the card.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Card {
    /// Printing.
    Printing {
        /// Bytes read.
        done: u64,
        /// Bytes of the file.
        total: u64,
    },
    /// Not printing; some firmwares say so in a pause too.
    NotPrinting,
    /// The file has ended.
    Done,
}

/// Why a line is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LineError {
    /// Bytes that are no text.
    NotText,
    /// A number that is none.
    NotNumber,
}

/// Reads one line.
///
/// # Errors
/// [`LineError`]; both kinds are to be counted.
pub fn parse(line: &[u8]) -> Result<Line, LineError> {
    let text = std::str::from_utf8(line).map_err(|_| LineError::NotText)?.trim();
    let ok = text.strip_prefix("ok").filter(|rest| rest.is_empty() || rest.starts_with(' '));
    Ok(match ok {
        Some(rest) => Line { ok: true, says: after_ok(rest.trim())? },
        None => Line { ok: false, says: alone(text)? },
    })
}

/// What may stand in the line of an `ok`. (`ok N5 P15 B3` numbers the line and the room in the buffers.)
fn after_ok(text: &str) -> Result<Says, LineError> {
    let says = values(text)?;
    Ok(if says == Says::Other && text.is_empty() { Says::Nothing } else { says })
}

fn alone(text: &str) -> Result<Says, LineError> {
    if let Some(action) = text.strip_prefix("//") {
        return Ok(action
            .trim_start()
            .strip_prefix("action:")
            .map_or(Says::Other, |action| host(action.trim())));
    }
    for (mark, fatal) in [("Error:", false), ("error:", false), ("fatal:", true), ("!!", true)] {
        if let Some(error) = text.strip_prefix(mark) {
            let words = error.to_ascii_lowercase();
            let fatal = fatal || FATAL.iter().any(|word| words.contains(word));
            return Ok(Says::Error { fatal, text: error.trim().to_owned() });
        }
    }
    let echo = text.strip_prefix("echo:").map(str::trim_start);
    if echo.unwrap_or(text).starts_with("busy:") {
        return Ok(Says::Busy);
    }
    if let Some(echo) = echo {
        let unknown = echo.strip_prefix("Unknown command:");
        return Ok(unknown
            .map_or(Says::Other, |sent| Says::UnknownCommand(sent.trim().trim_matches('"').to_owned())));
    }
    match text {
        "wait" => return Ok(Says::Wait),
        "start" => return Ok(Says::Start),
        "Not SD printing" => return Ok(Says::Card(Card::NotPrinting)),
        "Done printing file" => return Ok(Says::Card(Card::Done)),
        _ => {}
    }
    if text.starts_with("Resend:") || text.starts_with("rs ") {
        return Ok(Says::Resend);
    }
    if let Some(bytes) = text.strip_prefix("SD printing byte") {
        return fields::bytes(bytes).map(Says::Card);
    }
    values(text)
}

/// Lines of values.
fn values(text: &str) -> Result<Says, LineError> {
    if let Some(capability) = text.strip_prefix("Cap:") {
        return fields::capability(capability);
    }
    if text.contains("FIRMWARE_NAME:") {
        return Ok(Says::Firmware(fields::firmware_name(text)));
    }
    if let Some(position) = fields::position(text)? {
        return Ok(Says::Position(position));
    }
    Ok(fields::temperatures(text)?.map_or(Says::Other, Says::Temperatures))
}

/// A host action; its words after the first are for people.
fn host(action: &str) -> Says {
    Says::Action(match action.split_ascii_whitespace().next().unwrap_or_default() {
        "pause" | "paused" => Action::Pause,
        "resume" | "resumed" => Action::Resume,
        "cancel" => Action::Cancel,
        "out_of_filament" | "filament_runout" => Action::OutOfFilament,
        _ => Action::Other,
    })
}
