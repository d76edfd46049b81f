//! The advance predictor's parameters and networks.

use super::ConfigDir;
use anyhow::Context;
use runtime::params::{NodePath, Parameters};
use std::path::Path;

/// Parameters and trained networks of the advance predictor.
#[derive(Debug, Clone)]
pub struct Foresight {
    /// Parameters.
    pub params: advance_predictor::Params,
    /// `K_A`.
    pub compensation: advance_predictor::compensation::Predictor,
    /// Turns.
    pub network: advance_predictor::turn::TurnNetwork,
}

impl ConfigDir {
    /// The advance predictor for a material.
    ///
    /// # Errors
    /// File, line, field, value and range of what is refused, networks that cannot be read.
    pub fn foresight(&self, material: &str) -> anyhow::Result<Foresight> {
        let path =
            NodePath { qualified: "/printer/advance_predictor".into(), base: "advance_predictor".into() };
        let files = self.files_of("advance_predictor", material);
        let overrides = self.foresight_overrides(material)?;
        self.foresight_of(&Parameters::read(&files, &overrides, &path)?)
    }

    /// The advance predictor with these parameters.
    ///
    /// # Errors
    /// As [`Self::foresight`].
    pub fn foresight_of(&self, parameters: &Parameters) -> anyhow::Result<Foresight> {
        use advance_predictor::{compensation, turn};
        let params: advance_predictor::Params = parameters.without(&["advance_physics"]).parse()?;
        let physics = parameters.block("advance_physics")?;
        let told = |file: &Path| format!("models: {}", file.display());
        let text = |file: &Path| runtime::input::text(file).with_context(|| told(file));
        let file = params.models.of(params.drive);
        let ensemble =
            compensation::Ensemble::parse(&text(file)?, params.drive).with_context(|| told(file))?;
        let compensation = compensation::Predictor::new(physics, params.bounds, ensemble);
        let compensation = compensation.with_context(|| told(file))?;
        let file = &params.models.turn;
        let network = turn::TurnNetwork::parse(&text(file)?).with_context(|| told(file))?;
        Ok(Foresight { params, compensation, network })
    }

    /// Polymer and networks of the advance predictor, wherever it is started.
    ///
    /// # Errors
    /// As [`Self::model_overrides`].
    pub fn foresight_overrides(&self, material: &str) -> anyhow::Result<Vec<(String, String)>> {
        let mut all = vec![("polymer".to_owned(), serde_json::json!(material.to_uppercase()).to_string())];
        all.extend(self.model_overrides("advance_predictor", material)?);
        Ok(all)
    }
}
