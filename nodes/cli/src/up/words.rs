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

/// What a supervisor or a bag says to do, with the commands that bare words of former builds stand for. Who is to stop
/// one of two controllers is not to stop the print.
#[must_use]
pub fn todo(text: &str) -> String {
    const WORDS: [(&str, [&str; 2]); 3] = [
        ("acknowledge", ["acknowledge", "acknowledge"]),
        ("resume", ["resume", "resume"]),
        ("stop", ["or stop", "stop and print"]),
    ];
    let words: Vec<&str> = text.split(|letter: char| !letter.is_alphanumeric()).collect();
    let said = |word: &str, phrases: [&str; 2]| {
        words.contains(&word)
            && phrases.iter().any(|phrase| text.contains(phrase))
            && !text.contains(&format!("fdm {word}"))
    };
    let commands: Vec<String> = WORDS
        .into_iter()
        .filter(|(word, phrases)| said(word, *phrases))
        .map(|(word, _)| format!("`fdm {word}`"))
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
    use safety_supervisor::Cause;

    /// A supervisor of this build names them itself, for whoever reads its topics, its events or a bag.
    #[test]
    fn what_this_supervisor_says_needs_no_command_added() {
        for cause in Cause::ALL {
            assert_eq!(todo(cause.what_to_do()), cause.what_to_do(), "{cause:?}");
        }
    }

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
        assert_eq!(
            todo("stop and print anew: the lost steps are not made up for"),
            "stop and print anew: the lost steps are not made up for (`fdm stop`)"
        );
        for plain in [
            "check the plug, then `fdm acknowledge`",
            "the print has stopped",
            "stop one of the controllers",
            "see the log",
            "",
        ] {
            assert_eq!(todo(plain), plain);
        }
    }
}
