//! The driver for Linux industrial I/O on a folder and a FIFO that stand in for `/sys/bus/iio/devices` and `/dev`.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

use imu::node::iio::{Iio, IioEvent};
use imu::params::{IioParams, UnitParams};
use rustix::fs::{FileType, Mode, mknodat};

/// Files of an ADXL345 as its kernel driver has them, 16 g.
struct Device {
    root: PathBuf,
}

impl Device {
    fn new(test: &str) -> Self {
        let root = std::env::temp_dir().join(format!("imu_iio_{test}_{}", std::process::id()));
        let folder = root.join("devices/iio:device1");
        fs::create_dir_all(folder.join("scan_elements")).unwrap();
        fs::create_dir_all(folder.join("buffer")).unwrap();
        fs::create_dir_all(root.join("devices/iio:device0")).unwrap();
        fs::create_dir_all(root.join("dev")).unwrap();
        fs::write(root.join("devices/iio:device0/name"), "bme280\n").unwrap();
        for (name, text) in [
            ("name", "adxl345\n"),
            ("in_accel_scale", "0.038245\n"),
            ("in_accel_sampling_frequency", "100.000000\n"),
            ("in_accel_sampling_frequency_available", "100 200 400 800 1600 3200\n"),
            ("buffer/enable", "1\n"),
            ("buffer/length", "2\n"),
            ("buffer/watermark", "1\n"),
            ("scan_elements/in_accel_x_index", "0\n"),
            ("scan_elements/in_accel_y_index", "1\n"),
            ("scan_elements/in_accel_z_index", "2\n"),
            ("scan_elements/in_accel_x_type", "le:s13/16>>0\n"),
            ("scan_elements/in_accel_y_type", "le:s13/16>>0\n"),
            ("scan_elements/in_accel_z_type", "le:s13/16>>0\n"),
            ("scan_elements/in_accel_x_en", "0\n"),
            ("scan_elements/in_accel_y_en", "0\n"),
            ("scan_elements/in_accel_z_en", "0\n"),
            ("scan_elements/in_timestamp_en", "1\n"),
        ] {
            fs::write(folder.join(name), text).unwrap();
        }
        let device = Self { root };
        device.plug_in();
        device
    }

    fn plug_in(&self) {
        mknodat(rustix::fs::CWD, self.fifo(), FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
    }

    fn fifo(&self) -> PathBuf {
        self.root.join("dev/iio:device1")
    }

    /// The sensor's end; held for reading too, so that it opens without a reader.
    fn sensor(&self) -> File {
        OpenOptions::new().read(true).write(true).open(self.fifo()).unwrap()
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.root.join("devices/iio:device1").join(name)).unwrap()
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.root.join("devices/iio:device1").join(name), text).unwrap();
    }

    /// A driver of 1600 Hz whose batches are 8 samples.
    fn driver(&self) -> Iio {
        let root = Path::new(&self.root).display();
        let iio: IioParams = serde_saphyr::from_str(&format!(
            "{{devices: {root}/devices, device_files: {root}/dev, name: adxl345, axes: [\"y\", \"-x\", \"z\"], \
             batch_s: 0.005, silence_max_s: 0.2, retry_min_s: 0.01, retry_max_s: 0.04}}"
        ))
        .unwrap();
        let unit: UnitParams = serde_saphyr::from_str(
            "{frame: imu, up: z, rate_hz: 1600.0, rate_tolerance: 0.1, range_m_s2: 156.9064, sigma_m_s2: 0.3, \
             window_s: 1.0, gravity_tolerance: 0.3, tilt_max_deg: 25.0, output_hz: 100.0, stamp_future_max_s: 0.2, \
             stamp_age_max_s: 0.5, lost_after_s: 0.2}",
        )
        .unwrap();
        Iio::new(iio, unit)
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        drop(fs::remove_dir_all(&self.root));
    }
}

/// Scans of x = 1, y = 2, z = 256 counts; the last one has x at the end of its 13 bits.
fn scans(count: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    for index in 0..count {
        let x: i16 = if index + 1 == count { -4096 } else { 1 };
        for value in [x, 2, 256] {
            bytes.extend(value.to_le_bytes());
        }
    }
    bytes
}

