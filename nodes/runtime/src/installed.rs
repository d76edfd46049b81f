//! Parameter files of a node that was installed: what `ros2 run` starts without `--params-file`.
//!
//! `fdm install` puts a node into `PREFIX/lib/fdm_loop/` and writes the names of its files, one a line and relative to
//! `PREFIX/share/fdm_loop/config/`, into `<node>.files` there.

use crate::args::Args;
use std::path::{Path, PathBuf};

/// Adds the installed files of `node` where no file was given; nothing where this program was not installed.
pub(crate) fn complete(mut args: Args, node: &str) -> Args {
    if args.params_files.is_empty() {
        args.params_files = std::env::current_exe().map(|program| files(&program, node)).unwrap_or_default();
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
        // What was given stands alone.
        let given = Args { params_files: vec!["own.yaml".into()], ..Args::default() };
        assert_eq!(complete(given.clone(), "imu"), given);
    }
}
