use super::footprint::Lies;
use super::*;
use crate::camera::tests::camera;
use crate::frame::tests::picture;
use crate::path::tests::{params as history, road};

fn params() -> OffsetParams {
    OffsetParams::try_from(RawOffset {
        bed_low_m: [0.0, 0.0],
        bed_high_m: [0.25, 0.25],
        depth_m: 2e-3,
        old_s: 20.0,
        beside_new_m: 3e-4,
        range_m: 1.44e-3,
        step_m: 2.4e-4,
        sure_m: 1.2e-3,
        samples_min: 300,
        separation_min: 4.0,
        ratio_max: 2.0,
        alike: 60.0,
        gap_m: 3e-3,
        fringe_m: 3.6e-4,
        rarity: 6.0,
        memory_s: 4.0,
        sigma_floor_m: 7e-5,
        sigma_max_m: 1.5e-4,
    })
    .unwrap()
}

/// A solid block of 8 x 8 mm laid around a corner at (0.104, 0.1), long ago.
fn laid() -> PathHistory {
    let mut path = PathHistory::new(history());
    for line in 0..18_u32 {
        let y_m = 0.1 + 4.5e-4 * f64::from(line);
        path.on_move(Seconds(f64::from(line)), &road(0, [0.104, y_m], [0.112, y_m]));
    }
    path
}

/// The block as it looks with the tool at (0.1, 0.1), `moved_px` to the right and downwards, with some grain; roads end round, half a width beyond their last point.
fn seen(moved_px: [i64; 2], grain: u64) -> Mat {
    picture(640, 480, |u, v| {
        let at =
            [(u, moved_px[0]), (v, moved_px[1])].map(|(place, moved)| i64::try_from(place).unwrap() - moved);
        let inside = (446..720).contains(&at[0]) && (-16..247).contains(&at[1]);
        dust(u, v, grain) + if inside { 150 } else { 60 }
    })
}

fn dust(u: usize, v: usize, grain: u64) -> u8 {
    let noise = (u as u64 * 7919 + v as u64 * 104_729 + grain * 31).wrapping_mul(2_654_435_761) >> 29 & 7;
    u8::try_from(noise).unwrap()
}

/// Two roads abreast around a corner, laid long ago; a new layer on the first half of them.
fn thin() -> PathHistory {
    let mut path = PathHistory::new(history());
    for (line, in_m) in [0.0, 4.5e-4].into_iter().enumerate() {
        let (y_m, x_m, at_s) = (0.104 - in_m, 0.108 - in_m, f64::from(u8::try_from(line).unwrap()));
        path.on_move(Seconds(at_s), &road(0, [0.0935, y_m], [0.108, y_m]));
        path.on_move(Seconds(at_s + 0.5), &road(0, [x_m, 0.104], [x_m, 0.095]));
    }
    path.on_move(Seconds(50.0), &road(1, [0.0935, 0.104], [0.1005, 0.104]));
    path.on_move(Seconds(53.0), &road(1, [0.0935, 0.103_55], [0.1005, 0.103_55]));
    path
}

/// What [`thin`] looks like with the tool at (0.1, 0.1) and its old layer moved.
fn thin_seen(moved_m: [f64; 2], grain: u64) -> Mat {
    let within = |at_m: [f64; 2], x_m: (f64, f64), y_m: (f64, f64)| {
        (x_m.0..x_m.1).contains(&at_m[0]) && (y_m.0..y_m.1).contains(&at_m[1])
    };
    picture(640, 480, |u, v| {
        let bed_m = camera().bed([0.1, 0.1], [u, v].map(|pixel| f64::from(u16::try_from(pixel).unwrap())));
        let old_m = [bed_m[0] - moved_m[0], bed_m[1] - moved_m[1]];
        let part = within(bed_m, (0.093_275, 0.100_725), (0.103_325, 0.104_225))
            || within(old_m, (0.093_275, 0.108_225), (0.103_325, 0.104_225))
            || within(old_m, (0.107_325, 0.108_225), (0.094_775, 0.104_225));
        dust(u, v, grain) + if part { 150 } else { 60 }
    })
}

