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

/// What the supervisor says to do, with the commands that its words stand for.
#[must_use]
pub fn todo(text: &str) -> String {
    let said = |word: &&str| {
        let words = text.split(|letter: char| !letter.is_alphanumeric());
        words.clone().any(|said| said == *word) && !text.contains(&format!("fdm {word}"))
    };
    let commands: Vec<String> = ["acknowledge", "resume", "stop"]
        .iter()
        .filter(|word| said(word))
        .map(|word| format!("`fdm {word}`"))
        .collect();
    if commands.is_empty() { text.to_owned() } else { format!("{text} ({})", commands.join(", ")) }
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

#[cfg(test)]
mod tests {
    use super::todo;

    /// Who reads "acknowledge" cannot know that it is a command, and whose.
    #[test]
    fn what_to_do_names_its_commands() {
        assert_eq!(
            todo("look at the print, then resume or stop"),
            "look at the print, then resume or stop (`fdm resume`, `fdm stop`)"
        );
        assert_eq!(
            todo("check the plug, then acknowledge"),
            "check the plug, then acknowledge (`fdm acknowledge`)"
        );
        for plain in ["check the plug, then `fdm acknowledge`", "the print has stopped", "see the log", ""] {
            assert_eq!(todo(plain), plain);
        }
    }
}
