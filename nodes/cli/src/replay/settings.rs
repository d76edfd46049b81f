//! The parameters with which a bag was recorded, and those that are set instead.

use super::recorded::Recorded;
use super::set::Set;
use crate::config::{ConfigDir, Foresight, Sight};
use anyhow::anyhow;
use models::material::Material;
use models::printer::Printer;
use runtime::params::{NodePath, ParamFileError, Parameters};
use std::collections::{BTreeMap, BTreeSet};

/// Nodes with a brain that is replayed.
pub(crate) const BRAINS: [&str; 5] =
    ["state_estimator", "mpc_controller", "safety_supervisor", "defect_classifier", "advance_predictor"];
/// Blocks that belong to printer and material.
const NOMINAL: [&str; 2] = ["printer", "material"];

/// Names by which commands of two runs are told apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Sessions {
    pub(crate) controller: u64,
    pub(crate) supervisor: u64,
}

/// Parameters that no file has: whoever starts a node gives them.
const GIVEN: [&str; 1] = ["latch_file"];

/// What record and build do not share of a node's parameters.
#[derive(Debug, Default)]
struct Unlike {
    /// Names and shipped values of what the record does not say.
    lacking: Vec<String>,
    /// Names that this build does not know.
    unknown: Vec<String>,
}

/// The printer and the material that a brain believes in; each has its own, as its node has.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Nominal {
    pub(crate) printer: Printer,
    pub(crate) material: Material,
}

impl Nominal {
    fn of(parameters: &Parameters) -> Result<Self, ParamFileError> {
        Ok(Self { printer: parameters.block("printer")?, material: parameters.block("material")? })
    }
}

/// Parameters of every brain.
#[derive(Debug, Clone)]
pub(crate) struct Settings {
    pub(crate) estimator: state_estimator::Params,
    pub(crate) controller: mpc_controller::Params,
    pub(crate) supervisor: safety_supervisor::Params,
    /// What the estimator and the controller believe of printer and material.
    pub(crate) estimated: Nominal,
    pub(crate) controlled: Nominal,
    pub(crate) sight: Option<Sight>,
    pub(crate) foresight: Option<Foresight>,
    pub(crate) sessions: Sessions,
}

/// Where parameters come from.
pub(crate) struct Source<'a> {
    pub(crate) config: &'a ConfigDir,
    pub(crate) recorded: &'a Recorded,
    /// Material for nodes of which the bag says nothing.
    pub(crate) material: &'a str,
    /// Whether frames are judged, and turns foretold.
    pub(crate) frames: bool,
    pub(crate) predictions: bool,
    pub(crate) sessions: Sessions,
}

impl Source<'_> {
    /// Parameters of all brains with `sets` in place of what was recorded.
    pub(crate) fn settings(&self, sets: &[Set]) -> anyhow::Result<Settings> {
        let estimator = self.parameters("state_estimator", sets)?;
        let controller = self.parameters("mpc_controller", sets)?;
        let supervisor = self.parameters("safety_supervisor", sets)?.without(&["latch_file"]);
        let refuse = |node| move |error: ParamFileError| refused(node, sets, &error);
        Ok(Settings {
            estimated: Nominal::of(&estimator).map_err(refuse("state_estimator"))?,
            controlled: Nominal::of(&controller).map_err(refuse("mpc_controller"))?,
            estimator: estimator.without(&NOMINAL).parse().map_err(refuse("state_estimator"))?,
            controller: controller
                .without(&NOMINAL)
                .parse::<mpc_controller::Params>()
                .map_err(refuse("mpc_controller"))?
                .in_virtual_time(),
            supervisor: supervisor.parse().map_err(refuse("safety_supervisor"))?,
            sight: self.frames.then(|| self.sight(sets)).transpose()?,
            foresight: self.predictions.then(|| self.foresight(sets)).transpose()?,
            sessions: self.sessions,
        })
    }

    fn sight(&self, sets: &[Set]) -> anyhow::Result<Sight> {
        let node = "defect_classifier";
        let read = self.config.sight_of(&self.parameters(node, sets)?);
        read.map_err(|error| told(node, sets, error))
    }

    fn foresight(&self, sets: &[Set]) -> anyhow::Result<Foresight> {
        let node = "advance_predictor";
        let read = self.config.foresight_of(&self.parameters(node, sets)?);
        read.map_err(|error| told(node, sets, error))
    }

    fn parameters(&self, node: &'static str, sets: &[Set]) -> anyhow::Result<Parameters> {
        // The record of another build may lack what this one asks for, and know what it does not.
        let files = self.config.files_of(node, self.material);
        let unknown = self.unlike(node)?.unknown;
        let recorded = self.recorded.of(node).into_iter().flatten();
        let mut values: Vec<_> = recorded.filter(|(name, _)| !unknown.contains(name)).cloned().collect();
        let networks = match node {
            "defect_classifier" => self.config.model_overrides(node, self.material)?,
            "advance_predictor" => self.config.foresight_overrides(self.material)?,
            _ => Vec::new(),
        };
        // Networks of another machine stand elsewhere: those of this build's configuration take their place.
        let known: BTreeSet<String> = values.iter().map(|(name, _)| name.clone()).collect();
        let usable = |name: &str| {
            values.iter().any(|(known, value)| known == name && is_there(value)) && known.contains(name)
        };
        let missing: Vec<_> = networks.into_iter().filter(|(name, _)| !usable(name)).collect();
        values
            .extend(missing.into_iter().filter(|(name, _)| name != "polymer" || !known.contains("polymer")));
        for set in sets.iter().filter(|set| set.node == node) {
            values.push((set.name.clone(), set.value.clone()));
        }
        let path = NodePath { qualified: format!("/printer/{node}"), base: node.to_owned() };
        Parameters::read(&files, &values, &path).map_err(|error| refused(node, sets, &error))
    }

    /// What this build asks of a node and the record does not say, and the other way round; nothing of a node that the
    /// record does not know at all.
    fn unlike(&self, node: &str) -> anyhow::Result<Unlike> {
        let Some(recorded) = self.recorded.of(node) else { return Ok(Unlike::default()) };
        let path = NodePath { qualified: format!("/printer/{node}"), base: node.to_owned() };
        let shipped = Parameters::read(&self.config.files_of(node, self.material), &[], &path)?.text();
        let shipped: BTreeMap<&str, &str> =
            shipped.lines().filter_map(|line| line.split_once(": ")).collect();
        let is_said = |name: &str| recorded.iter().any(|(known, _)| known == name);
        let is_known = |name: &str| shipped.contains_key(name) || GIVEN.contains(&name);
        Ok(Unlike {
            lacking: shipped
                .iter()
                .filter(|(name, _)| !is_said(name))
                .map(|(name, value)| format!("{name} = {value}"))
                .collect(),
            unknown: recorded.iter().map(|(name, _)| name.clone()).filter(|name| !is_known(name)).collect(),
        })
    }

    /// One line for each parameter by which the record shows that it is another build's.
    pub(crate) fn other_build(&self) -> anyhow::Result<Vec<String>> {
        let mut lines = Vec::new();
        for node in BRAINS {
            let Unlike { lacking, unknown } = self.unlike(node)?;
            lines.extend(
                lacking.iter().map(|value| format!("{node}.{value} as shipped: the record lacks it")),
            );
            lines.extend(
                unknown
                    .iter()
                    .map(|name| format!("{node}.{name} is left out: this build has no such parameter")),
            );
        }
        Ok(lines)
    }
}

