//! The table of `launch_scripts/README.md`: what it names exists, and no line is without a check.

use super::root;

/// Lines of the table: what is tried, what checks it, what is done by hand.
fn lines(text: &str) -> Vec<[&str; 3]> {
    let table = text.split_once("| tried | checked by | by hand |\n").unwrap().1;
    table
        .lines()
        .skip(1)
        .take_while(|line| line.starts_with("| "))
        .map(|line| {
            let cells: Vec<&str> = line.trim_matches('|').split(" | ").map(str::trim).collect();
            cells.try_into().unwrap_or_else(|cells| panic!("three cells: {cells:?}"))
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

#[test]
fn every_line_of_what_a_ros_user_tries_first_has_a_check_that_exists() {
    let text = std::fs::read_to_string(root().join("launch_scripts/README.md")).unwrap();
    let lines = lines(&text);
    assert!(lines.len() >= 20, "{}", lines.len());
    for [tried, checked, by_hand] in lines {
        let checks: Vec<&str> =
            checked.split('`').skip(1).step_by(2).filter(|word| word.contains("::")).collect();
        assert!(!checks.is_empty(), "{tried}: nothing checks it");
        checks.into_iter().for_each(exists);
        assert!(
            by_hand.contains("untried") || by_hand.contains("done") || by_hand.contains("bare_machine"),
            "{tried}"
        );
    }
}
