//! Events of two runs beside each other: whose they are, and what they say.

use super::brains::encode;
use super::schedule::{seconds, stamp_ns};
use crate::report::decode::decode;
use fdm_loop_msgs::PrintEvent;
use runtime::topics;
use serde::Serialize;
use std::borrow::Cow;

/// Events that only one run has, as many as are told.
pub(super) const ALONE_MAX: usize = 10;

/// An event that only one run has.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Alone {
    pub(crate) stamp_s: f64,
    /// The run before has it, or the one after.
    pub(crate) before: bool,
    pub(crate) text: String,
}

impl Alone {
    pub(super) fn of(payload: &[u8], before: bool) -> Option<Self> {
        let event = decode::<PrintEvent>(payload)?;
        Some(Self {
            stamp_s: seconds(stamp_ns(payload).unwrap_or(0)).0,
            before,
            text: format!("{} {}: {}", base(&event.who), event.what, event.why),
        })
    }
}

/// An event whose node has no namespace, as a replay has it; all else as it is.
pub(super) fn unplaced<'a>(topic: &str, payload: &'a [u8]) -> Cow<'a, [u8]> {
    let event = if topic == topics::EVENTS.name() { decode::<PrintEvent>(payload) } else { None };
    let placed = event.filter(|event| event.who.starts_with('/'));
    let encoded = placed.and_then(|event| encode(&PrintEvent { who: base(&event.who).to_owned(), ..event }));
    encoded.map_or(Cow::Borrowed(payload), Cow::Owned)
}

/// A node's name without its namespace.
fn base(who: &str) -> &str {
    who.rsplit('/').next().unwrap_or(who)
}

#[cfg(test)]
mod tests {
    use super::super::compare::compare;
    use super::*;
    use fdm_loop_msgs::Header;

    /// A supervisor of `fdm up` has a namespace, and one of a replay none; another node is another node. What only one says
    /// is told in its words.
    #[test]
    fn events_are_compared_without_their_namespace_and_told_where_one_run_lacks_them() {
        let event = |at_s: f64, who: &str, what: &str| {
            let header = Header::at(at_s);
            let (who, what, why) = (who.to_owned(), what.to_owned(), "S1".to_owned());
            encode(&PrintEvent { header, who, what, why, ..PrintEvent::default() }).unwrap()
        };
        let both = |before: &[Vec<u8>], after: &[Vec<u8>]| {
            let slices =
                |all: &[Vec<u8>]| all.iter().map(|one| one.clone().leak() as &[u8]).collect::<Vec<_>>();
            compare(topics::EVENTS.name(), &slices(before), &slices(after), true)
        };
        let recorded = [event(1.0, "/printer/safety_supervisor", "mode"), event(2.0, "/printer/a", "paused")];
        let same = both(&recorded[..1], &[event(1.0, "safety_supervisor", "mode")]);
        assert!(same.is_identical() && same.alone.is_empty(), "{same:?}");
        let other = both(&recorded[..1], &[event(1.0, "camera", "mode")]);
        assert!(!other.is_identical() && other.fields.contains_key("who"), "{other:?}");
        let fewer = both(&recorded, &[event(1.0, "safety_supervisor", "mode")]);
        let told = Alone { stamp_s: 2.0, before: true, text: "a paused: S1".to_owned() };
        assert_eq!(fewer.alone, [told]);
    }
}