/// One line on what was refused: what was typed, or that the record does not fit this build.
fn refused(node: &str, sets: &[Set], error: &ParamFileError) -> anyhow::Error {
    let text = error.to_string();
    let typed = sets
        .iter()
        .find(|set| set.node == node && text.starts_with(&format!("-p {}:={}", set.name, set.value)));
    match (typed, text.split_once(": ")) {
        (Some(set), Some((_, rule))) => anyhow!("--set {node}.{}={}: {rule}", set.name, set.value),
        _ => anyhow!("parameters of {node} in the record, as this build reads them: {text}"),
    }
}

fn told(node: &str, sets: &[Set], error: anyhow::Error) -> anyhow::Error {
    match error.downcast::<ParamFileError>() {
        Ok(error) => refused(node, sets, &error),
        Err(error) => error,
    }
}

/// Whether a recorded value names a file of this machine.
fn is_there(value: &str) -> bool {
    std::path::Path::new(value.trim_matches('"')).is_file()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bag outlives a build that asks for more, and one that asks for less; both are told.
    #[test]
    fn the_record_of_another_build_is_read_and_told() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config");
        let config = ConfigDir::find(Some(&root)).unwrap();
        let mut text = String::new();
        for node in &BRAINS[..3] {
            let path = NodePath { qualified: format!("/printer/{node}"), base: (*node).to_owned() };
            let all = Parameters::read(&config.files_of(node, "PLA"), &[], &path).unwrap().text();
            text.push_str(&format!("# {node} 0f\n{all}"));
        }
        let read = |text: &str| {
            let recorded = &Recorded::parse(text);
            let sessions = Sessions::default();
            let source = Source {
                config: &config,
                recorded,
                material: "PLA",
                frames: false,
                predictions: false,
                sessions,
            };
            (source.settings(&[]).map(drop), source.other_build().unwrap())
        };
        assert_eq!(read(&text).1, Vec::<String>::new());
        let older = text.replace("bed_heater.usual_noise_k: 0.15\n", "bed_heater.usual_w: 3.0\n");
        let (settings, told) = read(&older);
        settings.unwrap();
        assert_eq!(
            told,
            [
                "safety_supervisor.bed_heater.usual_noise_k = 0.15 as shipped: the record lacks it",
                "safety_supervisor.bed_heater.usual_w is left out: this build has no such parameter"
            ]
        );
    }

    /// The controller has a printer and a material of its own, as its node has: either is set alone.
    #[test]
    fn what_is_set_of_printer_and_material_reaches_the_brain_that_it_is_set_of() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config");
        let config = &ConfigDir::find(Some(&root)).unwrap();
        let recorded = &Recorded::default();
        let (material, sessions) = ("PLA", Sessions::default());
        let source = Source { config, recorded, material, frames: false, predictions: false, sessions };
        let set = |text: &str| source.settings(&[Set::parse(text).unwrap()]);
        let shipped = source.settings(&[]).unwrap();
        let lag = set("mpc_controller.material.lag_s=0.7").unwrap();
        assert!((lag.controlled.material.lag_s - 0.7).abs() < 1e-12 && lag.estimated == shipped.estimated);
        let force = set("state_estimator.printer.extruder.force_max_n=70.0").unwrap();
        assert!((force.estimated.printer.extruder.force_max_n - 70.0).abs() < 1e-12);
        assert_eq!(force.controlled, shipped.controlled);
        let refused = set("mpc_controller.material.lag_s=0.0").unwrap_err().to_string();
        assert!(refused.starts_with("--set mpc_controller.material.lag_s=0.0: "), "{refused}");
    }
}
