//! How regularly the supervisor ticks, by its own count in `/diagnostics`: what is sent in between, in answer to a wish of the
//! controller or of a person, hides no late tick there.

use fdm_loop_msgs::DiagnosticStatus;
use runtime::TICKS_LATE_MS;
use std::collections::BTreeMap;

/// Milliseconds in a second.
const MS_PER_S: f64 = 1e3;

/// How many ticks were late, and by how many whole milliseconds.
type Counts = BTreeMap<u16, u64>;

/// Counts of one run of the supervisor since its first report.
#[derive(Debug, Default)]
pub(super) struct Jitter {
    first: Option<Counts>,
    newest: Counts,
}

impl Jitter {
    /// Takes in a status of the supervisor.
    pub(super) fn take(&mut self, status: &DiagnosticStatus) {
        let Some(counts) = status.values.iter().find(|value| value.key == TICKS_LATE_MS) else { return };
        let Some(counts) = counts_of(&counts.value) else { return };
        self.newest.clone_from(&counts);
        self.first.get_or_insert(counts);
    }

    /// How much later than usual each tick since the first report came, in whole milliseconds, rounded up `[s]`.
    pub(super) fn late(&self) -> Vec<f64> {
        let before = |late_ms| self.first.as_ref().and_then(|first| first.get(late_ms)).copied().unwrap_or(0);
        let since =
            self.newest.iter().map(|(late_ms, ticks)| (*late_ms, ticks.saturating_sub(before(late_ms))));
        since
            .flat_map(|(late_ms, ticks)| (0..ticks).map(move |_| (f64::from(late_ms) + 1.0) / MS_PER_S))
            .collect()
    }
}

/// What `/diagnostics` says, `0:498 1:2`, as counts.
fn counts_of(text: &str) -> Option<Counts> {
    let count = |pair: &str| {
        let (late_ms, ticks) = pair.split_once(':')?;
        Some((late_ms.parse().ok()?, ticks.parse().ok()?))
    };
    text.split_whitespace().map(count).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fdm_loop_msgs::KeyValue;

    fn told(counts: &[&str]) -> Vec<f64> {
        let mut jitter = Jitter::default();
        for counts in counts {
            let value = KeyValue { key: TICKS_LATE_MS.to_owned(), value: (*counts).to_owned() };
            jitter.take(&DiagnosticStatus { values: vec![value], ..DiagnosticStatus::default() });
        }
        jitter.late()
    }

    #[test]
    fn what_came_late_before_the_trial_is_not_counted() {
        assert_eq!(told(&["0:498 12:1", "0:500 3:1 12:2"]), [0.001, 0.001, 0.004, 0.013]);
        assert!(told(&["0:498 12:1"]).is_empty());
        assert_eq!(told(&["0:1", "1:x", "0:2", "ok"]), [0.001], "what cannot be read is left out");
    }
}
