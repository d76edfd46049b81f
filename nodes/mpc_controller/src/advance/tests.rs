//! Laws of the advance that is sent.

use super::*;
use crate::params::RawLearning;
use models::command::{AdvanceLaw, Trims};
use models::status::{HostProfile, JobPhase};
use models::units::Celsius;

pub(super) const LEARNING: RawLearning = RawLearning {
    reach: 0.0,
    planned_reach: 0.0,
    index_reach: 0.0,
    narrowed_reach: 0.0,
    slew_1_s: 0.003,
    width_noise: 0.1,
    frames: 200.0,
    settle_s: 1.0,
    calm_s: 0.06,
    pairing_s: 0.03,
    lever_min: 0.1,
    lever_max: 0.6,
    error_max: 0.5,
};

pub(super) const SETTINGS: RawAdvance = RawAdvance {
    source: AdvanceSource::Predicted,
    age_limit_s: 5.0,
    schedule_validity_s: 5.0,
    doubt_max: 0.3,
    low_s: 0.0,
    high_s: 1.5,
    law_high_s: 2.5,
    law_feed_m_s: 2e-3,
    straight_slew_s_s: 0.02,
    turn_slew_s_s: 0.3,
    turn_lead_s: 0.5,
    learning: LEARNING,
};

const NOMINAL_S: f64 = 0.63;

/// A printer at 50 mm/s that lays a road where there is feed.
pub(crate) fn status(stamp_s: f64, feed_m_s: f64) -> PrinterStatus {
    let laid = feed_m_s > 0.0;
    PrinterStatus {
        stamp: Seconds(stamp_s),
        phase: JobPhase::Printing,
        host: HostProfile::Native,
        progress: 0.5,
        layer: Some(3),
        line: 100,
        position_m: [0.1, 0.1, 1e-3],
        path_time_s: stamp_s,
        path_speed_m_s: 0.05,
        planned_speed_m_s: 0.05,
        planned_feed_m_s: feed_m_s,
        motor_position_m: 0.0,
        wanted_position_m: 0.0,
        depositing: laid,
        target_width_m: laid.then_some(4.5e-4),
        layer_height_m: laid.then_some(2e-4),
        hotend_target: Celsius(215.0),
        hotend_sliced_target: Celsius(215.0),
        bed_target: Celsius(60.0),
        hotend_duty: 0.5,
        bed_duty: 0.2,
        fan: 1.0,
        trims: Trims::NEUTRAL,
        advance_s: 0.5,
        homed: true,
        mains_on: true,
        filament_present: Some(true),
        part_fan_speed_1_s: None,
        stop_input: None,
    }
}

const LAW: AdvanceLaw = AdvanceLaw { linear_s: 0.4, shear: 1e-3, index: 0.5 };

fn word(stamp_s: f64, advance_s: f64, turn: Option<Turn>) -> Prediction {
    let advance = Some(Foretold { advance_s, half_width_s: 0.02, law: LAW, basis: Basis::Network });
    Prediction { stamp: Seconds(stamp_s), advance, turn }
}

const COMING: Option<Turn> = Some(Turn { probability: 0.9, expected: true, lead: Seconds(0.2) });

fn sent(advance: &mut Advance, now_s: f64) -> Option<f64> {
    advance.command(now_s, &status(now_s, 2e-3), NOMINAL_S)
}

fn holding(advance_s: f64) -> Advance {
    let mut advance = Advance::new(SETTINGS, Level::Mpc);
    advance.on_prediction(word(0.0, advance_s, None));
    assert_eq!(sent(&mut advance, 0.0), Some(advance_s));
    advance
}

#[test]
fn without_a_word_the_files_own_advance_stays() {
    let mut advance = Advance::new(SETTINGS, Level::Mpc);
    assert_eq!(sent(&mut advance, 0.0), None);
    assert_eq!(advance.report().without, 1);
}

