//! When each brain hears what, and when its timer is due.
//!
//! A record of `fdm sim --bag` has the brains' own clock: timers are due at their periods. In a record of processes the
//! estimates and permits tell when the timers were due; the controller's own timer leaves no trace, and has its period
//! from the first message on. At one instant messages come first, then the estimator's timer, what was recorded of it,
//! the controller's and the supervisor's timer.

use super::brains::{Brains, Feeds};
use super::record::{Kept, Record};
use super::settings::Settings;
use crate::report::decode::decode;
use fdm_loop_msgs::{BeadWidth, PrintEvent, Time};
use models::command::Mode;
use models::units::Seconds;
use runtime::topics;
use safety_supervisor::Operator;
use std::collections::BTreeMap;

/// What happens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Happening {
    /// A message of the part by its number.
    Hear(usize),
    Estimate,
    /// An estimate or a command of this record.
    HearSaid(usize),
    Plan,
    Permit,
    /// What a person asked, by its number.
    Ask(usize),
}

impl Happening {
    /// Place among what happens at one instant.
    fn rank(self) -> u8 {
        match self {
            Self::Hear(_) => 0,
            Self::Estimate => 1,
            Self::HearSaid(_) => 2,
            Self::Plan => 3,
            Self::Permit | Self::Ask(_) => 4,
        }
    }
}

/// Whose timers follow the record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Timers {
    /// The estimator's are at the stamps of the recorded estimates.
    pub(crate) estimates: bool,
    /// The supervisor's are at the stamps of the recorded permits.
    pub(crate) permits: bool,
}

/// The order of one part of a record.
pub(crate) struct Schedule<'a> {
    part: &'a [Kept],
    happenings: Vec<(u64, Happening)>,
    asked: Vec<Operator>,
    /// The newest permit of a tick `[ns]`.
    ticked_ns: Option<u64>,
}

/// A permit so soon after a tick's is none of a tick `[ns]`: half of [`topics::PERMIT_PERIOD`].
const ANSWERS_NS: u64 = 10_000_000;

/// A time on the brains' clock as a stamp of it reads.
pub(crate) fn seconds(ns: u64) -> Seconds {
    let stamp = Time {
        sec: i32::try_from(ns / 1_000_000_000).unwrap_or(i32::MAX),
        nanosec: u32::try_from(ns % 1_000_000_000).unwrap_or(0),
    };
    Seconds(stamp.seconds().unwrap_or(0.0))
}

/// Stamp of a message's header `[ns]`: the first field of every type that brains say.
pub(crate) fn stamp_ns(payload: &[u8]) -> Option<u64> {
    let sec = i32::from_le_bytes(payload.get(4..8)?.try_into().ok()?);
    let nanos = u32::from_le_bytes(payload.get(8..12)?.try_into().ok()?);
    Some(u64::try_from(sec).ok()? * 1_000_000_000 + u64::from(nanos))
}

impl<'a> Schedule<'a> {
    /// Orders a part.
    pub(crate) fn new(
        record: &Record,
        part: &'a [Kept],
        settings: &Settings,
        (feeds, timers): (Feeds, Timers),
    ) -> Self {
        let mut schedule = Self { part, happenings: Vec::new(), asked: Vec::new(), ticked_ns: None };
        let requests = requests(part);
        for (number, kept) in part.iter().enumerate() {
            schedule.place(number, kept, (feeds, timers), &requests);
        }
        let (begin_ns, end_ns) =
            (part.first().map_or(0, |kept| kept.log_ns), part.last().map_or(0, |kept| kept.log_ns));
        let begin_ns = if record.is_virtual() { 0 } else { begin_ns };
        let mut timer = |period_s: f64, happening| {
            let due = Timer { begin_ns, end_ns, period_s, step: record.is_virtual() };
            schedule.happenings.extend(due.map(|ns| (ns, happening)));
        };
        if !timers.estimates {
            timer(settings.estimator.period_s, Happening::Estimate);
        }
        timer(settings.controller.period_s, Happening::Plan);
        if !timers.permits {
            timer(topics::PERMIT_PERIOD.0, Happening::Permit);
        }
        schedule.happenings.sort_by_key(|(ns, happening)| (*ns, happening.rank()));
        schedule
    }

