//! The tables of `launch_scripts/README.md`: what they name exists, and no line is missing or without a check.

use super::root;

/// What a ROS user tries in the first half hour: words of the lines that must be there.
const TRIED: [&str; 26] = [
    "apt install",
    "demo.sh",
    "colcon build",
    "pkg executables",
    "--show-args",
    "node list",
    "topic list",
    "topic info",
    "topic hz",
    "topic echo --once",
    "param list",
    "ros2 run",
    "ROS_DOMAIN_ID",
    "ros2 lifecycle",
    "safety/estop",
    "/diagnostics",
    "use_sim_time",
    "bag info",
    "bag play",
    "fdm recover",
    "two printers",
    "TF tree",
    "layouts",
    "Ctrl-C",
    "systemd",
    "container",
];
/// What an independent DDS has to show.
const SHOWN: [&str; 13] = [
    "every message type both ways",
    "rate and loss",
    "six parameter services",
    "lifecycle",
    "/clock",
    "late joiner",
    "kill -9",
    "SIGCONT",
    "stalled subscriber",
    "ten processes",
    "ros_discovery_info",
    "two namespaces",
    "bags",
];

/// Lines of the table below a headline.
fn lines<'a, const N: usize>(text: &'a str, headline: &str) -> Vec<[&'a str; N]> {
    let table = text.split_once(&format!("{headline}\n")).unwrap().1;
    table
        .lines()
        .skip(1)
        .take_while(|line| line.starts_with("| "))
        .map(|line| {
            let cells: Vec<&str> = line.trim_matches('|').split(" | ").map(str::trim).collect();
            cells.try_into().unwrap_or_else(|cells| panic!("{N} cells: {cells:?}"))
        })
        .collect()
}

/// `file::test` in Rust, `file::check` in Python.
fn exists(check: &str) {
    let (file, name) = check.split_once("::").unwrap();
    let text = std::fs::read_to_string(root().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
    let definition = if file.ends_with(".py") { format!("\ndef {name}(") } else { format!("fn {name}(") };
    assert_eq!(text.matches(&definition).count(), 1, "{check}");
    if file.ends_with(".py") {
        // Defined and run.
        assert!(text.matches(name).count() > 1, "{check} is not called");
    } else {
        let before = text.split_once(&definition).unwrap().0.trim_end();
        let attributes = before.rsplit("\n\n").next().unwrap();
        assert!(attributes.contains("#[test]"), "{check} is no test");
    }
}

/// What a line names as its checks: at least one, and each exists.
fn check(line: &str, checked: &str) {
    let checks: Vec<&str> =
        checked.split('`').skip(1).step_by(2).filter(|word| word.contains("::")).collect();
    assert!(!checks.is_empty(), "{line}: nothing checks it");
    checks.into_iter().for_each(exists);
}

/// Each of `wanted` stands in some line.
fn complete(lines: &[&str], wanted: &[&str]) {
    for word in wanted {
        assert!(lines.iter().any(|line| line.contains(word)), "no line tells of '{word}'");
    }
}

#[test]
fn every_line_of_what_a_ros_user_tries_first_has_a_check_that_exists() {
    let text = std::fs::read_to_string(root().join("launch_scripts/README.md")).unwrap();
    let lines: Vec<[&str; 3]> = lines(&text, "| tried | checked by | by hand |");
    complete(&lines.iter().map(|[tried, ..]| *tried).collect::<Vec<_>>(), &TRIED);
    for [tried, checked, by_hand] in lines {
        check(tried, checked);
        assert!(
            by_hand.contains("untried") || by_hand.contains("done") || by_hand.contains("bare_machine"),
            "{tried}"
        );
    }
}

#[test]
fn every_line_of_what_an_independent_dds_shows_has_a_check_that_exists() {
    let text = std::fs::read_to_string(root().join("launch_scripts/README.md")).unwrap();
    let lines: Vec<[&str; 2]> = lines(&text, "| shown | checked by |");
    complete(&lines.iter().map(|[shown, _]| *shown).collect::<Vec<_>>(), &SHOWN);
    lines.into_iter().for_each(|[shown, checked]| check(shown, checked));
    // Whatever stands there is run: the scripts by the test, two graphs by the long run.
    let runs = [root().join("tests/tests/interop.rs"), root().join("launch_scripts/test.sh")]
        .map(|path| std::fs::read_to_string(path).unwrap())
        .concat();
    for entry in std::fs::read_dir(root().join("tests/interop")).unwrap() {
        let path = entry.unwrap().path();
        let script = std::fs::read_to_string(&path).unwrap_or_default();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if script.contains("__main__") {
            assert!(runs.contains(&name), "{name} is run by nobody");
        }
    }
}
