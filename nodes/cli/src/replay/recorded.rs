//! What a bag says of the parameters with which it was recorded.

use super::settings::BRAINS;
use std::collections::BTreeMap;

/// What a bag says of its parameters: names and values by node.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Recorded(BTreeMap<String, Vec<(String, String)>>);

impl Recorded {
    /// Reads the configuration text of a record: `# node sha256`, then `name: value` line by line.
    pub(crate) fn parse(text: &str) -> Self {
        let mut nodes: BTreeMap<String, Vec<(String, String)>> = BTreeMap::new();
        let mut current = None;
        for line in text.lines() {
            if let Some(head) = line.strip_prefix("# ") {
                current = head.split_whitespace().next().map(str::to_owned);
            } else if let (Some(node), Some((name, value))) = (&current, line.split_once(": ")) {
                nodes.entry(node.clone()).or_default().push((name.to_owned(), value.to_owned()));
            }
        }
        Self(nodes)
    }

    /// Names and values of a node; `None` where the bag says nothing of it.
    pub(crate) fn of(&self, node: &str) -> Option<&Vec<(String, String)>> {
        self.0.get(node)
    }

    /// Material that was printed.
    pub(crate) fn material(&self) -> Option<String> {
        let names = self.0.values().flatten().find(|(name, _)| name == "material.name");
        names.map(|(_, value)| value.trim_matches('"').to_owned())
    }

    /// Whether it says anything of a brain.
    pub(crate) fn is_empty(&self) -> bool {
        !BRAINS.iter().any(|node| self.0.contains_key(*node))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_configuration_is_read_node_by_node() {
        let text =
            "# state_estimator 0f\nperiod_s: 0.05\nq.names: [\"a: b\"]\n\n# imu 1a\nuse_sim_time: true\n";
        let recorded = Recorded::parse(text);
        let pair = |(name, value): (&str, &str)| (name.to_owned(), value.to_owned());
        assert_eq!(
            recorded.0["state_estimator"],
            [("period_s", "0.05"), ("q.names", "[\"a: b\"]")].map(pair)
        );
        assert!(!recorded.is_empty() && Recorded::parse("no config").is_empty());
        let of = |text| Recorded::parse(text).material();
        assert_eq!(of("# mpc_controller 0f\nmaterial.name: \"ABS\"\n").as_deref(), Some("ABS"));
        assert_eq!(recorded.material(), None);
    }
}