    fn place(
        &mut self,
        number: usize,
        kept: &Kept,
        (feeds, timers): (Feeds, Timers),
        requests: &BTreeMap<u64, Vec<Operator>>,
    ) {
        let stamp_ns = stamp_ns(&kept.payload).unwrap_or(kept.log_ns);
        // These are said as soon as what they answer is heard, estimates and commands by a timer.
        let heard = |own: bool| (!own).then_some((kept.log_ns, Happening::Hear(number)));
        let said = |own: bool| (!own).then_some((kept.log_ns, Happening::HearSaid(number)));
        let happening = match kept.topic {
            name if name == topics::ESTIMATE.name() => {
                if timers.estimates {
                    self.happenings.push((stamp_ns, Happening::Estimate));
                }
                said(feeds.estimate)
            }
            name if name == topics::SAFETY_COMMAND.name() => {
                for request in requests.get(&stamp_ns).into_iter().flatten() {
                    self.happenings.push((stamp_ns, Happening::Ask(self.asked.len())));
                    self.asked.push(*request);
                }
                if timers.permits && !requests.contains_key(&stamp_ns) && self.is_of_tick(stamp_ns) {
                    self.happenings.push((stamp_ns, Happening::Permit));
                }
                None
            }
            name if name == topics::CONTROL_COMMAND.name() => said(feeds.command),
            name if name == topics::CONTROL_SCHEDULE.name() => heard(feeds.command),
            name if name == topics::SAFETY_SCHEDULE.name() => None,
            name if name == topics::ADVANCE_PREDICTION.name() => heard(feeds.prediction),
            name if name == topics::DEFECTS.name() => heard(feeds.vision),
            name if name == topics::BEAD_WIDTH.name() => heard(feeds.vision && is_of_camera(&kept.payload)),
            name if name == topics::EVENTS.name() || name == topics::LAYER_QUALITY.name() => None,
            _ => heard(false),
        };
        self.happenings.extend(happening);
    }

    /// Whether a permit is of a tick. One that answers a command follows soon, mostly at the same simulated time.
    fn is_of_tick(&mut self, stamp_ns: u64) -> bool {
        let answers = self.ticked_ns.is_some_and(|ticked_ns| stamp_ns < ticked_ns + ANSWERS_NS);
        if !answers {
            self.ticked_ns = Some(stamp_ns);
        }
        !answers
    }

    /// Lets the brains live through the part.
    pub(crate) fn run(&self, brains: &mut Brains<'_>) {
        for (ns, happening) in &self.happenings {
            let now = seconds(*ns);
            match happening {
                Happening::Hear(number) | Happening::HearSaid(number) => {
                    let kept = &self.part[*number];
                    brains.hear(now, kept.topic, &kept.payload);
                }
                Happening::Estimate => brains.estimate(now),
                Happening::Plan => brains.plan(now),
                Happening::Permit => brains.permit(now),
                Happening::Ask(number) => brains.ask(now, self.asked[*number]),
            }
        }
    }
}

/// Whether a width was measured in a frame, not by the simulator's stand-in.
fn is_of_camera(payload: &[u8]) -> bool {
    decode::<BeadWidth>(payload).is_some_and(|width| width.source == "camera")
}

/// What persons asked the supervisor, by the stamp of its answer: its events tell.
fn requests(part: &[Kept]) -> BTreeMap<u64, Vec<Operator>> {
    let mut requests: BTreeMap<u64, Vec<Operator>> = BTreeMap::new();
    for kept in part.iter().filter(|kept| kept.topic == topics::EVENTS.name()) {
        let event = decode::<PrintEvent>(&kept.payload);
        if let (Some(request), Some(ns)) = (event.as_ref().and_then(request), stamp_ns(&kept.payload)) {
            requests.entry(ns).or_default().push(request);
        }
    }
    requests
}

