//! The files of a device: found by name, channels enabled, rate set and read back, buffer on.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use rustix::fs::OFlags;

use crate::params::{IioParams, UnitParams};
use crate::scan::{Channel, Layout, Storage};

/// Channels of an accelerometer.
const CHANNELS: [&str; 3] = ["in_accel_x", "in_accel_y", "in_accel_z"];

/// A device that is set up; dropping it switches its buffer off.
#[derive(Debug)]
pub(super) struct Setup {
    folder: PathBuf,
    name: String,
    rate_hz: f64,
    /// Scale of x, y, z `[m/s2]` a count.
    scale_m_s2: [f64; 3],
    /// Offset of x, y, z in counts, added before scaling.
    offset: [f64; 3],
}

impl Setup {
    /// Finds the device and switches its buffer on.
    pub(super) fn start(params: &IioParams, unit: &UnitParams) -> Result<Self, String> {
        let folder = find(Path::new(&params.devices), &params.name)?;
        // What cannot be changed while the buffer runs: a run before this one may have left it on.
        write(&folder, "buffer/enable", "0")?;
        let rate_hz = set_rate(&folder, unit)?;
        for entry in fs::read_dir(folder.join("scan_elements")).map_err(|error| said(&folder, &error))? {
            let name = entry.map_err(|error| said(&folder, &error))?.file_name();
            let name = name.to_string_lossy();
            if let Some(channel) = name.strip_suffix("_en") {
                let wanted = if CHANNELS.contains(&channel) { "1" } else { "0" };
                write(&folder, &format!("scan_elements/{name}"), wanted)?;
            }
        }
        // Room for a second; a watermark is not known to every driver, which then wakes us more often.
        write(&folder, "buffer/length", &format!("{:.0}", unit.rate_hz.ceil()))?;
        if folder.join("buffer/watermark").exists() {
            let watermark = (params.batch_s * unit.rate_hz).max(1.0);
            write(&folder, "buffer/watermark", &format!("{watermark:.0}"))?;
        }
        let setup = Self {
            name: params.name.clone(),
            rate_hz,
            scale_m_s2: each(&folder, "scale")?.ok_or_else(|| missing(&folder, "in_accel_scale"))?,
            offset: each(&folder, "offset")?.unwrap_or([0.0; 3]),
            folder,
        };
        write(&setup.folder, "buffer/enable", "1")?;
        Ok(setup)
    }

    pub(super) fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// For people.
    pub(super) fn text(&self) -> String {
        let Self { name, rate_hz, scale_m_s2, folder, .. } = self;
        format!("{name} in {}: {rate_hz} Hz, {} m/s2 a count", folder.display(), scale_m_s2[0])
    }

    /// Path of the file that gives its scans.
    pub(super) fn device_file(&self, params: &IioParams) -> PathBuf {
        Path::new(&params.device_files).join(self.folder.file_name().unwrap_or_default())
    }

    /// Where x, y and z lie in a scan.
    pub(super) fn layout(&self) -> Result<Layout, String> {
        let channel = |name: &str| {
            let index = number(&self.folder, &format!("scan_elements/{name}_index"))?
                .ok_or_else(|| missing(&self.folder, &format!("scan_elements/{name}_index")))?;
            let text = read(&self.folder, &format!("scan_elements/{name}_type"))?
                .ok_or_else(|| missing(&self.folder, &format!("scan_elements/{name}_type")))?;
            let storage = Storage::parse(&text).map_err(|error| error.to_string())?;
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "saturates: an order is enough"
            )]
            let index = index as u32;
            Ok::<_, String>(Channel { index, storage })
        };
        let [x, y, z] = CHANNELS.map(channel);
        Ok(Layout::new([x?, y?, z?]))
    }

    /// `(raw + offset) scale`, as the ABI has it.
    pub(super) fn accelerations_m_s2(&self, raw: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| (raw[axis] + self.offset[axis]) * self.scale_m_s2[axis])
    }
}

