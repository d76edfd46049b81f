//! The ways of REP-less `lifecycle_msgs`, as `rcl_lifecycle` of Jazzy registers them.

use super::*;

fn at(steps: &[Step]) -> Machine {
    let mut machine = Machine::default();
    for step in steps {
        machine.begin(*step).unwrap();
        machine.finish(Outcome::Success).unwrap();
    }
    machine
}

fn by_id(id: u8) -> Transition {
    Transition { id, label: String::new() }
}

#[test]
fn a_life_from_start_to_end() {
    let life = [Step::Configure, Step::Activate, Step::Deactivate, Step::Cleanup, Step::Shutdown];
    let states = ["inactive", "active", "inactive", "unconfigured", "finalized"];
    for (index, label) in states.iter().enumerate() {
        assert_eq!(at(&life[..=index]).state().label, *label);
    }
}

/// From each primary state exactly the steps of the design can be taken, by number and by name.
#[test]
fn wrong_steps_are_refused_and_change_nothing() {
    let states: [(&[Step], &[u8]); 4] = [
        (&[], &[1, 5]),
        (&[Step::Configure], &[2, 3, 6]),
        (&[Step::Configure, Step::Activate], &[4, 7]),
        (&[Step::Shutdown], &[]),
    ];
    for (steps, allowed) in states {
        for id in 0..=255 {
            let mut machine = at(steps);
            let before = machine.state();
            assert_eq!(machine.request(&by_id(id)).is_some(), allowed.contains(&id), "{before:?} {id}");
            assert_eq!(machine.state() == before, !allowed.contains(&id));
        }
        let machine = at(steps);
        let told: Vec<u8> = machine.available().iter().map(|way| way.transition.id).collect();
        assert_eq!(
            {
                let mut told = told;
                told.sort_unstable();
                told
            },
            allowed
        );
    }
    let named = Transition { id: 0, label: "activate".to_owned() };
    assert!(at(&[]).request(&named).is_none());
    assert_eq!(at(&[Step::Configure]).request(&named).unwrap().0, Step::Activate);
}

/// While a step is under way nothing else is taken, and its end cannot be asked for from outside.
#[test]
fn a_step_that_is_under_way_is_alone() {
    let mut machine = Machine::default();
    machine.request(&by_id(Transition::CONFIGURE)).unwrap();
    for id in 0..=255 {
        assert!(machine.request(&by_id(id)).is_none(), "{id}");
    }
    assert_eq!(machine.finish(Outcome::Failure).unwrap().goal_state.label, "unconfigured");
    assert!(machine.finish(Outcome::Success).is_none(), "nothing is under way");
}

#[test]
fn an_error_leads_back_to_the_start() {
    let mut machine = at(&[Step::Configure, Step::Activate]);
    machine.begin(Step::Deactivate).unwrap();
    assert_eq!(machine.finish(Outcome::Error).unwrap().goal_state.label, "errorprocessing");
    assert_eq!(machine.finish(Outcome::Success).unwrap().goal_state.label, "unconfigured");
    assert_eq!((Machine::states().len(), Machine::graph().len()), (11, 25));
}
