//! Outputs of two runs beside each other.

use super::events::{ALONE_MAX, Alone, unplaced};
use super::fields::{Found, differences, is_round_off, value};
use super::schedule::{seconds, stamp_ns};
use runtime::topics;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// Stamps that differ by less belong together `[ns]`: half the shortest period of an output.
pub(super) const TOGETHER_NS: u64 = 9_000_000;
/// Where the stamp lies in a message `[byte]`.
const STAMP: std::ops::Range<usize> = 4..12;

/// What two runs say on a topic.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Output {
    pub(crate) topic: &'static str,
    /// Messages before and after.
    pub(crate) before: u64,
    pub(crate) after: u64,
    /// Pairs of one stamp.
    pub(crate) matched: u64,
    /// Pairs that are the same, byte by byte.
    pub(crate) identical: u64,
    /// SHA-256 of all messages after.
    pub(crate) sha256: String,
    /// The first that is more than round-off.
    pub(crate) first_difference: Option<Difference>,
    /// Fields that differ anywhere.
    pub(crate) fields: BTreeMap<String, Field>,
    /// Events that only one run has, the first of them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) alone: Vec<Alone>,
}

/// Where two runs part.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Difference {
    pub(crate) stamp_s: f64,
    pub(crate) field: String,
    pub(crate) before: Value,
    pub(crate) after: Value,
}

/// How far a field differs over all pairs.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub(crate) struct Field {
    /// Root of the mean square over pairs.
    pub(crate) rms: f64,
    pub(crate) max: f64,
    /// Pairs in which it differs.
    pub(crate) differing: u64,
    #[serde(skip)]
    squares: f64,
}

impl Output {
    /// Whether both runs say the same, to the last bit.
    pub(crate) fn is_identical(&self) -> bool {
        self.before == self.after && self.identical == self.before
    }
}

/// Outputs of brains that are looked at.
pub(crate) const SAID: [&str; 10] = [
    topics::ESTIMATE.name(),
    topics::CONTROL_COMMAND.name(),
    topics::SAFETY_COMMAND.name(),
    topics::CONTROL_SCHEDULE.name(),
    topics::SAFETY_SCHEDULE.name(),
    topics::EVENTS.name(),
    topics::ADVANCE_PREDICTION.name(),
    topics::DEFECTS.name(),
    topics::BEAD_WIDTH.name(),
    topics::LAYER_QUALITY.name(),
];

/// Compares two runs on a topic; `exact` counts a stamp as part of the message.
pub(crate) fn compare(topic: &'static str, before: &[&[u8]], after: &[&[u8]], exact: bool) -> Output {
    let mut output = Output {
        topic,
        before: before.len() as u64,
        after: after.len() as u64,
        matched: 0,
        identical: 0,
        sha256: runtime::params::sha256_hex(&after.concat()),
        first_difference: None,
        fields: BTreeMap::new(),
        alone: Vec::new(),
    };
    let (mut one, mut other) = (0, 0);
    while let (Some(left), Some(right)) = (before.get(one), after.get(other)) {
        let (left_ns, right_ns) = (stamp_ns(left).unwrap_or(0), stamp_ns(right).unwrap_or(0));
        if left_ns.abs_diff(right_ns) <= TOGETHER_NS {
            output.pair(left, right, exact);
            (one, other) = (one + 1, other + 1);
        } else if left_ns < right_ns {
            output.alone(left, true);
            one += 1;
        } else {
            output.alone(right, false);
            other += 1;
        }
    }
    before.iter().skip(one).for_each(|left| output.alone(left, true));
    after.iter().skip(other).for_each(|right| output.alone(right, false));
    for field in output.fields.values_mut() {
        #[allow(clippy::cast_precision_loss, reason = "counts of a print are far below 2^52")]
        let pairs = output.matched as f64;
        field.rms = (field.squares / pairs).sqrt();
    }
    output
}

impl Output {
    /// A message that only one run has.
    fn alone(&mut self, payload: &[u8], before: bool) {
        if self.topic == topics::EVENTS.name() && self.alone.len() < ALONE_MAX {
            self.alone.extend(Alone::of(payload, before));
        }
        self.first_difference.get_or_insert_with(|| Difference {
            stamp_s: seconds(stamp_ns(payload).unwrap_or(0)).0,
            field: "a message".to_owned(),
            before: Value::Bool(before),
            after: Value::Bool(!before),
        });
    }