/// The material's constant is held to what may be sent, as a foretold one is.
#[test]
fn the_materials_constant_is_within_its_bounds() {
    for source in [AdvanceSource::Material, AdvanceSource::Planned] {
        for (nominal_s, expected_s) in [(0.63, 0.63), (2.0, SETTINGS.high_s)] {
            let mut advance = Advance::new(RawAdvance { source, ..SETTINGS }, Level::Mpc);
            assert_eq!(advance.command(0.0, &status(0.0, 2e-3), nominal_s), Some(expected_s));
        }
    }
}

/// Silence is neutral: 5 s after the last word the file's own advance is back.
#[test]
fn a_stale_word_is_not_used() {
    let mut advance = holding(0.6);
    assert_eq!(sent(&mut advance, 5.0), Some(0.6));
    assert_eq!(sent(&mut advance, 5.05), None);
}

/// A half width of 0.2 s on 0.6 s is a third; 0.3 is allowed.
#[test]
fn a_doubtful_word_is_not_used() {
    let mut advance = Advance::new(SETTINGS, Level::Mpc);
    let doubtful = Foretold { advance_s: 0.6, half_width_s: 0.2, law: LAW, basis: Basis::Physics };
    advance.on_prediction(Prediction { advance: Some(doubtful), ..word(0.0, 0.6, None) });
    assert_eq!(sent(&mut advance, 0.0), None);
    assert_eq!(advance.law(0.0), None);
}

/// A coming move gets the law as it was foretold while nothing was learnt; a stale one is not attached.
#[test]
fn a_coming_move_gets_the_foretold_law() {
    let advance = holding(0.6);
    assert_eq!(advance.law(5.0), Some(LAW));
    assert_eq!(advance.law(5.05), None);
}

#[test]
fn what_is_sent_is_bounded() {
    let mut advance = Advance::new(SETTINGS, Level::Mpc);
    advance.on_prediction(word(0.0, 4.0, None));
    assert_eq!(sent(&mut advance, 0.0), Some(1.5));
}

/// `LAW` has 0.4 + 1e-3 / sqrt(2e-3) s at 2 mm/s.
#[test]
fn the_law_of_a_coming_move_is_bounded() {
    let at_s = 0.4 + 1e-3 / 2e-3_f64.sqrt();
    let mut advance = Advance::new(SETTINGS, Level::Mpc);
    let kept = LAW.scaled(2.49 / at_s);
    assert_eq!((advance.bound(kept), advance.report().bounded), (1.0, 0));
    assert!((advance.bound(LAW.scaled(5.0 / at_s)) - 0.5).abs() < 1e-12);
    assert_eq!(advance.report().bounded, 1);
}

/// 0.02 s/s over 50 ms is 1 ms.
#[test]
fn a_change_on_a_straight_is_slow() {
    let mut advance = holding(0.6);
    advance.on_prediction(word(0.0, 0.7, None));
    let next_s = sent(&mut advance, 0.05).unwrap();
    assert!((next_s - 0.601).abs() < 1e-12, "{next_s}");
    assert_eq!(advance.report().hurried, 0);
}

/// 0.3 s/s over 50 ms is 15 ms: a change of 45 ms is over 150 ms after the turn was told, 50 ms before it begins.
#[test]
fn a_change_is_over_before_a_foreseen_turn() {
    let mut advance = holding(0.6);
    advance.on_prediction(word(0.0, 0.645, COMING));
    let last_s = (1..=3).filter_map(|step| sent(&mut advance, 0.05 * f64::from(step))).last().unwrap();
    assert!((last_s - 0.645).abs() < 1e-12, "{last_s}");
    assert_eq!(advance.report().hurried, 3);
}

