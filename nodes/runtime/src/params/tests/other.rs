//! Files that are no parameter files: scenarios, say.

use super::*;

/// A file of another kind, as scenarios are, says it in the same words.
#[test]
fn a_name_that_stands_twice_is_told_with_both_lines() {
    let file = std::env::temp_dir().join(format!("fdm_twice_{}.yaml", std::process::id()));
    std::fs::write(&file, "faults:\n  kind: slip\n  kind: clog\n").unwrap();
    let error = from_yaml::<serde_json::Value>(&file).unwrap_err().to_string();
    std::fs::remove_file(&file).unwrap();
    assert!(error.ends_with(": 'kind' stands twice in the same block: lines 2 and 3"), "{error}");
}

#[test]
fn the_line_of_an_unknown_field_is_told_once() {
    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Known {
        #[allow(dead_code, reason = "only its name counts")]
        kind: String,
    }
    let file = std::env::temp_dir().join(format!("fdm_once_{}.yaml", std::process::id()));
    std::fs::write(&file, "kind: slip at line 3\nsizes: 1\n").unwrap();
    let error = from_yaml::<Known>(&file).unwrap_err().to_string();
    std::fs::remove_file(&file).unwrap();
    assert!(
        error.contains(".yaml:2: ") && error.contains("`sizes`") && !error.contains(" at line "),
        "{error}"
    );
}