    fn pair(&mut self, left: &[u8], right: &[u8], exact: bool) {
        self.matched += 1;
        let without = |bytes: &[u8]| {
            [&bytes[..STAMP.start.min(bytes.len())], bytes.get(STAMP.end..).unwrap_or_default()].concat()
        };
        let (left, right) = (unplaced(self.topic, left), unplaced(self.topic, right));
        let (left, right) = (left.as_ref(), right.as_ref());
        if left == right || (!exact && without(left) == without(right)) {
            self.identical += 1;
            return;
        }
        let (Some(left_value), Some(right_value)) = (value(self.topic, left), value(self.topic, right))
        else {
            return self.alone(left, true);
        };
        let mut differing = BTreeMap::new();
        differences("", &left_value, &right_value, &mut differing);
        for (name, Found { size, values }) in differing {
            let field = self.fields.entry(name.clone()).or_default();
            field.differing += 1;
            field.squares += size * size;
            field.max = field.max.max(size);
            if is_round_off(&values) {
                continue;
            }
            self.first_difference.get_or_insert_with(|| Difference {
                stamp_s: seconds(stamp_ns(left).unwrap_or(0)).0,
                field: name,
                before: values.0,
                after: values.1,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::brains::encode;
    use super::*;
    use fdm_loop_msgs::{ControlCommand, Header};

    fn command(at_s: f64, flow_factor: f64) -> Vec<u8> {
        let header = Header::at(at_s);
        encode(&ControlCommand { header, flow_factor, ..ControlCommand::default() }).unwrap()
    }

    fn compared(before: &[Vec<u8>], after: &[Vec<u8>], exact: bool) -> Output {
        let slices = |all: &[Vec<u8>]| all.iter().map(|one| one.clone().leak() as &[u8]).collect::<Vec<_>>();
        compare(topics::CONTROL_COMMAND.name(), &slices(before), &slices(after), exact)
    }

    /// Four pairs of which one differs by 0.2: root of 0.04 / 4.
    #[test]
    fn a_difference_is_told_with_place_size_and_first_instant() {
        let before = [1.0, 1.0, 1.0, 1.0].iter().zip(1_u8..).map(|(flow, at)| command(f64::from(at), *flow));
        let before: Vec<_> = before.collect();
        let mut after = before.clone();
        after[2] = command(3.0, 1.2);
        let output = compared(&before, &after, true);
        assert_eq!((output.matched, output.identical, output.is_identical()), (4, 3, false));
        let field = output.fields["flow_factor"];
        assert!((field.rms - 0.1).abs() < 1e-12 && (field.max - 0.2).abs() < 1e-12, "{field:?}");
        let first = output.first_difference.unwrap();
        assert_eq!((first.field.as_str(), first.stamp_s.to_bits()), ("flow_factor", 3.0_f64.to_bits()));
    }

    /// A bit of the first pair differs, and 20 % of the third: the latter is where the runs part, both are counted.
    #[test]
    fn the_first_difference_is_more_than_round_off() {
        let before: Vec<_> = [1.0, 2.0, 3.0].map(|at| command(at, 1.0)).into();
        let bit = command(1.0, 1.0 + f64::EPSILON);
        let parted = compared(&before, &[bit.clone(), before[1].clone(), command(3.0, 1.2)], true);
        assert_eq!(parted.first_difference.unwrap().stamp_s.to_bits(), 3.0_f64.to_bits());
        assert_eq!(parted.fields["flow_factor"].differing, 2);
        let rounded = compared(&before, &[bit, before[1].clone(), before[2].clone()], true);
        assert!(rounded.first_difference.is_none() && !rounded.is_identical());
    }

    #[test]
    fn what_one_run_lacks_is_told_and_not_paired_with_its_neighbour() {
        let before: Vec<_> = [1.0, 1.02, 1.04].map(|at| command(at, 1.0)).into();
        let output = compared(&before, &[before[0].clone(), before[2].clone()], true);
        assert_eq!((output.before, output.after, output.matched, output.identical), (3, 2, 2, 2));
        assert_eq!(output.first_difference.unwrap().field, "a message");
    }

    #[test]
    fn a_stamp_counts_only_where_both_runs_share_a_clock() {
        let (before, after) = ([command(1.0, 1.0)], [command(1.001, 1.0)]);
        assert!(!compared(&before, &after, true).is_identical());
        assert!(compared(&before, &after, false).is_identical());
    }
}
