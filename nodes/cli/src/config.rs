//! Finds and loads the files of `config/`: the same ones, through the same checks, as the nodes get.

use anyhow::bail;
use models::material::Material;
use models::motion::MotionParams;
use models::printer::Printer;
use mpc_controller::params::{AdvanceSource, Level};
use runtime::params::{NodePath, Parameters};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

mod cameras;
mod foresight;
mod machine;
mod names;
mod networks;
mod sight;
mod texts;

pub use foresight::Foresight;
pub use sight::Sight;

/// Everything that a loop needs to know.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The nominal printer.
    pub printer: Printer,
    /// The nominal material.
    pub material: Material,
    /// Motion limits before the file's own.
    pub motion: MotionParams,
    /// The simulated printer.
    pub simulated: printer_sim::Params,
    /// Estimator.
    pub estimator: state_estimator::Params,
    /// Controller.
    pub controller: mpc_controller::Params,
    /// Supervisor.
    pub supervisor: safety_supervisor::Params,
    /// The camera's judge, where frames are rendered.
    pub sight: Option<Sight>,
    /// The advance predictor, where it is asked.
    pub foresight: Option<Foresight>,
}

/// File by which a folder of configuration is known.
const MARK: &str = "printer_sim.param.yaml";

/// A folder like the repository's `config/`.
#[derive(Debug, Clone)]
pub struct ConfigDir(PathBuf);

/// What a command line chooses among the files.
#[derive(Debug, Clone)]
pub struct Choice {
    /// Material: a file of `config/materials/`.
    pub material: String,
    /// Control level.
    pub control: Level,
    /// Host profile of the simulated printer.
    pub host: String,
    /// Source of the pressure advance.
    pub advance: AdvanceSource,
    /// Frames are rendered and judged, accelerations sampled; else the simulator's stand-in gives the width.
    pub camera: bool,
    /// Parameters beside the files', by node: name and YAML value.
    pub overrides: BTreeMap<String, Vec<(String, String)>>,
}

impl Choice {
    /// A material and a control level, all else as usual.
    #[must_use]
    pub fn of(material: String, control: Level) -> Self {
        Self {
            material,
            control,
            host: "native".to_owned(),
            advance: AdvanceSource::Planned,
            camera: false,
            overrides: BTreeMap::new(),
        }
    }
}

/// What of the simulated printer's sensors a choice switches.
#[must_use]
pub fn sensor_overrides(camera: bool) -> Vec<(String, String)> {
    let pair = |name: &str, value: &str| (name.to_owned(), value.to_owned());
    if camera {
        vec![pair("camera.enabled", "true"), pair("simulator.width_period_s", "0.0")]
    } else {
        vec![pair("camera.enabled", "false"), pair("simulator.imu.period_s", "0.0")]
    }
}

impl ConfigDir {
    /// The folder given, or `$FDM_CONFIG`, or `config/` here, or beside the executable's workspace, or what was
    /// installed with this executable (`PREFIX/lib/fdm_loop/fdm`), or installed by the Debian package.
    ///
    /// # Errors
    /// Says where it looked.
    pub fn find(given: Option<&Path>) -> anyhow::Result<Self> {
        let above =
            std::env::current_exe().ok().and_then(|exe| Some(exe.parent()?.parent()?.parent()?.to_owned()));
        let beside =
            ["config", "share/fdm_loop/config"].map(|folder| above.as_ref().map(|above| above.join(folder)));
        let candidates: Vec<PathBuf> = given
            .map(Path::to_path_buf)
            .into_iter()
            .chain(std::env::var_os("FDM_CONFIG").map(PathBuf::from))
            .chain([PathBuf::from("config")])
            .chain(beside.into_iter().flatten())
            .chain([PathBuf::from("/usr/share/fdm_loop/config")])
            .collect();
        let tried = if given.is_some() { &candidates[..1] } else { &candidates[..] };
        match (tried.iter().find(|path| path.join(MARK).is_file()), given) {
            (Some(found), _) => Ok(Self(found.clone())),
            (None, Some(given)) => bail!(
                "--config {}: no {MARK} in it; a configuration is a whole one: copy the folder config/, and change the copy",
                given.display()
            ),
            (None, None) => bail!("no folder with {MARK} among {tried:?}: give one with --config"),
        }
    }

    /// A file of the folder.
    #[must_use]
    pub fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Parameter files of a node, in the order in which they are merged.
    #[must_use]
    pub fn files_of(&self, node: &str, material: &str) -> Vec<PathBuf> {
        let own = format!("{node}.param.yaml");
        let material = format!("materials/{}.yaml", material.to_lowercase());
        let names: Vec<String> = match node {
            "state_estimator" | "mpc_controller" => vec![own, "printers/ender3.yaml".into(), material],
            "defect_classifier" => vec![own, "quality.yaml".into(), "printers/ender3.yaml".into(), material],
            "advance_predictor" => vec![own, "advance/physics.yaml".into()],
            "printer_sim" => vec![
                own,
                "plants/ender3.yaml".into(),
                "printers/ender3_motion.yaml".into(),
                "quality.yaml".into(),
                material,
            ],
            _ => vec![own],
        };
        names.into_iter().map(|name| self.file(&name)).collect()
    }

