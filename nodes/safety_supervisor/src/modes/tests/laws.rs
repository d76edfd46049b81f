//! What holds in every state and after every step.

use super::*;

/// Laws of a state by itself.
fn check_state(modes: &Modes) {
    let (mode, request) = (modes.mode(), request(modes));
    match modes.latch {
        Some(Latch { estop: true, .. }) => {
            assert_eq!((mode, request), (Mode::Estop, Request::EmergencyStop));
        }
        Some(_) => assert_eq!((mode, request), (Mode::SafeOff, Request::HeatersOff)),
        None => assert!(mode < Mode::SafeOff && request < Request::HeatersOff),
    }
    assert!(mode != Mode::Paused || request >= Request::Pause, "paused and running");
    assert!(modes.pause.is_none() || modes.hold.is_none(), "two pauses at once");
    assert!(mode == modes.set_mode || mode != Mode::Act, "nobody has set it");
    assert!(mode < Mode::Degraded || modes.cause().is_some(), "no reason told");
}

/// Laws of a step.
pub(super) fn check_step(before: &Modes, step: Step, after: &After) {
    let modes = &after.modes;
    check_state(modes);
    let standing = worst(modes);
    if let Step::Tick { job_runs, .. } = step {
        // What stands is answered on the same tick, whatever was before.
        assert!(standing < Some(Reaction::Estop) || modes.mode() == Mode::Estop);
        assert!(standing < LATCHING || modes.latch.is_some());
        assert!(standing < PAUSING || !job_runs || request(modes) >= Request::Pause, "a cause runs on");
        assert!(standing.is_none() || modes.mode() >= Mode::Degraded);
    }
    check_latch(before, step, after);
    check_pause(before, step, after);
    match step {
        Step::Set(mode) => {
            let allowed = matches!(mode, Mode::Observe | Mode::Advise | Mode::Act);
            assert_eq!(after.granted, allowed);
            assert_eq!(modes.set_mode, if allowed { mode } else { before.set_mode });
            assert_eq!(modes.asked, StartMode::of(mode).or(before.asked));
        }
        Step::Tick { after_s, .. } if after_s >= HOLD_S && standing.is_none() && modes.initialised => {
            assert_ne!(modes.mode(), Mode::Degraded, "the cause has been gone for long enough");
        }
        // The start would be in act.
        Step::Restart { .. } => assert_eq!(modes.set_mode, before.asked.map_or(Mode::Act, Mode::from)),
        _ => assert_eq!(modes.set_mode, before.set_mode),
    }
    let restarted = matches!(step, Step::Restart { .. });
    assert!(restarted || modes.initialised || !before.initialised, "the start comes once");
}

/// A latch ends by an acknowledge with nothing standing that latches, and the job that waits does not run after it.
fn check_latch(before: &Modes, step: Step, after: &After) {
    let Some(latch) = before.latch else { return };
    let modes = &after.modes;
    match (step, modes.latch) {
        (Step::Acknowledge { job_waits }, None) => {
            assert!(after.granted && worst(before) < LATCHING);
            assert!(!job_waits || request(modes) == Request::Pause, "from latched straight on");
        }
        (_, now) => {
            let now = now.expect("only an acknowledge ends a latch");
            assert!(now.estop || !latch.estop, "an emergency stop became less");
            assert!(now.cause == latch.cause || now.estop && !latch.estop, "the first cause is told");
        }
    }
}

/// A pause begins once a cause, ends as a person says and the printer is ready, and does not last for ever.
fn check_pause(before: &Modes, step: Step, after: &After) {
    let modes = &after.modes;
    let (was, is) = (before.pause.or(before.hold), modes.pause.or(modes.hold));
    let ready_step = match step {
        Step::Resume(ready) | Step::TryResume(ready) => Some(ready),
        _ => None,
    };
    match (was, is) {
        (None, Some(pause)) if before.latch.is_none() => {
            let asked = matches!(step, Step::Demand(_, Reaction::Pause));
            let raised = modes.raised[pause.cause as usize] >= PAUSING;
            assert!(asked || raised, "paused for nothing");
        }
        (Some(_), None) if step == (Step::Restart { job_waits: false }) => {}
        (Some(pause), None) if !matches!(step, Step::Acknowledge { .. }) => {
            let ready = ready_step.expect("only a resume ends a pause");
            assert!(before.latch.is_none() && ready == Readiness { homed: true, filament: true, hot: true });
            assert!(worst(before) < PAUSING, "the cause is still there");
            assert!(pause.resuming || matches!(step, Step::Resume(_)), "nobody has asked for it");
        }
        (Some(pause), Some(now)) if pause.resuming && !now.resuming => {
            let asked = matches!(step, Step::Demand(_, Reaction::Pause));
            let restarted = matches!(step, Step::Restart { .. });
            let raised = worst(modes) >= PAUSING || before.latch.is_some();
            assert!(asked || raised || restarted, "the resume was forgotten");
        }
        _ => {}
    }
    if let Step::Restart { job_waits } = step {
        let waits = was.filter(|_| job_waits).map(|pause| pause.cause);
        assert_eq!(is.map(|pause| pause.cause), waits, "a restart is no resume");
    }
    if step == Step::SetBack {
        let ages = |modes: &Modes| [modes.pause, modes.hold].map(|pause| pause.map(|pause| pause.since));
        assert_eq!((is, ages(modes)), (was, ages(before)), "a pause keeps its age");
        assert_eq!((modes.mode(), modes.degraded), (before.mode(), before.degraded));
    }
    if let Step::Tick { after_s, .. } = step
        && was.is_some()
        && after_s > PAUSE_MAX_S
    {
        assert!(modes.latch.is_some(), "a pause without an end");
    }
}
