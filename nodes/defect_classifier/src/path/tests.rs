use super::*;
use proptest::prelude::*;

pub(crate) fn params() -> HistoryParams {
    HistoryParams::try_from(RawHistory {
        roads_max: 64,
        depth_m: 3e-4,
        moves_max: 64,
        statuses_max: 256,
        ahead_max_s: 0.1,
        disagreement_max_m: 5e-4,
    })
    .unwrap()
}

pub(crate) fn road(layer: u32, from_m: [f64; 2], to_m: [f64; 2]) -> Segment {
    let length_m = (to_m[0] - from_m[0]).hypot(to_m[1] - from_m[1]);
    let top_m = 2e-4 * f64::from(layer + 1);
    Segment {
        line: 1,
        layer: Some(layer),
        start_m: [from_m[0], from_m[1], top_m],
        end_m: [to_m[0], to_m[1], top_m],
        length_m,
        filament_m: 1e-3,
        kind: MoveKind::Deposit,
        role: Role::ExternalPerimeter,
        arc: false,
        target_width_m: Some(4.5e-4),
        stated_width_m: None,
        layer_height_m: Some(2e-4),
        profile: Trapezoid::new(length_m, (0.01, 0.01), 0.05, 1.0),
    }
}

/// A history that ran one road at half pace from 10 s on: its trapezoid takes twice its time.
fn at_half_pace() -> (PathHistory, Segment) {
    let mut history = PathHistory::new(params());
    let segment = road(0, [0.1, 0.1], [0.12, 0.1]);
    history.on_status(Seconds(9.98), 1.0, [0.1, 0.1, 0.0]);
    history.on_move(Seconds(10.0), &segment);
    for step in 0..60 {
        let stamp_s = 10.0 + 0.02 * f64::from(step);
        let path_s = 1.0 + 0.5 * (stamp_s - 10.0);
        let (place_m, _) = segment.at(Seconds(path_s - 1.0));
        history.on_status(Seconds(stamp_s), path_s, place_m);
    }
    (history, segment)
}

#[test]
fn a_speed_trim_moves_the_tool_as_the_status_says() {
    let (history, segment) = at_half_pace();
    let (place_m, velocity_m_s) = history.tool(Seconds(10.31)).unwrap();
    let (wanted_m, state) = segment.at(Seconds(0.155));
    assert!((place_m[0] - wanted_m[0]).abs() < 1e-9 && (place_m[1] - 0.1).abs() < 1e-12);
    assert!((velocity_m_s[0] - state.speed_m_s).abs() < 1e-9);
}

#[test]
fn when_and_where_a_stretch_was_laid_agree() {
    let (history, _) = at_half_pace();
    let road = *history.roads(Seconds(11.0)).next().unwrap();
    for at_s in [10.02, 10.2, 10.5, 10.8] {
        let way_m = history.laid_m(&road, Seconds(at_s));
        let back = history.laid_at(&road, way_m).unwrap();
        assert!((back.0 - at_s).abs() < 1e-6, "{at_s} s: {way_m} m, {} s", back.0);
    }
}

#[test]
fn a_tool_that_is_not_where_the_moves_say_has_no_place() {
    let (mut history, _) = at_half_pace();
    history.on_status(Seconds(11.2), 1.6, [0.2, 0.1, 0.0]);
    assert_eq!(history.tool(Seconds(11.2)), None);
}

#[test]
fn old_layers_and_old_roads_make_room() {
    let mut history = PathHistory::new(params());
    for layer in 0..6 {
        for line in 0..20_u32 {
            let y_m = 0.1 + 1e-3 * f64::from(line);
            history.on_move(Seconds(f64::from(layer * 20 + line)), &road(layer, [0.1, y_m], [0.12, y_m]));
        }
    }
    let layers: Vec<u32> = history.roads(Seconds(1e3)).map(|road| road.layer).collect();
    assert_eq!((layers.len(), layers[0], layers[39]), (40, 4, 5));
    let mut full = PathHistory::new(params());
    (0..100_u32).for_each(|line| full.on_move(Seconds(f64::from(line)), &road(0, [0.1, 0.1], [0.12, 0.1])));
    assert_eq!(full.len(), 64);
}

#[test]
fn what_is_out_of_order_is_refused_and_counted() {
    let (mut history, segment) = at_half_pace();
    history.on_move(Seconds(5.0), &segment);
    history.on_move(Seconds(f64::NAN), &segment);
    history.on_status(Seconds(3.0), 9.0, [0.0; 3]);
    assert_eq!((history.refused(), history.len()), (3, 1));
}

proptest! {
    #[test]
    fn time_at_a_way_inverts_the_trapezoid(
        length_m in 1e-4..0.1_f64, entry in 0.0..0.05_f64, exit in 0.0..0.05_f64, share in 0.0..1.0_f64,
    ) {
        let limit = 2.0_f64.mul_add(length_m, 0.0).sqrt();
        let profile = Trapezoid::new(length_m, (entry.min(limit), exit.min(limit)), 0.06, 1.0);
        let time_s = share * profile.duration().0;
        let way_m = profile.at(Seconds(time_s)).distance_m;
        // Near a standstill the way hardly depends on time: compare ways.
        let back_m = profile.at(Seconds(time_at(&profile, way_m))).distance_m;
        prop_assert!((back_m - way_m).abs() < 1e-9, "{} {}", way_m, back_m);
    }
}
