use proptest::prelude::*;

use super::*;
use crate::command::limits::tests::limits;

const VALIDITY_S: f64 = 0.25;

fn dead_man(on_supervisor_loss: OnLoss) -> DeadMan {
    let raw = RawDeadManParams { on_supervisor_loss, pause_delay_s: 2.0, heaters_off_delay_s: 5.0 };
    DeadMan::new(DeadManParams::try_from(raw).unwrap(), limits())
}

fn permit(session: u64, sequence: u64, request: Request) -> Permit {
    let mode = match request {
        Request::Run => Mode::Act,
        Request::Pause | Request::Standby => Mode::Paused,
        Request::HeatersOff => Mode::SafeOff,
        Request::EmergencyStop => Mode::Estop,
    };
    let trims = Trims { flow: 1.1, ..Trims::NEUTRAL };
    Permit { session, sequence, validity: Seconds(VALIDITY_S), mode, request, trims }
}

/// C2: the slicer's values 250 ms after the last permit.
#[test]
fn silence_brings_back_the_slicers_values_after_the_validity() {
    let mut dead_man = dead_man(OnLoss::Baseline);
    assert_eq!(dead_man.in_force(Seconds(0.0)).request, Request::Run);
    dead_man.on_permit(Seconds(1.0), permit(1, 1, Request::Run)).unwrap();
    assert!((dead_man.in_force(Seconds(1.25)).trims.flow - 1.1).abs() < 1e-12);
    let after = dead_man.in_force(Seconds(1.2501));
    assert_eq!((after.trims, after.lapsed, after.request), (Trims::NEUTRAL, true, Request::Run));
    assert_eq!(dead_man.in_force(Seconds(1e6)).request, Request::Run);
}

/// A supervisor that leaps is followed at the printer's own pace; what goes back to the slicer's values leaps.
#[test]
fn trims_move_no_faster_than_the_printers_own_slew() {
    let mut dead_man = dead_man(OnLoss::Baseline);
    let mut flows = vec![dead_man.in_force(Seconds(0.0)).trims.flow];
    dead_man.on_permit(Seconds(0.0), permit(1, 1, Request::Run)).unwrap();
    for step in 1..=26 {
        flows.push(dead_man.in_force(Seconds(f64::from(step) * 0.01)).trims.flow);
    }
    let steps: Vec<f64> = flows.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let slew =
        limits().slew(&Trims::NEUTRAL, &Trims { flow: 1.1, ..Trims::NEUTRAL }, Seconds(0.01)).trims.flow
            - 1.0;
    assert!(slew > 0.0 && slew < 0.05, "{slew}");
    let (last, up) = steps.split_last().unwrap();
    assert!(up.iter().all(|step| (0.0..=slew + 1e-12).contains(step)), "{flows:?}");
    assert!((up[0] - slew).abs() < 1e-12 && (flows[25] - 1.1).abs() < 1e-12, "{flows:?}");
    assert!((last + 0.1).abs() < 1e-12, "lapsed: {flows:?}");
}

/// C2: the policy's step after its own delay.
#[test]
fn the_policy_follows_after_its_delay_and_stays() {
    for (policy, delay_s, request) in
        [(OnLoss::Pause, 2.0, Request::Pause), (OnLoss::HeatersOff, 5.0, Request::HeatersOff)]
    {
        let mut dead_man = dead_man(policy);
        assert_eq!(dead_man.in_force(Seconds(100.0)).request, Request::Run, "nobody to lose yet");
        dead_man.on_permit(Seconds(0.0), permit(1, 1, Request::Run)).unwrap();
        assert_eq!(dead_man.in_force(Seconds(VALIDITY_S + delay_s)).request, Request::Run);
        assert_eq!(dead_man.in_force(Seconds(VALIDITY_S + delay_s + 0.01)).request, request);
        // Back again, but it knows nothing of the step: held until it has adopted it.
        dead_man.on_permit(Seconds(10.0), permit(1, 2, Request::Run)).unwrap();
        assert_eq!(dead_man.in_force(Seconds(10.0)).request, request);
        dead_man.on_permit(Seconds(10.1), permit(1, 3, request)).unwrap();
        dead_man.on_permit(Seconds(10.2), permit(1, 4, Request::Run)).unwrap();
        assert_eq!(dead_man.in_force(Seconds(10.2)).request, Request::Run);
    }
}