fn request(event: &PrintEvent) -> Option<Operator> {
    let asked = event.what.strip_suffix("_granted").or_else(|| event.what.strip_suffix("_denied"))?;
    Some(match asked {
        "pause" => Operator::Pause,
        "resume" => Operator::Resume,
        "stop" => Operator::Stop,
        "estop" => Operator::Estop,
        "acknowledge" => Operator::Acknowledge,
        "approve" => Operator::Approve,
        "set_mode" => Operator::SetMode(match event.after.as_str() {
            "observe" => Mode::Observe,
            "advise" => Mode::Advise,
            _ => Mode::Act,
        }),
        _ => return None,
    })
}

/// Instants at which a timer is due `[ns]`.
struct Timer {
    begin_ns: u64,
    end_ns: u64,
    period_s: f64,
    /// Due at the first whole step of the simulation that is late enough.
    step: bool,
}

/// Step of a simulation `[ns]`, and what its timers forgive, as `printer_sim::pace::Pace` does.
const STEP_NS: f64 = 1e6;
const FORGIVEN_NS: f64 = 1e3;

impl Timer {
    fn map<T>(self, of: impl Fn(u64) -> T) -> impl Iterator<Item = T> {
        let Self { begin_ns, end_ns, period_s, step } = self;
        let due = move |beat: u32| {
            let after_ns = f64::from(beat) * period_s * 1e9;
            let after_ns =
                if step { ((after_ns - FORGIVEN_NS) / STEP_NS).ceil() * STEP_NS } else { after_ns.round() };
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "times of a bag")]
            let due_ns = begin_ns.checked_add(after_ns as u64);
            due_ns
        };
        (1..u32::MAX).map_while(due).take_while(move |ns| *ns <= end_ns).map(of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_permit_that_answers_is_told_from_one_of_a_tick() {
        let mut schedule = Schedule { part: &[], happenings: Vec::new(), asked: Vec::new(), ticked_ns: None };
        let told = [0, 20, 20, 24, 40, 60, 69, 80].map(|ms| schedule.is_of_tick(ms * 1_000_000));
        assert_eq!(told, [true, true, false, false, true, true, false, true]);
    }

    #[test]
    fn a_timer_is_due_at_the_first_step_that_is_late_enough() {
        let due = |period_s, step| {
            let timer = Timer { begin_ns: 0, end_ns: 1_000_000_000, period_s, step };
            timer.map(|ns| ns).take(3).collect::<Vec<_>>()
        };
        assert_eq!(due(0.25, true), [250_000_000, 500_000_000, 750_000_000]);
        assert_eq!(due(0.0333, true), [34_000_000, 67_000_000, 100_000_000]);
        assert_eq!(due(0.0333, false), [33_300_000, 66_600_000, 99_900_000]);
    }

    /// A time at the end of what can be counted: a timer that stays there would be due for ever.
    #[test]
    fn a_timer_ends_with_the_times() {
        for begin_ns in [u64::MAX, u64::MAX - 600_000_000] {
            let timer = Timer { begin_ns, end_ns: u64::MAX, period_s: 0.25, step: false };
            let wanted = if begin_ns == u64::MAX { 0 } else { 2 };
            assert_eq!(timer.map(|ns| ns).take(9).count(), wanted);
        }
    }

    #[test]
    fn a_stamp_reads_as_its_message_says() {
        let header = fdm_loop_msgs::Header::at(12.345_678_901);
        let payload = super::super::brains::encode(&BeadWidth { header, ..BeadWidth::default() }).unwrap();
        assert_eq!(stamp_ns(&payload), Some(12_345_678_901));
        assert!((seconds(12_345_678_901).0 - 12.345_678_901).abs() < 1e-15);
    }
}
