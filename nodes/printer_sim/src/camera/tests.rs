//! Laws of the camera: what is laid, where it is seen, what the same seed gives.

use super::*;
use models::bead::stadium;
use models::units::Seconds;
use serde::Deserialize;
use std::collections::BTreeMap;

const WIDTH_M: f64 = 4.5e-4;
const HEIGHT_M: f64 = 2.0e-4;
const BEAD: Bead = Bead { top_m: HEIGHT_M, width_m: WIDTH_M, height_m: HEIGHT_M };

#[derive(Deserialize)]
struct Node {
    #[serde(rename = "ros__parameters")]
    parameters: Blocks,
}

#[derive(Deserialize)]
struct Blocks {
    camera: CameraParams,
}

pub(crate) fn params() -> CameraParams {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/printer_sim.param.yaml");
    let mut nodes: BTreeMap<String, Node> =
        serde_saphyr::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    nodes.remove("/**").unwrap().parameters.camera
}

/// A camera without noise, texture and vignetting, so that pictures differ by what lies on the bed alone.
fn plain(mut params: CameraParams) -> CameraParams {
    let none = Span { low: 0.0, high: 0.0 };
    let style = &mut params.test;
    (style.noise_grey, style.noise_share, style.vignette) = (none, none, none);
    (style.filament_grain, style.bed_texture, style.exposure_s) = (none, none, none);
    style.blur_px = Span { low: 0.5, high: 0.5 };
    params
}

fn bed() -> Deposit {
    let params = params();
    Deposit::new(params.field, params.geometry.scale_m())
}

/// Cells across a road at `y_m` that stand over `floor_m`.
fn standing(deposit: &Deposit, (from_m, to_m): (f64, f64), y_m: f64, floor_m: f64) -> f64 {
    let cell_m = deposit.cell_m();
    let mut at_m = from_m;
    let mut wide_m = 0.0;
    while at_m < to_m {
        wide_m += if deposit.height_m([at_m, y_m]) > floor_m { cell_m } else { 0.0 };
        at_m += cell_m;
    }
    wide_m
}

#[test]
fn the_nozzle_is_at_the_principal_point_and_image_y_runs_against_bed_y() {
    let geometry = params().geometry;
    let tool_m = [0.11, 0.09];
    let [cx, cy] = geometry.principal_px();
    let [u, v] = geometry.pixel_from_bed(tool_m, tool_m);
    assert!((u - cx).abs() < 1e-12 && (v - cy).abs() < 1e-12);
    assert!((geometry.focal_px() * geometry.scale_m() - geometry.working_distance_m()).abs() < 1e-12);
    let [u, v] = geometry.pixel_from_bed(tool_m, [0.113, 0.0915]);
    // 3 mm and 1.5 mm at 30 um a pixel.
    assert!((u - cx - 100.0).abs() < 1e-6 && (v - cy + 50.0).abs() < 1e-6);
    let back = geometry.bed_from_pixel(tool_m, [u, v]);
    assert!((back[0] - 0.113).abs() < 1e-12 && (back[1] - 0.0915).abs() < 1e-12);
}

#[test]
fn a_road_stands_as_wide_and_as_high_as_its_volume_says() {
    let mut deposit = bed();
    deposit.lay([0.05, 0.05], [0.05, 0.06], BEAD);
    let (wide_m, crest_m) =
        (standing(&deposit, (0.049, 0.051), 0.055, 0.0), deposit.height_m([0.050_005, 0.055]));
    // Counting cells of 30 um gives a width to one cell.
    assert!((wide_m - WIDTH_M).abs() <= deposit.cell_m(), "{wide_m}");
    // A cell's middle lies at most half a cell off the crest: 1 - sqrt(1 - (15/225)^2) = 0.2 %.
    assert!((crest_m - HEIGHT_M).abs() < 3e-3 * HEIGHT_M, "{crest_m}");
    assert!(deposit.height_m([0.05, 0.0605]).abs() < 1e-12, "ends after half a width");
}

#[test]
fn a_road_laid_in_pieces_is_the_road_laid_at_once() {
    let (mut whole, mut pieces) = (bed(), bed());
    let at = |share: f64| [0.05 + 4e-3 * share, 0.05 + 7e-3 * share];
    whole.lay(at(0.0), at(1.0), BEAD);
    for step in 0..40 {
        pieces.lay(at(f64::from(step) / 40.0), at(f64::from(step + 1) / 40.0), BEAD);
    }
    for cell in 0..40_000 {
        let at_m = [0.0495 + f64::from(cell % 200) * 3e-5, 0.0495 + f64::from(cell / 200) * 4e-5];
        let difference_m = whole.height_m(at_m) - pieces.height_m(at_m);
        // Single precision of 0.2 mm, with positions in cells: far below a micrometre.
        assert!(difference_m.abs() < 2e-7, "{at_m:?} {difference_m}");
    }
}

