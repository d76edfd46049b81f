//! The parameters of a running node: what the six services of ROS 2 say of them.
//!
//! A node takes its parameters when it starts; while it runs they are read-only. What is asked for is checked all the
//! same, by the node's own struct, so that a wrong value is refused with its allowed range, and a right one with the
//! place where to change it.

use super::comments::range;
use super::tree::{Origin, Tree};
use super::values::{from_ros, kind_name, to_ros};
use super::{ParamFileError, Parameters, USE_SIM_TIME};
use fdm_loop_msgs::{
    FloatingPointRange, IntegerRange, ListParametersResult, Parameter, ParameterDescriptor, ParameterValue,
    SetParametersResult,
};
use serde_json::Value;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};

/// Parses parameters as the node does.
type Check = Box<dyn Fn(&Parameters) -> Result<(), ParamFileError> + Send>;

/// The check of a node, once it has told it; clones share it.
#[derive(Clone, Default)]
pub(crate) struct Checked(Arc<Mutex<Option<Check>>>);

impl Checked {
    /// The node parses its parameters like this.
    pub(crate) fn tell(&self, check: impl Fn(&Parameters) -> Result<(), ParamFileError> + Send + 'static) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(check));
    }

    fn check(&self, parameters: &Parameters) -> Result<(), ParamFileError> {
        let check = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        check.as_ref().map_or(Ok(()), |check| check(parameters))
    }
}

/// The parameters in force.
pub(crate) struct Store {
    parameters: Parameters,
    check: Checked,
}

impl Store {
    pub(crate) fn new(parameters: Parameters, check: Checked) -> Self {
        Self { parameters, check }
    }

    /// Every parameter with its value.
    pub(crate) fn all(&self) -> Vec<Parameter> {
        let names = self.names();
        let values = self.get(&names);
        names.into_iter().zip(values).map(|(name, value)| Parameter { name, value }).collect()
    }

    /// Names below any of `prefixes` (none: all), at most `depth` levels of blocks down (0: all), and their blocks.
    pub(crate) fn list(&self, prefixes: &[String], depth: u64) -> ListParametersResult {
        let levels = |name: &str| name.matches('.').count() as u64;
        let is_asked = |name: &String| {
            let shallow = |below: &str| depth == 0 || levels(below) < depth;
            let below = |prefix: &String| {
                name == prefix
                    || name.strip_prefix(prefix).and_then(|rest| rest.strip_prefix('.')).is_some_and(shallow)
            };
            if prefixes.is_empty() { shallow(name) } else { prefixes.iter().any(below) }
        };
        let names: Vec<String> = self.names().into_iter().filter(is_asked).collect();
        let blocks: BTreeSet<String> = names
            .iter()
            .filter_map(|name| name.rsplit_once('.'))
            .map(|(block, _)| block.to_owned())
            .collect();
        ListParametersResult { names, prefixes: blocks.into_iter().collect() }
    }

    /// Values in the order asked; not set for what is not there.
    pub(crate) fn get(&self, names: &[String]) -> Vec<ParameterValue> {
        names.iter().map(|name| self.value(name).map(|value| to_ros(&value)).unwrap_or_default()).collect()
    }

    /// What is known of each, from the comment beside it.
    pub(crate) fn describe(&self, names: &[String]) -> Vec<ParameterDescriptor> {
        names.iter().map(|name| self.descriptor(name)).collect()
    }

    /// Whether these could be set together. They cannot while the node runs; what else is wrong comes first.
    pub(crate) fn set(&self, wanted: &[Parameter]) -> SetParametersResult {
        match self.refusal(wanted) {
            None => SetParametersResult { successful: true, reason: String::new() },
            Some(reason) => SetParametersResult { successful: false, reason },
        }
    }

    fn refusal(&self, wanted: &[Parameter]) -> Option<String> {
        let mut changed = self.parameters.clone();
        for Parameter { name, value } in wanted {
            let Some(known) = self.value(name) else {
                return Some(format!("{name}: there is no such parameter"));
            };
            let Some(new) = from_ros(value) else {
                return Some(format!("{name}: must be set, and finite"));
            };
            let (is, was) = (to_ros(&new).kind, to_ros(&known).kind);
            let numbers = |kind| matches!(kind, ParameterValue::INTEGER | ParameterValue::DOUBLE);
            if is != was && !(numbers(is) && numbers(was)) {
                let (was, is) = (kind_name(was), kind_name(is));
                return Some(format!("{name}: is a {was}, and {new} is a {is}"));
            }
            changed.tree.set(name, Tree::Leaf(new), Origin::Request);
        }
        if let Err(error) = self.check.check(&changed) {
            return Some(error.to_string());
        }
        let first = wanted.first()?;
        Some(format!("{}: {}", first.name, self.read_only(&first.name)))
    }

    fn read_only(&self, name: &str) -> String {
        let place = self
            .parameters
            .tree
            .origin(name)
            .map_or_else(|| "the node's arguments".to_owned(), ToString::to_string);
        format!("read-only while the node runs: change {place} and start it again")
    }

    fn descriptor(&self, name: &str) -> ParameterDescriptor {
        let Some(value) = self.value(name) else {
            let description = "there is no such parameter".to_owned();
            return ParameterDescriptor { name: name.to_owned(), description, ..Default::default() };
        };
        let comment = match self.parameters.tree.origin(name) {
            Some(Origin::File(file, line)) => self.parameters.comments.of(file, *line).unwrap_or_default(),
            _ => "",
        };
        let kind = to_ros(&value).kind;
        let bounds = range(comment).filter(|_| value.is_number());
        let mut descriptor = ParameterDescriptor {
            name: name.to_owned(),
            kind,
            description: comment.to_owned(),
            additional_constraints: self.read_only(name),
            read_only: true,
            ..Default::default()
        };
        if let Some((from, to)) = bounds {
            if kind == ParameterValue::INTEGER {
                #[expect(clippy::cast_possible_truncation, reason = "a float's cast saturates")]
                let (from_value, to_value) = (from.ceil() as i64, to.floor() as i64);
                descriptor.integer_range.push(IntegerRange { from_value, to_value, step: 0 });
            } else {
                let range = FloatingPointRange { from_value: from, to_value: to, step: 0.0 };
                descriptor.floating_point_range.push(range);
            }
        }
        descriptor
    }

    fn names(&self) -> Vec<String> {
        let mut names = self.parameters.tree.leaves();
        names.push(USE_SIM_TIME.to_owned());
        names.sort();
        names
    }

    fn value(&self, name: &str) -> Option<Value> {
        if name == USE_SIM_TIME {
            return Some(Value::from(self.parameters.use_sim_time));
        }
        match self.parameters.tree.get(name)?.0 {
            Tree::Leaf(value) => Some(value.clone()),
            Tree::Block(_) | Tree::NotFinite => None,
        }
    }
}

#[cfg(test)]
mod tests;
