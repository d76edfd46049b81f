//! Parameters for tests.

use super::MotionParams;
use std::collections::HashMap;

type Tree = HashMap<String, HashMap<String, HashMap<String, MotionParams>>>;

/// Those shipped in `config/printers/ender3_motion.yaml`.
pub(crate) fn shipped_params() -> MotionParams {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/printers/ender3_motion.yaml");
    let mut tree: Tree = serde_saphyr::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    tree.remove("/**").unwrap().remove("ros__parameters").unwrap().remove("printer_motion").unwrap()
}
