//! What was measured, applied to the belief.

use super::noise::ANY_SLIP;
use super::{Filter, Running};
use crate::channel::{CHANNELS, Channel, Record, Verdict};
use crate::estimator::Inbox;
use crate::intervals::Slip;
use crate::measurement::{self, Observation};
use crate::printer_model::{State, state};
use crate::ukf::{Gaussian, Update};
use models::transient::Transient;

impl Filter {
    /// Applies what was measured; `false` if the filter broke.
    pub(super) fn correct(
        &mut self,
        run: &mut Running,
        inbox: &mut Inbox,
        records: &mut [Record; CHANNELS],
    ) -> bool {
        let now = (run.at_s, run.drive);
        let block = inbox.temperature.take().map(|reading| {
            let what = (state::SENSOR, self.params.thermistor.sigma_k);
            (Channel::Thermistor, measurement::temperature(what, reading, now))
        });
        let nozzle = inbox.nozzle.take().map(|reading| {
            let what = (state::NOZZLE, self.params.nozzle_sensor.sigma_k);
            (Channel::Nozzle, measurement::temperature(what, reading, now))
        });
        let interval = measurement::encoder(&self.params, self.reference_feed_m_s, inbox);
        let encoder = interval.map(|interval| (Channel::Encoder, interval.observation(&self.params.encoder)));
        if let Some(interval) = interval {
            let Gaussian { mean, covariance } = run.ukf.belief();
            let before = Slip { mean: mean[state::SLIP], variance: covariance[(state::SLIP, state::SLIP)] };
            run.intervals.push(interval, before);
        }
        for (channel, observation) in [block, nozzle, encoder].into_iter().flatten() {
            if !self.apply(run, channel, &observation, &mut records[channel as usize]) {
                return false;
            }
        }
        if interval.is_some() && !self.follow_step(run, &mut records[Channel::Encoder as usize]) {
            return false;
        }
        if !self.correct_by_widths(run, inbox, &mut records[Channel::Width as usize]) {
            return false;
        }
        if run.slip_by_widths() {
            // a gear passes no more than it pushes: what seems to is the spool's
            run.ukf.confine(state::SLIP, (0.0, self.params.widths_alone.slip_most));
        }
        true
    }

    fn correct_by_widths(&mut self, run: &mut Running, inbox: &mut Inbox, record: &mut Record) -> bool {
        let (alone, width) = (&self.params.widths_alone, &self.params.width);
        let (imbalance, steady_s, unsteady) = if run.slip_by_widths() {
            (alone.imbalance, alone.steady_s, (alone.unsteady_spread, alone.unsteady_noise))
        } else {
            (width.imbalance, width.steady_s, (0.0, 0.0))
        };
        for frame in inbox.frames.iter() {
            let past = measurement::Past {
                flows: &run.flows,
                slopes: &run.slopes,
                flow_m_s: run.ukf.belief().mean[state::FLOW],
                at_s: run.at_s,
                imbalances: &run.imbalances,
                off_s_m: imbalance / self.reference_feed_m_s,
                steady_s,
                unsteady,
                transient_m: run.transient.rest(run.at_s, self.fade_s()),
            };
            let scale = self.width_noise.scale();
            let Some(observation) = measurement::width(&self.params, scale, frame, &inbox.samples, &past)
            else {
                continue;
            };
            if !self.apply(run, Channel::Width, &observation, record) {
                return false;
            }
        }
        inbox.frames.clear();
        true
    }

    /// Looks for a step of the slip in what the encoder's newest intervals tell together, and takes it as given; `false` if the
    /// filter broke.
    fn follow_step(&mut self, run: &mut Running, record: &mut Record) -> bool {
        let model = self.model;
        if record.rejected() {
            // an encoder that stands still for a moment is no slip of all there is
            run.intervals.clear();
        }
        let Some(observation) = run.intervals.step(&self.params.encoder) else { return true };
        self.steps += 1;
        record.begin();
        run.ukf.inflate(&self.doubt(Channel::Encoder));
        let gate = record.gate(run.encoder_alive);
        let update = run.ukf.update(&observation.measurement(gate), |x| observation.predicted(&model, x));
        !matches!(update, Update::Diverged)
    }