fn found(moved_px: [i64; 2]) -> Option<Offset> {
    watched([0.1, 0.1], moved_px)
}

/// What is known after six seconds with the tool at one place.
fn watched(tool_m: [f64; 2], moved_px: [i64; 2]) -> Option<Offset> {
    let (path, mut finder) = (laid(), OffsetFinder::new(params(), &camera()));
    let mut offset = None;
    for frame in 0..12_u32 {
        let exposed = Seconds(60.0 + 0.5 * f64::from(frame));
        let grey = seen(moved_px, u64::from(frame));
        offset = finder.on_frame(&grey, (&path, exposed), (&camera(), tool_m)).unwrap();
    }
    offset
}

#[test]
fn a_part_where_it_was_laid_has_no_offset() {
    let offset = found([0, 0]).unwrap();
    assert!(offset.offset_m.iter().all(|value| value.abs() < 1.2e-4), "{offset:?}");
}

/// P8: 0.8 mm are 26.7 px; image y runs against bed y. Where one edge alone is in view the fringe leaves 0.36 mm open.
#[test]
fn lost_steps_show_as_an_offset_of_the_old_part() {
    for (moved_px, wanted_m) in [([-27, 0], [-8e-4, 0.0]), ([0, -27], [0.0, 8e-4]), ([27, 27], [8e-4, -8e-4])]
    {
        let offset = found(moved_px).unwrap();
        let off = offset.offset_m.iter().zip(wanted_m).map(|(found, wanted)| (found - wanted).abs());
        assert!(off.into_iter().all(|off_m| off_m < 3.6e-4), "{moved_px:?}: {offset:?}");
    }
}

/// The same frames that tell the offset where the part was laid: 5 cm beside it an edge in them is something else.
#[test]
fn where_nothing_old_is_in_view_nothing_is_known() {
    assert!(watched([0.1, 0.1], [0, 0]).is_some());
    assert_eq!(watched([0.05, 0.05], [0, 0]), None);
}

/// Part and bed of the same grey and grain cannot be told apart, however long they are looked at.
#[test]
fn a_part_that_looks_like_its_bed_tells_nothing() {
    assert_eq!(found([-2000, 0]), None);
}

/// A skirt around a part of 2 cm lies in the dark: taken for the part's outline it let offsets pass that were none.
#[test]
fn what_lies_far_below_is_neither_part_nor_bed() {
    let (mut path, mut footprint) = (PathHistory::new(history()), Footprint::new([0.0; 2], [0.2; 2], 1.2e-4));
    path.on_move(Seconds(0.0), &road(0, [0.1, 0.1], [0.11, 0.1]));
    let skirt = *path.roads(Seconds(1.0)).next().unwrap();
    footprint.mark(&skirt, skirt.length_m);
    let found = |place_m, level_m| footprint.at(place_m, (level_m, 2e-3));
    assert_eq!(found([0.105, 0.1], 1e-3), Lies::Part);
    assert_eq!(found([0.105, 0.1], 2e-2), Lies::Deep);
    assert_eq!((found([0.105, 0.102], 1e-3), found([-1.0, f64::NAN], 1e-3)), (Lies::Bed, Lies::Bed));
}

/// A wall of 0.9 mm has no pixel that is part wherever it lies: the roads just laid tell how part looks.
#[test]
fn a_thin_wall_is_found_by_the_looks_of_fresh_roads() {
    for moved_m in [[0.0, 0.0], [8e-4, 0.0], [-8e-4, 8e-4]] {
        let (path, mut finder) = (thin(), OffsetFinder::new(params(), &camera()));
        let mut offset = None;
        for frame in 0..12_u32 {
            let exposed = Seconds(60.0 + 0.5 * f64::from(frame));
            let grey = thin_seen(moved_m, u64::from(frame));
            offset = finder.on_frame(&grey, (&path, exposed), (&camera(), [0.1, 0.1])).unwrap();
        }
        let found_m = offset.unwrap().offset_m;
        assert!(
            (0..2).all(|axis| (found_m[axis] - moved_m[axis]).abs() < 3.6e-4),
            "{moved_m:?}: {found_m:?}"
        );
    }
}
