//! One look of the simulated camera at straight roads of known width, read as the node reads a frame.

use super::settings::SceneSettings;
use crate::classify::chance::Stream;
use crate::config::ConfigDir;
use defect_classifier::camera::Camera;
use defect_classifier::width::WidthParams;
use defect_classifier::width::edge::training::KnownEdge;
use defect_classifier::width::profile::{Picture, Ruler, across};
use defect_classifier::width::stretch::Station;
use models::bead::ROUND_SIDES;
use models::params::{ParamError, in_range};
use printer_sim::camera::{Bead, CameraParams, Deposit, Look, Renderer, Style, View};
use runtime::params::{NodePath, Parameters};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Where the tool is on the bed `[m]`: anywhere, but not always at the same place between two pixels.
const TOOL_M: f64 = 0.1;

/// The camera as it is rendered and as it is measured with.
#[derive(Debug, Clone)]
pub(super) struct Optics {
    rendered: CameraParams,
    measured: Camera,
    /// How the node measures widths.
    pub(super) width: WidthParams,
}

impl Optics {
    /// Of the committed configuration.
    ///
    /// # Errors
    /// File, line, field, value and range of what is refused.
    pub(super) fn load(config: &ConfigDir) -> anyhow::Result<Self> {
        let path =
            NodePath { qualified: "/printer/defect_classifier".into(), base: "defect_classifier".into() };
        let node = Parameters::read(&[config.file("defect_classifier.param.yaml")], &[], &path)?;
        let rendered = crate::classify::renders::camera(config)?;
        let measured: Camera = node.block("camera")?;
        agree(&rendered, &measured)?;
        Ok(Self { rendered, measured, width: node.block("width")? })
    }

    /// Where profiles are sampled.
    pub(super) fn ruler(&self, scene: &SceneSettings) -> Ruler {
        Ruler::over(scene.profile_from_m, scene.profile_to_m, self.width.profile_step_m)
    }

    /// Profiles of one look with the roads that it sees; the same style and seed give the same ones.
    ///
    /// # Errors
    /// A frame that cannot be encoded or decoded.
    pub(super) fn profiles(
        &self,
        scene: &SceneSettings,
        (style, seed): (Style, u64),
    ) -> anyhow::Result<Vec<KnownEdge>> {
        let mut chance = Stream::new(seed);
        let roads = Roads::draw(scene, &mut chance);
        let mut deposit = Deposit::new(self.rendered.field, self.rendered.geometry.scale_m());
        roads.lay(&mut deposit);
        let speed_m_s = between(&mut chance, scene.speed_m_s);
        let heading_rad = between(&mut chance, [0.0, TAU]);
        let along = chance.uniform() < scene.along_share;
        let way = if along { roads.along } else { unit(heading_rad) };
        let velocity_m_s = way.map(|part| speed_m_s * part);
        let [x_m, y_m] = roads.tool_m;
        let view = View { tool_m: [x_m, y_m, roads.base_m + roads.height_m], velocity_m_s };
        let look = Look::draw(self.rendered.ranges(style), seed);
        let (exposure_s, quality) = (look.exposure_s, look.jpeg_quality);
        let frame = Renderer::new(self.rendered.geometry, look).render(&deposit, &view);
        let across_m_s = velocity_m_s[0] * roads.left[0] + velocity_m_s[1] * roads.left[1];
        if across_m_s.abs() * exposure_s / self.measured.scale_m >= scene.blur_max_px {
            return Ok(vec![]);
        }
        Ok(self.read(&Picture::decode(&frame.jpeg(quality)?)?, scene, (&roads, seed)))
    }

    /// Profiles on each free side, of each piece that is seen whole.
    fn read(&self, picture: &Picture, scene: &SceneSettings, (roads, look): (&Roads, u64)) -> Vec<KnownEdge> {
        let ruler = self.ruler(scene);
        let mut found = vec![];
        for middle_m in &scene.pieces_m {
            let mut stations = vec![];
            let mut way_m = -0.5 * scene.piece_m;
            while way_m <= 0.5 * scene.piece_m {
                let point_m = roads.point_m(roads.away_m, middle_m + way_m);
                stations.push(Station { point_m, left: roads.left });
                way_m += self.width.station_m;
            }
            let pixel = |station: &Station| self.measured.pixel(roads.tool_m, station.point_m);
            if !stations.iter().all(|station| self.measured.sees(pixel(station), scene.margin_px)) {
                continue;
            }
            for side in roads.free_sides() {
                let view = (&self.measured, roads.tool_m);
                let levels = across(&picture.pixels(), view, &stations, (side, &ruler));
                found.extend(levels.map(|levels| KnownEdge {
                    look,
                    levels,
                    edge_m: 0.5 * roads.width_m,
                    half_m: 0.5 * roads.wanted_m,
                }));
            }
        }
        found
    }
}

