//! The parameters of the brains as text, for a record.

use super::{Choice, ConfigDir};
use mpc_controller::params::{AdvanceSource, Level};
use runtime::params::{NodePath, Parameters};

impl ConfigDir {
    /// What is in force for each brain of a simulated print: `# node sha256`, then a parameter a line.
    ///
    /// # Errors
    /// A file that cannot be read or is no parameter file.
    pub fn texts(&self, choice: &Choice) -> anyhow::Result<String> {
        let mut nodes = vec!["state_estimator", "mpc_controller", "safety_supervisor"];
        if choice.camera {
            nodes.push("defect_classifier");
        }
        if choice.advance == AdvanceSource::Predicted {
            nodes.push("advance_predictor");
        }
        let mut text = String::new();
        for node in nodes {
            let path = NodePath { qualified: format!("/printer/{node}"), base: node.to_owned() };
            let mut values = self.usual_values(node, choice)?;
            values.extend(choice.overrides.get(node).into_iter().flatten().cloned());
            let parameters = Parameters::read(&self.files_for(node, choice), &values, &path)?;
            text.push_str(&format!("# {node} {}\n{}\n", parameters.sha256(), parameters.text()));
        }
        Ok(text)
    }

    /// What a choice sets of a node beside its files.
    fn usual_values(&self, node: &str, choice: &Choice) -> anyhow::Result<Vec<(String, String)>> {
        let pair = |name: &str, value: &str| (name.to_owned(), value.to_owned());
        Ok(match node {
            "safety_supervisor" => vec![pair("start_mode", "act")],
            "mpc_controller" => {
                let control = match choice.control {
                    Level::Off => "\"off\"",
                    Level::Encoder => "\"encoder\"",
                    Level::Mpc => "\"mpc\"",
                };
                let advance = match choice.advance {
                    AdvanceSource::None => "none",
                    AdvanceSource::File => "file",
                    AdvanceSource::Material => "material",
                    AdvanceSource::Planned => "planned",
                    AdvanceSource::Predicted => "predicted",
                };
                vec![pair("control", control), pair("advance.source", advance)]
            }
            "defect_classifier" => self.model_overrides(node, &choice.material)?,
            "advance_predictor" => self.foresight_overrides(&choice.material)?,
            _ => Vec::new(),
        })
    }
}
