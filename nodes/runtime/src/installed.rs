//! Parameter files of a node that was installed: what `ros2 run` starts without `--params-file`, and what the files of a
//! `--params-file` are laid over, so that they need to say no more than what differs.
//!
//! `fdm install` puts a node into `PREFIX/lib/fdm_loop/` and writes the names of its files, one a line and relative to
//! `PREFIX/share/fdm_loop/config/`, into `<node>.files` there.

use crate::args::Args;
use std::path::{Path, PathBuf};

/// Lays the files that were given over the installed ones of `node`; nothing where this program was not installed.
pub(crate) fn complete(args: Args, node: &str) -> Args {
    let installed = std::env::current_exe().map(|program| files(&program, node)).unwrap_or_default();
    over(installed, args, node)
}

/// Lays the files that were given over these. One with the name of the node's own, as a launch file gives it, takes the
/// place of all of them: what it asks for may be another machine's.
fn over(installed: Vec<PathBuf>, mut args: Args, node: &str) -> Args {
    let own = format!("{node}.param.yaml");
    if !args.params_files.iter().any(|file| file.ends_with(&own)) {
        args.params_files.splice(0..0, installed);
    }
    args
}

fn files(program: &Path, node: &str) -> Vec<PathBuf> {
    let Some(prefix) = program.ancestors().nth(3) else { return Vec::new() };
    let config = prefix.join("share/fdm_loop/config");
    let list = std::fs::read_to_string(config.join(format!("{node}.files"))).unwrap_or_default();
    list.lines().filter(|line| !line.is_empty()).map(|line| config.join(line)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_installed_node_knows_its_files_and_others_do_not() {
        let prefix = std::env::temp_dir().join(format!("fdm_installed_{}", std::process::id()));
        let config = prefix.join("share/fdm_loop/config");
        std::fs::create_dir_all(&config).unwrap();
        std::fs::write(config.join("imu.files"), "imu.param.yaml\nprinters/ender3.yaml\n").unwrap();
        let program = prefix.join("lib/fdm_loop/imu");
        assert_eq!(
            files(&program, "imu"),
            ["imu.param.yaml", "printers/ender3.yaml"].map(|file| config.join(file))
        );
        assert!(files(&program, "camera").is_empty());
        assert!(files(Path::new("/imu"), "imu").is_empty());
        std::fs::remove_dir_all(prefix).unwrap();
    }

    /// A file with three lines is enough; the node's own file, from wherever it is, stands for itself.
    #[test]
    fn a_file_is_laid_over_the_installed_ones_and_another_set_takes_their_place() {
        let paths = |names: &[&str]| names.iter().map(PathBuf::from).collect::<Vec<_>>();
        let after = |given: &[&str]| {
            let args = Args { params_files: paths(given), ..Args::default() };
            over(paths(&["/p/imu.param.yaml", "/p/printers/ender3.yaml"]), args, "imu").params_files
        };
        assert_eq!(after(&[]), paths(&["/p/imu.param.yaml", "/p/printers/ender3.yaml"]));
        assert_eq!(
            after(&["mine.yaml"]),
            paths(&["/p/imu.param.yaml", "/p/printers/ender3.yaml", "mine.yaml"])
        );
        let whole = ["wire/imu.param.yaml", "b.yaml"];
        assert_eq!(after(&whole), paths(&whole));
    }
}
