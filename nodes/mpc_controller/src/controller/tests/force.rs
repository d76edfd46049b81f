//! The drive's ceiling.

use super::*;
use crate::advance::Advance;
use crate::advance::learning::tests::taught;
use crate::params::AdvanceSource;

/// What widths told of the melt counts for the drive's ceiling: a fifth more force than nominal, and the print is slowed where
/// nominally a tenth was to spare.
#[test]
fn a_melt_that_runs_stiffer_is_pushed_no_harder_but_slower() {
    let slowest = |advance: Option<Advance>| {
        let mut controller = controller(Level::Mpc);
        let (melt, ambient) = (&controller.printer.melt, Kelvin(controller.params.ambient_k));
        let spare = |kelvin: f64| {
            melt.flow_max_m3_s(Kelvin(kelvin), ambient, controller.params.limits.force_margin)
                / (FEED_M_S * melt.filament_area_m2())
        };
        let nozzle_k =
            (0..100).map(|step| NOZZLE_K - f64::from(step)).find(|kelvin| spare(*kelvin) < 1.1).unwrap();
        if let Some(advance) = advance {
            controller.advance = advance;
        }
        let mut rig = Rig::of(controller);
        let sent = rig.run(200, |estimate| Estimate { nozzle: Kelvin(nozzle_k), ..estimate });
        sent.iter().map(|trims| trims.speed).fold(1.0, f64::min)
    };
    let (stiffer, _) = taught(AdvanceSource::Planned, Level::Mpc);
    assert!(slowest(None) > 0.99, "{}", slowest(None));
    let slowed = slowest(Some(stiffer));
    assert!((0.7..0.95).contains(&slowed), "{slowed}");
}

/// A melt that runs softer than nominal is no reason to push harder: the drive's force is known, the softness learnt.
#[test]
fn a_melt_that_runs_softer_is_pushed_no_faster() {
    let controller = controller(Level::Mpc);
    let most = [0.5, 1.0, 1.2].map(|stiffness| controller.feed_max_at(&estimate(1.0), stiffness));
    assert!((most[0] / most[1] - 1.0).abs() < 1e-12 && most[2] < 0.95 * most[1], "{most:?}");
}

/// A slower path lays more filament on its way: no more than the feed may be trimmed by, whatever lacks.
#[test]
fn a_path_is_slowed_no_more_than_the_feed_allows() {
    let mut controller = controller(Level::Mpc);
    let (limits, band) = (controller.params.limits, controller.params.deadband);
    let feed = 0.8 * limits.feed;
    controller.held[FEED] = feed;
    for step in 0..40_u32 {
        let now_s = 1.0 + 0.05 * f64::from(step);
        controller.slowing.on_section(now_s, -0.3, 0.1, &band);
        controller.slow_down(&estimate(now_s), 0.05);
    }
    let laid = (1.0 + feed) / controller.slowing.factor();
    assert!((laid - (1.0 + limits.feed)).abs() < 1e-9, "{laid}");
}

/// A drive that rests has no flow to plan: an error over a feed of nothing is none.
#[test]
fn a_drive_that_rests_plans_nothing() {
    let mut controller = controller(Level::Mpc);
    let resting = |planned_feed_m_s| PrinterStatus { planned_feed_m_s, ..status(1.0, 0.0, Trims::NEUTRAL) };
    let plans =
        [FEED_M_S, 0.0, -1e-3].map(|feed_m_s| controller.start(&resting(feed_m_s), &estimate(1.0)).is_some());
    assert_eq!(plans, [true, false, false]);
}