#[test]
fn a_restarted_supervisor_that_forgot_a_trip_does_not_undo_it() {
    for request in [Request::Pause, Request::Standby, Request::HeatersOff, Request::EmergencyStop] {
        let mut dead_man = dead_man(OnLoss::Baseline);
        dead_man.on_permit(Seconds(0.0), permit(1, 1, request)).unwrap();
        assert_eq!(dead_man.in_force(Seconds(9.0)).request, request, "kept without any permit");
        dead_man.on_permit(Seconds(10.0), permit(2, 1, Request::Run)).unwrap();
        assert_eq!(dead_man.in_force(Seconds(10.0)).request, request);
        dead_man.on_permit(Seconds(10.1), permit(2, 2, request)).unwrap();
        dead_man.on_permit(Seconds(10.2), permit(2, 3, Request::Pause)).unwrap();
        assert_eq!(dead_man.in_force(Seconds(10.2)).request, Request::Pause, "acknowledged");
        dead_man.on_permit(Seconds(10.3), permit(2, 4, Request::Run)).unwrap();
        assert_eq!(dead_man.in_force(Seconds(10.3)).request, Request::Run, "resumed");
    }
}

#[test]
fn who_asked_for_the_pause_may_end_standby() {
    let mut dead_man = dead_man(OnLoss::Baseline);
    dead_man.on_permit(Seconds(0.0), permit(1, 1, Request::Standby)).unwrap();
    dead_man.on_permit(Seconds(1.0), permit(2, 1, Request::Pause)).unwrap();
    assert_eq!(dead_man.in_force(Seconds(1.0)).request, Request::Pause);
}

#[test]
fn the_printers_own_limits_hold_whatever_the_permit_says() {
    let mut dead_man = dead_man(OnLoss::Baseline);
    let trims = Trims { flow: 9.0, ..Trims::NEUTRAL };
    let wild = Permit { trims, validity: Seconds(1.0), ..permit(1, 1, Request::Run) };
    dead_man.on_permit(Seconds(0.0), wild).unwrap();
    assert_eq!(dead_man.in_force(Seconds(0.0)).trims, Trims::NEUTRAL);
    assert!((dead_man.in_force(Seconds(0.9)).trims.flow - 1.25).abs() < 1e-12);
    assert_eq!(dead_man.clamped(), 1);
    let broken = Permit { trims: Trims { flow: f64::NAN, ..Trims::NEUTRAL }, ..permit(1, 2, Request::Run) };
    assert_eq!(dead_man.on_permit(Seconds(0.9), broken), Err(Refusal::NotFinite));
    assert_eq!(dead_man.refusals().not_finite, 1);
}

/// X2: a stranger that got in first, while the supervisor was started again, keeps nobody from switching off; and has no say
/// in the end of it.
#[test]
fn a_stop_counts_from_a_session_that_is_not_in_force() {
    for stop in [Request::HeatersOff, Request::EmergencyStop] {
        let mut dead_man = dead_man(OnLoss::Baseline);
        dead_man.on_permit(Seconds(0.0), permit(66, 1, Request::Run)).unwrap();
        let refused = dead_man.on_permit(Seconds(0.1), permit(1, 1, stop));
        assert_eq!(refused, Err(Refusal::OtherSession));
        dead_man.on_permit(Seconds(0.12), permit(66, 2, Request::Run)).unwrap();
        assert_eq!(dead_man.in_force(Seconds(0.12)).request, stop, "held against the stranger's own word");
    }
    let mut dead_man = dead_man(OnLoss::Baseline);
    dead_man.on_permit(Seconds(0.0), permit(66, 1, Request::Run)).unwrap();
    assert!(dead_man.on_permit(Seconds(0.1), permit(1, 1, Request::Standby)).is_err());
    assert_eq!(dead_man.in_force(Seconds(0.1)).request, Request::Run, "a pause waits for its turn");
}

/// A printer whose file takes shorter permits than its supervisor sends: no correction, but a stop all the same, also before
/// the first permit; one that is late or twice is over.
#[test]
fn a_stop_counts_whatever_its_validity() {
    let long = |sequence, request| Permit { validity: Seconds(60.0), ..permit(1, sequence, request) };
    for request in [Request::HeatersOff, Request::EmergencyStop] {
        let mut dead_man = dead_man(OnLoss::Baseline);
        assert_eq!(dead_man.on_permit(Seconds(0.0), long(1, request)), Err(Refusal::Validity));
        let InForce { request: held, lapsed, .. } = dead_man.in_force(Seconds(0.01));
        assert_eq!((held, lapsed), (request, true));
    }
    let mut dead_man = dead_man(OnLoss::Baseline);
    dead_man.on_permit(Seconds(0.0), permit(1, 7, Request::Run)).unwrap();
    for (sequence, asked, held) in [
        (7, Request::EmergencyStop, Request::Run),
        (8, Request::Standby, Request::Run),
        (8, Request::EmergencyStop, Request::EmergencyStop),
    ] {
        assert_eq!(dead_man.on_permit(Seconds(0.1), long(sequence, asked)), Err(Refusal::Validity));
        assert_eq!(dead_man.in_force(Seconds(0.1)).request, held);
    }
}

