use super::*;
use crate::offered_qos::OfferedQos;

fn channel(topic: &str, depth: usize) -> Channel {
    Channel {
        topic: topic.to_owned(),
        type_name: "std_msgs/msg/Empty".to_owned(),
        offered_qos: OfferedQos { reliable: true, transient_local: false, depth }.text(),
    }
}

fn file(number: u32, span_ns: (u64, u64), messages: &[(Channel, u64)]) -> FileContents {
    FileContents {
        number,
        name: format!("print_{number}.mcap"),
        span_ns: Some(span_ns),
        messages: messages.iter().cloned().collect(),
    }
}

fn two_files() -> Contents {
    let mut contents = Contents::default();
    contents.add(file(1, (50, 90), &[(channel("/a", 10), 2)]));
    contents.add(file(0, (10, 40), &[(channel("/a", 10), 3), (channel("/b", 1), 1)]));
    contents
}

/// Several files: sums over all of them, each file with its own times, in the order of their numbers.
#[test]
fn two_files_are_one_bag() {
    let text = metadata_yaml(&two_files(), None);
    let expected = include_str!("two_files.yaml");
    assert_eq!(text, expected);
}

/// A topic whose quality of service changed between two runs stands twice: readers match by it.
#[test]
fn channels_that_differ_in_quality_of_service_are_listed_apart() {
    let mut contents = two_files();
    contents.add(file(2, (100, 100), &[(channel("/a", 20), 4)]));
    let text = metadata_yaml(&contents, None);
    assert_eq!(text.matches("name: \"/a\"").count(), 2);
    assert!(counts_json(&contents, None, RunCounts::default()).contains("\"/a\": 9"));
}

/// While recording, the active file is named but not listed.
#[test]
fn an_active_file_is_named_not_listed() {
    let text = metadata_yaml(&Contents::default(), Some("print_0.mcap.active"));
    assert!(text.contains("relative_file_paths: []"), "{text}");
    assert!(text.contains("fdm_loop_active_file: \"print_0.mcap.active\""));
}

#[test]
fn counts_are_a_json_object() {
    let run = RunCounts { received: 7, dropped: 1, missed: 3, raised: 2 };
    let text = counts_json(&two_files(), None, run);
    let expected = "{\n  \"state\": \"closed\",\n  \"messages\": 6,\n  \"topics\": {\n    \"/a\": 5,\n    \
                    \"/b\": 1\n  },\n  \"files\": {\n    \"print_0.mcap\": 4,\n    \"print_1.mcap\": 2\n  },\n  \
                    \"run\": {\"received\": 7, \"dropped\": 1, \"missed\": 3, \"log_time_raised\": 2}\n}\n";
    assert_eq!(text, expected);
}

#[test]
fn odd_names_are_escaped() {
    assert_eq!(quoted("a \"b\"\\\n").to_string(), "\"a \\\"b\\\"\\\\\\u000a\"");
}
