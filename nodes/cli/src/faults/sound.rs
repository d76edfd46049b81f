//! Sound prints with every nuisance: nothing may trip.

use super::catalogue::{JobSpec, SoundSpec};
use crate::config::{Choice, ConfigDir};
use crate::job::GcodeFile;
use crate::output;
use crate::sim::printing::Printing;
use anyhow::Context;
use mpc_controller::params::Level;
use printer_sim::Scenario;

/// Steps between two looks at the progress.
const GLANCE: u64 = 100_000;

/// What became of them.
#[derive(Debug, Default)]
pub struct Sound {
    /// Simulated time `[h]`.
    pub hours: f64,
    /// What tripped, where and when.
    pub trips: Vec<String>,
}

impl JobSpec {
    /// The job's file.
    ///
    /// # Errors
    /// A file that cannot be read, or neither file nor text.
    pub fn load(&self, config: &ConfigDir) -> anyhow::Result<GcodeFile> {
        let motion = config.motion()?;
        match (&self.file, &self.text) {
            (Some(file), None) => GcodeFile::read(&config.file(file), &motion, self.layers),
            (None, Some(text)) => GcodeFile::of_text(text, &motion, self.layers),
            _ => anyhow::bail!("a job has either a file or a text"),
        }
    }
}

/// Prints until so many hours are simulated, one file and seed after the other.
///
/// # Errors
/// A file, material or scenario that cannot be read.
pub fn run(config: &ConfigDir, specs: &[SoundSpec], hours: f64) -> anyhow::Result<Sound> {
    let mut sound = Sound::default();
    if hours <= 0.0 || specs.is_empty() {
        return Ok(sound);
    }
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within 0 and 36 million")]
    let progress = output::bar((hours * 3600.0) as u64, "s of sound prints");
    for seed in 1.. {
        for spec in specs {
            let printed_s =
                one(config, spec, (seed, hours * 3600.0 - sound.hours * 3600.0), &mut sound.trips)?;
            sound.hours += printed_s / 3600.0;
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "as above")]
            progress.set_position((sound.hours * 3600.0) as u64);
            if sound.hours >= hours {
                progress.finish_and_clear();
                return Ok(sound);
            }
        }
    }
    Ok(sound)
}

/// One print, or as much of it as is wanted; how long it was `[s]`.
fn one(
    config: &ConfigDir,
    spec: &SoundSpec,
    (seed, most_s): (u64, f64),
    trips: &mut Vec<String>,
) -> anyhow::Result<f64> {
    let motion = config.motion()?;
    let file = GcodeFile::read(&config.file(&spec.file), &motion, None).context("a sound print")?;
    let material = spec.material.clone().unwrap_or_else(|| file.material());
    let setup = config.load(&Choice::of(material, Level::Mpc))?;
    let file = if spec.material.is_some() { file.with_set_points(&setup) } else { file };
    let scenario = spec.scenario.as_ref().map(|name| config.scenario(name)).transpose()?;
    let scenario = scenario.unwrap_or_else(Scenario::default);
    let mut printing = Printing::new(&setup, file.job(&setup), &scenario, seed)?;
    let mut steps: u64 = 0;
    while printing.step() && printing.noticed.is_empty() && !printing.is_stuck() {
        steps += 1;
        if steps.is_multiple_of(GLANCE) && printing.simulator().now().0 > most_s {
            break;
        }
    }
    for found in &printing.noticed {
        let (name, material) = (file.name(), &setup.material.name);
        trips.push(format!(
            "{name} in {material}, seed {seed}: {} {} at {:.1} s",
            found.fault, found.action, found.detected_s
        ));
    }
    Ok(printing.simulator().now().0)
}
