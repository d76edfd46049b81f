//! One trial: a job on the simulated printer, a fault, and what followed.

mod degraded;
pub(in crate::faults) mod off;
mod spans;
mod worse;

use super::catalogue::{Mark, Reaction, TrialSpec};
use crate::config::Setup;
use crate::job::GcodeFile;
use crate::sim::message::Lane;
use crate::sim::printing::Printing;
use crate::sim::relay::Relay;
use degraded::{TakenBack, is_back, kept_too_long};
use models::command::{Mode, Trims};
use models::status::JobPhase;
use models::units::{Celsius, Kelvin};
use off::Off;
use printer_sim::Scenario;
use serde::Serialize;
use worse::{taken_from_a_rival, worse_than};

/// What is said of something that is told and not acted upon.
const FLAGGED: &str = "flagged";
/// Part of a run after the limit in which a late reaction is still measured `[s]`.
const LATE_S: f64 = 10.0;

/// What followed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outcome {
    /// Seed of all noise.
    pub seed: u64,
    /// Time of the simulation at which the fault set in `[s]`; `null` if the job ended before.
    pub onset_s: Option<f64>,
    /// From the onset until the printer did what is asked for `[s]`; `null` if it never did.
    pub reaction_s: Option<f64>,
    /// From the onset until the motor had pushed what the limit allows first `[s]`; `null` if it never did.
    pub pushed_s: Option<f64>,
    /// What the motor pushed between onset and reaction `[mm]`.
    pub pushed_mm: f64,
    /// Layers begun between onset and reaction.
    pub layers: u32,
    /// How the supervisor called it.
    pub found_as: Option<String>,
    /// Something was found before the onset.
    pub early: Option<String>,
    /// More followed than may.
    pub too_much: Option<String>,
    /// From the end of the fault until corrections were back `[s]`.
    pub recovered_s: Option<f64>,
    /// Largest temperature of the block above its set-point from the onset on `[K]`.
    pub overshoot_k: f64,
}

/// A trial with what it needs.
pub struct Trial<'a> {
    /// What is asked for.
    pub spec: &'a TrialSpec,
    /// What has to follow.
    pub reaction: Reaction,
    /// Parameters of the loop.
    pub setup: &'a Setup,
    /// The job.
    pub file: &'a GcodeFile,
    /// The printer starts hot.
    pub warm: bool,
}

/// A run of a trial on its way.
struct Run {
    printing: Printing,
    mark_s: Option<f64>,
    /// Farthest position of the motor, and layer, at the onset.
    from: Option<(f64, u32)>,
    ended: bool,
    taken_back: TakenBack,
    off: Off,
    outcome: Outcome,
}

