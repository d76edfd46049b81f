//! What a person sees of a recorder that runs: a line that moves on a terminal, a line now and then elsewhere.

use super::watched::Watched;
use crate::output;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::path::Path;
use std::time::{Duration, Instant};

/// Between two looks at the bag.
pub(super) const LOOK: Duration = Duration::from_secs(1);
/// Pace of the progress where no terminal shows it.
const TELL: Duration = Duration::from_secs(10);
/// Silence after which a person is told of it.
const SILENCE: Duration = Duration::from_secs(5);

/// A recorder as a person sees it.
pub(super) struct Shown<'a> {
    pub(super) bag: &'a Path,
    /// Whose topics are recorded.
    namespace: &'a str,
    /// Nothing is to be written yet.
    paused: bool,
    begun: Instant,
    told: Instant,
    warned: bool,
    bar: ProgressBar,
    watched: Watched,
}

impl<'a> Shown<'a> {
    /// Tells where the bag goes.
    pub(super) fn begin(bag: &'a Path, namespace: &'a str, paused: bool) -> Self {
        output::note(&format!("recording {namespace} to {} until Ctrl-C", bag.display()));
        let bar = ProgressBar::new_spinner();
        if let Ok(style) = ProgressStyle::with_template("{msg}") {
            bar.set_style(style);
        }
        let begun = Instant::now();
        Self { bag, namespace, paused, begun, told: begun, warned: false, bar, watched: Watched::default() }
    }

    /// Looks at the bag, and tells what there is to tell.
    pub(super) fn look(&mut self) {
        self.watched.look(self.bag);
        if !self.warned && !self.paused && self.watched.others == 0 && self.begun.elapsed() >= SILENCE {
            self.warned = true;
            self.bar.suspend(|| output::note(&silence(self.namespace)));
        }
        let so_far = self.so_far();
        if !std::io::stderr().is_terminal() && self.told.elapsed() >= TELL {
            self.told = Instant::now();
            output::note(&so_far);
        }
        self.bar.set_message(so_far);
    }

    /// The total.
    pub(super) fn end(&mut self) -> anyhow::Result<()> {
        self.watched.look(self.bag);
        self.bar.finish_and_clear();
        output::line(&format!("{}: {}", self.bag.display(), self.so_far()))
    }

    fn so_far(&self) -> String {
        so_far(self.watched.messages, self.begun.elapsed(), self.watched.bytes())
    }
}

fn so_far(messages: u64, lasted: Duration, bytes: u64) -> String {
    #[allow(clippy::cast_precision_loss, reason = "a size for people")]
    let mib = bytes as f64 / f64::from(1 << 20);
    format!("{messages} messages, {:.0} s, {mib:.1} MiB", lasted.as_secs_f64())
}

fn silence(namespace: &str) -> String {
    format!(
        "nothing of {namespace} was heard in {} s: is its graph running, with the same ROS_DOMAIN_ID and --namespace? The \
         recorder goes on listening",
        SILENCE.as_secs()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_person_is_told_how_much_and_what_to_look_at() {
        assert_eq!(so_far(1200, Duration::from_millis(12_300), 3 << 19), "1200 messages, 12 s, 1.5 MiB");
        assert!(
            silence("/left").starts_with("nothing of /left was heard in 5 s: is its graph running, with ")
        );
    }
}
