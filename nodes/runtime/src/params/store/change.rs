//! Changes of parameters, and why they are refused.

use super::super::tree::{Origin, Tree};
use super::super::values::{from_ros, kind_name, text, to_ros};
use super::{Changed, OWN, ParamFileError, Parameters, Policy, View};
use crate::args::short;
use fdm_loop_msgs::{Parameter, ParameterValue};
use serde_json::Value;

/// So many of the values that were asked for together are named.
const NAMED: usize = 3;

impl View<'_> {
    /// The parameters with these set and the changes, or why they cannot be set: what is wrong comes before what is not
    /// allowed.
    pub(super) fn changed(
        &self,
        wanted: &[Parameter],
        policy: Policy,
    ) -> Result<(Parameters, Vec<Changed>), String> {
        let mut parameters = self.0.parameters.clone();
        let mut changes = Vec::new();
        for (place, Parameter { name, value }) in wanted.iter().enumerate() {
            if wanted[..place].iter().any(|earlier| earlier.name == *name) {
                // The first would be told as a change, and never hold.
                return Err(format!("{}: is asked to be set twice at once", short(name)));
            }
            let Some(before) = self.value(name) else {
                return Err(format!("{}: there is no such parameter", short(name)));
            };
            let bounds = &self.0.parameters.descriptions.of(name).bounds;
            let Some(asked) = from_ros(value) else {
                return Err(bounds.refusal(name, &text(value), "must be set, and finite"));
            };
            let (is, was) = (to_ros(&asked).kind, to_ros(&before).kind);
            let numbers = |kind| matches!(kind, ParameterValue::INTEGER | ParameterValue::DOUBLE);
            if is != was && !(numbers(is) && numbers(was)) {
                let rule = format!("is a {}, and must be a {}", kind_name(is), kind_name(was));
                return Err(bounds.refusal(name, &asked.to_string(), &rule));
            }
            if OWN.contains(&name.as_str()) {
                return Err(self
                    .read_only(name, policy)
                    .map_or_else(String::new, |why| bounds.refusal(name, &text(value), &why)));
            }
            // A double stays one, also where a whole number is asked for.
            let after =
                if was == ParameterValue::DOUBLE { asked.as_f64().map_or(asked, Value::from) } else { asked };
            parameters.tree.set(name, Tree::Leaf(after.clone()), Origin::Request);
            let parameter = Parameter { name: name.clone(), value: to_ros(&after) };
            changes.push(Changed { parameter, before, after });
        }
        if let Some(check) = &self.0.check {
            check(&parameters).map_err(|error| self.blame(wanted, &error))?;
        }
        for Parameter { name, value } in wanted {
            if let Some(why) = self.read_only(name, policy) {
                let bounds = &self.0.parameters.descriptions.of(name).bounds;
                return Err(bounds.refusal(name, &text(value), &why));
            }
        }
        // What stands beside a value in its file goes on to describe it.
        for Changed { parameter: Parameter { name, .. }, after, .. } in &changes {
            if let Some(place) = self.0.parameters.tree.origin(name) {
                parameters.tree.set(name, Tree::Leaf(after.clone()), place.clone());
            }
        }
        changes.retain(|change| change.before != change.after);
        Ok((parameters, changes))
    }

    /// Why what was asked for is refused: it begins with what was asked for, also where the check names a neighbour.
    fn blame(&self, wanted: &[Parameter], error: &ParamFileError) -> String {
        let names = |said: &str, name: &str| {
            said.strip_prefix(name).is_some_and(|rest| rest.starts_with([' ', ':', '[']))
        };
        match error {
            ParamFileError::Refused { message, .. } if wanted.iter().any(|one| names(message, &one.name)) => {
                message.clone()
            }
            _ => {
                let bounds = |name: &str| &self.0.parameters.descriptions.of(name).bounds;
                let asked = |one: &Parameter| {
                    bounds(&one.name).refusal(&one.name, &text(&one.value), "does not go with the others")
                };
                let all = wanted.iter().take(NAMED).map(asked).collect::<Vec<_>>();
                format!("{}: {error}", all.join(", "))
            }
        }
    }

    /// Why a parameter cannot be changed now.
    pub(super) fn read_only(&self, name: &str, policy: Policy) -> Option<String> {
        let origin = self.0.parameters.tree.origin(name);
        let place = origin.map_or_else(|| "the node's arguments".to_owned(), ToString::to_string);
        if OWN.contains(&name) || policy == Policy::Nothing {
            return Some(format!("read-only while the node runs: change {place} and start it again"));
        }
        match policy {
            Policy::Declared if !self.0.declared.contains(&name) => Some(
                "read-only while the node is active: deactivate it, set it, activate it again".to_owned(),
            ),
            Policy::UnderWay => {
                Some("the node is on its way from one state to another: ask again".to_owned())
            }
            _ => None,
        }
    }
}