/// Both parameter files must mean the same camera, or the labels would lie.
fn agree(rendered: &CameraParams, measured: &Camera) -> Result<(), ParamError> {
    let geometry = &rendered.geometry;
    in_range("camera.scale_m", measured.scale_m, "m", (geometry.scale_m(), geometry.scale_m()))?;
    for (name, found, wanted) in [
        ("camera.centre_px[0]", measured.centre_px[0], geometry.principal_px()[0]),
        ("camera.centre_px[1]", measured.centre_px[1], geometry.principal_px()[1]),
    ] {
        in_range(name, found, "px", (wanted, wanted))?;
    }
    Ok(())
}

/// Parallel roads, the last one beside the nozzle, on the bed or on solid layers.
#[derive(Debug)]
struct Roads {
    tool_m: [f64; 2],
    along: [f64; 2],
    left: [f64; 2],
    height_m: f64,
    wanted_m: f64,
    width_m: f64,
    /// Height of what they lie on.
    base_m: f64,
    /// Directions of the solid layers below.
    solid: Vec<[f64; 2]>,
    solid_half_m: f64,
    half_length_m: f64,
    /// Where the last one is, to the left of the nozzle.
    away_m: f64,
    /// The side where nothing lies beside it, as [`across`] counts.
    free: f64,
    count: u32,
}

impl Roads {
    fn draw(scene: &SceneSettings, chance: &mut Stream) -> Self {
        let height_m = scene.heights_m[chance.place(scene.heights_m.len())];
        let wanted_m = between(chance, scene.wanted_m);
        let width_m = wanted_m * between(chance, scene.width_rel);
        let turn_rad = between(chance, [0.0, TAU]);
        let axis = chance.uniform() < scene.axis_share;
        let angle_rad = if axis { (turn_rad / FRAC_PI_2).floor() * FRAC_PI_2 } else { turn_rad };
        let tool_m = [0, 1].map(|_| TOOL_M + between(chance, [0.0, 1e-4]));
        let on_bed = chance.uniform() < scene.bed_share;
        let layers = if on_bed { 0 } else { 1 + draw_below(chance, scene.solid_max) };
        let aslant = chance.uniform() >= scene.across_share;
        let first_rad = if aslant { between(chance, scene.turn_rad) } else { FRAC_PI_2 };
        let solid = (0..layers).map(|layer| unit(angle_rad + first_rad + f64::from(layer) * FRAC_PI_2));
        let along = unit(angle_rad);
        let away_m = sign(chance) * between(chance, scene.away_m);
        Self {
            tool_m,
            along,
            left: [-along[1], along[0]],
            height_m,
            wanted_m,
            width_m,
            base_m: f64::from(layers) * height_m,
            solid: solid.collect(),
            solid_half_m: scene.solid_half_m,
            half_length_m: scene.half_length_m,
            away_m,
            free: sign(chance),
            count: 1 + draw_below(chance, scene.roads_max),
        }
    }

    /// A place to the left of the nozzle and along the roads.
    fn point_m(&self, left_m: f64, along_m: f64) -> [f64; 2] {
        [0, 1].map(|axis| self.tool_m[axis] + self.left[axis] * left_m + self.along[axis] * along_m)
    }

    fn free_sides(&self) -> Vec<f64> {
        if self.count == 1 { vec![1.0, -1.0] } else { vec![self.free] }
    }

    /// Distance of neighbours, for the wanted width: what is laid wider or narrower keeps it.
    fn pitch_m(&self) -> f64 {
        self.wanted_m - ROUND_SIDES * self.height_m
    }

    fn lay(&self, deposit: &mut Deposit) {
        let mut top_m = 0.0;
        for along in &self.solid {
            top_m += self.height_m;
            let left = [-along[1], along[0]];
            let mut away_m = -self.solid_half_m;
            while away_m <= self.solid_half_m {
                let middle = [0, 1].map(|axis| self.tool_m[axis] + left[axis] * away_m);
                self.lay_one(deposit, (middle, *along), (self.solid_half_m + 1e-3, top_m));
                away_m += self.pitch_m();
            }
        }
        for before in (0..self.count).rev() {
            let away_m = self.away_m - self.free * f64::from(before) * self.pitch_m();
            let middle = self.point_m(away_m, 0.0);
            self.lay_one(deposit, (middle, self.along), (self.half_length_m, self.base_m + self.height_m));
        }
    }

    fn lay_one(
        &self,
        deposit: &mut Deposit,
        (middle, along): ([f64; 2], [f64; 2]),
        (half_m, top_m): (f64, f64),
    ) {
        let end = |way_m: f64| [0, 1].map(|axis| middle[axis] + along[axis] * way_m);
        let bead = Bead { top_m, width_m: self.width_m, height_m: self.height_m };
        deposit.lay(end(-half_m), end(half_m), bead);
    }
}

fn unit(angle_rad: f64) -> [f64; 2] {
    [angle_rad.cos(), angle_rad.sin()]
}

fn between(chance: &mut Stream, [low, high]: [f64; 2]) -> f64 {
    low + (high - low) * chance.uniform()
}

fn sign(chance: &mut Stream) -> f64 {
    if chance.uniform() < 0.5 { 1.0 } else { -1.0 }
}

/// A whole number below `limit`.
fn draw_below(chance: &mut Stream, limit: u32) -> u32 {
    u32::try_from(chance.place(limit as usize)).unwrap_or(0)
}
