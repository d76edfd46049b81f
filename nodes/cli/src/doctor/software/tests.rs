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

/// `/proc` takes no files, whoever asks.
#[test]
fn a_folder_that_takes_no_files_fails() {
    if access("/proc/sys/kernel", Access::WRITE_OK).is_err() {
        assert_eq!(disk(Path::new("/proc/sys/kernel")).level, Level::Fail);
    }
}
