//! Between messages and the brain's types.

use fdm_loop_msgs::{BeadWidth, FilamentMotion, Header, PrinterState, StateEstimate, Temperature};
use models::units::Seconds;
use runtime::Reason;
use runtime::wire::{self, WireError};

use crate::channel::{CHANNELS, Channel, WINDOW};
use crate::estimator::Estimate;
use crate::input::{Event, Refused};

pub fn hotend(message: &Temperature) -> Result<(Seconds, Event), WireError> {
    let (stamp, temp) = wire::temperature_from_wire(message)?;
    Ok((stamp, Event::Hotend { stamp, temp }))
}

pub fn nozzle(message: &Temperature) -> Result<(Seconds, Event), WireError> {
    let (stamp, temp) = wire::temperature_from_wire(message)?;
    Ok((stamp, Event::Nozzle { stamp, temp }))
}

pub fn encoder(message: &FilamentMotion) -> Result<(Seconds, Event), WireError> {
    let read = wire::filament_from_wire(message)?;
    Ok((read.stamp, Event::Encoder { stamp: read.stamp, position_m: read.position_m }))
}

pub fn width(message: &BeadWidth) -> Result<(Seconds, Event), WireError> {
    let read = wire::bead_width_from_wire(message)?;
    let event = Event::Width { exposed: read.exposed, width_m: read.width_m, sigma_m: read.sigma_m };
    Ok((read.exposed, event))
}

pub fn printer(message: &PrinterState) -> Result<(Seconds, Event), WireError> {
    let status = wire::status_from_wire(message)?;
    Ok((status.stamp, Event::Printer(status)))
}

/// The brain's counters by the reasons of the diagnostics.
pub fn reasons(refused: &Refused) -> [(Reason, u64); 4] {
    [
        (Reason::NotFinite, refused.not_finite),
        (Reason::OutOfRange, refused.out_of_range),
        (Reason::Stale, refused.stale),
        (Reason::Order, refused.disordered),
    ]
}

/// An estimate as sent.
pub fn estimate(estimate: &Estimate) -> StateEstimate {
    let or_zero = |values: [Option<f64>; CHANNELS]| values.map(|value| value.unwrap_or(0.0)).to_vec();
    StateEstimate {
        header: Header::at(estimate.stamp.0),
        names: wire::STATES.map(str::to_owned).to_vec(),
        x: estimate.x.iter().copied().collect(),
        // Row by row; nalgebra keeps columns.
        covariance: estimate.p.transpose().iter().copied().collect(),
        observed: estimate.observed.to_vec(),
        held: estimate.held().to_vec(),
        reference_feed_m_s: estimate.reference_feed_m_s,
        channels: wire::CHANNELS.map(str::to_owned).to_vec(),
        alive: estimate.alive.to_vec(),
        measured: estimate.nis.map(|nis| nis.is_some()).to_vec(),
        nis: or_zero(estimate.nis),
        nis_mean: or_zero(estimate.nis_mean),
        gated: estimate.gated.to_vec(),
        chi_square: or_zero(Channel::ALL.map(|c| estimate.window[c as usize].map(|window| window.chi2))),
        chi_square_window: u32::try_from(WINDOW).unwrap_or(u32::MAX),
        steps: estimate.steps,
        resets: estimate.resets,
        noise_scale: estimate.noise_scale.to_vec(),
        health: estimate.health as u8,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::printer_model::state;

    /// The names of the wire stand in the order of the brain's indices.
    #[test]
    fn names_and_indices_agree() {
        for (name, index) in [
            ("block_k", state::BLOCK),
            ("nozzle_k", state::NOZZLE),
            ("sensor_k", state::SENSOR),
            ("flow_m_s", state::FLOW),
            ("slip", state::SLIP),
            ("gain", state::GAIN),
        ] {
            assert_eq!(wire::STATES[index], name);
        }
        for (name, channel) in [
            ("thermistor", Channel::Thermistor),
            ("encoder", Channel::Encoder),
            ("width", Channel::Width),
            ("nozzle", Channel::Nozzle),
        ] {
            assert_eq!(wire::CHANNELS[channel as usize], name);
        }
    }
}
