//! What is learnt of a nozzle that may have narrowed.

use super::*;

/// A nozzle that has narrowed needs its melt's part 1.3 times: at each frame what is learnt of that is told, as much as it makes of the
/// melt's part at the feeds of the frames. Once it is sound again nothing of it is left.
#[test]
fn what_a_narrowed_nozzle_holds_more_is_learnt_at_once_and_told() {
    let printer = StaticLaw::of_compression(LAW.index, 1.3 * LAW.shear, LAW.linear_s);
    let foretold = Foretold { advance_s: 0.416, law: LAW, ..foretold() };
    let mut learning = Learning::new(RawLearning { reach: 1e-3, narrowed_reach: 0.5, ..LEARNING });
    let narrowed = Nozzle { force: 1.0, doubt: 1.0 };
    let (mut told_m, mut frames) = (0.0, 0);
    printed_with_law((&printer, feed_m_s), |sent, status, width| {
        learning.attached_mut().push(sent);
        learning.on_move(status);
        learning.on_status(status, &foretold, narrowed);
        if let Some((at_s, width_m)) = width {
            let more_m = learning.on_width(at_s, width_m);
            told_m += more_m;
            frames += u32::from(more_m != 0.0);
        }
        learning.learnt().of(LAW)
    });
    let narrowed = learning.learnt().narrowed;
    assert!((narrowed - 0.3).abs() < 0.05 && frames > 20, "{narrowed} {frames}");
    let at = |feed_m_s: f64| narrowed * LAW.shear * feed_m_s.powf(LAW.index);
    assert!((at(0.9e-3)..at(3.1e-3)).contains(&told_m), "{told_m} m");
    learning.on_status(&status(300.0, 2e-3), &foretold, Nozzle::SOUND);
    assert!(learning.learnt().narrowed.abs() < 1e-15);
}

/// Of a predicted law nothing is learnt but its factor, whatever a dip leaves open: it is sent without what the nozzle holds already.
#[test]
fn a_narrowing_is_learnt_of_a_planned_law_alone() {
    let printer = StaticLaw::of_compression(LAW.index, 1.3 * LAW.shear, LAW.linear_s);
    let learning =
        RawLearning { reach: 0.4, planned_reach: 0.4, index_reach: 0.2, narrowed_reach: 0.5, ..LEARNING };
    for (source, grows) in [(AdvanceSource::Planned, true), (AdvanceSource::Predicted, false)] {
        let mut advance =
            Advance::new(RawAdvance { source, learning, age_limit_s: 1e3, ..SETTINGS }, Level::Mpc);
        let word = Foretold { advance_s: 0.416, law: LAW, ..foretold() };
        advance.on_prediction(Prediction { stamp: Seconds(0.0), advance: Some(word), turn: None });
        let mut told_m: f64 = 0.0;
        let law = printed_with_law((&printer, feed_m_s), |sent, status, width| {
            advance.attached_mut().push(sent);
            advance.on_move(status);
            advance.on_status(status, Some(LAW), Nozzle { force: 1.0, doubt: 1.0 });
            if let Some((at_s, width_m)) = width {
                told_m += advance.on_width(Seconds(at_s), width_m).abs();
            }
            advance.with_learnt(LAW)
        });
        let is_factor = (law.shear / LAW.shear - law.linear_s / LAW.linear_s).abs() < 1e-5;
        assert_eq!((told_m > 1e-6, is_factor), (grows, !grows), "{source:?}: {told_m} m, {law:?}");
    }
}

/// By the time that a dip tells of a force the nozzle holds it: a law that grows by that leaves nothing to learn from.
#[test]
fn what_a_told_force_holds_is_held_already() {
    let mut learning = Learning::new(LEARNING);
    let law_of = |force: f64| AdvanceLaw { shear: force * LAW.shear, ..LAW };
    let lever_under = |learning: &mut Learning, at_s: f64, force: f64| {
        let foretold = Foretold { advance_s: 0.416, law: law_of(force), ..foretold() };
        learning.on_status(&status(at_s, 2e-3), &foretold, Nozzle { force, doubt: 0.15 });
        learning.moments.back().unwrap().levers[0].abs()
    };
    for step in 0..500_u32 {
        lever_under(&mut learning, 0.02 * f64::from(step), 1.0);
    }
    for (step, force) in [(500, 1.5), (501, 1.5), (502, 1.0), (503, 1.0)] {
        let lever = lever_under(&mut learning, 0.02 * f64::from(step), force);
        assert!(lever < 1e-9, "{force}: {lever}");
    }
}
