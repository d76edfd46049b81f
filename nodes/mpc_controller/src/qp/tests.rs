use super::*;
use proptest::prelude::*;

pub(crate) const COST: RawCost = RawCost {
    width_scale: 0.05,
    temperature_scale_k: 5.0,
    temperature_weight: 0.3,
    speed_scale: 0.2,
    feed_scale: 0.6,
    setpoint_weight_1_k2: 0.02,
    change_weight: 0.3,
    feed_change: 0.05,
    speed_change: 0.04,
    setpoint_change_k: 2.0,
};

pub(crate) const LIMITS: RawLimits = RawLimits {
    feed: 0.25,
    speed_low: -0.30,
    speed_high: 0.15,
    setpoint_k: 10.0,
    feed_rate: 0.06,
    speed_rate: 0.05,
    setpoint_rate_k: 1.0,
    force_margin: 0.8,
};

fn problem() -> Qp {
    problem_with(12, 60)
}

fn problem_with(guesses: u32, iterations: u32) -> Qp {
    let lags = Lags { period_s: 0.25, horizon: 16, flow_s: 0.63, thermal_s: 12.0 };
    Qp::new(COST, LIMITS, lags, RawSolver { guesses, iterations, time_limit_s: f64::INFINITY }).unwrap()
}

const REST: Start =
    Start { flow: 0.0, temperature_k: 0.0, gain: 0.0, last: [0.0; 3], feed_cap: None, width_ratio: 1.09 };

/// Golden vectors `mpc_step-1..5`, tolerance 2e-4 + 1e-3 of the value, by guess and by interior point.
#[test]
fn first_moves_agree_with_the_reference() {
    for (start, expected) in [
        (REST, [0.0, 0.0, 0.0]),
        (Start { gain: 0.03, ..REST }, [-0.017_040_96, 0.016_882_54, 0.0]),
        (Start { flow: -0.09, ..REST }, [0.021_234_08, -0.035_014_26, 0.0]),
        (Start { temperature_k: -6.0, ..REST }, [0.0, 0.0, 0.308_911_54]),
        (
            Start { gain: -0.4, last: [0.2, -0.25, 0.0], feed_cap: Some(0.22), ..REST },
            [0.22, -0.288_234_96, 0.0],
        ),
    ] {
        let expected: Move = expected;
        for (guesses, by_guess) in [(12, true), (0, false)] {
            let mut qp = problem_with(guesses, 60);
            let (got, outcome) = qp.solve(&start);
            assert!(
                matches!(outcome, Outcome::Solved { iterations } if (iterations == 0) == by_guess),
                "{outcome:?}"
            );
            for index in 0..input::COUNT {
                let tolerance = 2e-4 + 1e-3 * expected[index].abs();
                assert!((got[index] - expected[index]).abs() <= tolerance, "{got:?} for {expected:?}");
            }
        }
    }
}

#[test]
fn a_wide_road_gives_less_feed_and_more_speed() {
    let ([feed, speed, _], _) = problem().solve(&Start { gain: 0.05, ..REST });
    assert!(feed < 0.0 && speed > 0.0);
}

/// K3: NaN that comes in, and infinity that only arises inside.
#[test]
fn with_what_is_not_finite_the_plan_is_discarded() {
    for poison in [Start { flow: f64::NAN, ..REST }, Start { gain: f64::MAX, ..REST }] {
        let mut qp = problem();
        qp.solve(&Start { gain: 0.1, ..REST });
        let last = qp.plan()[0];
        assert!(last[input::FEED].abs() > 0.01);
        let (got, outcome) = qp.solve(&Start { last, ..poison });
        assert_eq!(outcome, Outcome::NotFinite);
        assert!(qp.plan().iter().flatten().all(|part| *part == 0.0));
        for index in 0..input::COUNT {
            let expected = (last[index].abs() - LIMITS.rate()[index]).max(0.0);
            assert!((got[index].abs() - expected).abs() < 1e-12, "back at the rates");
        }
        let (_, outcome) = qp.solve(&Start { gain: 0.1, last: got, ..REST });
        assert!(
            matches!(outcome, Outcome::Solved { .. }),
            "one poisoned start leaves nothing behind: {outcome:?}"
        );
    }
}

