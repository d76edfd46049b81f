//! What is forgotten between prints, and what is followed without an encoder.

use super::*;
use models::status::JobPhase;

/// A road 10 % thin moves the plan; a job that ends or fails leaves nothing of it for the next.
#[test]
fn what_was_corrected_ends_with_the_job() {
    for phase in [JobPhase::Idle, JobPhase::Done, JobPhase::Failed] {
        let mut rig = Rig::new(Level::Mpc);
        rig.run(200, |estimate| Estimate { gain: 0.9, ..estimate });
        assert!(rig.controller.held[FEED].abs() > 0.01 && rig.controller.report().base.abs() > 0.01);
        let now_s = rig.now_s() + 0.05;
        let ended = PrinterStatus { phase, ..status(now_s, rig.wanted_m, rig.in_force) };
        rig.controller.on_event(Event::Printer(ended));
        assert!(rig.controller.held.iter().all(|held| held.abs() < 1e-12), "{phase:?}");
        assert!(rig.controller.report().base.abs() < 1e-12, "{phase:?}");
        let sent = rig.controller.on_event(Event::Estimate(estimate(now_s))).unwrap().trims;
        assert_eq!(sent, Trims::NEUTRAL, "{phase:?}");
    }
}

/// Without an encoder the estimated flow tells: a tenth that lacks is minus a tenth of the nominal one.
#[test]
fn a_flow_that_lacks_is_an_error_below_zero() {
    let mut rig = Rig::new(Level::Mpc);
    rig.run(600, |estimate| Estimate { encoder_alive: false, flow_m_s: 0.9 * FEED_M_S, ..estimate });
    let told = rig.controller.flow_error.mean();
    // what the plan feeds meanwhile is taken out of the nominal flow again
    assert!((-0.12..-0.07).contains(&told), "{told}");
    assert!(rig.controller.held[FEED] > 0.02, "{:?}", rig.controller.held);
}
