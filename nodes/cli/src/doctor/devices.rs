//! Cameras and serial ports: there, and open to this user.

use super::finding::Finding;
use super::machine::Machine;
use rustix::fs::{Access, access};

/// Beginnings of names in `/dev` behind which a printer or a sensor may be.
pub(super) const SERIAL: [&str; 4] = ["ttyUSB", "ttyACM", "ttyAMA", "rfcomm"];

/// Devices whose name begins so, and whether they can be read and written.
pub(super) fn devices(machine: &Machine, beginnings: &[&str]) -> Vec<(String, bool)> {
    let names = machine.names("dev").into_iter();
    let wanted = names.filter(|name| {
        beginnings.iter().any(|start| {
            name.strip_prefix(start)
                .is_some_and(|rest| !rest.is_empty() && rest.chars().all(|c| c.is_ascii_digit()))
        })
    });
    wanted
        .map(|name| {
            let open =
                access(machine.path(&format!("dev/{name}")), Access::READ_OK | Access::WRITE_OK).is_ok();
            (name, open)
        })
        .collect()
}

/// Cameras of this machine.
pub(super) fn cameras(machine: &Machine) -> Finding {
    const NAME: &str = "cameras";
    let found = devices(machine, &["video"]);
    if found.is_empty() {
        return Finding::ok(
            NAME,
            "none at /dev/video*; cameras over HTTP, video files and folders need none",
        );
    }
    let titled = |name: &str| match machine.text(&format!("sys/class/video4linux/{name}/name")) {
        Some(title) => format!("/dev/{name} ({title})"),
        None => format!("/dev/{name}"),
    };
    judged(NAME, &found, titled, "video")
}

/// Serial ports of this machine.
pub(super) fn serial_ports(machine: &Machine) -> Finding {
    const NAME: &str = "serial ports";
    let found = devices(machine, &SERIAL);
    if found.is_empty() {
        return Finding::ok(
            NAME,
            "none; a printer or a sensor on USB shows up as /dev/ttyUSB0 or /dev/ttyACM0",
        );
    }
    let grabbed = machine
        .names("proc")
        .iter()
        .any(|pid| machine.text(&format!("proc/{pid}/comm")).is_some_and(|name| name == "ModemManager"));
    let finding = judged(NAME, &found, |name| format!("/dev/{name}"), "dialout");
    if grabbed && finding.what_to_do.is_empty() {
        let todo = "ModemManager runs and talks to new ports: sudo systemctl disable --now ModemManager";
        return Finding::warn(NAME, finding.found, todo);
    }
    finding
}

fn judged(
    name: &'static str,
    found: &[(String, bool)],
    titled: impl Fn(&str) -> String,
    group: &str,
) -> Finding {
    let list = |open: bool| {
        let titles: Vec<String> =
            found.iter().filter(|(_, is_open)| *is_open == open).map(|(name, _)| titled(name)).collect();
        titles.join(", ")
    };
    if found.iter().all(|(_, open)| *open) {
        return Finding::ok(name, list(true));
    }
    let todo = format!("sudo usermod -aG {group} $USER, then log in again");
    Finding::warn(name, format!("no permission for {}", list(false)), todo)
}

#[cfg(test)]
mod tests {
    use super::super::finding::Level;
    use super::*;

    fn machine(name: &str, files: &[&str]) -> Machine {
        let root = std::env::temp_dir().join(format!("fdm-devices-{name}-{}", std::process::id()));
        for file in files {
            let path = root.join(file);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "ModemManager\n").unwrap();
        }
        Machine::at(&root)
    }

    #[test]
    fn ports_are_found_by_their_names() {
        let here =
            machine("ports", &["dev/ttyUSB0", "dev/ttyACM11", "dev/ttyS0", "dev/ttyUSB", "dev/video0"]);
        assert_eq!(serial_ports(&here), Finding::ok("serial ports", "/dev/ttyACM11, /dev/ttyUSB0"));
        assert_eq!(cameras(&here), Finding::ok("cameras", "/dev/video0"));
    }

    #[test]
    fn nothing_there_is_nothing_wrong() {
        let here = machine("none", &["dev/null"]);
        assert_eq!([cameras(&here).level, serial_ports(&here).level], [Level::Ok, Level::Ok]);
    }

    #[test]
    fn a_modem_manager_at_the_ports_is_told() {
        let here = machine("modem", &["dev/ttyUSB0", "proc/77/comm"]);
        assert!(serial_ports(&here).what_to_do.contains("ModemManager"));
    }
}