/// K1: a ceiling out of the rates' reach gives way, is counted, and only without softening has no solution.
#[test]
fn a_ceiling_out_of_reach_gives_way_or_has_no_solution() {
    let low = Start { feed_cap: Some(-0.2), last: [0.1, 0.0, 0.0], ..REST };
    let mut qp = problem();
    let (got, outcome) = qp.solve(&low);
    assert!(matches!(outcome, Outcome::Solved { .. }) && qp.softened() == 1, "{outcome:?}");
    assert!((got[input::FEED] - 0.04).abs() < 1e-9, "as far down as a period allows: {got:?}");
    let mut hard = problem().with_softening(false);
    let (got, outcome) = hard.solve(&low);
    assert_eq!((outcome, hard.softened()), (Outcome::Infeasible, 0));
    assert!(
        (got[input::FEED] - 0.04).abs() < 1e-9,
        "held, but under the ceiling as far as the rates go: {got:?}"
    );
    let (_, outcome) = hard.solve(&Start { feed_cap: Some(0.2), ..low });
    assert!(matches!(outcome, Outcome::Solved { .. }), "{outcome:?}");
}

#[test]
fn a_solve_that_ends_early_falls_back_on_the_shifted_plan() {
    let mut qp = problem_with(0, 1);
    let (got, outcome) = qp.solve(&Start { gain: 0.1, ..REST });
    assert_eq!(outcome, Outcome::Fallback(Cause::Iterations));
    assert!(got.iter().all(|part| part.abs() < 1e-12), "the plan so far: none");
    for (step, planned) in qp.plan.iter_mut().enumerate() {
        *planned = [0.01 * f64::from(u8::try_from(step).unwrap()), 0.0, 0.0];
    }
    for shifted in [0.01, 0.02, 0.03] {
        let (got, outcome) = qp.solve(&Start { gain: 0.1, ..REST });
        assert_eq!(outcome, Outcome::Fallback(Cause::Iterations));
        assert!((got[input::FEED] - shifted).abs() < 1e-12, "{got:?}");
    }
}

/// Starts as they occur are guessed but for a few.
#[test]
fn most_starts_need_no_interior_point() {
    let mut qp = problem();
    let wave = |index: i32, rate: f64, range: f64| range * (rate * f64::from(index)).sin();
    let guessed = (0..400).filter(|index| {
        let wave = |rate, range| wave(*index, rate, range);
        let last = [wave(2.3, 0.08), wave(0.5, 0.08), wave(1.3, 3.0)];
        let start = Start {
            flow: wave(1.1, 0.1),
            temperature_k: wave(0.7, 5.0),
            gain: wave(1.9, 0.06),
            last,
            ..REST
        };
        qp.solve(&start).1 == Outcome::Solved { iterations: 0 }
    });
    assert!(guessed.count() >= 390);
}

/// Model book 1.7 written down once more: what a plan costs from a start.
fn cost_of(plan: &[Move], start: &Start) -> f64 {
    let keep = |lag_s: f64| f64::exp(-0.25 / lag_s);
    let (keep_flow, keep_temperature) = (keep(0.63), keep(12.0));
    let (mut flow, mut temperature_k, mut last) = (start.flow, start.temperature_k, clamped(start.last));
    plan.iter().fold(0.0, |sum, moved| {
        let [feed, speed, setpoint_k] = *moved;
        flow = keep_flow * flow + (1.0 - keep_flow) * feed;
        temperature_k = keep_temperature * temperature_k + (1.0 - keep_temperature) * setpoint_k;
        let width = start.width_ratio * (flow + start.gain - speed);
        let changes = moved.iter().zip(last).zip(COST.change_weights());
        last = *moved;
        sum + (width / COST.width_scale).powi(2)
            + COST.temperature_weight * (temperature_k / COST.temperature_scale_k).powi(2)
            + (speed / COST.speed_scale).powi(2)
            + (feed / COST.feed_scale).powi(2)
            + COST.setpoint_weight_1_k2 * setpoint_k.powi(2)
            + changes.map(|((now, before), weight)| weight * (now - before).powi(2)).sum::<f64>()
    })
}

fn clamped(moved: Move) -> Move {
    std::array::from_fn(|index| moved[index].clamp(LIMITS.low()[index], LIMITS.high()[index]))
}

