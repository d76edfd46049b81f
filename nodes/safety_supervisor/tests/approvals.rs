//! What a person lets through in advise, and until when.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::params_with;
use common::print::Print;
use models::command::{Mode, Trims};
use safety_supervisor::{Cause, Operator, Supervisor, What};

#[test]
fn advise_waits_for_approval_and_an_approval_ends_with_the_controller() {
    let mut print =
        Print::with(Supervisor::new(params_with("start_mode: observe", "start_mode: advise"), 7, None));
    print.run(3.0);
    assert_eq!(print.output.permit.trims, Trims::NEUTRAL);
    assert_eq!(print.ask(Operator::Approve), What::Granted(Operator::Approve));
    print.run(1.0);
    assert!((print.output.permit.trims.flow - 1.05).abs() < 1e-12);
    print.controller = false;
    print.run(3.0);
    assert_eq!(print.output.permit.trims, Trims::NEUTRAL);
    // It speaks again, and so may another one in its place: nobody has let that through.
    print.controller = true;
    print.run(3.0);
    assert_eq!(print.output.permit.trims, Trims::NEUTRAL);
}

/// Whoever has set advise is not told to set it.
#[test]
fn what_is_in_force_instead_of_advise_is_told() {
    let advising = params_with("start_mode: observe", "start_mode: advise");
    let mut print = Print::with(Supervisor::new(advising, 7, None));
    print.run(3.0);
    print.ask(Operator::Pause);
    assert_eq!(print.ask(Operator::Approve), What::Denied(Operator::Approve));
    let refused = print.output.events.last().unwrap();
    assert_eq!(refused.why, "advise is set, and not in force: what is in force has to be over first");
    assert_eq!(refused.cause.map(|(cause, _)| cause), Some(Cause::OperatorPause));
}

#[test]
fn an_approval_ends_with_the_mode_and_where_the_supervisor_stood_still() {
    let approved = || {
        let advising = params_with("start_mode: observe", "start_mode: advise");
        let mut print = Print::with(Supervisor::new(advising, 7, None));
        print.run(3.0);
        assert_eq!(print.ask(Operator::Approve), What::Granted(Operator::Approve));
        print.run(1.0);
        assert!((print.output.permit.trims.flow - 1.05).abs() < 1e-12);
        print
    };
    let mut print = approved();
    for mode in [Mode::Observe, Mode::Advise] {
        print.ask(Operator::SetMode(mode));
        print.run(3.0);
        assert_eq!(print.output.permit.trims, Trims::NEUTRAL, "{mode:?}");
    }
    let mut print = approved();
    print.tick += 20;
    print.run(0.5);
    assert_eq!((print.mode(), print.output.permit.trims), (Mode::Advise, Trims::NEUTRAL));
}
