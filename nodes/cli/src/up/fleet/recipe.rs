//! Name, program and arguments of a node.

use std::path::PathBuf;

/// How a node is started.
#[derive(Debug, Clone)]
pub struct Recipe {
    /// Name of node and executable.
    pub name: &'static str,
    /// The executable.
    pub program: PathBuf,
    /// Its arguments.
    pub arguments: Vec<String>,
    /// Whether it is started again after an end that nobody had asked for.
    pub replaceable: bool,
}

impl Recipe {
    /// The same for a node that waits to be configured and activated.
    pub(super) fn held(&self) -> Self {
        let mut held = self.clone();
        held.arguments.extend(["-p", "autostart:=false"].map(str::to_owned));
        held
    }
}