/// Bounds, rates and, where the rates reach it, the ceiling of the feed.
fn is_allowed(plan: &[Move], start: &Start) -> bool {
    let mut last = clamped(start.last);
    let mut reachable = last[input::FEED];
    plan.iter().all(|moved| {
        let within = (0..input::COUNT).all(|index| {
            let bounds = LIMITS.low()[index] - 1e-8..=LIMITS.high()[index] + 1e-8;
            bounds.contains(&moved[index])
                && (moved[index] - last[index]).abs() <= LIMITS.rate()[index] + 1e-8
        });
        last = *moved;
        reachable -= LIMITS.feed_rate;
        within && moved[input::FEED] <= start.feed_cap.unwrap_or(1.0).max(reachable).max(-LIMITS.feed) + 1e-8
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10_000))]

    /// A guess that proves itself is the interior point's plan, whatever was guessed before, on roads of any shape.
    #[test]
    fn a_proven_guess_is_the_optimum(
        (flow, temperature_k, gain) in (-0.4f64..0.4, -20.0f64..20.0, -0.3f64..0.3),
        last in (-0.3f64..0.3, -0.4f64..0.2, -12.0f64..12.0),
        feed_cap in prop::option::of(-0.3f64..0.3),
        width_ratio in 1.01f64..1.5,
    ) {
        thread_local!(static QP: std::cell::RefCell<[Qp; 2]> = [problem(), problem_with(0, 60)].into());
        let start = Start { flow, temperature_k, gain, last: [last.0, last.1, last.2], feed_cap, width_ratio };
        let plan_of = |qp: &mut Qp| (qp.solve(&start), qp.plan.clone());
        let [((_, outcome), guessed), ((_, exact), found)] = QP.with_borrow_mut(|qps| qps.each_mut().map(plan_of));
        prop_assert!(matches!(exact, Outcome::Solved { iterations } if iterations > 0), "{:?}", exact);
        let Outcome::Solved { iterations: 0 } = outcome else { return Ok(()) };
        // strictly convex: what is allowed and costs no more is the optimum
        prop_assert!(is_allowed(&guessed, &start), "{:?}", guessed);
        let (one, other) = (cost_of(&guessed, &start), cost_of(&found, &start));
        prop_assert!(one <= other * (1.0 + 1e-7) + 1e-9, "{} of {}", one, other);
    }

    /// Bounds and rates hold for any state, solved or not, also from a move outside of the bounds.
    #[test]
    fn bounds_and_rates_hold(
        (flow, temperature_k, gain) in (-2.0f64..2.0, -80.0f64..80.0, -0.9f64..2.0),
        last in (-0.3f64..0.3, -0.4f64..0.2, -12.0f64..12.0),
        feed_cap in prop::option::of(-1.0f64..1.0),
        width_ratio in 1.01f64..1.5,
    ) {
        thread_local!(static QP: std::cell::RefCell<Qp> = std::cell::RefCell::new(problem()));
        let start = Start { flow, temperature_k, gain, last: [last.0, last.1, last.2], feed_cap, width_ratio };
        let (got, outcome) = QP.with_borrow_mut(|qp| qp.solve(&start));
        prop_assert!(matches!(outcome, Outcome::Solved { .. }), "{:?}", outcome);
        let (low, high, rate) = (LIMITS.low(), LIMITS.high(), LIMITS.rate());
        for index in 0..input::COUNT {
            let last = start.last[index].clamp(low[index], high[index]);
            prop_assert!(got[index] >= low[index] && got[index] <= high[index]);
            prop_assert!((got[index] - last).abs() <= rate[index] + 1e-12);
        }
        if let Some(cap) = feed_cap {
            let last = start.last[input::FEED].clamp(low[0], high[0]);
            prop_assert!(got[input::FEED] <= cap.max(last - rate[0]).max(low[0]) + 1e-12);
        }
    }
}

/// The limit is one solve's: what was spent before it, in set-up or in thousands of solves, takes nothing of it.
#[test]
fn time_spent_before_a_solve_does_not_make_it_late() {
    let mut qp = problem_with(0, 60);
    let mut spent = Timers::default();
    spent.start_as_current("setup");
    std::thread::sleep(std::time::Duration::from_millis(1100));
    spent.stop_current();
    qp.solver.timers = Some(spent);
    let (_, outcome) = qp.solve(&Start { flow: -0.09, ..REST });
    assert!(matches!(outcome, Outcome::Solved { .. }), "{outcome:?}");
}
