//! Samples into the inbox, or a reason why not.

use super::{Estimator, Frame};
use crate::channel::Channel;
use crate::history::Sample;
use crate::input::{Ages, Reason, check_status, finite, within};
use models::status::PrinterStatus;
use models::units::{Celsius, Kelvin, Seconds};

impl Estimator {
    fn ages(&self, channel: Channel, limit_s: f64) -> Ages {
        let before_s = self.records[channel as usize].seen_s;
        Ages { now_s: self.now_s, lead_s: self.params.telemetry.lead_limit_s, limit_s, before_s }
    }

    pub(super) fn take_temperature(
        &mut self,
        channel: Channel,
        stamp: Seconds,
        temp: Celsius,
    ) -> Result<(f64, Kelvin), Reason> {
        let nozzle = channel == Channel::Nozzle;
        let sensor = if nozzle { &self.params.nozzle_sensor } else { &self.params.thermistor };
        let temp_c = within(temp.0, (sensor.low_c, sensor.high_c))?;
        let stamp_s = self.ages(channel, sensor.trust.age_limit_s).check(stamp)?;
        self.records[channel as usize].seen_s = Some(stamp_s);
        Ok((stamp_s, Celsius(temp_c).into()))
    }

    pub(super) fn take_position(&mut self, stamp: Seconds, position_m: f64) -> Result<(), Reason> {
        let position_m = finite(position_m)?;
        let stamp_s = self.ages(Channel::Encoder, self.params.encoder.trust.age_limit_s).check(stamp)?;
        let jump = self.inbox.positions.newest().is_some_and(|&(before_s, before_m)| {
            (position_m - before_m).abs()
                > self.params.telemetry.motor_speed_max_m_s * (stamp_s - before_s)
                    + self.params.encoder.quantum_m
        });
        self.records[Channel::Encoder as usize].seen_s = Some(stamp_s);
        if jump {
            self.inbox.positions.clear();
            self.inbox.position_used = None;
        }
        self.inbox.positions.push((stamp_s, position_m));
        if jump { Err(Reason::OutOfRange) } else { Ok(()) }
    }

    pub(super) fn take_width(&mut self, exposed: Seconds, width_m: f64, sigma_m: f64) -> Result<(), Reason> {
        let sensor = &self.params.width;
        let width_m = within(width_m, (0.0, sensor.width_max_m))?;
        let sigma_m = within(sigma_m, (0.0, sensor.width_max_m))?;
        let exposed_s = self.ages(Channel::Width, sensor.trust.age_limit_s).check(exposed)?;
        self.records[Channel::Width as usize].seen_s = Some(exposed_s);
        self.inbox.frames.push(Frame { exposed_s, width_m, sigma_m });
        Ok(())
    }

    pub(super) fn take_status(&mut self, status: &PrinterStatus) -> Result<(), Reason> {
        check_status(status)?;
        let newest = self.inbox.samples.newest().copied();
        let ages = Ages {
            now_s: self.now_s,
            lead_s: self.params.telemetry.lead_limit_s,
            limit_s: self.params.telemetry.age_limit_s,
            before_s: newest.map(|sample| sample.stamp_s),
        };
        let stamp_s = ages.check(status.stamp)?;
        let jump = newest.is_some_and(|before| {
            (status.motor_position_m - before.motor_m).abs()
                > self.params.telemetry.motor_speed_max_m_s * (stamp_s - before.stamp_s)
        });
        if jump {
            self.inbox.samples.clear();
        }
        self.inbox.samples.push(Sample {
            stamp_s,
            motor_m: status.motor_position_m,
            wanted_m: status.wanted_position_m,
            slip: status.trims.slip.unwrap_or(0.0),
            path_speed_m_s: status.path_speed_m_s,
            tool_m: [status.position_m[0], status.position_m[1]],
            height_m: status.layer_height_m,
            depositing: status.depositing,
        });
        self.inbox.status = Some(*status);
        if jump { Err(Reason::OutOfRange) } else { Ok(()) }
    }
}
