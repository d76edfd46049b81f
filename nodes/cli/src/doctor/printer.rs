//! The real printer: what the bridge's parameter files name, and whether it is there.

use super::devices::{SERIAL, devices};
use super::finding::Finding;
use super::machine::Machine;
use crate::config::ConfigDir;
use printer_bridge::Params;
use runtime::params::{NodePath, Parameters};
use rustix::fs::{Access, access};
use std::os::unix::fs::FileTypeExt;
use std::path::{Path, PathBuf};

const NAME: &str = "printer";
/// Node, and its own parameters where the systemd units run it.
const BRIDGE: &str = "printer_bridge";
const OWN: &str = "etc/fdm_loop/printer_bridge.param.yaml";

/// What stands where the printer should.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum There {
    Nothing,
    NoDevice,
    Closed,
    Open,
}

/// The port that the bridge would open.
pub(super) fn bridge(machine: &Machine, given: Option<&Path>) -> Finding {
    let (files, params) = match read(machine, given) {
        Ok(read) => read,
        Err(error) => {
            let todo = "mend it before printer_bridge is started; the simulated printer does without";
            return Finding::warn(NAME, format!("{error:#}"), todo);
        }
    };
    let path = &params.serial.path;
    let others: Vec<String> =
        devices(machine, &SERIAL).into_iter().map(|(name, _)| format!("/dev/{name}")).collect();
    let file = files.last().map_or_else(String::new, |file| file.display().to_string());
    told((path, &file), there(machine, path), &others)
}

/// Files of the bridge and what they say.
fn read(machine: &Machine, given: Option<&Path>) -> anyhow::Result<(Vec<PathBuf>, Params)> {
    let mut files = ConfigDir::find(given)?.files_of(BRIDGE, "");
    let own = machine.path(OWN);
    files.extend(own.exists().then_some(own));
    let path = NodePath { qualified: format!("/printer/{BRIDGE}"), base: BRIDGE.to_owned() };
    let parameters = Parameters::read(&files, &[], &path)?;
    parameters.optional::<runtime::FrameParams>("frames")?;
    let params = parameters.without(&["frames"]).parse()?;
    Ok((files, params))
}

fn there(machine: &Machine, path: &str) -> There {
    let device = machine.path(path.trim_start_matches('/'));
    match std::fs::metadata(&device) {
        Err(_) => There::Nothing,
        Ok(found) if !found.file_type().is_char_device() => There::NoDevice,
        Ok(_) if access(&device, Access::READ_OK | Access::WRITE_OK).is_err() => There::Closed,
        Ok(_) => There::Open,
    }
}

fn told((path, file): (&str, &str), there: There, others: &[String]) -> Finding {
    let named = format!("serial.path = {path} ({file})");
    match there {
        There::Open => Finding::ok(NAME, format!("{named} is there and open to this user")),
        There::Nothing if others.is_empty() => Finding::ok(
            NAME,
            format!("{named} is not there: no printer is connected; the simulated one needs none"),
        ),
        There::Nothing => {
            let todo = format!(
                "set serial.path in {file} to the printer's, best to its name below /dev/serial/by-id"
            );
            Finding::warn(NAME, format!("{named} is not there; there are {}", others.join(", ")), todo)
        }
        There::NoDevice => {
            let todo =
                format!("set serial.path in {file} to a serial port: ls -l /dev/serial/by-id shows them");
            Finding::warn(NAME, format!("{named} is no device"), todo)
        }
        There::Closed => {
            let todo = "sudo usermod -aG dialout $USER, then log in again";
            Finding::warn(NAME, format!("no permission for {named}"), todo)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::finding::Level;
    use super::*;

    /// A machine whose bridge is told a port of its own, and the devices that it has.
    fn machine(name: &str, own: &str, links: &[(&str, &str)]) -> Machine {
        let root = std::env::temp_dir().join(format!("fdm-printer-{name}-{}", std::process::id()));
        _ = std::fs::remove_dir_all(&root);
        for folder in ["dev/serial/by-id", "etc/fdm_loop"] {
            std::fs::create_dir_all(root.join(folder)).unwrap();
        }
        std::fs::write(root.join(OWN), format!("/**:\n  ros__parameters:\n    {own}\n")).unwrap();
        for (link, to) in links {
            std::os::unix::fs::symlink(to, root.join(link)).unwrap();
        }
        Machine::at(&root)
    }

    fn found(machine: &Machine) -> Finding {
        let config = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config");
        let finding = bridge(machine, Some(&config));
        _ = std::fs::remove_dir_all(machine.path(""));
        finding
    }

    /// The own file of the machine wins over the shipped one; a name below by-id is a link to the device.
    #[test]
    fn the_port_that_the_bridge_would_open_is_looked_at() {
        const OWN: &str = "serial.path: /dev/serial/by-id/usb-board";
        let fitted = [("dev/serial/by-id/usb-board", "/dev/null"), ("dev/ttyUSB0", "/dev/null")];
        let there = found(&machine("there", OWN, &fitted));
        assert_eq!(there.level, Level::Ok);
        assert!(there.found.starts_with("serial.path = /dev/serial/by-id/usb-board (/"), "{there}");
        let other = found(&machine("other", OWN, &fitted[1..]));
        assert_eq!(other.level, Level::Warn);
        assert!(other.found.ends_with("is not there; there are /dev/ttyUSB0"), "{other}");
        assert!(other.what_to_do.contains("etc/fdm_loop/printer_bridge.param.yaml"), "{other}");
        let none = found(&machine("none", OWN, &[]));
        assert!(none.level == Level::Ok && none.found.contains("no printer is connected"), "{none}");
        let file = found(&machine("file", OWN, &[("dev/serial/by-id/usb-board", "/proc/self/status")]));
        assert!(file.level == Level::Warn && file.found.ends_with("is no device"), "{file}");
    }

    #[test]
    fn a_port_of_others_says_how_to_get_in() {
        let closed = told(("/dev/ttyACM0", "x.yaml"), There::Closed, &[]);
        assert!(closed.level == Level::Warn && closed.what_to_do.contains("dialout"), "{closed}");
    }

    #[test]
    fn what_the_bridge_would_refuse_is_told_with_its_line() {
        let wrong = found(&machine("baud", "serial.baud: 300", &[]));
        assert_eq!(wrong.level, Level::Warn);
        assert!(
            wrong.found.contains("printer_bridge.param.yaml:3: serial.baud = 300 Bd: must be in"),
            "{wrong}"
        );
        let host = found(&machine("host", "host: octoprint", &[]));
        assert!(host.found.contains("disconnect OctoPrint"), "{host}");
        let frames = found(&machine("frames", "frames.parts.nozzle.parent: nozzle", &[]));
        assert!(frames.found.contains("frames.parts.nozzle.parent = nozzle"), "{frames}");
    }
}
