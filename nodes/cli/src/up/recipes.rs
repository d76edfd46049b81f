//! Which node is started with which files and parameters.

use super::{UpArgs, check_new_bag, fleet::Recipe, records};
use crate::config::{ConfigDir, sensor_overrides};
use crate::programs;
use anyhow::Context;
use runtime::params::{NodePath, Parameters};
use std::path::PathBuf;

/// The node that is started with `--advance predicted` alone.
pub(crate) const FORESIGHT: &str = "advance_predictor";

/// The nodes of the simulated printer in the order of their start: who records and who guards come first.
/// The advance predictor is started where it is asked for alone: without multicast on `lo` twelve processes see each
/// other, and these eleven with `fdm` are twelve (`runtime::participants`), which leaves no place for a tool.
pub const NODES: [&str; 11] = [
    "bag_recorder",
    "safety_supervisor",
    "thermistor",
    "imu",
    "camera",
    "filament_encoder",
    "state_estimator",
    "defect_classifier",
    FORESIGHT,
    "mpc_controller",
    "printer_sim",
];

/// The namespace whose clock is the domain's: tools that follow simulated time look for `/clock`.
pub(crate) const DEFAULT_NAMESPACE: &str = "/printer";

/// Where the clock of a printer is published.
pub(crate) fn clock_of(namespace: &str) -> String {
    if namespace == DEFAULT_NAMESPACE {
        return "/clock".to_owned();
    }
    format!("{}/clock", namespace.trim_end_matches('/'))
}

/// Everything that one print is started with.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Control level.
    pub control: String,
    /// Source of the pressure advance.
    pub advance: String,
    /// Folder of the bag.
    pub bag: PathBuf,
    /// G-code file.
    pub gcode: PathBuf,
    /// Host profile.
    pub host: String,
    /// Scenario as named by the person.
    pub scenario: String,
    /// Material.
    pub material: String,
    /// Seed.
    pub seed: u64,
    /// Simulated over wall time.
    pub speed: f64,
    /// Stamps are of the host's clock, nothing follows `/clock`.
    pub host_clock: bool,
    /// Namespace of the printer.
    pub namespace: String,
    /// The graph runs on after the print.
    pub stay: bool,
    config: ConfigDir,
    overrides: Vec<(&'static str, String, String)>,
}

impl Plan {
    /// The plan of one control level.
    ///
    /// # Errors
    /// A bag folder that is in use.
    pub fn new(args: &UpArgs, config: &ConfigDir, material: &str, control: &str) -> anyhow::Result<Self> {
        let bag = match &args.bag {
            Some(bag) if args.control.len() > 1 => PathBuf::from(format!("{}-{control}", bag.display())),
            Some(bag) => bag.clone(),
            None => default_bag(args, control),
        };
        check_new_bag(&bag)?;
        let absolute = |path: &PathBuf| std::path::absolute(path).with_context(|| path.display().to_string());
        let gcode = absolute(&args.gcode)?;
        let mut plan = Self {
            control: control.to_owned(),
            advance: args.advance.clone(),
            bag: absolute(&bag)?,
            gcode,
            host: args.host.clone(),
            scenario: args.scenario.clone(),
            material: material.to_owned(),
            seed: args.seed,
            speed: args.speed,
            host_clock: args.host_clock,
            namespace: args.namespace.clone(),
            stay: args.stay,
            config: config.clone(),
            overrides: Vec::new(),
        };
        plan.overrides = plan.parameter_overrides(args)?;
        Ok(plan)
    }