    /// The same, and what the choice's host asks of the node where it asks for something.
    fn files_for(&self, node: &str, choice: &Choice) -> Vec<PathBuf> {
        let host = self.file(&format!("hosts/{}.param.yaml", choice.host));
        let mut files = self.files_of(node, &choice.material);
        files.extend(host.is_file().then_some(host));
        files
    }

    /// Names of the scenarios.
    #[must_use]
    pub fn names_in(&self, folder: &str) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(self.file(folder))
            .into_iter()
            .flatten()
            .flatten()
            .filter_map(|entry| Some(entry.path().file_name()?.to_str()?.strip_suffix(".yaml")?.to_owned()))
            .collect();
        names.sort();
        names
    }

    /// A scenario by name or by path.
    ///
    /// # Errors
    /// Names the scenarios that there are, or file, line and field.
    pub fn scenario(&self, name: &str) -> anyhow::Result<printer_sim::Scenario> {
        let path = self.scenario_path(name);
        if !path.exists() && name.ends_with(".yaml") {
            bail!("scenario {}: no such file", path.display());
        }
        if !path.exists() {
            bail!("scenario '{name}' is unknown; there are {}", self.names_in("scenarios").join(", "));
        }
        Ok(runtime::params::from_yaml(&path)?)
    }

    /// Where a scenario by name or path stands.
    #[must_use]
    pub fn scenario_path(&self, name: &str) -> PathBuf {
        let path = if name.ends_with(".yaml") {
            PathBuf::from(name)
        } else {
            self.file(&format!("scenarios/{name}.yaml"))
        };
        std::path::absolute(&path).unwrap_or(path)
    }

    /// Refuses a material without a file.
    ///
    /// # Errors
    /// Names the materials that there are.
    pub fn check_material(&self, material: &str) -> anyhow::Result<()> {
        if self.names_in("materials").contains(&material.to_lowercase()) {
            return Ok(());
        }
        let known = self.names_in("materials").join(", ").to_uppercase();
        bail!("material '{material}' is unknown; there are {known}")
    }

    /// Motion limits of the printer.
    ///
    /// # Errors
    /// File, line, field, value and range of what is refused.
    pub fn motion(&self) -> anyhow::Result<MotionParams> {
        let path = NodePath { qualified: "/printer/printer_sim".into(), base: "printer_sim".into() };
        let parameters = Parameters::read(&[self.file("printers/ender3_motion.yaml")], &[], &path)?;
        Ok(parameters.block("printer_motion")?)
    }

    /// Loads everything for a loop in one process.
    ///
    /// # Errors
    /// File, line, field, value and range of what is refused.
    pub fn load(&self, choice: &Choice) -> anyhow::Result<Setup> {
        self.check_material(&choice.material)?;
        self.check_names(&choice.material, &choice.host)?;
        self.check_machine_budget(&choice.material)?;
        self.check_cameras(&choice.material)?;
        let read = |node: &str, usual: &[(String, String)]| {
            let path = NodePath { qualified: format!("/printer/{node}"), base: node.to_owned() };
            let wished = choice.overrides.get(node).into_iter().flatten();
            let overrides: Vec<_> = usual.iter().chain(wished).cloned().collect();
            Parameters::read(&self.files_for(node, choice), &overrides, &path)
        };
        let nominal = ["printer", "material"];
        let estimator = read("state_estimator", &[])?;
        let controller = read("mpc_controller", &[])?;
        let mut simulated = sensor_overrides(choice.camera);
        simulated.push(("simulator.host".into(), choice.host.clone()));
        let simulator = read("printer_sim", &simulated)?;
        let printer: Printer = estimator.block("printer")?;
        let material: Material = estimator.block("material")?;
        let simulated = printer_sim::load::simulator_params(&simulator, &material)?;
        Ok(Setup {
            motion: simulator.block("printer_motion")?,
            estimator: estimator.without(&nominal).parse()?,
            controller: controller
                .without(&nominal)
                .parse::<mpc_controller::Params>()?
                .with_level(choice.control)
                .with_advance(choice.advance),
            foresight: (choice.advance == AdvanceSource::Predicted)
                .then(|| self.foresight(&choice.material))
                .transpose()?,
            sight: choice.camera.then(|| self.sight(&choice.material)).transpose()?,
            supervisor: read("safety_supervisor", &[("start_mode".into(), "act".into())])?.parse()?,
            simulated,
            printer,
            material,
        })
    }
}

#[cfg(test)]
mod range_tests;

#[cfg(test)]
mod tests;
