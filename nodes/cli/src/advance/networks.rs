//! The networks that a command asks: those of the configuration folder, or of another one; what their answers mean.

use super::Printed;
use super::Setup;
use crate::config::ConfigDir;
use crate::output;
use advance_predictor::compensation::{Ensemble, Outside, Predictor, Source};
use anyhow::{Context, bail};
use models::advance::{Condition, DriveKind};
use serde::Serialize;
use std::path::Path;

/// Which networks a command asked.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Networks {
    /// Their file.
    pub file: String,
    /// What they were trained with, as the file says.
    pub trained: String,
}

impl Networks {
    /// For people.
    pub(super) fn text(&self) -> String {
        format!("{} ({})", self.file, self.trained)
    }
}

/// What an interval about a foretold K is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum IntervalOf {
    /// It holds the best K of 95 % of virtual test lines. What a real printer needs was never compared.
    VirtualTestLine,
    /// The same of virtual lines scaled to a person's own, and it holds 95 % of the own ones too.
    VirtualAndMeasured,
    /// `bounds.physics_doubt` of the physical model's answer: an assumption.
    AssumedDoubt,
}

impl IntervalOf {
    /// What the interval of an answer of these networks is of.
    pub(super) fn of(source: Source, networks: &Ensemble) -> Self {
        Self::label(source, networks.measured())
    }

    fn label(source: Source, measured: usize) -> Self {
        match source {
            Source::Network if measured > 0 => Self::VirtualAndMeasured,
            Source::Network => Self::VirtualTestLine,
            Source::Physics => Self::AssumedDoubt,
        }
    }

    /// For people.
    pub(super) fn text(self) -> &'static str {
        match self {
            Self::VirtualTestLine => "95 % of virtual test lines; no printer was involved",
            Self::VirtualAndMeasured => "95 % of virtual test lines scaled to measured ones, and of those",
            Self::AssumedDoubt => "an assumption",
        }
    }
}

/// What of a condition lies outside of the networks' data, each with the data's range; empty where they answer.
pub(super) fn outside(networks: &Ensemble, polymer: &str, at: &Condition) -> Vec<String> {
    let Some(hull) = networks.hull(polymer) else {
        return vec![format!("polymer {polymer} is none of theirs")];
    };
    let told = |Outside { field, value, range: [low, high], unit }: Outside| {
        format!("{field} {value} {unit} is outside of {low} to {high} {unit}")
    };
    hull.outside(at).into_iter().map(told).collect()
}

/// Who answered, for people.
pub(super) fn answered(outside: &[String]) -> String {
    if outside.is_empty() {
        return "the networks, inside of their data".to_owned();
    }
    format!("the physical model, OUTSIDE of the networks' data: {}", outside.join(", "))
}

impl Printed {
    /// The predictor that is asked. Says so where the drive is not the printer's.
    ///
    /// # Errors
    /// A folder or a file that is not there, a file that is damaged or of the other drive.
    pub(super) fn predictor(
        &self,
        setup: &Setup,
        config: &ConfigDir,
    ) -> anyhow::Result<(Predictor, Networks)> {
        let drive: DriveKind = self.drive.into();
        let configured = setup.params.drive;
        if drive != configured {
            output::note(&format!(
                "--drive {}: the printer of {} has a {} drive",
                drive.name(),
                config.file("advance_predictor.param.yaml").display(),
                configured.name()
            ));
        }
        if let Some(folder) = self.models.as_deref().filter(|folder| !folder.is_dir()) {
            bail!("--models {}: no such folder", folder.display());
        }
        let folder = self.models.clone().unwrap_or_else(|| config.file("models"));
        read(setup, &folder, drive)
    }
}

/// The predictor with the networks of a folder.
pub(super) fn read(setup: &Setup, folder: &Path, drive: DriveKind) -> anyhow::Result<(Predictor, Networks)> {
    let path = folder.join(format!("advance_{}.json", drive.name()));
    let told = || path.display().to_string();
    let text = runtime::input::text(&path).with_context(told)?;
    let ensemble = Ensemble::parse(&text, drive).with_context(told)?;
    let networks = Networks { file: told(), trained: ensemble.trained().to_owned() };
    let predictor =
        Predictor::new(setup.physics.clone(), setup.params.bounds, ensemble).with_context(told)?;
    Ok((predictor, networks))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{folder, setup};
    use super::*;
    use crate::advance::DriveName;

    fn printed(drive: DriveName, models: Option<&Path>) -> Printed {
        let models = models.map(Path::to_path_buf);
        Printed { drive, polymer: "pla".to_owned(), config: None, models, json: None }
    }

    #[test]
    fn a_folder_that_is_not_there_is_refused_by_name() {
        let (config, setup) = setup();
        let nowhere = printed(DriveName::Bowden, Some(Path::new("/nowhere/networks")));
        let error = nowhere.predictor(&setup, &config).unwrap_err().to_string();
        assert_eq!(error, "--models /nowhere/networks: no such folder");
    }

    /// A file that own lines had a part in says so in each answer.
    #[test]
    fn own_lines_are_in_the_label_of_the_interval() {
        let (config, _) = setup();
        let file = config.file("models/advance_bowden.json");
        let shipped = Ensemble::parse(&std::fs::read_to_string(file).unwrap(), DriveKind::Bowden).unwrap();
        assert_eq!(IntervalOf::of(Source::Network, &shipped), IntervalOf::VirtualTestLine);
        let of = |source| IntervalOf::label(source, 4);
        assert_eq!(of(Source::Network), IntervalOf::VirtualAndMeasured);
        assert_eq!(of(Source::Physics), IntervalOf::AssumedDoubt);
        assert!(!of(Source::Network).text().contains("no printer"));
    }

    /// The answer names its file, wherever that lies; one under the other drive's name is refused.
    #[test]
    fn other_networks_are_told_by_their_file() {
        let (config, setup) = setup();
        let folder = folder("networks");
        let shipped = config.file("models/advance_bowden.json");
        for drive in DriveKind::ALL {
            std::fs::copy(&shipped, folder.join(format!("advance_{}.json", drive.name()))).unwrap();
        }
        let (_, networks) = printed(DriveName::Bowden, Some(&folder)).predictor(&setup, &config).unwrap();
        assert_eq!(networks.file, folder.join("advance_bowden.json").display().to_string());
        assert!(networks.trained.starts_with("fdm advance train: 1476 virtual"), "{networks:?}");
        let error = printed(DriveName::Direct, Some(&folder)).predictor(&setup, &config).unwrap_err();
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(format!("{error:#}").ends_with("drive is bowden, must be direct"), "{error:#}");
    }
}
