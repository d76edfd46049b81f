//! Parts as STL files: maps of them, and meshes that are none.

use super::{json, number, refused, run, scratch};

type Corner = [f32; 3];

/// A cone of `sides` sides, 60 mm wide and 50 mm high, with or without its base.
pub(super) fn cone(sides: u16, closed: bool) -> Vec<[Corner; 3]> {
    let rim = |side: u16| {
        let angle = f32::from(side % sides) / f32::from(sides) * std::f32::consts::TAU;
        [30.0 * angle.cos(), 30.0 * angle.sin(), 0.0]
    };
    let mut triangles = Vec::new();
    for side in 0..sides {
        triangles.push([rim(side), rim(side + 1), [0.0, 0.0, 50.0]]);
        if closed {
            triangles.push([rim(side + 1), rim(side), [0.0, 0.0, 0.0]]);
        }
    }
    triangles
}

pub(super) fn write_stl(name: &str, triangles: &[[Corner; 3]]) -> String {
    let mut bytes = vec![b' '; 80];
    bytes.extend(u32::try_from(triangles.len()).unwrap().to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        bytes.extend(triangle.iter().flatten().flat_map(|value| value.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    let path = scratch(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

/// The machine works on the sides of a cone, and its base looks down: area 1 / (1 + r/s) of the whole.
#[test]
fn the_map_of_a_cone_is_of_its_sides() {
    let part = write_stl("cone.stl", &cone(60, true));
    let picture = scratch("cone.html");
    let map = json(&["kinematics", "map", "--stl", &part, "--picture", &picture]);
    assert_eq!(map["triangles"], 120);
    // The base looks down, but nobody prints on it: it stands on the table.
    assert_eq!(map["refused"]["on_the_table"], 60);
    let (workable, table) = (number(&map, "workable_share"), number(&map, "on_the_table_share"));
    assert!((workable + table - 1.0).abs() < 1e-3 && map["warning"].is_null(), "{map}");
    let slant = 30.0_f64.hypot(50.0);
    assert!((number(&map, "workable_share") - 1.0 / (1.0 + 30.0 / slant)).abs() < 1e-3, "{map}");
    // Looked at in even pieces, not in the triangles' middles alone: the error differs over the height.
    assert!(number(&map, "points") > 1000.0 && number(&map, "edge_mm") < 5.0, "{map}");
    assert!(number(&map, "largest_mm") >= number(&map, "p95_mm"), "{map}");
    assert!(number(&map, "p95_mm") >= number(&map, "mean_mm"), "{map}");
    let page = std::fs::read_to_string(picture).unwrap();
    assert!(
        page.starts_with("<!DOCTYPE html>")
            && page.contains("<svg")
            // Triangles that look away are not drawn; 60 of the sides are more than half to be seen from above.
            && (30..=60).contains(&page.matches("<polygon").count())
            && page.contains("max-width: 100%")
    );
}

/// Metres read as millimetres: the machine can do it, and nobody means it.
#[test]
fn a_part_a_thousand_times_off_is_warned_of() {
    let part = write_stl("tiny.stl", &cone(60, true));
    for command in ["map", "budget"] {
        let arguments = ["kinematics", command, "--stl", &part, "--unit", "0.001", "--from-height", "0"];
        let figures = json(&arguments[..if command == "map" { 6 } else { 8 }]);
        assert!(figures["warning"].as_str().unwrap().contains("is --unit right"), "{figures}");
    }
}

/// The same triangles twice, and a small cone upside down beside a large one: closed by the sums of their edges, and no
/// part all the same. A cavity inside of a part is one.
#[test]
fn doubled_and_inverted_bodies_are_refused() {
    let big = cone(12, true);
    let moved = |scale: f32, across: f32, up: f32| -> Vec<[Corner; 3]> {
        let move_corner = |[x, y, z]: Corner| [scale * x + across, scale * y, scale * z + up];
        big.iter().map(|triangle| triangle.map(move_corner)).collect()
    };
    let inverted = |part: Vec<[Corner; 3]>| part.into_iter().map(|[a, b, c]| [a, c, b]).collect::<Vec<_>>();
    let map = |name: &str, more: Vec<[Corner; 3]>| {
        let part = write_stl(name, &[big.clone(), more].concat());
        run(&["kinematics", "map", "--stl", &part])
    };
    for (name, more, said) in [
        ("twice.stl", big.clone(), "doubled edges = 36"),
        ("apart.stl", inverted(moved(0.2, 50.0, 0.0)), "of body 2 of 2: must be > 0"),
        ("inner.stl", moved(0.2, 0.0, 10.0), "lies inside of another"),
    ] {
        let output = map(name, more);
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && text.contains(said), "{name}: {text}");
    }
    for (name, more) in [("cavity.stl", inverted(moved(0.2, 0.0, 10.0))), ("two.stl", moved(0.2, 50.0, 0.0))]
    {
        assert!(map(name, more).status.success(), "{name}");
    }
}

/// Nothing within reach is no map with an error of 0.
#[test]
fn a_part_out_of_reach_is_refused() {
    let part = write_stl("far.stl", &cone(12, true));
    refused(
        &["kinematics", "map", "--stl", &part, "--unit", "1000"],
        &["can work on no point of the part", "must be", "is --unit right"],
    );
    refused(
        &["kinematics", "budget", "--stl", &part, "--from-height", "49.9"],
        &["--from-height 49.9 mm", "must be 30 or more", "lie below it"],
    );
}
