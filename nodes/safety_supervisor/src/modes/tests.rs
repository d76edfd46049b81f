//! The mode machine, state by state: every state that can be reached, every event in it, every law after it.
//!
//! Of time the machine knows only ages against three limits; with limits of 1 s, 2 s and 3 s and steps of 1 s an age
//! beyond the last one says nothing new, so that the states are few and finite. Causes differ by their order alone.

use std::collections::{BTreeMap, BTreeSet, HashSet, VecDeque};

use super::*;

mod laws;

const HOLD_S: f64 = 1.0;
const STANDBY_S: f64 = 2.0;
const PAUSE_MAX_S: f64 = 3.0;
/// Ages from here on are all alike `[s]`.
const OLD_S: f64 = 4.0;
const LEVELS: [Option<Reaction>; 5] =
    [None, Some(Reaction::Degrade), Some(Reaction::Pause), Some(Reaction::SafeOff), Some(Reaction::Estop)];
const LATCHING: Option<Reaction> = Some(Reaction::SafeOff);
const PAUSING: Option<Reaction> = Some(Reaction::Pause);

fn params() -> ModeParams {
    ModeParams {
        ramp_s: 1.0,
        hold_s: HOLD_S,
        standby_after_s: STANDBY_S,
        pause_max_s: PAUSE_MAX_S,
        hot_margin_k: 5.0,
        adopt_s: 1.0,
        take_up_s: 10.0,
        startup_s: 10.0,
        stall_s: 0.2,
        stall_forgiven_s: 5.0,
        return_s: 5.0,
        grace_layers: 2,
    }
}

/// What can happen.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Step {
    /// A tick so much later, on which a cause calls for something else than before.
    Tick {
        after_s: f64,
        change: Option<(Cause, Option<Reaction>)>,
        job_runs: bool,
    },
    Demand(Cause, Reaction),
    Set(Mode),
    Resume(Readiness),
    TryResume(Readiness),
    Acknowledge {
        job_waits: bool,
    },
    Initialise,
    /// The process is started again in act and finds what stood; the printer's first word may be that no job waits.
    Restart {
        job_waits: bool,
    },
    /// The clock is set back.
    SetBack,
}

fn steps(causes: &[Cause], sets: &[Mode]) -> Vec<Step> {
    let mut steps = vec![
        Step::Demand(Cause::OperatorPause, Reaction::Pause),
        Step::Demand(Cause::OperatorStop, Reaction::SafeOff),
        Step::Demand(Cause::OperatorEstop, Reaction::Estop),
        Step::Initialise,
        Step::SetBack,
    ];
    for job_runs in [false, true] {
        for after_s in [0.0, 1.0, 2.0 * OLD_S] {
            steps.push(Step::Tick { after_s, change: None, job_runs });
        }
        for cause in causes {
            for reaction in LEVELS {
                steps.push(Step::Tick { after_s: 0.0, change: Some((*cause, reaction)), job_runs });
            }
        }
        steps.extend([Step::Acknowledge { job_waits: job_runs }, Step::Restart { job_waits: job_runs }]);
    }
    steps.extend(sets.iter().copied().map(Step::Set));
    for bits in 0..8_u8 {
        let ready = Readiness { homed: bits & 1 != 0, filament: bits & 2 != 0, hot: bits & 4 != 0 };
        steps.extend([Step::Resume(ready), Step::TryResume(ready)]);
    }
    steps
}

/// A machine whose clock stands at zero, and whether the last step was granted.
struct After {
    modes: Modes,
    granted: bool,
}

fn take(before: &Modes, step: Step) -> After {
    let mut modes = before.clone();
    let mut now = Seconds(0.0);
    let granted = match step {
        Step::Tick { after_s, change, job_runs } => {
            now = Seconds(after_s);
            let mut raised = modes.raised;
            if let Some((cause, reaction)) = change {
                raised[cause as usize] = reaction;
            }
            _ = modes.update(now, &raised, job_runs);
            true
        }
        Step::Demand(cause, reaction) => {
            modes.demand(now, cause, reaction);
            true
        }
        Step::Set(mode) => modes.set(mode).is_ok(),
        Step::Resume(ready) => modes.resume(now, ready).is_ok(),
        Step::TryResume(ready) => modes.try_resume(now, ready),
        Step::Acknowledge { job_waits } => modes.acknowledge(now, job_waits).is_ok(),
        Step::Initialise => {
            modes.initialise();
            true
        }
        Step::Restart { job_waits } => {
            let left = modes.standing(Some(now));
            modes = Modes::new(params(), Mode::Act, modes.latch);
            left.into_iter().for_each(|left| modes.restore(left));
            modes.begin(now);
            if !job_waits {
                modes.drop_pause(now);
            }
            true
        }
        Step::SetBack => {
            now = Seconds(-2.0 * OLD_S);
            modes.set_back(now, now);
            true
        }
    };
    let age = |since: Seconds| Seconds(-(now.0 - since.0).min(OLD_S));
    for pause in [&mut modes.pause, &mut modes.hold].into_iter().flatten() {
        pause.since = age(pause.since);
    }
    modes.degraded = modes.degraded.map(|(cause, last)| (cause, age(last)));
    modes.since = Seconds(0.0);
    After { modes, granted }
}

