//! What the nodes show on `/diagnostics`.

use fdm_loop_msgs::DiagnosticArray;
use std::collections::{BTreeMap, BTreeSet};

/// Topics of the runtime itself: the clock carries no value that could be refused but time, which is tested there.
const OWN: [&str; 1] = ["clock"];

/// Newest values by status and key.
#[derive(Debug, Default)]
pub(crate) struct Shown(BTreeMap<(String, String), String>);

impl Shown {
    pub(crate) fn take(&mut self, array: &DiagnosticArray) {
        for status in &array.status {
            // All nodes of the test share a namespace; the table's names are relative to it.
            let (namespace, name) = status.name.rsplit_once('/').unwrap_or(("", &status.name));
            for pair in &status.values {
                let key = pair.key.strip_prefix(namespace).unwrap_or(&pair.key);
                self.0.insert((name.to_owned(), key.to_owned()), pair.value.clone());
            }
        }
    }

    pub(crate) fn nodes(&self) -> BTreeSet<&str> {
        self.0.keys().map(|(name, _)| name.split(':').next().unwrap_or_default()).collect()
    }

    pub(crate) fn knows(&self, node: &str) -> bool {
        self.nodes().contains(node)
    }

    /// Pairs of node and topic, as the subscriptions themselves report them.
    pub(crate) fn subscriptions(&self) -> Vec<(String, String)> {
        let pair = |(name, key): &(String, String)| {
            let node = name.strip_suffix(": topics").filter(|node| *node != "peer")?;
            let topic = key.strip_suffix(" received")?.trim_start_matches('/');
            (!OWN.contains(&topic)).then(|| (node.to_owned(), topic.to_owned()))
        };
        self.0.keys().filter_map(pair).collect()
    }

    pub(crate) fn received(&self, node: &str, topic: &str) -> u64 {
        self.number(&format!("{node}: topics"), &format!("/{topic} received"))
    }

    pub(crate) fn undecodable(&self, node: &str, topic: &str) -> u64 {
        self.number(&format!("{node}: topics"), &format!("/{topic} undecodable"))
    }

    pub(crate) fn sent(&self, node: &str, topic: &str) -> u64 {
        self.number(&format!("{node}: topics"), &format!("/{topic} sent"))
    }

    pub(crate) fn refused_in_all(&self, node: &str, topic: &str) -> u64 {
        self.number(node, &format!("refused_{}", topic.replace('/', "_")))
    }

    pub(crate) fn refused(&self, node: &str, topic: &str, reason: &str) -> u64 {
        self.number(node, &format!("refused_{}_{reason}", topic.replace('/', "_")))
    }

    /// Everything of these pairs, for the message of a failure.
    pub(crate) fn all(&self, pairs: &[(String, String)]) -> String {
        let line = |(node, topic): &(String, String)| {
            let counter = format!("refused_{}", topic.replace('/', "_"));
            let refused: Vec<_> = self
                .0
                .iter()
                .filter(|((name, key), _)| name == node && key.starts_with(&counter))
                .map(|((_, key), value)| format!("{}={value}", key.trim_start_matches("refused_")))
                .collect();
            format!("\n{node} {topic}: received {} {}", self.received(node, topic), refused.join(" "))
        };
        pairs.iter().map(line).collect()
    }

    fn number(&self, name: &str, key: &str) -> u64 {
        self.0.get(&(name.to_owned(), key.to_owned())).and_then(|value| value.parse().ok()).unwrap_or(0)
    }
}