fn executor() -> tokio::runtime::Runtime {
    tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap()
}

/// The bound only ends a test that hangs.
async fn next(driver: &mut Iio) -> IioEvent {
    tokio::time::timeout(Duration::from_secs(20), driver.next()).await.unwrap()
}

fn lost(event: IioEvent) -> (String, f64) {
    let IioEvent::Lost { reason, retry_s } = event else { panic!("{event:?}") };
    (reason, retry_s)
}

#[test]
fn scans_become_accelerations_in_the_axes_of_the_tool() {
    executor().block_on(async {
        let device = Device::new("scans");
        let (mut driver, mut sensor) = (device.driver(), device.sensor());
        let IioEvent::Found { text } = next(&mut driver).await else { panic!("the device is not found") };
        assert!(text.contains("1600 Hz"), "{text}");
        for (name, value) in [
            ("in_accel_sampling_frequency", "1600"),
            ("buffer/enable", "1"),
            ("buffer/length", "1600"),
            ("buffer/watermark", "8"),
            ("scan_elements/in_accel_z_en", "1"),
            ("scan_elements/in_timestamp_en", "0"),
        ] {
            assert_eq!(device.read(name), value, "{name}");
        }
        // In pieces that end within a scan.
        let bytes = scans(8);
        sensor.write_all(&bytes[..20]).unwrap();
        sensor.write_all(&bytes[20..]).unwrap();
        let IioEvent::Batch { samples, period, .. } = next(&mut driver).await else { panic!("no batch") };
        assert_eq!(samples.len(), 8);
        assert!((period.0 - 6.25e-4).abs() < 1e-12);
        // x of the tool is y of the sensor, y is -x: 2, -1 and 256 counts of 0.038245 m/s2.
        for (value, counts) in samples[0].into_iter().zip([2.0, -1.0, 256.0]) {
            assert!((value - counts * 0.038245).abs() < 1e-12);
        }
        assert!((samples[7][1] - 4096.0 * 0.038245).abs() < 1e-9);
        drop(driver);
        assert_eq!(device.read("buffer/enable"), "0", "left as it was found off");
    });
}

#[test]
fn a_device_that_is_unplugged_is_found_again() {
    executor().block_on(async {
        let device = Device::new("unplugged");
        let (mut driver, mut sensor) = (device.driver(), device.sensor());
        assert!(matches!(next(&mut driver).await, IioEvent::Found { .. }));
        sensor.write_all(&scans(8)).unwrap();
        assert!(matches!(next(&mut driver).await, IioEvent::Batch { .. }));
        drop(sensor);
        assert_eq!(lost(next(&mut driver).await), ("the device file has ended".to_owned(), 0.01));
        fs::remove_file(device.fifo()).unwrap();
        let (reason, retry_s) = lost(next(&mut driver).await);
        assert!(reason.contains("No such file") && (retry_s - 0.02).abs() < 1e-12, "{reason} {retry_s}");
        device.plug_in();
        let mut sensor = device.sensor();
        assert!(matches!(next(&mut driver).await, IioEvent::Found { .. }));
        sensor.write_all(&scans(8)).unwrap();
        assert!(matches!(next(&mut driver).await, IioEvent::Batch { .. }));
    });
}

#[test]
fn a_device_that_cannot_be_used_says_what_to_do() {
    executor().block_on(async {
        for (file, text, advice) in [
            ("name", "lis2dh12\n", "found bme280, lis2dh12; set iio.name"),
            ("scan_elements/in_accel_y_type", "le:s99/16>>0\n", "no channel type"),
            ("in_accel_scale", "nan\n", "is no number"),
        ] {
            let device = Device::new("wrong");
            device.write(file, text);
            let (reason, _) = lost(next(&mut device.driver()).await);
            assert!(reason.contains(advice), "{reason} is not {advice}");
        }
        let device = Device::new("silent");
        let (mut driver, _sensor) = (device.driver(), device.sensor());
        assert!(matches!(next(&mut driver).await, IioEvent::Found { .. }));
        let (reason, _) = lost(next(&mut driver).await);
        assert!(reason.contains("trigger"), "{reason}");
    });
}
