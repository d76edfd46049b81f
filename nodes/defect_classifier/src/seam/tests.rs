use super::*;
use crate::camera::tests::camera;
use crate::frame::tests::picture;
use crate::path::tests::{params as history, road};
use crate::width::params::tests::params as width;

const TOOL_M: [f64; 2] = [0.1, 0.1];
/// Distance of two walls of 0.45 mm in layers of 0.2 mm.
const PITCH_M: f64 = 4.07e-4;
/// Level of the crests in daylight.
const CREST: f64 = 150.0;

fn params() -> SeamParams {
    SeamParams::try_from(RawSeam {
        fresh_s: 4.0,
        pitch_rel: [0.6, 1.15],
        parallel_rad: 0.15,
        valley_m: 6e-5,
        crest_m: 3e-5,
        cell_m: 1e-3,
        cells_max: 1000,
        stations_min: 5,
        beside_m: 2e-5,
        beside_share: 0.05,
        layers_min: 3,
        rate: 0.2,
        depth_m: 2e-3,
        cells_min: 4,
        cell_sigma: 0.04,
        shared_sigma: [0.05, 0.03, 0.08],
        shared_rate: 0.05,
        learn_max_sigmas: 3.0,
        drift_slack_sigmas: 1.0,
        drift_max_sigmas: 8.0,
    })
    .unwrap()
}

/// A layer of a wall of two roads, and how it looks.
#[derive(Clone, Copy)]
struct Layer {
    number: u32,
    /// Bed y of the first road, and the second's distance from it `[m]`.
    roads_m: [f64; 2],
    /// Level in the seam over that of the crests.
    ratio: f64,
    light: f64,
    /// What a sound nozzle lays of the wanted flow.
    share: f64,
    /// The second road's move is told.
    told: bool,
}

impl Layer {
    fn sound(number: u32) -> Self {
        Self { number, roads_m: [0.104, PITCH_M], ratio: 0.8, light: 1.0, share: 1.0, told: true }
    }
}

struct Wall {
    path: PathHistory,
    gauge: SeamGauge,
}

impl Wall {
    fn new() -> Self {
        Self { path: PathHistory::new(history()), gauge: SeamGauge::new(params(), &width()) }
    }

    /// Lays a layer in 20 s, every other one the other way round, and takes one frame of it.
    fn lay(&mut self, layer: Layer) -> Option<SeamReading> {
        let begin_s = 10.0 + 20.0 * f64::from(layer.number);
        let [y_m, apart_m] = layer.roads_m;
        let ends_m = if layer.number.is_multiple_of(2) { [0.092, 0.108] } else { [0.108, 0.092] };
        for step in 0..150_u32 {
            let stamp_s = begin_s - 0.1 + 0.02 * f64::from(step);
            self.path.on_status(Seconds(stamp_s), stamp_s, [TOOL_M[0], TOOL_M[1], 0.0]);
            let beside_m = match step {
                5 => 0.0,
                55 if layer.told => apart_m,
                _ => continue,
            };
            let [from_m, to_m] = ends_m.map(|x_m| [x_m, y_m + beside_m]);
            self.path.on_move(Seconds(stamp_s), &road(layer.number, from_m, to_m));
        }
        let seam = camera().pixel(TOOL_M, [0.1, y_m + 0.5 * apart_m])[1];
        let grey = picture(640, 480, |_, v| {
            let valley = (f64::from(u32::try_from(v).unwrap()) - seam).abs() < 3.6;
            let level = layer.light * CREST * if valley { layer.ratio } else { 1.0 };
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a grey level")]
            let level = level.round() as u8;
            level
        });
        let view = (&camera(), TOOL_M);
        self.gauge.on_frame(&grey, (&self.path, Seconds(begin_s + 2.5)), view, |_| layer.share).unwrap()
    }

    /// A wall with five sound layers.
    fn known() -> Self {
        let mut wall = Self::new();
        for number in 0..5 {
            let reading = wall.lay(Layer::sound(number));
            assert_eq!(
                reading.is_some(),
                number >= 4,
                "three layers above the first have to be known: {number}"
            );
        }
        wall
    }
}

/// 0.5 instead of 0.8 on fourteen millimetres; grey levels are whole: 1/150.
#[test]
fn a_seam_is_told_beside_its_own_past_layer_after_layer() {
    let mut wall = Wall::known();
    for number in 5..20 {
        let reading = wall.lay(Layer { ratio: 0.5, ..Layer::sound(number) });
        // What lies ten layers below is too far down; until then the thin ones do not become usual.
        let told = reading.map(|reading| reading.shade);
        if number < 14 {
            assert!((told.unwrap() + 0.3).abs() < 0.01, "{number}: {told:?}");
            let reading = reading.unwrap();
            assert!(reading.cells >= 12 && reading.shade < -4.0 * reading.sigma, "{reading:?}");
        }
    }
}

