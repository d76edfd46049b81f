//! The nodes' programs: they lie beside this one.

use anyhow::bail;
use std::path::{Path, PathBuf};

/// Where the program of this name belongs.
///
/// # Errors
/// Where this program lies is not known.
pub(crate) fn beside(name: &str) -> anyhow::Result<PathBuf> {
    Ok(std::env::current_exe()?.parent().map(|folder| folder.join(name)).unwrap_or_default())
}

/// The program of this name, which has to be there.
///
/// # Errors
/// Its path where it was not built, and how it is built.
pub(crate) fn there(name: &str) -> anyhow::Result<PathBuf> {
    let program = beside(name)?;
    built(&program)?;
    Ok(program)
}

/// Refuses a program that was not built.
///
/// # Errors
/// Its path, and how it is built.
pub(crate) fn built(program: &Path) -> anyhow::Result<()> {
    if !program.is_file() {
        bail!("{} is missing: build all nodes with `cargo build --release`", program.display());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_built_is_named() {
        assert_eq!(beside("x").unwrap().parent(), std::env::current_exe().unwrap().parent());
        built(&std::env::current_exe().unwrap()).unwrap();
        let error = there("no_such_node").unwrap_err().to_string();
        assert!(error.contains("no_such_node is missing: build all nodes"), "{error}");
    }
}
