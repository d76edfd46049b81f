//! Random states, references and poisoned inputs: whatever comes in, what is sent stays within bounds and rates.

use super::*;
use models::motion::{MoveKind, Role, Segment, Trapezoid};

/// Numbers without an end, the same each time (Marsaglia's xorshift).
struct Dice(u64);

impl Dice {
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        f64::from(u32::try_from(self.0 >> 32).unwrap()) / f64::from(u32::MAX)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// One value in twenty is none that a sensor can have.
    fn poisoned(&mut self, value: f64) -> f64 {
        const POISON: [f64; 6] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -1.0e30, 0.0];
        if self.unit() > 0.05 {
            return value;
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0..6")]
        let index = (self.unit() * 5.99) as usize;
        POISON[index]
    }
}

fn rounds() -> u32 {
    std::env::var("FDM_CONTROL_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(5_000)
}

fn inside(trims: &Trims, params: &Params) {
    let limits = &params.limits;
    let within = |value: f64, low: f64, high: f64| (low - 1e-12..=high + 1e-12).contains(&value);
    assert!(trims.is_finite(), "{trims:?}");
    assert!(within(trims.flow, 1.0 - limits.feed, 1.0 + limits.feed), "{trims:?}");
    assert!(within(trims.speed, 1.0 + limits.speed_low, 1.0 + limits.speed_high), "{trims:?}");
    assert!(within(trims.setpoint_offset_k, -limits.setpoint_k, limits.setpoint_k), "{trims:?}");
    assert!(trims.slip.is_none_or(|slip| within(slip, params.slip.low, params.slip.high)), "{trims:?}");
    assert!(trims.advance_s.is_none_or(|k| within(k, 0.0, params.advance.high_s)), "{trims:?}");
}

/// Every event may move what is held by one period's rate, and no further; what is sent is inside of the bounds.
#[test]
fn every_command_is_within_bounds_and_rates() {
    let mut controller = controller(Level::Mpc);
    let params = controller.params;
    let mut dice = Dice(0x9E37_79B9_7F4A_7C15);
    let (mut sent, mut in_force, mut wanted_m) = (0_u32, Trims::NEUTRAL, 0.0);
    let mut planned = 0.0;
    for round in 0..rounds() {
        let now_s = 0.05 * f64::from(round + 1);
        wanted_m += FEED_M_S * 0.05;
        let width_m = dice.between(2e-4, 1e-3);
        let width_m = dice.poisoned(width_m);
        let reported = PrinterStatus {
            host: if dice.unit() < 0.5 { HostProfile::Native } else { HostProfile::Serial },
            planned_feed_m_s: dice.between(0.0, 0.02),
            planned_speed_m_s: dice.between(0.0, 0.3),
            target_width_m: Some(width_m),
            hotend_sliced_target: Celsius(dice.between(0.0, 300.0)),
            hotend_duty: dice.unit(),
            trims: Trims { flow: dice.poisoned(in_force.flow), ..in_force },
            ..status(now_s, wanted_m, in_force)
        };
        controller.on_event(Event::Printer(reported));
        let before = controller.held;
        let position_m = wanted_m * dice.between(0.5, 1.0);
        controller.on_event(Event::Encoder { stamp: Seconds(now_s), position_m: dice.poisoned(position_m) });
        let width_m = dice.between(0.0, 2e-3);
        controller.on_event(Event::Width { exposed: Seconds(now_s), width_m: dice.poisoned(width_m) });
        moved_by_a_rate(&before, &controller.held, &params);
        let nozzle_k = dice.between(250.0, 650.0);
        let nozzle_k = dice.poisoned(nozzle_k);
        let seen = Estimate {
            stamp: Seconds(now_s),
            nozzle: Kelvin(nozzle_k),
            flow_m_s: dice.between(0.0, 0.02),
            slip: dice.between(-1.0, 2.0),
            gain: dice.between(0.1, 4.0),
            reference_feed_m_s: dice.between(1e-5, 0.01),
            encoder_alive: dice.unit() < 0.8,
            width_alive: true,
        };
        let gain = dice.poisoned(seen.gain);
        if let Some(command) = controller.on_event(Event::Estimate(Estimate { gain, ..seen })) {
            inside(&command.trims, &params);
            // The path is slowed down beside the plan by what the plan's own moves leave of the rate.
            let (now, rate) = (controller.held[SPEED], params.limits.speed_rate);
            let by_plan = (now - std::mem::replace(&mut planned, now)).abs();
            let moved = (command.trims.speed - in_force.speed).abs();
            assert!(
                moved <= ((1.0 + params.limits.speed_high) * by_plan).max(rate) + 1e-9,
                "{in_force:?} -> {command:?}"
            );
            in_force = command.trims;
            sent += 1;
        }
        let before = controller.held;
        controller.on_event(Event::Tick { now: Seconds(dice.poisoned(now_s)) });
        moved_by_a_rate(&before, &controller.held, &params);
        valid_trims(&mut controller, &mut dice, (now_s, round));
    }
    assert!(sent > rounds() / 2, "{sent} commands: the storm must not have silenced the controller");
}

fn moved_by_a_rate(before: &Move, after: &Move, params: &Params) {
    for (index, rate) in params.limits.rate().into_iter().enumerate() {
        assert!((after[index] - before[index]).abs() <= rate + 1e-12, "{before:?} -> {after:?}");
    }
}

/// Of a coming move, and of those that are sent anew.
fn valid_trims(controller: &mut Controller, dice: &mut Dice, (now_s, round): (f64, u32)) {
    let start = Seconds(dice.poisoned(now_s));
    let coming = Coming { sequence: round.into(), start, segment: coming(dice) };
    let anew = controller.take_anew(Seconds(now_s));
    for trim in controller.on_coming(Seconds(now_s), &coming).into_iter().chain(anew) {
        assert!(trim.is_valid(), "{trim:?}");
    }
}

fn coming(dice: &mut Dice) -> Segment {
    let length_m = dice.between(1e-5, 0.2);
    Segment {
        line: 1,
        layer: Some(0),
        start_m: [0.0; 3],
        end_m: [length_m, 0.0, 0.0],
        length_m,
        filament_m: length_m * dice.between(0.0, 0.2),
        kind: MoveKind::Deposit,
        role: Role::Unknown,
        arc: false,
        target_width_m: Some(4.5e-4),
        stated_width_m: None,
        layer_height_m: Some(2e-4),
        profile: Trapezoid::new(length_m, (0.0, 0.0), dice.between(1e-3, 0.3), 0.5),
    }
}
