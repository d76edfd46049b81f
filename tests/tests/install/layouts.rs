//! What a layout shows exists: each topic with a type that the panel takes, each field down to a number.

use super::root;
use crate::definition::flatten;
use runtime::topics::{self, TopicInfo};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// Namespace that the layouts are for.
const NAMESPACE: &str = "/printer/";

fn layout(name: &str) -> String {
    std::fs::read_to_string(root().join("launch_scripts/layouts").join(name)).unwrap()
}

/// The declared topic that a path begins with, and what follows it.
fn topic(path: &str) -> (&'static TopicInfo, &str) {
    let rest = |info: &TopicInfo| {
        let absolute = if info.name.starts_with('/') {
            info.name.to_owned()
        } else {
            format!("{NAMESPACE}{}", info.name)
        };
        path.strip_prefix(&absolute)
            .filter(|rest| rest.is_empty() || rest.starts_with(['.', '/']))
            .map(str::len)
    };
    let found = topics::ALL.iter().filter_map(|info| Some((info, rest(info)?))).min_by_key(|(_, left)| *left);
    let (info, left) = found.unwrap_or_else(|| panic!("{path}: no topic of runtime/src/topics.rs"));
    (info, path[path.len() - left..].trim_start_matches(['.', '/']))
}

/// Type of a field, `.` or `/` between its parts, one element of a list by its index.
fn field(path: &str) -> String {
    let (info, wanted) = topic(path);
    let plain = |text: &str| {
        let parts = text.split(['.', '/']).map(|part| part.split('[').next().unwrap_or(part));
        parts.collect::<Vec<_>>().join(".")
    };
    let fields = flatten(info.definition.text, &info.definition);
    let found = fields.iter().find(|(name, _)| plain(name) == plain(wanted));
    let (name, kind) =
        found.unwrap_or_else(|| panic!("{path}: {} has no {wanted}", info.definition.full_name()));
    assert_eq!(name.contains('['), wanted.contains('['), "{path}: one element of a list has an index");
    kind.clone()
}

fn shown(path: &str) {
    let kind = field(path);
    assert!(kind != "string", "{path} is a {kind}, which no plot shows");
}

fn is_type(path: &str, expected: &str) {
    let (info, rest) = topic(path);
    assert_eq!((info.definition.full_name().as_str(), rest), (expected, ""), "{path}");
}

fn panel(kind: &str, settings: &Value) {
    let text = |name: &str| settings[name].as_str().unwrap_or_else(|| panic!("{kind} without {name}"));
    match kind {
        "Plot" | "StateTransitions" => {
            let paths = settings["paths"].as_array().unwrap();
            assert!(!paths.is_empty());
            paths.iter().for_each(|path| shown(path["value"].as_str().unwrap()));
        }
        "Image" => {
            let mode = &settings["imageMode"];
            is_type(mode["imageTopic"].as_str().unwrap(), "sensor_msgs/msg/CompressedImage");
            if let Some(info) = mode["calibrationTopic"].as_str() {
                is_type(info, "sensor_msgs/msg/CameraInfo");
            }
        }
        "RawMessages" => assert_eq!(topic(text("topicPath")).1, ""),
        "DiagnosticSummary" => is_type(text("topicToRender"), "diagnostic_msgs/msg/DiagnosticArray"),
        "RosOut" => is_type(text("topicToRender"), "rcl_interfaces/msg/Log"),
        "CallService" => {
            let services = [topics::SAFETY_PAUSE.name(), topics::SAFETY_ESTOP.name()];
            let name = text("serviceName").strip_prefix(NAMESPACE).unwrap_or_default();
            assert!(services.contains(&name), "{name}");
        }
        other => panic!("a panel {other} that this test does not know"),
    }
}

