//! Files that belong together are replaced together.

use super::{beside, of_bag};
use anyhow::{Context, bail};
use std::path::{Path, PathBuf};

/// Writes files that belong together: all of them are replaced, or none is.
///
/// # Errors
/// A file that cannot be written, or is one of a bag; then all are as they were.
pub fn write_all_whole(files: &[(PathBuf, String)]) -> anyhow::Result<()> {
    replace_all(files, |from, to| std::fs::rename(from, to))
}

fn replace_all(
    files: &[(PathBuf, String)],
    rename: impl Fn(&Path, &Path) -> std::io::Result<()>,
) -> anyhow::Result<()> {
    for (path, _) in files {
        of_bag::check(path)?;
        if path.is_dir() {
            bail!("{} is a folder, where a file is to be written", path.display());
        }
    }
    let mut replaced = vec![];
    let written = files.iter().try_for_each(|(path, text)| -> anyhow::Result<()> {
        let told = || path.display().to_string();
        std::fs::write(beside(path, "part"), text).with_context(told)?;
        // What stood there, for the way back.
        if path.exists() {
            std::fs::copy(path, beside(path, "old")).map(drop).with_context(told)
        } else {
            Ok(())
        }
    });
    let written = written.and_then(|()| {
        files.iter().try_for_each(|(path, _)| {
            rename(&beside(path, "part"), path).with_context(|| path.display().to_string())?;
            replaced.push(path);
            Ok(())
        })
    });
    if written.is_err() {
        for path in replaced {
            let old = beside(path, "old");
            _ = if old.exists() { std::fs::rename(old, path) } else { std::fs::remove_file(path) };
        }
    }
    for (path, _) in files {
        for name in ["part", "old"] {
            _ = std::fs::remove_file(beside(path, name));
        }
    }
    written
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With a folder `bag` in it.
    fn folder() -> PathBuf {
        let folder = std::env::temp_dir().join(format!("fdm-together-{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(folder.join("bag")).unwrap();
        folder
    }

    /// The last of three cannot be written, has its name taken by a folder, or does not get its name: the first stays as it
    /// was, the second, which is new, is not there, and nothing is left beside them.
    #[test]
    fn files_that_belong_together_are_replaced_together_or_not_at_all() {
        let folder = folder();
        let names = ["a.json", "b.json", "nowhere/c.json", "bag", "d.json"];
        let [first, second, nowhere, taken, last] = names.map(|name| folder.join(name));
        std::fs::write(&first, "old").unwrap();
        std::fs::write(&last, "old").unwrap();
        let count = || std::fs::read_dir(&folder).unwrap().count();
        let before = count();
        let of =
            |third: &Path| [&first, &second, third].map(|path: &Path| (path.to_path_buf(), "new".to_owned()));
        let read = |path: &Path| std::fs::read_to_string(path).unwrap();
        let error = write_all_whole(&of(&nowhere)).unwrap_err().to_string();
        assert_eq!(error, nowhere.display().to_string());
        assert!(count() == before && read(&first) == "old" && !second.exists());
        let error = write_all_whole(&of(&taken)).unwrap_err().to_string();
        assert!(error.starts_with(&taken.display().to_string()) && error.contains("is a folder"), "{error}");
        assert!(count() == before && read(&first) == "old" && !second.exists());
        let torn = |from: &Path, to: &Path| match to == last {
            true => Err(std::io::Error::other("no")),
            false => std::fs::rename(from, to),
        };
        let error = replace_all(&of(&last), torn).unwrap_err().to_string();
        assert_eq!(error, last.display().to_string());
        assert!(count() == before && read(&first) == "old" && read(&last) == "old" && !second.exists());
        write_all_whole(&of(&last)).unwrap();
        assert!([&first, &second, &last].iter().all(|path| read(path) == "new"));
        assert_eq!(count(), before + 1);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
