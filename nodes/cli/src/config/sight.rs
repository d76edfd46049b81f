//! The parameters and networks of the camera's judge.

use super::ConfigDir;
use anyhow::Context;
use runtime::params::{NodePath, Parameters};
use std::path::Path;

/// Parameters and trained networks of the camera's judge.
#[derive(Debug, Clone)]
pub struct Sight {
    /// Parameters.
    pub params: defect_classifier::Params,
    /// Networks and nominal printer.
    pub models: defect_classifier::Models,
}

impl ConfigDir {
    /// The camera's judge.
    ///
    /// # Errors
    /// File, line, field, value and range of what is refused, networks that cannot be read.
    pub fn sight(&self, material: &str) -> anyhow::Result<Sight> {
        let path =
            NodePath { qualified: "/printer/defect_classifier".into(), base: "defect_classifier".into() };
        let files = self.files_of("defect_classifier", material);
        let models = self.model_overrides("defect_classifier", material)?;
        self.sight_of(&Parameters::read(&files, &models, &path)?)
    }

    /// The camera's judge with these parameters.
    ///
    /// # Errors
    /// As [`Self::sight`].
    pub fn sight_of(&self, parameters: &Parameters) -> anyhow::Result<Sight> {
        let params: defect_classifier::Params =
            parameters.without(&["printer", "material", "quality"]).parse()?;
        let told = |file: &Path| format!("models: {}", file.display());
        let text = |file: &Path| runtime::input::text(file).with_context(|| told(file));
        let (network, edge) = (&params.models.network, &params.models.edge);
        let models = defect_classifier::Models {
            network: defect_classifier::network::Network::parse(&text(network)?)
                .with_context(|| told(network))?,
            edge: defect_classifier::width::EdgeModel::parse(&text(edge)?).with_context(|| told(edge))?,
            nominal: defect_classifier::layer::Nominal {
                quality: parameters.block("quality")?,
                printer: parameters.block("printer")?,
                material: parameters.block("material")?,
            },
        };
        Ok(Sight { params, models })
    }
}
