//! Where the networks stand, wherever a node is started.

use super::ConfigDir;
use runtime::params::{NodePath, Parameters};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What the folder of parameter files is called in them.
const CONFIG: &str = "config";

impl ConfigDir {
    /// The files that a node's block `models` names, as parameters with whole paths.
    ///
    /// A path that begins with `config/` lies in the folder of the parameter files, whatever that is called; any other one
    /// where it says, seen from the folder in which the command is called.
    ///
    /// # Errors
    /// File, line and field of what is refused.
    pub fn model_overrides(&self, node: &str, material: &str) -> anyhow::Result<Vec<(String, String)>> {
        let path = NodePath { qualified: format!("/printer/{node}"), base: node.to_owned() };
        let parameters = Parameters::read(&self.files_of(node, material), &[], &path)?;
        let named: BTreeMap<String, PathBuf> = parameters.block("models")?;
        let whole = |(name, file): (String, PathBuf)| {
            let file = self.model(&file);
            // A JSON string is a YAML string: whatever a file is called.
            (format!("models.{name}"), serde_json::json!(file.to_string_lossy()).to_string())
        };
        Ok(named.into_iter().map(whole).collect())
    }

    fn model(&self, named: &Path) -> PathBuf {
        let file = match named.strip_prefix(CONFIG) {
            Ok(inside) => self.file("").join(inside),
            Err(_elsewhere) => named.to_path_buf(),
        };
        std::path::absolute(&file).unwrap_or(file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The folder has another name than in the files, and one network stands elsewhere.
    #[test]
    fn the_files_that_are_named_are_the_ones_that_are_read() {
        let folder = std::env::temp_dir().join(format!("fdm-models-{}", std::process::id()));
        _ = std::fs::remove_dir_all(&folder);
        let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config");
        for part in ["", "advance", "models", "printers", "materials"] {
            std::fs::create_dir_all(folder.join(part)).unwrap();
            for entry in std::fs::read_dir(shipped.join(part)).unwrap() {
                let path = entry.unwrap().path();
                if path.is_file() {
                    std::fs::copy(&path, folder.join(part).join(path.file_name().unwrap())).unwrap();
                }
            }
        }
        let own = folder.join("own.json");
        let file = folder.join("defect_classifier.param.yaml");
        let text = std::fs::read_to_string(&file).unwrap();
        let text = text.replace("config/models/toolhead.json", &own.display().to_string());
        std::fs::write(&file, text).unwrap();
        let config = ConfigDir::find(Some(&folder)).unwrap();
        let quoted = |path: PathBuf| format!("\"{}\"", path.display());
        let edge = quoted(folder.join("models/road_edge.json"));
        let named = config.model_overrides("defect_classifier", "pla").unwrap();
        let wanted = [("models.edge", edge), ("models.network", quoted(own.clone()))];
        assert_eq!(named, wanted.map(|(name, path)| (name.to_owned(), path)));
        // It is not there: the file is named.
        let error = format!("{:#}", config.sight("pla").unwrap_err());
        assert!(error.contains(&own.display().to_string()), "{error}");
        std::fs::copy(shipped.join("models/toolhead.json"), &own).unwrap();
        assert_eq!(config.sight("pla").unwrap().params.models.network, own);
        let turn = quoted(folder.join("models/turn.json"));
        let predictor = config.foresight_overrides("pla").unwrap();
        assert!(predictor.contains(&("models.turn".to_owned(), turn)), "{predictor:?}");
        std::fs::remove_dir_all(folder).unwrap();
    }
}