    fn apply(
        &mut self,
        run: &mut Running,
        channel: Channel,
        observation: &Observation,
        record: &mut Record,
    ) -> bool {
        let model = self.model;
        let alone = &self.params.widths_alone;
        let by_widths = channel == Channel::Width && run.slip_by_widths();
        let (gate, step) = if by_widths {
            (alone.gate, alone.step())
        } else {
            (record.gate(run.encoder_alive), record.step())
        };
        let lagging = observation.lagging(&model, &run.ukf.belief().mean);
        let update = if by_widths {
            self.update_doubting(run, observation, (gate, record.deviates(run.at_s)))
        } else {
            run.ukf.update(&observation.measurement(gate), |x| observation.predicted(&model, x))
        };
        record.used_s = Some(run.at_s);
        if channel == Channel::Width && self.opens(run, observation, &update) {
            // whether it fades can be told of what comes from now on
            record.begin();
        }
        if let (Channel::Width, Update::Applied(seen) | Update::Rejected(seen)) = (channel, &update) {
            run.transient.on_rest(run.at_s, seen.residual.x, self.fade_s());
        }
        let verdict = record.note(&update, observation.passing(), step);
        if verdict == Verdict::Stepped && channel == Channel::Width {
            run.transient = Transient::default();
        }
        if observation.is_of_noise() {
            self.learn(channel, verdict, record.nis);
            if let (Some((width_m, lever)), Update::Applied(seen), Verdict::Consistent) =
                (lagging, &update, verdict)
            {
                self.melt_lag.take(lever, seen.residual.x / width_m);
            }
        }
        match verdict {
            Verdict::Consistent | Verdict::Rejected => true,
            Verdict::Diverged => false,
            Verdict::Stepped => {
                self.steps += 1;
                // a spool does not step: where nobody watches the gear, that does
                if by_widths {
                    return self.take_slip(run, observation, gate);
                }
                run.ukf.inflate(&self.doubt(channel));
                true
            }
        }
    }

    /// Takes a width that is off by more than `outlier` deviations with so much more noise that it is off by that many, so that it
    /// counts the less the farther it is off, and tells by how much it was: it is its own mistake, unless the one before is off to
    /// the same side, too.
    fn update_doubting(
        &self,
        run: &mut Running,
        observation: &Observation,
        (gate, before): (f64, f64),
    ) -> Update<1> {
        let most = self.params.widths_alone.outlier.powi(2);
        let predicted = |x: &State| observation.predicted(&self.model, x);
        let update = run.ukf.update(&observation.measurement(most.min(gate)), predicted);
        let Update::Rejected(seen) = update else { return update };
        if seen.nis > gate {
            return update;
        }
        let again = before * seen.residual.x > 0.0 && before.powi(2) > most;
        let excess = if again { 0.0 } else { seen.covariance.x * (seen.nis / most - 1.0) };
        match run.ukf.update(&observation.doubted(excess).measurement(f64::INFINITY), predicted) {
            Update::Applied(_) => Update::Applied(seen),
            other => other,
        }
    }

    /// Takes a step of the slip from the width that tells of it, and its size, too: a usual one, or, where the road thins, any.
    /// A road that widens is of a slip that was told too large: the flow has followed that for long. `false` where no step
    /// explains it: the filter is lost.
    fn take_slip(&self, run: &mut Running, observation: &Observation, gate: f64) -> bool {
        let alone = &self.params.widths_alone;
        let predicted = |x: &State| observation.predicted(&self.model, x);
        let thins = observation.lacks(predicted(&run.ukf.belief().mean).x);
        let (followed, deviations) = if thins {
            (alone.followed, &[alone.step_std, ANY_SLIP][..])
        } else {
            (1.0, &[alone.step_std][..])
        };
        deviations.iter().any(|std| {
            // what was taken for the spool's beside the old slip is none of the new one's; a second doubt comes on top of the first
            run.ukf.freeze(state::SLIP);
            run.ukf.inflate(&Self::slip_doubt(run, *std, followed));
            matches!(run.ukf.update(&observation.measurement(gate), predicted), Update::Applied(_))
        })
    }

    /// Noise is learnt from what passed the gate; a step is none.
    fn learn(&mut self, channel: Channel, verdict: Verdict, nis: Option<f64>) {
        match (channel, verdict, nis) {
            (Channel::Width, Verdict::Consistent, Some(nis)) => self.width_noise.on_accepted(nis),
            (Channel::Width, Verdict::Stepped | Verdict::Diverged, _) => self.width_noise.forget(),
            _ => {}
        }
    }

    /// Whether a transient begins. A width that is rejected while the encoder vouches for the feed is of filament that is
    /// being compressed, or of pressure that was held before the road began: it fades, and what follows is its rest. Where
    /// the innovations stay, they are taken as a step, and that is the end of it.
    fn opens(&self, run: &mut Running, observation: &Observation, update: &Update<1>) -> bool {
        let Update::Rejected(innovation) = update else { return false };
        let residual_m = innovation.residual.x;
        if run.encoder_alive {
            run.transient.on_error(run.at_s, residual_m, self.fade_s());
        }
        run.encoder_alive && observation.is_of_noise()
    }

    fn fade_s(&self) -> f64 {
        self.params.width.transient_lags * self.model.lag_s()
    }
}
