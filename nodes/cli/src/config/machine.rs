//! The error budget of the machine: what one node publishes and both hold against an offset of the layers.

use super::ConfigDir;
use anyhow::bail;
use defect_classifier::params::MachineParams;
use runtime::params::{NodePath, Parameters};

impl ConfigDir {
    /// Refuses a machine of which two nodes know different errors: one would blame the print for what the other
    /// explains.
    ///
    /// # Errors
    /// Both files, fields and values; file, line and field of what cannot be read.
    pub fn check_machine_budget(&self, material: &str) -> anyhow::Result<()> {
        let read = |node: &str| {
            let path = NodePath { qualified: format!("/printer/{node}"), base: node.to_owned() };
            Parameters::read(&self.files_of(node, material), &[], &path)
        };
        let classifier: MachineParams = read("defect_classifier")?.block("machine")?;
        let supervisor: safety_supervisor::Params = read("safety_supervisor")?.parse()?;
        let (published_m, allowed_m) = (classifier.error_m.unwrap_or(0.0), supervisor.shift.machine_error_m);
        if (published_m - allowed_m).abs() > 1e-9 {
            bail!(
                "{}: machine.error_m = {published_m} m, but {}: shift.machine_error_m = {allowed_m} m: must be \
                 the same, as `fdm kinematics budget` prints them",
                self.file("defect_classifier.param.yaml").display(),
                self.file("safety_supervisor.param.yaml").display(),
            );
        }
        Ok(())
    }
}
