//! Parameters that are set instead of the recorded ones.

use super::settings::BRAINS;
use anyhow::bail;

/// A parameter that is set instead of the recorded one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Set {
    pub(crate) node: &'static str,
    pub(crate) name: String,
    pub(crate) value: String,
}

impl Set {
    /// Reads all that is set; a parameter is set once.
    pub(crate) fn parse_all(texts: &[String]) -> anyhow::Result<Vec<Self>> {
        let sets = texts.iter().map(|text| Self::parse(text)).collect::<anyhow::Result<Vec<_>>>()?;
        for (index, set) in sets.iter().enumerate() {
            let is_same = |other: &&Self| (other.node, &other.name) == (set.node, &set.name);
            if let Some(first) = sets[..index].iter().find(is_same) {
                let Self { node, name, value } = set;
                bail!(
                    "--set {node}.{name}={value}: is set to {} already; a parameter has one value",
                    first.value
                );
            }
        }
        Ok(sets)
    }

    /// Reads `node.param=value`.
    pub(crate) fn parse(text: &str) -> anyhow::Result<Self> {
        let parts = text
            .split_once('=')
            .and_then(|(path, value)| path.split_once('.').map(|(node, name)| (node, name, value)))
            .filter(|(_, name, value)| !name.is_empty() && !value.is_empty());
        let Some((node, name, value)) = parts else {
            let what = if text.ends_with('=') { "the value is missing" } else { "cannot be read" };
            bail!("--set {text}: {what}: must be node.parameter=value");
        };
        match BRAINS.iter().find(|brain| **brain == node) {
            Some(node) => Ok(Self { node, name: name.to_owned(), value: value.to_owned() }),
            None => bail!("--set {text}: no brain '{node}' is replayed; there are {}", BRAINS.join(", ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_set_is_refused_by_name() {
        let said = |text| Set::parse(text).unwrap_err().to_string();
        assert!(Set::parse("mpc_controller.trims.delay_s=0.2").is_ok());
        let form = "must be node.parameter=value";
        assert_eq!(said("mpc_controller=2"), format!("--set mpc_controller=2: cannot be read: {form}"));
        assert_eq!(
            said("mpc_controller.trims.delay_s="),
            format!("--set mpc_controller.trims.delay_s=: the value is missing: {form}")
        );
        assert!(
            said("thermistor.x=1").contains("no brain 'thermistor' is replayed; there are state_estimator")
        );
    }

    /// Which of the two was played nobody could tell.
    #[test]
    fn a_parameter_that_is_set_twice_is_refused() {
        let all = |texts: [&str; 2]| Set::parse_all(&texts.map(str::to_owned)).map(|sets| sets.len());
        let refused =
            all(["mpc_controller.material.lag_s=0.6", "mpc_controller.material.lag_s=0.7"]).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "--set mpc_controller.material.lag_s=0.7: is set to 0.6 already; a parameter has one value"
        );
        assert_eq!(
            all(["mpc_controller.material.lag_s=0.6", "state_estimator.material.lag_s=0.7"]).unwrap(),
            2
        );
    }
}