    fn parameter_overrides(&self, args: &UpArgs) -> anyhow::Result<Vec<(&'static str, String, String)>> {
        // A JSON string is a YAML string: whatever a file is called.
        let quoted = |path: &std::path::Path| serde_json::json!(path.to_string_lossy()).to_string();
        let scenario = self.config.scenario_path(&self.scenario);
        let sensors = sensor_overrides(true).into_iter().map(|(name, value)| ("printer_sim", name, value));
        let mut all = vec![
            ("bag_recorder", "bag_dir".into(), quoted(&self.bag)),
            ("safety_supervisor", "start_mode".into(), args.mode.clone()),
            ("safety_supervisor", "latch_file".into(), quoted(&records::latch(&self.logs()))),
            ("mpc_controller", "control".into(), format!("\"{}\"", self.control)),
            ("mpc_controller", "advance.source".into(), format!("\"{}\"", self.advance)),
            ("printer_sim", "run.gcode".into(), quoted(&self.gcode)),
            ("printer_sim", "run.scenario".into(), quoted(&scenario)),
            ("printer_sim", "run.seed".into(), self.seed.to_string()),
            ("printer_sim", "run.speed".into(), format!("{:?}", self.speed)),
            ("printer_sim", "run.host_clock".into(), self.host_clock.to_string()),
            ("printer_sim", "run.layers".into(), args.layers.unwrap_or(0).to_string()),
            ("printer_sim", "run.warm".into(), args.warm.to_string()),
            ("printer_sim", "run.material_set_points".into(), args.material.is_some().to_string()),
            ("printer_sim", "run.allow_fault_injection".into(), args.allow_fault_injection.to_string()),
            ("printer_sim", "run.config_file".into(), quoted(&self.config_text_file())),
            ("printer_sim", "simulator.host".into(), self.host.clone()),
        ];
        all.extend(sensors);
        if args.with.iter().any(|sensor| sensor == "nozzle") {
            all.push(("printer_sim", "simulator.nozzle_sensor".into(), true.to_string()));
            all.push(("thermistor", "nozzle_fitted".into(), true.to_string()));
        }
        let models = self.config.model_overrides("defect_classifier", &self.material)?.into_iter();
        all.extend(models.map(|(name, value)| ("defect_classifier", name, value)));
        let foresight = self.config.foresight_overrides(&self.material)?.into_iter();
        all.extend(foresight.map(|(name, value)| (FORESIGHT, name, value)));
        Ok(all)
    }

    /// Folder of the nodes' messages, beside the bag.
    #[must_use]
    pub fn logs(&self) -> PathBuf {
        let mut name = self.bag.file_name().unwrap_or_default().to_os_string();
        name.push("_logs");
        self.bag.with_file_name(name)
    }

    fn config_text_file(&self) -> PathBuf {
        self.logs().join("config.txt")
    }

