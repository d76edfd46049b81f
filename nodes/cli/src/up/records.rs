//! What the supervisor of a print remembers lies beside the bag: for one that is started again, not for another print.

use anyhow::Context;
use std::path::{Path, PathBuf};

/// How the names of the records begin: the latch, what stands beside it, and either while it is written.
const RECORDS: &str = "latch.";

/// The latch in a folder of logs.
pub(super) fn latch(logs: &Path) -> PathBuf {
    logs.join(format!("{RECORDS}json"))
}

/// Removes the records from a folder of logs. A supervisor that found a pause of a former print would take it over, and the
/// new one would stand from its first moment on.
///
/// # Errors
/// The file or folder that cannot be read or removed.
pub(super) fn forget(logs: &Path) -> anyhow::Result<()> {
    for entry in std::fs::read_dir(logs).with_context(|| logs.display().to_string())? {
        let entry = entry.with_context(|| logs.display().to_string())?;
        if entry.file_name().to_string_lossy().starts_with(RECORDS) {
            let path = entry.path();
            std::fs::remove_file(&path).with_context(|| path.display().to_string())?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_of_a_former_print_go_and_its_logs_stay() {
        let folder = std::env::temp_dir().join(format!("fdm_records_{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        for name in ["latch.standing.json", "latch.new", "imu.log", "config.txt"] {
            std::fs::write(folder.join(name), "x").unwrap();
        }
        std::fs::write(latch(&folder), "x").unwrap();
        forget(&folder).unwrap();
        let mut left: Vec<_> =
            std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        left.sort();
        assert_eq!(left, ["config.txt", "imu.log"]);
        std::fs::create_dir(latch(&folder)).unwrap();
        let refused = forget(&folder).unwrap_err().to_string();
        assert!(refused.ends_with("latch.json"), "{refused}");
        std::fs::remove_dir_all(folder).unwrap();
    }
}
