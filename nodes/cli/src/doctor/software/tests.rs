use super::super::finding::Level;
use super::*;

/// A folder that looks like a machine.
fn machine(name: &str, files: &[(&str, &str)]) -> Machine {
    let root = std::env::temp_dir().join(format!("fdm-doctor-{name}-{}", std::process::id()));
    for (path, text) in files {
        let path = root.join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    Machine::at(&root)
}

#[test]
fn a_system_is_judged_by_its_release() {
    let release = |text: &str, name| system(&machine(name, &[("etc/os-release", text)])).level;
    assert_eq!(
        release("PRETTY_NAME=\"Debian GNU/Linux 12\"\nID=debian\nVERSION_ID=\"12\"\n", "new"),
        Level::Ok
    );
    assert_eq!(release("ID=debian\nVERSION_ID=\"11\"\n", "old"), Level::Warn);
    assert_eq!(release("ID=arch\n", "other"), Level::Warn);
    assert_eq!(system(&machine("none", &[])).found, "unknown");
}

#[test]
fn memory_is_what_programs_can_have() {
    let free = |kib: u64, name| {
        let text = format!("MemTotal:       4000000 kB\nMemFree: 1 kB\nMemAvailable:   {kib} kB\n");
        memory(&machine(name, &[("proc/meminfo", &text)])).level
    };
    assert_eq!(
        [free(400_000, "m0"), free(800_000, "m1"), free(3_000_000, "m2")],
        [Level::Fail, Level::Warn, Level::Ok]
    );
    assert_eq!(kib("MemAvailable: 18446744073709551615 kB", "MemAvailable"), None);
}

/// A folder that is not there yet is judged by the one it will stand in.
#[test]
fn the_disk_of_a_new_folder_is_that_of_its_parent() {
    let found = disk(&std::env::temp_dir().join("not/there/yet"));
    assert!(found.found.contains(&std::env::temp_dir().display().to_string()), "{found}");
}

/// A file stands in the way: nobody, whoever he is, makes files below it.
#[test]
fn a_folder_that_takes_no_files_fails() {
    use std::os::unix::fs::PermissionsExt;
    let folder = std::env::temp_dir().join(format!("fdm-doctor-locked-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::set_permissions(&folder, std::fs::Permissions::from_mode(0o555)).unwrap();
    // The superuser may write there all the same: the check is of what this user can do.
    let may = std::fs::write(folder.join("x"), "x").is_ok();
    assert_eq!(disk(&folder.join("bags")).level == Level::Fail, !may);
    std::fs::write(folder.with_extension("file"), "x").unwrap();
    assert_eq!(disk(&folder.with_extension("file").join("bags")).level, Level::Fail);
}

/// A program of this test: a shell script.
fn program(name: &str, script: &str) -> std::path::PathBuf {
    use std::os::unix::fs::PermissionsExt;
    let folder = std::env::temp_dir().join(format!("fdm-doctor-programs-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join(name);
    std::fs::write(&path, format!("#!/bin/sh\n{script}\n")).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    path
}

/// A node refuses the argument with 2; a missing library is 127 of the loader; whatever else happens is told.
#[test]
fn a_program_that_does_not_come_to_refuse_an_argument_is_told() {
    assert_eq!(loads(&program("sound", "exit 2")), Ok(()));
    let missing = loads(&program("missing", "echo libx.so: not found >&2; exit 127"));
    assert_eq!(missing, Err(Trouble::Library("libx.so: not found".to_owned())));
    let Err(Trouble::Other(said)) = loads(&program("crashes", "kill -SEGV $$")) else {
        panic!("it is ended")
    };
    assert!(said.contains("crashes") && said.contains("signal: 11"), "{said}");
    assert!(matches!(loads(&program("silent", "exit 0")), Err(Trouble::Other(_))));
    assert!(matches!(loads(Path::new("/nowhere/node")), Err(Trouble::Other(_))));
    assert_eq!(judged(vec![]).level, Level::Ok);
    let finding = judged(vec![Trouble::Other("camera ended".to_owned())]);
    assert!(finding.level == Level::Fail && !finding.what_to_do.contains("apt-get"), "{finding}");
}
