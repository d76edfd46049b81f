//! What a sound nozzle lays of the wanted flow goes into what is said of widths and seams.

use super::*;
use crate::width::Facing;
use models::motion::Segment;

/// Below the camera in every frame `[m]`.
const TOOL_M: [f64; 2] = [0.1, 0.1];
/// Feed of the filament before and after it doubles `[m/s]`.
const FEEDS_M_S: [f64; 2] = [1e-3, 2e-3];
/// Bed y of the first of two roads, and the second's distance from it `[m]`.
const ROADS_M: [f64; 2] = [0.104, 4.07e-4];
/// A layer lasts so long `[s]`.
const LAYER_S: f64 = 20.0;

/// A print whose statuses come at 50 Hz, and the filament that it has wanted.
struct Fed {
    brain: Classifier,
    /// Statuses so far.
    told: u32,
    wanted_m: f64,
}

impl Fed {
    fn new() -> Self {
        Self { brain: classifier(), told: 0, wanted_m: 0.0 }
    }

    fn now_s(&self) -> f64 {
        0.02 * f64::from(self.told)
    }

    /// Feeds on for some time.
    fn feed(&mut self, layer: u32, feed_m_s: f64, time_s: f64) {
        let end_s = self.now_s() + time_s;
        while self.now_s() < end_s - 1e-9 {
            self.told += 1;
            self.wanted_m += 0.02 * feed_m_s;
            let status = PrinterStatus {
                planned_feed_m_s: feed_m_s,
                wanted_position_m: self.wanted_m,
                position_m: [TOOL_M[0], TOOL_M[1], 0.0],
                ..printer_status(self.now_s(), JobPhase::Printing, layer)
            };
            self.brain.on_event(Event::Printer(Box::new(status)));
        }
    }

    /// Share of a sound nozzle at a moment of the past.
    fn share(&self, laid_s: f64) -> f64 {
        self.brain.nozzle.share(Seconds(laid_s), None)
    }

    fn lay(&mut self, layer: u32, ends_m: [f64; 2], y_m: f64) {
        let [from_m, to_m] = ends_m.map(|x_m| [x_m, y_m]);
        let segment = Segment { filament_m: 6e-4, ..road(layer, from_m, to_m) };
        let (start, path_s) = (Seconds(self.now_s()), self.now_s());
        self.brain.on_event(Event::Motion { start, path_s, segment: Box::new(segment) });
    }
}

/// What is said after six looks at roads of this ratio to the wanted width, laid from 0.06 s after the feed has doubled
/// on, or before; `ratio` is told what a sound nozzle lays.
fn cause(fresh: bool, ratio: impl Fn(f64) -> f64) -> String {
    let mut print = Fed::new();
    print.feed(0, FEEDS_M_S[0], 9.0);
    print.feed(0, FEEDS_M_S[1], 1.0);
    let grey = picture(640, 480, |u, v| if (u / 40 + v / 40) % 2 == 0 { 60 } else { 160 });
    let begin_s = if fresh { 9.06 } else { 8.06 };
    // The first of a print opens the time in which pressure builds up, the others come after it.
    let laid = std::iter::once(4.0).chain((0..6).map(|number| begin_s + 0.02 * f64::from(number)));
    let mut said = None;
    for (number, laid_s) in laid.enumerate() {
        let width = WidthMeasurement {
            laid: Seconds(laid_s),
            width_m: 4.5e-4 * if number == 0 { 1.0 } else { ratio(print.share(laid_s)) },
            sigma_m: 1e-5,
            wanted_m: 4.5e-4,
            height_m: 2e-4,
            facing: Facing::numbered(0),
            pieces: 3,
        };
        let found =
            Found { width: Some(width), seen: Seen::default(), seams: None, offset: None, unexplained: None };
        said = print.brain.judge(&grey, Seconds(laid_s + 0.5), &found).ok();
    }
    said.unwrap().fused.cause
}

/// After a step of the feed a sound nozzle lays 0.6 to 0.85 of it: a road of that width is as good as one of the full
/// width at rest, and one of the full width is too wide.
#[test]
fn a_road_as_thin_as_a_sound_nozzle_lays_it_is_no_thin_road() {
    let at_rest = |share: f64| {
        assert!((share - 1.0).abs() < 0.01, "{share}");
        share
    };
    let after_a_step = |share: f64| {
        assert!((0.6..0.85).contains(&share), "{share}");
        share
    };
    assert_eq!([cause(false, at_rest), cause(true, after_a_step)], ["ok", "ok"]);
    assert_eq!([cause(false, |_| 0.7), cause(true, |_| 1.0)], ["under", "over"]);
}

/// Lays a layer of two roads beside each other at a feed each, and looks at the seam, this much as bright as the crests.
fn seam_of(print: &mut Fed, layer: u32, feeds_m_s: [f64; 2], ratio: f64) -> Option<SeamReading> {
    let ends_m = if layer.is_multiple_of(2) { [0.092, 0.108] } else { [0.108, 0.092] };
    let [y_m, apart_m] = ROADS_M;
    print.lay(layer, ends_m, y_m);
    print.feed(layer, feeds_m_s[0], 1.0);
    print.lay(layer, ends_m, y_m + apart_m);
    print.feed(layer, feeds_m_s[1], 1.5);
    let seam = print.brain.params.camera.pixel(TOOL_M, [TOOL_M[0], y_m + 0.5 * apart_m])[1];
    let grey = picture(640, 480, |_, v| {
        let in_seam = (f64::from(u32::try_from(v).unwrap()) - seam).abs() < 3.6;
        let level = 150.0 * if in_seam { ratio } else { 1.0 };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a grey level")]
        let level = level.round() as u8;
        level
    });
    let exposed = Seconds(print.now_s());
    let found = print.brain.measure(&grey, exposed, TOOL_M).unwrap();
    print.feed(layer, FEEDS_M_S[0], LAYER_S - 2.5);
    found.seams
}

/// A wall of five layers at one feed, then a sixth whose second road is laid at the given feeds.
fn sixth_layer(feeds_m_s: [f64; 2]) -> Option<SeamReading> {
    let mut print = Fed::new();
    print.feed(0, FEEDS_M_S[0], LAYER_S);
    for layer in 0..5 {
        let reading = seam_of(&mut print, layer, [FEEDS_M_S[0]; 2], 0.8);
        assert_eq!(
            reading.is_some(),
            layer == 4,
            "three layers above the first have to be known: {layer} {reading:?}"
        );
    }
    seam_of(&mut print, 5, feeds_m_s, 0.5)
}

/// Where a sound nozzle lays less than on the layers below seams are not compared; at the same feed a dark one is told.
#[test]
fn a_seam_where_a_sound_nozzle_lays_less_is_not_compared() {
    let dark = sixth_layer([FEEDS_M_S[0]; 2]).unwrap();
    assert!((dark.shade + 0.3).abs() < 0.01, "{dark:?}");
    assert_eq!(sixth_layer(FEEDS_M_S), None);
}
