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

/// What to do about a stop that ends the graph: its latch ends with it, and nobody is left to acknowledge to.
#[must_use]
pub fn at_the_end(text: &str) -> String {
    const NEXT: &str = "start the next print";
    const WORDS: [(&str, &str); 4] = [
        ("`fdm acknowledge`, then start the next job", NEXT),
        ("`fdm acknowledge`, then start the job again", NEXT),
        ("`fdm acknowledge` where the heaters are off", NEXT),
        ("`fdm acknowledge`", NEXT),
    ];
    let said = WORDS.iter().fold(text.to_owned(), |text, (word, then)| text.replace(word, then));
    // Nothing is left of a pause either.
    said.replace("then `fdm resume` where it has paused, ", "then ")
}

/// A happening for people.
#[must_use]
pub fn text(happening: &Happening) -> String {
    match happening {
        Happening::Ended { name, how } => format!("{name} ended ({how}); it is started again"),
        Happening::Restarted { name, pid } => format!("{name} runs again as process {pid}"),
        Happening::GivenUp { name } => format!("{name} ended and stays down: see its log"),
        Happening::KeepsEnding { name, how } => {
            format!(
                "{name} keeps ending ({how}): it is tried again every 2 s, after a minute every 10 s, see its log"
            )
        }
        Happening::EndedAgain { name } => format!("{name} ended again"),
        Happening::Silent { name } => format!("{name} is silent: its heart stands still"),
        Happening::Hung { name } => format!("{name} has been silent for 10 s: it is ended by force"),
        Happening::HeardAgain { name } => format!("{name} is heard again"),
    }
}

#[cfg(test)]
mod tests {
    use super::{at_the_end, todo};
    use safety_supervisor::Cause;

    /// A supervisor of this build names them itself, for whoever reads its topics, its events or a bag.
    #[test]
    fn what_this_supervisor_says_needs_no_command_added() {
        for cause in Cause::ALL {
            assert_eq!(todo(cause.what_to_do()), cause.what_to_do(), "{cause:?}");
        }
    }

    /// The graph has ended by the time somebody has read it.
    #[test]
    fn what_to_do_after_the_end_asks_nothing_of_a_graph_that_is_gone() {
        assert_eq!(
            at_the_end("make the printer safe, then `fdm acknowledge`"),
            "make the printer safe, then start the next print"
        );
        assert_eq!(at_the_end("`fdm acknowledge`, then start the next job"), "start the next print");
        for cause in Cause::ALL.iter().filter(|cause| cause.what_to_do().contains("`fdm acknowledge`")) {
            let said = at_the_end(cause.what_to_do());
            assert!(said.contains("start the next print") && !said.contains("`fdm "), "{cause:?}: {said}");
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