/// 0.02 s/s over 50 ms is 1 ms: past the turn, 0.2 s after a word that told it for then, and 2 s before one.
#[test]
fn past_a_turn_and_long_before_one_a_change_is_slow() {
    let far = Some(Turn { lead: Seconds(2.0), ..COMING.unwrap() });
    for (told_s, turn, expected_s) in [(0.0, COMING, 0.601), (0.25, far, 0.601), (0.25, COMING, 0.615)] {
        let mut advance = holding(0.6);
        assert_eq!(sent(&mut advance, 0.25), Some(0.6));
        advance.on_prediction(word(told_s, 0.7, turn));
        let next_s = sent(&mut advance, 0.3).unwrap();
        assert!((next_s - expected_s).abs() < 1e-12, "{told_s} {turn:?}: {next_s}");
        assert_eq!(advance.report().hurried, u64::from(expected_s > 0.61));
    }
}

/// `K_A v` with `v = 0` holds nothing: no filament moves.
#[test]
fn where_nothing_is_laid_a_change_is_at_once() {
    let mut advance = holding(0.6);
    advance.on_prediction(word(0.0, 0.9, None));
    assert_eq!(advance.command(0.05, &status(0.05, 0.0), NOMINAL_S), Some(0.9));
}

#[test]
fn other_sources_ask_no_predictor() {
    let of = |source| {
        let mut advance = Advance::new(RawAdvance { source, ..SETTINGS }, Level::Mpc);
        advance.on_prediction(word(0.0, 0.9, None));
        sent(&mut advance, 0.0)
    };
    assert_eq!(of(AdvanceSource::None), Some(0.0));
    assert_eq!(of(AdvanceSource::File), None);
    assert_eq!(of(AdvanceSource::Material), Some(NOMINAL_S));
}

/// Behind Moonraker and OctoPrint a change acts too late for the road that it was meant for: the constant, and no change.
#[test]
fn a_host_that_attaches_nothing_to_moves_gets_the_constant() {
    for (host, expected_s) in [
        (HostProfile::Native, 0.9),
        (HostProfile::Serial, 0.9),
        (HostProfile::Moonraker, NOMINAL_S),
        (HostProfile::Octoprint, NOMINAL_S),
    ] {
        let mut advance = Advance::new(SETTINGS, Level::Mpc);
        advance.on_prediction(word(0.0, 0.9, None));
        let status = PrinterStatus { host, ..status(0.0, 2e-3) };
        assert_eq!(advance.command(0.0, &status, NOMINAL_S), Some(expected_s), "{host:?}");
    }
}

#[test]
fn words_that_are_no_numbers_are_invalid() {
    let foretold =
        |advance_s, half_width_s| Foretold { advance_s, half_width_s, law: LAW, basis: Basis::Network };
    let still = Foretold { law: AdvanceLaw { index: 0.0, ..LAW }, ..foretold(0.6, 0.1) };
    for bad in [foretold(f64::NAN, 0.0), foretold(-0.1, 0.0), foretold(0.6, f64::INFINITY), still] {
        assert!(!Prediction { advance: Some(bad), ..word(0.0, 0.6, None) }.is_valid());
    }
    assert!(!word(f64::NAN, 0.6, None).is_valid());
    assert!(!word(0.0, 0.6, Some(Turn { probability: 1.1, ..COMING.unwrap() })).is_valid());
    assert!(word(0.0, 0.6, COMING).is_valid());
}

/// What is told of the source is what is sent.
#[test]
fn a_source_that_a_level_or_a_host_cannot_have_in_force_is_told_as_what_is() {
    use AdvanceSource::{File, Material, None, Planned, Predicted};
    use HostProfile::{Moonraker, Native, Octoprint, Serial};
    for source in [None, File, Material, Planned, Predicted] {
        assert_eq!(source.in_force(Level::Off, Native), File, "{source:?}");
        for host in [Native, Serial] {
            assert_eq!(source.in_force(Level::Mpc, host), source, "{host:?}");
        }
        for host in [Moonraker, Octoprint] {
            let told = if matches!(source, Planned | Predicted) { Material } else { source };
            assert_eq!(source.in_force(Level::Encoder, host), told, "{source:?} {host:?}");
        }
    }
}

impl Advance {
    /// Frames that the learning has taken in, older ones for less.
    pub(crate) fn frames_learnt(&self) -> f64 {
        self.learning.frames()
    }
}
