//! Names of nodes in parameter files: what stands under a misspelt one would reach nobody, and nobody would say so.

use super::ConfigDir;
use crate::up::recipes::NODES;
use anyhow::bail;
use runtime::params::addressed;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// The node that takes the simulated printer's place beside a real one.
const BRIDGE: &str = "printer_bridge";

/// Hosts whose state comes so late that they need limits of their own.
const LATE: [&str; 2] = ["moonraker", "octoprint"];

impl ConfigDir {
    /// Refuses files with values for a node that there is not, and a host's file with values for none.
    ///
    /// # Errors
    /// File, line and name, and the names that there are; a file that cannot be read.
    pub fn check_names(&self, material: &str, host: &str) -> anyhow::Result<()> {
        let file = self.file(&format!("hosts/{host}.param.yaml"));
        if LATE.contains(&host) && !file.is_file() {
            bail!(
                "{}: is missing: with another host's limits this one's late word counts for nothing",
                file.display()
            );
        }
        let host = Some(file).filter(|file| file.is_file());
        let of_nodes = NODES.into_iter().flat_map(|node| self.files_of(node, material));
        // One that is not there is told by the node that wants it.
        let files: BTreeSet<PathBuf> = of_nodes.chain(host.clone()).filter(|file| file.is_file()).collect();
        for file in &files {
            let names = addressed(file)?;
            if names.is_empty() && host.as_ref() == Some(file) {
                bail!("{}: holds nothing for any node, which a host's file has to", file.display());
            }
            for (pattern, at) in names {
                let name = pattern.rsplit('/').next().unwrap_or(&pattern);
                if !name.contains('*') && !NODES.contains(&name) && name != BRIDGE {
                    bail!("{at}: no node is called '{name}'; there are {}, {BRIDGE}", NODES.join(", "));
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::tests::copied;

    /// A slip of the pen in a host's file costs the estimator its encoder.
    #[test]
    fn a_misspelt_node_and_a_hosts_file_without_one_are_refused() {
        let folder = copied("names");
        let config = ConfigDir::find(Some(&folder)).unwrap();
        let file = config.file("hosts/moonraker.param.yaml");
        let text = std::fs::read_to_string(&file).unwrap();
        let told = |text: &str| {
            std::fs::write(&file, text).unwrap();
            config.check_names("PLA", "moonraker").map_err(|error| error.to_string())
        };
        assert_eq!(told(&text), Ok(()));
        let line = text.lines().position(|line| line == "state_estimator:").unwrap() + 1;
        let misspelt = told(&text.replace("state_estimator:", "state_estimater:")).unwrap_err();
        let wanted = format!("{}:{line}: no node is called 'state_estimater'; there are ", file.display());
        assert!(misspelt.starts_with(&wanted) && misspelt.contains("state_estimator"), "{misspelt}");
        assert!(told("# nothing\n").unwrap_err().contains("holds nothing for any node"));
        assert!(config.check_names("PLA", "native").is_ok(), "it is not asked for");
        std::fs::remove_file(&file).unwrap();
        let missing = config.check_names("PLA", "moonraker").unwrap_err().to_string();
        assert!(missing.starts_with(&format!("{}: is missing", file.display())), "{missing}");
        assert!(config.check_names("PLA", "serial").is_ok(), "it has none");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
