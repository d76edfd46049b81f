//! What is learnt of a law that is planned from the melt.

use super::*;

/// A melt that thins less under shear than its maker says, index 0.6 of 0.5, on roads at three feeds: some of the offset is found in
/// 200 s. Without reach the index is the maker's.
#[test]
fn the_index_of_a_planned_law_is_learnt() {
    let plant = LAW.bent(0.1, 2e-3);
    let printer = StaticLaw::of_compression(plant.index, plant.shear, plant.linear_s);
    let feed_m_s = |at_s: f64| match (at_s / 6.0).fract() {
        0.0..0.33 => 3e-3,
        0.33..0.66 => 0.4e-3,
        _ => 1.7e-3,
    };
    // what an index does is much like what a factor does: widths that scatter tell it slowly, these do not
    let learnt = |index_reach: f64| {
        let learning = RawLearning {
            planned_reach: 0.4,
            index_reach,
            width_noise: 0.01,
            settle_s: 0.1,
            lever_min: 0.05,
            lever_max: 1.0,
            ..LEARNING
        };
        let settings = RawAdvance { source: AdvanceSource::Planned, learning, ..SETTINGS };
        let mut advance = Advance::new(settings, Level::Mpc);
        print_and_learn(&mut advance, (&printer, feed_m_s))
    };
    let (bent, unbent) = (learnt(0.2), learnt(0.0));
    assert!((0.03..0.13).contains(&(bent.index - LAW.index)), "{bent:?}");
    assert!((unbent.index - LAW.index).abs() < 1e-15);
    assert!(learnt(0.03).index - LAW.index < 0.03 + 1e-12);
}

/// A law that goes on growing by what was learnt, at one feed: what it holds more there is told, so that nothing is pushed for it. A
/// predicted law is sent without what the nozzle is said to hold.
#[test]
fn what_a_planned_law_grows_by_is_told() {
    for (source, told) in [(AdvanceSource::Planned, true), (AdvanceSource::Predicted, false)] {
        let learning = RawLearning { reach: 0.4, planned_reach: 0.4, slew_1_s: 5e-4, ..LEARNING };
        let mut advance =
            Advance::new(RawAdvance { source, learning, age_limit_s: 1e3, ..SETTINGS }, Level::Mpc);
        let word = Foretold { advance_s: 0.416, law: LAW, ..foretold() };
        advance.on_prediction(Prediction { stamp: Seconds(0.0), advance: Some(word), turn: None });
        let before = print_and_learn(&mut advance, (&stiff(), feed_m_s));
        let grown_m: f64 = (1..=500_u32)
            .map(|step| {
                let at_s = 200.0 + 0.02 * f64::from(step);
                let acting = Trims { advance_s: Some(0.5), ..Trims::NEUTRAL };
                let status = PrinterStatus { trims: acting, ..status(at_s, 2e-3) };
                advance.on_status(&status, Some(LAW), Nozzle::SOUND)
            })
            .sum();
        let expected_m = advance.with_learnt(LAW).held_m(2e-3) - before.held_m(2e-3);
        assert!(expected_m > 5e-6, "{expected_m}");
        let expected_m = if told { expected_m } else { 0.0 };
        assert!((grown_m - expected_m).abs() < 1e-9, "{grown_m} of {expected_m}");
    }
}

/// The melt's own law is learnt too where it is planned, no word of a predictor needed; not where one K is sent, nor where
/// nothing can slow the print. What a planned law holds more than the nominal one is force.
#[test]
fn a_planned_law_is_learnt_and_its_force() {
    let (advance, planned) = taught(AdvanceSource::Planned, Level::Mpc);
    assert!((planned - 1.2).abs() < 0.05, "{planned}");
    assert!((advance.stiffness() - planned).abs() < 1e-12);
    for (source, level) in [(AdvanceSource::Material, Level::Mpc), (AdvanceSource::Planned, Level::Encoder)] {
        let (advance, constant) = taught(source, level);
        assert!((constant - 1.0).abs() < 1e-12, "{constant}");
        assert!((advance.stiffness() - 1.0).abs() < 1e-12);
    }
}
