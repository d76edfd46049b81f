//! What a bag says of the parameters with which it was recorded.

use super::settings::BRAINS;
use crate::config::ConfigDir;
use anyhow::bail;
use std::collections::BTreeMap;
use std::path::Path;

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

    /// Material of what the record does not say: its own, or the one that is asked for where it says none.
    ///
    /// # Errors
    /// Another one than the record's, whose parameters count.
    pub(crate) fn material_for(
        &self,
        asked: Option<&str>,
        config: &ConfigDir,
        bag: &Path,
    ) -> anyhow::Result<String> {
        let printed = self.material();
        match (asked, printed) {
            (Some(asked), Some(printed)) if !asked.eq_ignore_ascii_case(&printed) => bail!(
                "--material {asked}: {} says the parameters of its print in {printed}, which count; \
                 --set mpc_controller.material... changes one of them",
                bag.display()
            ),
            (Some(asked), _) => Ok(asked.to_owned()),
            // One that this configuration does not know is said whole by its record.
            (None, printed) => Ok(printed
                .filter(|printed| config.check_material(printed).is_ok())
                .unwrap_or_else(|| "PLA".to_owned())),
        }
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

    /// What is asked for beside it would be left aside without a word; what it lacks is not filled up from another's file.
    #[test]
    fn the_recorded_material_counts() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config");
        let config = ConfigDir::find(Some(&root)).unwrap();
        let of = |recorded: &str, asked| {
            let recorded = Recorded::parse(&format!("# mpc_controller 0f\n{recorded}"));
            recorded.material_for(asked, &config, Path::new("bags/cube")).map_err(|error| error.to_string())
        };
        let abs = "material.name: \"ABS\"\n";
        let refused = of(abs, Some("PLA")).unwrap_err();
        assert!(refused.starts_with("--material PLA: bags/cube says the parameters of its print in ABS"));
        let cases =
            [(abs, Some("abs"), "abs"), (abs, None, "ABS"), ("", Some("PETG"), "PETG"), ("", None, "PLA")];
        for (recorded, asked, taken) in cases {
            assert_eq!(of(recorded, asked).as_deref(), Ok(taken), "{recorded} {asked:?}");
        }
        assert_eq!(of("material.name: \"NYLON\"\n", None).as_deref(), Ok("PLA"));
    }
}