fn any_request() -> impl Strategy<Value = Request> {
    prop_oneof![
        5 => Just(Request::Run),
        1 => Just(Request::Pause),
        1 => Just(Request::Standby),
        1 => Just(Request::HeatersOff),
        1 => Just(Request::EmergencyStop),
    ]
}

proptest! {
    /// For any sequence of permits and gaps: trims finite and inside, neutral when lapsed, and a latched demand
    /// ends only with a permit of a session that has made it itself.
    #[test]
    fn laws_of_the_dead_man(
        arrivals in proptest::collection::vec(
            (0.0..0.6f64, 0u64..2, 0u64..100, any_request(), -2.0..4.0f64), 1..100)
    ) {
        let mut dead_man = dead_man(OnLoss::HeatersOff);
        let mut now_s = 0.0;
        // The session whose permit was taken last, and the highest demand that it has made since.
        let mut bound = (None, Request::Run);
        for (step_s, session, sequence, request, flow) in arrivals {
            let before = dead_man.in_force(Seconds(now_s));
            now_s += step_s;
            let trims = Trims { flow, ..Trims::NEUTRAL };
            let accepted = dead_man
                .on_permit(Seconds(now_s), Permit { trims, ..permit(session, sequence, request) })
                .is_ok();
            let now = dead_man.in_force(Seconds(now_s));
            prop_assert!((0.75..=1.25).contains(&now.trims.flow));
            prop_assert!(!now.lapsed || now.trims == Trims::NEUTRAL);
            prop_assert!(accepted || now.request >= before.request);
            if accepted {
                let own = if bound.0 == Some(session) { bound.1.max(request) } else { request };
                let needed = if before.request == Request::Standby { Request::Pause } else { before.request };
                let lowered = now.request < before.request;
                prop_assert!(!lowered || (now.request == request && own >= needed));
                bound = (Some(session), if lowered { request } else { own });
            }
        }
    }
}

/// A middleware that drowns delivers late: a correction ends when its stamp's validity does, and not that long after receipt.
#[test]
fn a_permit_counts_from_its_stamp() {
    let sent = permit(1, 1, Request::Run);
    assert_eq!(sent.arrived(Seconds(0.0)), Some(sent));
    assert_eq!(sent.arrived(Seconds(-0.02)), Some(sent), "a clock that was read before");
    assert_eq!(sent.arrived(Seconds(VALIDITY_S)), None, "nothing is left of it");
    let mut dead_man = dead_man(OnLoss::Baseline);
    let way_s = 0.6 * VALIDITY_S;
    dead_man.on_permit(Seconds(way_s), sent.arrived(Seconds(way_s)).unwrap()).unwrap();
    assert!(!dead_man.in_force(Seconds(0.99 * VALIDITY_S)).lapsed);
    let after = dead_man.in_force(Seconds(1.01 * VALIDITY_S));
    assert!(after.lapsed && after.trims == Trims::NEUTRAL, "{after:?}");
}

/// Who wants the printer stopped is heard however long it took, and a validity that is no time is the gate's to refuse.
#[test]
fn a_demand_counts_however_late_it_comes() {
    for request in [Request::Pause, Request::Standby, Request::HeatersOff, Request::EmergencyStop] {
        let sent = permit(1, 1, request);
        assert_eq!(sent.arrived(Seconds(10.0 * VALIDITY_S)), Some(sent));
    }
    let mut dead_man = dead_man(OnLoss::Baseline);
    for validity_s in [f64::NAN, 0.0, -1.0, 60.0] {
        let wrong = Permit { validity: Seconds(validity_s), ..permit(1, 1, Request::Run) };
        assert!(
            dead_man.on_permit(Seconds(0.1), wrong.arrived(Seconds(0.1)).unwrap()).is_err(),
            "{validity_s}"
        );
    }
}
