//! Which gate and which rule of a step count for a width.

use super::*;

const WIDTH: usize = Channel::Width as usize;

/// Beside an encoder what follows a rejected width has to fit better: 4 % are within four sigma, not within two. No doubt of
/// a transient.
#[test]
fn after_a_rejected_width_the_gate_is_narrow() {
    let gated = |gains: &[f64]| {
        let mut rig = Rig::with(&[("transient_doubt: 3.0 ", "transient_doubt: 0.0 ")]);
        let before = rig.run(3000).gated[WIDTH];
        gains.iter().for_each(|&gain| {
            rig.gain = gain;
            rig.run(50);
        });
        rig.run(5).gated[WIDTH] - before
    };
    assert_eq!(gated(&[1.04]), 0);
    assert_eq!(gated(&[1.2]), 1);
    assert_eq!(gated(&[1.2, 1.04]), 2);
}

/// Widths that nobody vouches for have a gate and a rule of their own.
#[test]
fn widths_alone_have_their_own_gate_and_step() {
    let slipped = |changes: &[(&str, &str)]| {
        let mut rig = Rig::with(changes);
        rig.encoder = false;
        let before = rig.run(3000);
        rig.slip = 0.40;
        let after = rig.run(1000);
        (after.gated[WIDTH] - before.gated[WIDTH], after.steps - before.steps)
    };
    let (gated, steps) = slipped(&[]);
    assert!(gated > 0 && steps > 0, "{gated} {steps}");
    let gate = |largest: &str| format!("gate: {largest}                    # [-] 1..1e6, widths");
    assert_eq!(slipped(&[(&gate("25.0"), &gate("1.0e6"))]).0, 0);
    assert_eq!(slipped(&[("step_threshold: 2.5 ", "step_threshold: 100.0 ")]).1, 0);
}

/// A single width off by four sigma: a step where one is looked at, none in the mean of four.
#[test]
fn widths_alone_look_for_a_step_in_as_many_as_they_say() {
    let rule = |samples: u32| {
        format!(
            "step_samples: {samples}               # [samples] 1..20, newest innovations in which a step of"
        )
    };
    for (samples, steps) in [(4, 0), (1, 1)] {
        let mut rig = Rig::with(&[(&rule(4), &rule(samples))]);
        rig.encoder = false;
        let before = rig.run(3000).steps;
        rig.gain = 1.06;
        assert_eq!(rig.run(50).steps - before, steps, "{samples}");
    }
}
