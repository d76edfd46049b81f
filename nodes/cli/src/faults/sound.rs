//! Sound prints with every nuisance: nothing may trip.

use super::catalogue::{JobSpec, SoundSpec};
use super::trial::share_of;
use crate::config::{Choice, ConfigDir};
use crate::job::GcodeFile;
use crate::output;
use crate::sim::{self, printing::Printing};
use anyhow::Context;
use models::status::JobPhase;
use printer_sim::Scenario;
use safety_supervisor::Operator;
use std::sync::{Mutex, PoisonError};

/// Steps between two looks at the progress.
const GLANCE: u64 = 100_000;
/// Most of the hours that are prints with the camera: they take some twenty times as long `[-]`.
const CAMERA_SHARE: f64 = 0.01;
/// Somebody comes so long after the file asked for a pause, and by a share of the spread of each seed later `[s]`: on
/// either side of the minute after which the nozzle is let cool down.
const CHANGED_S: (f64, f64) = (15.0, 90.0);
/// How long the printer may need to go on after that: it heats up again `[s]`.
const GOES_ON_S: f64 = 180.0;
/// Where a file of the catalogue is looked for.
const OF_THE_CLONE: &str = "a print of the catalogue: its file lies beside the folder of the parameters, in ../tests/data as in a clone";
/// Seconds of an hour.
const HOUR_S: f64 = 3600.0;

/// What became of them.
#[derive(Debug, Clone, Default)]
pub struct Sound {
    /// Simulated time `[h]`.
    pub hours: f64,
    /// Of it with the camera `[h]`.
    pub camera_hours: f64,
    /// Prints, the last ones not to their end.
    pub prints: usize,
    /// Pauses that a file asked for (change of filament, say), after which the print went on.
    pub pauses: usize,
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
            (Some(file), None) => {
                GcodeFile::read(&config.file(file), &motion, self.layers).context(OF_THE_CLONE)
            }
            (None, Some(text)) => GcodeFile::of_text(text, &motion, self.layers),
            _ => anyhow::bail!("a job has either a file or a text"),
        }
    }
}

/// Which prints come next, and what became of those before.
struct Queue<'a> {
    config: &'a ConfigDir,
    specs: &'a [SoundSpec],
    wanted_s: f64,
    /// Seed of the first round of prints.
    first_seed: u64,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    next: usize,
    sound: Sound,
}

/// Prints until so many hours are simulated, one file and seed after the other from `first_seed` on, on all cores.
///
/// # Errors
/// A file, material or scenario that cannot be read; a print that panicked.
pub fn run(
    config: &ConfigDir,
    specs: &[SoundSpec],
    (first_seed, hours): (u64, f64),
) -> anyhow::Result<Sound> {
    if hours <= 0.0 || specs.iter().all(|spec| spec.camera) {
        return Ok(Sound::default());
    }
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within 0 and 36 million")]
    let progress = output::bar((hours * HOUR_S) as u64, "s of sound prints");
    let queue = Queue { config, specs, wanted_s: hours * HOUR_S, first_seed, state: Mutex::default() };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let ended: Vec<anyhow::Result<()>> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..cores).map(|_| scope.spawn(|| queue.work(&progress))).collect();
        let ended = workers.into_iter().map(|worker| worker.join());
        ended.map(|ended| ended.unwrap_or_else(|_| Err(anyhow::anyhow!("a sound print panicked")))).collect()
    });
    progress.finish_and_clear();
    ended.into_iter().collect::<anyhow::Result<()>>()?;
    let state = queue.state.into_inner().unwrap_or_else(PoisonError::into_inner);
    Ok(state.sound)
}

impl Queue<'_> {
    fn work(&self, progress: &indicatif::ProgressBar) -> anyhow::Result<()> {
        while let Some((spec, seed)) = self.next() {
            let printed = one(self, spec, seed)?;
            let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
            let sound = &mut state.sound;
            sound.hours += printed.hours;
            sound.camera_hours += printed.camera_hours;
            sound.prints += 1;
            sound.pauses += printed.pauses;
            sound.trips.extend(printed.trips);
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "as above")]
            progress.set_position((sound.hours * HOUR_S) as u64);
        }
        Ok(())
    }

    /// The next print and its seed; one with the camera only while its share is not reached.
    fn next(&self) -> Option<(&SoundSpec, u64)> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if state.sound.hours * HOUR_S >= self.wanted_s {
            return None;
        }
        loop {
            let index = state.next;
            state.next += 1;
            let spec = &self.specs[index % self.specs.len()];
            if !spec.camera || state.sound.camera_hours * HOUR_S < CAMERA_SHARE * self.wanted_s {
                return Some((spec, self.first_seed + (index / self.specs.len()) as u64));
            }
        }
    }

    /// How much is still wanted `[s]`.
    fn left_s(&self) -> f64 {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        self.wanted_s - state.sound.hours * HOUR_S
    }
}

