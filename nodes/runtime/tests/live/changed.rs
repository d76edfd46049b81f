//! A shipped parameter file with one value changed: for the tables of what may change while a node is active.

use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;

#[derive(Deserialize)]
struct File<T> {
    #[serde(rename = "ros__parameters")]
    parameters: T,
}

/// The parameters of the one node of a file; `None` where they are refused.
pub(super) fn parsed<T: DeserializeOwned>(text: &str) -> Option<T> {
    let nodes: BTreeMap<String, File<T>> = serde_saphyr::from_str(text).ok()?;
    nodes.into_values().next().map(|node| node.parameters)
}

/// The text with another value of a parameter, named as `ros2 param` names it.
pub(super) fn changed(text: &str, name: &str, value: &str) -> String {
    let mut path: Vec<(usize, &str)> = Vec::new();
    let mut found = 0;
    let mut lines = Vec::new();
    for line in text.lines() {
        let rest = line.trim_start();
        let indent = line.len() - rest.len();
        let split = rest.split_once(':').filter(|_| !rest.starts_with('#'));
        let Some((key, _)) = split else { continue };
        path.retain(|(depth, _)| *depth < indent);
        path.push((indent, key));
        // the first two are `/**` and `ros__parameters`
        let dotted: Vec<&str> = path.iter().skip(2).map(|(_, key)| *key).collect();
        if dotted.join(".") == name {
            found += 1;
            lines.push(format!("{}{key}: {value}", &line[..indent]));
        } else {
            lines.push(line.to_owned());
        }
    }
    assert_eq!(found, 1, "{name} stands once in the file");
    lines.join("\n")
}