    /// Parses the parameters of every node, so that a mistake is told before anything runs.
    ///
    /// # Errors
    /// File, line, field, value and range of what is refused.
    pub fn check(&self) -> anyhow::Result<()> {
        const NOMINAL: [&str; 2] = ["printer", "material"];
        self.config.check_names(&self.material, &self.host)?;
        self.config.check_machine_budget(&self.material)?;
        self.config.check_cameras(&self.material)?;
        for (name, _, parameters, _) in self.nodes()? {
            match name {
                "thermistor" => _ = parameters.parse::<thermistor::params::Params>()?,
                "imu" => _ = parameters.parse::<imu::Params>()?,
                "camera" => _ = parameters.parse::<camera::Params>()?,
                "defect_classifier" => _ = self.config.sight(&self.material)?,
                FORESIGHT => _ = self.config.foresight(&self.material)?,
                "filament_encoder" => _ = parameters.parse::<filament_encoder::params::Params>()?,
                "state_estimator" => _ = parameters.without(&NOMINAL).parse::<state_estimator::Params>()?,
                "mpc_controller" => _ = parameters.without(&NOMINAL).parse::<mpc_controller::Params>()?,
                "safety_supervisor" => {
                    _ = parameters.without(&["latch_file"]).parse::<safety_supervisor::Params>()?;
                }
                "printer_sim" => {
                    _ = printer_sim::load::simulator_params(&parameters, &parameters.block("material")?)?;
                    _ = parameters.block::<printer_sim::run_params::RunParams>("run")?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// What would be started: name, program and arguments of each process.
    ///
    /// # Errors
    /// As [`Plan::recipes`].
    pub fn processes(&self) -> anyhow::Result<serde_json::Value> {
        let (recipes, _) = self.compose()?;
        let process = |recipe: &Recipe| serde_json::json!({"node": recipe.name, "program": recipe.program, "arguments": recipe.arguments});
        Ok(recipes.iter().map(process).collect())
    }

    /// The nodes to start; writes the configuration of the whole graph for the record, and removes what the supervisor of a
    /// former print with this bag remembered: that print and its printer are gone, and nothing waits for a person.
    ///
    /// # Errors
    /// File, line, field, value and range of what is refused; executables that are missing; a record that stays.
    pub fn recipes(&self) -> anyhow::Result<Vec<Recipe>> {
        let (recipes, text) = self.compose()?;
        std::fs::create_dir_all(self.logs()).with_context(|| self.logs().display().to_string())?;
        records::forget(&self.logs())?;
        std::fs::write(self.config_text_file(), text)?;
        Ok(recipes)
    }

    /// The nodes to start, and the configuration of all as text.
    fn compose(&self) -> anyhow::Result<(Vec<Recipe>, String)> {
        let mut recipes = Vec::new();
        let mut text = String::new();
        for (name, program, parameters, (files, overrides)) in self.nodes()? {
            programs::built(&program)?;
            text.push_str(&format!("# {name} {}\n{}\n", parameters.sha256(), parameters.text()));
            let mut arguments: Vec<String> =
                ["--ros-args", "--log-level", "info", "-r", &format!("__ns:={}", self.namespace)]
                    .map(str::to_owned)
                    .to_vec();
            if self.namespace != DEFAULT_NAMESPACE {
                // The time of one simulated printer is not that of another in the same domain.
                arguments.extend(["-r".to_owned(), format!("/clock:={}", clock_of(&self.namespace))]);
            }
            for file in files {
                arguments.extend(["--params-file".to_owned(), file.display().to_string()]);
            }
            for (key, value) in overrides {
                arguments.extend(["-p".to_owned(), format!("{key}:={value}")]);
            }
            // A printer that was started again would begin its file anew.
            recipes.push(Recipe { name, program, arguments, replaceable: name != "printer_sim" });
        }
        Ok((recipes, text))
    }

    /// Every node with its executable, its merged parameters, and what they are merged from.
    #[allow(clippy::type_complexity, reason = "used in the two functions above alone")]
    fn nodes(
        &self,
    ) -> anyhow::Result<Vec<(&'static str, PathBuf, Parameters, (Vec<PathBuf>, Vec<(String, String)>))>> {
        let mut nodes = Vec::new();
        for name in NODES.into_iter().filter(|name| *name != FORESIGHT || self.advance == "predicted") {
            let program = programs::beside(name)?;
            let files = self.config.files_of(name, &self.material);
            let overrides: Vec<(String, String)> = self
                .overrides
                .iter()
                .filter(|(node, ..)| *node == name)
                .map(|(_, key, value)| (key.clone(), value.clone()))
                .chain(
                    (name != "printer_sim" && !self.host_clock)
                        .then(|| ("use_sim_time".to_owned(), "true".to_owned())),
                )
                .collect();
            let path = NodePath {
                qualified: format!("{}/{name}", self.namespace.trim_end_matches('/')),
                base: name.to_owned(),
            };
            let parameters = Parameters::read(&files, &overrides, &path)?;
            nodes.push((name, program, parameters, (files, overrides)));
        }
        Ok(nodes)
    }
}

/// `bags/<file>-<seconds since 1970>-<control>`: sorts by time, never the same twice.
fn default_bag(args: &UpArgs, control: &str) -> PathBuf {
    let stem = args.gcode.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    PathBuf::from("bags").join(format!("{stem}-{}-{control}", now.as_secs()))
}
