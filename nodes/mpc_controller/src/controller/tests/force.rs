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