/// Seam between two roads at the slicer's pitch for a share of the slicer's width.
fn seam_m(share: f64) -> f64 {
    let mut deposit = bed();
    let pitch_m = WIDTH_M - HEIGHT_M * models::bead::ROUND_SIDES;
    let bead = Bead { width_m: share * WIDTH_M, ..BEAD };
    deposit.lay([0.05, 0.05], [0.05, 0.06], bead);
    deposit.lay([0.05 + pitch_m, 0.06], [0.05 + pitch_m, 0.05], bead);
    deposit.height_m([0.05 + pitch_m / 2.0, 0.055])
}

#[test]
fn neighbours_leave_a_gap_when_thin_a_groove_when_right_and_a_ridge_when_thick() {
    let (thin_m, right_m, thick_m) = (seam_m(0.8), seam_m(1.0), seam_m(1.2));
    assert!(thin_m < 0.05 * HEIGHT_M, "{thin_m}");
    assert!((0.5..0.95).contains(&(right_m / HEIGHT_M)), "{right_m}");
    let ridge = 1.0 + params().field.ridge_share;
    assert!(thick_m > HEIGHT_M && thick_m <= HEIGHT_M * ridge * 1.001, "{thick_m}");
}

#[test]
fn what_is_too_little_for_the_layer_becomes_a_strand_and_nothing_lays_nothing() {
    let strand_m = HEIGHT_M / 2.0;
    let area_m2 = std::f64::consts::FRAC_PI_4 * strand_m * strand_m;
    for (area_m2, wanted_m) in [(area_m2, strand_m), (0.0, 0.0)] {
        let mut deposit = bed();
        let width_m = stadium::width_of_area_m(area_m2, HEIGHT_M);
        deposit.lay([0.05, 0.05], [0.05, 0.06], Bead { width_m, ..BEAD });
        let wide_m = standing(&deposit, (0.049, 0.051), 0.055, 0.0);
        assert!((wide_m - wanted_m).abs() <= deposit.cell_m(), "{wide_m} {wanted_m}");
    }
}

#[test]
fn tiles_are_bounded_and_what_finds_no_room_is_counted() {
    let mut field = params().field;
    field.tiles_max = 64;
    let mut deposit = Deposit::new(field, 3e-5);
    for step in 0..200 {
        let x_m = 2e-3 * f64::from(step);
        deposit.lay([x_m, 0.0], [x_m + 2e-3, 0.0], BEAD);
    }
    deposit.lay([f64::NAN, 0.0], [0.0, 0.0], BEAD);
    assert!(deposit.bytes() <= 64 * 16_384 + (1 << 19), "{}", deposit.bytes());
    assert!(deposit.refused() > 0);
    assert!(deposit.height_m([0.0, 0.0]) > 0.0, "what was laid before stays");
}

/// Mean grey by column over rows 100 to 140, of a road along y at `x_m` from the tool less that of the bare bed.
fn columns(x_m: f64, tool_m: [f64; 2]) -> Vec<f64> {
    let params = plain(params());
    let look = || Look::draw(&params.test, 3);
    let view = View { tool_m: [tool_m[0], tool_m[1], HEIGHT_M], velocity_m_s: [0.0; 2] };
    let mut deposit = bed();
    let bare = Renderer::new(params.geometry, look()).render(&deposit, &view);
    deposit.lay([tool_m[0] + x_m, tool_m[1] - 8e-3], [tool_m[0] + x_m, tool_m[1] + 8e-3], BEAD);
    let seen = Renderer::new(params.geometry, look()).render(&deposit, &view);
    (0..seen.width_px)
        .map(|u| {
            let rows = (100..140).map(|v| v * seen.width_px + u);
            rows.map(|at| f64::from(seen.grey[at]) - f64::from(bare.grey[at])).sum::<f64>() / 40.0
        })
        .collect()
}