#[test]
fn the_foxglove_layout_shows_what_is_published() {
    let layout: Value = serde_json::from_str(&layout("foxglove.json")).unwrap();
    let panels = layout["configById"].as_object().unwrap();
    for (id, settings) in panels {
        panel(id.split('!').next().unwrap(), settings);
    }
    // Every panel has a place, every place a panel.
    let mut places = Vec::new();
    let mut waiting = vec![&layout["layout"]];
    while let Some(place) = waiting.pop() {
        match place.as_str() {
            Some(id) => places.push(id.to_owned()),
            None => waiting.extend([&place["first"], &place["second"]]),
        }
    }
    places.sort();
    let mut ids: Vec<String> = panels.keys().cloned().collect();
    ids.sort();
    assert_eq!(places, ids);
}

/// Values of an attribute or key in a text, up to a mark.
fn values<'a>(text: &'a str, key: &str, end: char) -> Vec<&'a str> {
    text.split(key).skip(1).map(|rest| rest.split(end).next().unwrap().trim()).collect()
}

#[test]
fn the_plotjuggler_layout_shows_what_is_published() {
    let text = layout("plotjuggler.xml");
    let curves: Vec<&str> = text
        .lines()
        .filter(|line| line.contains("<curve "))
        .flat_map(|line| values(line, " name=\"", '"'))
        .collect();
    assert!(curves.len() > 20, "{curves:?}");
    curves.into_iter().for_each(shown);
}

#[test]
fn the_rviz_file_shows_pictures_that_are_published() {
    let text = layout("fdm_loop.rviz");
    let pictures = values(&text, "Value: /", '\n');
    assert_eq!(pictures.len(), text.matches("Class: rviz_default_plugins/Image").count());
    for picture in pictures {
        is_type(&format!("/{picture}"), "sensor_msgs/msg/CompressedImage");
        // Best effort is what is offered to a tool that asks for no more.
        assert!(text.contains("Reliability Policy: Best Effort"));
    }
}

/// A group of `diagnostic_aggregator`.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Analyzer {
    r#type: String,
    path: String,
    timeout: f64,
    #[serde(default)]
    startswith: Vec<String>,
    #[serde(default)]
    contains: Vec<String>,
    #[serde(default)]
    name: Vec<String>,
    #[serde(default)]
    expected: Vec<String>,
}

impl Analyzer {
    /// As `GenericAnalyzer::match` has it, which is asked for every status by its full name.
    fn matches(&self, status: &str) -> bool {
        self.expected.iter().chain(&self.name).any(|name| status == name)
            || self.startswith.iter().any(|start| status.starts_with(start))
            || self.contains.iter().any(|part| status.contains(part))
    }
}

/// A status without a group is shown under Other, one in two is counted twice. A node's statuses are called as the node
/// is (`tests/interop/peers.py::diagnostics`); they come at 1 Hz, a slower group would never be stale in time.
#[test]
fn the_aggregator_has_one_group_for_every_node() {
    let path = root().join("launch_scripts/diagnostics.aggregator.yaml");
    let file: BTreeMap<String, BTreeMap<String, BTreeMap<String, Value>>> =
        runtime::params::from_yaml(&path).unwrap();
    let entries = &file["/**"]["ros__parameters"];
    let analyzers: Vec<Analyzer> = entries
        .values()
        .filter(|entry| entry.is_object())
        .map(|entry| serde_json::from_value(entry.clone()).unwrap())
        .collect();
    let paths: BTreeSet<&str> = analyzers.iter().map(|analyzer| analyzer.path.as_str()).collect();
    assert_eq!(paths.len(), analyzers.len(), "a path is one group");
    for analyzer in &analyzers {
        assert_eq!(analyzer.r#type, "diagnostic_aggregator/GenericAnalyzer", "{}", analyzer.path);
        assert!((1.0..=5.0).contains(&analyzer.timeout), "{}", analyzer.path);
    }
    let nodes = cli::up::recipes::NODES.into_iter().chain(["printer_bridge", "fdm"]);
    for status in nodes
        .flat_map(|node| ["/printer", "/left", "/hall/7", ""].map(|space| format!("{space}/{node}: topics")))
    {
        let groups: Vec<&str> = analyzers
            .iter()
            .filter(|group| group.matches(&status))
            .map(|group| group.path.as_str())
            .collect();
        assert_eq!(groups.len(), 1, "{status} is in {groups:?}");
    }
}