impl Trial<'_> {
    /// Runs it with one seed.
    ///
    /// # Errors
    /// What the brains refuse of their parameters.
    pub fn run(&self, seed: u64) -> anyhow::Result<Outcome> {
        let job = self.file.job(self.setup);
        let preheat = job.preheat;
        let mut printing = Printing::new(self.setup, job, &Scenario::default(), seed)?
            .with_relay(Relay::new(self.spec.relay.clone(), seed));
        if self.warm {
            printing.simulator_mut().warm_up(&preheat);
        }
        let outcome = Outcome {
            seed,
            onset_s: None,
            reaction_s: None,
            pushed_s: None,
            pushed_mm: 0.0,
            layers: 0,
            found_as: None,
            early: None,
            too_much: None,
            recovered_s: None,
            overshoot_k: 0.0,
        };
        let mut run = Run {
            printing,
            mark_s: None,
            from: None,
            ended: false,
            taken_back: TakenBack::default(),
            off: Off::default(),
            outcome,
        };
        while run.printing.step() || run.outcome.onset_s.is_some() {
            if self.is_over(&mut run)? {
                break;
            }
        }
        Ok(run.outcome)
    }

    /// Looks at one step; whether enough was seen.
    fn is_over(&self, run: &mut Run) -> anyhow::Result<bool> {
        let now_s = run.printing.simulator().now().0;
        let Some(onset_s) = run.outcome.onset_s else {
            self.await_onset(run, now_s)?;
            return Ok(run.outcome.early.is_some());
        };
        let since_s = now_s - onset_s;
        if let Some(duration_s) = self.spec.duration_s
            && since_s >= duration_s
            && !run.ended
        {
            run.ended = true;
            run.printing.relay().into_iter().for_each(|relay| relay.set_active(false));
        }
        self.measure(run, since_s);
        self.look(run, since_s);
        let Some(reaction_s) = run.outcome.reaction_s else {
            return Ok(since_s > self.patience_s());
        };
        let recovering = self.spec.recover_s.is_some_and(|recover_s| {
            run.outcome.recovered_s.is_none()
                && since_s < self.spec.duration_s.unwrap_or(0.0) + recover_s + LATE_S
        });
        let watched_s = self.watched_s().max(self.off_s());
        Ok(!recovering && since_s >= reaction_s + watched_s)
    }

    fn await_onset(&self, run: &mut Run, now_s: f64) -> anyhow::Result<()> {
        let reached = match self.spec.onset.after {
            Mark::Start => true,
            Mark::Printing => run.printing.simulator().phase() == JobPhase::Printing,
            Mark::Deposit => run.printing.simulator().truth().depositing,
        };
        if reached {
            run.mark_s.get_or_insert(now_s);
        }
        if let Some(found) = run.printing.noticed.first() {
            run.outcome.early = Some(format!("{} {}", found.fault, found.action));
        }
        let wait_s = self.spec.onset.time_s + self.spec.onset.spread_s * share_of(run.outcome.seed);
        if run.mark_s.is_some_and(|mark_s| now_s >= mark_s + wait_s) {
            run.outcome.onset_s = Some(now_s);
            for entry in self.spec.entries()? {
                run.printing.simulator_mut().inject(entry);
            }
            run.printing.relay().into_iter().for_each(|relay| relay.set_active(true));
            if let Some(person) = self.spec.person {
                run.printing.ask(person.into());
            }
        }
        Ok(())
    }

    /// What was pushed and begun since the onset, until the reaction.
    fn measure(&self, run: &mut Run, since_s: f64) {
        let status = run.printing.simulator().status();
        let (motor_m, layer) = (status.motor_position_m, status.layer.unwrap_or(0));
        let (from_m, from_layer) = *run.from.get_or_insert((motor_m, layer));
        if run.outcome.reaction_s.is_some() {
            return;
        }
        let outcome = &mut run.outcome;
        outcome.pushed_mm = outcome.pushed_mm.max((motor_m - from_m) * 1e3);
        outcome.layers = layer.saturating_sub(from_layer);
        if self.spec.limit_mm.is_some_and(|limit_mm| outcome.pushed_mm >= limit_mm) {
            outcome.pushed_s.get_or_insert(since_s);
        }
    }

    fn look(&self, run: &mut Run, since_s: f64) {
        let printing = &run.printing;
        let simulator = printing.simulator();
        let status = simulator.status();
        let block_c = Celsius::from(Kelvin(simulator.truth().block_k)).0;
        let excess_k = block_c - status.hotend_sliced_target.0;
        if status.hotend_sliced_target.0 > 0.0 {
            run.outcome.overshoot_k = run.outcome.overshoot_k.max(excess_k);
        }
        let reached = self.reached(printing);
        if run.outcome.reaction_s.is_none() && reached {
            run.outcome.reaction_s = Some(since_s);
            run.outcome.found_as = self.found(printing);
        }
        let let_go = (self.spec.lasts && run.outcome.reaction_s.is_some() && !reached)
            .then(|| format!("let go after {since_s:.2} s"));
        let most = self.spec.at_most.unwrap_or(self.reaction);
        let printer = simulator.in_force().mode == Mode::Degraded;
        let supervisor = printing.safety.is_some_and(|state| state.mode == Mode::Degraded);
        let degraded_s = run.taken_back.look(since_s, printer, supervisor);
        let late_s: f64 = self.spec.relay.iter().map(|relay| relay.keeps_back_s(Lane::Permit)).sum();
        let degraded_s = degraded_s.map(|degraded_s| degraded_s - late_s);
        let kept = kept_too_long(degraded_s, &simulator.in_force().trims);
        let told = self.spec.recover_s.is_none()
            && run.outcome.reaction_s.is_some_and(|reaction_s| since_s > reaction_s + self.watched_s());
        let worse = worse_than(most, printing).filter(|_| !told);
        let behind_s = run.outcome.reaction_s.map(|reaction_s| since_s - reaction_s);
        let heated = behind_s.and_then(|behind_s| run.off.look(self.reaction, behind_s, printing));
        if let Some(worse) =
            worse.or_else(|| taken_from_a_rival(&self.spec.relay, printing)).or(kept).or(heated).or(let_go)
        {
            run.outcome.too_much.get_or_insert(worse);
        }
        let in_force = simulator.in_force();
        if run.ended && is_back(&self.spec.control, in_force) {
            run.outcome.recovered_s.get_or_insert(since_s - self.spec.duration_s.unwrap_or(0.0));
        }
    }

    /// What the supervisor calls it: the cause in force, or what it has flagged.
    fn found(&self, printing: &Printing) -> Option<String> {
        if self.reaction == Reaction::Flagged {
            let flagged = printing.noticed.iter().find(|found| found.action == FLAGGED);
            return flagged.map(|found| found.fault.to_string());
        }
        printing.safety.and_then(|state| state.cause).map(|cause| cause.id().to_owned())
    }

    /// Whether the printer does what is asked for.
    fn reached(&self, printing: &Printing) -> bool {
        let simulator = printing.simulator();
        let in_force = simulator.in_force();
        match self.reaction {
            Reaction::None | Reaction::Told => false,
            Reaction::Flagged => printing.noticed.iter().any(|found| found.action == FLAGGED),
            // Neutral by the dead-man: the slicer's values may have been in force before.
            Reaction::Baseline => in_force.lapsed && in_force.trims == Trims::NEUTRAL,
            Reaction::Observe => printing.safety.is_some_and(|state| state.set_mode == Mode::Observe),
            Reaction::Degraded => in_force.mode >= Mode::Degraded && !in_force.lapsed,
            Reaction::Paused => matches!(simulator.phase(), JobPhase::Paused | JobPhase::Failed),
            Reaction::SafeOff => simulator.phase() == JobPhase::Failed,
            Reaction::Estop => !simulator.mains_on(),
        }
    }
}

/// A number in `[0, 1)` of each seed, evenly spread: multiples of the golden ratio.
pub(super) fn share_of(seed: u64) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "seeds are small")]
    let seed = seed as f64;
    (seed * 0.618_033_988_749_894_9).fract()
}

#[cfg(test)]
mod tests;