impl Drop for Setup {
    fn drop(&mut self) {
        // A device that is gone has no buffer to switch off.
        drop(write(&self.folder, "buffer/enable", "0"));
    }
}

pub(super) fn open_nonblocking(path: &Path) -> io::Result<File> {
    let flags = i32::try_from(OFlags::NONBLOCK.bits()).map_err(io::Error::other)?;
    OpenOptions::new().read(true).custom_flags(flags).open(path)
}

fn find(devices: &Path, wanted: &str) -> Result<PathBuf, String> {
    let entries = fs::read_dir(devices).map_err(|error| said(devices, &error))?;
    let mut found = Vec::new();
    for entry in entries {
        let folder = entry.map_err(|error| said(devices, &error))?.path();
        let Ok(Some(name)) = read(&folder, "name") else { continue };
        if name == wanted {
            return Ok(folder);
        }
        found.push(name);
    }
    found.sort();
    let others = if found.is_empty() { "no device".to_owned() } else { found.join(", ") };
    Err(format!(
        "no {wanted} in {}: found {others}; set iio.name, or load the sensor's driver",
        devices.display()
    ))
}

/// Sets the rate and reads it back.
fn set_rate(folder: &Path, unit: &UnitParams) -> Result<f64, String> {
    for name in ["sampling_frequency", "in_accel_sampling_frequency"] {
        if !folder.join(name).exists() {
            continue;
        }
        let refused = write(folder, name, &unit.rate_hz.to_string()).err();
        let rate_hz = number(folder, name)?.unwrap_or(f64::NAN);
        if refused.is_none() && (rate_hz / unit.rate_hz - 1.0).abs() <= unit.rate_tolerance {
            return Ok(rate_hz);
        }
        let offered = read(folder, &format!("{name}_available"))?.unwrap_or_else(|| "rates unknown".into());
        let wanted = unit.rate_hz;
        return Err(format!(
            "{}: runs at {rate_hz} Hz, not at {wanted}: set unit.rate_hz; offered are {offered}",
            folder.join(name).display()
        ));
    }
    Err(missing(folder, "sampling_frequency"))
}

/// A number of each axis, or the one they share; `None` where there is neither.
fn each(folder: &Path, what: &str) -> Result<Option<[f64; 3]>, String> {
    if let Some(shared) = number(folder, &format!("in_accel_{what}"))? {
        return Ok(Some([shared; 3]));
    }
    let mut values = [0.0; 3];
    for (value, channel) in values.iter_mut().zip(CHANNELS) {
        match number(folder, &format!("{channel}_{what}"))? {
            Some(number) => *value = number,
            None => return Ok(None),
        }
    }
    Ok(Some(values))
}

/// A finite number in a file; `None` where there is no such file.
fn number(folder: &Path, name: &str) -> Result<Option<f64>, String> {
    let Some(text) = read(folder, name)? else { return Ok(None) };
    let value = text.parse().ok().filter(|value: &f64| value.is_finite());
    value.map(Some).ok_or_else(|| format!("{}: {text:?} is no number", folder.join(name).display()))
}

fn read(folder: &Path, name: &str) -> Result<Option<String>, String> {
    let path = folder.join(name);
    match fs::read_to_string(&path) {
        Ok(text) => Ok(Some(text.trim().to_owned())),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(said(&path, &error)),
    }
}

/// An existing file of the device; sysfs files are written whole.
fn write(folder: &Path, name: &str, text: &str) -> Result<(), String> {
    let path = folder.join(name);
    let written = OpenOptions::new().write(true).truncate(true).open(&path);
    written
        .and_then(|mut file| io::Write::write_all(&mut file, text.as_bytes()))
        .map_err(|error| said(&path, &error))
}

fn said(path: &Path, error: &io::Error) -> String {
    format!("{}: {error}", path.display())
}

fn missing(folder: &Path, name: &str) -> String {
    format!("{} is missing: no accelerometer with a buffer", folder.join(name).display())
}
