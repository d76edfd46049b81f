//! The files of `config/`, through the checks that they pass when something is started with them.

use super::finding::Finding;
use crate::config::ConfigDir;
use crate::up::UpArgs;
use crate::up::recipes::Plan;
use crate::wire;
use anyhow::Context;
use std::path::{Path, PathBuf};

/// Everything that `fdm up`, `fdm wire up` and `fdm classify` read.
pub(super) fn config(given: Option<&Path>) -> Finding {
    const NAME: &str = "configuration";
    let found = ConfigDir::find(given);
    let checked = found.and_then(|config| Ok((checked(&config)?, config)));
    match checked {
        Ok((what, config)) => Finding::ok(NAME, format!("{}: {what}", config.file("").display())),
        Err(error) => Finding::fail(
            NAME,
            format!("{error:#}"),
            "mend that file (git diff config shows what was changed), or call fdm in the repository, or set FDM_CONFIG",
        ),
    }
}

/// What was parsed, or the first thing that is refused.
fn checked(config: &ConfigDir) -> anyhow::Result<String> {
    config.motion()?;
    let materials = config.names_in("materials");
    for material in &materials {
        let parsed = Plan::new(&print(material), config, material, "mpc").and_then(|plan| plan.check());
        parsed.with_context(|| format!("fdm up with {}", material.to_uppercase()))?;
    }
    let scenarios = config.names_in("scenarios");
    for scenario in &scenarios {
        config.scenario(scenario)?;
    }
    wire::up::check_config(config).context("fdm wire up")?;
    wire::nominal(config)?;
    crate::classify::network(config, crate::classify::View::Photograph)?;
    Ok(format!(
        "parameters of fdm up with {} materials, {} scenarios and fdm wire up are accepted",
        materials.len(),
        scenarios.len()
    ))
}

/// A print of every node there is; nothing of it is written or started.
fn print(material: &str) -> UpArgs {
    let nowhere = || PathBuf::from(format!("/nonexistent/fdm_doctor_{}", std::process::id()));
    UpArgs {
        gcode: nowhere(),
        config: None,
        bag: Some(nowhere()),
        speed: 1.0,
        control: vec!["mpc".to_owned()],
        mode: "act".to_owned(),
        host: "native".to_owned(),
        advance: "predicted".to_owned(),
        scenario: "nominal".to_owned(),
        material: Some(material.to_owned()),
        layers: None,
        warm: false,
        with: Vec::new(),
        seed: 1,
        namespace: "/printer".to_owned(),
        allow_fault_injection: false,
        host_clock: false,
        dry_run: true,
        stay: false,
        json: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::doctor::finding::Level;

    /// Beside this test lie no nodes; whether they were built is another check's.
    #[test]
    fn the_configuration_is_checked_where_programs_are_missing() {
        assert!(!crate::programs::beside("mpc_controller").unwrap().is_file());
        let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config");
        let found = config(Some(Path::new(shipped)));
        assert_eq!(found.level, Level::Ok, "{}", found.found);
    }
}
