//! A buffer of Linux industrial I/O: finds the device by its name, sets it up through its files, reads scans.
//!
//! Kernel documentation, "Industrial I/O buffers" and `Documentation/ABI/testing/sysfs-bus-iio`. The device's trigger
//! (`trigger/current_trigger`) is left as it is: devices with a FIFO of their own, as the ADXL345, need none.

mod setup;

use std::fs::File;
use std::io::{ErrorKind, Read};
use std::time::Duration;

use models::units::Seconds;
use tokio::time::{Instant, sleep_until};

use crate::params::{IioParams, UnitParams};
use crate::scan::Layout;
use setup::Setup;

/// What the device has to say.
#[derive(Debug, Clone, PartialEq)]
pub enum IioEvent {
    /// The device is set up and open; what was found, for people.
    Found {
        /// Device, rate, scale.
        text: String,
    },
    /// The device could not be set up or was lost.
    Lost {
        /// Why, for people.
        reason: String,
        /// Pause before the next try `[s]`.
        retry_s: f64,
    },
    /// Samples that were complete just now, in the axes of the tool.
    Batch {
        /// Accelerations x, y, z `[m/s2]`.
        samples: Vec<[f64; 3]>,
        /// Time between two samples, by the device's own word.
        period: Seconds,
        /// Largest magnitude an axis can show, as configured `[m/s2]`.
        range_m_s2: f64,
    },
}

/// Bytes taken at once: more than the samples of half a second at any rate.
const CHUNK: usize = 64 * 1024;

/// A device that is opened again whenever it is lost.
#[derive(Debug)]
pub struct Iio {
    params: IioParams,
    unit: UnitParams,
    device: Option<Open>,
    retry_s: f64,
    retry_at: Instant,
}

#[derive(Debug)]
struct Open {
    // Dropped before the set-up, which switches the buffer off.
    file: File,
    setup: Setup,
    layout: Layout,
    bytes: Vec<u8>,
    /// Next look at the file: it is read without waiting, one wake-up a batch.
    due: Instant,
    silent_at: Instant,
}

impl Iio {
    /// Nothing is opened before the first [`Iio::next`].
    #[must_use]
    pub fn new(params: IioParams, unit: UnitParams) -> Self {
        let retry_s = params.retry_min_s;
        Self { params, unit, device: None, retry_s, retry_at: Instant::now() }
    }

    /// The next event; a batch at most every `batch_s`. Cancelling loses nothing.
    pub async fn next(&mut self) -> IioEvent {
        loop {
            let Some(device) = &mut self.device else {
                sleep_until(self.retry_at).await;
                return self.open();
            };
            sleep_until(device.due).await;
            device.due = Instant::now() + Duration::from_secs_f64(self.params.batch_s);
            if let Err(reason) = device.take() {
                return self.lose(reason);
            }
            if device.bytes.len() >= device.layout.bytes() {
                return self.batch();
            }
            if Instant::now() >= device.silent_at {
                let limit_s = self.params.silence_max_s;
                let advice = "does the device need a trigger (trigger/current_trigger)?";
                return self.lose(format!("no samples for {limit_s} s: {advice}"));
            }
        }
    }

    fn open(&mut self) -> IioEvent {
        match Open::new(&self.params, &self.unit) {
            Ok(device) => {
                let text = device.setup.text();
                self.device = Some(device);
                IioEvent::Found { text }
            }
            Err(reason) => self.lose(reason),
        }
    }

    fn lose(&mut self, reason: String) -> IioEvent {
        self.device = None;
        let retry_s = self.retry_s;
        self.retry_at = Instant::now() + Duration::from_secs_f64(retry_s);
        self.retry_s = (2.0 * retry_s).min(self.params.retry_max_s);
        IioEvent::Lost { reason, retry_s }
    }

    /// Everything that is complete; the rest waits.
    fn batch(&mut self) -> IioEvent {
        let Some(device) = &mut self.device else { return self.lose("the device is closed".into()) };
        self.retry_s = self.params.retry_min_s;
        device.silent_at = Instant::now() + Duration::from_secs_f64(self.params.silence_max_s);
        let size = device.layout.bytes();
        let complete = device.bytes.len() / size * size;
        let scans = device.bytes[..complete].chunks_exact(size);
        let samples = scans
            .filter_map(|scan| device.layout.raw(scan))
            .map(|raw| self.params.axes.tool_from_sensor(device.setup.accelerations_m_s2(raw)))
            .collect();
        device.bytes.drain(..complete);
        let period = Seconds(1.0 / device.setup.rate_hz());
        IioEvent::Batch { samples, period, range_m_s2: self.unit.range_m_s2 }
    }
}

impl Open {
    fn new(params: &IioParams, unit: &UnitParams) -> Result<Self, String> {
        let setup = Setup::start(params, unit)?;
        let path = setup.device_file(params);
        let file = setup::open_nonblocking(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        let due = Instant::now() + Duration::from_secs_f64(params.batch_s);
        let silent_at = Instant::now() + Duration::from_secs_f64(params.silence_max_s);
        Ok(Self { file, layout: setup.layout()?, setup, bytes: Vec::new(), due, silent_at })
    }

    /// Takes what is there, as much as a chunk.
    fn take(&mut self) -> Result<(), String> {
        let mut chunk = [0; CHUNK];
        match self.file.read(&mut chunk) {
            Ok(0) => return Err("the device file has ended".into()),
            Ok(count) => self.bytes.extend_from_slice(&chunk[..count]),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {}
            Err(error) => return Err(error.to_string()),
        }
        Ok(())
    }
}