type PauseKey = Option<(Cause, u8, bool)>;
type Key =
    ([u8; 2], bool, Option<(bool, Cause)>, [PauseKey; 2], Option<(Cause, u8)>, Vec<Option<Reaction>>, Mode);

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "whole seconds up to four")]
fn key(modes: &Modes, causes: &[Cause]) -> Key {
    let pause = |pause: Option<Pause>| pause.map(|pause| (pause.cause, -pause.since.0 as u8, pause.resuming));
    (
        [modes.set_mode as u8, modes.asked.map_or(0, |mode| Mode::from(mode) as u8)],
        modes.initialised,
        modes.latch.map(|latch| (latch.estop, latch.cause)),
        [pause(modes.pause), pause(modes.hold)],
        modes.degraded.map(|(cause, last)| (cause, -last.0 as u8)),
        causes.iter().map(|cause| modes.raised[*cause as usize]).collect(),
        modes.seen,
    )
}

fn request(modes: &Modes) -> Request {
    modes.request(Seconds(0.0))
}

/// Most that any standing cause calls for.
fn worst(modes: &Modes) -> Option<Reaction> {
    modes.raised.iter().copied().max().flatten()
}

/// What the search has seen.
#[derive(Default)]
struct Seen {
    states: usize,
    transitions: usize,
    modes: BTreeMap<(Mode, Mode), usize>,
}

/// Visits every state that the causes lead to and takes every step in it.
fn search(causes: &[Cause], sets: &[Mode]) -> Seen {
    let steps = steps(causes, sets);
    let mut seen = Seen::default();
    let mut known = HashSet::new();
    let mut queue = VecDeque::new();
    for cause in [None, Some(causes[0])] {
        let start = Modes::new(params(), Mode::Observe, cause.map(|cause| Latch { estop: false, cause }));
        known.insert(key(&start, causes));
        queue.push_back(start);
    }
    while let Some(before) = queue.pop_front() {
        for step in &steps {
            let after = take(&before, *step);
            laws::check_step(&before, *step, &after);
            seen.transitions += 1;
            *seen.modes.entry((before.mode(), after.modes.mode())).or_default() += 1;
            if known.insert(key(&after.modes, causes)) {
                queue.push_back(after.modes);
            }
        }
    }
    seen.states = known.len();
    seen
}

const MODES: [Mode; 8] = [
    Mode::Init,
    Mode::Observe,
    Mode::Advise,
    Mode::Act,
    Mode::Degraded,
    Mode::Paused,
    Mode::SafeOff,
    Mode::Estop,
];

#[test]
fn every_step_in_every_state_of_two_causes_keeps_the_laws() {
    let seen = search(&[Cause::ALL[0], Cause::ALL[Cause::COUNT - 1]], &MODES);
    println!("two causes: {} states, {} transitions", seen.states, seen.transitions);
    let pairs = MODES.into_iter().flat_map(|from| MODES.map(|to| (from, to)));
    let never: Vec<_> = pairs.filter(|pair| !seen.modes.contains_key(pair)).collect();
    // An emergency stop does not fade, and a latch does not turn into a pause; all else happens.
    let expected = [(Mode::SafeOff, Mode::Paused), (Mode::Estop, Mode::Paused), (Mode::Estop, Mode::SafeOff)];
    assert_eq!(never, expected);
}

#[test]
fn every_cause_by_itself_keeps_the_laws() {
    let (mut states, mut transitions) = (0, 0);
    for cause in Cause::ALL {
        let seen = search(&[*cause], &[Mode::Act]);
        states += seen.states;
        transitions += seen.transitions;
        let visited: BTreeSet<_> = seen.modes.keys().map(|(_, to)| *to).collect();
        assert_eq!(visited.len(), MODES.len() - 1, "{cause:?}: all modes but advise, which nobody sets here");
    }
    println!("{} causes: {states} states, {transitions} transitions", Cause::COUNT);
}
