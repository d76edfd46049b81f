//! What several test targets share; the tests themselves live in these.

pub mod fuzz;

use std::io::Write;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};

/// A domain of DDS for this process and those that it starts, `nth` tells those of one process apart: ports of domains up to
/// 101 lie below the ephemeral ones.
#[must_use]
pub fn own_domain(nth: u32) -> String {
    (20 + (std::process::id() + nth) % 80).to_string()
}

/// Runs a test once more, as the one test of a process with its own domain: a node reads the domain from the environment,
/// which a test cannot change in itself. `None` in that process: it goes on with the test.
///
/// # Errors
/// What the system says, and that no such test ran: a process without tests ends well too.
pub fn run_in_own_domain(test: &str, nth: u32) -> std::io::Result<Option<ExitStatus>> {
    const ALONE: &str = "FDM_TEST_IN_OWN_DOMAIN";
    if std::env::var_os(ALONE).is_some() {
        return Ok(None);
    }
    let mut command = Command::new(std::env::current_exe()?);
    command.args([test, "--exact", "--nocapture"]);
    let ran =
        command.env(ALONE, "1").env("ROS_DOMAIN_ID", own_domain(nth)).stderr(Stdio::inherit()).output()?;
    let text = String::from_utf8_lossy(&ran.stdout);
    std::io::stdout().write_all(&ran.stdout)?;
    if ran.status.success() && !text.contains("1 passed") {
        return Err(std::io::Error::other(format!("{test}: no such test")));
    }
    Ok(Some(ran.status))
}

/// Copies a folder with all that is in it.
///
/// # Errors
/// What the system says.
pub fn copy_folder(from: &Path, to: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(from)? {
        let path = entry?.path();
        let target = to.join(path.file_name().unwrap_or_default());
        if path.is_dir() {
            copy_folder(&path, &target)?;
        } else {
            std::fs::copy(&path, &target)?;
        }
    }
    Ok(())
}
