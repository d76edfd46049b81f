//! One simulated print after another.

use super::bagging::Bagging;
use super::choices::{advance_name, filter_name, name_of};
use super::consistency::STATE_NAMES;
use super::printing::Printing;
use super::report::Run;
use super::width_trace::WidthTrace;
use crate::config::Setup;
use crate::job::GcodeFile;
use fdm_loop_msgs::PrintInfo;
use models::status::JobPhase;
use mpc_controller::params::Level;
use printer_sim::Scenario;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

/// What several runs share.
pub(super) struct Task {
    pub(super) setup: Setup,
    pub(super) file: GcodeFile,
    pub(super) scenario: Scenario,
    pub(super) names: Names,
    pub(super) bag: Option<(PathBuf, PrintInfo)>,
}

/// Time for which a width has to be back to count as recovered `[s]`.
const HELD_S: f64 = 5.0;

/// What was chosen by name.
pub(super) struct Names {
    pub(super) scenario: String,
    pub(super) host: String,
    pub(super) advance: String,
    pub(super) buffer: Option<u32>,
    pub(super) without: Vec<String>,
    pub(super) with: Vec<String>,
}

impl Names {
    /// What was chosen of the printer, as a section of the recorded configuration.
    pub(super) fn text(&self) -> String {
        let (without, with) = (self.without.join(", "), self.with.join(", "));
        format!("# sim\nsimulator.host: {}\nsensors.without: {without}\nsensors.with: {with}\n", self.host)
    }
}

/// Mean NIS by channel; of a sensor that few printers have nothing is told where it is not fitted.
fn nis_by_channel(printing: &Printing) -> BTreeMap<&'static str, Option<f64>> {
    let means = runtime::wire::CHANNELS.into_iter().zip(printing.nis_mean);
    means.filter(|(channel, mean)| *channel != "nozzle" || mean.is_some()).collect()
}

impl Task {
    /// One run; a run with a fault is compared with the same seed's run without.
    pub(super) fn one(
        &self,
        level: Level,
        seed: u64,
        fault_free: &mut BTreeMap<u64, WidthTrace>,
    ) -> anyhow::Result<Run> {
        let started = Instant::now();
        let (printing, notes) = self.print(&self.scenario, seed, self.bag.as_ref())?;
        let wall_time_s = started.elapsed().as_secs_f64();
        if !self.scenario.faults.is_empty() && !fault_free.contains_key(&seed) {
            fault_free.insert(seed, self.print(&Scenario::default(), seed, None)?.0.width);
        }
        Ok(self.report(&printing, fault_free.get(&seed), (level, seed, wall_time_s, notes)))
    }

    fn print(
        &self,
        scenario: &Scenario,
        seed: u64,
        bag: Option<&(PathBuf, PrintInfo)>,
    ) -> anyhow::Result<(Printing, Option<String>)> {
        let mut printing = Printing::new(&self.setup, self.file.job(&self.setup), scenario, seed)?;
        if let Some((bag, info)) = bag {
            let machine = self.setup.sight.as_ref().map(|sight| sight.params.machine);
            printing = printing.with_bagging(Bagging::create(bag, info, machine)?);
        }
        let mut stuck = None;
        while printing.step() {
            if printing.is_stuck() {
                stuck = Some("paused".to_owned());
                break;
            }
        }
        printing.take_bagging().map(Bagging::finish).transpose()?;
        Ok((printing, stuck))
    }

    /// Name of the source of the pressure advance that this level and the host leave in force.
    fn advance_in_force(&self, level: Level) -> &'static str {
        let asked = self.setup.controller.advance.source;
        advance_name(asked.in_force(level, self.setup.simulated.simulator.executor.host))
    }

    fn report(
        &self,
        printing: &Printing,
        fault_free: Option<&WidthTrace>,
        (level, seed, wall_time_s, stuck): (Level, u64, f64, Option<String>),
    ) -> Run {
        let truth = printing.simulator().truth();
        let whole = truth.integrals.since(&Default::default());
        let [settled, late] = printing.settled.map(|at| at.and_then(|at| truth.integrals.since(&at)));
        let [states_not_observed, states_held] = printing.consistency.blind();
        let shares = printing.trimmed.shares();
        let (detections, alarms) =
            printing.noticed.iter().cloned().partition::<Vec<_>, _>(|found| found.onset_s.is_some());
        let ended = stuck.unwrap_or_else(|| match printing.simulator().phase() {
            JobPhase::Done => "done".to_owned(),
            other => format!("{other:?}").to_lowercase(),
        });
        Run {
            gcode_oddities: self.file.oddities(),
            gcode: self.file.name(),
            material: self.setup.material.name.clone(),
            scenario: self.names.scenario.clone(),
            control: name_of(level).to_owned(),
            host: self.names.host.clone(),
            advance: self.names.advance.clone(),
            advance_in_force: self.advance_in_force(level),
            buffer: self.names.buffer,
            without: self.names.without.clone(),
            with: self.names.with.clone(),
            states_not_observed,
            states_held,
            filter: filter_name(self.setup.estimator.filter),
            seed,
            ended,
            print_time_s: truth.stamp_s,
            wall_time_s,
            realtime_factor: truth.stamp_s / wall_time_s,
            quality_mean: whole.map(|figures| figures.quality_mean),
            width_rms_rel: whole.map(|figures| figures.width_rms_rel),
            corner_width_rms_rel: printing.foresight.corners.rms(),
            corner_time_s: printing.foresight.corners.time_s(),
            feed_error_rel: whole.and_then(|figures| figures.feed_error_rel),
            feed_error_after_2s_rel: settled.and_then(|figures| figures.feed_error_rel),
            feed_error_after_8s_rel: late.and_then(|figures| figures.feed_error_rel),
            recovery_time_s: fault_free
                .zip(printing.onset_path_s)
                .and_then(|(fault_free, onset_s)| printing.width.recovery_s(fault_free, onset_s)),
            recovery_5s_s: fault_free
                .zip(printing.onset_path_s)
                .and_then(|(fault_free, onset_s)| printing.width.recovery_for_s(fault_free, onset_s, HELD_S)),
            nis_mean: nis_by_channel(printing),
            nees_median: printing.consistency.median(),
            nees_told: printing.consistency.told(),
            coverage: printing.consistency.coverage(),
            coverage_states: STATE_NAMES,
            trimmed_share: shares.map(|shares| shares.trimmed),
            feedback_share: shares.map(|shares| shares.fed_back),
            slowed_share: shares.map(|shares| shares.slowed),
            detections,
            false_alarms: alarms.len(),
            false_alarm_list: alarms,
            max_command: printing.extremes,
            file_pauses: printing.file_pauses.clone(),
            advance_control: printing.foresight.figures(&printing.controller().report().advance),
            camera: printing.sight(),
        }
    }
}
