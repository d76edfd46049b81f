//! Process noise, and the doubt after a step.

use super::{Covariance, Filter, Running};
use crate::channel::{Channel, widths_tell_slip};
use crate::params::Params;
use crate::printer_model::{State, state};
use models::status::PrinterStatus;

/// Smallest deviation of a process noise `[-]`: a root has to exist.
const FLOOR: f64 = 1e-9;
/// Deviation of a slip of which nothing is known but that it is between none and all, `1/sqrt(12)` `[-]`.
pub(super) const ANY_SLIP: f64 = 0.289;
/// Least share of the feed that is taken to get through where nothing tells how much does `[-]`.
const LEAST_KEPT: f64 = 0.1;

impl Filter {
    /// Other noises and limits from now on; what is known stays as well known as it is.
    pub(crate) fn retune(&mut self, params: Params) {
        self.params = params;
        self.width_noise.retune(params.width.adaptation);
        self.melt_lag.retune(params.melt_lag);
        self.watch.retune(params.health);
    }

    /// Process noise over `dt_s`: a random walk, and the flow's own share where the lag is at work. What stands behind a
    /// width, flow and gain, is scaled as the widths' innovations have taught.
    pub(super) fn noise(&self, run: &Running, status: &PrinterStatus, dt_s: f64) -> Covariance {
        let (process, alone) = (&self.params.process, &self.params.widths_alone);
        let by_widths = run.slip_by_widths();
        let lag_rel = if by_widths { alone.lag_rel } else { process.lag_rel };
        let root = (dt_s / process.reference_period_s).sqrt();
        let belief = run.ukf.belief();
        let filament_m_s = self.model.pushed(&belief.mean, &run.drive);
        let off_m_s = (filament_m_s - belief.mean[state::FLOW].max(0.0)).abs() / self.model.lag_s();
        let off_m_s = off_m_s * (dt_s * process.reference_period_s).sqrt();
        let learnt = self.width_noise.scale().sqrt();
        let flow_std_m_s =
            learnt * (process.flow_rel * self.reference_feed_m_s * root).hypot(lag_rel * off_m_s);
        // nothing can be learned of slip and gain at rest: forget slowly, and never more than the prior knew
        let walk = |std: f64, index: usize, bound: f64| {
            let known = belief.covariance[(index, index)] < bound * bound;
            match (status.depositing, known) {
                (true, _) => std * root,
                (false, true) => (std * root * process.frozen).max(FLOOR),
                (false, false) => FLOOR,
            }
        };
        // what nothing is known of grows to what the prior knew; a variance of zero has no root
        let frozen = |std: f64| {
            let known = belief.covariance[(state::SLIP, state::SLIP)] < self.params.prior.slip_std.powi(2);
            if known { (std * root * process.frozen).max(FLOOR) } else { FLOOR }
        };
        variances([
            process.block_k * root,
            // Where widths tell the slip, what the melt cools the nozzle by would tell it, too, surer than a model of the hot end is.
            if run.nozzle_alive && !by_widths { process.nozzle_seen_k } else { process.nozzle_k } * root,
            process.sensor_k * root,
            flow_std_m_s,
            if run.encoder_alive {
                walk(process.slip, state::SLIP, self.params.prior.slip_std)
            } else if by_widths && status.depositing {
                walk(alone.slip, state::SLIP, ANY_SLIP)
            } else {
                frozen(process.slip_unseen)
            },
            // where widths alone tell, it is the slip that wanders; with nothing that tells of it, the gain may be both
            walk(
                learnt
                    * match (run.encoder_alive, by_widths) {
                        (true, _) => process.gain,
                        (false, true) => alone.gain,
                        (false, false) => process.gain.hypot(process.slip_unseen),
                    },
                state::GAIN,
                self.params.prior.gain_std,
            ),
        ])
    }

    /// What may have changed since no encoder tells of the slip, and shows nowhere: a slip, and the flow that it takes. Widths show
    /// the product of flow and gain alone, so that the gain seems to have changed instead (model book 1.5), or, where the slip is
    /// told by them, what is a spool's is put down to the gear.
    pub(super) fn unseen(&self, run: &Running, x: &State) -> Covariance {
        let process = &self.params.process;
        let (walk, most) = if run.slip_by_widths() {
            (process.gain, self.params.widths_alone.parted_std)
        } else {
            (process.slip_unseen, ANY_SLIP)
        };
        let walked = walk * (run.blind_s / process.reference_period_s).sqrt();
        let mut along = slipping(x);
        along[state::GAIN] = if run.width_alive { x[state::GAIN] / kept(x) } else { 0.0 };
        along * along.transpose() * walked.min(most).powi(2)
    }

    /// Doubt added to the states behind a channel whose innovations stand on one side.
    pub(super) fn doubt(&self, channel: Channel) -> Covariance {
        let mut deviations = [0.0; state::COUNT];
        match channel {
            Channel::Thermistor => {
                deviations[state::BLOCK] = self.params.thermistor.step_std_k;
                deviations[state::NOZZLE] = self.params.thermistor.step_std_k;
                deviations[state::SENSOR] = self.params.thermistor.step_std_k;
            }
            Channel::Nozzle => deviations[state::NOZZLE] = self.params.nozzle_sensor.step_std_k,
            Channel::Encoder => deviations[state::SLIP] = self.params.encoder.step_std,
            Channel::Width => deviations[state::GAIN] = self.params.width.step_std,
        }
        variances(deviations)
    }

    /// Doubt added by a step of the slip of such a deviation that widths alone tell, of which the flow has followed a share.
    pub(super) fn slip_doubt(run: &Running, std: f64, followed: f64) -> Covariance {
        let mut along = State::zeros();
        along[state::SLIP] = 1.0;
        along[state::FLOW] = -followed * run.slipped_m_s;
        along * along.transpose() * std.powi(2)
    }
}

/// What one of slip makes of slip and flow on a road without strokes, once the flow has followed it.
fn slipping(x: &State) -> State {
    let mut along = State::zeros();
    along[state::SLIP] = 1.0;
    along[state::FLOW] = -x[state::FLOW] / kept(x);
    along
}

/// Share of the feed that gets through `[-]`.
fn kept(x: &State) -> f64 {
    (1.0 - x[state::SLIP]).max(LEAST_KEPT)
}

impl Running {
    pub(super) fn slip_by_widths(&self) -> bool {
        widths_tell_slip([true, self.encoder_alive, self.width_alive, self.nozzle_alive])
    }

    pub(super) fn tells_slip(&self) -> bool {
        self.encoder_alive || self.slip_by_widths()
    }
}

pub(super) fn variances(deviations: [f64; state::COUNT]) -> Covariance {
    Covariance::from_diagonal(&State::from(deviations.map(|deviation| deviation * deviation)))
}
