//! Where a limit comes from.

use super::FaultSpec;
use anyhow::bail;
use serde::{Deserialize, Serialize};

/// Who says how long a reaction may take.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LimitSource {
    /// The catalogue of the design: this number for this fault.
    Catalogue,
    /// Its number of another kind, an age or a count, and the time that it takes to see it and to act.
    Derived,
    /// This file's own, below the design's.
    Stricter,
    /// This file's own: the design has none for this way to bring the fault about, or one that holds elsewhere.
    Own,
}

impl LimitSource {
    /// Names in files and figures, for people.
    const NAMES: &str = "catalogue, derived, stricter, own";

    /// Name in files and figures.
    fn name(self) -> &'static str {
        match self {
            Self::Catalogue => "catalogue",
            Self::Derived => "derived",
            Self::Stricter => "stricter",
            Self::Own => "own",
        }
    }

    /// For people.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Catalogue => "from the catalogue of the design",
            Self::Derived => "derived from the catalogue of the design",
            Self::Stricter => "own, stricter than the design's",
            Self::Own => "own",
        }
    }
}

/// Refuses a limit of which nobody could tell where it comes from, and a source of nothing.
pub(super) fn check(fault: &FaultSpec) -> anyhow::Result<()> {
    let trials = fault.trials.iter().map(|trial| {
        let limited = trial.limit_s.is_some() || trial.limit_layers.is_some();
        (&trial.name, limited, trial.source)
    });
    let process = fault.process.iter().map(|trial| {
        let limited = trial.limit_s.is_some() || !trial.bounds.is_empty();
        (&trial.name, limited, trial.source)
    });
    let mut limited_at_all = fault.limit.is_some();
    for trial in fault.process.iter().filter(|trial| trial.told_s.is_some()) {
        limited_at_all = true;
        if fault.source.is_none() {
            bail!("{}, trial '{}': told_s has the source of its ID, which has none", fault.id, trial.name);
        }
    }
    for (name, limited, source) in trials.chain(process) {
        limited_at_all |= limited;
        if limited && source.or(fault.source).is_none() {
            bail!(
                "{}, trial '{name}': a limit without source, which can be {}",
                fault.id,
                LimitSource::NAMES
            );
        }
        if let Some(source) = source.filter(|_| !limited) {
            bail!("{}, trial '{name}': source = {}: there is no limit", fault.id, source.name());
        }
    }
    match fault.source {
        None if fault.limit.is_some() => {
            bail!("{}: limit without source, which can be {}", fault.id, LimitSource::NAMES)
        }
        Some(source) if !limited_at_all => {
            bail!("{}: source = {}: there is no limit", fault.id, source.name())
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    /// What is refused of an ID with one trial and these fields more, nothing where it is not.
    fn refused(of_id: &Value, of_trial: &Value) -> String {
        let with = |mut all: Value, more: &Value| {
            all.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
            all
        };
        let trial = json!({"name": "a", "job": "print", "onset": {"after": "start", "time_s": 1.0}});
        let fault =
            json!({"id": "P6", "fault": "slip", "reaction": "paused", "trials": [with(trial, of_trial)]});
        let fault: FaultSpec = serde_json::from_value(with(fault, of_id)).unwrap();
        check(&fault).map_or_else(|error| error.to_string(), |()| String::new())
    }

    /// Of an ID or of a trial, and of no trial that has none.
    #[test]
    fn every_limit_names_its_source_and_no_source_is_idle() {
        let kinds = "which can be catalogue, derived, stricter, own";
        let nothing = json!({});
        let limit_s = json!({"limit_s": 1.0});
        assert_eq!(refused(&nothing, &limit_s), format!("P6, trial 'a': a limit without source, {kinds}"));
        assert_eq!(
            refused(&json!({"limit": "soon"}), &nothing),
            format!("P6: limit without source, {kinds}")
        );
        let own = json!({"source": "own"});
        assert_eq!(refused(&own, &nothing), "P6: source = own: there is no limit");
        assert_eq!(refused(&nothing, &own), "P6, trial 'a': source = own: there is no limit");
        for (of_id, of_trial) in [
            (json!({"source": "catalogue"}), limit_s),
            (json!({}), json!({"limit_layers": 1, "source": "derived"})),
            (json!({"limit": "soon", "source": "stricter"}), json!({})),
            (json!({}), json!({})),
        ] {
            assert_eq!(refused(&of_id, &of_trial), "", "{of_id} {of_trial}");
        }
    }

    /// The name in messages is that in files.
    #[test]
    fn a_source_is_named_as_it_is_written() {
        for name in LimitSource::NAMES.split(", ") {
            let source: LimitSource = serde_json::from_value(Value::from(name)).unwrap();
            assert_eq!(source.name(), name);
        }
    }
}
