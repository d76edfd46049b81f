//! The map of the paper's hemisphere: height to the right, motor angle downward.

use super::super::picture;
use super::MapArgs;
use crate::output::{self, Json};
use crate::process::Picture;
use models::hybrid::{AxisError, Geometry, SurfacePoint};
use serde::Serialize;

/// One height and angle on the hemisphere.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Spot {
    /// Height.
    pub height_mm: f64,
    /// Angle by which every motor is wrong.
    pub angle_deg: f64,
    /// Worst error; absent where a combination has no pose on the nominal branch.
    pub error_mm: Option<f64>,
}

/// The figures of the hemisphere.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HemisphereFigures {
    /// Machine.
    pub machine: String,
    /// Where its geometry comes from.
    pub provenance: String,
    /// Radius.
    pub radius_mm: f64,
    /// Rows of one angle each, heights rising.
    pub spots: Vec<Spot>,
}

/// Heights of the hemisphere's map.
const HEIGHTS: u32 = 31;
/// Angles: a full step, halved again and again.
const HALVINGS: u32 = 9;

pub(super) fn run(
    args: &MapArgs,
    geometry: &Geometry,
    radius_m: f64,
    picture: Option<&Picture>,
) -> anyhow::Result<()> {
    let mut spots = Vec::new();
    for halving in 0..HALVINGS {
        let angle_deg = args.part.step / f64::from(1_u32 << halving);
        let error = AxisError::of_motors(angle_deg.to_radians(), geometry.lead_m);
        for index in 0..HEIGHTS {
            let height_m = radius_m * f64::from(index) / f64::from(HEIGHTS - 1);
            let worst = geometry.station(&SurfacePoint::on_hemisphere(radius_m, height_m)?)?.extremal(&error);
            let error_mm = (worst.failed == 0).then_some(1e3 * worst.largest_m);
            spots.push(Spot { height_mm: 1e3 * height_m, angle_deg, error_mm });
        }
    }
    let figures = HemisphereFigures {
        machine: args.machine.machine.clone(),
        provenance: geometry.provenance.clone(),
        radius_mm: 1e3 * radius_m,
        spots,
    };
    if let Some(picture) = picture {
        picture::hemisphere(picture, &figures.spots)?;
    }
    let json = Json::new(args.json.as_deref());
    if !json.is_stdout() {
        output::line(&text(&figures))?;
    }
    json.write(&figures)
}

fn text(figures: &HemisphereFigures) -> String {
    let mut lines = vec![
        format!("machine      {}: geometry {}", figures.machine, figures.provenance),
        format!(
            "hemisphere   radius {:.1} mm; worst error [mm] over height and motor angle",
            figures.radius_mm
        ),
    ];
    let width = HEIGHTS as usize;
    let shown = || (0..width).step_by(5);
    let head: Vec<String> = shown().map(|index| format!("{:>9.1}", figures.spots[index].height_mm)).collect();
    lines.push(format!("{:>12} {}", "deg \\ z mm", head.join(" ")));
    for row in figures.spots.chunks(width) {
        let cells: Vec<String> = shown()
            .map(|index| row[index].error_mm.map_or_else(|| format!("{:>9}", "-"), |mm| format!("{mm:>9.4}")))
            .collect();
        lines.push(format!("{:>12.5} {}", row[0].angle_deg, cells.join(" ")));
    }
    lines.join("\n")
}