/// One print, or as much of it as is wanted.
fn one(queue: &Queue<'_>, spec: &SoundSpec, seed: u64) -> anyhow::Result<Sound> {
    let config = queue.config;
    let motion = config.motion()?;
    let file = GcodeFile::read(&config.file(&spec.file), &motion, spec.layers).context(OF_THE_CLONE)?;
    let material = spec.material.clone().unwrap_or_else(|| file.material());
    let choice = Choice { camera: spec.camera, ..Choice::of(material, sim::level(&spec.control)?) };
    let setup = config.load(&choice)?;
    let file = if spec.material.is_some() { file.with_set_points(&setup) } else { file };
    let scenario = spec.scenario.as_ref().map(|name| config.scenario(name)).transpose()?;
    let scenario = scenario.unwrap_or_else(Scenario::default);
    let mut printing = Printing::new(&setup, file.job(&setup), &scenario, seed)?;
    let mut somebody = Somebody::of(seed);
    let mut steps: u64 = 0;
    while printing.step() && printing.noticed.is_empty() && somebody.looks(&mut printing) {
        steps += 1;
        if steps.is_multiple_of(GLANCE) && printing.simulator().now().0 > queue.left_s() {
            break;
        }
    }
    let (name, material) = (file.name(), &setup.material.name);
    let hours = printing.simulator().now().0 / HOUR_S;
    let named = |what: String| format!("{name} in {material}, control {}, seed {seed}: {what}", spec.control);
    let found = printing.noticed.iter();
    let mut trips: Vec<String> = found
        .map(|found| named(format!("{} {} at {:.1} s", found.fault, found.action, found.detected_s)))
        .collect();
    if somebody.waits_in_vain {
        trips.push(named(format!("stands at {:.1} s and does not go on", printing.simulator().now().0)));
    }
    // The last step ends the run, before the supervisor could say why.
    if printing.simulator().phase() == JobPhase::Failed && trips.is_empty() {
        trips.push(named(format!("given up at {:.1} s", printing.simulator().now().0)));
    }
    Ok(Sound {
        hours,
        camera_hours: if spec.camera { hours } else { 0.0 },
        prints: 1,
        pauses: somebody.went_on,
        trips,
    })
}

/// Who does what a file asks for in its pauses, and lets the printer go on.
struct Somebody {
    /// How long after the pause began `[s]`.
    comes_after_s: f64,
    since_s: Option<f64>,
    asked: bool,
    went_on: usize,
    waits_in_vain: bool,
}

impl Somebody {
    fn of(seed: u64) -> Self {
        let comes_after_s = CHANGED_S.0 + CHANGED_S.1 * share_of(seed);
        Self { comes_after_s, since_s: None, asked: false, went_on: 0, waits_in_vain: false }
    }

    /// Looks at the printer; whether it is worth to look on.
    fn looks(&mut self, printing: &mut Printing) -> bool {
        let now_s = printing.simulator().now().0;
        if printing.simulator().phase() != JobPhase::Paused {
            self.went_on += usize::from(self.since_s.take().is_some());
            self.asked = false;
            return true;
        }
        let waited_s = now_s - *self.since_s.get_or_insert(now_s);
        if !self.asked && waited_s > self.comes_after_s {
            self.asked = true;
            printing.ask(Operator::Resume);
        }
        self.waits_in_vain = waited_s > self.comes_after_s + GOES_ON_S;
        !self.waits_in_vain
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A printer that gives its job up by itself has tripped, whoever noticed.
    #[test]
    fn a_sound_print_that_fails_has_tripped() {
        let config = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config");
        let config = ConfigDir::find(Some(&config)).unwrap();
        let file = std::env::temp_dir().join(format!("sound_{}.gcode", std::process::id()));
        for (last, trips) in [("G4 S1", 0), ("M112", 1)] {
            std::fs::write(&file, format!("G28\nG1 X10 Y10 F3000\n{last}\nG1 X20\n")).unwrap();
            let spec = serde_json::json!({"file": file, "material": "PLA"});
            let spec: SoundSpec = serde_json::from_value(spec).unwrap();
            let queue = Queue {
                config: &config,
                specs: std::slice::from_ref(&spec),
                wanted_s: HOUR_S,
                first_seed: 1,
                state: Mutex::default(),
            };
            let sound = one(&queue, &spec, 1).unwrap();
            assert_eq!(sound.trips.len(), trips, "{last}: {:?}", sound.trips);
        }
        std::fs::remove_file(file).unwrap();
    }
}
