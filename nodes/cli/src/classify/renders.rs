//! Labelled frames of the simulated camera.

use super::settings::RenderSettings;
use crate::config::ConfigDir;
use anyhow::Context;
use defect_classifier::features::{self, Hidden, Measured};
use printer_sim::camera::{CameraParams, Class, Style, synthesize};
use runtime::params::{NodePath, Parameters};

/// Names of the classes in the order of [`Class::ALL`], `ok` first.
pub(super) const CLASSES: [&str; 7] = ["ok", "under", "over", "spaghetti", "stringing", "blobs", "shift"];

/// Features of a rendered frame.
#[derive(Debug, Clone)]
pub(super) struct Render {
    /// Index among [`CLASSES`].
    pub(super) class: usize,
    pub(super) values: Vec<f64>,
}

/// The camera of the simulated printer.
///
/// # Errors
/// File, line, field, value and range of what is refused.
pub(super) fn camera(config: &ConfigDir) -> anyhow::Result<CameraParams> {
    let path = NodePath { qualified: "/printer/printer_sim".into(), base: "printer_sim".into() };
    Ok(Parameters::read(&[config.file("printer_sim.param.yaml")], &[], &path)?.block("camera")?)
}

/// Frames of a style, in the order of class and seed whatever the number of threads.
///
/// # Errors
/// A frame that cannot be encoded or judged.
pub(super) fn gather(
    camera: &CameraParams,
    settings: &RenderSettings,
    style: Style,
) -> anyhow::Result<Vec<Render>> {
    let (per_class, first_seed) = match style {
        Style::Training => (settings.per_class, settings.first_seed),
        Style::Test => (settings.test_per_class, settings.test_first_seed),
    };
    let mut tasks = vec![];
    for class in 0..Class::ALL.len() {
        let times = if class == 0 && style == Style::Training { settings.ok_times } else { 1 };
        tasks.extend((0..u64::from(per_class * times)).map(|number| (class, first_seed + number)));
    }
    let threads = settings.threads as usize;
    let hidden = Hidden(settings.hidden_share);
    let one = |(class, seed): (usize, u64)| frame((camera, hidden), style, class, seed);
    let parts = std::thread::scope(|scope| {
        let tasks = &tasks;
        let start = |part: usize| {
            scope.spawn(move || tasks.iter().skip(part).step_by(threads).map(|task| one(*task)).collect())
        };
        let running: Vec<_> = (0..threads).map(start).collect();
        let finish = |part: std::thread::ScopedJoinHandle<'_, anyhow::Result<Vec<Render>>>| match part.join()
        {
            Ok(done) => done,
            Err(_) => anyhow::bail!("a thread that renders ended early"),
        };
        running.into_iter().map(finish).collect::<anyhow::Result<Vec<_>>>()
    })?;
    let mut parts: Vec<_> = parts.into_iter().map(Vec::into_iter).collect();
    (0..tasks.len()).map(|task| parts[task % threads].next().context("a rendered frame is missing")).collect()
}

fn frame(
    (camera, hidden): (&CameraParams, Hidden),
    style: Style,
    class: usize,
    seed: u64,
) -> anyhow::Result<Render> {
    let example = synthesize(camera, style, Class::ALL[class], seed);
    let jpeg = example.frame.jpeg(example.jpeg_quality)?;
    Ok(Render { class, values: features::extract_encoded(&jpeg, hidden, &Measured::default())? })
}
