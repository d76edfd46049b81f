//! Figures and pages take the place of nothing that was recorded.

use anyhow::bail;
use std::io::Read;
use std::path::Path;

/// Endings of recordings: whole, being written, damaged, in the making.
const RECORDINGS: [&str; 4] = [".mcap", ".mcap.active", ".mcap.torn", ".mcap.recovering"];
/// What describes a bag, beside its recordings.
const DESCRIPTIONS: [&str; 3] = ["metadata.yaml", "metadata.yaml.before", "counts.json"];

/// Refuses an output that is a file of a bag, under whatever name, or would be taken for one.
///
/// # Errors
/// The file.
pub(super) fn check(output: &Path) -> anyhow::Result<()> {
    let whole = std::fs::canonicalize(output).or_else(|_| std::path::absolute(output))?;
    let name = whole.file_name().unwrap_or_default().to_string_lossy();
    if is_recordings(&name) || begins_as_a_recording(&whole) {
        bail!("{} is a recording, or named as one: choose another file", output.display());
    }
    let folder = whole.parent().unwrap_or(&whole);
    if DESCRIPTIONS.contains(&&*name) && has_recordings(folder) {
        bail!("{} describes the bag {}: choose another file", output.display(), folder.display());
    }
    Ok(())
}

/// Whether a name is one of a recording.
fn is_recordings(name: &str) -> bool {
    RECORDINGS.iter().any(|ending| name.ends_with(ending))
}

/// Whether a file begins as MCAP files do: it may have been linked or renamed.
fn begins_as_a_recording(file: &Path) -> bool {
    let mut head = [0; mcap::MAGIC.len()];
    runtime::input::open(file).and_then(|mut file| file.read_exact(&mut head)).is_ok() && head == mcap::MAGIC
}

fn has_recordings(folder: &Path) -> bool {
    std::fs::read_dir(folder).is_ok_and(|entries| {
        entries.flatten().any(|entry| is_recordings(&entry.file_name().to_string_lossy()))
    })
}

#[cfg(test)]
mod tests {
    use crate::output::{check_apart, check_writable, write_whole};

    /// By its name, through links of both kinds, renamed, and what describes it; beside it, and where no bag is, all is free.
    #[test]
    fn no_output_takes_the_place_of_a_recording() {
        let folder = std::env::temp_dir().join(format!("fdm-output-of-bag-{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(folder.join("bag")).unwrap();
        let recording = folder.join("bag/a_0.mcap");
        std::fs::write(&recording, mcap::MAGIC).unwrap();
        for name in ["bag/a_1.mcap.active", "bag/metadata.yaml", "bag/counts.json", "metadata.yaml"] {
            std::fs::write(folder.join(name), "x").unwrap();
        }
        std::fs::copy(&recording, folder.join("renamed.json")).unwrap();
        std::fs::hard_link(&recording, folder.join("hard.json")).unwrap();
        std::os::unix::fs::symlink(&recording, folder.join("soft.html")).unwrap();
        for name in [
            "bag/a_0.mcap",
            "bag/a_1.mcap.active",
            "bag/a_2.mcap",
            "bag/metadata.yaml",
            "bag/counts.json",
            "renamed.json",
            "hard.json",
            "soft.html",
        ] {
            let output = folder.join(name);
            let before = std::fs::read(&output).ok();
            for refused in [
                check_writable("--json", &output),
                check_apart(&output, &[]),
                write_whole(&output, "figures"),
            ] {
                let error = refused.unwrap_err().to_string();
                assert!(error.contains(name) && error.ends_with("choose another file"), "{error}");
            }
            assert_eq!(std::fs::read(&output).ok(), before, "{name}");
        }
        for name in ["bag/figures.json", "metadata.yaml", "counts.json", "page.html", "bag/a_0.mcap.html"] {
            check_writable("--json", &folder.join(name)).unwrap();
            write_whole(&folder.join(name), "figures").unwrap();
        }
        std::fs::remove_dir_all(folder).unwrap();
    }
}
