//! Package files: `package.xml` after REP 149, the Debian package, the container file.

use super::{PREFIX, cargo_version, root};
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

fn read(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Names and texts of the elements of a package.xml that stand one level deep, in order.
fn elements(text: &str) -> Vec<(String, String)> {
    let body = text.split_once("<package format=\"3\">").unwrap().1.split_once("<export>").unwrap().0;
    let mut found = Vec::new();
    for part in body.split('<').filter(|part| !part.trim().is_empty() && !part.starts_with('/')) {
        let (tag, inside) = part.split_once('>').unwrap();
        found.push((tag.split(' ').next().unwrap().to_owned(), inside.trim().to_owned()));
    }
    found
}

fn of(elements: &[(String, String)], tag: &str) -> Vec<String> {
    elements.iter().filter(|(name, _)| name == tag).map(|(_, text)| text.clone()).collect()
}

/// REP 149: what a manifest of format 3 must hold, in the order of its schema, and what may stand in it.
#[test]
fn both_manifests_are_of_format_3() {
    const ORDER: [&str; 10] = [
        "name",
        "version",
        "description",
        "maintainer",
        "license",
        "buildtool_depend",
        "depend",
        "exec_depend",
        "member_of_group",
        "export",
    ];
    for (folder, name) in [("msgs", "fdm_loop_msgs"), ("launch_scripts", "fdm_loop")] {
        let text = read(&format!("{folder}/package.xml"));
        let elements = elements(&text);
        let places: Vec<usize> =
            elements.iter().map(|(tag, _)| ORDER.iter().position(|known| known == tag).unwrap()).collect();
        assert!(places.is_sorted(), "{folder}: {elements:?}");
        assert_eq!(of(&elements, "name"), [name]);
        assert_eq!(of(&elements, "version"), [cargo_version()]);
        assert_eq!(of(&elements, "license"), ["Apache-2.0"]);
        assert!(
            text.contains("<maintainer email=\"") && text.contains("<build_type>ament_cmake</build_type>")
        );
        let cmake = read(&format!("{folder}/CMakeLists.txt"));
        assert!(cmake.contains(&format!("project({name}")), "{folder}: project of CMakeLists.txt");
    }
}

/// Every package that a definition or CMake names is declared, and the other way round.
#[test]
fn the_interface_package_declares_what_its_definitions_use() {
    let elements = elements(&read("msgs/package.xml"));
    let cmake = read("msgs/CMakeLists.txt");
    let depends: BTreeSet<String> = of(&elements, "depend").into_iter().collect();
    let mut used = BTreeSet::new();
    for folder in ["msgs/msg", "msgs/srv"] {
        for entry in std::fs::read_dir(root().join(folder)).unwrap() {
            let text = std::fs::read_to_string(entry.unwrap().path()).unwrap();
            let types = text
                .lines()
                .map(|line| line.split('#').next().unwrap())
                .filter_map(|line| line.split_whitespace().next());
            used.extend(types.filter_map(|name| Some(name.split_once('/')?.0.to_owned())));
        }
    }
    // What a header brings with it is named by its own package as well.
    used.insert("builtin_interfaces".to_owned());
    assert_eq!(used, depends);
    let listed = cmake.split_once("DEPENDENCIES ").unwrap().1.lines().next().unwrap();
    assert_eq!(listed.split_whitespace().map(str::to_owned).collect::<BTreeSet<_>>(), depends);
    let buildtools = of(&elements, "buildtool_depend");
    let found: BTreeSet<&str> =
        cmake.split("find_package(").skip(1).map(|rest| rest.split(' ').next().unwrap()).collect();
    let declared: BTreeSet<&str> = depends.iter().chain(&buildtools).map(String::as_str).collect();
    assert_eq!(found, declared);
    assert_eq!(of(&elements, "member_of_group"), ["rosidl_interface_packages"]);
}

fn dpkg_deb(arguments: &[&str], package: &Path) -> String {
    let output = Command::new("dpkg-deb").args(arguments).arg(package).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// What the units read beside a node's own file is there, and so is what the links of `postinst` lead to.
fn files_of_units(files: &BTreeSet<&str>) {
    let postinst = read("launch_scripts/debian/postinst");
    let named: Vec<String> = files
        .iter()
        .filter(|file| file.ends_with(".conf"))
        .flat_map(|file| {
            let text = read(&file.replace("/usr/lib/systemd/system", "launch_scripts/systemd"));
            text.split([' ', '"', '\n']).map(str::to_owned).collect::<Vec<_>>()
        })
        .filter(|word| word.ends_with(".yaml"))
        .collect();
    assert!(named.len() >= 6, "{named:?}");
    for file in named {
        let link = file.strip_prefix("/etc/fdm_loop/").and_then(|name| name.strip_suffix(".yaml"));
        let target = link.map(|name| {
            let choice = postinst.split_whitespace().find_map(|word| word.strip_prefix(&format!("{name}=")));
            format!("/usr/share/fdm_loop/config/{}.yaml", choice.unwrap().trim_end_matches(';'))
        });
        let file = target.unwrap_or(file);
        assert!(files.contains(file.as_str()), "{file}");
    }
}

/// Built from the programs of the other tests: its scripts, its owner, and that nothing in it speaks of a file that it
/// does not hold.
#[test]
fn the_debian_package_holds_what_its_units_start() {
    let folder = PREFIX.join("..");
    let built = Command::new(root().join("launch_scripts/debian/build.sh"))
        .args([folder.join("programs"), folder.clone()])
        .env("DPKG_DEB_COMPRESSOR_TYPE", "none")
        .output()
        .unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let architecture = Command::new("dpkg").arg("--print-architecture").output().unwrap();
    let architecture = String::from_utf8(architecture.stdout).unwrap();
    let package = folder.join(format!("fdm-loop_{}_{}.deb", cargo_version(), architecture.trim()));
    let control = dpkg_deb(&["--field"], &package);
    let depends = control.lines().find_map(|line| line.strip_prefix("Depends: ")).unwrap();
    for library in ["libc6 (>= 2.", "libstdc++6", "libopencv-core", "libopencv-imgproc"] {
        assert!(depends.contains(library), "{library} in {depends}");
    }
    let contents = dpkg_deb(&["--contents"], &package);
    let files: BTreeSet<&str> = contents
        .lines()
        .map(|line| {
            assert!(line.split_whitespace().nth(1) == Some("root/root"), "{line}");
            line.split_whitespace().nth(5).unwrap().trim_start_matches('.')
        })
        .collect();
    let conffiles = dpkg_deb(&["--info"], &package);
    assert!(conffiles.contains("conffiles"));
    let target = read("launch_scripts/systemd/fdm_loop.target");
    let nodes: Vec<&str> =
        target.split("fdm_loop@").skip(1).map(|rest| rest.split('.').next().unwrap()).collect();
    for node in &nodes {
        for file in [
            format!("/usr/lib/fdm_loop/{node}"),
            format!("/usr/share/fdm_loop/config/{node}.param.yaml"),
            format!("/etc/fdm_loop/{node}.param.yaml"),
        ] {
            assert!(files.contains(file.as_str()), "{file}");
        }
    }
    for entry in ["fdm_loop.target", "fdm_loop@.service", "fdm_loop-loopback.service"] {
        assert!(files.contains(format!("/usr/lib/systemd/system/{entry}").as_str()), "{entry}");
    }
    files_of_units(&files);
    for script in ["postinst", "prerm", "postrm"] {
        let checked =
            Command::new("sh").arg("-n").arg(root().join("launch_scripts/debian").join(script)).status();
        assert!(checked.unwrap().success(), "{script}");
    }
}

/// Statements with their continued lines, comments left out.
fn statements(text: &str) -> Vec<String> {
    let joined = text
        .lines()
        .filter(|line| !line.starts_with('#'))
        .collect::<Vec<_>>()
        .join("\n")
        .replace("\\\n", " ");
    joined
        .lines()
        .map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "))
        .filter(|line| !line.is_empty())
        .collect()
}

/// No container runs here: the statements are held against `setup.sh`, and against what the package lays out.
#[test]
fn the_container_file_builds_as_setup_does_and_runs_without_rights() {
    let text = read("launch_scripts/Containerfile");
    let statements = statements(&text);
    for statement in &statements {
        let word = statement.split(' ').next().unwrap();
        assert!(
            ["FROM", "RUN", "ENV", "WORKDIR", "COPY", "USER", "ENTRYPOINT", "CMD"].contains(&word),
            "{statement}"
        );
    }
    let setup = read("launch_scripts/setup.sh");
    let needed = setup
        .lines()
        .find_map(|line| line.strip_prefix("need_packages ").filter(|rest| !rest.contains("curl")));
    let installs: Vec<&String> = statements.iter().filter(|line| line.contains("apt-get install")).collect();
    for package in needed.unwrap().split(' ') {
        assert!(installs[0].contains(&format!(" {package}")), "{package} in {}", installs[0]);
    }
    assert_eq!(installs.len(), 2);
    for line in installs {
        assert!(
            line.contains("--no-install-recommends") && line.contains("rm -rf /var/lib/apt/lists/*"),
            "{line}"
        );
    }
    let stages: Vec<&String> = statements.iter().filter(|line| line.starts_with("FROM ")).collect();
    assert_eq!(stages.len(), 2);
    assert!(stages.iter().all(|line| line.contains("debian:12-slim")) && stages[0].ends_with(" AS build"));
    // Nothing runs as root once the package is in place, by a number that needs no /etc/passwd to be seen as such.
    let user = statements.iter().position(|line| line == "USER 10001:10001").unwrap();
    let last_run = statements.iter().rposition(|line| line.starts_with("RUN ")).unwrap();
    assert!(user > last_run);
    assert!(statements.contains(&"ENTRYPOINT [\"/usr/bin/fdm\"]".to_owned()));
    assert!(PREFIX.join("bin/fdm").exists());
    for script in
        text.split_whitespace().filter(|word| word.starts_with("launch_scripts/") && word.ends_with(".sh"))
    {
        assert!(root().join(script).is_file(), "{script}");
    }
}