#[test]
fn a_road_is_seen_where_it_lies_and_nothing_changes_elsewhere() {
    // A tool position between two cells: the picture follows it.
    for tool_m in [[0.1, 0.1], [0.100_013, 0.099_991], [0.003, 0.002]] {
        for x_m in [4e-3, -6e-3] {
            let params = params();
            let middle = params.geometry.pixel_from_bed(tool_m, [tool_m[0] + x_m, tool_m[1]])[0];
            let half = WIDTH_M / params.geometry.scale_m() / 2.0;
            let seen = columns(x_m, tool_m);
            // Outside of the shadow's and the surroundings' reach (14 cells) nothing changes.
            for (u, change) in seen.iter().enumerate() {
                let away = (u as f64 - middle).abs();
                assert!(away < half + 16.0 || change.abs() < 0.5, "{u} {middle} {change}");
            }
            assert!(
                seen[super::cast::index(super::cast::floor(middle + 0.5))].abs() > 5.0,
                "no road is seen at {middle}"
            );
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_frame_and_another_style_another() {
    let params = params();
    for class in [Class::Over, Class::Spaghetti, Class::Stringing, Class::Blobs, Class::Shift] {
        let once = synthesize(&params, Style::Training, class, 5);
        assert_eq!(once.frame, synthesize(&params, Style::Training, class, 5).frame, "{class:?}");
        assert_ne!(once.frame, synthesize(&params, Style::Training, class, 6).frame);
        assert_ne!(once.frame, synthesize(&params, Style::Test, class, 5).frame);
    }
}

#[test]
fn a_label_holds_what_was_laid() {
    let params = params();
    for seed in 0..4 {
        let share = |class| {
            let example = synthesize(&params, Style::Training, class, seed);
            (example.width_m / example.target_width_m, example.shift_m)
        };
        assert!((share(Class::Ok).0 - 1.0).abs() <= 0.03);
        assert!(share(Class::Ok).1.iter().all(|way_m| way_m.abs() < 1e-12));
        assert!(share(Class::Under).0 <= 0.88 && share(Class::Over).0 >= 1.13);
        let [x_m, y_m] = share(Class::Shift).1;
        assert!((0.39e-3..2.01e-3).contains(&x_m.hypot(y_m)), "{x_m} {y_m}");
    }
}

#[test]
fn a_tangle_grows_with_the_volume_alone_and_stays_near_the_nozzle() {
    let mut deposit = bed();
    let mut tangle = Tangle::new(4e-4, 9);
    let tool_m = [0.1, 0.1, 5e-3];
    tangle.grow(&mut deposit, tool_m, 0.0);
    assert_eq!(deposit.bytes(), 0);
    // 300 mm of strand.
    let volume_m3 = 0.3 * std::f64::consts::FRAC_PI_4 * 4e-4_f64.powi(2);
    for _ in 0..1000 {
        tangle.grow(&mut deposit, tool_m, volume_m3 / 1000.0);
    }
    let far = (0..360).map(f64::from).map(|angle| {
        let (sin, cos) = angle.to_radians().sin_cos();
        deposit.height_m([tool_m[0] + 0.02 * cos, tool_m[1] + 0.02 * sin])
    });
    assert!(far.fold(0.0, f64::max) < 1e-12, "strays 20 mm from the nozzle");
    let area_m2 = 9e-10
        * f64::from(
            (0..250_000)
                .map(|cell| {
                    let at_m = [0.0925 + f64::from(cell % 500) * 3e-5, 0.0925 + f64::from(cell / 500) * 3e-5];
                    u32::from(deposit.height_m(at_m) > 0.0)
                })
                .sum::<u32>(),
        );
    // It lies over itself, so it covers less than its own shadow of 300 mm x 0.4 mm = 120 mm2, but a good part of it.
    assert!((2e-5..1.2e-4).contains(&area_m2), "{area_m2}");
}

#[test]
fn frames_come_once_a_period_late_and_numbered() {
    let params = CameraParams { period_s: 0.5, dither: 0.0, delay_s: 0.05, ..params() };
    let mut rig = Rig::new(&params, 1);
    let mut seen = Vec::new();
    for step in 1..=2_100 {
        let now = Seconds(f64::from(step) * 1e-3);
        let tool_m = [0.1 + 2e-5 * f64::from(step), 0.1, HEIGHT_M];
        let road_m = Some((WIDTH_M, HEIGHT_M));
        rig.observe(&Moment { now, tool_m, velocity_m_s: [0.02, 0.0], road_m, loose_m3: 0.0 });
        while let Some(shot) = rig.ready(now) {
            assert!((now.0 - shot.exposed.0 - 0.05).abs() < 1e-9);
            assert_eq!(shot.jpeg[..2], [0xff, 0xd8]);
            seen.push((shot.exposed.0, shot.sequence));
        }
    }
    let wanted = [(0.5, 0), (1.0, 1), (1.5, 2), (2.0, 3)];
    assert_eq!(seen.len(), wanted.len());
    for (seen, wanted) in seen.iter().zip(wanted) {
        assert!((seen.0 - wanted.0).abs() < 1e-9 && seen.1 == wanted.1);
    }
    // The road of 42 mm has reached the field up to the last frame at least.
    assert!(rig.deposit().height_m([0.139, 0.1]) > 0.9 * HEIGHT_M);
}

/// A metre of filament in a millimetre of way would be a road of metres: the picture's work stays that of a heap.
#[test]
fn what_no_nozzle_spreads_is_drawn_as_a_heap_and_counted() {
    let mut deposit = bed();
    deposit.lay([0.1, 0.1], [0.1004, 0.1], Bead { width_m: 15.0, ..BEAD });
    assert_eq!(deposit.refused(), 1);
    assert!((deposit.height_m([0.1002, 0.1]) - HEIGHT_M).abs() < 0.02 * HEIGHT_M);
    // At most four tiles of 16 KiB to a side, each with what the newest road covers.
    assert!(deposit.bytes() <= 16 * 3 * 16_384, "{}", deposit.bytes());
}
