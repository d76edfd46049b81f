//! What travels between printer and brains, by the topic on which it would: the place where a fault of a message, a
//! node or the network can be put in.

use fdm_loop_msgs::{FilamentMotion, Header, Temperature};
use models::command::{Command, ControlHealth, EstimateHealth, Permit};
use models::status::PrinterStatus;
use models::units::{Celsius, Seconds};
use printer_sim::imu::Batch;
use runtime::wire::{self, ImuReading, WireError};
use safety_supervisor::VisionReport;
use serde::Deserialize;

/// The way of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Lane {
    /// Hot end temperature.
    Hotend,
    /// Bed temperature.
    Bed,
    /// Temperature of the sensor in the nozzle.
    Nozzle,
    /// Filament encoder.
    Encoder,
    /// State of the printer.
    Printer,
    /// Accelerations.
    Imu,
    /// Frames of the camera.
    Frames,
    /// What the camera's judge says.
    Vision,
    /// Estimates, of which the supervisor takes that there are any.
    Estimate,
    /// Commands of the controller.
    Command,
    /// Permits of the supervisor.
    Permit,
}

/// A message and when it was made.
#[derive(Debug, Clone)]
pub struct Message {
    /// Its header's stamp on the sender's clock.
    pub stamp: Seconds,
    /// What it says.
    pub content: Content,
}

/// What a message says.
#[derive(Debug, Clone)]
pub enum Content {
    /// Hot end temperature as read.
    Hotend(Celsius),
    /// Bed temperature as read.
    Bed(Celsius),
    /// Nozzle temperature as read.
    Nozzle(Celsius),
    /// Filament seen since start `[m]`.
    Encoder(f64),
    /// State of printer and job.
    Printer(Box<PrinterStatus>),
    /// Accelerations since the last batch.
    Imu(Box<Batch>),
    /// A picture.
    Frame(Vec<u8>),
    /// What a picture says.
    Vision(VisionReport),
    /// The estimator has worked, and how it is.
    Estimate(EstimateHealth),
    /// A controller's wish, and how its work goes.
    Command(Command, ControlHealth),
    /// What the supervisor allows.
    Permit(Permit),
}

impl Message {
    /// A message made at `stamp`.
    #[must_use]
    pub fn new(stamp: Seconds, content: Content) -> Self {
        Self { stamp, content }
    }

    /// Its way.
    #[must_use]
    pub fn lane(&self) -> Lane {
        match self.content {
            Content::Hotend(_) => Lane::Hotend,
            Content::Bed(_) => Lane::Bed,
            Content::Nozzle(_) => Lane::Nozzle,
            Content::Encoder(_) => Lane::Encoder,
            Content::Printer(_) => Lane::Printer,
            Content::Imu(_) => Lane::Imu,
            Content::Frame(_) => Lane::Frames,
            Content::Vision(_) => Lane::Vision,
            Content::Estimate(_) => Lane::Estimate,
            Content::Command(..) => Lane::Command,
            Content::Permit(_) => Lane::Permit,
        }
    }
}

impl Message {
    /// What a node's own conversion makes of it where it has gone over the wire.
    ///
    /// # Errors
    /// What the conversion refuses.
    pub fn over_the_wire(self) -> Result<Self, WireError> {
        let Self { stamp, content } = self;
        let header = Header::at(stamp.0);
        let temperature = |temp: Celsius| {
            let header = header.clone();
            wire::temperature_from_wire(&Temperature { header, temperature: temp.0, variance: 0.0 })
        };
        let (stamp, content) = match content {
            Content::Hotend(temp) => temperature(temp).map(|(stamp, temp)| (stamp, Content::Hotend(temp)))?,
            Content::Bed(temp) => temperature(temp).map(|(stamp, temp)| (stamp, Content::Bed(temp)))?,
            Content::Nozzle(temp) => temperature(temp).map(|(stamp, temp)| (stamp, Content::Nozzle(temp)))?,
            Content::Encoder(position_m) => {
                let read = wire::filament_from_wire(&FilamentMotion { header, position_m, speed_m_s: 0.0 })?;
                (read.stamp, Content::Encoder(read.position_m))
            }
            Content::Printer(status) => {
                let read =
                    wire::status_from_wire(&wire::status_to_wire(&PrinterStatus { stamp, ..*status }))?;
                (read.stamp, Content::Printer(Box::new(read)))
            }
            Content::Imu(batch) => {
                let read = wire::imu_from_wire(&wire::imu_to_wire(&reading(stamp, *batch), ""))?;
                (read.first, Content::Imu(Box::new(batch_of(read))))
            }
            Content::Command(command, health) => {
                let sent = wire::command_to_wire(stamp, &command);
                let read = wire::command_from_wire(&sent)?;
                (wire::stamp_from_wire(&sent.header)?, Content::Command(read, health))
            }
            Content::Permit(permit) => {
                let sent = wire::permit_to_wire(stamp, &permit);
                (wire::stamp_from_wire(&sent.header)?, Content::Permit(wire::permit_from_wire(&sent)?))
            }
            same @ (Content::Frame(_) | Content::Vision(_) | Content::Estimate(_)) => (stamp, same),
        };
        Ok(Self { stamp, content })
    }
}

fn reading(first: Seconds, batch: Batch) -> ImuReading {
    let Batch { first_sequence, period, range_m_s2, samples, .. } = batch;
    ImuReading { first, first_sequence, period, range_m_s2, samples }
}

fn batch_of(read: ImuReading) -> Batch {
    let ImuReading { first, first_sequence, period, range_m_s2, samples } = read;
    Batch { first, first_sequence, period, range_m_s2, samples }
}