/// Over the bed roads are wider and higher, and what shines through is another ground.
#[test]
fn the_first_layer_of_an_outline_is_not_learned() {
    let mut wall = Wall::new();
    wall.lay(Layer { ratio: 1.0, ..Layer::sound(0) });
    (1..4).for_each(|number| assert_eq!(wall.lay(Layer::sound(number)), None));
    let reading = wall.lay(Layer::sound(4)).unwrap();
    assert!(reading.shade.abs() < 0.01 && reading.drift_sigmas < 1e-9, "{reading:?}");
}

#[test]
fn brighter_or_darker_light_is_no_change() {
    let mut wall = Wall::known();
    for (number, light) in [(5, 0.6), (6, 1.4), (7, 0.8)] {
        let reading = wall.lay(Layer { light, ..Layer::sound(number) }).unwrap();
        assert!(reading.shade.abs() < 0.01, "{reading:?}");
    }
}

#[test]
fn where_roads_lie_otherwise_nothing_is_told() {
    for roads_m in [[0.104 + 1e-4, PITCH_M], [0.104, PITCH_M - 6e-5], [0.1047, PITCH_M]] {
        let mut wall = Wall::known();
        let moved = |number| Layer { roads_m, ratio: 0.5, ..Layer::sound(number) };
        assert_eq!(wall.lay(moved(5)), None, "{roads_m:?}");
        // The new places have to become known themselves.
        assert_eq!([6, 7, 8].map(|number| wall.lay(moved(number))), [None; 3]);
        assert!(wall.lay(moved(9)).unwrap().shade.abs() < 0.01);
    }
}

/// A stream that was silent leaves roads out: a seam needs both of its own.
#[test]
fn a_road_that_was_not_told_makes_no_seam() {
    let mut wall = Wall::known();
    assert_eq!(wall.lay(Layer { told: false, ratio: 0.5, ..Layer::sound(5) }), None);
    assert!(wall.lay(Layer::sound(6)).unwrap().shade.abs() < 0.01);
}

#[test]
fn after_a_new_print_begins_the_past_is_another_part() {
    let mut wall = Wall::known();
    wall.gauge.clear();
    assert_eq!(wall.lay(Layer { ratio: 0.5, ..Layer::sound(5) }), None);
}

/// Each reading by itself is one that a sound print may show; `S` is then 1.5 a layer.
#[test]
fn what_one_reading_hides_many_tell_and_it_does_not_become_usual() {
    let mut wall = Wall::known();
    let mut drifts = vec![];
    for number in 5..12 {
        // About two standard deviations.
        let reading = wall.lay(Layer { ratio: 0.8 - 0.14, ..Layer::sound(number) }).unwrap();
        let sigmas = reading.shade / reading.sigma;
        assert!((-3.0..-1.8).contains(&sigmas), "{sigmas}");
        drifts.push(reading.drift_sigmas);
    }
    assert!(drifts.windows(2).all(|pair| pair[1] > pair[0] || pair[1] >= 8.0), "{drifts:?}");
    assert!(drifts[0] < 2.0 && drifts[6] > 4.0, "{drifts:?}");
    // Sound layers take back one a reading, a pause takes back all.
    let after = wall.lay(Layer::sound(12)).unwrap().drift_sigmas;
    assert!(after < drifts[6] && after > 2.0, "{after}");
    wall.gauge.forget_drift();
    assert!(wall.lay(Layer::sound(13)).unwrap().drift_sigmas < 1e-9);
}

#[test]
fn darker_and_brighter_by_turns_is_no_drift() {
    let mut wall = Wall::known();
    for number in 5..12 {
        let change = if number % 2 == 0 { 0.08 } else { -0.08 };
        let reading = wall.lay(Layer { ratio: 0.8 + change, ..Layer::sound(number) }).unwrap();
        assert!(reading.drift_sigmas < 2.0, "{number}: {reading:?}");
    }
}

#[test]
fn a_value_out_of_range_is_refused_by_name() {
    let refused = |raw: RawSeam| SeamParams::try_from(raw).unwrap_err().to_string();
    assert!(refused(RawSeam { rate: f64::NAN, ..*params() }).starts_with("seam.rate = NaN"));
    assert!(refused(RawSeam { shared_sigma: [0.1, 0.03, 0.08], ..*params() }).contains("shared_sigma"));
    assert!(refused(RawSeam { drift_slack_sigmas: 3.5, ..*params() }).contains("drift_slack_sigmas"));
    assert!(refused(RawSeam { drift_max_sigmas: 2.0, ..*params() }).contains("drift_max_sigmas"));
}

/// Where no advance is in force roads are thin after a start: a layer that starts elsewhere is not compared.
#[test]
fn where_a_sound_nozzle_lays_less_nothing_is_told() {
    let mut wall = Wall::known();
    assert!(wall.lay(Layer { ratio: 0.5, share: 0.85, ..Layer::sound(5) }).is_none());
    let mut wall = Wall::known();
    assert!(wall.lay(Layer { ratio: 0.5, share: 0.97, ..Layer::sound(5) }).is_some());
}
