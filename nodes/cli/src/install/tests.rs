//! Laws of installing, with this clone and programs of a few bytes.

use super::*;
use runtime::params::sha256_hex;
use std::collections::BTreeSet;
use std::os::unix::fs::PermissionsExt;

struct Scene {
    folder: PathBuf,
}

impl Scene {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("fdm_install_{name}_{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(folder.join("programs")).unwrap();
        for program in crate::up::recipes::NODES.into_iter().chain(["printer_bridge", "fdm"]) {
            std::fs::write(folder.join("programs").join(program), program).unwrap();
        }
        Self { folder }
    }

    fn prefix(&self) -> PathBuf {
        self.folder.join("prefix")
    }

    fn args(&self) -> InstallArgs {
        InstallArgs {
            prefix: self.prefix(),
            root: None,
            source: Some(Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")),
            programs: Some(self.folder.join("programs")),
            uninstall: false,
            overwrite: false,
            dry_run: false,
            json: None,
        }
    }

    fn refused(&self, change: impl Fn(&mut InstallArgs)) -> String {
        let mut args = self.args();
        change(&mut args);
        format!("{:#}", perform(&args).unwrap_err())
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// Everything below a folder but folders.
fn tree(folder: &Path) -> BTreeSet<PathBuf> {
    let mut found = BTreeSet::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        if path.is_dir() { found.extend(tree(&path)) } else { _ = found.insert(path) }
    }
    found
}

#[test]
fn what_is_installed_is_listed_with_its_checksum_and_taken_away_without_a_trace() {
    let scene = Scene::new("all");
    let prefix = scene.prefix();
    perform(&InstallArgs { dry_run: true, ..scene.args() }).unwrap();
    assert!(!prefix.exists(), "a rehearsal writes nothing");
    perform(&scene.args()).unwrap();
    let list = std::fs::read_to_string(prefix.join(MANIFEST)).unwrap();
    let mut listed: BTreeSet<PathBuf> = BTreeSet::from([prefix.join(MANIFEST)]);
    for line in list.lines() {
        let (sum, path) = line.split_once("  ").unwrap();
        assert_eq!(sum, sha256_hex(&std::fs::read(prefix.join(path)).unwrap()), "{path}");
        listed.insert(prefix.join(path));
    }
    assert_eq!(listed, tree(&prefix));
    assert!(!prefix.join("share/fdm_loop/launch/__pycache__").exists());
    // Again over itself, then away; what a person put beside it stays.
    perform(&scene.args()).unwrap();
    assert_eq!(listed, tree(&prefix));
    let foreign = prefix.join("share/fdm_loop/config/notes.txt");
    std::fs::write(&foreign, "mine").unwrap();
    perform(&InstallArgs { uninstall: true, ..scene.args() }).unwrap();
    assert_eq!(tree(&prefix), BTreeSet::from([foreign]));
    assert!(!prefix.join("lib").exists() && !prefix.join("bin").exists(), "empty folders go too");
}

/// Installed by root with a narrow umask and run by somebody else.
#[test]
fn everybody_may_run_programs_and_read_files() {
    let scene = Scene::new("modes");
    perform(&scene.args()).unwrap();
    for path in tree(&scene.prefix()) {
        let mode = std::fs::metadata(&path).unwrap().permissions().mode() & 0o777;
        let program = path.starts_with(scene.prefix().join("lib")) || path.ends_with("bin/fdm");
        assert_eq!(mode, if program { 0o755 } else { 0o644 }, "{}", path.display());
        let folder = std::fs::metadata(path.parent().unwrap()).unwrap().permissions().mode() & 0o777;
        assert_eq!(folder, 0o755);
    }
    assert_eq!(std::fs::read_to_string(scene.prefix().join("bin/fdm")).unwrap(), "fdm");
}

#[test]
fn what_is_not_ours_is_neither_replaced_nor_taken_away() {
    let scene = Scene::new("foreign");
    let prefix = scene.prefix();
    let marker = prefix.join("share/ament_index/resource_index/packages/fdm_loop");
    // A folder that is somebody's home, not a prefix.
    std::fs::create_dir_all(prefix.join("Documents")).unwrap();
    assert!(scene.refused(|_| ()).contains("holds other files and none of bin/, lib/, share/"));
    // A prefix in which another build of the package stands.
    std::fs::create_dir_all(marker.parent().unwrap()).unwrap();
    std::fs::write(&marker, "").unwrap();
    assert!(
        scene
            .refused(|args| args.overwrite = true)
            .contains("was not installed by fdm install, nor were 0 more")
    );
    assert!(scene.refused(|args| args.uninstall = true).contains("nothing is installed there"));
    std::fs::remove_file(&marker).unwrap();
    perform(&scene.args()).unwrap();
    // Edited in place: said and kept, until told otherwise.
    let edited = prefix.join("share/fdm_loop/config/thermistor.param.yaml");
    std::fs::write(&edited, "mine").unwrap();
    assert!(scene.refused(|_| ()).contains("1 files were changed since they were installed, first"));
    perform(&InstallArgs { uninstall: true, ..scene.args() }).unwrap();
    // It is known as ours still: a second time, and for who installs anew.
    assert_eq!(tree(&prefix), BTreeSet::from([edited.clone(), prefix.join(MANIFEST)]));
    assert_eq!(perform(&InstallArgs { uninstall: true, ..scene.args() }).unwrap().kept.len(), 1);
    assert!(scene.refused(|_| ()).contains("1 files were changed since they were installed, first"));
    perform(&InstallArgs { uninstall: true, overwrite: true, ..scene.args() }).unwrap();
    assert_eq!(tree(&prefix), BTreeSet::new());
    std::fs::create_dir_all(prefix.join("share")).unwrap();
    perform(&scene.args()).unwrap();
    std::fs::write(&edited, "mine").unwrap();
    perform(&InstallArgs { overwrite: true, ..scene.args() }).unwrap();
    assert!(std::fs::read_to_string(&edited).unwrap().contains("ros__parameters"));
}

/// A list that names a path outside of the prefix would have it removed.
#[test]
fn a_list_cannot_reach_outside_of_the_prefix() {
    let scene = Scene::new("list");
    perform(&scene.args()).unwrap();
    let list = scene.prefix().join(MANIFEST);
    for path in ["../victim", "/etc/passwd", "share/../../victim", ""] {
        std::fs::write(&list, format!("{}  {path}\n", sha256_hex(b""))).unwrap();
        let said = scene.refused(|args| args.uninstall = true);
        assert!(said.contains("line 1: expected a checksum and a path below the prefix"), "{path}: {said}");
    }
}

#[test]
fn what_is_asked_wrongly_is_told_before_anything_is_written() {
    let scene = Scene::new("refused");
    for (change, part) in [
        (&(|args: &mut InstallArgs| args.prefix = "/tmp/a b".into()) as &dyn Fn(&mut InstallArgs), "not ' '"),
        (&|args| args.prefix = "/".into(), "must be a folder below /"),
        (&|args| args.prefix = "/opt/../etc".into(), "named without .."),
        (&|args| args.programs = Some("/tmp".into()), "build all programs with `cargo build --release"),
        (&|args| args.source = Some("/tmp".into()), "no clone of the repository"),
        (&|args| args.prefix = args.programs.clone().unwrap(), "holds other files and none of"),
    ] {
        let said = scene.refused(change);
        assert!(said.contains(part), "{said}");
    }
    assert!(!scene.prefix().exists());
}

/// What only a debugger reads is left out of a program, and what is no program is copied as it is.
#[test]
fn programs_are_installed_without_their_debug_information() {
    let scene = Scene::new("bare");
    let test = std::env::current_exe().unwrap();
    let from = scene.folder.join("programs/imu");
    std::fs::copy(&test, &from).unwrap();
    perform(&scene.args()).unwrap();
    let size = |path: &Path| std::fs::metadata(path).unwrap().len();
    let installed = scene.prefix().join("lib/fdm_loop/imu");
    assert!(size(&installed) < size(&from), "{} of {}", size(&installed), size(&from));
    let listed = std::process::Command::new(&installed).arg("--list").output().unwrap();
    assert!(String::from_utf8_lossy(&listed.stdout).contains("programs_are_installed_without"), "it runs");
    assert_eq!(std::fs::read(scene.prefix().join("lib/fdm_loop/camera")).unwrap(), b"camera");
}

/// For a package: written below another folder, and speaking of where it will lie.
#[test]
fn a_root_of_its_own_leaves_no_trace_in_the_files() {
    let scene = Scene::new("root");
    let root = scene.folder.join("stage");
    perform(&InstallArgs { prefix: "/usr".into(), root: Some(root.clone()), ..scene.args() }).unwrap();
    let classifier = root.join("usr/share/fdm_loop/config/defect_classifier.param.yaml");
    let text = std::fs::read_to_string(classifier).unwrap();
    assert!(text.contains("network: /usr/share/fdm_loop/config/models/toolhead.json"), "{text}");
    for path in tree(&root) {
        let text = std::fs::read(&path).unwrap();
        let stage = scene.folder.to_str().unwrap().as_bytes();
        assert!(!text.windows(stage.len()).any(|part| part == stage), "{}", path.display());
        if path.to_string_lossy().ends_with(".param.yaml") {
            assert!(!String::from_utf8_lossy(&text).contains(": config/models/"), "{}", path.display());
        }
    }
}

/// What the texts name a person finds without a clone: each of their links leads to an installed file or folder.
#[test]
fn the_links_of_the_installed_texts_lead_somewhere() {
    let scene = Scene::new("texts");
    perform(&scene.args()).unwrap();
    let doc = scene.prefix().join("share/doc/fdm-loop");
    let mut links = 0;
    for text in
        ["README.md", "nodes/README.md", "launch_scripts/README.md", "launch_scripts/systemd/README.md"]
    {
        let path = doc.join(text);
        let text = std::fs::read_to_string(&path).unwrap();
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let file = link.split('#').next().unwrap_or_default();
            // The source of a topic's name is no text for people.
            if file.is_empty() || file.contains("://") || file.ends_with(".rs") {
                continue;
            }
            assert!(path.parent().unwrap().join(file).exists(), "{}: {link}", path.display());
            links += 1;
        }
    }
    assert!(links >= 12, "{links}");
}
