//! What is fed in addition for a slip.

use super::*;

/// A loop on an encoder that is silent would push on: it is open. Where none is fitted there is no loop, and what widths tell
/// of the slip is fed.
#[test]
fn without_an_encoder_the_extruder_loop_is_open() {
    let none_fitted = SHIPPED.replace("encoder_fitted: true ", "encoder_fitted: false ");
    for (text, width_alive, slip, expected) in [
        (SHIPPED, true, 0.01, None),
        (&none_fitted, false, 0.01, None),
        (&none_fitted, true, 0.01, Some(0.01)),
        (&none_fitted, true, -0.03, Some(0.0)),
    ] {
        let silent = |estimate| Estimate { encoder_alive: false, width_alive, slip, ..estimate };
        let sent = Rig::of(made_of(text, Level::Mpc)).run(4, silent);
        assert!(sent.iter().all(|trims| trims.slip == expected), "{sent:?}");
    }
}

/// The slip that widths tell of is fed in addition: the flow that it takes in the estimate is no error to correct once more.
#[test]
fn what_a_slip_by_widths_takes_is_made_up_for_once() {
    let none_fitted = SHIPPED.replace("encoder_fitted: true ", "encoder_fitted: false ");
    let thin = |width_alive| {
        move |estimate| Estimate {
            encoder_alive: false,
            width_alive,
            slip: 0.1,
            flow_m_s: 0.9 * FEED_M_S,
            ..estimate
        }
    };
    for (width_alive, corrects) in [(true, false), (false, true)] {
        let sent = Rig::of(made_of(&none_fitted, Level::Mpc)).run(399, thin(width_alive));
        let most = sent.iter().map(|trims| (trims.flow - 1.0).abs()).fold(0.0, f64::max);
        assert_eq!(most > 0.01, corrects, "{most}");
    }
}

/// 1 % that is told, and from 5 s on 2 % more that only the count shows: the melt's lack is fed, and what is learned of it.
#[test]
fn a_host_without_a_loop_gets_what_the_melt_lacks_as_slip() {
    let mut controller = controller(Level::Encoder);
    let (mut sent, mut before) = (Trims::NEUTRAL, Vec::new());
    for step in 1..200 {
        let now_s = f64::from(step) * 0.05;
        let status = PrinterStatus { host: HostProfile::Serial, ..status(now_s, FEED_M_S * now_s, sent) };
        controller.on_event(Event::Printer(status));
        let lost_m = 0.02 * FEED_M_S * (now_s - 5.0).max(0.0);
        controller.on_event(Event::Encoder { stamp: Seconds(now_s), position_m: FEED_M_S * now_s - lost_m });
        sent = controller.on_event(Event::Estimate(estimate(now_s))).map_or(sent, |command| command.trims);
        before.extend(sent.slip.filter(|_| now_s < 5.0));
    }
    assert!(before.len() > 90 && before.iter().all(|slip| (slip - 0.01).abs() < 3e-3), "{before:?}");
    assert!((0.03..0.08).contains(&sent.slip.unwrap()), "{:?}", sent.slip);
}
