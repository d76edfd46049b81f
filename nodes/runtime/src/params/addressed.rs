//! Whom a parameter file is for: a node whose name is misspelt there hears nothing of it, and nobody says so.

use super::ParamFileError;
use super::tree::{Tree, root_of};
use std::path::Path;

/// Names of nodes, or patterns of names, that a parameter file has values for, each with its file and line.
///
/// # Errors
/// [`ParamFileError`] for a file that cannot be read or is no YAML.
pub fn addressed(file: &Path) -> Result<Vec<(String, String)>, ParamFileError> {
    let unreadable = |error: std::io::Error| ParamFileError::Unreadable {
        file: file.to_path_buf(),
        reason: error.to_string(),
    };
    let mut names = Vec::new();
    if let Some(root) = root_of(&crate::input::text(file).map_err(unreadable)?, file)? {
        collect(&root, "", &mut names);
    }
    Ok(names)
}

/// A name stands above `ros__parameters`, its namespace above it.
fn collect(tree: &Tree, namespace: &str, names: &mut Vec<(String, String)>) {
    let Tree::Block(entries) = tree else { return };
    for (key, child, origin) in entries {
        let name = if namespace.is_empty() { key.clone() } else { format!("{namespace}/{key}") };
        match child {
            Tree::Block(below) if below.iter().any(|(key, ..)| key == "ros__parameters") => {
                names.push((name, origin.to_string()));
            }
            _ => collect(child, &name, names),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stand_above_their_parameters() {
        let file = std::env::temp_dir().join(format!("fdm_addressed_{}.yaml", std::process::id()));
        let text = "/**:\n  ros__parameters: {a: 1}\nleft:\n  mpc:\n    ros__parameters:\n      ros: 1\nimu: {ros__parameters: {}}\n";
        std::fs::write(&file, text).unwrap();
        let found = addressed(&file).unwrap();
        std::fs::write(&file, "# nothing\n").unwrap();
        let none = addressed(&file).unwrap();
        std::fs::remove_file(&file).unwrap();
        let at = |line: u32| format!("{}:{line}", file.display());
        let wanted =
            [("/**", 1), ("left/mpc", 4), ("imu", 7)].map(|(name, line)| (name.to_owned(), at(line)));
        assert_eq!(found, wanted);
        assert!(none.is_empty());
        assert!(addressed(&file).is_err());
    }
}
